//! Means of textures, for values that must be constant.

use std::collections::HashMap;

use crate::base::input::{Budget, OverBudget};
use crate::scene::model::texture::{Octaves, Texture, TextureKind};
use crate::scene::model::{Input, Rgb};

/// Share of the area that the discs of `dots` cover: 25,832 of the 256 x 256 cells of the noise have one.
const DOTS_SHARE: f64 = 0.151_692;
/// Mean magnitude of noise, within 0.0004.
const NOISE_MAGNITUDE: f64 = 0.2179;
/// Mean colour of `marble` over all phases of the sine.
const MARBLE_MEAN: Rgb = Rgb::new(0.804_635, 0.802_959, 0.839_813);

/// Means of textures computed so far, by their indices: textures may share inputs.
#[derive(Debug, Default)]
pub(in crate::scene) struct Means {
    known: HashMap<usize, Rgb>,
}

impl Means {
    /// Returns the mean of a texture. Parts that are multiplied or mixed count as independent.
    ///
    /// # Errors
    /// The images read so far have more pixels than the budget allows to be read.
    pub fn of(&mut self, index: usize, textures: &[Texture], budget: &Budget) -> Result<Rgb, OverBudget> {
        // A stack of the textures to compute: a recursion could be too deep.
        let mut wanted = vec![index];
        while let Some(index) = wanted.last().copied() {
            let kind = &textures[index].kind;
            let unknown = kind.inputs().into_iter().filter(|input| !self.known.contains_key(input));
            let before = wanted.len();
            wanted.extend(unknown);
            if wanted.len() == before {
                wanted.pop();
                let mean = self.mean_of_parts(kind, budget)?;
                self.known.insert(index, mean);
            }
        }
        Ok(self.mean(&Input::Texture(index)))
    }

    /// Returns the mean of an input whose mean is known.
    fn mean(&self, input: &Input<Rgb>) -> Rgb {
        match input {
            Input::Constant(value) => *value,
            Input::Texture(index) => self.known.get(index).copied().unwrap_or_default(),
        }
    }

    /// Returns the mean of a texture whose inputs have known means.
    fn mean_of_parts(&self, kind: &TextureKind, budget: &Budget) -> Result<Rgb, OverBudget> {
        let number = |input: &Input<f64>| self.mean(&as_color(*input));
        Ok(match kind {
            TextureKind::Image(image) => {
                budget.read(size_of_val(&image.image.pixels[..]) as u64)?;
                image.mean()
            }
            TextureKind::Bilerp { corners, .. } => corners.iter().sum::<Rgb>() / 4.0,
            TextureKind::Checkerboard { textures: [a, b], .. } | TextureKind::DirectionMix { textures: [a, b], .. } => {
                0.5 * (self.mean(a) + self.mean(b))
            }
            TextureKind::Mix { textures: [a, b], amount } => {
                let (a, b) = (self.mean(a), self.mean(b));
                a + number(amount) * (b - a)
            }
            TextureKind::Scale { texture, factor } => self.mean(texture) * number(factor),
            TextureKind::Dots { textures: [inside, outside], .. } => {
                self.mean(outside).lerp(self.mean(inside), DOTS_SHARE)
            }
            // The noise is as often positive as negative.
            TextureKind::Fbm { .. } | TextureKind::Windy { .. } => Rgb::ZERO,
            TextureKind::Wrinkled { octaves, .. } => Rgb::splat(wrinkled_mean(octaves)),
            TextureKind::Marble { .. } => MARBLE_MEAN,
        })
    }
}

/// Mean of a `wrinkled` texture: each octave has the mean magnitude of noise.
fn wrinkled_mean(octaves: &Octaves) -> f64 {
    let weights =
        (0..octaves.count).scan(1.0, |weight, _| Some(std::mem::replace(weight, *weight * octaves.roughness)));
    NOISE_MAGNITUDE * weights.sum::<f64>() + 0.2 * octaves.roughness.powi(octaves.count as i32)
}

/// Returns an input of numbers as an input of grey colours.
pub(in crate::scene) fn as_color(input: Input<f64>) -> Input<Rgb> {
    match input {
        Input::Constant(value) => Input::Constant(Rgb::splat(value)),
        Input::Texture(index) => Input::Texture(index),
    }
}
