//! `Shape "cylinder"`.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::geometry::bezier::Curve;
use crate::scene::directives::shape::phi_max;
use crate::scene::format::error::SceneError;
use crate::scene::format::params::ParamList;
use crate::scene::model::{Geometry, Mesh, Profile};

/// Number of sectors of a whole turn for a partial cylinder: the distance of its sides from the cylinder is
/// 2e-5 of the radius.
const SECTORS: f64 = 512.0;

/// Returns a cylinder: a body of revolution with a straight profile, or, for a partial turn, a mesh with
/// the cylinder's normals.
pub(in crate::scene) fn geometry(params: &ParamList) -> Result<Geometry, SceneError> {
    let radius = params.positive("radius", 1.0)?;
    let z0 = params.float("zmin")?.unwrap_or(-1.0);
    let z1 = params.float("zmax")?.unwrap_or(1.0);
    if let Some(param) = params.get("zmax").or(params.get("zmin")).filter(|_| z0 == z1) {
        return Err(param.bad_value("heights that differ"));
    }
    let (z_min, z_max) = (z0.min(z1), z0.max(z1));
    let phi_max = phi_max(params)?;
    if phi_max < TAU {
        return Ok(Geometry::Mesh(Arc::new(sector(radius, [z_min, z_max], phi_max))));
    }
    // The profile runs upward, so that it faces away from the axis.
    let points = vec![DVec2::new(radius, z_min), DVec2::new(radius, z_max)];
    Ok(Geometry::Revolution(Arc::new(Profile { segments: vec![Curve { points }] })))
}

fn sector(radius: f64, heights: [f64; 2], phi_max: f64) -> Mesh {
    let sectors = (SECTORS * phi_max / TAU).ceil() as u32;
    let mut mesh = Mesh::default();
    for i in 0..=sectors {
        let u = f64::from(i) / f64::from(sectors);
        let azimuth = DVec2::from_angle(phi_max * u);
        for (v, height) in [0.0, 1.0].into_iter().zip(heights) {
            mesh.positions.push((radius * azimuth).extend(height));
            mesh.normals.push(DVec3::new(azimuth.x, azimuth.y, 0.0));
            mesh.uvs.push(DVec2::new(u, v));
        }
    }
    for i in 0..sectors {
        let [a, b, c, d] = [0, 2, 3, 1].map(|corner| 2 * i + corner);
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}
