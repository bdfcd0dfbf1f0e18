//! The graphics state, and the scene that directives build.

// Circle: state.rs <-> media.rs <-> options.rs <-> transforms.rs: methods of SceneBuilder by topic, each with the part of the state that they change.
mod collected;
mod defaults;
mod media;
mod options;
mod resolve;
mod transforms;

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DAffine3;

use crate::base::input::Budget;
use crate::scene::directives::light;
use crate::scene::directives::material;
use crate::scene::directives::object::Objects;
use crate::scene::directives::shape;
use crate::scene::directives::shape::MeshFiles;
use crate::scene::directives::texture::{Declaration, Textures, Values};
use crate::scene::directives::transform;
use crate::scene::format::error::{Location, SceneError, bounded};
use crate::scene::format::lexer::shorten;
use crate::scene::format::params::ParamList;
use crate::scene::format::registry::Ignored;
use crate::scene::model::{AreaLight, ByWavelength, Input, Instance, Light, Material, MediumInterface, Rgb, Shape};
use crate::scene::spectrum::color_space::ColorSpace;
pub(in crate::scene) use collected::Collected;
use media::{NamedInterface, NamedMedia};
pub(in crate::scene) use options::SceneOptions;
pub(in crate::scene) use transforms::ActiveTimes;

/// The attributes of the next shape or light.
#[derive(Clone, Debug)]
struct GraphicsState {
    /// Transform at the start time, which is the one that is rendered.
    world_from_object: DAffine3,
    /// Transform at the end time.
    world_from_object_at_end: DAffine3,
    active: ActiveTimes,
    color_space: ColorSpace,
    reverse_orientation: bool,
    material: MaterialRef,
    emission: Option<AreaLight>,
    /// Media on both sides of shapes; `None` for a vacuum.
    media: Option<Arc<NamedInterface>>,
    /// Default parameters set by `Attribute`.
    shape_defaults: Arc<ParamList>,
    light_defaults: Arc<ParamList>,
    material_defaults: Arc<ParamList>,
    texture_defaults: Arc<ParamList>,
    medium_defaults: Arc<ParamList>,
}

/// A material's slot, or its name, which is looked up at the end because a scene may define it later.
#[derive(Clone, Debug)]
enum MaterialRef {
    Slot(usize),
    Named(Arc<str>, Location),
}

/// A material, or a mix whose parts are looked up at the end.
#[derive(Clone, Debug)]
enum Made {
    Material(Material),
    Mix {
        parts: [MaterialRef; 2],
        amount: Input<f64>,
        location: Location,
    },
    /// A material with a texture that is not defined yet: its type and checked parameters.
    Waiting {
        kind: String,
        params: ParamList,
        location: Location,
    },
}

/// A shape, and its references that are resolved at the end.
#[derive(Debug)]
struct PendingShape {
    shape: Shape,
    material: MaterialRef,
    media: Option<Arc<NamedInterface>>,
    /// The alpha parameter, if it names a texture that is not defined yet.
    alpha: Option<ParamList>,
}

/// A material of the scene file. A material that goblet cannot render is an error only if a shape uses it.
#[derive(Debug)]
struct MaterialSlot {
    made: Result<Made, SceneError>,
    /// Set when the first shape that uses the material is resolved.
    used: Option<Used>,
}

/// Place of a material in use.
#[derive(Clone, Copy, Debug)]
struct Used {
    /// Index into [`Scene::materials`].
    index: usize,
    /// Depth of nested mixes.
    depth: u32,
}

/// Maximum depth of nested mixes.
const MAX_MIX_DEPTH: u32 = 4;

/// A saved state of an enclosing block.
#[derive(Debug)]
struct Saved {
    state: GraphicsState,
    /// Place where the block begins.
    begin: Location,
    /// The directive that ends the block.
    end: &'static str,
}

/// Builds a [`Scene`] directive by directive.
#[derive(Debug)]
pub(in crate::scene) struct SceneBuilder {
    pub options: SceneOptions,
    world: bool,
    state: GraphicsState,
    saved: Vec<Saved>,
    /// Transforms by name, at the start time and at the end time.
    coordinate_systems: HashMap<String, [DAffine3; 2]>,
    warned_of_motion: bool,
    slots: Vec<MaterialSlot>,
    named: HashMap<Arc<str>, usize>,
    shapes: Vec<PendingShape>,
    /// Number of `Shape "revolution"` directives so far.
    revolutions: usize,
    objects: Objects,
    lights: Vec<Light>,
    /// The interface in force at each light.
    light_media: Vec<Option<Arc<NamedInterface>>>,
    light_curves: Vec<Option<ByWavelength>>,
    /// The interface in force at the camera.
    camera_media: Option<Arc<NamedInterface>>,
    media: NamedMedia,
    files: MeshFiles,
    textures: Textures,
    /// Files that the scene includes or imports.
    pub included: Vec<PathBuf>,
    /// Every file that the scene reads besides its own.
    pub inputs: Vec<PathBuf>,
    warnings: Vec<String>,
    /// Number of warnings that are not kept.
    more_warnings: u64,
    /// Parameters that cannot change the image.
    ignored: Ignored,
    budget: Arc<Budget>,
    /// Errors so far, if all errors are collected.
    collected: Option<Collected>,
}

impl SceneBuilder {
    /// Returns an empty scene. File names in the scene are relative to `directory`.
    pub fn new(directory: &Path, budget: &Arc<Budget>) -> Self {
        let default_material = MaterialSlot { made: Ok(Made::Material(material::default())), used: None };
        Self {
            options: SceneOptions::default(),
            world: false,
            state: GraphicsState {
                world_from_object: DAffine3::IDENTITY,
                world_from_object_at_end: DAffine3::IDENTITY,
                active: ActiveTimes::ALL,
                color_space: ColorSpace::default(),
                reverse_orientation: false,
                material: MaterialRef::Slot(0),
                emission: None,
                media: None,
                shape_defaults: Arc::default(),
                light_defaults: Arc::default(),
                material_defaults: Arc::default(),
                texture_defaults: Arc::default(),
                medium_defaults: Arc::default(),
            },
            saved: Vec::new(),
            coordinate_systems: HashMap::new(),
            warned_of_motion: false,
            slots: vec![default_material],
            named: HashMap::new(),
            shapes: Vec::new(),
            revolutions: 0,
            objects: Objects::default(),
            lights: Vec::new(),
            light_media: Vec::new(),
            light_curves: Vec::new(),
            camera_media: None,
            media: NamedMedia::default(),
            files: MeshFiles::new(directory, budget),
            textures: Textures::new(directory, budget),
            included: Vec::new(),
            inputs: Vec::new(),
            warnings: Vec::new(),
            more_warnings: 0,
            ignored: Ignored::default(),
            budget: Arc::clone(budget),
            collected: None,
        }
    }

    pub fn set_color_space(&mut self, space: ColorSpace) {
        self.state.color_space = space;
    }

    pub fn color_space(&self) -> ColorSpace {
        self.state.color_space
    }

    /// Returns the folder of the scene file.
    pub fn directory(&self) -> &Path {
        &self.files.directory
    }

    pub fn warn(&mut self, location: &impl fmt::Display, message: &str) {
        if self.warnings.len() < MOST_WARNINGS {
            self.warnings.push(bounded(format!("{location}: {message}")));
        } else {
            self.more_warnings += 1;
        }
    }

    /// Charges the budget for a value of type `T` and the bytes that it refers to.
    fn keep<T>(&self, bytes: usize, location: &Location) -> Result<(), SceneError> {
        self.budget.take((size_of::<T>() + bytes) as u64).map_err(location.over())
    }

    /// Fails unless `directive` is after `WorldBegin`, or before it if `world` is false.
    pub fn require_world(&mut self, world: bool, directive: &str, location: &Location) -> Result<(), SceneError> {
        let (found, expected) = match (self.world, world) {
            (true, false) => ("after", "before"),
            (false, true) => ("before", "after"),
            _ => return Ok(()),
        };
        // A missing WorldBegin is reported once, even if all errors are collected.
        self.world = true;
        Err(location.invalid(format!("{directive} stands {found} WorldBegin; expected it {expected} WorldBegin")))
    }

    pub fn world_begin(&mut self, location: &Location) -> Result<(), SceneError> {
        self.require_world(false, "a second WorldBegin", location)?;
        self.world = true;
        self.reset_transforms();
        Ok(())
    }

    pub fn attribute_begin(&mut self, location: &Location) -> Result<(), SceneError> {
        self.begin_block(location, "AttributeEnd")
    }

    pub fn attribute_end(&mut self, location: &Location) -> Result<(), SceneError> {
        self.end_block(location, "AttributeEnd")
    }

    pub fn object_begin(&mut self, name: &str, location: &Location) -> Result<(), SceneError> {
        self.keep::<(Arc<str>, usize)>(name.len() + ENTRY_BYTES, location)?;
        self.objects.begin(name, location)?;
        self.begin_block(location, "ObjectEnd")
    }

    pub fn object_end(&mut self, location: &Location) -> Result<(), SceneError> {
        self.end_block(location, "ObjectEnd")?;
        self.objects.end();
        Ok(())
    }

    pub fn object_instance(&mut self, name: &str, location: &Location) -> Result<(), SceneError> {
        let world_from_instance = self.state.world_from_object;
        check_finite(&world_from_instance, location)?;
        if !transform::is_invertible(&world_from_instance) {
            self.warn(location, FLATTENED);
            return Ok(());
        }
        self.keep::<(Instance, Location)>(name.len() + ENTRY_BYTES, location)?;
        self.objects.instance(name, location, world_from_instance)
    }

    fn begin_block(&mut self, location: &Location, end: &'static str) -> Result<(), SceneError> {
        self.keep::<Saved>(0, location)?;
        self.saved.push(Saved { state: self.state.clone(), begin: location.clone(), end });
        Ok(())
    }

    fn end_block(&mut self, location: &Location, end: &'static str) -> Result<(), SceneError> {
        let Some(saved) = self.saved.pop() else {
            return Err(location.invalid("this ends a block that was never begun"));
        };
        self.budget.give_back(size_of::<Saved>() as u64);
        if saved.end != end {
            let (begin, expected) = (&saved.begin, saved.end);
            return Err(location.invalid(format!("found {end}; expected {expected} for what begins at {begin}")));
        }
        self.state = saved.state;
        Ok(())
    }

    pub fn reverse_orientation(&mut self) {
        self.state.reverse_orientation = !self.state.reverse_orientation;
    }

    pub fn material(&mut self, name: &str, params: ParamList, location: &Location) -> Result<(), SceneError> {
        self.state.material = MaterialRef::Slot(self.make_material(name, params, location)?);
        Ok(())
    }

    pub fn make_named_material(
        &mut self,
        name: &str,
        mut params: ParamList,
        location: &Location,
    ) -> Result<(), SceneError> {
        let Some(kind) = params.take("type") else {
            return Err(location
                .invalid(format!("MakeNamedMaterial \"{}\" has no \"string type\"; expected one", shorten(name))));
        };
        let Some(kind) = kind.text() else {
            return Err(kind.bad_value("the name of a material type"));
        };
        let made = self.make_material(kind, params, location);
        self.keep::<(Arc<str>, usize)>(name.len() + ENTRY_BYTES, location)?;
        // An invalid material keeps its name, so that its use causes no second error.
        if self.named.insert(name.into(), *made.as_ref().unwrap_or(&0)).is_some() {
            return Err(
                location.invalid(format!("a material \"{}\" exists already; expected a new name", shorten(name)))
            );
        }
        made.map(drop)
    }

    fn make_material(&mut self, kind: &str, mut params: ParamList, location: &Location) -> Result<usize, SceneError> {
        // pbrt's old name of "interface".
        let kind = if kind.is_empty() || kind == "none" { "interface" } else { kind };
        let defaults = &self.state.material_defaults;
        let made = material::FAMILY.check(kind, location, &mut params, defaults, &mut self.ignored).and_then(|_| {
            if self.textures.has_all(&params) {
                return self.material_of(kind, &params, location);
            }
            Ok(Made::Waiting { kind: kind.to_string(), params: params.clone(), location: location.clone() })
        });
        if let Err(error) = &made
            && !matches!(error, SceneError::Unsupported { .. })
        {
            return made.map(|_| 0);
        }
        // A used material is stored twice: as it was made, and in the scene.
        self.keep::<[MaterialSlot; 2]>(0, location)?;
        self.slots.push(MaterialSlot { made, used: None });
        Ok(self.slots.len() - 1)
    }

    fn material_of(&mut self, kind: &str, params: &ParamList, location: &Location) -> Result<Made, SceneError> {
        if kind != "mix" {
            let (material, warnings) = material::material(kind, params, &mut self.textures, location)?;
            warnings.into_iter().for_each(|warning| self.warn(location, &warning));
            return Ok(Made::Material(material));
        }
        let (names, amount) = material::mix(params, &self.textures, location)?;
        let parts = names.map(|name| MaterialRef::Named(name.into(), location.clone()));
        Ok(Made::Mix { parts, amount, location: location.clone() })
    }

    pub fn named_material(&mut self, name: &str, location: &Location) {
        self.state.material = MaterialRef::Named(name.into(), location.clone());
    }

    /// Executes `Texture`; `location` is the place of the class.
    pub fn texture(
        &mut self,
        name: String,
        values: Values,
        class: String,
        params: ParamList,
        location: &Location,
    ) -> Result<(), SceneError> {
        let (world_from_texture, defaults) = (self.state.world_from_object, Arc::clone(&self.state.texture_defaults));
        let location = location.clone();
        self.textures.declare(Declaration { name, values, class, location, params, world_from_texture, defaults })
    }

    pub fn light(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        self.warn_of_motion(location);
        light::FAMILY.check(name, location, &mut params, &self.state.light_defaults, &mut self.ignored)?;
        let mut warnings = Vec::new();
        let world_from_light = self.state.world_from_object;
        check_finite(&world_from_light, location)?;
        self.keep::<Light>(0, location)?;
        let light = light::light(name, &params, &self.files, world_from_light, location, &mut warnings)?;
        for warning in warnings {
            self.warn(location, &warning);
        }
        if let Light::Spot { .. } = light
            && !transform::keeps_angles(&self.state.world_from_object)
        {
            self.warn(location, "the transform would distort the spot light's cone; the cone stays round");
        }
        if light::emission(&light) != Rgb::ZERO {
            self.lights.push(light);
            self.light_media.push(self.state.media.clone());
            self.light_curves.push(light::curve(&params)?);
        }
        Ok(())
    }

    pub fn area_light(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        light::AREA_FAMILY.check(name, location, &mut params, &self.state.light_defaults, &mut self.ignored)?;
        let light = light::area_light(&params, &mut self.textures, &self.files.directory)?;
        let shines = |light: &AreaLight| light.radiance * light.image.map_or(Rgb::ONE, |image| image.mean) != Rgb::ZERO;
        self.state.emission = Some(light).filter(shines);
        Ok(())
    }

    /// Adds a shape. `location` is the place of its type, `directive` the place of the directive.
    pub fn shape(
        &mut self,
        name: &str,
        mut params: ParamList,
        location: &Location,
        directive: &Location,
    ) -> Result<(), SceneError> {
        self.warn_of_motion(location);
        let revolution = (name == "revolution").then_some(self.revolutions);
        self.revolutions += usize::from(revolution.is_some());
        shape::FAMILY.check(name, location, &mut params, &self.state.shape_defaults, &mut self.ignored)?;
        let waits = !self.textures.has_all(&params);
        let alpha = if waits { Input::Constant(1.0) } else { shape::alpha(&params, &self.textures)? };
        let mut emission = self.state.emission.clone();
        if emission.is_some() && self.objects.open().is_some() {
            emission = None;
            if self.objects.is_first_emitter() {
                self.warn(
                    directive,
                    "a shape of an object emits no light: as in pbrt, only shapes outside of objects do",
                );
            }
        }
        self.keep::<PendingShape>(SHAPE_BYTES, directive)?;
        let mut geometry = shape::geometry(name, &params, &mut self.files, location)?;
        if emission.as_ref().is_some_and(|emission| emission.power.is_some()) {
            shape::check_power(name, &geometry, location)?;
        }
        let world_from_object = self.state.world_from_object;
        check_finite(&world_from_object, directive)?;
        if !geometry.hull_all(|point| world_from_object.transform_point3(point).is_finite()) {
            return Err(directive.invalid(OVERFLOWS));
        }
        if !transform::is_invertible(&world_from_object) && !shape::stays_when_flattened(&mut geometry) {
            self.warn(directive, FLATTENED);
            return Ok(());
        }
        let placed = geometry.placed_bytes(emission.is_some());
        self.budget.take_later(placed).map_err(directive.over())?;
        let shape = Shape {
            geometry,
            alpha,
            world_from_object,
            reverse_orientation: self.state.reverse_orientation,
            material: 0,
            media: MediumInterface::default(),
            emission,
            object: self.objects.open(),
            revolution,
            location: directive.to_string(),
        };
        let material = self.state.material.clone();
        // Other parameters may be large and are dropped.
        let alpha = params.take("alpha").filter(|_| waits).map(ParamList::of);
        self.shapes.push(PendingShape { shape, material, media: self.state.media.clone(), alpha });
        Ok(())
    }
}

/// The warning about a shape or an instance that its transform flattens.
const FLATTENED: &str = "its transform flattens it to a plane, a line or a point; it is not rendered, because no ray can hit it, as in pbrt";

/// The error about coordinates in world space that are not finite.
const OVERFLOWS: &str = "coordinates overflow, in the shape or by its transform; expected smaller numbers";

/// Maximum number of warnings that are kept; more are counted.
const MOST_WARNINGS: usize = 1000;
/// Approximate bytes of an entry of a table besides its key and value.
const ENTRY_BYTES: usize = 64;
/// Bytes of a shape besides [`PendingShape`]: its location, and a copy of it during packing.
const SHAPE_BYTES: usize = size_of::<Shape>() + ENTRY_BYTES;

/// Fails if a transform is not finite.
fn check_finite(transform: &DAffine3, location: &Location) -> Result<(), SceneError> {
    if transform.is_finite() {
        return Ok(());
    }
    Err(location.invalid("the transform overflows here; expected smaller numbers"))
}
