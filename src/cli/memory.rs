//! The option `--scene-memory`: the memory that a scene may take.

use clap::Args;

use super::values::gibibytes;
use crate::base::input::Budget;

/// The option of every command that reads a scene.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct SceneMemory {
    /// Largest memory of the scene, in GiB [default: a sixteenth of the machine's memory, at least 1]
    ///
    /// A scene that needs more is refused. The text, the meshes, images and textures of the scene
    /// count, and its triangles on the device; the buffers of the render do not.
    #[arg(id = "scene_memory", long = "scene-memory", value_name = "GIB", value_parser = gibibytes)]
    #[arg(allow_negative_numbers = true)]
    bytes: Option<u64>,
}

impl SceneMemory {
    /// Returns the budget of memory; the default budget if the option is not given.
    pub fn budget(&self) -> Budget {
        self.bytes.map_or_else(Budget::default, Budget::new)
    }
}
