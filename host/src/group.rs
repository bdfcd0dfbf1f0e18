//! Groups of texels that kernels bind together. Where texels are in images, each has its own. Where they are
//! in buffers, a group is one buffer. A table at its start has one word for each array: the texel of the
//! buffer where the array begins.

use std::collections::VecDeque;
use std::ops::Range;

use bytemuck::Pod;

use crate::texels::{Extent, Storage, Texels};

/// Bytes of a texel of a group.
const TEXEL_BYTES: u64 = 16;

/// The arrays of a group, allocated, until each is taken.
pub struct Group {
    arrays: VecDeque<(Extent, Storage)>,
}

impl Group {
    pub(crate) fn new(arrays: impl Iterator<Item = (Extent, Storage)>) -> Self {
        Self { arrays: arrays.collect() }
    }

    /// Takes the next array. Panics if there is none, or if it has elements of another size.
    pub fn take<T: Pod>(&mut self) -> Texels<T> {
        let (extent, storage) = self.arrays.pop_front().expect("the group has no more arrays");
        Texels::new(&extent, storage)
    }
}

/// The places of arrays in the buffer of their group.
pub(crate) struct Layout {
    /// For each array the texel where it begins, and zeros up to whole texels.
    pub table: Vec<u32>,
    /// Bytes of each array.
    pub places: Vec<Range<u64>>,
    /// The end of the last array.
    pub bytes: u64,
}

impl Layout {
    /// Places arrays one after the other, with `gap` bytes after each but the last.
    pub fn new(extents: &[Extent], gap: u64) -> Self {
        let mut table = vec![0; extents.len().next_multiple_of(TEXEL_BYTES as usize / 4)];
        let mut places = Vec::new();
        let mut end = size_of_val(&table[..]) as u64;
        for (extent, word) in extents.iter().zip(&mut table) {
            assert_eq!(u64::from(extent.texel_bytes()), TEXEL_BYTES, "{} has words for texels", extent.name);
            let first = end + if places.is_empty() { 0 } else { gap };
            // One that does not fit in a word is after more bytes than a device binds.
            *word = u32::try_from(first / TEXEL_BYTES).unwrap_or(u32::MAX);
            end = first.saturating_add(extent.bytes());
            places.push(first..end);
        }
        Self { table, places, bytes: end }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_a_group_follow_its_table() {
        let extents = [Extent::of::<[f32; 8]>("a", 3), Extent::of::<[u32; 4]>("b", 0), Extent::of::<[u32; 4]>("c", 2)];
        let Layout { table, places, bytes } = Layout::new(&extents, 0);
        assert_eq!(table, [1, 7, 8, 0]);
        assert_eq!(places, [16..112, 112..128, 128..160]);
        assert_eq!(bytes, 160);
        let Layout { table, places, bytes } = Layout::new(&extents, 32);
        assert_eq!(table, [1, 9, 12, 0]);
        assert_eq!(places, [16..112, 144..160, 192..224]);
        assert_eq!(bytes, 224);
    }
}
