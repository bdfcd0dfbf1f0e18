//! Kernels as the build script describes them, and passes: compiled kernels with their arrays bound.

use std::marker::PhantomData;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};

use ash::vk;
use bytemuck::Pod;

use crate::buffer::{Buffer, RawBuffer};
use crate::error::{Context, Error, Result};
use crate::image::RawImage;
use crate::layout::{Layout, Place, Slot};
use crate::physical::{ArrayKind, DeviceInfo};
use crate::pipeline::{Code, Source};
use crate::shared::DeviceShared;
use crate::texels::{Part, Storage, Texels};

/// A kernel with its arrays. Implemented by generated code only.
pub trait Kernel {
    /// The file stem of its source: its label, its timer and its crash marker.
    const NAME: &'static str;
    /// Its code, for each kind of arrays and each workgroup size.
    const CODE: &'static [Code];
    /// Its push constants.
    type Push: Pod;
    /// Values for its specialization constants.
    type Specialization: SpecializationValues;
    /// Where it binds its arrays.
    const PLACES: &'static [Place];
    /// All of the above.
    const OUTLINE: Outline = Outline {
        name: Self::NAME,
        code: Self::CODE,
        places: Self::PLACES,
        push_bytes: size_of::<Self::Push>() as u32,
    };
    /// Returns its arrays, each with its place.
    fn bindings(&self) -> Vec<Binding<'_>>;
}

/// A kernel without its arrays: what is enough to compile it.
#[derive(Clone, Copy)]
pub struct Outline {
    /// [`Kernel::NAME`].
    pub name: &'static str,
    pub(crate) code: &'static [Code],
    pub(crate) places: &'static [Place],
    pub(crate) push_bytes: u32,
}

impl Outline {
    /// Returns the layout of its arrays and push constants on a device.
    pub(crate) fn layout(&self, device: &DeviceShared) -> Result<Arc<Layout>> {
        device.layouts.get(&device.raw, device.info.arrays, self.places, self.push_bytes)
    }

    /// Returns what the driver of a device compiles.
    pub(crate) fn source(
        &self,
        device: &DeviceInfo,
        specialization: &impl SpecializationValues,
        workgroup_size: u32,
        layout: &Layout,
    ) -> Result<Source> {
        let fits = |code: &&Code| code.arrays == device.arrays && code.workgroup_size == workgroup_size;
        let code = self.code.iter().find(fits).ok_or_else(|| Error::Unfit {
            device: device.name.clone(),
            reason: format!("kernel {} was not built for workgroups of {workgroup_size}", self.name),
        })?;
        let lanes = device.subgroups.required_for(workgroup_size);
        Ok(Source::new(code, |id| specialization.value(id), layout.pipeline, lanes, device.keeps_infinities))
    }
}

/// Values of specialization constants by id.
pub trait SpecializationValues {
    /// Returns the four bytes of a constant, or `None` if there is no constant with this id.
    fn value(&self, id: u32) -> Option<[u8; 4]>;
}

/// An array with its place.
pub struct Binding<'a> {
    slot: Slot,
    resource: Resource<'a>,
}

enum Resource<'a> {
    Buffer(&'a Arc<RawBuffer>),
    Image(&'a Arc<RawImage>),
}

impl<'a> Binding<'a> {
    /// Binds `buffer` at `place`.
    pub fn buffer<T: Pod>(place: Place, buffer: &'a Buffer<T>) -> Self {
        Self { slot: place.slot(ArrayKind::Buffers), resource: Resource::Buffer(buffer.raw()) }
    }

    /// Binds `texels` at `place`. Panics if the place is of a group, and the texels are not the array of that
    /// group that belongs there: the kernel would look for them at another place.
    pub fn texels<T: Pod>(place: Place, texels: &'a Texels<T>) -> Self {
        match texels.storage() {
            Storage::Image(image) => Self { slot: place.slot(ArrayKind::Images), resource: Resource::Image(image) },
            Storage::Part(Part { buffer, member, .. }) => {
                assert_eq!(*member, place.number(), "the number of {} in a group", texels.name());
                Self { slot: place.slot(ArrayKind::Buffers), resource: Resource::Buffer(buffer) }
            }
        }
    }

    /// Returns the contents of the descriptor; only the one of its type is used.
    fn descriptor(&self) -> ([vk::DescriptorBufferInfo; 1], [vk::DescriptorImageInfo; 1]) {
        let buffer = vk::DescriptorBufferInfo::default();
        let image = vk::DescriptorImageInfo::default();
        match self.resource {
            Resource::Buffer(raw) => ([buffer.buffer(raw.handle).range(raw.bytes)], [image]),
            Resource::Image(raw) => ([buffer], [image.image_view(raw.view).image_layout(vk::ImageLayout::GENERAL)]),
        }
    }

    fn keep(&self) -> Kept {
        match self.resource {
            Resource::Buffer(raw) => Kept::Buffer(Arc::clone(raw)),
            Resource::Image(raw) => Kept::Image(Arc::clone(raw)),
        }
    }
}

/// Returns bindings without those that repeat an earlier one, as arrays in the buffer of a group do. Panics if
/// one place has two arrays.
fn distinct(bindings: Vec<Binding<'_>>) -> Vec<Binding<'_>> {
    let mut distinct: Vec<Binding<'_>> = Vec::new();
    for binding in bindings {
        match distinct.iter().find(|other| other.slot == binding.slot) {
            None => distinct.push(binding),
            Some(other) => assert!(
                matches!((&other.resource, &binding.resource), (Resource::Buffer(a), Resource::Buffer(b)) if Arc::ptr_eq(a, b)),
                "set {}, binding {}: arrays of one group are in two",
                binding.slot.set,
                binding.slot.binding
            ),
        }
    }
    distinct
}

/// An array that a pass keeps alive.
enum Kept {
    Buffer(#[expect(dead_code, reason = "held, not used")] Arc<RawBuffer>),
    Image(#[expect(dead_code, reason = "held, not used")] Arc<RawImage>),
}

/// A compiled kernel with its arrays bound; `Push` are its push constants.
pub struct Pass<Push> {
    pub(crate) name: &'static str,
    /// `None` only until it is compiled.
    pipeline: Option<Arc<vk::Pipeline>>,
    pub(crate) layout: Arc<Layout>,
    pub(crate) sets: Vec<vk::DescriptorSet>,
    pub(crate) workgroup_size: u32,
    pool: vk::DescriptorPool,
    _kept: Vec<Kept>,
    device: Arc<DeviceShared>,
    push: PhantomData<Push>,
}

impl<Push: Pod> Pass<Push> {
    pub(crate) fn new<K: Kernel<Push = Push>>(
        device: &Arc<DeviceShared>,
        kernel: &K,
        specialization: &K::Specialization,
        workgroup_size: u32,
    ) -> Result<Self> {
        Compiling::new(device, kernel, specialization, workgroup_size)?.finish()
    }

    /// Creates a pass without its pipeline.
    fn unfinished<K: Kernel<Push = Push>>(device: &Arc<DeviceShared>, kernel: &K, workgroup_size: u32) -> Result<Self> {
        let bindings = distinct(kernel.bindings());
        let mut pass = Self {
            name: K::NAME,
            pipeline: None,
            layout: K::OUTLINE.layout(device)?,
            sets: Vec::new(),
            workgroup_size,
            pool: vk::DescriptorPool::null(),
            _kept: bindings.iter().map(Binding::keep).collect(),
            device: Arc::clone(device),
            push: PhantomData,
        };
        pass.bind(&bindings)?;
        Ok(pass)
    }

    /// Returns the compiled kernel.
    pub(crate) fn pipeline(&self) -> vk::Pipeline {
        self.pipeline.as_deref().copied().unwrap_or_default()
    }

    fn bind(&mut self, bindings: &[Binding<'_>]) -> Result<()> {
        if bindings.is_empty() {
            return Ok(());
        }
        let sizes: Vec<_> = bindings
            .iter()
            .map(|binding| vk::DescriptorPoolSize { ty: binding.slot.descriptor, descriptor_count: 1 })
            .collect();
        let create = vk::DescriptorPoolCreateInfo::default().max_sets(self.layout.sets.len() as u32).pool_sizes(&sizes);
        let descriptors: Vec<_> = bindings.iter().map(Binding::descriptor).collect();
        // SAFETY: the pool has room for exactly these sets and is destroyed with the
        // pass; what they point to is kept alive by the pass.
        unsafe {
            self.pool = self.device.raw.create_descriptor_pool(&create, None).context("vkCreateDescriptorPool")?;
            let allocate =
                vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&self.layout.sets);
            self.sets = self.device.raw.allocate_descriptor_sets(&allocate).context("vkAllocateDescriptorSets")?;
            let writes: Vec<_> = bindings
                .iter()
                .zip(&descriptors)
                .map(|(binding, (buffer, image))| {
                    let write = vk::WriteDescriptorSet::default()
                        .dst_set(self.sets[binding.slot.set as usize])
                        .dst_binding(binding.slot.binding)
                        .descriptor_type(binding.slot.descriptor);
                    match binding.resource {
                        Resource::Buffer(_) => write.buffer_info(buffer),
                        Resource::Image(_) => write.image_info(image),
                    }
                })
                .collect();
            self.device.raw.update_descriptor_sets(&writes, &[]);
        }
        Ok(())
    }
}

/// A pass whose kernel is being compiled on a thread of its own: a driver takes about a third of a second
/// for a kernel that traces rays.
pub struct Compiling<Push> {
    pass: Option<Pass<Push>>,
    thread: Option<JoinHandle<Result<Arc<vk::Pipeline>>>>,
}

impl<Push: Pod> Compiling<Push> {
    pub(crate) fn new<K: Kernel<Push = Push>>(
        device: &Arc<DeviceShared>,
        kernel: &K,
        specialization: &K::Specialization,
        workgroup_size: u32,
    ) -> Result<Self> {
        let pass = Pass::unfinished(device, kernel, workgroup_size)?;
        let source = K::OUTLINE.source(&device.info, specialization, workgroup_size, &pass.layout)?;
        let device = Arc::clone(device);
        let thread = Builder::new().spawn(move || device.pipelines.get(&device.raw, source)).map_err(Error::Thread)?;
        Ok(Self { pass: Some(pass), thread: Some(thread) })
    }

    /// Waits for the compiler and returns the pass.
    ///
    /// # Errors
    /// The driver refuses the kernel.
    pub fn finish(mut self) -> Result<Pass<Push>> {
        let failed = Error::Vulkan { call: "compiling a kernel", result: vk::Result::ERROR_UNKNOWN };
        match (self.pass.take(), self.thread.take().map(JoinHandle::join)) {
            (Some(mut pass), Some(Ok(pipeline))) => {
                pass.pipeline = Some(pipeline?);
                Ok(pass)
            }
            _ => Err(failed),
        }
    }
}

impl<Push> Drop for Compiling<Push> {
    fn drop(&mut self) {
        // Its pipeline stays with the device.
        let _pipeline = self.thread.take().map(JoinHandle::join);
    }
}

impl<Push> Drop for Pass<Push> {
    fn drop(&mut self) {
        // SAFETY: frames wait for the device before they return, so nothing uses it;
        // destroying a null handle does nothing.
        unsafe { self.device.raw.destroy_descriptor_pool(self.pool, None) };
    }
}
