//! Writes meshes and rays for another renderer, in render units: little-endian f32 without a header.

use std::fs;
use std::path::Path;

use bytemuck::cast_slice;
use goblet::Device;

use crate::Result;
use crate::prepare::Prepared;
use crate::sets::{Rays, Set};

/// Writes `SCENE.triangles`, three corners for each triangle, and for each set `SCENE.SET.rays`: origin,
/// t_max, direction and a zero for each ray. A scene that has more than triangles is left out.
pub fn write(device: &Device, scene: &Prepared, count: u64, folder: &Path) -> Result<()> {
    let Some(mesh) = &scene.mesh else { return Ok(()) };
    fs::create_dir_all(folder)?;
    let corners: Vec<[[f32; 3]; 3]> = mesh.iter().map(|triangle| [triangle.p0, triangle.p1, triangle.p2]).collect();
    fs::write(folder.join(format!("{}.triangles", scene.name)), little_endian(cast_slice(&corners)))?;
    for set in Set::ALL {
        if let Some(rays) = Rays::new(device, scene, set, count)? {
            let rays = device.read_texels(&rays.texels)?;
            let path = folder.join(format!("{}.{}.rays", scene.name, set.name()));
            fs::write(path, little_endian(cast_slice(&rays)))?;
        }
    }
    Ok(())
}

fn little_endian(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}
