//! What a driver's compiler says of kernels: registers, spills, bytes of code
//! (`VK_KHR_pipeline_executable_properties`). Nothing runs and no memory is allocated, so that drivers which
//! compile for hardware that is not there can be asked, too.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::{khr, vk};

use crate::error::{Context, Error, Result};
use crate::instance::Instance;
use crate::kernel::{Outline, SpecializationValues};
use crate::physical::{self, DeviceInfo, Requirements, compute_family, text};
use crate::shared::DeviceShared;

/// A device that compiles kernels, as a [`Device`](crate::Device) does, and tells what has become of them.
pub struct Compiler {
    shared: Arc<DeviceShared>,
    executables: khr::pipeline_executable_properties::Device,
}

/// What has become of a kernel.
#[derive(Clone, Debug, PartialEq)]
pub struct Compiled {
    /// Time to prepare and to compile it.
    pub time: Duration,
    /// One, or more where the driver chooses among several when it runs the kernel.
    pub executables: Vec<Executable>,
}

/// Code for a device, with its driver's statistics.
#[derive(Clone, Debug, PartialEq)]
pub struct Executable {
    /// The driver's name of it.
    pub name: String,
    /// Lanes of its subgroups, or 0 if the driver does not tell.
    pub lanes: u32,
    /// Names and values, as the driver calls them and in its units.
    pub statistics: Vec<(String, f64)>,
}

impl Instance {
    /// Opens a compiler for the device that [`Instance::open`] would open.
    ///
    /// # Errors
    /// There is no such device, it lacks something of `requirements`, or it tells nothing of kernels.
    pub fn open_compiler(&self, selector: Option<&str>, requirements: &Requirements) -> Result<Compiler> {
        let (physical, info) = self.choose(selector, requirements)?;
        let vulkan = &self.shared.raw;
        let unfit = |reason: &str| Error::Unfit { device: info.name.clone(), reason: reason.into() };
        let family = compute_family(vulkan, physical).ok_or_else(|| unfit("it has no compute queue"))?;
        if !tells_statistics(vulkan, physical) {
            return Err(unfit("its driver tells nothing of kernels (VK_KHR_pipeline_executable_properties)"));
        }
        let extensions = [khr::pipeline_executable_properties::NAME];
        let row = requirements.texels_per_row;
        let shared = DeviceShared::open(self.clone(), physical, info, row, family, &extensions, None)?;
        let executables = khr::pipeline_executable_properties::Device::new(vulkan, &shared.raw);
        Ok(Compiler { shared: Arc::new(shared), executables })
    }
}

fn tells_statistics(instance: &ash::Instance, physical: vk::PhysicalDevice) -> bool {
    if !physical::has_extension(instance, physical, khr::pipeline_executable_properties::NAME) {
        return false;
    }
    let mut statistics = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut statistics);
    // SAFETY: `physical` belongs to `instance`, whose version 1.2 has this function, and has the extension of
    // what is chained.
    unsafe { instance.get_physical_device_features2(physical, &mut features) };
    statistics.pipeline_executable_info == vk::TRUE
}

impl Compiler {
    /// Returns what the list of devices says of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.shared.info
    }

    /// Compiles a kernel for a workgroup size as [`Device::pass`](crate::Device::pass) does, and drops it.
    ///
    /// # Errors
    /// The kernel was not built for that size, or the driver refuses it.
    pub fn compile(
        &self,
        kernel: &Outline,
        specialization: &impl SpecializationValues,
        workgroup_size: u32,
    ) -> Result<Compiled> {
        let layout = kernel.layout(&self.shared)?;
        let start = Instant::now();
        let source = kernel.source(&self.shared.info, specialization, workgroup_size, &layout)?;
        let flags = vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR;
        let pipeline = source.compile(&self.shared.raw, vk::PipelineCache::null(), flags)?;
        let time = start.elapsed();
        let executables = self.executables(pipeline);
        // SAFETY: it was made above, and nothing uses it.
        unsafe { self.shared.raw.destroy_pipeline(pipeline, None) };
        Ok(Compiled { time, executables: executables? })
    }

    /// Asks the driver for the executables of a pipeline that was made to have statistics.
    fn executables(&self, pipeline: vk::Pipeline) -> Result<Vec<Executable>> {
        let of = vk::PipelineInfoKHR::default().pipeline(pipeline);
        // SAFETY: the pipeline is of this device, which has the feature.
        let properties = unsafe { self.executables.get_pipeline_executable_properties(&of) };
        let properties = properties.context("vkGetPipelineExecutablePropertiesKHR")?;
        let executable = |(index, properties): (usize, &vk::PipelineExecutablePropertiesKHR<'_>)| {
            let of = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(index as u32);
            // SAFETY: the pipeline has this executable and was made to have statistics.
            let statistics = unsafe { self.executables.get_pipeline_executable_statistics(&of) };
            let statistics = statistics.context("vkGetPipelineExecutableStatisticsKHR")?;
            Ok(Executable {
                name: text(&properties.name),
                lanes: properties.subgroup_size,
                statistics: statistics.iter().map(|statistic| (text(&statistic.name), value(statistic))).collect(),
            })
        };
        properties.iter().enumerate().map(executable).collect()
    }
}

fn value(statistic: &vk::PipelineExecutableStatisticKHR<'_>) -> f64 {
    use vk::PipelineExecutableStatisticFormatKHR as Format;
    let value = &statistic.value;
    // SAFETY: the driver has set the member that the format names; every bit pattern is a value of each.
    unsafe {
        match statistic.format {
            Format::BOOL32 => f64::from(value.b32),
            Format::INT64 => value.i64 as f64,
            Format::UINT64 => value.u64 as f64,
            _ => value.f64,
        }
    }
}
