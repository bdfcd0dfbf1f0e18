//! The graphics state, and the scene that grows under it.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;

use super::error::{Location, SceneError};
use super::lexer::shorten;
use super::model::{AreaLight, Input, Light, Material, Rgb, Scene, Shape};
use super::params::ParamList;
use super::registry::Family;
use super::shape::MeshFiles;
use super::texture::{Place, Textures, Values};
use super::{camera, film, light, material, shape, transform};

/// What applies to the next shape or light.
#[derive(Clone, Debug)]
struct GraphicsState {
    world_from_object: DAffine3,
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

/// A material of the scene file. One that goblet cannot render is an error only
/// once a shape is made of it.
#[derive(Debug)]
struct MaterialSlot {
    made: Result<Material, SceneError>,
    /// Its place in [`Scene::materials`], once a shape is made of it.
    index: Option<usize>,
}

/// What stands before `WorldBegin`, with the type's name.
#[derive(Debug, Default)]
struct Options {
    film: ParamList,
    filter: Option<(String, ParamList)>,
    camera: ParamList,
    world_from_camera: Option<DAffine3>,
    integrator: Option<(String, ParamList)>,
    iterations: Option<u32>,
}

/// Builds a [`Scene`] directive by directive.
#[derive(Debug)]
pub(super) struct SceneBuilder {
    options: Options,
    world: bool,
    state: GraphicsState,
    /// Each with the place of its `AttributeBegin`.
    saved: Vec<(GraphicsState, Location)>,
    coordinate_systems: HashMap<String, DAffine3>,
    slots: Vec<MaterialSlot>,
    named: HashMap<Arc<str>, usize>,
    shapes: Vec<(Shape, MaterialRef)>,
    lights: Vec<Light>,
    files: MeshFiles,
    textures: Textures,
    warnings: Vec<String>,
}

impl SceneBuilder {
    /// File names in the scene are relative to `directory`.
    pub fn new(directory: &Path) -> Self {
        let default_material = MaterialSlot { made: Ok(material::default()), index: None };
        Self {
            options: Options::default(),
            world: false,
            state: GraphicsState {
                world_from_object: DAffine3::IDENTITY,
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
            slots: vec![default_material],
            named: HashMap::new(),
            shapes: Vec::new(),
            lights: Vec::new(),
            files: MeshFiles::new(directory),
            textures: Textures::default(),
            warnings: Vec::new(),
        }
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
        self.state.world_from_object = DAffine3::IDENTITY;
        self.coordinate_systems.insert("world".to_string(), DAffine3::IDENTITY);
        Ok(())
    }

    pub fn attribute_begin(&mut self, location: &Location) {
        self.saved.push((self.state.clone(), location.clone()));
    }

    pub fn attribute_end(&mut self, location: &Location) -> Result<(), SceneError> {
        let Some((state, _)) = self.saved.pop() else {
            return Err(location.invalid("this ends an attribute block that was never begun"));
        };
        self.state = state;
        Ok(())
    }

    pub fn reverse_orientation(&mut self) {
        self.state.reverse_orientation = !self.state.reverse_orientation;
    }

    /// Replaces the current transform; `None` where the directive describes none.
    pub fn set_transform(
        &mut self,
        transform: Option<DAffine3>,
        directive: &str,
        location: &Location,
    ) -> Result<(), SceneError> {
        let transform = transform.ok_or_else(|| {
            let expected = match directive {
                "LookAt" => "an eye and a look point that differ, and an up not along their line",
                "Rotate" => "an axis that is not zero",
                _ => "an affine matrix: 4th, 8th and 12th number 0, 16th number 1",
            };
            location.invalid(format!("{directive} is no transform; expected {expected}"))
        })?;
        if !transform::is_invertible(&transform) {
            return Err(location.invalid(format!(
                "after this {directive} the transform is singular or overflows; \
                 expected one that can be inverted"
            )));
        }
        self.state.world_from_object = transform;
        Ok(())
    }

    /// Applies a transform before the current one.
    pub fn concat_transform(
        &mut self,
        transform: Option<DAffine3>,
        directive: &str,
        location: &Location,
    ) -> Result<(), SceneError> {
        let transform = transform.map(|t| self.state.world_from_object * t);
        self.set_transform(transform, directive, location)
    }

    pub fn name_coordinate_system(&mut self, name: String) {
        self.coordinate_systems.insert(name, self.state.world_from_object);
    }

    pub fn use_coordinate_system(&mut self, name: &str, location: &Location) -> Result<(), SceneError> {
        let Some(transform) = self.coordinate_systems.get(name) else {
            return Err(location.invalid(format!(
                "unknown coordinate system \"{}\"; expected one that CoordinateSystem has named, \
                 \"camera\" or \"world\"",
                shorten(name)
            )));
        };
        self.state.world_from_object = *transform;
        Ok(())
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

    pub fn film(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        check(&film::FILM_FAMILY, name, location, &mut params)?;
        self.options.film = params;
        Ok(())
    }

    pub fn filter(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        check(&film::FILTER_FAMILY, name, location, &mut params)?;
        self.options.filter = Some((name.to_string(), params));
        Ok(())
    }

    pub fn sampler(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        check(&film::SAMPLER_FAMILY, name, location, &mut params)?;
        self.options.iterations = Some(film::iterations(name, &params)?);
        Ok(())
    }

    pub fn integrator(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        check(&film::INTEGRATOR_FAMILY, name, location, &mut params)?;
        if name != "sppm" {
            let message = format!("Integrator \"{name}\" is rendered as \"sppm\"");
            self.warn(location, &message);
        }
        self.options.integrator = Some((name.to_string(), params));
        Ok(())
    }

    pub fn camera(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        check(&camera::FAMILY, name, location, &mut params)?;
        let world_from_camera = self.state.world_from_object.inverse();
        self.coordinate_systems.insert("camera".to_string(), world_from_camera);
        self.options.camera = params;
        self.options.world_from_camera = Some(world_from_camera);
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
            .and_then(|_| material::material(kind, &params, location, &self.textures));
        if let Err(error) = &made
            && !matches!(error, SceneError::Unsupported { .. })
        {
            return made.map(|_| 0);
        }
        self.slots.push(MaterialSlot { made, index: None });
        Ok(self.slots.len() - 1)
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
        light::FAMILY.check(name, location, &mut params, &self.state.light_defaults)?;
        let light = light::light(name, &params, self.state.world_from_object, location)?;
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
        shape::FAMILY.check(name, location, &mut params, &self.state.shape_defaults)?;
        let alpha = shape::alpha(&params, &self.textures)?;
        let shape = Shape {
            geometry: shape::geometry(name, &params, &mut self.files, location)?,
            alpha,
            world_from_object: self.state.world_from_object,
            reverse_orientation: self.state.reverse_orientation,
            material: 0,
            emission: self.state.emission,
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
        if !self.world {
            return Err(end.invalid("the file ends before WorldBegin; expected a WorldBegin"));
        }
        if let Some((_, begin)) = self.saved.last() {
            return Err(begin.invalid("this attribute block is never ended; expected AttributeEnd"));
        }
        let (shapes, materials) = self.resolve_materials()?;
        if shapes.is_empty() {
            return Err(end.invalid("the scene has no shape; expected at least one Shape"));
        }
        if self.lights.is_empty() && shapes.iter().all(|shape| shape.emission.is_none()) {
            return Err(
                end.invalid("the scene has no light; expected a LightSource or AreaLightSource that is not black")
            );
        }
        if self.options.world_from_camera.is_none() {
            self.warn(end, "the scene has no Camera; it is seen from the origin along +z");
        }
        let options = self.options;
        let filter = match &options.filter {
            Some((name, params)) => film::filter(name, params)?,
            None => film::filter("gaussian", &ParamList::default())?,
        };
        let film = film::film(&options.film, filter)?;
        let world_from_camera = options.world_from_camera.unwrap_or(DAffine3::IDENTITY);
        let iterations = film::DEFAULT_INTEGRATOR.iterations;
        let iterations = options.iterations.unwrap_or(iterations);
        let (name, params) = options.integrator.unwrap_or_default();
        Ok(Scene {
            camera: camera::camera(&options.camera, world_from_camera, film.resolution)?,
            integrator: film::integrator(&name, &params, iterations)?,
            film,
            materials,
            textures: self.textures.made,
            shapes,
            lights: self.lights,
            warnings: self.warnings,
        })
    }

    /// Shapes with the indices of their materials, and the materials in use.
    fn resolve_materials(&mut self) -> Result<(Vec<Shape>, Vec<Material>), SceneError> {
        let mut materials = Vec::new();
        let mut shapes = Vec::with_capacity(self.shapes.len());
        for (mut shape, material) in self.shapes.drain(..) {
            let slot = match material {
                MaterialRef::Slot(slot) => slot,
                MaterialRef::Named(name, location) => *self.named.get(&name).ok_or_else(|| {
                    location.invalid(format!(
                        "unknown material \"{}\"; expected one that MakeNamedMaterial has made",
                        shorten(&name)
                    ))
                })?,
            };
            let slot = &mut self.slots[slot];
            shape.material = match (slot.index, &slot.made) {
                (Some(index), _) => index,
                (None, Ok(material)) => {
                    materials.push(material.clone());
                    materials.len() - 1
                }
                (None, Err(_)) => {
                    let unused = Ok(material::default());
                    std::mem::replace(&mut slot.made, unused)?;
                    0
                }
            };
            slot.index = Some(shape.material);
            shapes.push(shape);
        }
        Ok((shapes, materials))
    }
}

/// Checks an option, which `Attribute` has no defaults for.
fn check(family: &Family, name: &str, location: &Location, params: &mut ParamList) -> Result<(), SceneError> {
    family.check(name, location, params, &ParamList::default())?;
    Ok(())
}
