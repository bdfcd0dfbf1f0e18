//! The Vulkan instance, its validation messages, and the list of devices.

use std::ffi::{CStr, c_char, c_void};
use std::sync::{Arc, Mutex};

use ash::{khr, vk};

use crate::error::{Context, Error, Result};
use crate::physical::{API_VERSION, DeviceInfo, Requirements, describe};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

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

    /// Loads Vulkan as [`Instance::new`] does, with extensions.
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
        let has_portability = has_extension(&entry, khr::portability_enumeration::NAME)?;
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let mut create = vk::InstanceCreateInfo::default().application_info(&application);
        if has_portability {
            // Without it, devices that are a layer over another system's, such as MoltenVK, are not listed.
            extensions.push(khr::portability_enumeration::NAME.as_ptr());
            create = create.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
        }
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

    /// Returns the messages of the validation layer so far; empty without validation.
    pub fn validation_messages(&self) -> Vec<String> {
        self.shared.messages.lock().map(|messages| messages.clone()).unwrap_or_default()
    }

    /// Returns every device, in order of preference: discrete, integrated, virtual, CPU.
    ///
    /// # Errors
    /// The driver fails to list them.
    pub fn devices(&self, requirements: &Requirements) -> Result<Vec<DeviceInfo>> {
        Ok(self.ranked(requirements)?.into_iter().map(|(_, info)| info).collect())
    }

    /// Returns the device that [`Instance::open`](crate::Instance::open) opens.
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

fn has_extension(entry: &ash::Entry, name: &CStr) -> Result<bool> {
    // SAFETY: the loader is loaded.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }.context("listing extensions")?;
    Ok(extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name)))
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
