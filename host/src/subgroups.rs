//! How many invocations of a kernel run together: the lanes of its subgroups.
//!
//! Vulkan has one number for a device, `subgroupSize`, and a device may run any kernel with fewer lanes. So a
//! kernel may rely on a number of lanes only if the device has been told to run it so, or if the device runs
//! all kernels alike.

use ash::vk;

/// Lanes that a device is told to run kernels with, if it lets itself be told. Wider subgroups take more
/// instructions for a shuffle on some graphics cards.
const WANTED: u32 = 32;

/// What a device says of its subgroups.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Subgroups {
    /// Lanes, as the device reports them. Kernels may run with fewer.
    pub size: u32,
    /// The number that kernels are compiled for, where the device can be told (`VK_EXT_subgroup_size_control`).
    pub required: Option<u32>,
    /// Whether compute kernels can use ballots and shuffles.
    pub has_shuffle: bool,
    /// Whether all kernels run with the same number of lanes.
    is_fixed: bool,
    /// Most subgroups of a workgroup, where `required` lanes are asked for.
    most: u32,
}

impl Subgroups {
    /// Asks a device; `has_control` says whether it has `VK_EXT_subgroup_size_control`.
    pub(crate) fn of(instance: &ash::Instance, physical: vk::PhysicalDevice, has_control: bool) -> Self {
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut control = vk::PhysicalDeviceSubgroupSizeControlProperties::default();
        let mut allowed = vk::PhysicalDeviceSubgroupSizeControlFeatures::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut subgroup);
        let mut features = vk::PhysicalDeviceFeatures2::default();
        if has_control {
            properties = properties.push_next(&mut control);
            features = features.push_next(&mut allowed);
        }
        // SAFETY: `physical` belongs to `instance`, whose version 1.2 has these functions, and has the extension
        // of what is chained.
        unsafe {
            instance.get_physical_device_properties2(physical, &mut properties);
            instance.get_physical_device_features2(physical, &mut features);
        }
        let can_require = allowed.subgroup_size_control == vk::TRUE
            && allowed.compute_full_subgroups == vk::TRUE
            && control.required_subgroup_size_stages.contains(vk::ShaderStageFlags::COMPUTE);
        let [least, most] = [control.min_subgroup_size, control.max_subgroup_size];
        let operations = vk::SubgroupFeatureFlags::BALLOT | vk::SubgroupFeatureFlags::SHUFFLE;
        Self {
            size: subgroup.subgroup_size,
            required: (can_require && least <= most).then(|| WANTED.clamp(least, most)),
            has_shuffle: subgroup.supported_stages.contains(vk::ShaderStageFlags::COMPUTE)
                && subgroup.supported_operations.contains(operations),
            is_fixed: has_control && least == most,
            most: control.max_compute_workgroup_subgroups,
        }
    }

    /// Returns the number of lanes of each subgroup of a kernel with workgroups of this size. `None` if the
    /// device does not commit itself.
    pub fn lanes(&self, workgroup_size: u32) -> Option<u32> {
        self.required_for(workgroup_size).or(self.is_fixed.then(|| self.size.min(workgroup_size)))
    }

    /// Returns the number of lanes that a kernel with workgroups of this size is compiled for. Its workgroups
    /// must consist of whole subgroups.
    pub(crate) fn required_for(&self, workgroup_size: u32) -> Option<u32> {
        let fits = |lanes: &u32| workgroup_size.is_multiple_of(*lanes) && workgroup_size / lanes <= self.most;
        self.required.filter(fits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_known_only_where_a_device_commits_itself() {
        let reports = Subgroups { size: 32, ..Subgroups::default() };
        assert_eq!(reports.lanes(64), None);
        let can_be_told = Subgroups { required: Some(32), most: 16, ..reports };
        assert_eq!((can_be_told.lanes(64), can_be_told.lanes(16), can_be_told.lanes(1024)), (Some(32), None, None));
        let fixed = Subgroups { size: 8, is_fixed: true, ..Subgroups::default() };
        assert_eq!((fixed.lanes(64), fixed.lanes(4)), (Some(8), Some(4)));
    }
}
