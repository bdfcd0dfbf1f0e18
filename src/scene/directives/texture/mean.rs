//! Means of textures, for values that must be constant.

use std::collections::HashMap;

use crate::base::input::{Budget, OverBudget};
use crate::scene::model::texture::{Texture, TextureKind};
use crate::scene::model::{Input, Rgb};

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
        })
    }
}

/// Returns an input of numbers as an input of grey colours.
pub(in crate::scene) fn as_color(input: Input<f64>) -> Input<Rgb> {
    match input {
        Input::Constant(value) => Input::Constant(Rgb::splat(value)),
        Input::Texture(index) => Input::Texture(index),
    }
}
