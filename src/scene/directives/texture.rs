//! The `Texture` directive, and parameters that may be textures.

// Circle: texture.rs <-> named.rs: one declares the types of textures, the other keeps textures by name and asks for these types.

mod mean;
mod named;

use glam::{DAffine3, DMat3, DVec3};

use crate::image::file::{Transfer, Use};
use crate::scene::directives::transform::is_invertible;
use crate::scene::format::error::SceneError;
use crate::scene::format::kind::Kind;
use crate::scene::format::lexer::shorten;
use crate::scene::format::registry::{Family, ParamSpec, full, ignored, not_yet, supported};
use crate::scene::model::texture::{ImageTexture, Mapping, Octaves, Texture, TextureKind, Wrap};
use crate::scene::model::{Input, Rgb};
pub(in crate::scene) use named::{Declaration, Textures, Values};

const FLOAT: &[Kind] = &[Kind::Float];
const STRING: &[Kind] = &[Kind::String];
const VECTOR: &[Kind] = &[Kind::Vector3];
const NUMBER: &[Kind] = &[Kind::Float, Kind::Texture];
const FIXED_COLOUR: &[Kind] = &[Kind::Rgb, Kind::Spectrum, Kind::Blackbody];
const COLOUR: &[Kind] = &[Kind::Rgb, Kind::Spectrum, Kind::Blackbody, Kind::Texture];

const MAPPING: ParamSpec = full("mapping", STRING);
const U_SCALE: ParamSpec = full("uscale", FLOAT);
const V_SCALE: ParamSpec = full("vscale", FLOAT);
const U_DELTA: ParamSpec = full("udelta", FLOAT);
const V_DELTA: ParamSpec = full("vdelta", FLOAT);
const V1: ParamSpec = full("v1", VECTOR);
const V2: ParamSpec = full("v2", VECTOR);
const OCTAVES: ParamSpec = full("octaves", &[Kind::Integer]);
const ROUGHNESS: ParamSpec = full("roughness", FLOAT);

/// What to use in place of a `ptex` texture.
const INSTEAD_OF_PTEX: &str =
    "\"imagemap\", for which the colours of all faces are baked into one image by the mesh's \"point2 uv\"";

/// The family of pbrt's textures with values of the types `$fixed`, or `$input` for parameters that may be
/// textures themselves.
macro_rules! family {
    ($fixed:expr, $input:expr, $($noise:expr),*) => {
        Family {
            directive: "Texture",
            types: &[
                supported("constant", &[full("value", $fixed)]),
                supported("scale", &[full("tex", $input), full("scale", NUMBER)]),
                supported("mix", &[full("tex1", $input), full("tex2", $input), full("amount", NUMBER)]),
                supported("directionmix", &[full("tex1", $input), full("tex2", $input), full("dir", VECTOR)]),
                supported(
                    "bilerp",
                    &[
                        full("v00", $fixed),
                        full("v01", $fixed),
                        full("v10", $fixed),
                        full("v11", $fixed),
                        MAPPING, U_SCALE, V_SCALE, U_DELTA, V_DELTA, V1, V2,
                    ],
                ),
                supported(
                    "checkerboard",
                    &[
                        full("tex1", $input),
                        full("tex2", $input),
                        full("dimension", &[Kind::Integer]),
                        MAPPING, U_SCALE, V_SCALE, U_DELTA, V_DELTA, V1, V2,
                    ],
                ),
                supported(
                    "imagemap",
                    &[
                        full("filename", STRING),
                        full("wrap", STRING),
                        full("filter", STRING),
                        ignored("maxanisotropy", FLOAT),
                        full("scale", FLOAT),
                        full("invert", &[Kind::Bool]),
                        full("encoding", STRING),
                        MAPPING, U_SCALE, V_SCALE, U_DELTA, V_DELTA, V1, V2,
                    ],
                ),
                supported(
                    "dots",
                    &[
                        full("inside", $input),
                        full("outside", $input),
                        MAPPING, U_SCALE, V_SCALE, U_DELTA, V_DELTA, V1, V2,
                    ],
                ),
                $($noise,)*
                not_yet("ptex"),
            ],
        }
    };
}

/// The textures of numbers.
pub(in crate::scene) const FLOAT_FAMILY: Family = family!(
    FLOAT,
    NUMBER,
    supported("fbm", &[OCTAVES, ROUGHNESS]),
    supported("windy", &[]),
    supported("wrinkled", &[OCTAVES, ROUGHNESS])
);
/// The textures of colours.
pub(in crate::scene) const SPECTRUM_FAMILY: Family = family!(
    FIXED_COLOUR,
    COLOUR,
    supported("marble", &[OCTAVES, ROUGHNESS, full("scale", FLOAT), full("variation", FLOAT)])
);

/// Maker of one texture from parameters that its family has checked.
struct Maker<'a> {
    textures: &'a mut Textures,
    place: &'a Declaration,
}

impl Maker<'_> {
    /// Makes a texture of a class, and returns a constant if its value is one.
    fn make(&mut self, class: &str) -> Result<Input<Rgb>, SceneError> {
        let kind = match class {
            "constant" => return self.value("value", 1.0),
            "scale" => {
                let (texture, factor) = (self.value("tex", 1.0)?, self.number("scale", 1.0)?);
                if let (Input::Constant(value), Input::Constant(factor)) = (texture, factor) {
                    return Ok(Input::Constant(value * factor));
                }
                TextureKind::Scale { texture, factor }
            }
            "mix" => {
                let (textures, amount) = (self.pair(0.0, 1.0)?, self.number("amount", 0.5)?);
                if let ([Input::Constant(a), Input::Constant(b)], Input::Constant(amount)) = (textures, amount) {
                    return Ok(Input::Constant(a.lerp(b, amount)));
                }
                TextureKind::Mix { textures, amount }
            }
            "directionmix" => {
                TextureKind::DirectionMix { direction: self.direction()?, textures: self.pair(0.0, 1.0)? }
            }
            "bilerp" => TextureKind::Bilerp { mapping: self.mapping()?, corners: self.corners()? },
            "checkerboard" => {
                let mapping = match self.place.params.integer("dimension", 2, 3)? {
                    Some(3) => self.position()?,
                    _ => self.mapping()?,
                };
                TextureKind::Checkerboard { mapping, textures: self.pair(1.0, 0.0)? }
            }
            "dots" => TextureKind::Dots { mapping: self.mapping()?, textures: self.dots()? },
            "fbm" => TextureKind::Fbm { mapping: self.position()?, octaves: self.octaves()? },
            "wrinkled" => TextureKind::Wrinkled { mapping: self.position()?, octaves: self.octaves()? },
            "windy" => TextureKind::Windy { mapping: self.position()? },
            "marble" => TextureKind::Marble {
                mapping: Mapping::Space(self.scale()? * self.texture_from_world()?),
                octaves: self.octaves()?,
                variation: self.moderate("variation", 0.2, 1e5)?,
            },
            _ => TextureKind::Image(self.image()?),
        };
        let made = &mut self.textures.made;
        made.push(Texture { kind, location: self.place.location.to_string() });
        Ok(Input::Texture(made.len() - 1))
    }

    fn texture_from_world(&self) -> Result<DAffine3, SceneError> {
        let world_from_texture = &self.place.world_from_texture;
        if !is_invertible(world_from_texture) {
            let what = "a texture in a space that cannot be inverted, by its transform,";
            return Err(self
                .place
                .location
                .unsupported(what, "transforms that can be inverted, or \"string mapping\" \"uv\""));
        }
        Ok(world_from_texture.inverse())
    }

    /// Returns the map to positions in the texture's space.
    fn position(&self) -> Result<Mapping, SceneError> {
        Ok(Mapping::Space(self.texture_from_world()?))
    }

    /// Returns the multiplication by `scale`.
    fn scale(&self) -> Result<DAffine3, SceneError> {
        Ok(DAffine3::from_scale(DVec3::splat(self.float("scale", 1.0)?)))
    }

    /// Returns the textures in the discs and around them. pbrt-v4 looks "outside" up in the discs of `dots` and
    /// "inside" around them (`FloatDotsTexture::Create` against the order that its constructor expects).
    fn dots(&self) -> Result<[Input<Rgb>; 2], SceneError> {
        Ok([self.value("outside", 0.0)?, self.value("inside", 1.0)?])
    }

    fn octaves(&self) -> Result<Octaves, SceneError> {
        let count = self.place.params.integer("octaves", 0, Octaves::MOST)?.unwrap_or(8);
        Ok(Octaves { count, roughness: self.moderate("roughness", 0.5, 100.0)? })
    }

    /// Returns a number whose magnitude must be at most `most`, so that f32 holds what is computed from it.
    fn moderate(&self, name: &str, default: f64, most: f64) -> Result<f64, SceneError> {
        let expected = format!("a number from -{most} to {most}");
        self.place.params.float_in(name, default, |value| value.abs() <= most, &expected)
    }

    /// Returns a value of the texture's own type.
    fn value(&self, name: &str, default: f64) -> Result<Input<Rgb>, SceneError> {
        match (self.place.params.get(name), self.place.values) {
            (None, _) => Ok(Input::Constant(Rgb::splat(default))),
            (Some(param), Values::Colors) => self.textures.color(param),
            (Some(param), Values::Numbers) => Ok(match self.textures.number(param)? {
                Input::Constant(value) => Input::Constant(Rgb::splat(value)),
                Input::Texture(index) => Input::Texture(index),
            }),
        }
    }

    fn pair(&self, first: f64, second: f64) -> Result<[Input<Rgb>; 2], SceneError> {
        Ok([self.value("tex1", first)?, self.value("tex2", second)?])
    }

    fn number(&self, name: &str, default: f64) -> Result<Input<f64>, SceneError> {
        self.place.params.get(name).map_or(Ok(Input::Constant(default)), |param| self.textures.number(param))
    }

    fn corners(&self) -> Result<[Rgb; 4], SceneError> {
        let mut corners = [Rgb::ZERO; 4];
        for (corner, (name, default)) in
            corners.iter_mut().zip([("v00", 0.0), ("v10", 0.0), ("v01", 1.0), ("v11", 1.0)])
        {
            if let Input::Constant(value) = self.value(name, default)? {
                *corner = value;
            }
        }
        Ok(corners)
    }

    fn direction(&self) -> Result<DVec3, SceneError> {
        let direction = self.vector("dir", DVec3::Y)?;
        let turned = self.place.world_from_texture.transform_vector3(direction).try_normalize();
        turned.ok_or_else(|| self.place.location.invalid("\"vector3 dir\" is 0; expected a direction"))
    }

    fn vector(&self, name: &str, default: DVec3) -> Result<DVec3, SceneError> {
        Ok(self.place.params.point(name)?.unwrap_or(default))
    }

    fn float(&self, name: &str, default: f64) -> Result<f64, SceneError> {
        Ok(self.place.params.float(name)?.unwrap_or(default))
    }

    fn mapping(&self) -> Result<Mapping, SceneError> {
        let delta = DVec3::new(self.float("udelta", 0.0)?, self.float("vdelta", 0.0)?, 0.0);
        match self.choice("mapping", &["uv", "planar", "spherical", "cylindrical"])? {
            "planar" => {
                let (s, t) = (self.vector("v1", DVec3::X)?, self.vector("v2", DVec3::Y)?);
                let flat = DAffine3 { matrix3: DMat3::from_cols(s, t, DVec3::ZERO).transpose(), translation: delta };
                Ok(Mapping::Space(flat * self.texture_from_world()?))
            }
            "spherical" => Ok(Mapping::Spherical(self.texture_from_world()?)),
            "cylindrical" => Ok(Mapping::Cylindrical(self.texture_from_world()?)),
            _ => {
                let scale = DVec3::new(self.float("uscale", 1.0)?, self.float("vscale", 1.0)?, 0.0);
                Ok(Mapping::Surface(DAffine3 { matrix3: DMat3::from_diagonal(scale), translation: delta }))
            }
        }
    }

    /// Returns a parameter's value, one of `words`; the first one is the default.
    fn choice(&self, name: &str, words: &[&'static str]) -> Result<&'static str, SceneError> {
        let Some(param) = self.place.params.get(name) else {
            return Ok(words[0]);
        };
        words.iter().copied().find(|word| param.text() == Some(*word)).ok_or_else(|| {
            let expected = words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ");
            param.bad_value(&format!("one of {expected}"))
        })
    }

    fn image(&mut self) -> Result<ImageTexture, SceneError> {
        let Some(file) = self.place.params.get("filename") else {
            return Err(self.place.location.invalid("Texture \"imagemap\" has no \"string filename\"; expected one"));
        };
        let name = self.place.params.string("filename")?.unwrap_or_default();
        let wrap = match self.choice("wrap", &["repeat", "clamp", "black", "octahedralsphere"])? {
            "clamp" => Wrap::Clamp,
            "black" => Wrap::Black,
            "octahedralsphere" => {
                let what = "\"string wrap\" \"octahedralsphere\"";
                return Err(self.place.location.unsupported(what, "\"repeat\", \"clamp\", \"black\""));
            }
            _ => Wrap::Repeat,
        };
        // The paths of a pixel average what is finer than the pixel: all filters but "point" are bilinear.
        let filter = self.choice("filter", &["bilinear", "point", "trilinear", "EWA", "ewa"])?;
        let (mapping, scale, invert) = (self.mapping()?, self.float("scale", 1.0)?, self.place.params.flag("invert")?);
        let encoding = self.encoding()?;
        let (path, of) = (self.textures.directory.join(name), (self.place.values, Use::Reflectance));
        let image = self.textures.image(path, encoding, of, file)?;
        let least = if self.place.values == Values::Colors || invert { 0.0 } else { f64::NEG_INFINITY };
        let most = if self.place.values == Values::Colors { 1.0 } else { f64::INFINITY };
        Ok(ImageTexture {
            image,
            mapping,
            wrap,
            nearest: filter == "point",
            offset: f64::from(u8::from(invert)),
            factor: if invert { -scale } else { scale },
            range: [least, most],
        })
    }

    /// Returns the encoding as written, and its transfer function.
    fn encoding(&self) -> Result<(String, Transfer), SceneError> {
        let text = self.place.params.string("encoding")?.unwrap_or("sRGB");
        let gamma = |text: &str| {
            text.strip_prefix("gamma ")?.trim().parse().ok().filter(|gamma| (0.01..=100.0).contains(gamma))
        };
        let encoding = match text {
            "sRGB" => Transfer::Srgb,
            "linear" => Transfer::Linear,
            text => Transfer::Gamma(gamma(text).ok_or_else(|| {
                let expected = "\"sRGB\", \"linear\" or \"gamma\" and a number above 0";
                self.place
                    .location
                    .invalid(format!("the encoding \"{}\" is unknown; expected {expected}", shorten(text)))
            })?),
        };
        Ok((text.to_string(), encoding))
    }
}
