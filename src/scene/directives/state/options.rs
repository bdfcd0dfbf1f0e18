//! The directives before `WorldBegin`: the image, the camera, and rendering options.

use glam::{DAffine3, DVec2};

use crate::scene::directives::camera;
use crate::scene::directives::film;
use crate::scene::directives::state::SceneBuilder;
use crate::scene::directives::transform;
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::lexer::shorten;
use crate::scene::format::params::ParamList;
use crate::scene::format::registry::{Family, Ignored};
use crate::scene::model::{Camera, Film, FilterKind, Integrator, PixelFilter};

/// The parameters of these directives, with the name of the type, until all of them are known.
#[derive(Debug, Default)]
pub struct SceneOptions {
    film: (String, ParamList),
    filter: Option<(String, ParamList)>,
    camera: (String, ParamList),
    world_from_camera: Option<DAffine3>,
    integrator: Option<(String, ParamList)>,
    iterations: Option<u32>,
    /// `Option "integer seed"`.
    pub seed: Option<u32>,
    /// `Option "bool disablepixeljitter"`: camera samples are at the centres of pixel and lens.
    pub without_jitter: bool,
}

impl SceneOptions {
    pub(in crate::scene) fn has_camera(&self) -> bool {
        self.world_from_camera.is_some()
    }

    pub(in crate::scene) fn resolve(self) -> Result<(Film, Camera, Integrator), SceneError> {
        let mut filter = match &self.filter {
            Some((name, params)) => film::filter(name, params)?,
            None => film::filter("gaussian", &ParamList::default())?,
        };
        if self.without_jitter {
            filter = PixelFilter { kind: FilterKind::Box, radius: DVec2::ZERO };
        }
        let (name, params) = &self.camera;
        let film = film::film(&self.film.0, &self.film.1, filter, camera::exposure_time(params)?)?;
        let world_from_camera = self.world_from_camera.unwrap_or(DAffine3::IDENTITY);
        let mut camera = camera::camera(name, params, world_from_camera, film.resolution)?;
        if self.without_jitter {
            camera.lens_radius = 0.0;
        }
        let default = Integrator {
            iterations: self.iterations.unwrap_or(film::DEFAULT_INTEGRATOR.iterations),
            seed: self.seed.unwrap_or(film::DEFAULT_INTEGRATOR.seed),
            ..film::DEFAULT_INTEGRATOR
        };
        let (name, params) = self.integrator.unwrap_or_default();
        Ok((film, camera, film::integrator(&name, &params, default)?))
    }
}

impl SceneBuilder {
    pub fn film(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        check(&film::FILM_FAMILY, name, location, &mut params, &mut self.ignored)?;
        if name == "spectral" {
            self.warn(location, &format!("Film \"{name}\" is written as an RGB image, without spectra"));
        }
        if let Some(sensor) = params.string("sensor")?.filter(|sensor| *sensor != "cie1931") {
            let message = format!("the sensor \"{}\" is rendered as \"cie1931\"", shorten(sensor));
            self.warn(location, &message);
        }
        if self.color_space() != Default::default() {
            self.warn(location, "the image is written with sRGB primaries, not with the primaries of the ColorSpace");
        }
        self.options.film = (name.to_owned(), params);
        Ok(())
    }

    pub fn filter(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        check(&film::FILTER_FAMILY, name, location, &mut params, &mut self.ignored)?;
        self.options.filter = Some((name.to_string(), params));
        Ok(())
    }

    pub fn sampler(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        check(&film::SAMPLER_FAMILY, name, location, &mut params, &mut self.ignored)?;
        self.options.iterations = Some(film::iterations(name, &params)?);
        Ok(())
    }

    pub fn integrator(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        check(&film::INTEGRATOR_FAMILY, name, location, &mut params, &mut self.ignored)?;
        if name != "sppm" {
            let message = format!("Integrator \"{name}\" is rendered as \"sppm\"");
            self.warn(location, &message);
        }
        self.options.integrator = Some((name.to_string(), params));
        Ok(())
    }

    pub fn camera(&mut self, name: &str, mut params: ParamList, location: &Location) -> Result<(), SceneError> {
        check(&camera::FAMILY, name, location, &mut params, &mut self.ignored)?;
        self.warn_of_motion(location);
        if !transform::is_invertible(&self.state.world_from_object) {
            let what = "the transform of the camera is singular or overflows; expected one that can be inverted";
            return Err(location.invalid(what));
        }
        let inverses = [self.state.world_from_object, self.state.world_from_object_at_end].map(|t| t.inverse());
        self.coordinate_systems.insert("camera".to_string(), inverses);
        self.options.camera = (name.to_string(), params);
        self.options.world_from_camera = Some(inverses[0]);
        self.camera_media = self.state.media.clone();
        Ok(())
    }
}

/// Checks the parameters of an option; `Attribute` has no defaults for options.
fn check(
    family: &Family,
    name: &str,
    location: &Location,
    params: &mut ParamList,
    ignored: &mut Ignored,
) -> Result<(), SceneError> {
    family.check(name, location, params, &ParamList::default(), ignored)?;
    Ok(())
}
