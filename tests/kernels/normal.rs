//! pack_normal, unpack_normal: 32 bits hold a unit vector to 6.5e-5 radians.

use glam::DVec3;

use crate::fixture::{Fixture, Rng, double, single};
use crate::generated::RoundNormals;

/// Half a step of 16-bit snorm.
const HALF_STEP: f64 = 0.5 / 32767.0;

fn round_trip(normals: &[[f32; 3]]) -> Vec<DVec3> {
    let fixture = Fixture::new();
    let padded: Vec<_> = normals.iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
    let (normals, back) = (fixture.upload(&padded), fixture.output::<[f32; 4]>(padded.len()));
    fixture.run(&RoundNormals { normals: &normals, back: &back }, padded.len());
    fixture.read(&back).into_iter().map(|[x, y, z, _]| double([x, y, z])).collect()
}

/// Rounding moves a point of the octahedron by up to (h, h, 2h): sqrt(6) h in its face,
/// which is at least 1 / sqrt(3) from the centre. That is sqrt(18) h = 6.48e-5 radians.
#[test]
fn packed_normals_are_off_by_at_most_6_5e_5_radians() {
    let bound = 18.0_f64.sqrt() * HALF_STEP + 3e-7;
    let mut rng = Rng(1);
    let normals: Vec<_> = (0..1_000_000)
        .map(|i| {
            let mut n = rng.direction();
            if i % 4 == 0 {
                // Near an axis or an edge of the octahedron.
                let tiny = rng.log_range(1e-9, 1e-2);
                let axis = rng.below(3);
                n[axis] *= tiny;
                n[(axis + 1) % 3] *= if rng.chance(0.5) { tiny } else { 1.0 };
            }
            single(n.normalize())
        })
        .collect();
    let mut worst = 0.0_f64;
    for (normal, back) in normals.iter().zip(round_trip(&normals)) {
        let angle = double(*normal).cross(back).length();
        assert!(double(*normal).dot(back) > 0.0 && angle <= bound, "{normal:?} comes back as {back}");
        assert!((back.length() - 1.0).abs() < 3e-7, "{back} is no unit vector");
        worst = worst.max(angle);
    }
    assert!(worst > 0.8 * bound, "the bound {bound} is loose: {worst}");
}

#[test]
fn axes_and_diagonals_survive_packing() {
    let mut normals = Vec::new();
    for x in [-1.0, -0.0, 0.0, 1.0] {
        for y in [-1.0, -0.0, 0.0, 1.0] {
            for z in [-1.0, -0.0, 0.0, 1.0] {
                let n = DVec3::new(x, y, z);
                if n != DVec3::ZERO {
                    normals.push(single(n.normalize()));
                }
            }
        }
    }
    for (normal, back) in normals.iter().zip(round_trip(&normals)) {
        let zeros = normal.iter().filter(|component| **component == 0.0).count();
        // Axes fall on grid points; of the others half a step can be lost.
        let bound = if zeros == 2 { 1e-7 } else { 6.5e-5 };
        assert!(back.distance(double(*normal)) <= bound, "{normal:?} comes back as {back}");
    }
}
