//! Kernels as the build script describes them, and passes: compiled kernels with their arrays bound.

use std::marker::PhantomData;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};

use ash::vk;
use bytemuck::Pod;

use crate::buffer::{Buffer, RawBuffer};
use crate::error::{Context, Error, Result};
use crate::image::RawImage;
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
    /// Returns its arrays with set and binding.
    fn bindings(&self) -> Vec<Binding<'_>>;
}

/// Values of specialization constants by id.
pub trait SpecializationValues {
    /// Returns the four bytes of a constant, or `None` if there is no constant with this id.
    fn value(&self, id: u32) -> Option<[u8; 4]>;
}

/// An array with its set and binding.
pub struct Binding<'a> {
    set: u32,
    binding: u32,
    resource: Resource<'a>,
}

enum Resource<'a> {
    Buffer(&'a Arc<RawBuffer>),
    Image(&'a Arc<RawImage>),
}

impl<'a> Binding<'a> {
    /// Binds `buffer` at `set` and `binding`.
    pub fn buffer<T: Pod>(set: u32, binding: u32, buffer: &'a Buffer<T>) -> Self {
        Self { set, binding, resource: Resource::Buffer(buffer.raw()) }
    }

    /// Binds `texels`, which are in no group, at `set` and `binding`.
    pub fn texels<T: Pod>(set: u32, binding: u32, texels: &'a Texels<T>) -> Self {
        Self { set, binding, resource: resource(texels, None) }
    }

    /// Binds `texels`, which are the array with number `member` of a group: in an image at `set` and `binding`,
    /// in the group's buffer at `set` and `group`, as all arrays of the group are.
    pub fn member<T: Pod>(set: u32, binding: u32, group: u32, member: u32, texels: &'a Texels<T>) -> Self {
        let resource = resource(texels, Some(member));
        let binding = if matches!(resource, Resource::Image(_)) { binding } else { group };
        Self { set, binding, resource }
    }

    fn descriptor_type(&self) -> vk::DescriptorType {
        match self.resource {
            Resource::Buffer(_) => vk::DescriptorType::STORAGE_BUFFER,
            Resource::Image(_) => vk::DescriptorType::STORAGE_IMAGE,
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

/// Returns the image or the buffer that has texels. Panics if their number in a group is not `member`: the
/// kernel would look for them at another place.
fn resource<T>(texels: &Texels<T>, member: Option<u32>) -> Resource<'_> {
    match texels.storage() {
        Storage::Image(image) => Resource::Image(image),
        Storage::Part(Part { buffer, member: has, .. }) => {
            assert_eq!(*has, member, "the number of {} in a group", texels.name());
            Resource::Buffer(buffer)
        }
    }
}

/// Returns bindings without those that repeat an earlier one, as arrays in the buffer of a group do. Panics if
/// one place has two arrays.
fn distinct(bindings: Vec<Binding<'_>>) -> Vec<Binding<'_>> {
    let mut distinct: Vec<Binding<'_>> = Vec::new();
    for binding in bindings {
        match distinct.iter().find(|other| (other.set, other.binding) == (binding.set, binding.binding)) {
            None => distinct.push(binding),
            Some(other) => assert!(
                matches!((&other.resource, &binding.resource), (Resource::Buffer(a), Resource::Buffer(b)) if Arc::ptr_eq(a, b)),
                "set {}, binding {}: arrays of one group are in two",
                binding.set,
                binding.binding
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
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) sets: Vec<vk::DescriptorSet>,
    pub(crate) workgroup_size: u32,
    set_layouts: Vec<vk::DescriptorSetLayout>,
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
            layout: vk::PipelineLayout::null(),
            sets: Vec::new(),
            workgroup_size,
            set_layouts: Vec::new(),
            pool: vk::DescriptorPool::null(),
            _kept: bindings.iter().map(Binding::keep).collect(),
            device: Arc::clone(device),
            push: PhantomData,
        };
        pass.create_layout(&bindings)?;
        pass.bind(&bindings)?;
        Ok(pass)
    }

    /// Returns the compiled kernel.
    pub(crate) fn pipeline(&self) -> vk::Pipeline {
        self.pipeline.as_deref().copied().unwrap_or_default()
    }

    fn create_layout(&mut self, bindings: &[Binding<'_>]) -> Result<()> {
        let set_count = bindings.iter().map(|binding| binding.set + 1).max().unwrap_or(0);
        for set in 0..set_count {
            let entries: Vec<_> = bindings
                .iter()
                .filter(|binding| binding.set == set)
                .map(|binding| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(binding.binding)
                        .descriptor_type(binding.descriptor_type())
                        .descriptor_count(1)
                        .stage_flags(vk::ShaderStageFlags::COMPUTE)
                })
                .collect();
            let create = vk::DescriptorSetLayoutCreateInfo::default().bindings(&entries);
            // SAFETY: destroyed with the pass.
            let layout = unsafe { self.device.raw.create_descriptor_set_layout(&create, None) };
            self.set_layouts.push(layout.context("vkCreateDescriptorSetLayout")?);
        }
        let push = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(size_of::<Push>() as u32)];
        let mut create = vk::PipelineLayoutCreateInfo::default().set_layouts(&self.set_layouts);
        if size_of::<Push>() > 0 {
            create = create.push_constant_ranges(&push);
        }
        // SAFETY: destroyed with the pass.
        self.layout = unsafe { self.device.raw.create_pipeline_layout(&create, None) }.context("a pipeline layout")?;
        Ok(())
    }

    fn bind(&mut self, bindings: &[Binding<'_>]) -> Result<()> {
        if bindings.is_empty() {
            return Ok(());
        }
        let sizes: Vec<_> = bindings
            .iter()
            .map(|binding| vk::DescriptorPoolSize { ty: binding.descriptor_type(), descriptor_count: 1 })
            .collect();
        let create = vk::DescriptorPoolCreateInfo::default().max_sets(self.set_layouts.len() as u32).pool_sizes(&sizes);
        let descriptors: Vec<_> = bindings.iter().map(Binding::descriptor).collect();
        // SAFETY: the pool has room for exactly these sets and is destroyed with the
        // pass; what they point to is kept alive by the pass.
        unsafe {
            self.pool = self.device.raw.create_descriptor_pool(&create, None).context("vkCreateDescriptorPool")?;
            let allocate =
                vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&self.set_layouts);
            self.sets = self.device.raw.allocate_descriptor_sets(&allocate).context("vkAllocateDescriptorSets")?;
            let writes: Vec<_> = bindings
                .iter()
                .zip(&descriptors)
                .map(|(binding, (buffer, image))| {
                    let write = vk::WriteDescriptorSet::default()
                        .dst_set(self.sets[binding.set as usize])
                        .dst_binding(binding.binding)
                        .descriptor_type(binding.descriptor_type());
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
        let (arrays, size) = (device.info.arrays, workgroup_size);
        let code = K::CODE.iter().find(|code| code.arrays == arrays && code.workgroup_size == size);
        let code = code.ok_or_else(|| Error::Unfit {
            device: device.info.name.clone(),
            reason: format!("kernel {} was not built for workgroups of {workgroup_size}", K::NAME),
        })?;
        let lanes = device.info.subgroups.required_for(workgroup_size);
        let source = Source::new(code, |id| specialization.value(id), pass.layout, lanes);
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
        // The thread uses the pass's layout. Its pipeline stays with the device.
        let _pipeline = self.thread.take().map(JoinHandle::join);
    }
}

impl<Push> Drop for Pass<Push> {
    fn drop(&mut self) {
        // SAFETY: frames wait for the device before they return, so nothing uses it;
        // destroying a null handle does nothing.
        unsafe {
            self.device.raw.destroy_pipeline_layout(self.layout, None);
            self.device.raw.destroy_descriptor_pool(self.pool, None);
            for layout in &self.set_layouts {
                self.device.raw.destroy_descriptor_set_layout(*layout, None);
            }
        }
    }
}
