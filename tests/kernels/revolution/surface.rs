//! surface_at of bodies of revolution: positions, normals and texture coordinates.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3Swizzles};

use crate::fixture::{EPS, Fixture, Rng, double};
use crate::generated::{BodyRay, INDEX_MASK, Met, NONE, RevolutionPiece};
use crate::revolution::lab::Lab;
use crate::revolution::profiles::{self, Profile};
use crate::revolution::rays::Kind;

const COUNT: usize = 4096;

/// Rays at a body after some directives, and what they meet.
fn meet(
    fixture: &Fixture,
    profile: &Profile,
    directives: &str,
    rng: &mut Rng,
    mut each: impl FnMut(&Lab, &BodyRay, &Met),
) {
    let lab = Lab::new(fixture, profile, directives, COUNT, 1e-3);
    let kinds = [Kind::Primary5, Kind::Grazing, Kind::NearHorizontal, Kind::ThroughAxis];
    let rays: Vec<_> = (0..COUNT).map(|i| lab.draw(kinds[i % kinds.len()], rng)).collect();
    let mut found = 0;
    for (ray, met) in rays.iter().zip(lab.meet(&rays)) {
        if met.primitive != NONE {
            found += 1;
            each(&lab, ray, &met);
        }
    }
    assert!(found > COUNT / 10, "{}: {found} of {COUNT} rays meet it", profile.name);
}

/// A point of a piece, as f64 has it.
struct Twin {
    point: DVec2,
    slope: DVec2,
    /// Sizes of the terms of the slope: its error is some EPS of them.
    terms: DVec2,
    chord: f64,
}

impl Twin {
    fn of(piece: &RevolutionPiece, x: f64) -> Self {
        let [u0, v0, u1, v1] = piece.ends.map(f64::from);
        let mut twin = Self {
            point: DVec2::ZERO,
            slope: DVec2::ZERO,
            terms: DVec2::ZERO,
            chord: DVec2::new(u1 - u0, v1 - v0).length(),
        };
        for i in (0..9).rev() {
            let pair = piece.coefficients[i / 2].map(f64::from);
            let c = DVec2::new(pair[2 * (i % 2)], pair[2 * (i % 2) + 1]);
            twin.slope = twin.slope * x + twin.point;
            twin.point = twin.point * x + c;
            twin.terms += i as f64 * c.abs();
        }
        twin
    }
}

/// The radius may be off by both x and y.
fn assert_on_surface(lab: &Lab, met: &Met, twin: &Twin) {
    let to_unit = &lab.subject.unit_from_render;
    let p = to_unit.transform_point3(double(met.position));
    let circle = (twin.point.x * p.truncate().normalize_or(DVec2::X)).extend(twin.point.y);
    let off = (lab.subject.render_from_unit.transform_point3(circle) - double(met.position)).abs();
    let error = f64::from(met.error);
    assert!(off.max_element() <= error, "{met:?} is {off} from its circle");
    // 16 roundings of coordinates up to sqrt(3) and sizes up to 2.
    assert!(error <= 16.0 * EPS * 4.0, "{met:?} has an error of {error:e}");
}

/// Where the profile stands still, any normal will do.
fn assert_normal(lab: &Lab, met: &Met, twin: &Twin, flipped: bool) {
    if twin.slope.length() < 1e-4 * twin.chord {
        return;
    }
    let to_unit = &lab.subject.unit_from_render;
    let out = to_unit.transform_point3(double(met.position)).truncate().normalize_or(DVec2::X);
    let transform = |radial: f64, axial: f64| to_unit.matrix3.transpose() * (radial * out).extend(axial);
    let normal = transform(twin.slope.y, -twin.slope.x);
    let rounding = transform(twin.terms.y, 0.0).length() + transform(0.0, twin.terms.x).length() + normal.length();
    // Horner's rule has two roundings for each of eight terms; the azimuth, known to those of
    // a position at the distance of the radius, turns the normal about the axis.
    let error = 24.0 * EPS * rounding / normal.length() + 16.0 * EPS / twin.point.x.max(1e-3);
    let expected = normal.normalize() * if flipped { -1.0 } else { 1.0 };
    let off = double(met.normal).distance(expected);
    assert!(off <= error, "{met:?} has no normal {expected}, but one {off:e} away");
}

#[test]
fn positions_and_normals_are_those_of_the_profile() {
    let fixture = Fixture::new();
    let mut rng = Rng(1);
    for profile in profiles::all(&mut Rng(2)) {
        meet(&fixture, &profile, "", &mut rng, |lab, _, met| {
            let piece = &lab.world.revolution_pieces[(met.primitive & INDEX_MASK) as usize];
            let twin = Twin::of(piece, met.x.into());
            assert_on_surface(lab, met, &twin);
            assert_normal(lab, met, &twin, false);
        });
    }
}

#[test]
fn positions_are_where_rays_meet_the_surface() {
    let fixture = Fixture::new();
    let mut rng = Rng(3);
    for profile in profiles::all(&mut Rng(2)) {
        meet(&fixture, &profile, "", &mut rng, |_, ray, met| {
            let (o, d) = (double(ray.origin), double(ray.direction));
            let cosine = double(met.normal).dot(d.normalize()).abs();
            let off = (o + f64::from(met.t) * d).distance(double(met.position));
            // Distances are right to 5e-6 where the ray does not graze; the point is as far
            // off along the surface.
            assert!(cosine < 0.01 || off <= 1e-5, "{ray:?} meets {met:?}, {off:e} away from itself");
        });
    }
}

/// As quadrics: the side that runs up has its normal outside, unless one of both turns it.
#[test]
fn orientation_and_mirrors_turn_normals() {
    let fixture = Fixture::new();
    let mut rng = Rng(4);
    let transforms = [
        ("Rotate 40 1 2 3 Scale 1 2 0.5", false),
        ("ReverseOrientation", true),
        ("Scale -1 1 1", true),
        ("Rotate 20 1 0 2 Scale 2 1 -1", true),
        ("ReverseOrientation Scale 1 1 -1", false),
    ];
    for (directives, flipped) in transforms {
        for profile in profiles::reference() {
            meet(&fixture, &profile, directives, &mut rng, |lab, _, met| {
                let piece = &lab.world.revolution_pieces[(met.primitive & INDEX_MASK) as usize];
                assert_normal(lab, met, &Twin::of(piece, met.x.into()), flipped);
            });
        }
    }
    let cylinder = Profile::new("cylinder", 1, &[[0.5, -1.0], [0.5, 1.0]]);
    meet(&fixture, &cylinder, "", &mut rng, |_, _, met| {
        let outside = double(met.position).truncate().dot(double(met.normal).truncate());
        assert!(outside > 0.0, "{met:?} looks inside");
    });
}

/// The second coordinate runs along all segments of the profile; the first around it from the
/// x axis, as well as an arc tangent is known: 4096 units in the last place of pi.
#[test]
fn texture_coordinates_are_along_the_profile_and_around_the_axis() {
    let fixture = Fixture::new();
    let mut rng = Rng(5);
    for profile in profiles::reference() {
        let curves = profile.curves();
        meet(&fixture, &profile, "", &mut rng, |lab, _, met| {
            let [around, along] = met.uv.map(f64::from);
            let place = along * curves.len() as f64;
            let segment = (place as usize).min(curves.len() - 1);
            let point = curves[segment].at(place - segment as f64);
            // Render space is scaled about the middle of the body's box.
            let p = lab.render_from_world.transform_point3(point.extend(0.0).xzy());
            let radius = double(met.position).truncate().length();
            let off = (p.x - radius).abs().max((p.z - f64::from(met.position[2])).abs());
            assert!(off <= 2e-6 * curves.len() as f64, "{met:?}: {p} is {off:e} away");
            let azimuth = DVec3::from(met.position.map(f64::from)).truncate().to_angle().rem_euclid(TAU);
            let off = (around * TAU - azimuth).abs();
            assert!(off.min(TAU - off) <= 4096.0 * 2.0 * EPS * TAU, "{met:?} is at azimuth {azimuth}");
        });
    }
}
