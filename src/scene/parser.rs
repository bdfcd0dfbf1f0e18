//! The directives of a scene file.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;
use glam::{DAffine3, DVec3};

use super::error::{Location, SceneError};
use super::lexer::{FlatText, TokenKind, TokenStream, shorten};
use super::model::Scene;
use super::params::ParamList;
use super::registry::Kind;
use super::state::SceneBuilder;
use super::texture::Values;
use super::transform;

/// Every directive of pbrt-v4.
const DIRECTIVES: &[&str] = &[
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Film",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "Translate",
    "WorldBegin",
];

/// Reads the scene file at `path`.
pub(super) fn load(path: &Path) -> Result<Scene, SceneError> {
    Parser::new(open(path)?, directory(path)).parse()
}

/// Reads the scene file at `path`, and keeps its text.
pub(crate) fn load_with_text(path: &Path) -> Result<(Scene, FlatText), SceneError> {
    let mut parser = Parser::new(open(path)?.keeping_text(), directory(path));
    parser.directives()?;
    let text = parser.stream.flat_text();
    Ok((parser.scene.finish(parser.stream.end())?, text))
}

/// The folder that a scene's file names are relative to.
pub(crate) fn directory(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

fn open(path: &Path) -> Result<TokenStream, SceneError> {
    Ok(TokenStream::new(read_text(path, None)?, &path.to_string_lossy(), Some(identity(path))))
}

/// Reads a scene from text.
pub(super) fn parse(text: &str, file: &str, directory: &Path) -> Result<Scene, SceneError> {
    let stream = TokenStream::new(text.to_string(), file, None);
    Parser::new(stream, directory).parse()
}

/// The same for every way to name a file.
pub(crate) fn identity(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

/// The longest text that is read: a device file or a gzip bomb never ends.
const MAX_TEXT: u64 = 1 << 30;

fn read_text(path: &Path, location: Option<&Location>) -> Result<String, SceneError> {
    let unreadable = |source| SceneError::Unreadable { path: path.to_path_buf(), location: location.cloned(), source };
    let file = fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(MAX_TEXT + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.starts_with(&[0x1f, 0x8b]) {
        let mut expanded = Vec::new();
        let mut decoder = MultiGzDecoder::new(&bytes[..]).take(MAX_TEXT + 1);
        decoder.read_to_end(&mut expanded).map_err(unreadable)?;
        bytes = expanded;
    }
    if bytes.len() as u64 > MAX_TEXT {
        let what = format!("it holds more than {MAX_TEXT} bytes of text");
        return Err(unreadable(io::Error::other(what)));
    }
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(unreadable(io::Error::other("it is UTF-16; expected UTF-8")));
    }
    // Old scenes have comments in other encodings: what is not UTF-8 is replaced,
    // and an error only where it would mean something.
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

struct Parser {
    stream: TokenStream,
    scene: SceneBuilder,
}

impl Parser {
    fn new(stream: TokenStream, directory: &Path) -> Self {
        Self { stream, scene: SceneBuilder::new(directory) }
    }

    fn parse(mut self) -> Result<Scene, SceneError> {
        self.directives()?;
        self.scene.finish(self.stream.end())
    }

    fn directives(&mut self) -> Result<(), SceneError> {
        while let Some(token) = self.stream.next()? {
            match &token.kind {
                TokenKind::Word(word) => self.directive(word, &token.location)?,
                _ => {
                    return Err(token.location.invalid(format!("found {token}; expected a directive")));
                }
            }
        }
        Ok(())
    }

    fn directive(&mut self, word: &str, at: &Location) -> Result<(), SceneError> {
        match word {
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform" | "ConcatTransform"
            | "CoordinateSystem" | "CoordSysTransform" | "ActiveTransform" | "TransformTimes" => {
                self.transform(word, at)
            }
            "Film" | "Camera" | "Sampler" | "Integrator" | "Accelerator" | "PixelFilter" => {
                self.scene.require_world(false, word, at)?;
                self.option(word)
            }
            "Shape" | "LightSource" | "AreaLightSource" | "Material" | "MakeNamedMaterial" | "NamedMaterial"
            | "ReverseOrientation" | "AttributeBegin" | "AttributeEnd" | "TransformBegin" | "TransformEnd"
            | "Texture" | "ObjectBegin" | "ObjectEnd" | "ObjectInstance" | "Import" => {
                self.scene.require_world(true, word, at)?;
                self.world(word, at)
            }
            "WorldBegin" => self.scene.world_begin(at),
            "Include" => self.include(at),
            "Option" => self.renderer_option(at),
            "ColorSpace" => self.color_space(),
            "Attribute" => {
                let (target, target_at) = self.stream.string("the target of Attribute")?;
                let params = ParamList::read(&mut self.stream)?;
                self.scene.attribute(&target, params, &target_at)
            }
            "MakeNamedMedium" => {
                self.stream.string("the name of a medium")?;
                ParamList::read(&mut self.stream).map(drop)
            }
            "MediumInterface" => self.medium_interface(at),
            _ => Err(at.invalid(format!(
                "unknown directive `{}`; expected one of: {}",
                shorten(word),
                DIRECTIVES.join(", ")
            ))),
        }
    }

    fn transform(&mut self, word: &str, at: &Location) -> Result<(), SceneError> {
        let (stream, scene) = (&mut self.stream, &mut self.scene);
        match word {
            "Identity" => scene.set_transform(Some(DAffine3::IDENTITY), word, at),
            "Translate" => {
                let offset = DVec3::from(stream.numbers(word)?);
                scene.concat_transform(Some(DAffine3::from_translation(offset)), word, at)
            }
            "Scale" => {
                let factors = DVec3::from(stream.numbers(word)?);
                scene.concat_transform(Some(DAffine3::from_scale(factors)), word, at)
            }
            "Rotate" => {
                let [degrees, x, y, z] = stream.numbers(word)?;
                let rotation = transform::rotate(degrees, DVec3::new(x, y, z));
                scene.concat_transform(rotation, word, at)
            }
            "LookAt" => {
                let [ex, ey, ez, lx, ly, lz, ux, uy, uz] = stream.numbers(word)?;
                let camera_from_world =
                    transform::look_at(DVec3::new(ex, ey, ez), DVec3::new(lx, ly, lz), DVec3::new(ux, uy, uz));
                scene.concat_transform(camera_from_world, word, at)
            }
            "Transform" => {
                let matrix = transform::from_numbers(stream.matrix(word)?);
                scene.set_transform(matrix, word, at)
            }
            "ConcatTransform" => {
                let matrix = transform::from_numbers(stream.matrix(word)?);
                scene.concat_transform(matrix, word, at)
            }
            "CoordinateSystem" => {
                let (name, _) = stream.string("the name of a coordinate system")?;
                scene.name_coordinate_system(name);
                Ok(())
            }
            "CoordSysTransform" => {
                let (name, name_at) = stream.string("the name of a coordinate system")?;
                scene.use_coordinate_system(&name, &name_at)
            }
            // Nothing moves, so the times do not matter.
            "TransformTimes" => stream.numbers::<2>(word).map(drop),
            _ => self.active_transform(),
        }
    }

    fn active_transform(&mut self) -> Result<(), SceneError> {
        let token = self.stream.required("All, StartTime or EndTime")?;
        match &token.kind {
            TokenKind::Word(word) if word == "All" => Ok(()),
            TokenKind::Word(word) if word == "StartTime" || word == "EndTime" => {
                let what = format!("ActiveTransform {word}");
                Err(token.location.unsupported(&what, "All"))
            }
            _ => Err(token.location.invalid(format!("found {token}; expected All, StartTime or EndTime"))),
        }
    }

    fn option(&mut self, word: &str) -> Result<(), SceneError> {
        let (name, name_at) = self.stream.string(&format!("the type of {word}"))?;
        let params = ParamList::read(&mut self.stream)?;
        let scene = &mut self.scene;
        match word {
            "Film" => scene.film(&name, params, &name_at),
            "Camera" => scene.camera(&name, params, &name_at),
            "Sampler" => scene.sampler(&name, params, &name_at),
            "Integrator" => scene.integrator(&name, params, &name_at),
            "PixelFilter" => scene.filter(&name, params, &name_at),
            // Accelerator: finds the same surfaces, sooner or later.
            _ => Ok(()),
        }
    }

    fn world(&mut self, word: &str, at: &Location) -> Result<(), SceneError> {
        match word {
            "AttributeBegin" | "TransformBegin" => {
                self.scene.attribute_begin(at);
                return Ok(());
            }
            "AttributeEnd" | "TransformEnd" => return self.scene.attribute_end(at),
            "ReverseOrientation" => {
                self.scene.reverse_orientation();
                return Ok(());
            }
            "ObjectBegin" | "ObjectEnd" | "ObjectInstance" => {
                return Err(at.unsupported(word, "shapes that are given where they stand"));
            }
            "Import" => return Err(at.unsupported(word, "Include")),
            _ => {}
        }
        let (name, name_at) = self.stream.string(&format!("the type or name of {word}"))?;
        let scene = &mut self.scene;
        match word {
            "NamedMaterial" => {
                scene.named_material(&name, &name_at);
                return Ok(());
            }
            "Texture" => {
                let (values, values_at) = self.stream.string("the texture's type, \"float\" or \"spectrum\"")?;
                let values = match values.as_str() {
                    "float" => Values::Numbers,
                    "spectrum" => Values::Colors,
                    _ => {
                        let what = format!("unknown type \"{}\" of Texture", shorten(&values));
                        return Err(values_at.invalid(format!("{what}; expected \"float\" or \"spectrum\"")));
                    }
                };
                let (class, class_at) = self.stream.string("the texture's class")?;
                let params = ParamList::read(&mut self.stream)?;
                return scene.texture(&name, values, &class, params, &class_at);
            }
            _ => {}
        }
        let params = ParamList::read(&mut self.stream)?;
        match word {
            "Shape" => scene.shape(&name, params, &name_at, at),
            "LightSource" => scene.light(&name, params, &name_at),
            "AreaLightSource" => scene.area_light(&name, params, &name_at),
            "MakeNamedMaterial" => scene.make_named_material(&name, params, &name_at),
            _ => scene.material(&name, params, &name_at),
        }
    }

    /// Continues with another file. Its name is relative to the folder of the
    /// scene file, not to that of the including file: as in pbrt.
    fn include(&mut self, at: &Location) -> Result<(), SceneError> {
        let (name, name_at) = self.stream.string("the name of a file after Include")?;
        let path = self.scene.directory().join(&name);
        let identity = identity(&path);
        self.stream.check_include(&identity, at)?;
        let text = read_text(&path, Some(&name_at))?;
        self.stream.include(text, &path.to_string_lossy(), identity);
        Ok(())
    }

    /// `Option`: most steer pbrt itself.
    fn renderer_option(&mut self, at: &Location) -> Result<(), SceneError> {
        let params = ParamList::read(&mut self.stream)?;
        let [option] = &params.items[..] else {
            return Err(at.invalid("expected one parameter after Option"));
        };
        match (option.name.as_str(), option.kind) {
            ("forcediffuse" | "disablepixeljitter", Kind::Bool) => {
                if params.flag(&option.name)? {
                    let what = format!("{option} true");
                    return Err(option.location.unsupported(&what, "false"));
                }
                Ok(())
            }
            (
                "disabletexturefiltering"
                | "disablewavelengthjitter"
                | "displacementedgescale"
                | "msereferenceimage"
                | "msereferenceout"
                | "pixelstats"
                | "rendercoordsys"
                | "seed"
                | "wavefront",
                _,
            ) => Ok(()),
            _ => Err(option
                .location
                .invalid(format!("unknown Option {option}; expected one of pbrt-v4's, such as \"integer seed\""))),
        }
    }

    fn color_space(&mut self) -> Result<(), SceneError> {
        let (name, at) = self.stream.string("the name of a color space")?;
        match name.as_str() {
            "srgb" => Ok(()),
            "aces2065-1" | "dci-p3" | "rec2020" => Err(at.unsupported(&format!("ColorSpace \"{name}\""), "\"srgb\"")),
            _ => Err(at.invalid(format!("unknown ColorSpace \"{}\"; expected \"srgb\"", shorten(&name)))),
        }
    }

    fn medium_interface(&mut self, at: &Location) -> Result<(), SceneError> {
        let (inside, _) = self.stream.string("the name of a medium")?;
        let mut outside = String::new();
        if matches!(self.stream.peek()?, Some(token) if matches!(token.kind, TokenKind::Text(_))) {
            (outside, _) = self.stream.string("the name of a medium")?;
        }
        if inside.is_empty() && outside.is_empty() {
            return Ok(());
        }
        let what = format!("MediumInterface \"{}\" \"{}\"", shorten(&inside), shorten(&outside));
        Err(at.unsupported(&what, "MediumInterface \"\" \"\", which is empty space"))
    }
}
