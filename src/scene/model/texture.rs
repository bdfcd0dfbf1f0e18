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
    /// `dots`: at most one disc, of a radius of 0.35, in each unit square.
    Dots {
        /// Map to the texture coordinates.
        mapping: Mapping,
        /// Textures in the discs, and around them.
        textures: [Input<Rgb>; 2],
    },
    /// `fbm`: the sum of octaves of noise.
    Fbm {
        /// Map to the coordinates of the noise.
        mapping: Mapping,
        /// The octaves.
        octaves: Octaves,
    },
    /// `wrinkled`: the sum of the magnitudes of octaves, and 0.2 times the weight of the next one.
    Wrinkled {
        /// Map to the coordinates of the noise.
        mapping: Mapping,
        /// The octaves.
        octaves: Octaves,
    },
    /// `windy`: six octaves of waves, times the magnitude of three octaves that are ten times as coarse. Both
    /// have a roughness of 0.5.
    Windy {
        /// Map to the coordinates of the waves.
        mapping: Mapping,
    },
    /// `marble`: a colour by the sine of y plus noise, where y is the second coordinate.
    Marble {
        /// Map to the coordinates of the noise, which `scale` has multiplied.
        mapping: Mapping,
        /// The octaves of the noise.
        octaves: Octaves,
        /// Factor of the noise, in radians.
        variation: f64,
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
            Self::Image(_)
            | Self::Bilerp { .. }
            | Self::Fbm { .. }
            | Self::Wrinkled { .. }
            | Self::Windy { .. }
            | Self::Marble { .. } => return Vec::new(),
            Self::Checkerboard { textures, .. } | Self::DirectionMix { textures, .. } | Self::Dots { textures, .. } => {
                (&textures[..], None)
            }
            Self::Mix { textures, amount } => (&textures[..], Some(amount)),
            Self::Scale { texture, factor } => (std::slice::from_ref(texture), Some(factor)),
        };
        textures.iter().filter_map(index).chain(number.and_then(index)).collect()
    }
}

/// A sum of gradient noise. The coordinates of each octave are 1.99 times those of the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octaves {
    /// Number of octaves, 0 to [`Octaves::MOST`].
    pub count: u32,
    /// Weight of an octave over that of the one before; the first one has a weight of 1.
    pub roughness: f64,
}

impl Octaves {
    /// Maximum number of octaves. The last one has 1.99^15, about 30,000, times the frequency of the first.
    pub const MOST: u32 = 16;
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
