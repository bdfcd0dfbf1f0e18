//! The parser of a scene file: one method call per directive.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::base::input::{Budget, Held};
use crate::scene::directives::state::{ActiveTimes, Collected, SceneBuilder};
use crate::scene::directives::texture::Values;
use crate::scene::directives::{option, transform};
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::files::{directory, identity, read_text};
use crate::scene::format::lexer::{FlatText, Token, TokenKind, TokenStream, shorten};
use crate::scene::format::params::ParamList;
use crate::scene::format::version3;
use crate::scene::model::Scene;
use crate::scene::rewrite::input_file;
use crate::scene::spectrum::color_space::ColorSpace;
use crate::scene::spectrum::files::read_spectra;
use crate::scene::survey::Survey;

/// The command-line option that sets a scene's budget of memory.
pub(in crate::scene) const SCENE_MEMORY: &str = "--scene-memory";

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
pub(in crate::scene) fn load(path: &Path, budget: Budget) -> Result<Scene, SceneError> {
    Parser::new(open(path, budget)?, directory(path)).parse()
}

/// Reads the scene file at `path`, and returns the scene and its text with included files in place.
pub(crate) fn load_with_text(path: &Path, budget: Budget) -> Result<(Scene, FlatText), SceneError> {
    let mut parser = Parser::new(open(path, budget)?.keeping_text()?, directory(path));
    parser.directives()?;
    let text = parser.stream.flat_text();
    Ok((parser.scene.finish(parser.stream.end())?, text))
}

/// Reads the scene file at `path`, and continues after errors.
pub(in crate::scene) fn survey(path: &Path, budget: Budget) -> Survey {
    let mut parser = match open(path, budget) {
        Ok(stream) => Parser::new(stream, directory(path)),
        Err(error) => return Survey { scene: None, unsupported: Vec::new(), errors: vec![error], more: 0 },
    };
    parser.scene.collect_errors();
    let (scene, Collected { unsupported, errors, more }) = match parser.directives() {
        Ok(()) => parser.scene.finish_collecting(parser.stream.end()),
        Err(error) => (None, parser.scene.collected_with(error)),
    };
    Survey { scene, unsupported, errors, more }
}

fn open(path: &Path, budget: Budget) -> Result<TokenStream, SceneError> {
    let budget = Arc::new(budget.raised_by(SCENE_MEMORY));
    let text = read_text(path, None, &budget)?;
    Ok(TokenStream::of_file(text, &path.to_string_lossy(), identity(path), &budget))
}

/// Reads a scene from text.
pub(in crate::scene) fn parse(text: &str, file: &str, directory: &Path) -> Result<Scene, SceneError> {
    let stream = TokenStream::new(text.to_string(), file, None);
    Parser::new(stream, directory).parse()
}

struct Parser {
    stream: TokenStream,
    scene: SceneBuilder,
}

impl Parser {
    fn new(stream: TokenStream, directory: &Path) -> Self {
        let scene = SceneBuilder::new(directory, stream.budget());
        Self { stream, scene }
    }

    fn parse(mut self) -> Result<Scene, SceneError> {
        self.directives()?;
        self.scene.finish(self.stream.end())
    }

    fn directives(&mut self) -> Result<(), SceneError> {
        loop {
            let outcome = match self.stream.next() {
                Ok(None) => return Ok(()),
                Ok(Some(Token { kind: TokenKind::Word(word), location, .. })) => self.directive(&word, &location),
                Ok(Some(token)) => Err(token.location.invalid(format!("found {token}; expected a directive"))),
                Err(error) => Err(error),
            };
            if self.scene.notes(outcome)? {
                self.skip_to_directive();
            }
        }
    }

    /// Skips the tokens that a directive with an error has left unread.
    fn skip_to_directive(&mut self) {
        let begins = |token: &Token| matches!(&token.kind, TokenKind::Word(word) if DIRECTIVES.contains(&&**word));
        // Text that is not a token is skipped, too.
        while self.stream.peek().map_or(true, |token| token.is_some_and(|token| !begins(token))) {
            drop(self.stream.next());
        }
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
            | "Texture" | "ObjectBegin" | "ObjectEnd" | "ObjectInstance" => {
                self.scene.require_world(true, word, at)?;
                self.world(word, at)
            }
            "WorldBegin" => self.scene.world_begin(at),
            "Include" => {
                let (text, file, identity) = self.named_text(word, at)?;
                self.stream.include(text, &file, identity)
            }
            "Import" => {
                self.scene.require_world(true, word, at)?;
                let (text, file, identity) = self.named_text(word, at)?;
                self.scene.attribute_begin(at)?;
                self.stream.import(text, &file, identity)
            }
            "Option" => option::read(&mut self.stream, &mut self.scene.options),
            "ColorSpace" => self.color_space(),
            "Attribute" => {
                let (target, target_at) = self.stream.string("the target of Attribute")?;
                let params = self.params(word)?;
                self.scene.attribute(&target, params, &target_at)
            }
            "MakeNamedMedium" => {
                let (name, name_at) = self.stream.string("the name of a medium")?;
                self.apply(word, &name, &name_at, at)
            }
            "MediumInterface" => self.medium_interface(at),
            _ => Err(at.invalid(format!(
                "unknown directive `{}`; expected one of: {}{}",
                shorten(word),
                DIRECTIVES.join(", "),
                version3::hint_at_directive(word)
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
                let (name, name_at) = stream.string("the name of a coordinate system")?;
                scene.name_coordinate_system(name, &name_at)
            }
            "CoordSysTransform" => {
                let (name, name_at) = stream.string("the name of a coordinate system")?;
                scene.use_coordinate_system(&name, &name_at)
            }
            // Motion is ignored, so the times do not matter.
            "TransformTimes" => stream.numbers::<2>(word).map(drop),
            _ => self.active_transform(),
        }
    }

    fn active_transform(&mut self) -> Result<(), SceneError> {
        let token = self.stream.required("All, StartTime or EndTime")?;
        let times = match &token.kind {
            TokenKind::Word(word) if word == "All" => ActiveTimes::ALL,
            TokenKind::Word(word) if word == "StartTime" => ActiveTimes { start: true, end: false },
            TokenKind::Word(word) if word == "EndTime" => ActiveTimes { start: false, end: true },
            _ => return Err(token.location.invalid(format!("found {token}; expected All, StartTime or EndTime"))),
        };
        self.scene.activate(times);
        Ok(())
    }

    /// Reads the parameters that follow, and adds the colour space in force and the values of spectra from
    /// files.
    fn params(&mut self, directive: &str) -> Result<ParamList, SceneError> {
        let mut params = ParamList::read(&mut self.stream)?;
        let named = params.items.iter().filter_map(|param| input_file(directive, param));
        let paths: Vec<PathBuf> = named.map(|name| self.scene.directory().join(name)).collect();
        self.scene.inputs.extend(paths);
        for param in params.take_repeated()? {
            self.scene.warn(&param.location, &format!("{param} is given again; its first value is used"));
        }
        for param in &mut params.items {
            param.color_space = self.scene.color_space();
        }
        read_spectra(&mut params, self.scene.directory(), self.stream.budget())?;
        Ok(params)
    }

    fn option(&mut self, word: &str) -> Result<(), SceneError> {
        let (name, name_at) = self.stream.string(&format!("the type of {word}"))?;
        self.apply(word, &name, &name_at, &name_at)
    }

    /// Reads the parameters of a directive, and executes the directive. If all errors are collected, the
    /// directive is tried again without each parameter that is not supported.
    fn apply(&mut self, word: &str, name: &str, name_at: &Location, at: &Location) -> Result<(), SceneError> {
        let mut params = self.params(word)?;
        if !self.scene.collects_errors() {
            return self.perform(word, name, params, name_at, at);
        }
        let mut has_all = true;
        loop {
            let outcome = self.perform(word, name, params.clone(), name_at, at);
            let place = match &outcome {
                Err(SceneError::Unsupported { location, .. }) => location,
                // The error may follow from a parameter that was removed.
                Err(SceneError::Invalid { .. }) if !has_all => return Ok(()),
                _ => return outcome,
            };
            let Some(index) = params.items.iter().position(|param| param.location == *place) else {
                return outcome;
            };
            if self.scene.has_many_errors() {
                return outcome;
            }
            params.items.remove(index);
            has_all = false;
            self.scene.notes(outcome)?;
        }
    }

    fn perform(
        &mut self,
        word: &str,
        name: &str,
        params: ParamList,
        name_at: &Location,
        at: &Location,
    ) -> Result<(), SceneError> {
        let scene = &mut self.scene;
        match word {
            "Film" => scene.film(name, params, name_at),
            "Camera" => scene.camera(name, params, name_at),
            "Sampler" => scene.sampler(name, params, name_at),
            "Integrator" => scene.integrator(name, params, name_at),
            "PixelFilter" => scene.filter(name, params, name_at),
            // An accelerator changes the time to find a surface, not the surface.
            "Accelerator" => Ok(()),
            "Shape" => scene.shape(name, params, name_at, at),
            "LightSource" => scene.light(name, params, name_at),
            "AreaLightSource" => scene.area_light(name, params, name_at),
            "MakeNamedMaterial" => scene.make_named_material(name, params, name_at),
            "MakeNamedMedium" => scene.make_named_medium(name, params, name_at),
            _ => scene.material(name, params, name_at),
        }
    }

    fn world(&mut self, word: &str, at: &Location) -> Result<(), SceneError> {
        match word {
            "AttributeBegin" | "TransformBegin" => {
                return self.scene.attribute_begin(at);
            }
            "AttributeEnd" | "TransformEnd" => return self.scene.attribute_end(at),
            "ReverseOrientation" => {
                self.scene.reverse_orientation();
                return Ok(());
            }
            "ObjectEnd" => return self.scene.object_end(at),
            _ => {}
        }
        let (name, name_at) = self.stream.string(&format!("the type or name of {word}"))?;
        let scene = &mut self.scene;
        match word {
            "ObjectBegin" => return scene.object_begin(&name, at),
            "ObjectInstance" => return scene.object_instance(&name, at),
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
                        let hint = version3::hint_at_values(&values);
                        let what = format!("unknown type \"{}\" of Texture", shorten(&values));
                        return Err(values_at.invalid(format!("{what}; expected \"float\" or \"spectrum\"{hint}")));
                    }
                };
                let (class, class_at) = self.stream.string("the texture's class")?;
                let params = self.params(word)?;
                return self.scene.texture(name, values, class, params, &class_at);
            }
            _ => {}
        }
        self.apply(word, &name, &name_at, at)
    }

    /// Returns the text, name and identity of the file that a directive names. As in pbrt, the name is
    /// relative to the folder of the scene file, not to that of the including file.
    fn named_text(&mut self, word: &str, at: &Location) -> Result<((String, Held), String, PathBuf), SceneError> {
        let (name, name_at) = self.stream.string(&format!("the name of a file after {word}"))?;
        let path = self.scene.directory().join(&name);
        let identity = identity(&path);
        self.stream.check_include(&identity, at)?;
        let text = read_text(&path, Some(&name_at), self.stream.budget())?;
        self.scene.included.push(path.clone());
        self.scene.inputs.push(path.clone());
        Ok((text, path.to_string_lossy().into_owned(), identity))
    }

    fn color_space(&mut self) -> Result<(), SceneError> {
        let (name, at) = self.stream.string("the name of a color space")?;
        let Some(space) = ColorSpace::from_name(&name) else {
            let names = ColorSpace::ALL.map(|(_, name)| format!("\"{name}\"")).join(", ");
            return Err(at.invalid(format!("unknown ColorSpace \"{}\"; expected one of: {names}", shorten(&name))));
        };
        self.scene.set_color_space(space);
        Ok(())
    }

    fn medium_interface(&mut self, at: &Location) -> Result<(), SceneError> {
        let (inside, _) = self.stream.string("the name of a medium")?;
        // As in pbrt, one name is that of both sides.
        let mut outside = inside.clone();
        if matches!(self.stream.peek()?, Some(token) if matches!(token.kind, TokenKind::Text(_))) {
            (outside, _) = self.stream.string("the name of a medium")?;
        }
        self.scene.medium_interface(&inside, &outside, at)
    }
}
