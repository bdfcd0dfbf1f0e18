//! Arrays for random access by kernels: in images or in buffers, whichever the device loads from faster.

use std::marker::PhantomData;
use std::sync::Arc;

use bytemuck::Pod;

use crate::buffer::RawBuffer;
use crate::error::Result;
use crate::image::RawImage;
use crate::shared::DeviceShared;

/// An array of `T` in an image or a buffer. An element of four bytes is one texel of a word; others are a
/// whole number of texels of four words.
pub struct Texels<T> {
    name: &'static str,
    storage: Storage,
    length: u64,
    element: PhantomData<T>,
}

impl<T: Pod> Texels<T> {
    /// Takes the memory that was allocated for an extent of this element.
    pub(crate) fn new(extent: &Extent, storage: Storage) -> Self {
        assert_eq!(extent.element_bytes, size_of::<T>() as u64, "{} has other elements", extent.name);
        Self { name: extent.name, storage, length: extent.length, element: PhantomData }
    }
}

impl<T> Texels<T> {
    /// Returns the number of elements.
    pub fn len(&self) -> u64 {
        self.length
    }

    /// Returns whether they have no element.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Returns their name in messages.
    pub fn name(&self) -> &'static str {
        self.name
    }

    pub(crate) fn storage(&self) -> &Storage {
        &self.storage
    }
}

/// The memory of texels.
#[derive(Clone)]
pub(crate) enum Storage {
    Image(Arc<RawImage>),
    Part(Part),
}

/// A part of a buffer, or all of it.
#[derive(Clone)]
pub(crate) struct Part {
    pub buffer: Arc<RawBuffer>,
    /// Byte of the buffer where it begins.
    pub first: u64,
    pub bytes: u64,
    /// Its number in the group whose buffer this is; `None` if the buffer has nothing else.
    pub member: Option<u32>,
}

/// The size of an array that is to be allocated.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    pub(crate) name: &'static str,
    length: u64,
    element_bytes: u64,
}

impl Extent {
    /// Returns the extent of `length` elements. Panics if they are not made of texels.
    pub fn of<T: Pod>(name: &'static str, length: u64) -> Self {
        let extent = Self { name, length, element_bytes: size_of::<T>() as u64 };
        let texel = u64::from(extent.texel_bytes());
        assert!(size_of::<T>() > 0 && extent.element_bytes.is_multiple_of(texel), "{name} is not made of texels");
        extent
    }

    /// Returns the bytes of a texel.
    pub(crate) fn texel_bytes(&self) -> u32 {
        if self.element_bytes == 4 { 4 } else { 16 }
    }

    /// Returns the bytes to allocate: of one element at least, since Vulkan binds nothing empty.
    pub(crate) fn bytes(&self) -> u64 {
        self.length.max(1).saturating_mul(self.element_bytes)
    }

    /// Allocates an image with a guard zone of a number of rows.
    pub(crate) fn image(&self, device: &Arc<DeviceShared>, guard_rows: u64) -> Result<Arc<RawImage>> {
        let texels = self.bytes() / u64::from(self.texel_bytes());
        Ok(Arc::new(RawImage::new(device, self.name, texels, self.texel_bytes(), guard_rows)?))
    }
}
