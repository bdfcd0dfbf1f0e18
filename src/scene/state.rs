//! The graphics state, and the scene that grows under it.

mod options;
mod place;
mod survey;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DAffine3;

use super::color::ColorSpace;
use super::error::{Location, SceneError};
use super::lexer::shorten;
use super::model::{AreaLight, Input, Light, Material, Rgb, Scene, Shape};
use super::object::Objects;
use super::params::ParamList;
use super::shape::MeshFiles;
use super::texture::{Place, Textures, Values};
use super::{light, material, missing_light, shape, transform};
use options::Options;
pub(super) use place::ActiveTimes;

/// What applies to the next shape or light.
#[derive(Clone, Debug)]
struct GraphicsState {
    /// At the start time, as which all is rendered.
    world_from_object: DAffine3,
    /// At the end time.
    world_from_object_at_end: DAffine3,
    active: ActiveTimes,
    color_space: ColorSpace,
    reverse_orientation: bool,
    material: MaterialRef,
    emission: Option<AreaLight>,
    /// What `Attribute` has set.
    shape_defaults: Arc<ParamList>,
    light_defaults: Arc<ParamList>,
    material_defaults: Arc<ParamList>,
    texture_defaults: Arc<ParamList>,
}

/// A material, by its place among all or by a name that is looked up at the end:
/// a scene may name a material before it makes it.
#[derive(Clone, Debug)]
enum MaterialRef {
    Slot(usize),
    Named(Arc<str>, Location),
}

/// A material, or two that are looked up at the end.
#[derive(Clone, Debug)]
enum Made {
    Material(Material),
    Mix { parts: [MaterialRef; 2], amount: Input<f64>, location: Location },
}

/// A material of the scene file. One that goblet cannot render is an error only
/// once a shape is made of it.
#[derive(Debug)]
struct MaterialSlot {
    made: Result<Made, SceneError>,
    /// Its place in [`Scene::materials`], once a shape is made of it.
    index: Option<usize>,
}

/// Mixes may be of mixes.
const MAX_MIX_DEPTH: u32 = 4;

/// A state to return to.
#[derive(Debug)]
struct Saved {
    state: GraphicsState,
    /// Where the block begins.
    begin: Location,
    /// The directive that ends it.
    end: &'static str,
}

/// Builds a [`Scene`] directive by directive.
#[derive(Debug)]
pub(super) struct SceneBuilder {
    pub options: Options,
    world: bool,
    state: GraphicsState,
    saved: Vec<Saved>,
    /// Each at the start time and at the end time.
    coordinate_systems: HashMap<String, [DAffine3; 2]>,
    warned_of_motion: bool,
    slots: Vec<MaterialSlot>,
    named: HashMap<Arc<str>, usize>,
    shapes: Vec<(Shape, MaterialRef)>,
    objects: Objects,
    lights: Vec<Light>,
    files: MeshFiles,
    textures: Textures,
    /// Files that the scene includes or imports.
    pub included: Vec<PathBuf>,
    warnings: Vec<String>,
    /// Set where everything that is not supported is to be found.
    unsupported: Option<Vec<SceneError>>,
}

impl SceneBuilder {
    /// File names in the scene are relative to `directory`.
    pub fn new(directory: &Path) -> Self {
        let default_material = MaterialSlot { made: Ok(Made::Material(material::default())), index: None };
        Self {
            options: Options::default(),
            world: false,
            state: GraphicsState {
                world_from_object: DAffine3::IDENTITY,
                world_from_object_at_end: DAffine3::IDENTITY,
                active: ActiveTimes::ALL,
                color_space: ColorSpace::default(),
                reverse_orientation: false,
                material: MaterialRef::Slot(0),
                emission: None,
                shape_defaults: Arc::default(),
                light_defaults: Arc::default(),
                material_defaults: Arc::default(),
                texture_defaults: Arc::default(),
            },
            saved: Vec::new(),
            coordinate_systems: HashMap::new(),
            warned_of_motion: false,
            slots: vec![default_material],
            named: HashMap::new(),
            shapes: Vec::new(),
            objects: Objects::default(),
            lights: Vec::new(),
            files: MeshFiles::new(directory),
            textures: Textures::default(),
            included: Vec::new(),
            warnings: Vec::new(),
            unsupported: None,
        }
    }

    /// The colour space of the values to come.
    pub fn set_color_space(&mut self, space: ColorSpace) {
        self.state.color_space = space;
    }

    /// The colour space in force.
    pub fn color_space(&self) -> ColorSpace {
        self.state.color_space
    }

    /// The folder of the scene file.
    pub fn directory(&self) -> &Path {
        &self.files.directory
    }

    pub fn warn(&mut self, location: &Location, message: &str) {
        self.warnings.push(format!("{location}: {message}"));
    }

    /// Fails unless `directive` stands after `WorldBegin`, or before it where
    /// `world` is false.
    pub fn require_world(&self, world: bool, directive: &str, location: &Location) -> Result<(), SceneError> {
        let (found, expected) = match (self.world, world) {
            (true, false) => ("after", "before"),
            (false, true) => ("before", "after"),
            _ => return Ok(()),
        };
        Err(location.invalid(format!("{directive} stands {found} WorldBegin; expected it {expected} WorldBegin")))
    }

    pub fn world_begin(&mut self, location: &Location) -> Result<(), SceneError> {
        self.require_world(false, "a second WorldBegin", location)?;
        self.world = true;
        self.reset_transforms();
        Ok(())
    }

    pub fn attribute_begin(&mut self, location: &Location) {
        self.begin_block(location, "AttributeEnd");
    }

    pub fn attribute_end(&mut self, location: &Location) -> Result<(), SceneError> {
        self.end_block(location, "AttributeEnd")
    }

    pub fn object_begin(&mut self, name: &str, location: &Location) -> Result<(), SceneError> {
        self.objects.begin(name, location)?;
        self.begin_block(location, "ObjectEnd");
        Ok(())
    }

    pub fn object_end(&mut self, location: &Location) -> Result<(), SceneError> {
        self.end_block(location, "ObjectEnd")?;
        self.objects.end();
        Ok(())
    }

    pub fn object_instance(&mut self, name: &str, location: &Location) -> Result<(), SceneError> {
        self.objects.instance(name, location, self.state.world_from_object)
    }

    fn begin_block(&mut self, location: &Location, end: &'static str) {
        self.saved.push(Saved { state: self.state.clone(), begin: location.clone(), end });
    }

    fn end_block(&mut self, location: &Location, end: &'static str) -> Result<(), SceneError> {
        let Some(saved) = self.saved.pop() else {
            return Err(location.invalid("this ends a block that was never begun"));
        };
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

    /// `Attribute`: parameters that later directives take unless they have them.
    pub fn attribute(&mut self, target: &str, params: ParamList, location: &Location) -> Result<(), SceneError> {
        let defaults = match target {
            "shape" => &mut self.state.shape_defaults,
            "light" => &mut self.state.light_defaults,
            "material" => &mut self.state.material_defaults,
            "texture" => &mut self.state.texture_defaults,
            // Media are not read, so neither are their defaults.
            "medium" => return Ok(()),
            _ => {
                return Err(location.invalid(format!(
                    "unknown Attribute \"{}\"; expected one of: \"shape\", \"light\", \
                     \"material\", \"medium\", \"texture\"",
                    shorten(target)
                )));
            }
        };
        let defaults = Arc::make_mut(defaults);
        for param in params.items {
            defaults.take(&param.name);
            defaults.items.push(param);
        }
        Ok(())
    }

    pub fn material(&mut self, name: &str, params: ParamList, location: &Location) -> Result<(), SceneError> {
        // pbrt's old name of it.
        let name = if name.is_empty() || name == "none" { "interface" } else { name };
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
        let slot = self.make_material(kind, params, location)?;
        if self.named.insert(name.into(), slot).is_some() {
            return Err(
                location.invalid(format!("a material \"{}\" exists already; expected a new name", shorten(name)))
            );
        }
        Ok(())
    }

    fn make_material(&mut self, kind: &str, mut params: ParamList, location: &Location) -> Result<usize, SceneError> {
        let defaults = &self.state.material_defaults;
        let made = material::FAMILY
            .check(kind, location, &mut params, defaults)
            .and_then(|_| self.material_of(kind, &params, location));
        if let Err(error) = &made
            && !matches!(error, SceneError::Unsupported { .. })
        {
            return made.map(|_| 0);
        }
        self.slots.push(MaterialSlot { made, index: None });
        Ok(self.slots.len() - 1)
    }

    fn material_of(&self, kind: &str, params: &ParamList, location: &Location) -> Result<Made, SceneError> {
        if kind != "mix" {
            return material::material(kind, params, &self.textures, location).map(Made::Material);
        }
        let (names, amount) = material::mix(params, &self.textures, location)?;
        let parts = names.map(|name| MaterialRef::Named(name.into(), location.clone()));
        Ok(Made::Mix { parts, amount, location: location.clone() })
    }

    pub fn named_material(&mut self, name: &str, location: &Location) {
        self.state.material = MaterialRef::Named(name.into(), location.clone());
    }

    /// A texture of a class that is named at `location`.
    pub fn texture(
        &mut self,
        name: &str,
        values: Values,
        class: &str,
        params: ParamList,
        location: &Location,
    ) -> Result<(), SceneError> {
        let place = Place {
            directory: &self.files.directory,
            world_from_texture: self.state.world_from_object,
            defaults: &self.state.texture_defaults,
            location,
        };
        for warning in self.textures.make(name, values, class, params, &place)? {
            self.warn(location, &warning);
        }
        Ok(())
    }

    pub fn light(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        self.warn_of_motion(location);
        light::FAMILY.check(name, location, &mut params, &self.state.light_defaults)?;
        let mut warnings = Vec::new();
        let world_from_light = self.state.world_from_object;
        let light = light::light(name, &params, &self.files.directory, world_from_light, location, &mut warnings)?;
        for warning in warnings {
            self.warn(location, &warning);
        }
        if let Light::Spot { .. } = light
            && !transform::keeps_angles(&self.state.world_from_object)
        {
            self.warn(location, "the spot light's cone is kept round in spite of its transform");
        }
        if light::emission(&light) != Rgb::ZERO {
            self.lights.push(light);
        }
        Ok(())
    }

    pub fn area_light(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        light::AREA_FAMILY.check(name, location, &mut params, &self.state.light_defaults)?;
        let light = light::area_light(&params, &mut self.textures, &self.files.directory)?;
        let shines = |light: &AreaLight| light.radiance * light.image.map_or(Rgb::ONE, |image| image.mean) != Rgb::ZERO;
        self.state.emission = Some(light).filter(shines);
        Ok(())
    }

    /// A shape, its type named at `location`, in the directive at `directive`.
    pub fn shape(
        &mut self,
        name: &str,
        mut params: ParamList,
        location: &Location,
        directive: &Location,
    ) -> Result<(), SceneError> {
        self.warn_of_motion(location);
        shape::FAMILY.check(name, location, &mut params, &self.state.shape_defaults)?;
        let alpha = shape::alpha(&params, &self.textures)?;
        let mut emission = self.state.emission;
        if emission.is_some() && self.objects.open().is_some() {
            emission = None;
            if self.objects.is_first_emitter() {
                self.warn(directive, "shapes of an object emit no light; as in pbrt, only those outside do");
            }
        }
        let geometry = shape::geometry(name, &params, &mut self.files, location)?;
        if emission.is_some_and(|emission| emission.power.is_some()) {
            shape::check_power(name, &geometry, location)?;
        }
        let shape = Shape {
            geometry,
            alpha,
            world_from_object: self.state.world_from_object,
            reverse_orientation: self.state.reverse_orientation,
            material: 0,
            emission,
            object: self.objects.open(),
            location: directive.to_string(),
        };
        // Nothing meets what is not there; light may still come from it, as in pbrt.
        if alpha != Input::Constant(0.0) || shape.emission.is_some() {
            self.shapes.push((shape, self.state.material.clone()));
        }
        Ok(())
    }

    /// The scene; `end` is where its file ends.
    pub fn finish(mut self, end: &Location) -> Result<Scene, SceneError> {
        self.resolve(end)
    }

    fn resolve(&mut self, end: &Location) -> Result<Scene, SceneError> {
        if !self.world {
            return Err(end.invalid("the file ends before WorldBegin; expected a WorldBegin"));
        }
        if let Some(Saved { begin, end, .. }) = self.saved.last() {
            return Err(begin.invalid(format!("this block is never ended; expected {end}")));
        }
        let (shapes, materials) = self.resolve_materials()?;
        let instances = std::mem::take(&mut self.objects).resolve(&shapes)?;
        if shapes.is_empty() {
            return Err(end.invalid("the scene has no shape; expected at least one Shape"));
        }
        if self.lights.is_empty() && shapes.iter().all(|shape| shape.emission.is_none()) {
            return Err(
                end.invalid("the scene has no light; expected a LightSource or AreaLightSource that is not black")
            );
        }
        if !self.options.has_camera() {
            self.warn(end, "the scene has no Camera; it is seen from the origin along +z");
        }
        let (film, camera, integrator) = std::mem::take(&mut self.options).resolve()?;
        let (lights, warnings) = (std::mem::take(&mut self.lights), std::mem::take(&mut self.warnings));
        let textures = std::mem::take(&mut self.textures).made;
        let included = std::mem::take(&mut self.included);
        let mut scene =
            Scene { camera, integrator, film, materials, textures, shapes, instances, lights, included, warnings };
        scene.warnings.extend(missing_light::warning(&scene, &self.material_names()));
        Ok(scene)
    }

    /// Names of materials in use, by their index.
    fn material_names(&self) -> BTreeMap<usize, Arc<str>> {
        let index = |(name, slot): (&Arc<str>, &usize)| Some((self.slots[*slot].index?, Arc::clone(name)));
        self.named.iter().filter_map(index).collect()
    }

    /// Shapes with the indices of their materials, and the materials in use. Shapes of none are
    /// left out.
    fn resolve_materials(&mut self) -> Result<(Vec<Shape>, Vec<Material>), SceneError> {
        let mut materials = Vec::new();
        let mut shapes = Vec::with_capacity(self.shapes.len());
        for (mut shape, material) in std::mem::take(&mut self.shapes) {
            shape.material = self.resolve_material(&material, &mut materials, 0)?;
            if materials[shape.material] != Material::Interface {
                shapes.push(shape);
            }
        }
        Ok((shapes, materials))
    }

    /// The place of a material among `materials`, where it is put if it is not there yet.
    fn resolve_material(
        &mut self,
        material: &MaterialRef,
        materials: &mut Vec<Material>,
        depth: u32,
    ) -> Result<usize, SceneError> {
        let slot = match material {
            MaterialRef::Slot(slot) => *slot,
            MaterialRef::Named(name, location) => *self.named.get(name).ok_or_else(|| {
                location.invalid(format!(
                    "unknown material \"{}\"; expected one that MakeNamedMaterial has made",
                    shorten(name)
                ))
            })?,
        };
        if let Some(index) = self.slots[slot].index {
            return Ok(index);
        }
        let nothing = Ok(Made::Material(material::default()));
        let resolved = match std::mem::replace(&mut self.slots[slot].made, nothing) {
            Err(error) => {
                self.notes(Err(error))?;
                material::default()
            }
            Ok(Made::Material(material)) => material,
            Ok(Made::Mix { parts, amount, location }) => {
                let again = format!("this mix is of itself, or of mixes more than {MAX_MIX_DEPTH} deep; expected less");
                if depth >= MAX_MIX_DEPTH {
                    return Err(location.invalid(again));
                }
                self.slots[slot].made = Err(location.invalid(again));
                let mut indices = [0; 2];
                for (index, part) in indices.iter_mut().zip(&parts) {
                    *index = self.resolve_material(part, materials, depth + 1)?;
                    if materials[*index] == Material::Interface {
                        let error = location.unsupported("a mix with \"interface\"", "a mix of surfaces");
                        self.notes(Err(error))?;
                    }
                }
                Material::Mix { materials: indices, amount }
            }
        };
        materials.push(resolved);
        self.slots[slot].index = Some(materials.len() - 1);
        Ok(materials.len() - 1)
    }
}
