//! intersect_sphere and intersect_disk, in object space, against f64.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3};

use crate::fixture::{EPS, Fixture, Rng, UNBOUNDED, double, frame, single};
use crate::generated::{DISK, HitQuadrics, KIND_SHIFT, ObjectHit, ObjectRay, Quadric, SPHERE, SceneArrays};
use crate::world::{World, quadric};

const COUNT: usize = 300_000;

fn hit_quadrics(quadrics: &[Quadric], rays: &[ObjectRay]) -> Vec<ObjectHit> {
    let fixture = Fixture::new();
    let world = World::of(SceneArrays { quadrics: quadrics.to_vec(), ..SceneArrays::default() }).upload(&fixture);
    let (rays, hits) = (fixture.upload(rays), fixture.output(rays.len()));
    fixture.run(&HitQuadrics { scene: world.bindings(), rays: &rays, hits: &hits }, rays.len() as usize);
    fixture.read(&hits)
}

fn object_ray(kind: u32, index: usize, origin: DVec3, direction: DVec3) -> ObjectRay {
    let quadric = kind << KIND_SHIFT | index as u32;
    ObjectRay { origin: single(origin), quadric, direction: single(direction), t_max: UNBOUNDED }
}

/// Whether fp32 must find a root of the f64 twin.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    Yes,
    No,
    /// Too near to a boundary to say.
    Either,
}

/// The verdict on `margin > 0`, known to within `error`.
fn above_zero(margin: f64, error: f64) -> Verdict {
    match margin {
        _ if margin > error => Verdict::Yes,
        _ if margin < -error => Verdict::No,
        _ => Verdict::Either,
    }
}

fn both(a: Verdict, b: Verdict) -> Verdict {
    match (a, b) {
        (Verdict::No, _) | (_, Verdict::No) => Verdict::No,
        (Verdict::Yes, Verdict::Yes) => Verdict::Yes,
        _ => Verdict::Either,
    }
}

/// A root that fp32 may find, nearest first.
#[derive(Debug)]
struct Root {
    t: f64,
    error: f64,
    verdict: Verdict,
}

/// Panics unless fp32 found the first root that it must, or one before it that it may.
fn assert_root(hit: &ObjectHit, ray: &ObjectRay, roots: &[Root]) {
    if hit.found == 0 {
        assert!(roots.iter().all(|root| root.verdict != Verdict::Yes), "{ray:?} misses {roots:?}");
        assert_eq!(hit.t, ray.t_max, "a miss changes t");
        return;
    }
    for root in roots {
        if root.verdict != Verdict::No && (f64::from(hit.t) - root.t).abs() <= root.error {
            return;
        }
        assert!(root.verdict != Verdict::Yes, "{ray:?} finds {} of {roots:?}", hit.t);
    }
    panic!("{ray:?} finds {} of {roots:?}", hit.t);
}

/// The cuts of a sphere at a point known to within `error`. The arc tangent is 4e-6 off.
fn cut_verdict(sphere: &Quadric, p: DVec3, error: f64) -> Verdict {
    let z = both(
        if sphere.z_min > -1.0 { above_zero(p.z - f64::from(sphere.z_min), error) } else { Verdict::Yes },
        if sphere.z_max < 1.0 { above_zero(f64::from(sphere.z_max) - p.z, error) } else { Verdict::Yes },
    );
    if f64::from(sphere.phi_max) >= TAU - 1e-6 {
        return z;
    }
    let phi = p.y.atan2(p.x).rem_euclid(TAU);
    let phi_error = 4e-6 + error / p.truncate().length().max(1e-30);
    let beyond_zero = above_zero(phi, phi_error);
    let inside = above_zero(f64::from(sphere.phi_max) - phi, phi_error);
    // Near phi = 0 the azimuth may come out as 2 pi.
    both(z, if beyond_zero == Verdict::Yes && phi < TAU - phi_error { inside } else { Verdict::Either })
}

/// Both roots, with errors of first order. With L the origin's distance from the centre and
/// a unit direction: the closest approach is at t_c = -o.d, off by 5 EPS L (three products,
/// two sums, a division by d.d); its point p is off by 2 EPS L across the ray and by the
/// same along it, which changes p.p at second order only. The half chord
/// sqrt(1 - p.p) then follows, whose error is large for grazing rays only.
fn sphere_roots(sphere: &Quadric, ray: &ObjectRay) -> Vec<Root> {
    let (o, d) = (double(ray.origin), double(ray.direction));
    let size = d.length();
    let unit = d / size;
    let reach = o.length();
    let closest = -o.dot(unit);
    let p = o + closest * unit;
    let h2 = 1.0 - p.length_squared();
    let across = 4.0 * EPS * (reach + 1.0);
    let along = 8.0 * EPS * (reach + 1.0);
    let h2_error = 2.0 * p.length() * across + along * along + across * across + 6.0 * EPS;
    let meets = above_zero(h2, h2_error);
    let chord = h2.max(0.0).sqrt();
    let chord_error = (h2.max(0.0) + h2_error).sqrt() - (h2 - h2_error).max(0.0).sqrt() + 4.0 * EPS * chord;
    let error = along + chord_error;
    [closest - chord, closest + chord]
        .map(|t| {
            let in_range = both(above_zero(t, error), above_zero(f64::from(ray.t_max) * size - t, error));
            let cuts = cut_verdict(sphere, o + t * unit, error + across);
            Root { t: t / size, error: error / size, verdict: both(meets, both(in_range, cuts)) }
        })
        .into()
}

fn whole_sphere() -> Quadric {
    quadric(&DAffine3::IDENTITY)
}

fn cut_sphere(rng: &mut Rng) -> Quadric {
    let (z0, z1) = (rng.range(-1.0, 1.0) as f32, rng.range(-1.0, 1.0) as f32);
    let phi_max = if rng.chance(0.3) { TAU } else { rng.range(0.1, TAU) } as f32;
    Quadric { z_min: z0.min(z1), z_max: z0.max(z1), phi_max, ..whole_sphere() }
}

/// Origins far, near, on the surface and inside; targets inside, at the rim, and beyond it.
fn random_sphere_ray(rng: &mut Rng, index: usize) -> ObjectRay {
    let distance = match rng.below(4) {
        0 => rng.log_range(1.0, 1e5),
        1 => rng.range(0.0, 1.0),
        2 => 1.0,
        _ => rng.range(1.0, 10.0),
    };
    let origin = distance * rng.direction();
    let target = match rng.below(3) {
        0 => rng.direction() * rng.range(0.0, 1.2),
        1 => rng.direction(),
        _ => {
            // A tangent, missed or met by little.
            let (s, t) = frame(origin.normalize());
            let phi = rng.range(0.0, TAU);
            let rim = (1.0 - 1.0 / (distance * distance).max(1.0)).sqrt();
            let point = origin / distance.max(1.0).powi(2) + rim * (phi.cos() * s + phi.sin() * t);
            point * (1.0 + rng.log_range(1e-8, 1e-2) * if rng.chance(0.5) { 1.0 } else { -1.0 })
        }
    };
    let length = if rng.chance(0.3) { rng.log_range(1e-3, 1e3) } else { 1.0 };
    let direction = (target - origin).normalize_or(DVec3::X) * length;
    let mut ray = object_ray(SPHERE, index, origin, direction);
    if rng.chance(0.2) {
        ray.t_max = (rng.range(0.0, 2.0) * distance / length) as f32;
    }
    ray
}

#[test]
fn sphere_hits_agree_with_f64() {
    let mut rng = Rng(1);
    let rays: Vec<_> = (0..COUNT).map(|_| random_sphere_ray(&mut rng, 0)).collect();
    let mut decided = 0;
    for (ray, hit) in rays.iter().zip(hit_quadrics(&[whole_sphere()], &rays)) {
        let roots = sphere_roots(&whole_sphere(), ray);
        decided += usize::from(roots.iter().all(|root| root.verdict != Verdict::Either));
        assert_root(&hit, ray, &roots);
    }
    assert!(decided > COUNT / 2, "{decided}");
}

#[test]
fn cut_sphere_hits_agree_with_f64() {
    let mut rng = Rng(2);
    let spheres: Vec<_> = (0..COUNT).map(|_| cut_sphere(&mut rng)).collect();
    let rays: Vec<_> = (0..COUNT).map(|i| random_sphere_ray(&mut rng, i)).collect();
    let mut decided = 0;
    for ((sphere, ray), hit) in spheres.iter().zip(&rays).zip(hit_quadrics(&spheres, &rays)) {
        let roots = sphere_roots(sphere, ray);
        decided += usize::from(roots.iter().all(|root| root.verdict != Verdict::Either));
        assert_root(&hit, ray, &roots);
    }
    assert!(decided > COUNT / 2, "{decided}");
}

/// The error of the distance is a few EPS of the distance, not of its square.
#[test]
fn a_far_origin_costs_no_digits() {
    let mut rng = Rng(3);
    let rays: Vec<_> = (0..COUNT)
        .map(|_| {
            let origin = rng.direction() * rng.log_range(1.0, 1e5);
            object_ray(SPHERE, 0, origin, (0.5 * rng.direction() - origin).normalize())
        })
        .collect();
    for (ray, hit) in rays.iter().zip(hit_quadrics(&[whole_sphere()], &rays)) {
        let o = double(ray.origin);
        // Half the radius away from the axis at most: the chord is not grazing.
        let root = &sphere_roots(&whole_sphere(), ray)[0];
        assert!(o.length() < 1.001 || hit.found == 1, "{ray:?} misses");
        let error = (f64::from(hit.t) - root.t).abs();
        assert!(hit.found == 0 || error <= 16.0 * EPS * (o.length() + 1.0), "{ray:?} is {error:e} off");
    }
}

/// Kernels for scenes with a cut sphere test whole ones for cuts too.
#[test]
fn whole_spheres_and_disks_have_no_hole() {
    let mut rng = Rng(4);
    let mut rays = Vec::new();
    for _ in 0..COUNT {
        let pole = if rng.chance(0.5) { DVec3::Z } else { DVec3::NEG_Z };
        // The pole itself, its surroundings, and the seam of the azimuth.
        let target = match rng.below(4) {
            0 => pole,
            1 => (pole + rng.direction() * rng.log_range(1e-8, 1e-2)).normalize(),
            2 => {
                let z: f64 = rng.range(-1.0, 1.0);
                let seam = rng.log_range(1e-12, 1e-6) * if rng.chance(0.5) { 1.0 } else { -1.0 };
                DVec3::new((1.0 - z * z).sqrt(), seam, z)
            }
            _ => rng.direction(),
        };
        let origin = match rng.below(3) {
            0 => target * rng.range(1.5, 20.0),
            1 => target * rng.range(-0.5, 0.5),
            _ => 0.5 * rng.direction(),
        };
        rays.push(object_ray(SPHERE, 0, origin, (target - origin).normalize()));
    }
    let hits = hit_quadrics(&[whole_sphere()], &rays);
    let missed: Vec<_> = rays.iter().zip(&hits).filter(|(_, hit)| hit.found == 0).collect();
    assert!(missed.is_empty(), "{} rays slip through a whole sphere, as {:?}", missed.len(), missed[0]);

    let axis = |x, y| object_ray(DISK, 0, DVec3::new(x, y, 2.0), DVec3::NEG_Z);
    let rays = [axis(0.0, 0.0), axis(0.5, 0.0), axis(0.5, -1e-30), axis(-0.5, 0.0), axis(0.0, -0.5)];
    assert!(hit_quadrics(&[whole_sphere()], &rays).iter().all(|hit| hit.found == 1 && hit.t == 2.0));
}

fn cut_disk(rng: &mut Rng) -> Quadric {
    let inner_radius = if rng.chance(0.5) { 0.0 } else { rng.range(0.0, 0.99) as f32 };
    let phi_max = if rng.chance(0.3) { TAU } else { rng.range(0.1, TAU) } as f32;
    Quadric { inner_radius, phi_max, ..whole_sphere() }
}

/// t = -o.z / d.z has the error of a division; the point then 3 EPS of its terms.
#[test]
fn disk_hits_agree_with_f64() {
    let mut rng = Rng(5);
    let disks: Vec<_> = (0..COUNT).map(|_| cut_disk(&mut rng)).collect();
    let rays: Vec<_> = (0..COUNT)
        .map(|i| {
            let target = 1.1 * rng.cube(1.0).with_z(0.0);
            let mut origin = target + rng.direction() * rng.log_range(1e-6, 1e3);
            if rng.chance(0.1) {
                origin.z = 0.0;
            }
            let length = if rng.chance(0.3) { rng.log_range(1e-3, 1e3) } else { 1.0 };
            let mut ray = object_ray(DISK, i, origin, (target - origin).normalize() * length);
            ray.t_max = if rng.chance(0.2) { rng.range(0.0, 10.0) as f32 } else { UNBOUNDED };
            ray
        })
        .collect();
    let mut found = 0;
    for ((disk, ray), hit) in disks.iter().zip(&rays).zip(hit_quadrics(&disks, &rays)) {
        let (o, d) = (double(ray.origin), double(ray.direction));
        let t = -o.z / d.z;
        if !t.is_finite() {
            assert_eq!(hit.found, 0, "{ray:?} is in the plane of the disk");
            continue;
        }
        let error = 3.0 * EPS * t.abs();
        let p = o + t * d;
        let place_error = 6.0 * EPS * (o.length() + t.abs() * d.length());
        let in_range = both(above_zero(t, 0.0), above_zero(f64::from(ray.t_max) - t, error));
        let r = p.truncate().length();
        let radius = both(
            above_zero(1.0 - r, place_error + 4.0 * EPS),
            if disk.inner_radius > 0.0 {
                above_zero(r - f64::from(disk.inner_radius), place_error + 4.0 * EPS)
            } else {
                Verdict::Yes
            },
        );
        let verdict = both(in_range, both(radius, cut_verdict(&Quadric { z_min: -1.0, ..*disk }, p, place_error)));
        found += usize::from(hit.found == 1);
        assert_root(&hit, ray, &[Root { t, error, verdict }]);
    }
    assert!(found > COUNT / 5, "{found}");
}
