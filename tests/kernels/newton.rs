//! The classical solver of bodies of revolution, where it can be trusted, against f64; and
//! where it cannot, as a record. `revolution_newton.glsl` says why it is kept.

use glam::{DVec2, DVec3};
use goblet::geometry::bezier::Curve;
use goblet::{Envelopes, RevolutionSolver};

use crate::fixture::{Fixture, Rng, UNBOUNDED, double, single};
use crate::generated::{HitSegments, INDEX_MASK, KIND_SHIFT, NONE, REVOLUTION, SegmentHit, SegmentRay};
use crate::support::work;
use crate::world::World;

/// Rays for each body. [`one_approximation_is_not_enough`] needs enough that one envelope alone makes an error.
fn count() -> usize {
    work(20_000, 100_000)
}

/// A profile of one segment whose unit space is its own: the widest radius and the largest
/// height are 1.
struct Body {
    name: &'static str,
    points: &'static [[f64; 2]],
}

const BODIES: [Body; 4] = [
    Body { name: "cylinder", points: &[[1.0, -1.0], [1.0, -0.4], [1.0, 0.3], [1.0, 1.0]] },
    Body { name: "cone", points: &[[1.0, -1.0], [0.75, -0.5], [0.5, 0.0], [0.25, 0.5], [0.0, 1.0]] },
    Body { name: "dome", points: &[[1.0, -1.0], [1.0, 0.1], [0.55, 1.0], [0.0, 1.0]] },
    Body { name: "egg", points: &[[0.0, -1.0], [1.0, -1.0], [1.0, 0.2], [0.5, 1.0], [0.0, 1.0]] },
];

impl Body {
    fn curve(&self) -> Curve {
        Curve { points: self.points.iter().map(|point| DVec2::from(*point)).collect() }
    }

    fn world(&self, envelopes: Envelopes) -> World {
        let numbers: Vec<String> = self.points.as_flattened().iter().map(f64::to_string).collect();
        let degree = self.points.len() - 1;
        let text = format!(
            "WorldBegin\nLightSource \"point\"\nShape \"revolution\" \"integer degree\" {degree} \"point2 P\" [{}]",
            numbers.join(" ")
        );
        World::parse_for(&text, RevolutionSolver::Newton { segments: 16, envelopes }).0
    }
}

fn hit_segments(world: &World, rays: &[SegmentRay]) -> Vec<SegmentHit> {
    let fixture = Fixture::new();
    let world = world.upload(&fixture);
    let (rays, hits) = (fixture.upload(rays), fixture.output(rays.len()));
    fixture.run(&HitSegments { scene: world.bindings(), rays: &rays, hits: &hits }, rays.len() as usize);
    fixture.read(&hits)
}

fn ray(origin: DVec3, direction: DVec3) -> SegmentRay {
    SegmentRay { origin: single(origin), segment: 0, direction: single(direction), t_max: UNBOUNDED }
}

/// A ray from outside to a point in the body's bounding cylinder, as a camera sends it,
/// steeper than 1 in 5.
fn primary(rng: &mut Rng) -> SegmentRay {
    loop {
        let origin = rng.direction() * rng.range(2.0, 10.0);
        let direction = (0.8 * rng.cube(1.0) - origin).normalize();
        if direction.z.abs() > 0.2 {
            return ray(origin, direction);
        }
    }
}

/// The profile at equal steps of its parameter.
struct Samples {
    curve: Curve,
    points: Vec<DVec2>,
}

const STEPS: usize = 256;

impl Samples {
    fn new(curve: Curve) -> Self {
        let points = (0..=STEPS).map(|i| curve.at(i as f64 / STEPS as f64)).collect();
        Self { curve, points }
    }

    /// The roots in f64 as (t, parameter), nearest first; `None` if one is near grazing or
    /// near an end.
    fn clear_roots(&self, ray: &SegmentRay) -> Option<Vec<(f64, f64)>> {
        let (o, d) = (double(ray.origin), double(ray.direction));
        let t = |point: DVec2| (point.y - o.z) / d.z;
        let outside = |point: DVec2| point.x - (o + t(point) * d).truncate().length();
        let values: Vec<f64> = self.points.iter().map(|point| outside(*point)).collect();
        let crosses = |i: usize| values[i].signum() != values[i + 1].signum();
        if (0..=STEPS).any(|i| values[i].abs() < 1e-3 && (i == 0 || i == STEPS || !(crosses(i - 1) || crosses(i)))) {
            return None;
        }
        let mut roots = Vec::new();
        for i in (0..STEPS).filter(|i| crosses(*i)) {
            let [mut low, mut high] = [i, i + 1].map(|i| i as f64 / STEPS as f64);
            for _ in 0..45 {
                let middle = 0.5 * (low + high);
                let same = outside(self.curve.at(middle)).signum() == values[i].signum();
                *(if same { &mut low } else { &mut high }) = middle;
            }
            roots.push((t(self.curve.at(low)), low));
        }
        roots.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some(roots)
    }
}

/// What became of rays whose roots are clear.
#[derive(Debug, Default)]
struct Outcome {
    rays: usize,
    /// The nearest root is not what was found.
    wrong: usize,
    /// Mean error of t where it is.
    error: f64,
}

impl Outcome {
    fn wrong_share(&self) -> f64 {
        self.wrong as f64 / self.rays as f64
    }
}

/// How far along the profile a hit is.
fn parameter(world: &World, hit: &SegmentHit) -> f64 {
    assert_eq!(hit.primitive >> KIND_SHIFT, REVOLUTION, "{hit:?}");
    let [from, to] = world.revolution_pieces[(hit.primitive & INDEX_MASK) as usize].along.map(f64::from);
    assert!((-1.0..=1.0).contains(&hit.x), "{hit:?}");
    from + (to - from) * (0.5 + 0.5 * f64::from(hit.x))
}

fn try_primary_rays(body: &Body, envelopes: Envelopes) -> Outcome {
    let mut rng = Rng(1);
    let samples = Samples::new(body.curve());
    let world = body.world(envelopes);
    let rays: Vec<_> = (0..count()).map(|_| primary(&mut rng)).collect();
    let mut outcome = Outcome::default();
    for (ray, hit) in rays.iter().zip(hit_segments(&world, &rays)) {
        let Some(roots) = samples.clear_roots(ray) else {
            continue;
        };
        outcome.rays += 1;
        match roots.first() {
            // Several times the largest errors seen.
            Some((t, along)) if hit.primitive != NONE && (t - f64::from(hit.t)).abs() < 1e-3 => {
                outcome.error += (t - f64::from(hit.t)).abs();
                assert!((parameter(&world, &hit) - along).abs() < 0.01, "{ray:?}: {hit:?} is not at {along}");
            }
            Some(_) => outcome.wrong += 1,
            None => outcome.wrong += usize::from(hit.primitive != NONE),
        }
    }
    outcome.error /= outcome.rays as f64;
    println!("{} {envelopes:?}: {outcome:?}", body.name);
    outcome
}

/// What the method is good for: smooth bodies, seen from outside, not along the horizon.
/// The bounds are several times what was measured.
#[test]
fn clear_hits_of_primary_rays_agree_with_f64() {
    for body in &BODIES {
        let outcome = try_primary_rays(body, Envelopes::Both);
        assert!(outcome.rays > count() * 9 / 10, "{}: {outcome:?}", body.name);
        assert!(outcome.wrong_share() < 2e-4, "{}: {outcome:?}", body.name);
        assert!(outcome.error < 1e-5, "{}: {outcome:?}", body.name);
    }
}

/// One approximation alone has no start for some roots.
#[test]
fn one_approximation_is_not_enough() {
    let egg = &BODIES[3];
    let [chord, tangent, both] =
        [Envelopes::Chord, Envelopes::Tangent, Envelopes::Both].map(|which| try_primary_rays(egg, which).wrong);
    assert!(chord > both && chord < count() / 200, "{chord} {tangent} {both}");
    assert!(tangent < count() / 200, "{chord} {tangent} {both}");
}

/// A known failure, which is the method's own: there is no height to eliminate.
#[test]
fn a_horizontal_ray_finds_nothing() {
    for body in &BODIES {
        let world = body.world(Envelopes::Both);
        let rays: Vec<_> = [-0.5, 0.0, 0.5].map(|height| ray(DVec3::new(-3.0, 0.1, height), DVec3::X)).into();
        assert!(hit_segments(&world, &rays).iter().all(|hit| hit.primitive == NONE), "{}", body.name);
        // A slope is all it takes.
        let tilted = rays.iter().map(|level| SegmentRay { direction: [1.0, 0.0, 0.05], ..*level }).collect::<Vec<_>>();
        assert!(hit_segments(&world, &tilted).iter().all(|hit| hit.primitive != NONE), "{}", body.name);
    }
}

/// The vertices that the scene was packed with: see also src/gpu_scene/pack/newton.rs.
#[test]
fn chords_are_on_the_curve_and_tangents_outside() {
    let dome = &BODIES[2];
    for (envelopes, least, most) in [(Envelopes::Chord, -1e-6, 1e-6), (Envelopes::Tangent, 1e-5, 1e-2)] {
        let starts = dome.world(envelopes).newton_starts.clone();
        for start in &starts[1..starts.len() - 1] {
            let outside = |p: DVec2| (p - DVec2::new(0.0, -1.0)).length();
            let vertex = DVec2::new(start.point[0].into(), start.point[1].into());
            let off = outside(vertex) - outside(dome.curve().at(start.t.into()));
            assert!(off > least && off < most, "{envelopes:?} {start:?} is {off} outside");
        }
    }
}
