//! What every test here uses: a validated device, and random inputs with a fixed seed.

use std::sync::Arc;

use bytemuck::Pod;
use glam::{DVec3, Vec3};
use goblet_host::{Buffer, Device, Extent, Kernel, Texels};

use crate::generated::Specialization;
use crate::support;
pub use crate::support::random::Rng;

/// 2^-24: the largest relative rounding error of one fp32 operation.
pub const EPS: f64 = 0.5 * f32::EPSILON as f64;

/// A ray's `t_max` that bounds nothing; `INFINITY_T` of the shaders.
pub const UNBOUNDED: f32 = 3.0e38;

/// A device that must not say anything.
pub struct Fixture {
    device: Arc<Device>,
}

impl Fixture {
    pub fn new() -> Self {
        Self { device: support::device() }
    }

    pub fn device(&self) -> &Device {
        &self.device
    }

    pub fn upload<T: Pod>(&self, data: &[T]) -> Buffer<T> {
        self.device.upload("input", data).expect("an upload")
    }

    pub fn upload_texels<T: Pod>(&self, data: &[T]) -> Texels<T> {
        self.device.upload_texels("input", data).expect("an upload")
    }

    /// The arrays of a group, all with the same elements.
    pub fn upload_group<T: Pod, const N: usize>(&self, data: &[T]) -> [Texels<T>; N] {
        let extents = [Extent::of::<T>("input", data.len() as u64); N];
        let mut group = self.device.group("group", &extents).expect("a group");
        [(); N].map(|()| {
            let texels = group.take();
            self.device.write_texels(&texels, data).expect("an upload");
            texels
        })
    }

    pub fn output<T: Pod>(&self, length: usize) -> Buffer<T> {
        self.device.buffer("output", length as u64).expect("a buffer")
    }

    pub fn output_texels<T: Pod>(&self, length: usize) -> Texels<T> {
        self.device.texels("output", length as u64).expect("texels")
    }

    pub fn read<T: Pod>(&self, buffer: &Buffer<T>) -> Vec<T> {
        self.device.read(buffer).expect("a download")
    }

    pub fn read_texels<T: Pod>(&self, texels: &Texels<T>) -> Vec<T> {
        self.device.read_texels(texels).expect("a download")
    }

    /// Runs a test kernel that has no push constants.
    pub fn run<K>(&self, kernel: &K, invocations: usize)
    where
        K: Kernel<Push = (), Specialization = Specialization>,
    {
        self.run_specialized(kernel, &Specialization::DECLARED, invocations);
    }

    /// The same for a scene that has other things.
    pub fn run_specialized<K>(&self, kernel: &K, specialization: &Specialization, invocations: usize)
    where
        K: Kernel<Push = (), Specialization = Specialization>,
    {
        let pass = self.device.pass(kernel, specialization, 64).expect("a pass");
        let mut frame = self.device.frame().expect("a frame");
        frame.dispatch(&pass, (), invocations as u64);
        frame.run().expect("a run");
    }
}

impl Drop for Fixture {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            support::assert_silent(&self.device);
        }
    }
}

/// The nearest fp32 vector.
pub fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// An fp32 vector, exactly.
pub fn double(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// Two unit vectors that make a right-handed frame with `n`.
pub fn frame(n: DVec3) -> (DVec3, DVec3) {
    let s = n.any_orthonormal_vector();
    (s, n.cross(s))
}
