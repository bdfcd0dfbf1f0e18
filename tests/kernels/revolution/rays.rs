//! Rays of every kind, in the render space of a body about the z axis.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::fixture::{Rng, double, single};
use crate::revolution::oracle::Oracle;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Primary5,
    Primary100,
    /// Made on the device, where a ray of the kind before meets glass.
    Refracted,
    Grazing,
    NearHorizontal,
    Horizontal,
    Parallel,
    ThroughAxis,
    OnAxis,
}

pub const KINDS: [Kind; 9] = [
    Kind::Primary5,
    Kind::Primary100,
    Kind::Refracted,
    Kind::Grazing,
    Kind::NearHorizontal,
    Kind::Horizontal,
    Kind::Parallel,
    Kind::ThroughAxis,
    Kind::OnAxis,
];

/// The body's box: radius and half height.
#[derive(Clone, Copy)]
pub struct Extent {
    pub radius: f64,
    pub height: f64,
}

/// Origin and direction.
type Ray = (DVec3, DVec3);

impl Extent {
    fn inside(&self, rng: &mut Rng) -> DVec3 {
        rng.cube(1.0) * DVec3::new(self.radius, self.radius, self.height)
    }
}

/// A ray of a kind at a body.
pub fn draw(kind: Kind, rng: &mut Rng, extent: &Extent, oracle: &Oracle) -> Ray {
    let target = extent.inside(rng);
    // From outside, not too far: what fp32 knows of the direction is not the matter.
    let near = rng.range(1.0, 4.0);
    match kind {
        Kind::Primary5 | Kind::Refracted => towards(target, rng.direction(), 5.0),
        Kind::Primary100 => towards(target, rng.direction(), 100.0),
        Kind::Grazing => grazing(rng, oracle),
        Kind::NearHorizontal => {
            let rise = rng.log_range(1e-6, 1e-1) * if rng.chance(0.5) { 1.0 } else { -1.0 };
            towards(target, around(rng).extend(rise).normalize(), near)
        }
        Kind::Horizontal => {
            // Heights where pieces meet and profiles turn too.
            let target = if rng.chance(0.3) { target.with_z(oracle.end(rng)[1]) } else { target };
            towards(target, around(rng).extend(0.0), near)
        }
        Kind::Parallel => {
            let tilt = if rng.chance(0.5) { 0.0 } else { rng.log_range(1e-20, 1e-7) };
            let up = if rng.chance(0.5) { 1.0 } else { -1.0 };
            // Radii where pieces meet too.
            let target = if rng.chance(0.3) { DVec3::X * oracle.end(rng)[0] } else { target };
            towards(target, (tilt * around(rng)).extend(up), near)
        }
        Kind::ThroughAxis => through_axis(rng, target.z),
        Kind::OnAxis => {
            let up = if rng.chance(0.5) { 1.0 } else { -1.0 };
            let start = if rng.chance(0.2) { target.z } else { -up * near };
            (DVec3::Z * start, DVec3::Z * up * if rng.chance(0.5) { 1.0 } else { near })
        }
    }
}

fn around(rng: &mut Rng) -> DVec2 {
    DVec2::from_angle(rng.range(0.0, TAU))
}

/// From `distance` away from a point, through it as well as fp32 can.
fn towards(target: DVec3, direction: DVec3, distance: f64) -> Ray {
    let direction = double(single(direction));
    (target - distance * direction, direction)
}

/// Nearly along a tangent of the body.
fn grazing(rng: &mut Rng, oracle: &Oracle) -> Ray {
    let azimuth = around(rng);
    let (point, along) = oracle.tangent(rng, azimuth);
    let across = DVec3::new(-azimuth.y, azimuth.x, 0.0);
    let turn = DVec2::from_angle(rng.range(0.0, TAU));
    let normal = along.cross(across);
    let angle = rng.log_range(1e-5, 1e-1) * if rng.chance(0.5) { 1.0 } else { -1.0 };
    let direction = (turn.x * along + turn.y * across + angle * normal).normalize();
    towards(point, direction, rng.log_range(0.1, 5.0))
}

/// Half of them exactly: the origin is a multiple of the direction away from the axis.
fn through_axis(rng: &mut Rng, height: f64) -> Ray {
    let direction = double(single(rng.direction()));
    if rng.chance(0.5) {
        return towards(DVec3::Z * height, direction, rng.range(1.0, 5.0));
    }
    let distance = [1.0, 2.0, 4.0][rng.below(3)];
    (DVec3::Z * height - distance * direction, direction)
}
