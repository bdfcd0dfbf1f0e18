//! Compiled kernels. A device keeps them: a second pass with the same code compiles nothing.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::vk;

use crate::error::{Context, Error, Result};
use crate::floats;
use crate::physical::ArrayKind;
use crate::pipeline_cache::PipelineCache;
use crate::specialize;

/// SPIR-V for a kind of arrays and a workgroup size.
pub struct Code {
    /// What texels are in.
    pub arrays: ArrayKind,
    /// Invocations of a workgroup.
    pub workgroup_size: u32,
    /// The SPIR-V, as little-endian words.
    pub spirv: &'static [u8],
}

/// Once a device has this many pipelines, those that no pass uses are dropped before another is kept.
/// llvmpipe takes some 15 MB for one.
const ENOUGH: usize = 192;

/// What a pipeline is made from. The arrays of a kernel, and with them its layout, follow from its code.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Key {
    /// Address of the SPIR-V, which is static.
    code: usize,
    /// Values of the constants that the code uses, in the order of their ids.
    values: Vec<[u8; 4]>,
}

/// The pipelines of a device.
pub(crate) struct Pipelines {
    made: Mutex<HashMap<Key, Arc<vk::Pipeline>>>,
    cache: PipelineCache,
}

impl Pipelines {
    /// Returns no pipelines yet. They will be compiled with a cache of the driver.
    pub fn new(cache: PipelineCache) -> Self {
        Self { made: Mutex::default(), cache }
    }

    /// Returns a pipeline, compiled now unless the device has it already.
    pub fn get(&self, device: &ash::Device, source: Source) -> Result<Arc<vk::Pipeline>> {
        let kept = self.made().get(&source.key).map(Arc::clone);
        match kept {
            Some(kept) => Ok(kept),
            None => {
                let pipeline = source.compile(device, self.cache.handle(), vk::PipelineCreateFlags::empty())?;
                Ok(self.keep(device, source.key, pipeline))
            }
        }
    }

    /// Destroys all pipelines and the driver's cache, whose file is written.
    ///
    /// # Safety
    /// Nothing uses them any more, and `device` is the one that made them.
    pub unsafe fn destroy(&self, device: &ash::Device) {
        for (_, pipeline) in self.made().drain() {
            // SAFETY: the caller promises it.
            unsafe { device.destroy_pipeline(*pipeline, None) };
        }
        // SAFETY: the caller promises it.
        unsafe { self.cache.close(device) };
    }

    #[cfg(test)]
    pub fn cache(&self) -> &PipelineCache {
        &self.cache
    }

    fn made(&self) -> MutexGuard<'_, HashMap<Key, Arc<vk::Pipeline>>> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn keep(&self, device: &ash::Device, key: Key, pipeline: vk::Pipeline) -> Arc<vk::Pipeline> {
        let mut made = self.made();
        if made.len() >= ENOUGH {
            made.retain(|_, pipeline| {
                let is_used = Arc::strong_count(pipeline) > 1;
                if !is_used {
                    // SAFETY: no pass has it, and the lock keeps new ones from getting it.
                    unsafe { device.destroy_pipeline(**pipeline, None) };
                }
                is_used
            });
        }
        if let Some(other) = made.get(&key) {
            // Another thread has compiled the same meanwhile.
            // SAFETY: nothing has used it.
            unsafe { device.destroy_pipeline(pipeline, None) };
            return Arc::clone(other);
        }
        let pipeline = Arc::new(pipeline);
        made.insert(key, Arc::clone(&pipeline));
        pipeline
    }
}

/// The input of the driver's compiler.
pub(crate) struct Source {
    spirv: Vec<u32>,
    constants: HashMap<u32, [u8; 4]>,
    key: Key,
    layout: vk::PipelineLayout,
    /// Lanes of a subgroup; the device's choice if `None`.
    lanes: Option<u32>,
    /// Whether infinities are kept: floats.rs.
    keeps_infinities: bool,
}

impl Source {
    /// Takes code with the values of its specialization constants by their ids. `layout` must live until it
    /// is compiled. Subgroups have `lanes` lanes, which divide the workgroup; the device chooses if it is `None`.
    pub fn new(
        code: &Code,
        value: impl Fn(u32) -> Option<[u8; 4]>,
        layout: vk::PipelineLayout,
        lanes: Option<u32>,
        keeps_infinities: bool,
    ) -> Self {
        let word = |word: &[u8]| u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        let spirv: Vec<u32> = code.spirv.chunks_exact(4).map(word).collect();
        let constants: Vec<_> =
            specialize::constants(&spirv).into_iter().filter_map(|id| value(id).map(|value| (id, value))).collect();
        let key = Key { code: code.spirv.as_ptr().addr(), values: constants.iter().map(|(_, value)| *value).collect() };
        Self { spirv, constants: constants.into_iter().collect(), key, layout, lanes, keeps_infinities }
    }

    /// Compiles it, for the caller to destroy.
    pub fn compile(
        &self,
        device: &ash::Device,
        cache: vk::PipelineCache,
        flags: vk::PipelineCreateFlags,
    ) -> Result<vk::Pipeline> {
        let mut words = specialize::specialize(&self.spirv, |id| self.constants.get(&id).copied());
        if self.keeps_infinities {
            words = floats::keep(&words);
        }
        // SAFETY: the code was compiled and reflected by the build script; the module is
        // destroyed once the pipeline has been made, the pipeline by the caller.
        unsafe {
            let create = vk::ShaderModuleCreateInfo::default().code(&words);
            let module = device.create_shader_module(&create, None).context("vkCreateShaderModule")?;
            let mut subgroups = vk::PipelineShaderStageRequiredSubgroupSizeCreateInfo::default();
            let mut stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main");
            if let Some(lanes) = self.lanes {
                subgroups.required_subgroup_size = lanes;
                stage =
                    stage.flags(vk::PipelineShaderStageCreateFlags::REQUIRE_FULL_SUBGROUPS).push_next(&mut subgroups);
            }
            let create = [vk::ComputePipelineCreateInfo::default().flags(flags).stage(stage).layout(self.layout)];
            let made = device.create_compute_pipelines(cache, &create, None);
            device.destroy_shader_module(module, None);
            let pipelines = made.map_err(|(_, result)| Error::Vulkan { call: "compiling a kernel", result })?;
            Ok(pipelines[0])
        }
    }
}
