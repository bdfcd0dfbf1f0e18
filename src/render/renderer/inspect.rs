//! Quantities of each pixel besides radiance: lengths of eye paths, radii, photon densities and normals.

use glam::Vec2;

use super::Renderer;
use crate::kernels::{PixelState, VisiblePoint};
use crate::render::error::RenderError;

impl Renderer {
    /// Returns the length of each pixel's eye path to its visible point in the last iteration, in scene
    /// units; 0 for pixels without a visible point.
    ///
    /// # Errors
    /// The device fails.
    pub fn path_lengths(&self) -> Result<Vec<f32>, RenderError> {
        let throughputs = self.device.read_first_texels(&self.buffers.visible_throughputs, self.settings.pixels())?;
        let scale = self.base.space.scale;
        Ok(throughputs.into_iter().map(|throughput| (f64::from(throughput[3]) / scale) as f32).collect())
    }

    /// Returns the radius of each pixel's visible point in the last iteration, in scene units; 0 for pixels
    /// without a visible point.
    ///
    /// # Errors
    /// The device fails.
    pub fn radii(&self) -> Result<Vec<f32>, RenderError> {
        let squares = self.device.read_first_texels(&self.buffers.visible_radii2, self.settings.pixels())?;
        let scale = self.base.space.scale;
        Ok(squares.into_iter().map(|radius2| (f64::from(radius2).sqrt() / scale) as f32).collect())
    }

    /// Returns the number of photons that each pixel has kept, divided by the area of its disc, in photons
    /// per square scene unit; 0 for pixels without a visible point.
    ///
    /// # Errors
    /// The device fails.
    pub fn photon_densities(&self) -> Result<Vec<f32>, RenderError> {
        let states = self.device.read_first_texels(&self.buffers.pixel_states, self.settings.pixels())?;
        let kept = |state: &PixelState| {
            let found = u64::from(state.found_high) << 32 | u64::from(state.found_low);
            (self.settings.alpha * found as f64) as f32
        };
        let density = |(state, radius): (PixelState, f32)| {
            if radius > 0.0 { kept(&state) / (std::f32::consts::PI * radius * radius) } else { 0.0 }
        };
        Ok(states.into_iter().zip(self.radii()?).map(density).collect())
    }

    /// Returns the normal at each pixel's visible point, on the side of the eye path; 0 for pixels without a
    /// visible point.
    ///
    /// # Errors
    /// The device fails.
    pub fn normals(&self) -> Result<Vec<[f32; 3]>, RenderError> {
        let points = self.device.read_first_texels(&self.buffers.visible_points, self.settings.pixels())?;
        let normal = |(point, length): (VisiblePoint, f32)| {
            if length > 0.0 { unpack_normal(point.normal) } else { [0.0; 3] }
        };
        Ok(points.into_iter().zip(self.path_lengths()?).map(normal).collect())
    }
}

/// Unpacks a unit normal from two 16-bit coordinates, as `shaders/include/geometry/normal.glsl` does.
fn unpack_normal(packed: u32) -> [f32; 3] {
    let coordinate = |bits: u32| f32::from(bits as u16 as i16) / 32767.0;
    let v = Vec2::new(coordinate(packed), coordinate(packed >> 16));
    let z = 1.0 - v.x.abs() - v.y.abs();
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let folded = Vec2::new((1.0 - v.y.abs()) * sign(v.x), (1.0 - v.x.abs()) * sign(v.y));
    (if z < 0.0 { folded } else { v }).extend(z).normalize().to_array()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn normals_are_unpacked_on_both_halves() {
        let pack = |x: f32, y: f32| {
            let word = |v: f32| u32::from((v * 32767.0).round() as i16 as u16);
            word(x) | word(y) << 16
        };
        for (packed, expected) in [
            (pack(0.0, 0.0), Vec3::Z),
            (pack(-1.0, 0.0), Vec3::NEG_X),
            (pack(0.0, 1.0), Vec3::Y),
            (pack(1.0, 1.0), Vec3::NEG_Z),
            (pack(0.25, -0.25), Vec3::new(0.25, -0.25, 0.5).normalize()),
            (pack(0.75, 0.75), Vec3::new(0.25, 0.25, -0.5).normalize()),
        ] {
            assert!(Vec3::from(unpack_normal(packed)).distance(expected) < 1e-4, "{packed:x}");
        }
    }
}
