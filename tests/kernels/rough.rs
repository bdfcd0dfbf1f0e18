//! microfacet.glsl, glossy.glsl and layers.glsl: what is sampled is what is said, light goes
//! both ways alike, and none is made.

use std::f64::consts::PI;

use bytemuck::Zeroable;
use glam::DVec3;

use crate::fixture::{Fixture, Rng, double, single};
use crate::generated::{
    COAT, COATED_CONDUCTOR, COATED_DIFFUSE, CONDUCTOR, DIELECTRIC, DIFFUSE, DIFFUSE_TRANSMISSION, HAS_LAMBERTIAN,
    Material, MaterialFeatures, Meeting, NONE, ScatterLobes, Scattered, Specialization, THIN_DIELECTRIC,
};
use crate::world::World;

const KINDS: [u32; 4] = [CONDUCTOR, DIELECTRIC, COAT, COATED_CONDUCTOR];

fn scatter(materials: &[Material], meetings: &[Meeting]) -> Vec<Scattered> {
    scatter_in(&World::default(), materials, meetings)
}

/// The same where materials have tables in the arrays of a scene.
pub fn scatter_in(world: &World, materials: &[Material], meetings: &[Meeting]) -> Vec<Scattered> {
    let fixture = Fixture::new();
    let scene = world.upload(&fixture);
    let (meetings, lobes) = (fixture.upload(meetings), fixture.upload(materials));
    let out = fixture.output(meetings.len() as usize);
    let kernel = ScatterLobes { scene: scene.bindings(), meetings: &meetings, lobes: &lobes, outcomes: &out };
    let all = Specialization {
        material: MaterialFeatures {
            has_rough: true,
            has_coats: true,
            has_thin: true,
            has_diffuse_transmission: true,
            has_layers: true,
            has_measured: true,
            has_anisotropic: true,
            ..Specialization::DECLARED.material
        },
        ..Specialization::DECLARED
    };
    fixture.run_specialized(&kernel, &all, meetings.len() as usize);
    fixture.read(&out)
}

fn material(kind: u32, alpha: [f64; 2]) -> Material {
    let [u, v] = alpha.map(|alpha| alpha as f32);
    let coated = kind == COAT || kind == COATED_CONDUCTOR;
    Material {
        kind,
        color: [1.0; 3],
        eta: if kind == DIELECTRIC { [1.5; 3] } else { [0.2, 0.9, 1.5] },
        k: [3.0, 2.0, 6.0],
        alpha_u: u,
        alpha_v: v,
        coat_eta: if coated { 1.5 } else { 0.0 },
        coat_thickness: if coated { 0.01 } else { 0.0 },
        coat_sent_back: if coated { 0.1 } else { 0.0 },
        color_texture: NONE,
        ..Material::zeroed()
    }
}

/// One on each side of the surface, as the material allows.
fn meeting(rng: &mut Rng, material: usize, kind: u32) -> Meeting {
    let normal = rng.direction();
    let mut wo = rng.direction();
    while wo.dot(normal).abs() < 0.05 {
        wo = rng.direction();
    }
    if kind != DIELECTRIC && wo.dot(normal) < 0.0 {
        wo = -wo;
    }
    Meeting {
        wo: single(wo),
        material: material as u32,
        wi: [0.0; 3],
        u_lobe: rng.unit_f32(),
        normal: single(normal),
        whole: 0,
        tangent: single(rng.direction()),
        carries_radiance: u32::from(rng.chance(0.5)),
        u: [rng.unit_f32(), rng.unit_f32()],
        pad0: [0.0; 2],
    }
}

fn random_materials(rng: &mut Rng, count: usize) -> Vec<Material> {
    let mut make = |i: usize| {
        let alpha = rng.log_range(0.02, 1.0);
        let other = if rng.chance(0.5) { alpha } else { rng.log_range(0.02, 1.0) };
        material(KINDS[i % KINDS.len()], [alpha, other])
    };
    (0..count).map(&mut make).collect()
}

#[test]
fn weights_are_the_bsdf_over_the_pdf() {
    let mut rng = Rng(1);
    let materials = random_materials(&mut rng, 400);
    let meetings: Vec<_> =
        (0..200_000).map(|i| meeting(&mut rng, i % materials.len(), materials[i % materials.len()].kind)).collect();
    let mut compared = 0;
    for (meeting, outcome) in meetings.iter().zip(scatter(&materials, &meetings)) {
        if outcome.weight == [0.0; 3] || outcome.pdf < 1e-3 {
            continue;
        }
        // A grazing direction in fp32 is uncertain by more than its cosine.
        if double(outcome.wi).dot(double(meeting.normal)).abs() < 0.02 {
            continue;
        }
        compared += 1;
        for channel in 0..3 {
            let expected = outcome.value[channel] / outcome.pdf;
            let error = (outcome.weight[channel] - expected).abs();
            assert!(
                error <= 0.01 * expected + 1e-5,
                "{meeting:?} {:?}: {outcome:?}",
                materials[meeting.material as usize]
            );
        }
    }
    assert!(compared > 150_000, "{compared}");
}

/// Radiance that goes from wi to wo meets what flux does on the way back (Veach 1997, eq. 5.14).
#[test]
fn light_goes_both_ways_alike() {
    let mut rng = Rng(2);
    let materials = random_materials(&mut rng, 400);
    let there: Vec<_> = (0..100_000)
        .map(|i| {
            let kind = materials[i % materials.len()].kind;
            let mut meeting = meeting(&mut rng, i % materials.len(), kind);
            let mut wi = rng.direction();
            let side = wi.dot(double(meeting.normal));
            if kind != DIELECTRIC && side < 0.0 {
                wi = -wi;
            }
            meeting.wi = single(wi);
            meeting.carries_radiance = 1;
            meeting
        })
        .collect();
    let back: Vec<_> =
        there.iter().map(|there| Meeting { wo: there.wi, wi: there.wo, carries_radiance: 0, ..*there }).collect();
    let mut compared = 0;
    for ((meeting, there), back) in there.iter().zip(scatter(&materials, &there)).zip(scatter(&materials, &back)) {
        let n = double(meeting.normal);
        let [cos_o, cos_i] = [meeting.wo, meeting.wi].map(|w| double(w).dot(n).abs());
        if cos_o.min(cos_i) < 0.05 {
            continue;
        }
        for channel in 0..3 {
            let [f, g] = [f64::from(there.value[channel]) / cos_i, f64::from(back.value[channel]) / cos_o];
            compared += usize::from(f > 1e-3);
            assert!((f - g).abs() <= 0.005 * f.max(g) + 1e-4, "{meeting:?}: {there:?} {back:?}");
        }
    }
    assert!(compared > 60_000, "{compared}");
}

/// GGX in f64, in terms of angles; reflection only.
fn reflected(wo: DVec3, wi: DVec3, alpha: f64) -> f64 {
    let m = (wo + wi).normalize();
    let tan2 = |w: DVec3| (1.0 - w.z * w.z).max(0.0) / (w.z * w.z);
    let d = (1.0 + tan2(m) / (alpha * alpha)).powi(-2) / (PI * alpha * alpha * m.z.powi(4));
    let lambda = |w: DVec3| 0.5 * ((1.0 + alpha * alpha * tan2(w)).sqrt() - 1.0);
    d / (4.0 * wo.z * (1.0 + lambda(wo) + lambda(wi)))
}

#[test]
fn reflection_agrees_with_f64() {
    let mut rng = Rng(3);
    // eta = 1 and no k would reflect nothing: a metal that reflects nearly all light.
    let alphas: Vec<f64> = (0..100).map(|_| rng.log_range(1e-3, 1.0)).collect();
    let metal = |alpha: &f64| Material { eta: [1e-3; 3], k: [100.0; 3], ..material(CONDUCTOR, [*alpha; 2]) };
    let materials: Vec<_> = alphas.iter().map(metal).collect();
    let meetings: Vec<_> = (0..100_000)
        .map(|i| {
            let meeting = meeting(&mut rng, i % 100, CONDUCTOR);
            // By the mirrored direction, where the lobe is.
            let (wo, n) = (double(meeting.wo), double(meeting.normal));
            let spread = alphas[i % 100] * rng.range(0.0, 3.0);
            let wi = (2.0 * wo.dot(n) * n - wo + spread * rng.direction()).normalize();
            Meeting { wi: single(if wi.dot(n) < 0.0 { wo } else { wi }), ..meeting }
        })
        .collect();
    for (meeting, outcome) in meetings.iter().zip(scatter(&materials, &meetings)) {
        let n = double(meeting.normal).normalize();
        let s = n.any_orthonormal_vector();
        let local = |w: [f32; 3]| DVec3::new(double(w).dot(s), double(w).dot(n.cross(s)), double(w).dot(n));
        let alpha = f64::from(materials[meeting.material as usize].alpha_u);
        let exact = reflected(local(meeting.wo), local(meeting.wi), alpha);
        // A facet's slope is off by some roundings, which the lobe's width magnifies.
        let bound = 1e-3 + 1e-5 / alpha;
        if local(meeting.wi).z > 0.02 {
            let value = f64::from(outcome.value[0]);
            assert!((value - exact).abs() <= bound * exact + 1e-4, "{meeting:?} {alpha}: {value} is not {exact}");
        }
    }
}

/// Cells of equal cosine and azimuth over the whole sphere.
const SIDE: usize = 16;
/// Places in each cell where the pdf is evaluated.
const FINE: usize = 12;

/// Checks that sampled directions follow the pdf of a material of a world, by chi squared.
pub fn directions_follow_the_pdf(world: &World, lobe: Material, wo: DVec3) {
    const SAMPLES: usize = 200_000;
    let mut rng = Rng(4);
    let base = Meeting {
        wo: single(wo),
        normal: [0.0, 0.0, 1.0],
        tangent: [1.0, 0.0, 0.0],
        carries_radiance: 1,
        ..Meeting::zeroed()
    };
    let draw = |rng: &mut Rng| Meeting { u_lobe: rng.unit_f32(), u: [rng.unit_f32(), rng.unit_f32()], ..base };
    let samples: Vec<_> = (0..SAMPLES).map(|_| draw(&mut rng)).collect();
    let steps = SIDE * FINE;
    let direction = |i: usize| {
        let z = ((i / steps) as f64 + 0.5) / steps as f64 * 2.0 - 1.0;
        let phi = ((i % steps) as f64 + 0.5) / steps as f64 * 2.0 * PI;
        let r = (1.0 - z * z).sqrt();
        Meeting { wi: single(DVec3::new(r * phi.cos(), r * phi.sin(), z)), ..base }
    };
    let judged: Vec<_> = (0..steps * steps).map(direction).collect();
    let mut expected = vec![0.0; SIDE * SIDE];
    for (i, outcome) in scatter_in(world, &[lobe], &judged).iter().enumerate() {
        let cell = i / steps / FINE * SIDE + i % steps / FINE;
        expected[cell] += f64::from(outcome.pdf) * 4.0 * PI / (steps * steps) as f64 * SAMPLES as f64;
    }
    let mut counts = vec![0.0; SIDE * SIDE];
    for outcome in scatter_in(world, &[lobe], &samples).iter().filter(|outcome| outcome.weight != [0.0; 3]) {
        let [x, y, z] = outcome.wi.map(f64::from);
        let place = |x: f64| ((x * SIDE as f64) as usize).min(SIDE - 1);
        counts[place(0.5 * z + 0.5) * SIDE + place((y.atan2(x) / (2.0 * PI)).rem_euclid(1.0))] += 1.0;
    }
    let cells = expected.iter().zip(&counts).filter(|(expected, _)| **expected >= 20.0);
    let (mut chi2, mut freedom) = (0.0, 0.0_f64);
    for (expected, count) in cells {
        chi2 += (count - expected).powi(2) / expected;
        freedom += 1.0;
    }
    assert!(freedom > 20.0, "{freedom}");
    // The integral of the pdf is good to a percent or so of a cell.
    let limit = freedom + 6.0 * (2.0 * freedom).sqrt() + 12.0 + 1e-4 * SAMPLES as f64 / freedom;
    assert!(chi2 <= limit, "{lobe:?} from {wo}: chi squared {chi2:.1} of {freedom} degrees of freedom");
}

#[test]
fn rough_directions_follow_their_pdf() {
    for kind in KINDS {
        for alpha in [[0.3, 0.3], [0.6, 0.2]] {
            directions_follow_the_pdf(&World::default(), material(kind, alpha), DVec3::new(0.5, 0.2, 0.7).normalize());
        }
    }
    directions_follow_the_pdf(
        &World::default(),
        material(DIELECTRIC, [0.4, 0.4]),
        DVec3::new(0.3, 0.1, -0.9).normalize(),
    );
}

/// Mean weight of directions from a material at an angle, per channel.
fn albedo(lobe: Material, cos: f64) -> [f64; 3] {
    const SAMPLES: usize = 100_000;
    let mut rng = Rng(5);
    let wo = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let draw = |_| Meeting {
        wo: single(wo),
        normal: [0.0, 0.0, 1.0],
        whole: 1,
        u_lobe: rng.unit_f32(),
        u: [rng.unit_f32(), rng.unit_f32()],
        ..Meeting::zeroed()
    };
    let meetings: Vec<_> = (0..SAMPLES).map(draw).collect();
    let outcomes = scatter(&[lobe], &meetings);
    [0, 1, 2].map(|i| outcomes.iter().map(|o| f64::from(o.weight[i])).sum::<f64>() / SAMPLES as f64)
}

/// What facets reflect of all light from an angle, if each does so once, by quadrature in f64.
fn reflected_once(alpha: f64, cos: f64) -> f64 {
    const STEPS: usize = 500;
    let wo = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mut sum = 0.0;
    for i in 0..STEPS {
        for j in 0..STEPS {
            let z = (i as f64 + 0.5) / STEPS as f64;
            let phi = (j as f64 + 0.5) / STEPS as f64 * 2.0 * PI;
            let r = (1.0 - z * z).sqrt();
            sum += reflected(wo, DVec3::new(r * phi.cos(), r * phi.sin(), z), alpha);
        }
    }
    sum * 2.0 * PI / (STEPS * STEPS) as f64
}

#[test]
fn facets_lose_what_they_hide() {
    for alpha in [0.2, 0.5, 1.0] {
        let lobe = Material { eta: [1e-3; 3], k: [100.0; 3], ..material(CONDUCTOR, [alpha; 2]) };
        for cos in [0.95, 0.5, 0.2] {
            let (mean, exact) = (albedo(lobe, cos)[0], reflected_once(alpha, cos));
            assert!((mean - exact).abs() < 0.01, "{alpha} at {cos}: {mean} is not {exact}");
        }
    }
}

/// White surfaces that absorb nothing send all light on, but for what rough facets hide.
#[test]
fn a_white_furnace_stays_white() {
    // Twice the integral of the Fresnel reflectance from below over cosines: 0.596 at 1.5.
    let coated = Material {
        color: [1.0; 3],
        coat_eta: 1.5,
        coat_sent_back: 0.5964,
        flags: HAS_LAMBERTIAN,
        ..material(COATED_DIFFUSE, [0.0; 2])
    };
    let sheet = Material { color: [0.3; 3], second: [0.7; 3], ..material(DIFFUSE_TRANSMISSION, [0.0; 2]) };
    for (lobe, least) in [
        (Material { eta: [1e-3; 3], k: [100.0; 3], ..material(CONDUCTOR, [0.0; 2]) }, 0.999),
        (material(DIELECTRIC, [0.0; 2]), 0.9999),
        (material(DIELECTRIC, [0.1; 2]), 0.97),
        (Material { eta: [1.5; 3], ..material(THIN_DIELECTRIC, [0.0; 2]) }, 0.9999),
        (coated, 0.99),
        (sheet, 0.99),
        (material(DIFFUSE, [0.0; 2]), 0.9999),
    ] {
        for cos in [0.95, 0.6, 0.4] {
            let mean = albedo(lobe, cos);
            assert!(mean.iter().all(|mean| (least..1.01).contains(mean)), "{lobe:?} at {cos}: {mean:?}");
        }
    }
}
