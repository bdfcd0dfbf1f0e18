//! A body on the device and its oracle, for rays in batches.

use std::cell::OnceCell;

use glam::{DAffine3, DVec3};
use goblet_host::{Buffer, Pass};

use crate::fixture::{Fixture, Rng, double, single};
use crate::generated::{
    BodyRay, FindRoots, FoundRoot, GpuScene, HitRevolutions, INDEX_MASK, Met, NONE, SceneFeatures, Specialization,
};
use crate::revolution::line::Line;
use crate::revolution::oracle::Oracle;
use crate::revolution::profiles::Profile;
use crate::revolution::rays::{Extent, Kind, draw};
use crate::revolution::tally::{Found, Missing, Tally, View};
use crate::world::{World, affine};

/// Roots that find_roots keeps of a ray; only rays that graze along a surface have more.
const MOST_ROOTS: usize = 32;
/// Surfaces that a refracted ray meets one after the other.
const BOUNCES: usize = 4;
/// No body has a root before.
const BEFORE_ALL: f32 = -1e4;
const AFTER_ALL: f32 = 1e4;

/// What is known of a body.
pub struct Subject {
    name: String,
    pub oracle: Oracle,
    /// The transforms that the kernels read.
    pub unit_from_render: DAffine3,
    pub render_from_unit: DAffine3,
    extent: Extent,
    /// Farther off, it is another root.
    same: f64,
}

/// A body and the passes over a batch of rays.
pub struct Lab<'a> {
    fixture: &'a Fixture,
    pub subject: Subject,
    pub world: World,
    pub render_from_world: DAffine3,
    rays: Buffer<BodyRay>,
    met: Buffer<Met>,
    roots: Buffer<FoundRoot>,
    counts: Buffer<u32>,
    piece_count: Buffer<u32>,
    hit: Pass<()>,
    /// Made when it is first used.
    find: OnceCell<Pass<()>>,
    uploaded: GpuScene,
    specialization: Specialization,
}

impl<'a> Lab<'a> {
    /// A body after some directives, for batches of rays.
    pub fn new(fixture: &'a Fixture, profile: &Profile, directives: &str, batch: usize, same: f64) -> Self {
        let (world, packed) = World::parse(&profile.scene(directives));
        let (rays, met) = (fixture.output(batch), fixture.output(batch));
        let (roots, counts) = (fixture.output(batch * MOST_ROOTS), fixture.output(batch));
        let specialization = Specialization {
            scene: SceneFeatures {
                has_triangles: false,
                has_spheres: false,
                has_disks: false,
                has_quadrics: false,
                revolution_pairs: packed.features.revolution_pairs,
                is_flat: packed.features.is_flat,
                flat_revolutions: packed.features.flat_revolutions,
                ..Specialization::DECLARED.scene
            },
            ..Specialization::DECLARED
        };
        let uploaded = world.upload(fixture);
        let kernel = HitRevolutions { scene: uploaded.bindings(), rays: &rays, met: &met };
        let hit = fixture.device().pass(&kernel, &specialization, 64).expect("a pass");
        Self {
            subject: Subject::new(profile, &world, same),
            render_from_world: packed.space.from_world(),
            find: OnceCell::new(),
            piece_count: fixture.upload(&[world.revolution_pieces.len() as u32]),
            fixture,
            world,
            rays,
            met,
            roots,
            counts,
            hit,
            uploaded,
            specialization,
        }
    }

    /// A body alone in the world, whose unit space has the bits of render space: rays there
    /// are exact.
    pub fn exact(fixture: &'a Fixture, profile: &Profile, batch: usize) -> Self {
        let lab = Self::new(fixture, profile, "", batch, 1e-4);
        let Subject { name, unit_from_render, .. } = &lab.subject;
        let columns = unit_from_render.matrix3.to_cols_array_2d();
        let scale = DVec3::new(columns[0][0], columns[1][1], columns[2][2]);
        let power_of_two = |x: f64| x > 0.0 && x.to_bits() << 12 == 0;
        assert_eq!(*unit_from_render, DAffine3::from_scale(scale), "{name} is not at the origin");
        assert!(scale.to_array().into_iter().all(power_of_two), "{name} rounds rays by {scale}");
        lab
    }

    /// A ray of a kind, as it is in the place of the body.
    pub fn draw(&self, kind: Kind, rng: &mut Rng) -> BodyRay {
        let (origin, direction) = draw(kind, rng, &self.subject.extent, &self.subject.oracle);
        let DAffine3 { matrix3: axes, translation } = self.subject.render_from_unit;
        let turn =
            |v: DVec3| v.x * axes.x_axis.normalize() + v.y * axes.y_axis.normalize() + v.z * axes.z_axis.normalize();
        body_ray(single(turn(origin) + translation), single(turn(direction)))
    }

    /// What rays meet first, found as in scenes of many bodies.
    pub fn meet_by_hierarchy(&self, rays: &[BodyRay]) -> Vec<Met> {
        let kernel = HitRevolutions { scene: self.uploaded.bindings(), rays: &self.rays, met: &self.met };
        let scene = SceneFeatures { is_flat: false, flat_revolutions: 0, ..self.specialization.scene };
        let specialization = Specialization { scene, ..self.specialization };
        self.run_hit(&self.fixture.device().pass(&kernel, &specialization, 64).expect("a pass"), rays)
    }

    /// What rays meet first.
    pub fn meet(&self, rays: &[BodyRay]) -> Vec<Met> {
        self.run_hit(&self.hit, rays)
    }

    fn run_hit(&self, hit: &Pass<()>, rays: &[BodyRay]) -> Vec<Met> {
        let device = self.fixture.device();
        device.write(&self.rays, rays).expect("an upload");
        let mut frame = device.frame().expect("a frame");
        frame.dispatch(hit, (), rays.len() as u64);
        frame.run().expect("a run");
        let mut met = self.fixture.read(&self.met);
        met.truncate(rays.len());
        met
    }

    fn find_pass(&self) -> Pass<()> {
        let (scene, rays, roots) = (self.uploaded.bindings(), &self.rays, &self.roots);
        let kernel = FindRoots { scene, rays, roots, root_counts: &self.counts, piece_count: &self.piece_count };
        self.fixture.device().pass(&kernel, &self.specialization, 64).expect("a pass")
    }

    /// The roots of rays between their bounds.
    pub fn find(&self, rays: &[BodyRay]) -> Vec<Vec<Found>> {
        let device = self.fixture.device();
        device.write(&self.rays, rays).expect("an upload");
        let mut frame = device.frame().expect("a frame");
        frame.clear(&self.counts);
        frame.dispatch(
            self.find.get_or_init(|| self.find_pass()),
            (),
            (rays.len() * self.world.revolution_pieces.len()) as u64,
        );
        frame.run().expect("a run");
        let (roots, counts) = (self.fixture.read(&self.roots), self.fixture.read(&self.counts));
        let of_ray = |i: usize| {
            let found = &roots[i * MOST_ROOTS..][..MOST_ROOTS.min(counts[i] as usize)];
            found.iter().map(|root| Found { t: root.t, x: root.x, piece: root.piece }).collect()
        };
        (0..rays.len()).map(of_ray).collect()
    }

    /// Rays of a kind, counted; the refracted ones of each surface that a ray goes through.
    /// With all roots, or the nearest only.
    pub fn tally(&self, kind: Kind, rng: &mut Rng, count: usize, all_roots: bool) -> Tally {
        let mut rays: Vec<_> = (0..count).map(|_| self.draw(kind, rng)).collect();
        if kind != Kind::Refracted {
            return self.compare(&rays, &self.meet(&rays), all_roots);
        }
        let mut tally = Tally::default();
        let mut met = self.meet(&rays);
        for _ in 0..BOUNCES {
            let through = met.iter().filter(|met| met.primitive != NONE);
            rays = through.map(|met| body_ray(met.next_origin, met.next_direction)).collect();
            met = self.meet(&rays);
            tally.merge(&self.compare(&rays, &met, all_roots));
        }
        tally
    }

    /// Compares what the kernels and the oracle say of rays.
    fn compare(&self, rays: &[BodyRay], met: &[Met], all_roots: bool) -> Tally {
        let found = if all_roots { self.find(rays) } else { Vec::new() };
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let part = rays.len().div_ceil(threads).max(1);
        let (mut tally, mut missing) = (Tally::default(), Vec::new());
        std::thread::scope(|scope| {
            let subject = &self.subject;
            let parts: Vec<_> = (0..rays.len())
                .step_by(part)
                .map(|first| {
                    let (end, found) = (rays.len().min(first + part), found.get(first..));
                    scope.spawn(move || subject.examine(first, &rays[first..end], &met[first..], found))
                })
                .collect();
            for part in parts {
                let (counted, lost) = part.join().expect("a tally");
                tally.merge(&counted);
                missing.extend(lost);
            }
        });
        self.look_again(rays, &missing, &mut tally);
        tally
    }

    /// A ray that grazes has more roots on a piece than are kept: one is missed if nothing is
    /// found where it is alone.
    fn look_again(&self, rays: &[BodyRay], missing: &[Missing], tally: &mut Tally) {
        for missing in missing.chunks(self.rays.len() as usize) {
            let near = |missing: &Missing| {
                let [t_min, t_max] = missing.between.map(|t| t as f32);
                BodyRay { t_min, t_max, ..rays[missing.ray] }
            };
            let found = self.find(&missing.iter().map(near).collect::<Vec<_>>());
            for (missing, found) in missing.iter().zip(found) {
                if found.is_empty() {
                    tally.miss(missing);
                }
            }
        }
    }
}

impl Subject {
    fn new(profile: &Profile, world: &World, same: f64) -> Self {
        let render_from_unit = affine(world.revolutions[0].render_from_unit);
        let scale = [render_from_unit.matrix3.x_axis.length(), render_from_unit.matrix3.z_axis.length()];
        let pieces = &world.revolution_pieces;
        let most = |one: usize, other: usize| {
            let ends = pieces.iter().map(|piece| piece.ends[one].abs().max(piece.ends[other].abs()));
            f64::from(ends.fold(0.0, f32::max))
        };
        Self {
            name: profile.name.clone(),
            oracle: Oracle::new(pieces, scale),
            unit_from_render: affine(world.revolutions[0].unit_from_render),
            render_from_unit,
            extent: Extent { radius: scale[0] * most(0, 2), height: scale[1] * most(1, 3) },
            same,
        }
    }

    /// A ray in unit space.
    pub fn line(&self, ray: &BodyRay) -> Line {
        let origin = self.unit_from_render.transform_point3(double(ray.origin));
        Line::new(origin, self.unit_from_render.transform_vector3(double(ray.direction)))
    }

    /// Compares rays, of which the first has a number, with what was found.
    fn examine(
        &self,
        first: usize,
        rays: &[BodyRay],
        met: &[Met],
        found: Option<&[Vec<Found>]>,
    ) -> (Tally, Vec<Missing>) {
        let (mut tally, mut missing) = (Tally::default(), Vec::new());
        for (i, (ray, met)) in rays.iter().zip(met).enumerate() {
            let line = self.line(ray);
            let nearest = Found { t: met.t, x: met.x, piece: met.primitive & INDEX_MASK };
            let found = found.and_then(|found| found.get(i));
            let view = View {
                body: &self.name,
                oracle: &self.oracle,
                line: &line,
                size: double(ray.direction).length(),
                same: self.same,
                roots: &self.oracle.solve(&line),
                found: found.map_or(&[], Vec::as_slice),
                nearest: (met.primitive != NONE).then_some(nearest),
            };
            if found.is_some() {
                view.count_roots(first + i, &mut tally, &mut missing);
            }
            view.count_nearest(&mut tally);
        }
        (tally, missing)
    }
}

/// A ray of which all roots count.
pub fn body_ray(origin: [f32; 3], direction: [f32; 3]) -> BodyRay {
    BodyRay { origin, t_min: BEFORE_ALL, direction, t_max: AFTER_ALL }
}
