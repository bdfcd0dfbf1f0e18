//! The Vulkan instance, its validation messages, and the list of devices.

use std::ffi::{CStr, c_char, c_void};
use std::sync::{Arc, Mutex};

use ash::vk;

use crate::error::{Context, Error, Result};
use crate::memory::available_memory;
use crate::{Device, device};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
const API_VERSION: u32 = vk::API_VERSION_1_2;

/// What a program needs of a device.
#[derive(Clone, Copy, Debug)]
pub struct Requirements {
    /// Storage buffers bound to one kernel.
    pub storage_buffers: u32,
    /// Storage images bound to one kernel.
    pub images: u32,
    /// Texels in a row of them.
    pub texels_per_row: u32,
    /// Bytes of push constants.
    pub push_constant_bytes: u32,
    /// Descriptor sets bound at once.
    pub descriptor_sets: u32,
    /// Invocations in one workgroup.
    pub workgroup_size: u32,
}

/// Where a device's processor is. In order of preference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A graphics card.
    Discrete,
    /// Shares memory with the CPU.
    Integrated,
    /// Passed through by a hypervisor.
    Virtual,
    /// Software, such as lavapipe.
    Cpu,
    /// Unknown to Vulkan.
    Other,
}

/// One line of the list of devices.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// Its place in the list; stable while the drivers are.
    pub index: usize,
    /// The device's own name.
    pub name: String,
    /// Driver name and version.
    pub driver: String,
    /// Kind of device.
    pub kind: DeviceKind,
    /// Bytes of its largest device-local heap; of a software device, of memory that is free now.
    pub memory_bytes: u64,
    /// Bytes that one storage buffer binding can have.
    pub max_buffer_bytes: u64,
    /// Rows that an image can have.
    pub max_image_rows: u32,
    /// Whether compute kernels can take a vote in a subgroup and read other invocations' values.
    pub has_shuffle: bool,
    /// Why it cannot be used, if it cannot.
    pub unfit: Option<String>,
}

pub(crate) struct InstanceShared {
    pub raw: ash::Instance,
    debug: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    // The messenger holds a pointer to this: boxed, so that it stays where it is.
    messages: Box<Mutex<Vec<String>>>,
    pub entry: ash::Entry,
}

/// The connection to Vulkan.
#[derive(Clone)]
pub struct Instance {
    pub(crate) shared: Arc<InstanceShared>,
}

impl Instance {
    /// Loads Vulkan; with `validation`, checks every call.
    ///
    /// # Errors
    /// No loader, no validation layer where it was asked for, or no memory.
    pub fn new(validation: bool) -> Result<Self> {
        Self::with_extensions(validation, |_| Ok(Vec::new()))
    }

    /// As [`Instance::new`], with extensions.
    pub(crate) fn with_extensions(
        validation: bool,
        extensions: impl FnOnce(&ash::Entry) -> Result<Vec<*const c_char>>,
    ) -> Result<Self> {
        // SAFETY: the loader is used as long as `InstanceShared` holds the entry.
        let entry = unsafe { ash::Entry::load() }.map_err(|error| Error::NoLoader(error.to_string()))?;
        if validation && !has_validation(&entry)? {
            return Err(Error::NoValidationLayer);
        }
        let application = vk::ApplicationInfo::default().application_name(c"goblet").api_version(API_VERSION);
        let layers = [VALIDATION_LAYER.as_ptr()];
        let mut extensions = extensions(&entry)?;
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let mut create = vk::InstanceCreateInfo::default().application_info(&application);
        if validation {
            extensions.push(ash::ext::debug_utils::NAME.as_ptr());
            create = create.enabled_layer_names(&layers).push_next(&mut features);
        }
        create = create.enabled_extension_names(&extensions);
        // SAFETY: everything `create` points to lives until after the call.
        let raw = unsafe { entry.create_instance(&create, None) }.map_err(|result| match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => Error::NoDevice,
            vk::Result::ERROR_EXTENSION_NOT_PRESENT => Error::NoPresentation("Vulkan".into()),
            result => Error::Vulkan { call: "vkCreateInstance", result },
        })?;
        // From here on it is destroyed, whatever fails.
        let mut shared = InstanceShared { raw, debug: None, messages: Box::default(), entry };
        if validation {
            shared.debug = Some(messenger(&shared.entry, &shared.raw, &shared.messages)?);
        }
        Ok(Self { shared: Arc::new(shared) })
    }

    /// What the validation layer has said so far; empty without validation.
    pub fn validation_messages(&self) -> Vec<String> {
        self.shared.messages.lock().map(|messages| messages.clone()).unwrap_or_default()
    }

    /// Every device, in the order of preference: discrete, integrated, virtual, CPU.
    ///
    /// # Errors
    /// The driver fails to list them.
    pub fn devices(&self, requirements: &Requirements) -> Result<Vec<DeviceInfo>> {
        Ok(self.ranked(requirements)?.into_iter().map(|(_, info)| info).collect())
    }

    /// Opens the device that `selector` names by index or by part of its name, or
    /// the first fitting one.
    ///
    /// # Errors
    /// No such device, or it lacks what `requirements` ask for.
    pub fn open(&self, selector: Option<&str>, requirements: &Requirements) -> Result<Device> {
        let (physical, info) = self.choose(selector, requirements)?;
        Device::open(self.clone(), physical, info, requirements.texels_per_row)
    }

    /// The device that [`Instance::open`] opens.
    pub(crate) fn choose(
        &self,
        selector: Option<&str>,
        requirements: &Requirements,
    ) -> Result<(vk::PhysicalDevice, DeviceInfo)> {
        let devices = self.ranked(requirements)?;
        if devices.is_empty() {
            return Err(Error::NoDevice);
        }
        let chosen = match selector {
            None => devices.iter().find(|(_, info)| info.unfit.is_none()).or(devices.first()),
            Some(wanted) => {
                let wanted = wanted.to_lowercase();
                devices
                    .iter()
                    .find(|(_, info)| wanted.parse() == Ok(info.index) || info.name.to_lowercase().contains(&wanted))
            }
        };
        let Some((physical, info)) = chosen else {
            let names: Vec<_> = devices.iter().map(|(_, info)| format!("{} ({})", info.index, info.name)).collect();
            return Err(Error::NoSuchDevice {
                wanted: selector.unwrap_or_default().to_owned(),
                available: names.join(", "),
            });
        };
        match &info.unfit {
            Some(reason) => Err(Error::Unfit { device: info.name.clone(), reason: reason.clone() }),
            None => Ok((*physical, info.clone())),
        }
    }

    fn ranked(&self, requirements: &Requirements) -> Result<Vec<(vk::PhysicalDevice, DeviceInfo)>> {
        // SAFETY: the instance is alive.
        let physical = unsafe { self.shared.raw.enumerate_physical_devices() }.context("listing devices")?;
        let mut devices: Vec<_> =
            physical.into_iter().map(|device| (device, describe(&self.shared.raw, device, requirements))).collect();
        devices.sort_by_key(|(_, info)| info.kind);
        for (index, (_, info)) in devices.iter_mut().enumerate() {
            info.index = index;
        }
        Ok(devices)
    }
}

impl Drop for InstanceShared {
    fn drop(&mut self) {
        // SAFETY: devices hold the instance, so nothing made from it is left.
        unsafe {
            if let Some((debug, messenger)) = &self.debug {
                debug.destroy_debug_utils_messenger(*messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn has_validation(entry: &ash::Entry) -> Result<bool> {
    // SAFETY: the loader is loaded.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.context("listing layers")?;
    Ok(layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER)))
}

fn messenger(
    entry: &ash::Entry,
    instance: &ash::Instance,
    messages: &Mutex<Vec<String>>,
) -> Result<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)> {
    let debug = ash::ext::debug_utils::Instance::new(entry, instance);
    let create = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR | vk::DebugUtilsMessageSeverityFlagsEXT::WARNING)
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE)
        .pfn_user_callback(Some(receive))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast());
    // SAFETY: `messages` is boxed in `InstanceShared`, which destroys the messenger first.
    let messenger = unsafe { debug.create_debug_utils_messenger(&create, None) }.context("the debug messenger")?;
    Ok((debug, messenger))
}

/// Keeps a message of the validation layer.
unsafe extern "system" fn receive(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes valid message data, and `user` is the list given to `messenger`.
    unsafe {
        if let (Some(messages), Some(data)) = (user.cast::<Mutex<Vec<String>>>().as_ref(), data.as_ref())
            && let Some(text) = data.message_as_c_str()
            && let Ok(mut messages) = messages.lock()
        {
            messages.push(text.to_string_lossy().into_owned());
        }
    }
    vk::FALSE
}

fn describe(instance: &ash::Instance, physical: vk::PhysicalDevice, requirements: &Requirements) -> DeviceInfo {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver).push_next(&mut subgroup);
    // SAFETY: `physical` belongs to `instance`; instance version 1.2 has this call.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
    let properties = properties.properties;
    let kind = match properties.device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
        _ => DeviceKind::Other,
    };
    let text = |name: &[c_char]| -> String {
        let bytes: Vec<u8> = name.iter().take_while(|c| **c != 0).map(|c| c.cast_unsigned()).collect();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    let driver = format!("{} {}", text(&driver.driver_name), text(&driver.driver_info));
    DeviceInfo {
        index: 0,
        name: text(&properties.device_name),
        driver: driver.trim().to_owned(),
        kind,
        memory_bytes: match kind {
            // Its heap has little to do with the machine's memory.
            DeviceKind::Cpu => available_memory(),
            _ => None,
        }
        .unwrap_or_else(|| device::local_memory(instance, physical)),
        max_buffer_bytes: u64::from(properties.limits.max_storage_buffer_range),
        has_shuffle: subgroup.supported_stages.contains(vk::ShaderStageFlags::COMPUTE)
            && subgroup
                .supported_operations
                .contains(vk::SubgroupFeatureFlags::BALLOT | vk::SubgroupFeatureFlags::SHUFFLE),
        max_image_rows: properties.limits.max_image_dimension2_d,
        unfit: unfit(instance, physical, &properties, requirements),
    }
}

/// Why a device cannot run the program, if it cannot.
fn unfit(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    properties: &vk::PhysicalDeviceProperties,
    requirements: &Requirements,
) -> Option<String> {
    let limits = &properties.limits;
    let needs = [
        ("storage buffers per stage", limits.max_per_stage_descriptor_storage_buffers, requirements.storage_buffers),
        ("storage images per stage", limits.max_per_stage_descriptor_storage_images, requirements.images),
        ("texels in a row", limits.max_image_dimension2_d, requirements.texels_per_row),
        ("bytes of push constants", limits.max_push_constants_size, requirements.push_constant_bytes),
        ("descriptor sets", limits.max_bound_descriptor_sets, requirements.descriptor_sets),
        ("invocations per workgroup", limits.max_compute_work_group_invocations, requirements.workgroup_size),
    ];
    if properties.api_version < API_VERSION {
        return Some("it has no Vulkan 1.2".into());
    }
    if device::compute_family(instance, physical).is_none() {
        return Some("it has no compute queue".into());
    }
    needs
        .into_iter()
        .find(|(_, has, needed)| has < needed)
        .map(|(what, has, needed)| format!("it has {has} {what}, and {needed} are needed"))
}
