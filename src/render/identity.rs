//! What makes an image what it is: a checkpoint can be continued, and shards be merged,
//! where all of it agrees.

use std::collections::BTreeMap;

use bytemuck::Pod;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::gpu_scene::camera::View;
use crate::gpu_scene::pack::PackedScene;
use crate::render::checkpoint::error::CheckpointError;
use crate::render::options::table::{Effect, OPTIONS};
use crate::render::options::{Contribution, Options, Resolved};
use crate::scene::{Scene, shorten};

/// Names and values: options as they are written, parts of the scene as digests.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Identity(BTreeMap<String, String>);

/// How digests are told from values that a person can read.
const DIGEST: &str = "sha256:";

/// Parts of the scene. Shapes decide where render space is, so that other parts may differ
/// for their sake: they are looked at first.
const PARTS: [&str; 4] = ["the shapes", "the materials", "the lights", "the camera"];

/// What is said of images that have not all light.
const CONTRIBUTION: &str = "light";

impl Identity {
    /// Of a render with these options.
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
        identity.set_view(scene, view, options, resolved);
        identity
    }

    /// Makes it that of a render of the same shapes, materials and lights, seen and rendered
    /// otherwise.
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
        self.0.remove(CONTRIBUTION);
        if options.contribution != Contribution::All {
            self.0.insert(CONTRIBUTION.to_owned(), options.contribution.to_string());
        }
    }

    /// Whether a checkpoint with the identity `other` is of this render.
    ///
    /// # Errors
    /// The first difference, of options before parts of the scene.
    pub fn check(&self, other: &Self) -> Result<(), CheckpointError> {
        let differing = self.0.keys().chain(other.0.keys()).filter(|name| self.0.get(*name) != other.0.get(*name));
        let Some(name) = differing.min_by_key(|name| PARTS.iter().position(|part| part == name)) else {
            return Ok(());
        };
        let [here, there] = [self, other].map(|identity| identity.0.get(name).map_or("nothing", String::as_str));
        // Those of a file may be anything.
        let [name, here, there] = [name.as_str(), here, there].map(shorten);
        Err(if here.starts_with(DIGEST) {
            CheckpointError::Scene { part: name }
        } else {
            CheckpointError::Option { name, here, there }
        })
    }
}

fn bytes<T: Pod>(items: &[T]) -> &[u8] {
    bytemuck::cast_slice(items)
}

/// Of arrays with their lengths, so that none flows into the next.
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
    // Behind the lights themselves, which are the first array.
    arrays.insert(1, bytes(&infinite));
    digest(&arrays)
}

fn shapes(scene: &PackedScene) -> String {
    let mut arrays = scene.arrays.shapes();
    let space = [scene.space.center.x, scene.space.center.y, scene.space.center.z, scene.space.scale];
    arrays.push(bytes(&space));
    digest(&arrays)
}
