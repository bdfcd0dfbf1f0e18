//! Where kernels bind their arrays, and the layouts of descriptors that follow from it.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::vk;

use crate::error::{Context, Result};
use crate::physical::ArrayKind;

/// Where a kernel binds an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Place {
    set: u32,
    binding: u32,
    sort: Sort,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
#[derive(Default)]
pub(crate) struct Layout {
    pub sets: Vec<vk::DescriptorSetLayout>,
    pub pipeline: vk::PipelineLayout,
}

/// The layouts of a device, which keeps them: without `VK_KHR_maintenance4`, a layout must live as long as the pipelines
/// that were made with it.
#[derive(Default)]
pub(crate) struct Layouts {
    made: Mutex<Made>,
}

/// Layouts by places and bytes of push constants.
type Made = HashMap<(&'static [Place], u32), Arc<Layout>>;

impl Layouts {
    /// Returns the layout of a kernel that binds arrays of a kind at these places and has so many bytes of push constants.
    pub fn get(
        &self,
        device: &ash::Device,
        arrays: ArrayKind,
        places: &'static [Place],
        push_bytes: u32,
    ) -> Result<Arc<Layout>> {
        let mut made = self.made();
        if let Some(layout) = made.get(&(places, push_bytes)) {
            return Ok(Arc::clone(layout));
        }
        let mut layout = Layout::default();
        if let Err(error) = layout.create(device, arrays, places, push_bytes) {
            // SAFETY: nothing uses what was made of it.
            unsafe { layout.destroy(device) };
            return Err(error);
        }
        let layout = Arc::new(layout);
        made.insert((places, push_bytes), Arc::clone(&layout));
        Ok(layout)
    }

    fn made(&self) -> MutexGuard<'_, Made> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Destroys all layouts.
    ///
    /// # Safety
    /// No pipeline is left, nothing uses a layout any more, and `device` is the one that made them.
    pub unsafe fn destroy(&self, device: &ash::Device) {
        for (_, layout) in self.made().drain() {
            // SAFETY: the caller promises it.
            unsafe { layout.destroy(device) };
        }
    }
}

impl Layout {
    fn create(&mut self, device: &ash::Device, arrays: ArrayKind, places: &[Place], push_bytes: u32) -> Result<()> {
        let slots: Vec<Slot> = places.iter().map(|place| place.slot(arrays)).collect();
        let set_count = slots.iter().map(|slot| slot.set + 1).max().unwrap_or(0);
        for set in 0..set_count {
            self.add_set(device, slots.iter().filter(|slot| slot.set == set))?;
        }
        let push = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(push_bytes)];
        let mut create = vk::PipelineLayoutCreateInfo::default().set_layouts(&self.sets);
        if push_bytes > 0 {
            create = create.push_constant_ranges(&push);
        }
        // SAFETY: destroyed by `destroy`.
        self.pipeline = unsafe { device.create_pipeline_layout(&create, None) }.context("a pipeline layout")?;
        Ok(())
    }

    /// Creates the layout of the next set. Slots that repeat an earlier one are those of a group.
    fn add_set<'a>(&mut self, device: &ash::Device, slots: impl Iterator<Item = &'a Slot>) -> Result<()> {
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
        // SAFETY: destroyed by `destroy`.
        let set = unsafe { device.create_descriptor_set_layout(&create, None) };
        self.sets.push(set.context("vkCreateDescriptorSetLayout")?);
        Ok(())
    }

    /// Destroys what was made. Destroying a null handle does nothing.
    ///
    /// # Safety
    /// As [`Layouts::destroy`].
    unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: the caller promises it.
        unsafe {
            device.destroy_pipeline_layout(self.pipeline, None);
            self.sets.iter().for_each(|set| device.destroy_descriptor_set_layout(*set, None));
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
