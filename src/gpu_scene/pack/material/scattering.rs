//! Tables of coats that scatter light, as `shaders/include/material/coat_table.glsl` reads them.

use super::coat::thickness_at;
use super::slab::{Grid, Layer, MOST_G, Medium, Response};
use crate::kernels::{COAT_ALBEDOS, COAT_OCTAVES, COAT_PHASES, COAT_STEPS};
use crate::scene::{Coat, Input, Rgb, Scattering};

/// Returns the table of a coat with GGX's alpha of its boundary. Its entries are by thickness, within them by albedo, and within them by g. There is
/// one entry where a value is constant; three for a constant albedo, of each channel.
pub(super) fn table(coat: &Coat, alpha: f64, scattering: &Scattering) -> Vec<[u32; 4]> {
    let grid = Grid::new(coat.eta.mean, alpha);
    let albedos: Vec<f64> = match scattering.albedo {
        Input::Constant(albedo) => albedo.to_array().to_vec(),
        Input::Texture(_) => (0..COAT_ALBEDOS).map(albedo_at).collect(),
    };
    let phases: Vec<f64> = match scattering.g {
        Input::Constant(g) => vec![g],
        Input::Texture(_) => (0..COAT_PHASES).map(g_at).collect(),
    };
    let mut elements = Vec::new();
    for g in phases {
        let mut before: Option<(f64, Vec<Response>)> = None;
        for albedo in &albedos {
            // Grey coats are computed once.
            let row = match before {
                Some((same, row)) if same == *albedo => row,
                _ => row(&grid, coat.thickness, *albedo, g),
            };
            elements.extend(row.iter().flat_map(packed));
            before = Some((*albedo, row));
        }
    }
    elements
}

/// Returns a key that tells tables apart: the same for the same table.
pub(super) fn key(coat: &Coat, alpha: f64, scattering: &Scattering) -> Vec<u64> {
    let mut key = vec![coat.eta.mean.to_bits(), alpha.to_bits()];
    let mut add = |values: Option<&[f64]>| {
        key.push(values.map_or(0, |values| values.len() as u64));
        key.extend(values.into_iter().flatten().map(|value| value.to_bits()));
    };
    fn constant<T: Copy>(input: Input<T>) -> Option<T> {
        match input {
            Input::Constant(value) => Some(value),
            Input::Texture(_) => None,
        }
    }
    add(constant(coat.thickness).map(|value| [value]).as_ref().map(|value| &value[..]));
    add(constant(scattering.albedo).map(|value: Rgb| value.to_array()).as_ref().map(|value| &value[..]));
    add(constant(scattering.g).map(|value| [value]).as_ref().map(|value| &value[..]));
    key
}

/// Returns an albedo of a table: near 1, the reflectance of a thick layer grows with its square root.
fn albedo_at(i: u32) -> f64 {
    let root = 1.0 - f64::from(i) / f64::from(COAT_ALBEDOS - 1);
    1.0 - root * root
}

fn g_at(i: u32) -> f64 {
    MOST_G * (2.0 * f64::from(i) / f64::from(COAT_PHASES - 1) - 1.0)
}

/// Returns what coats of one albedo do, by their thickness.
fn row(grid: &Grid, thickness: Input<f64>, albedo: f64, g: f64) -> Vec<Response> {
    let layer = |thickness| grid.layer(Medium { thickness, albedo, g });
    if let Input::Constant(thickness) = thickness {
        return vec![grid.response(&layer(thickness))];
    }
    // Layers that are an octave apart follow by doubling.
    let octaves = |step: u32| {
        let first: Layer = layer(thickness_at(1 + step));
        std::iter::successors(Some(first), |layer| Some(layer.doubled())).take(COAT_OCTAVES as usize + 1)
    };
    let steps: Vec<Vec<Response>> =
        (0..COAT_STEPS).map(|step| octaves(step).map(|layer| grid.response(&layer)).collect()).collect();
    let rest = (0..COAT_OCTAVES * COAT_STEPS + 1).map(|i| steps[(i % COAT_STEPS) as usize][(i / COAT_STEPS) as usize]);
    std::iter::once(grid.response(&layer(0.0))).chain(rest).collect()
}

fn packed(coat: &Response) -> [[u32; 4]; 3] {
    let ([a, b, c], [d, e, f]) = (coat.from_base, coat.scattered);
    let elements = [[a, b, c, coat.sent_back], [d, e, f, coat.leaving], [coat.mean_scattered, 0.0, 0.0, 0.0]];
    elements.map(|element| element.map(|value| (value as f32).to_bits()))
}
