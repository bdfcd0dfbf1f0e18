//! bsdf.glsl: Fresnel reflectances, refraction, and what a scattered path weighs.

use glam::{DVec2, DVec3};

use crate::fixture::{EPS, Fixture, Rng, double, single};
use crate::generated::{Boundary, CONDUCTOR, DIELECTRIC, DIFFUSE, Fresnel, Incidence, Outcome, Reflectance, Refract};
use crate::world::World;

const COUNT: usize = 300_000;

fn reflectances(boundaries: &[Boundary]) -> Vec<Reflectance> {
    let fixture = Fixture::new();
    let (boundaries, out) = (fixture.upload(boundaries), fixture.output(boundaries.len()));
    fixture.run(&Fresnel { boundaries: &boundaries, reflectances: &out }, boundaries.len() as usize);
    fixture.read(&out)
}

fn boundary(cos_i: f64, eta: f64, k: f64) -> Boundary {
    Boundary { cos_i: cos_i as f32, eta: eta as f32, k: k as f32, pad0: 0.0 }
}

/// Reflectance between dielectrics by Fresnel's equations, from both cosines.
fn reflect(cos_i: f64, cos_t: f64, eta: f64) -> f64 {
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// The square of the refracted cosine, and the error that fp32 makes: 1.5 EPS in
/// 1 - cos^2, times 1 / eta^2, and three relative ones.
fn refracted_cos2(cos_i: f64, eta: f64) -> (f64, f64) {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    (1.0 - sin2_t, EPS * (1.5 / (eta * eta) + 4.0 * sin2_t + 1.0))
}

/// Angles anywhere, grazing, normal, and at the threshold of total reflection.
fn random_boundary(rng: &mut Rng) -> Boundary {
    let eta = if rng.chance(0.1) { 1.0 } else { rng.log_range(0.3, 4.0) };
    let cos_i = match rng.below(4) {
        0 => rng.log_range(1e-7, 1.0),
        1 => 1.0 - rng.log_range(1e-7, 1.0),
        2 if eta < 1.0 => {
            let threshold = (1.0 - eta * eta).sqrt();
            (threshold + rng.log_range(1e-8, 1e-2) * if rng.chance(0.5) { 1.0 } else { -1.0 }).clamp(0.0, 1.0)
        }
        _ => rng.unit(),
    };
    boundary(cos_i, eta, rng.log_range(0.01, 10.0))
}

/// The extremes of the reflectance over the refracted cosines that fp32 may compute bound
/// it, to 16 EPS for its own roundings.
#[test]
fn dielectric_reflectance_agrees_with_f64() {
    let mut rng = Rng(1);
    let mut boundaries: Vec<_> = (0..COUNT).map(|_| random_boundary(&mut rng)).collect();
    for eta in [0.3, 0.5, 0.999, 1.0, 1.001, 1.5, 4.0] {
        boundaries.extend([boundary(0.0, eta, 1.0), boundary(1.0, eta, 1.0)]);
    }
    let mut total = 0;
    for (boundary, result) in boundaries.iter().zip(reflectances(&boundaries)) {
        let (cos_i, eta) = (f64::from(boundary.cos_i), f64::from(boundary.eta));
        let (cos2, error) = refracted_cos2(cos_i, eta);
        let [least, most] = [cos2 - error, cos2 + error].map(|cos2| cos2.clamp(0.0, 1.0).sqrt());
        let possible = (0..=16).map(|i| reflect(cos_i, least + (most - least) * f64::from(i) / 16.0, eta));
        // The least may be between them, where the cosines agree.
        let possible = possible.chain([reflect(cos_i, cos2.clamp(0.0, 1.0).sqrt(), eta)]);
        let (low, high) = possible.fold((1.0_f64, 0.0_f64), |(low, high), r| (low.min(r), high.max(r)));
        let value = f64::from(result.dielectric);
        let within = value >= low - 16.0 * EPS && value <= high + 16.0 * EPS;
        assert!(within || cos_i == 0.0, "{boundary:?}: {value} not in {low} .. {high}");
        assert!((0.0..=1.0).contains(&value), "{boundary:?} reflects {value}");
        let cos_t = f64::from(result.cos_t);
        assert!(cos_t >= least - 2.0 * EPS && cos_t <= most + 2.0 * EPS, "{boundary:?}: cosine {cos_t}");
        if cos2 < -error {
            total += 1;
            assert!(value == 1.0 && cos_t == 0.0, "{boundary:?} is total reflection: {result:?}");
        }
    }
    assert!(total > COUNT / 20, "{total}");
}

#[test]
fn known_dielectric_reflectances() {
    let brewster = 1.0 / (1.0_f64 + 1.5 * 1.5).sqrt();
    let results = reflectances(&[
        boundary(1.0, 1.5, 1.0),
        boundary(1.0, 1.0 / 1.5, 1.0),
        boundary(brewster, 1.5, 1.0),
        boundary(0.5, 0.7, 1.0),
    ]);
    // At normal incidence ((eta - 1) / (eta + 1))^2 from either side; at Brewster's angle
    // only the perpendicular half is reflected; 60 degrees is past the threshold of 0.7.
    let perpendicular = ((1.5_f64 * 1.5 - 1.0) / (1.5 * 1.5 + 1.0)).powi(2);
    for (result, expected) in results.iter().zip([0.04, 0.04, 0.5 * perpendicular, 1.0]) {
        assert!((f64::from(result.dielectric) - expected).abs() < 1e-6, "{result:?} is not {expected}");
    }
}

/// Light crosses a boundary alike in both directions.
#[test]
fn dielectric_reflectance_is_reciprocal() {
    let mut rng = Rng(2);
    let there: Vec<_> = (0..COUNT).map(|_| boundary(rng.range(0.05, 1.0), rng.range(1.0, 4.0), 1.0)).collect();
    let results = reflectances(&there);
    let inverse =
        |(there, result): (&Boundary, &Reflectance)| Boundary { cos_i: result.cos_t, eta: 1.0 / there.eta, ..*there };
    let back: Vec<_> = there.iter().zip(&results).map(inverse).collect();
    for ((boundary, there), back) in there.iter().zip(&results).zip(reflectances(&back)) {
        // 1 / eta and cos_t are 2 EPS off each, which cos_i feels eta^2 / cos_i times.
        let bound = 1e-5 / f64::from(boundary.cos_i);
        assert!(f64::from((there.dielectric - back.dielectric).abs()) < bound, "{boundary:?}: {there:?} {back:?}");
        assert!(f64::from((back.cos_t - boundary.cos_i).abs()) < bound, "{boundary:?}: {there:?} {back:?}");
    }
}

/// |r|^2 by complex arithmetic, independent of the real form in the shader.
fn reflect_metal(cos_i: f64, eta: f64, k: f64) -> f64 {
    // w = sqrt((eta + i k)^2 - sin^2)
    let sin2 = 1.0 - cos_i * cos_i;
    let square = DVec2::new(eta * eta - k * k - sin2, 2.0 * eta * k);
    let length = square.length();
    let imaginary = (0.5 * (length - square.x)).max(0.0).sqrt();
    // The smaller of the two parts from the product, without cancellation.
    let w = if square.x > 0.0 {
        let real = (0.5 * (length + square.x)).sqrt();
        DVec2::new(real, 0.5 * square.y / real)
    } else {
        DVec2::new(0.5 * square.y / imaginary, imaginary)
    };
    let multiply = |a: DVec2, b: DVec2| DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
    let index2 = multiply(DVec2::new(eta, k), DVec2::new(eta, k));
    let ratio = |a: DVec2, b: DVec2| (a - b).length_squared() / (a + b).length_squared();
    let perpendicular = ratio(DVec2::new(cos_i, 0.0), w);
    let parallel = ratio(index2 * cos_i, w);
    0.5 * (perpendicular + parallel)
}

/// The real part a of w comes from a^2, which cancels to 4 EPS of |w^2| (and 2 EPS of the
/// terms of w^2); the reflectance then moves by at most 4 |da| / |w|, and by 32 EPS.
#[test]
fn conductor_reflectance_agrees_with_f64() {
    let mut rng = Rng(3);
    let boundaries: Vec<_> = (0..COUNT)
        .map(|_| {
            let cos_i = if rng.chance(0.3) { rng.log_range(1e-6, 1.0) } else { rng.unit() };
            boundary(cos_i, rng.log_range(0.03, 5.0), rng.log_range(0.3, 10.0))
        })
        .collect();
    let mut worst = 0.0_f64;
    for (boundary, result) in boundaries.iter().zip(reflectances(&boundaries)) {
        let (cos_i, eta, k) = (f64::from(boundary.cos_i), f64::from(boundary.eta), f64::from(boundary.k));
        let exact = reflect_metal(cos_i, eta, k);
        let length = DVec2::new(eta * eta - k * k - (1.0 - cos_i * cos_i), 2.0 * eta * k).length();
        let a2 = 0.5 * (length + eta * eta - k * k - (1.0 - cos_i * cos_i)).max(0.0);
        let a2_error = EPS * (4.0 * length + 2.0 * (eta * eta + k * k + 1.0));
        let a_error = (a2 + a2_error).sqrt() - (a2 - a2_error).max(0.0).sqrt();
        let bound = 4.0 * a_error / length.sqrt().max(0.1) + 32.0 * EPS;
        let error = (f64::from(result.conductor) - exact).abs();
        assert!(error <= bound, "{boundary:?}: {} is not {exact}, {error:e} off, not {bound:e}", result.conductor);
        assert!((0.0..=1.0).contains(&result.conductor), "{boundary:?} reflects {}", result.conductor);
        worst = worst.max(error);
    }
    assert!(worst < 1e-3, "{worst:e}");
}

/// An index of 0, that of what is around the metal, and indices as large as materials have: at
/// the angles where sums of squares are 0.
#[test]
fn metals_at_the_ends_reflect_what_their_limits_say() {
    let limits = [(0.0, 0.0, 1.0, 1.0), (0.0, 0.0, 0.5, 1.0), (1.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.5, 0.0)];
    let large = [(1e9, 1e9, 1.0, 1.0), (0.0, 1e9, 0.5, 1.0), (1e9, 0.0, 1.0, 1.0)];
    for (boundary, expected) in limits.iter().chain(&large).map(|(eta, k, cos, r)| (boundary(*cos, *eta, *k), *r)) {
        let value = f64::from(reflectances(&[boundary])[0].conductor);
        assert!((value - expected).abs() < 1e-6, "{boundary:?} reflects {value}, not {expected}");
    }
    // Grazing, all reflect all or, without a difference of index, any part: a number at least.
    for (eta, k) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1e9, 1e9)] {
        let value = reflectances(&[boundary(0.0, eta, k)])[0].conductor;
        assert!((0.0..=1.0).contains(&value), "{eta} {k} reflects {value}");
    }
}

/// Gold and copper at 630, 530 and 465 nm (Johnson and Christy 1972), at normal incidence.
#[test]
fn known_metals_have_their_colours() {
    let metals = [(0.188, 3.40), (0.543, 2.23), (1.346, 1.88), (0.238, 3.44), (1.02, 2.59), (1.17, 2.40)];
    let boundaries: Vec<_> = metals.iter().map(|(eta, k)| boundary(1.0, *eta, *k)).collect();
    for ((eta, k), result) in metals.iter().zip(reflectances(&boundaries)) {
        let expected = ((eta - 1.0_f64).powi(2) + k * k) / ((eta + 1.0_f64).powi(2) + k * k);
        assert!((f64::from(result.conductor) - expected).abs() < 2e-6, "{eta} {k}: {result:?} is not {expected}");
    }
}

fn scatter(incidences: &[Incidence]) -> Vec<Outcome> {
    let fixture = Fixture::new();
    let (incidences, outcomes) = (fixture.upload(incidences), fixture.output(incidences.len()));
    let scene = World::default().upload(&fixture);
    fixture.run(
        &Refract { scene: scene.bindings(), incidences: &incidences, outcomes: &outcomes },
        incidences.len() as usize,
    );
    fixture.read(&outcomes)
}

const COLOR: [f32; 3] = [0.25, 0.5, 0.875];

fn random_incidence(rng: &mut Rng, kind: u32) -> Incidence {
    let normal = double(single(rng.direction()));
    let mut wo = rng.direction();
    if rng.chance(0.3) {
        wo -= wo.dot(normal) * normal * (1.0 - rng.log_range(1e-4, 1.0));
    }
    Incidence {
        wo: single(wo.normalize()),
        u: rng.unit_f32(),
        normal: single(normal),
        kind,
        color: COLOR,
        carries_radiance: u32::from(rng.chance(0.5)),
        eta: [rng.log_range(0.3, 4.0) as f32, 0.7, 1.9],
        pad0: 0.0,
        k: [3.0, 2.0, 1.0],
        pad1: 0.0,
        u_direction: [rng.unit_f32(), rng.unit_f32()],
        pad2: [0.0; 2],
    }
}

/// A mirrored direction has two roundings of its terms on each axis.
fn assert_mirrored(incidence: &Incidence, wi: [f32; 3]) {
    let (wo, n) = (double(incidence.wo), double(incidence.normal));
    let error = (double(wi) - (2.0 * wo.dot(n) * n - wo)).length();
    assert!(error < 16.0 * EPS, "{incidence:?} is reflected to {wi:?}");
}

/// Refraction in f64; and how far fp32 may be from it, since the refracted cosine is the
/// root of a difference.
fn refract(incidence: &Incidence) -> (DVec3, f64) {
    let (wo, n) = (double(incidence.wo), double(incidence.normal));
    let cos_o = wo.dot(n);
    let eta = if cos_o > 0.0 { f64::from(incidence.eta[0]) } else { 1.0 / f64::from(incidence.eta[0]) };
    let across = (cos_o * n - wo) / eta;
    let (cos2, error) = refracted_cos2(cos_o.abs(), eta);
    // Unit vectors in fp32 and their cosine are 4 EPS off.
    let error = error + 8.0 * EPS * cos_o.abs() / (eta * eta) + 8.0 * EPS;
    let wi = across - cos_o.signum() * cos2.max(0.0).sqrt() * n;
    (wi.normalize(), (cos2 + error).max(0.0).sqrt() - (cos2 - error).max(0.0).sqrt() + 16.0 * EPS / eta)
}

#[test]
fn dielectrics_refract_by_snells_law_and_weigh_right() {
    let mut rng = Rng(4);
    let incidences: Vec<_> = (0..COUNT).map(|_| random_incidence(&mut rng, DIELECTRIC)).collect();
    let (mut reflected, mut crossed, mut total, mut expected) = (0, 0, 0, 0.0);
    for (incidence, outcome) in incidences.iter().zip(scatter(&incidences)) {
        let (wo, n) = (double(incidence.wo), double(incidence.normal));
        let cos_o = wo.dot(n);
        let eta = if cos_o > 0.0 { f64::from(incidence.eta[0]) } else { 1.0 / f64::from(incidence.eta[0]) };
        let (cos2, _) = refracted_cos2(cos_o.abs(), eta);
        expected += if cos2 <= 0.0 { 1.0 } else { reflect(cos_o.abs(), cos2.sqrt(), eta) };
        let wi = double(outcome.wi);
        assert!((wi.length() - 1.0).abs() < 8.0 * EPS, "{incidence:?}: {wi} is no unit vector");
        if outcome.transmitted == 0 {
            reflected += 1;
            total += usize::from(cos2 <= 0.0);
            assert_mirrored(incidence, outcome.wi);
            assert_eq!(outcome.weight, [1.0; 3], "{incidence:?} reflects with a weight");
            continue;
        }
        crossed += 1;
        let (exact, error) = refract(incidence);
        assert!((wi - exact).length() <= error, "{incidence:?} is refracted to {wi}, not {exact}");
        assert!(wi.dot(n) * cos_o <= 0.0, "{incidence:?} is refracted to its own side");
        let compression = if incidence.carries_radiance == 1 { 1.0 / (eta * eta) } else { 1.0 };
        for (weight, color) in outcome.weight.into_iter().zip(COLOR) {
            let exact = f64::from(color) * compression;
            assert!(
                (f64::from(weight) - exact).abs() <= 8.0 * EPS * exact,
                "{incidence:?} weighs {:?}",
                outcome.weight
            );
        }
    }
    assert!(crossed > COUNT / 3 && total > COUNT / 20, "{crossed} {total}");
    // The sum of independent choices: a variance of at most a quarter each.
    let limit = 6.0 * 0.5 * (COUNT as f64).sqrt();
    assert!((f64::from(reflected) - expected).abs() < limit, "{reflected} of {COUNT} are reflected, not {expected}");
}

/// A path may be walked backwards: through a boundary and back it weighs color^2, whatever
/// it carries, and comes out where it came in.
#[test]
fn refraction_is_reversible() {
    let mut rng = Rng(5);
    let incidences: Vec<_> = (0..COUNT)
        .map(|_| Incidence { u: 1.0 - f32::EPSILON / 2.0, ..random_incidence(&mut rng, DIELECTRIC) })
        .collect();
    let mut crossed = 0;
    for (incidence, outcome) in incidences.iter().zip(scatter(&incidences)) {
        let cos = double(incidence.wo).dot(double(incidence.normal)).abs();
        if outcome.transmitted == 0 || cos < 0.05 {
            continue;
        }
        crossed += 1;
        assert_eq!(outcome.transmitted_back, 1, "{incidence:?} finds no way back: {outcome:?}");
        let error = (double(outcome.wi_back) - double(incidence.wo)).length();
        assert!(error < 2e-4, "{incidence:?} comes back as {:?}", outcome.wi_back);
        for ((there, back), color) in outcome.weight.into_iter().zip(outcome.weight_back).zip(COLOR) {
            assert!((there * back / (color * color) - 1.0).abs() < 1e-6, "{incidence:?}: {there} and {back}");
        }
    }
    assert!(crossed > COUNT / 3, "{crossed}");
}

#[test]
fn conductors_mirror_with_their_reflectance_on_both_sides() {
    let mut rng = Rng(6);
    let incidences: Vec<_> = (0..COUNT).map(|_| random_incidence(&mut rng, CONDUCTOR)).collect();
    for (incidence, outcome) in incidences.iter().zip(scatter(&incidences)) {
        assert_mirrored(incidence, outcome.wi);
        assert_eq!(outcome.transmitted, 0);
        let cos = double(incidence.wo).dot(double(incidence.normal)).abs();
        for channel in 0..3 {
            let exact = reflect_metal(cos, incidence.eta[channel].into(), incidence.k[channel].into());
            assert!((f64::from(outcome.weight[channel]) - exact).abs() < 1e-5, "{incidence:?} weighs {outcome:?}");
        }
    }
}

#[test]
fn diffuse_surfaces_keep_the_side_and_weigh_their_colour() {
    let mut rng = Rng(7);
    let incidences: Vec<_> = (0..COUNT).map(|_| random_incidence(&mut rng, DIFFUSE)).collect();
    for (incidence, outcome) in incidences.iter().zip(scatter(&incidences)) {
        let n = double(incidence.normal);
        let (cos_o, cos_i) = (double(incidence.wo).dot(n), double(outcome.wi).dot(n));
        assert!(
            cos_o * cos_i >= 0.0 || cos_o.abs().min(cos_i.abs()) < 1e-6,
            "{incidence:?} scatters through the surface: {outcome:?}"
        );
        assert_eq!((outcome.weight, outcome.transmitted), (COLOR, 0));
    }
}
