//! The scene and the options that determine an image. A checkpoint can be continued, and shards can be
//! merged, only if their identities are equal.

use std::collections::{BTreeMap, BTreeSet};

use bytemuck::Pod;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::base::names::Named;
use crate::gpu_scene::camera::View;
use crate::gpu_scene::pack::PackedScene;
use crate::image::film::CoordinateSystem;
use crate::render::checkpoint::difference::{
    Difference, Differences, EYE_PATHS, INTEGRATOR, PHOTONS, RESOLUTION, ROUND, To, options_for,
};
use crate::render::checkpoint::error::CheckpointError;
use crate::render::counts::Auto;
use crate::render::options::table::{Effect, OPTIONS};
use crate::render::options::{Contribution, DEFAULT_ROUND, Integrator, Options, Resolved};
use crate::render::radius::{RADIUS_SCHEDULE, RadiusSchedule};
use crate::scene::{Scene, shorten};

/// Names and values: the text of options, and the digests of parts of the scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Identity(BTreeMap<String, String>);

/// The prefix that distinguishes a digest from the value of an option.
const DIGEST: &str = "sha256:";

/// The names of the parts of the scene, in the order in which they are compared. The shapes are first because
/// they determine render space: if they differ, other parts may differ for this reason alone.
/// The media are present only if there are any.
const PARTS: [&str; 5] = ["the shapes", "the materials", "the lights", "the camera", "the media"];

/// The name of the contribution, which is present only if the image does not show all light.
const CONTRIBUTION: &str = "light";

/// The name of the white balance, which is present only if the film has one.
const WHITE_BALANCE: &str = "white balance";

/// The names of the values of [`of_layers`], in the order in which they are compared.
const LAYERS: [&str; 3] = ["layers", "layers' coordinate system", "layers' film"];

/// Returns the layers, their coordinate system, and the type of the film if that asks for layers. They are present only
/// if there are layers.
fn of_layers(scene: &Scene, resolved: &Resolved) -> [Option<String>; 3] {
    if resolved.layers.is_empty() {
        return [None, None, None];
    }
    let system = match scene.film.gbuffer.unwrap_or_default() {
        CoordinateSystem::Camera => "camera",
        CoordinateSystem::World => "world",
    };
    [Some(resolved.layers.names()), Some(system.to_owned()), scene.film.gbuffer.is_some().then(|| "gbuffer".to_owned())]
}

impl Identity {
    /// Returns the identity of a render of a scene with these options.
    pub(crate) fn new(
        scene: &Scene,
        packed: &PackedScene,
        view: &View,
        options: &Options,
        resolved: &Resolved,
    ) -> Self {
        let parts =
            [(PARTS[0], shapes(packed)), (PARTS[1], digest(&packed.arrays.materials())), (PARTS[2], lights(packed))];
        let mut identity = Self(parts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect());
        if !packed.arrays.media.is_empty() {
            let mut arrays = packed.arrays.media();
            let camera = [packed.camera_medium];
            arrays.push(bytes(&camera));
            identity.0.insert(PARTS[4].to_owned(), digest(&arrays));
        }
        identity.set_view(scene, view, options, resolved);
        identity
    }

    /// Changes the identity to another camera, film or options; shapes, materials and lights stay.
    pub(crate) fn set_view(&mut self, scene: &Scene, view: &View, options: &Options, resolved: &Resolved) {
        let parts = [
            (PARTS[3], digest(&[bytes(&[view.camera]), bytes(&view.filter_table), view.projection_name()])),
            ("exposure", scene.film.exposure.to_string()),
        ];
        let values = OPTIONS.iter().filter_map(|option| match option.effect {
            Effect::Image(name, value) => Some((name, value(options, resolved))),
            Effect::PartOf | Effect::End | Effect::Cost => None,
        });
        self.0.extend(parts.into_iter().chain(values).map(|(name, value)| (name.to_owned(), value)));
        self.0.remove(WHITE_BALANCE);
        if let Some(balance) = scene.film.white_balance {
            self.0.insert(WHITE_BALANCE.to_owned(), format!("{} K", balance.kelvin));
        }
        for (name, value) in LAYERS.into_iter().zip(of_layers(scene, resolved)) {
            self.0.remove(name);
            self.0.extend(value.map(|value| (name.to_owned(), value)));
        }
        self.0.remove(CONTRIBUTION);
        if options.contribution != Contribution::All {
            self.0.insert(CONTRIBUTION.to_owned(), options.contribution.to_string());
        }
    }

    /// Returns the value of an option or the digest of a part of the scene; `None` if the identity has none.
    pub(crate) fn value(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str)
    }

    /// Returns whether radii shrink by this schedule.
    pub(crate) fn has_schedule(&self, schedule: RadiusSchedule) -> bool {
        self.0.get(RADIUS_SCHEDULE).is_some_and(|name| name == schedule.name())
    }

    /// Checks that a checkpoint with the identity `other` is of this render, or of the same render as the checkpoints
    /// before it.
    ///
    /// # Errors
    /// The identities differ. The error has all options that differ; if there is none, the parts of the scene that do.
    pub fn check(&self, other: &Self, to: To) -> Result<(), CheckpointError> {
        self.check_without(other, to, &[])
    }

    /// Checks that a checkpoint is of this render, except for the numbers that a trial will choose.
    ///
    /// # Errors
    /// The same as for [`Identity::check`].
    pub fn check_except(&self, other: &Self, auto: Auto) -> Result<(), CheckpointError> {
        let chosen = [(auto.photons, PHOTONS), (auto.eye_paths, EYE_PATHS)];
        let chosen: Vec<&str> = chosen.iter().filter(|(is_auto, _)| *is_auto).map(|(_, name)| *name).collect();
        self.check_without(other, To::Render, &chosen)
    }

    fn check_without(&self, other: &Self, to: To, left_out: &[&str]) -> Result<(), CheckpointError> {
        let names: BTreeSet<&String> = self.0.keys().chain(other.0.keys()).collect();
        let differs = |name: &&String| self.0.get(*name) != other.0.get(*name) && !left_out.contains(&name.as_str());
        let differing: Vec<&str> = names.into_iter().filter(differs).map(String::as_str).collect();
        let follows = |name: &str| [self, other].iter().all(|it| it.follows(name, &differing));
        let all: Vec<Difference> = differing
            .iter()
            .filter(|name| !self.is_digest(other, name) && !follows(name))
            .map(|name| self.difference(other, name))
            .collect();
        if !all.is_empty() {
            return Err(CheckpointError::Options(Differences { to, all }));
        }
        let mut parts: Vec<&str> = PARTS.into_iter().filter(|part| differing.contains(part)).collect();
        if parts.first() == Some(&PARTS[0]) {
            parts.truncate(1);
        }
        // A name that this program does not know is in a file of another one.
        parts.extend(differing.iter().copied().find(|_| parts.is_empty()));
        if parts.is_empty() {
            Ok(())
        } else {
            Err(CheckpointError::Scene { parts: parts.into_iter().map(shorten).collect() })
        }
    }

    fn get(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str)
    }

    fn is_digest(&self, other: &Self, name: &str) -> bool {
        [self, other].iter().any(|identity| identity.get(name).is_some_and(|value| value.starts_with(DIGEST)))
    }

    /// Returns whether a value that differs is the usual one for another value that differs too: one photon per pixel for
    /// the size of the image, the length of rounds for the integrator, and the form of layers.
    fn follows(&self, name: &str, differing: &[&str]) -> bool {
        let number = |name: &str| self.get(name).and_then(|value| value.parse::<u64>().ok());
        match name {
            PHOTONS if differing.contains(&RESOLUTION) => {
                let size = self.get(RESOLUTION).and_then(|size| size.split_once('x'));
                let sides = size.and_then(|(width, height)| width.parse::<u64>().ok().zip(height.parse::<u64>().ok()));
                number(PHOTONS).is_some()
                    && number(PHOTONS) == sides.map(|(width, height)| width.saturating_mul(height))
            }
            ROUND if differing.contains(&INTEGRATOR) => {
                let is_sppm = self.get(INTEGRATOR) == Some(Integrator::Sppm.name());
                number(ROUND) == Some(if is_sppm { 1 } else { DEFAULT_ROUND.into() })
            }
            // They are there where layers are.
            name if LAYERS[1..].contains(&name) => differing.contains(&LAYERS[0]),
            _ => false,
        }
    }

    /// Returns a difference with the options that give the value of `other`.
    fn difference(&self, other: &Self, name: &str) -> Difference {
        let [here, there] = [self, other].map(|identity| identity.get(name).map(str::to_owned));
        let options = options_for(name, there.as_deref(), other.get(PHOTONS));
        Difference { name: name.to_owned(), here, there, options }
    }
}

fn bytes<T: Pod>(items: &[T]) -> &[u8] {
    bytemuck::cast_slice(items)
}

/// Returns the digest of arrays. It includes their lengths, so that elements cannot move between arrays
/// unnoticed.
fn digest(arrays: &[&[u8]]) -> String {
    let mut hash = Sha256::new();
    for array in arrays {
        hash.update((array.len() as u64).to_le_bytes());
        hash.update(array);
    }
    let hex: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    format!("{DIGEST}{hex}")
}

fn lights(scene: &PackedScene) -> String {
    let mut arrays = scene.arrays.lights();
    let infinite = [scene.infinite.to_array()];
    // After the lights themselves, which are the first array.
    arrays.insert(1, bytes(&infinite));
    digest(&arrays)
}

fn shapes(scene: &PackedScene) -> String {
    let mut arrays = scene.arrays.shapes();
    let space = [scene.space.center.x, scene.space.center.y, scene.space.center.z, scene.space.scale];
    arrays.push(bytes(&space));
    digest(&arrays)
}
