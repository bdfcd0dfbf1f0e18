//! What makes an image what it is: a checkpoint can be continued, and shards be merged,
//! where all of it agrees.

use std::collections::BTreeMap;

use bytemuck::Pod;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::gpu_scene::camera::View;
use crate::gpu_scene::pack::PackedScene;
use crate::render::checkpoint::CheckpointError;
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
        let Resolved { resolution: [width, height], photons, radius, alpha, max_depth, seed, sequence, .. } = resolved;
        let radius_in_pixels = resolved.radius_in_pixels;
        let name = |value: Option<clap::builder::PossibleValue>| value.map(|value| value.get_name().to_owned());
        let values = [
            (PARTS[3], digest(&[bytes(&[view.camera]), bytes(&view.filter_table), view.projection_name()])),
            ("resolution", format!("{width}x{height}")),
            ("exposure", scene.film.exposure.to_string()),
            ("photons per iteration", photons.to_string()),
            ("eye paths per iteration", resolved.eye_paths.to_string()),
            ("radius", radius.map_or_else(|| format!("{radius_in_pixels}px"), |radius| radius.to_string())),
            ("alpha", alpha.to_string()),
            ("maximum depth", max_depth.to_string()),
            ("seed", seed.to_string()),
            ("integrator", name(options.integrator.to_possible_value()).unwrap_or_default()),
            ("iterations per round", sequence.round_length.to_string()),
            ("radius schedule", name(options.radius_schedule.to_possible_value()).unwrap_or_default()),
            ("direct light", name(options.direct.to_possible_value()).unwrap_or_default()),
            ("sampler", name(options.sampler.to_possible_value()).unwrap_or_default()),
            ("revolution solver", options.revolution_solver.to_string()),
        ];
        self.0.extend(values.into_iter().map(|(name, value)| (name.to_owned(), value)));
        self.0.remove(CONTRIBUTION);
        if options.contribution != Contribution::All {
            self.0.extend(name(options.contribution.to_possible_value()).map(|value| (CONTRIBUTION.to_owned(), value)));
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
