//! Textures, resolved: a directed graph without cycles in [`crate::scene::Scene::textures`].

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::image::film::Image;
use crate::scene::model::input::{Input, Rgb};

/// A value that varies over surfaces. A texture of numbers has its number in all channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// What it does. What it is made of comes before it in [`crate::scene::Scene::textures`].
    pub kind: TextureKind,
    /// `file:line:column` of the directive, for messages.
    pub location: String,
}

/// The classes of pbrt's textures.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureKind {
    /// `imagemap`.
    Image(ImageTexture),
    /// `bilerp`: linear in both coordinates, and goes on beyond 0 and 1.
    Bilerp {
        /// To the coordinates.
        mapping: Mapping,
        /// The values at (0, 0), (1, 0), (0, 1) and (1, 1).
        corners: [Rgb; 4],
    },
    /// `checkerboard`: unit squares or cubes.
    Checkerboard {
        /// To the coordinates; where the third is 0, the board is flat.
        mapping: Mapping,
        /// At the origin, and beside it.
        textures: [Input<Rgb>; 2],
    },
    /// `directionmix`.
    DirectionMix {
        /// Unit length, world space.
        direction: DVec3,
        /// Where the normal is along the direction, and where it is across.
        textures: [Input<Rgb>; 2],
    },
    /// `mix`.
    Mix {
        /// At an amount of 0 and of 1.
        textures: [Input<Rgb>; 2],
        /// Not clamped.
        amount: Input<f64>,
    },
    /// `scale`.
    Scale {
        /// What is scaled.
        texture: Input<Rgb>,
        /// By this.
        factor: Input<f64>,
    },
}

impl TextureKind {
    /// The textures that it is made of.
    pub(in crate::scene) fn inputs(&self) -> Vec<usize> {
        fn index<T>(input: &Input<T>) -> Option<usize> {
            match input {
                Input::Constant(_) => None,
                Input::Texture(index) => Some(*index),
            }
        }
        let (textures, number) = match self {
            Self::Image(_) | Self::Bilerp { .. } => return Vec::new(),
            Self::Checkerboard { textures, .. } | Self::DirectionMix { textures, .. } => (&textures[..], None),
            Self::Mix { textures, amount } => (&textures[..], Some(amount)),
            Self::Scale { texture, factor } => (std::slice::from_ref(texture), Some(factor)),
        };
        textures.iter().filter_map(index).chain(number.and_then(index)).collect()
    }
}

/// An image on a surface. Coordinates (0, 0) are its lower left corner, (1, 1) its upper right.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageTexture {
    /// Linear RGB; for a texture of numbers, grey.
    pub image: Arc<Image>,
    /// To the coordinates.
    pub mapping: Mapping,
    /// What is beyond the edges.
    pub wrap: Wrap,
    /// Whether the nearest pixel is taken; else four are interpolated.
    pub nearest: bool,
    /// The value is this plus `factor` times the image's, within `range`.
    pub offset: f64,
    /// See `offset`.
    pub factor: f64,
    /// The least and the largest value.
    pub range: [f64; 2],
}

impl ImageTexture {
    /// The mean over the image.
    pub(in crate::scene) fn mean(&self) -> Rgb {
        let [least, most] = self.range.map(Rgb::splat);
        let value = |pixel: &[f32; 3]| (self.offset + self.factor * Rgb::from(pixel.map(f64::from))).clamp(least, most);
        self.image.pixels.iter().map(value).sum::<Rgb>() / self.image.pixels.len() as f64
    }
}

/// What an image has beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// Itself again.
    Repeat,
    /// The pixels of its edge.
    Clamp,
    /// Black.
    Black,
}

/// How a point of a surface becomes texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mapping {
    /// From the surface's own coordinates (u, v, 0).
    Surface(DAffine3),
    /// From the place in world space.
    Space(DAffine3),
    /// Polar angle over π and azimuth over 2π, after a transform from world space.
    Spherical(DAffine3),
    /// Azimuth from the negative x axis over 2π and height, after a transform from world space.
    Cylindrical(DAffine3),
}
