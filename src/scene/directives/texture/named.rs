//! The textures of a scene by their names. A scene may use a name before it declares the texture.

use std::cell::RefCell;
use std::collections::{HashMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DAffine3;

use crate::base::input::Budget;
use crate::image::file::{ImageError, Transfer, Use, read_layers};
use crate::image::film::Image;
use crate::scene::directives::texture::mean::{Means, as_color};
use crate::scene::directives::texture::{FLOAT_FAMILY, INSTEAD_OF_PTEX, Maker, SPECTRUM_FAMILY};
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::kind::Kind;
use crate::scene::format::lexer::shorten;
use crate::scene::format::params::{Param, ParamList};
use crate::scene::format::registry::Ignored;
use crate::scene::measured::MeasuredFiles;
use crate::scene::model::texture::{ImageTexture, Mapping, Texture, TextureKind, Wrap};
use crate::scene::model::{EmissionImage, Input, Measured, Rgb};
use crate::scene::spectrum::Spectrum;

/// Maximum number of pixels of all images together: the size of a device's table.
const MAX_TEXELS: u64 = 1 << 27;

/// Maximum number of names that an error lists.
const MOST_LISTED: usize = 1000;

/// Type of a texture's values. Each type has its own name space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::scene) enum Values {
    Numbers,
    Colors,
}

/// Key of a texture.
type Key = (Values, String);

/// A texture of the scene file. A texture that goblet cannot render is an error only if it is used.
#[derive(Debug)]
enum Slot {
    Made(Input<Rgb>),
    Unsupported {
        location: Location,
        message: String,
    },
    /// The texture uses one that is not declared yet: its index among the waiting declarations.
    Waiting(usize),
    /// The texture has an error that has been reported.
    Faulty,
}

/// A `Texture` directive, and the attributes in force at its place.
#[derive(Debug)]
pub(in crate::scene) struct Declaration {
    pub name: String,
    pub values: Values,
    pub class: String,
    /// Place of the class.
    pub location: Location,
    pub params: ParamList,
    pub world_from_texture: DAffine3,
    /// Default parameters set by `Attribute`.
    pub defaults: Arc<ParamList>,
}

/// The textures so far, by name.
#[derive(Debug, Default)]
pub(in crate::scene) struct Textures {
    /// The scene's budget of memory.
    budget: Arc<Budget>,
    /// Directory that file names are relative to.
    pub(in crate::scene) directory: PathBuf,
    named: HashMap<Key, Slot>,
    /// Textures declared before the textures that they use.
    waiting: Vec<Declaration>,
    pub made: Vec<Texture>,
    /// Parameters that cannot change the image.
    pub ignored: Ignored,
    /// Images by file and decoding, so that each file is read once per decoding.
    images: HashMap<(PathBuf, String, Values, Use), Arc<Image>>,
    /// Means of images that area lights show, by the image's address.
    shown: HashMap<*const Image, Rgb>,
    means: RefCell<Means>,
    measured: MeasuredFiles,
    texels: u64,
}

impl Textures {
    /// Returns an empty set of textures. File names are relative to `directory`.
    pub fn new(directory: &Path, budget: &Arc<Budget>) -> Self {
        Self { directory: directory.to_path_buf(), budget: Arc::clone(budget), ..Self::default() }
    }

    /// Executes `Texture`. A texture that uses one which is not declared yet waits for
    /// [`make_waiting`](Self::make_waiting).
    pub fn declare(&mut self, declaration: Declaration) -> Result<(), SceneError> {
        let key = (declaration.values, declaration.name.clone());
        if self.named.contains_key(&key) {
            return Err(declaration.location.invalid(format!(
                "a texture \"{}\" of its type exists already; expected a new name",
                shorten(&declaration.name)
            )));
        }
        let bytes = size_of::<(Key, Slot)>() + size_of::<(Declaration, Texture)>() + declaration.name.len();
        self.budget.take(bytes as u64).map_err(declaration.location.over())?;
        if declaration.needs().iter().any(|need| !self.is_there(need)) {
            self.named.insert(key, Slot::Waiting(self.waiting.len()));
            self.waiting.push(declaration);
            return Ok(());
        }
        self.make(key, declaration)
    }

    /// Makes the waiting textures, after all are declared: each after the textures that it uses. Returns the
    /// errors.
    pub fn make_waiting(&mut self) -> Vec<SceneError> {
        let mut waiting: Vec<Option<Declaration>> = std::mem::take(&mut self.waiting).into_iter().map(Some).collect();
        let mut users = vec![Vec::new(); waiting.len()];
        let mut missing = vec![0; waiting.len()];
        for (user, declaration) in waiting.iter().enumerate() {
            for need in declaration.iter().flat_map(Declaration::needs) {
                if let Some(Slot::Waiting(needed)) = self.named.get(&need) {
                    users[*needed].push(user);
                    missing[user] += 1;
                }
            }
        }
        let mut errors = Vec::new();
        let mut ready: VecDeque<usize> = (0..waiting.len()).filter(|index| missing[*index] == 0).collect();
        while let Some(index) = ready.pop_front() {
            let Some(declaration) = waiting[index].take() else { continue };
            let key = (declaration.values, declaration.name.clone());
            errors.extend(self.make(key, declaration).err());
            for user in std::mem::take(&mut users[index]) {
                missing[user] -= 1;
                if missing[user] == 0 {
                    ready.push_back(user);
                }
            }
        }
        for declaration in waiting.into_iter().flatten() {
            let what = format!("the texture \"{}\" is made of itself", shorten(&declaration.name));
            errors.push(declaration.location.invalid(format!("{what}, through others or not; expected other ones")));
            self.named.insert((declaration.values, declaration.name), Slot::Faulty);
        }
        errors
    }

    /// Returns true if every texture that the parameters of a material or shape name is made.
    pub fn has_all(&self, params: &ParamList) -> bool {
        let is_there = |param: &Param| {
            let is_color = matches!(param.name.as_str(), "albedo" | "reflectance" | "transmittance");
            let values = if is_color { Values::Colors } else { Values::Numbers };
            texture_name(param).is_none_or(|name| self.is_there(&(values, name.to_string())))
        };
        params.items.iter().all(is_there)
    }

    fn is_there(&self, key: &Key) -> bool {
        matches!(self.named.get(key), Some(slot) if !matches!(slot, Slot::Waiting(_)))
    }

    fn make(&mut self, key: Key, mut declaration: Declaration) -> Result<(), SceneError> {
        let Declaration { values, location, class, params, defaults, .. } = &mut declaration;
        let family = if *values == Values::Numbers { &FLOAT_FAMILY } else { &SPECTRUM_FAMILY };
        let checked = match class.as_str() {
            "ptex" => Err(location.unsupported("Texture \"ptex\"", INSTEAD_OF_PTEX)),
            class => family.check(class, location, params, defaults, &mut self.ignored),
        };
        let made = checked.and_then(|_| Maker { textures: self, place: &declaration }.make(&declaration.class));
        let (slot, outcome) = match made {
            Ok(input) => (Slot::Made(input), Ok(())),
            Err(SceneError::Unsupported { location, message }) => (Slot::Unsupported { location, message }, Ok(())),
            Err(error) => (Slot::Faulty, Err(error)),
        };
        self.named.insert(key, slot);
        outcome
    }

    /// Returns a colour with channels from 0 to 1, or a texture of colours.
    pub fn color(&self, param: &Param) -> Result<Input<Rgb>, SceneError> {
        if param.kind == Kind::Texture {
            return self.find(Values::Colors, param);
        }
        let rgb = Spectrum::from_param(param)?.reflectance();
        if rgb.min_element() < 0.0 || rgb.max_element() > 1.0 {
            return Err(param.bad_value("channels from 0 to 1"));
        }
        Ok(Input::Constant(rgb))
    }

    /// Returns a number, or a texture of numbers.
    pub fn number(&self, param: &Param) -> Result<Input<f64>, SceneError> {
        if param.kind != Kind::Texture {
            let [value] = param.one()?;
            return Ok(Input::Constant(value));
        }
        Ok(match self.find(Values::Numbers, param)? {
            Input::Constant(value) => Input::Constant(value.x),
            Input::Texture(index) => Input::Texture(index),
        })
    }

    /// Returns the mean of an input over the texture's own domain, and true if the input is a texture.
    ///
    /// # Errors
    /// The images read so far have more pixels than the budget allows to be read; `location` is the error's
    /// place.
    pub fn mean_color(&self, input: Input<Rgb>, location: &Location) -> Result<(Rgb, bool), SceneError> {
        match input {
            Input::Constant(value) => Ok((value, false)),
            Input::Texture(index) => {
                let mean = self.means.borrow_mut().of(index, &self.made, &self.budget).map_err(location.over())?;
                Ok((mean, true))
            }
        }
    }

    /// Returns the mean of an input of numbers, as [`mean_color`](Self::mean_color) does for colours.
    pub fn mean_number(&self, input: Input<f64>, location: &Location) -> Result<(f64, bool), SceneError> {
        self.mean_color(as_color(input), location).map(|(mean, is_texture)| (mean.x, is_texture))
    }

    /// Returns the image of an area light.
    pub fn emission(&mut self, path: PathBuf, param: &Param) -> Result<EmissionImage, SceneError> {
        let image = self.image(path, ("sRGB".to_string(), Transfer::Srgb), (Values::Colors, Use::Light), param)?;
        let mean = *self.shown.entry(Arc::as_ptr(&image)).or_insert_with(|| {
            let sum: Rgb = image.pixels.iter().map(|pixel| Rgb::from(pixel.map(f64::from)).max(Rgb::ZERO)).sum();
            sum / image.pixels.len() as f64
        });
        let shown = ImageTexture { range: [0.0, f64::INFINITY], ..whole(image, Wrap::Clamp) };
        Ok(EmissionImage { texture: self.add_image(shown, param)?, mean })
    }

    /// Returns the index of the texture of a normal map, whose values are directions: x along u, z out of the
    /// surface. As in pbrt, the image is linear, whatever its encoding, and a value v in [0, 1] stands for 2v - 1.
    pub fn normal_map(&mut self, name: &str, param: &Param) -> Result<usize, SceneError> {
        let encoding = ("linear".to_string(), Transfer::Linear);
        let image = self.image(self.directory.join(name), encoding, (Values::Colors, Use::Reflectance), param)?;
        self.add_image(ImageTexture { offset: -1.0, factor: 2.0, ..whole(image, Wrap::Repeat) }, param)
    }

    /// Adds a texture that a parameter gives without a `Texture`, and returns its index.
    fn add_image(&mut self, image: ImageTexture, param: &Param) -> Result<usize, SceneError> {
        self.budget.take(size_of::<Texture>() as u64).map_err(param.location.over())?;
        self.made.push(Texture { kind: TextureKind::Image(image), location: param.location.to_string() });
        Ok(self.made.len() - 1)
    }

    /// Returns the measured material in a file, whose name is at `location`.
    pub fn measured(&self, name: &str, location: &Location) -> Result<Arc<Measured>, SceneError> {
        self.measured.get(&self.directory.join(name), &self.budget, location)
    }

    fn find(&self, values: Values, param: &Param) -> Result<Input<Rgb>, SceneError> {
        let name = param.text().ok_or_else(|| param.bad_value("the name of one texture"))?;
        match self.named.get(&(values, name.to_string())) {
            Some(Slot::Made(input)) => Ok(*input),
            Some(Slot::Unsupported { location, message }) => {
                Err(SceneError::Unsupported { location: location.clone(), message: message.clone() })
            }
            // The error has been reported, and this scene is refused anyway.
            Some(Slot::Faulty) => Ok(Input::Constant(Rgb::splat(0.5))),
            Some(Slot::Waiting(_)) | None => {
                let kind = if values == Values::Numbers { "float" } else { "spectrum" };
                let known = self.known(values);
                Err(param.bad_value(&format!("the name of a Texture of type \"{kind}\"; known here: {known}")))
            }
        }
    }

    /// Returns the names of known textures, for an error message.
    fn known(&self, values: Values) -> String {
        let mut names: Vec<&str> =
            self.named.keys().filter(|key| key.0 == values).map(|key| key.1.as_str()).take(MOST_LISTED + 1).collect();
        match names.len() {
            0 => "there is none".to_string(),
            1..=MOST_LISTED => {
                names.sort_unstable();
                shorten(&names.join(", "))
            }
            _ => format!("more than {MOST_LISTED}"),
        }
    }

    /// Returns an image by its file and its encoding: the encoding as written, and its transfer function.
    pub(in crate::scene) fn image(
        &mut self,
        path: PathBuf,
        encoding: (String, Transfer),
        (values, of): (Values, Use),
        param: &Param,
    ) -> Result<Arc<Image>, SceneError> {
        let key = (path, encoding.0, values, of);
        if let Some(image) = self.images.get(&key) {
            return Ok(Arc::clone(image));
        }
        let layers = read_layers(&key.0, encoding.1, of, &self.budget).map_err(|error| match error {
            ImageError::Read { path, reason } => {
                SceneError::Unreadable { path, location: Some(param.location.clone()), source: reason }
            }
            error => param.location.invalid(error.to_string()),
        })?;
        let mut image = layers.image;
        if image.pixels.iter().flatten().any(|value| !value.is_finite()) {
            return Err(param.bad_value("an image whose pixels are all finite"));
        }
        self.texels += image.pixels.len() as u64;
        if self.texels > MAX_TEXELS {
            return Err(param.location.invalid(format!(
                "the images of textures have {} pixels up to this one; expected at most {MAX_TEXELS}",
                self.texels
            )));
        }
        if values == Values::Numbers {
            // As in pbrt: alpha if the image has it, otherwise the mean of the channels.
            for (i, pixel) in image.pixels.iter_mut().enumerate() {
                let mean = (pixel[0] + pixel[1] + pixel[2]) / 3.0;
                *pixel = [layers.alpha.as_ref().map_or(mean, |alpha| alpha[i]); 3];
            }
        }
        // The values of alpha are in the pixels, or are not used.
        self.budget.give_back(layers.alpha.as_ref().map_or(0, |alpha| size_of_val(&alpha[..]) as u64));
        let image = Arc::new(image);
        self.images.insert(key, Arc::clone(&image));
        Ok(image)
    }
}

/// Returns the texture of an image that a surface's own coordinates span.
fn whole(image: Arc<Image>, wrap: Wrap) -> ImageTexture {
    ImageTexture {
        image,
        mapping: Mapping::Surface(DAffine3::IDENTITY),
        wrap,
        nearest: false,
        offset: 0.0,
        factor: 1.0,
        range: [f64::NEG_INFINITY, f64::INFINITY],
    }
}

/// Returns the name of the texture that a parameter names, if any.
fn texture_name(param: &Param) -> Option<&str> {
    param.text().filter(|_| param.kind == Kind::Texture)
}

impl Declaration {
    /// Returns the keys of the textures that the declaration uses. Amounts and factors are numbers in all
    /// classes.
    fn needs(&self) -> Vec<Key> {
        let need = |param: &Param| {
            let is_number = self.values == Values::Numbers || matches!(param.name.as_str(), "amount" | "scale");
            let values = if is_number { Values::Numbers } else { Values::Colors };
            texture_name(param).map(|name| (values, name.to_string()))
        };
        let of_own = |param: &&Param| self.params.get(&param.name).is_none();
        self.params.items.iter().chain(self.defaults.items.iter().filter(of_own)).filter_map(need).collect()
    }
}
