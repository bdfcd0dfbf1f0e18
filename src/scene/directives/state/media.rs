//! Named media, and the media on both sides of shapes and around lights and the camera.

use std::collections::HashMap;
use std::sync::Arc;

use crate::scene::directives::medium;
use crate::scene::directives::state::{ENTRY_BYTES, SceneBuilder};
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::lexer::shorten;
use crate::scene::format::params::ParamList;
use crate::scene::model::{Medium, MediumInterface};

/// The names of a `MediumInterface`, which are looked up at the end because a scene may make a medium later.
/// An empty name stands for a vacuum.
#[derive(Debug)]
pub(super) struct NamedInterface {
    inside: Box<str>,
    outside: Box<str>,
    location: Location,
}

/// A medium of the scene file. A medium that goblet cannot render is an error only if something is in it.
#[derive(Debug)]
enum Slot {
    /// A medium, or `None` for one that is like a vacuum.
    Made(Option<Medium>),
    Unsupported(SceneError),
    /// Index into [`super::Scene::media`], or `None`.
    Used(Option<usize>),
}

/// The named media of a scene.
#[derive(Debug, Default)]
pub(super) struct NamedMedia {
    slots: HashMap<String, Slot>,
    /// Media in use.
    pub used: Vec<Medium>,
}

impl SceneBuilder {
    /// Executes `MakeNamedMedium`.
    pub fn make_named_medium(
        &mut self,
        name: &str,
        mut params: ParamList,
        location: &Location,
    ) -> Result<(), SceneError> {
        let directive = format!("MakeNamedMedium \"{}\"", shorten(name));
        let Some(kind) = params.take("type") else {
            return Err(location.invalid(format!("{directive} has no \"string type\"; expected one")));
        };
        let Some(kind) = kind.text() else {
            return Err(kind.bad_value("the name of a type of media"));
        };
        let checked = medium::FAMILY.check(kind, location, &mut params, &self.state.medium_defaults, &mut self.ignored);
        let slot = match checked.and_then(|_| medium::medium(name, &params, location)) {
            Ok((medium, warning)) => {
                warning.into_iter().for_each(|warning| self.warn(location, &warning));
                Slot::Made(medium)
            }
            Err(error @ SceneError::Unsupported { .. }) => Slot::Unsupported(error),
            Err(error) => {
                // The name is known, so that its use causes no second error.
                self.media.slots.insert(name.to_owned(), Slot::Made(None));
                return Err(error);
            }
        };
        self.keep::<(String, Slot, Medium)>(name.len() + ENTRY_BYTES, location)?;
        if self.media.slots.insert(name.to_owned(), slot).is_some() {
            let what = format!("a medium \"{}\" exists already; expected a new name", shorten(name));
            return Err(location.invalid(what));
        }
        Ok(())
    }

    /// Executes `MediumInterface`.
    pub fn medium_interface(&mut self, inside: &str, outside: &str, location: &Location) -> Result<(), SceneError> {
        self.keep::<NamedInterface>(inside.len() + outside.len() + ENTRY_BYTES, location)?;
        let is_vacuum = inside.is_empty() && outside.is_empty();
        let interface =
            || NamedInterface { inside: inside.into(), outside: outside.into(), location: location.clone() };
        self.state.media = (!is_vacuum).then(|| Arc::new(interface()));
        Ok(())
    }

    /// Returns the media that an interface names.
    pub(super) fn resolve_media(&mut self, interface: Option<&NamedInterface>) -> Result<MediumInterface, SceneError> {
        let Some(NamedInterface { inside, outside, location }) = interface else {
            return Ok(MediumInterface::default());
        };
        Ok(MediumInterface {
            inside: self.resolve_medium(inside, location)?,
            outside: self.resolve_medium(outside, location)?,
        })
    }

    /// Returns the medium outside, in which a camera or light is.
    pub(super) fn resolve_outside(&mut self, interface: Option<&NamedInterface>) -> Result<Option<usize>, SceneError> {
        interface.map_or(Ok(None), |interface| self.resolve_medium(&interface.outside, &interface.location))
    }

    fn resolve_medium(&mut self, name: &str, location: &Location) -> Result<Option<usize>, SceneError> {
        if name.is_empty() {
            return Ok(None);
        }
        let (used, error) = match self.media.slots.remove(name) {
            Some(Slot::Used(used)) => (used, None),
            Some(Slot::Made(medium)) => {
                let index = medium.is_some().then_some(self.media.used.len());
                self.media.used.extend(medium);
                (index, None)
            }
            Some(Slot::Unsupported(error)) => (None, Some(error)),
            None => {
                let expected = "expected one that MakeNamedMedium has made, or \"\" for a vacuum";
                (None, Some(location.invalid(format!("unknown medium \"{}\"; {expected}", shorten(name)))))
            }
        };
        // An error is reported once, even if all errors are collected.
        self.media.slots.insert(name.to_owned(), Slot::Used(used));
        error.map_or(Ok(()), |error| self.notes(Err(error)).map(drop))?;
        Ok(used)
    }
}
