//! Resolution of the scene after the last directive.

use std::sync::Arc;

use crate::scene::directives::material;
use crate::scene::directives::shape;
use crate::scene::directives::state::{MAX_MIX_DEPTH, Made, MaterialRef, PendingShape, Saved, SceneBuilder, Used};
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::lexer::shorten;
use crate::scene::model::{Input, Material, Scene, Shape};

impl SceneBuilder {
    /// Returns the scene; `end` is the place where its file ends.
    pub fn finish(mut self, end: &Location) -> Result<Scene, SceneError> {
        self.resolve(end)
    }

    pub(in crate::scene) fn resolve(&mut self, end: &Location) -> Result<Scene, SceneError> {
        if !self.world {
            return Err(end.invalid("the file ends before WorldBegin; expected a WorldBegin"));
        }
        if let Some(Saved { begin, end, .. }) = self.saved.last() {
            let error = begin.invalid(format!("this block is never ended; expected {end}"));
            self.notes(Err(error))?;
        }
        self.make_what_waits()?;
        let (shapes, materials) = self.resolve_materials()?;
        let (instances, errors) = std::mem::take(&mut self.objects).resolve(&shapes);
        for error in errors {
            self.notes(Err(error))?;
        }
        self.warn_of_nothing(&shapes, end);
        if !self.options.has_camera() {
            self.warn(end, "the scene has no Camera; the camera is at the origin and looks along +z");
        }
        let (film, camera, integrator) = std::mem::take(&mut self.options).resolve()?;
        let (camera_medium, light_media) = self.resolve_surroundings()?;
        let media = std::mem::take(&mut self.media).used;
        let (lights, mut warnings) = (std::mem::take(&mut self.lights), std::mem::take(&mut self.warnings));
        if self.more_warnings > 0 {
            warnings.push(format!("{} more warnings are not shown", self.more_warnings));
        }
        let textures = std::mem::take(&mut self.textures);
        self.ignored.add(textures.ignored);
        let textures = textures.made;
        let (included, inputs) = (std::mem::take(&mut self.included), std::mem::take(&mut self.inputs));
        let budget = Arc::clone(&self.budget);
        Ok(Scene {
            camera,
            integrator,
            film,
            materials,
            textures,
            shapes,
            instances,
            lights,
            media,
            light_media,
            light_curves: std::mem::take(&mut self.light_curves),
            camera_medium,
            included,
            inputs,
            warnings,
            ignored: self.ignored.lines(),
            budget,
        })
    }

    fn warn_of_nothing(&mut self, shapes: &[Shape], end: &Location) {
        if shapes.is_empty() {
            self.warn(end, "the scene has no shape: the image shows the sky, or is black");
        }
        if self.lights.is_empty() && shapes.iter().all(|shape| shape.emission.is_none()) {
            self.warn(end, "the scene has no light, or only black lights: the image is black");
        }
    }

    /// Makes the textures, and then the materials and alphas, that name textures declared after them.
    fn make_what_waits(&mut self) -> Result<(), SceneError> {
        for error in self.textures.make_waiting() {
            self.notes(Err(error))?;
        }
        for slot in 0..self.slots.len() {
            let Ok(Made::Waiting { kind, params, location }) = &self.slots[slot].made else { continue };
            let (kind, params, location) = (kind.clone(), params.clone(), location.clone());
            let made = self.material_of(&kind, &params, &location);
            self.slots[slot].made = match made {
                Err(error) if !matches!(error, SceneError::Unsupported { .. }) => {
                    self.notes(Err(error))?;
                    Ok(Made::Material(material::default()))
                }
                made => made,
            };
        }
        let mut shapes = std::mem::take(&mut self.shapes);
        for PendingShape { shape, alpha, .. } in &mut shapes {
            if let Some(params) = alpha {
                match shape::alpha(params, &self.textures) {
                    Ok(alpha) => shape.alpha = alpha,
                    Err(error) => drop(self.notes(Err(error))?),
                }
            }
        }
        self.shapes = shapes;
        Ok(())
    }

    /// Returns the medium around the camera, and around each light; light from infinitely far away starts in
    /// a vacuum, as in pbrt.
    fn resolve_surroundings(&mut self) -> Result<(Option<usize>, Vec<Option<usize>>), SceneError> {
        let camera = self.camera_media.take();
        let camera = self.resolve_outside(camera.as_deref())?;
        let mut media = Vec::with_capacity(self.lights.len());
        for (index, interface) in std::mem::take(&mut self.light_media).into_iter().enumerate() {
            let medium = self.resolve_outside(interface.as_deref())?;
            media.push(medium.filter(|_| self.lights[index].position().is_some()));
        }
        Ok((camera, media))
    }

    /// Returns the shapes, with the indices of their materials, and the materials in use. Shapes of
    /// "interface" are left out unless they bound a medium that absorbs light.
    fn resolve_materials(&mut self) -> Result<(Vec<Shape>, Vec<Material>), SceneError> {
        let mut materials = Vec::new();
        let mut shapes = Vec::with_capacity(self.shapes.len());
        for PendingShape { mut shape, material, media, .. } in std::mem::take(&mut self.shapes) {
            // No ray meets a shape of alpha 0; as in pbrt, it may still emit light.
            if shape.alpha == Input::Constant(0.0) && shape.emission.is_none() {
                continue;
            }
            shape.material = self.resolve_material(&material, &mut materials, 0)?.index;
            shape.media = self.resolve_media(media.as_deref())?;
            let is_interface = materials[shape.material] == Material::Interface;
            if is_interface && shape.emission.take().is_some() {
                let what = "the shape is of the material \"interface\"; its area light is ignored, as in pbrt";
                self.warn(&shape.location, what);
            }
            if !is_interface || shape.media.is_transition() {
                shapes.push(shape);
            }
        }
        Ok((shapes, materials))
    }

    /// Returns the index of a material in `materials`, and adds the material if it is not there yet.
    fn resolve_material(
        &mut self,
        material: &MaterialRef,
        materials: &mut Vec<Material>,
        depth: u32,
    ) -> Result<Used, SceneError> {
        let slot = match material {
            MaterialRef::Slot(slot) => *slot,
            MaterialRef::Named(name, location) => {
                let known = self.named.get(name).copied();
                if known.is_none() {
                    let expected = "expected one that MakeNamedMaterial has made";
                    let error = location.invalid(format!("unknown material \"{}\"; {expected}", shorten(name)));
                    self.notes(Err(error))?;
                    // An unknown name is reported once, even if all errors are collected.
                    self.named.insert(name.clone(), 0);
                }
                known.unwrap_or(0)
            }
        };
        if let Some(used) = self.slots[slot].used {
            return Ok(used);
        }
        let mut own_depth = 0;
        let nothing = Ok(Made::Material(material::default()));
        let resolved = match std::mem::replace(&mut self.slots[slot].made, nothing) {
            Err(error) => {
                self.notes(Err(error))?;
                material::default()
            }
            Ok(Made::Material(material)) => material,
            // `make_what_waits` has made all of them.
            Ok(Made::Waiting { .. }) => material::default(),
            Ok(Made::Mix { parts, amount, location }) => {
                let again = format!("this mix is of itself, or of mixes more than {MAX_MIX_DEPTH} deep; expected less");
                if depth >= MAX_MIX_DEPTH {
                    return Err(location.invalid(again));
                }
                self.slots[slot].made = Err(location.invalid(again.clone()));
                let mut indices = [0; 2];
                for (index, part) in indices.iter_mut().zip(&parts) {
                    let part = self.resolve_material(part, materials, depth + 1)?;
                    *index = part.index;
                    own_depth = own_depth.max(part.depth + 1);
                    if materials[*index] == Material::Interface {
                        let error = location.unsupported("a mix with \"interface\"", "a mix of surfaces");
                        self.notes(Err(error))?;
                    }
                }
                if own_depth > MAX_MIX_DEPTH {
                    return Err(location.invalid(again));
                }
                Material::Mix { materials: indices, amount }
            }
        };
        materials.push(resolved);
        let used = Used { index: materials.len() - 1, depth: own_depth };
        self.slots[slot].used = Some(used);
        Ok(used)
    }
}
