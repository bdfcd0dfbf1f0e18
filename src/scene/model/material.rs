//! How surfaces scatter light.

use std::sync::Arc;

use crate::scene::model::{Index, Input, Measured, Rgb};

/// Roughness of a surface of microfacets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// Roughness along the direction in which the first texture coordinate grows; 0 or more.
    pub u: Input<f64>,
    /// Roughness along the direction in which the second texture coordinate grows; 0 or more.
    pub v: Input<f64>,
    /// Whether the values are perceptual: then their square roots are the slopes of the microfacets (GGX's
    /// alpha), as in pbrt.
    pub remap: bool,
}

impl Roughness {
    /// The roughness of a smooth surface.
    pub const SMOOTH: Self = Self { u: Input::Constant(0.0), v: Input::Constant(0.0), remap: false };
    /// Smallest alpha of a rough surface: a surface with a smaller alpha along both directions is smooth,
    /// as in pbrt.
    pub const LEAST_ALPHA: f64 = 1e-3;

    /// Returns GGX's alpha for a value of the roughness.
    pub fn alpha(&self, value: f64) -> f64 {
        if self.remap { value.sqrt() } else { value }
    }

    /// Returns true if the surface is smooth: both values are constants with an alpha below
    /// [`Self::LEAST_ALPHA`]. A roughness from a texture is never smooth.
    pub fn is_smooth(&self) -> bool {
        let is_small = |input| matches!(input, Input::Constant(value) if self.alpha(value) < Self::LEAST_ALPHA);
        is_small(self.u) && is_small(self.v)
    }
}

/// The reflectance of a metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Metal {
    /// Optical constants per channel.
    Index {
        /// Real part of the index of refraction.
        eta: Rgb,
        /// Absorption coefficient.
        k: Rgb,
    },
    /// Reflectance at normal incidence, 0 to 1. A constant reflectance is converted to [`Metal::Index`].
    Reflectance(Input<Rgb>),
}

/// A clear coat of varnish.
#[derive(Clone, Debug, PartialEq)]
pub struct Coat {
    /// Index of refraction of the coat over the index outside.
    pub eta: Index,
    /// Thickness in mean free paths, 0 or more; negative values of a texture are clamped.
    pub thickness: Input<f64>,
    /// Share of the extinguished light that is absorbed, 0 to 1; the rest goes straight on. Light that crosses
    /// the coat perpendicularly is multiplied by exp(-thickness * absorbed).
    pub absorbed: f64,
    /// Scattering inside, if there is any; then `absorbed` is 1, and is not used.
    pub scattering: Option<Scattering>,
    /// Roughness of the coat's outer surface.
    pub roughness: Roughness,
}

/// What bends the shading normals of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bump {
    /// Height of the surface above its shape along the normal, in scene units: the index of a texture of numbers.
    /// The normals are those of the raised surface (Blinn 1978).
    Displacement(usize),
    /// The normal itself, of any length: the index of a texture. Its x is along the derivative of the position by
    /// u, its z along the surface's shading normal, and x, y, z are right-handed.
    NormalMap(usize),
}

/// The scattering inside of a coat, by Henyey and Greenstein's phase function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattering {
    /// Share of the extinguished light that is scattered, 0 to 1; values of a texture outside that range are clamped.
    pub albedo: Input<Rgb>,
    /// Mean cosine of the angle of scattering, -1 to 1; 0 scatters to all directions alike.
    pub g: Input<f64>,
}

/// How a surface scatters light.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Lambertian reflection.
    Diffuse {
        /// Albedo per channel, 0 to 1; values of a texture outside that range are clamped.
        reflectance: Input<Rgb>,
    },
    /// Lambertian reflection and transmission of a thin sheet.
    DiffuseTransmission {
        /// Albedo of reflection, to the side that the light comes from, 0 to 1.
        reflectance: Input<Rgb>,
        /// Albedo of transmission, to the other side, 0 to 1.
        transmittance: Input<Rgb>,
        /// Factor of both albedos.
        scale: f64,
    },
    /// A metal.
    Conductor {
        /// Reflectance of the metal.
        metal: Metal,
        /// Roughness of the metal.
        roughness: Roughness,
    },
    /// Glass or water.
    Dielectric {
        /// Index of refraction inside over outside, positive.
        eta: Index,
        /// Fraction of the light that passes at each crossing, per channel, 0 to 1. An extension of the
        /// pbrt format: pbrt's dielectrics are untinted.
        transmittance: Rgb,
        /// Roughness of the surface.
        roughness: Roughness,
    },
    /// A thin pane of glass, with both of its surfaces.
    ThinDielectric {
        /// Index of refraction inside over outside, positive.
        eta: Index,
    },
    /// A Lambertian surface under a coat.
    CoatedDiffuse {
        /// Albedo of the surface under the coat, 0 to 1.
        reflectance: Input<Rgb>,
        /// The coat.
        coat: Coat,
    },
    /// A metal under a coat.
    CoatedConductor {
        /// Reflectance of the metal; optical constants are relative to the coat's index.
        metal: Metal,
        /// Roughness of the metal.
        roughness: Roughness,
        /// The coat.
        coat: Coat,
    },
    /// A measured surface: it reflects on both sides and transmits nothing.
    Measured(Arc<Measured>),
    /// A random choice between two other materials at each point.
    Mix {
        /// Indices into [`Scene::materials`].
        materials: [usize; 2],
        /// Probability of the second material, 0 to 1.
        amount: Input<f64>,
    },
    /// A material on a surface whose shading normals a texture bends.
    Bumped {
        /// The material; neither a mix nor bumped itself.
        material: Box<Material>,
        /// What bends the normals.
        bump: Bump,
    },
    /// No surface: light passes unchanged. The scene leaves out shapes of this material.
    Interface,
}

impl Material {
    /// Returns the type that a `Material` names.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Diffuse { .. } => "diffuse",
            Self::DiffuseTransmission { .. } => "diffusetransmission",
            Self::Conductor { .. } => "conductor",
            Self::Dielectric { .. } => "dielectric",
            Self::ThinDielectric { .. } => "thindielectric",
            Self::CoatedDiffuse { .. } => "coateddiffuse",
            Self::CoatedConductor { .. } => "coatedconductor",
            Self::Measured(_) => "measured",
            Self::Mix { .. } => "mix",
            Self::Bumped { material, .. } => material.kind(),
            Self::Interface => "interface",
        }
    }

    /// Returns the lobes of the material itself; those of a mix are lobes of its materials.
    pub(in crate::scene) fn lobes(&self) -> Lobes {
        match self {
            Self::Conductor { roughness, .. } | Self::Dielectric { roughness, .. } => Lobes::by(roughness),
            Self::Measured(_) => Lobes { smooth: false, rough: true },
            Self::ThinDielectric { .. } => Lobes { smooth: true, rough: false },
            Self::Bumped { material, .. } => material.lobes(),
            Self::CoatedDiffuse { coat, .. } => Lobes::of_coat(coat),
            Self::CoatedConductor { roughness, coat, .. } => {
                let (above, below) = (Lobes::of_coat(coat), Lobes::by(roughness));
                Lobes { smooth: above.smooth || below.smooth, rough: above.rough || below.rough }
            }
            Self::Diffuse { .. } | Self::DiffuseTransmission { .. } | Self::Mix { .. } | Self::Interface => {
                Lobes::default()
            }
        }
    }
}

/// Kinds of lobes of a material other than diffuse ones.
#[derive(Clone, Copy, Default)]
pub(in crate::scene) struct Lobes {
    /// Whether the material reflects or refracts into one direction.
    pub smooth: bool,
    /// Whether the material has microfacets.
    pub rough: bool,
}

impl Lobes {
    fn by(roughness: &Roughness) -> Self {
        Self { smooth: roughness.is_smooth(), rough: !roughness.is_smooth() }
    }

    /// Returns the lobes of a coat. A coat with a relative index of 1 reflects nothing.
    fn of_coat(coat: &Coat) -> Self {
        if coat.eta == Index::from(1.0) { Self::default() } else { Self::by(&coat.roughness) }
    }
}
