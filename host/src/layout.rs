//! Where kernels bind their arrays, and the layouts of descriptors that follow from it.

use std::sync::Arc;

use ash::vk;

use crate::error::{Context, Result};
use crate::physical::ArrayKind;
use crate::shared::DeviceShared;

/// Where a kernel binds an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    set: u32,
    binding: u32,
    sort: Sort,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sort {
    Buffer,
    Texels,
    /// Texels of a group, whose buffer is bound at `group`.
    Member {
        group: u32,
        number: u32,
    },
}

/// A place as it is where arrays are of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    pub set: u32,
    pub binding: u32,
    pub descriptor: vk::DescriptorType,
}

impl Place {
    /// The place of a buffer.
    pub const fn buffer(set: u32, binding: u32) -> Self {
        Self { set, binding, sort: Sort::Buffer }
    }

    /// The place of texels that are in no group.
    pub const fn texels(set: u32, binding: u32) -> Self {
        Self { set, binding, sort: Sort::Texels }
    }

    /// The place of texels that are the array with this number of a group: in an image at `binding`, in the
    /// group's buffer at `group`, as all arrays of the group are.
    pub const fn member(set: u32, binding: u32, group: u32, number: u32) -> Self {
        Self { set, binding, sort: Sort::Member { group, number } }
    }

    /// The number that an array must have in its group; `None` if it must be in none.
    pub(crate) fn number(self) -> Option<u32> {
        match self.sort {
            Sort::Member { number, .. } => Some(number),
            Sort::Buffer | Sort::Texels => None,
        }
    }

    /// The place where arrays are of this kind.
    pub(crate) fn slot(self, arrays: ArrayKind) -> Slot {
        let (binding, descriptor) = match (self.sort, arrays) {
            (Sort::Buffer, _) | (Sort::Texels, ArrayKind::Buffers) => {
                (self.binding, vk::DescriptorType::STORAGE_BUFFER)
            }
            (Sort::Texels | Sort::Member { .. }, ArrayKind::Images) => {
                (self.binding, vk::DescriptorType::STORAGE_IMAGE)
            }
            (Sort::Member { group, .. }, ArrayKind::Buffers) => (group, vk::DescriptorType::STORAGE_BUFFER),
        };
        Slot { set: self.set, binding, descriptor }
    }
}

/// What a kernel is bound by, without what is bound.
pub(crate) struct Layout {
    pub sets: Vec<vk::DescriptorSetLayout>,
    pub pipeline: vk::PipelineLayout,
    device: Arc<DeviceShared>,
}

impl Layout {
    /// Creates the layout of a kernel that binds arrays at these places and has so many bytes of push constants.
    pub fn new(device: &Arc<DeviceShared>, places: &[Place], push_bytes: u32) -> Result<Self> {
        let mut layout = Self { sets: Vec::new(), pipeline: vk::PipelineLayout::null(), device: Arc::clone(device) };
        let slots: Vec<Slot> = places.iter().map(|place| place.slot(device.info.arrays)).collect();
        let set_count = slots.iter().map(|slot| slot.set + 1).max().unwrap_or(0);
        for set in 0..set_count {
            layout.add_set(slots.iter().filter(|slot| slot.set == set))?;
        }
        let push = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(push_bytes)];
        let mut create = vk::PipelineLayoutCreateInfo::default().set_layouts(&layout.sets);
        if push_bytes > 0 {
            create = create.push_constant_ranges(&push);
        }
        // SAFETY: destroyed with the layout.
        layout.pipeline = unsafe { device.raw.create_pipeline_layout(&create, None) }.context("a pipeline layout")?;
        Ok(layout)
    }

    /// Creates the layout of the next set. Slots that repeat an earlier one are those of a group.
    fn add_set<'a>(&mut self, slots: impl Iterator<Item = &'a Slot>) -> Result<()> {
        let mut entries: Vec<vk::DescriptorSetLayoutBinding<'_>> = Vec::new();
        for slot in slots {
            if entries.iter().all(|entry| entry.binding != slot.binding) {
                entries.push(
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(slot.binding)
                        .descriptor_type(slot.descriptor)
                        .descriptor_count(1)
                        .stage_flags(vk::ShaderStageFlags::COMPUTE),
                );
            }
        }
        let create = vk::DescriptorSetLayoutCreateInfo::default().bindings(&entries);
        // SAFETY: destroyed with the layout.
        let set = unsafe { self.device.raw.create_descriptor_set_layout(&create, None) };
        self.sets.push(set.context("vkCreateDescriptorSetLayout")?);
        Ok(())
    }
}

impl Drop for Layout {
    fn drop(&mut self) {
        // SAFETY: whoever compiles or runs the kernel keeps its layout until that is done; destroying a null
        // handle does nothing.
        unsafe {
            self.device.raw.destroy_pipeline_layout(self.pipeline, None);
            for set in &self.sets {
                self.device.raw.destroy_descriptor_set_layout(*set, None);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_a_group_have_one_place_in_buffers_and_their_own_in_images() {
        let members = [Place::member(0, 3, 3, 0), Place::member(0, 4, 3, 1)];
        let bindings = |arrays| members.map(|place| place.slot(arrays).binding);
        assert_eq!((bindings(ArrayKind::Buffers), bindings(ArrayKind::Images)), ([3, 3], [3, 4]));
        let descriptors =
            [Place::buffer(1, 0), Place::texels(1, 1)].map(|place| place.slot(ArrayKind::Images).descriptor);
        assert_eq!(descriptors, [vk::DescriptorType::STORAGE_BUFFER, vk::DescriptorType::STORAGE_IMAGE]);
    }
}
