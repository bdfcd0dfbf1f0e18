//! Resolved textures: a directed graph without cycles in [`crate::scene::Scene::textures`].

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::image::film::Image;
use crate::scene::model::input::{Input, Rgb};

/// A value that varies over surfaces. A texture of numbers has its number in all three channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The function. The textures that it uses come before it in [`crate::scene::Scene::textures`].
    pub kind: TextureKind,
    /// `file:line:column` of the directive, for messages.
    pub location: String,
}

/// The classes of pbrt's textures.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureKind {
    /// `imagemap`.
    Image(ImageTexture),
    /// `bilerp`: linear in both coordinates, also outside of [0, 1].
    Bilerp {
        /// Map to the texture coordinates.
        mapping: Mapping,
        /// The values at (0, 0), (1, 0), (0, 1) and (1, 1).
        corners: [Rgb; 4],
    },
    /// `checkerboard`: unit squares or cubes.
    Checkerboard {
        /// Map to the texture coordinates; if it gives a third coordinate of 0, the board is
        /// two-dimensional.
        mapping: Mapping,
        /// Textures of the cell at the origin, and of its neighbours.
        textures: [Input<Rgb>; 2],
    },
    /// `directionmix`.
    DirectionMix {
        /// Direction in world space, unit length.
        direction: DVec3,
        /// Textures where the normal is parallel to the direction, and where it is perpendicular.
        textures: [Input<Rgb>; 2],
    },
    /// `mix`.
    Mix {
        /// Textures at an amount of 0 and of 1.
        textures: [Input<Rgb>; 2],
        /// Weight of the second texture; not clamped.
        amount: Input<f64>,
    },
    /// `scale`.
    Scale {
        /// The texture that is scaled.
        texture: Input<Rgb>,
        /// Its factor.
        factor: Input<f64>,
    },
}

impl TextureKind {
    /// Returns the indices of the textures that the function uses.
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

/// An image on a surface. Coordinates (0, 0) are the lower left corner, (1, 1) the upper right.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageTexture {
    /// Pixels in linear RGB; grey for a texture of numbers.
    pub image: Arc<Image>,
    /// Map to the texture coordinates.
    pub mapping: Mapping,
    /// The value outside of the image.
    pub wrap: Wrap,
    /// Whether the value is the nearest pixel; otherwise four pixels are interpolated.
    pub nearest: bool,
    /// Offset of the value, which is `offset + factor * pixel`, clamped to `range`.
    pub offset: f64,
    /// Factor of the pixel; see `offset`.
    pub factor: f64,
    /// Minimum and maximum of the value.
    pub range: [f64; 2],
}

impl ImageTexture {
    /// Returns the mean value over the image.
    pub(in crate::scene) fn mean(&self) -> Rgb {
        let [least, most] = self.range.map(Rgb::splat);
        let value = |pixel: &[f32; 3]| (self.offset + self.factor * Rgb::from(pixel.map(f64::from))).clamp(least, most);
        self.image.pixels.iter().map(value).sum::<Rgb>() / self.image.pixels.len() as f64
    }
}

/// The value of an image outside of its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The image repeats.
    Repeat,
    /// The nearest pixel of the edge.
    Clamp,
    /// Black.
    Black,
}

/// Map from a point of a surface to texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mapping {
    /// Affine transform of the surface's own coordinates (u, v, 0).
    Surface(DAffine3),
    /// Affine transform of the position in world space.
    Space(DAffine3),
    /// Polar angle over π and azimuth over 2π, after a transform from world space.
    Spherical(DAffine3),
    /// Azimuth from the negative x axis over 2π and height, after a transform from world space.
    Cylindrical(DAffine3),
}
