//! What every test here uses: a validated device, and random inputs with a fixed seed.

use std::rc::Rc;

use bytemuck::Pod;
use glam::{DVec3, Vec3};
use goblet_host::{Buffer, Device, Kernel, Texels};

use crate::generated::Specialization;
use crate::support;

/// 2^-24: the largest relative rounding error of one fp32 operation.
pub const EPS: f64 = 0.5 * f32::EPSILON as f64;

/// A ray's `t_max` that bounds nothing; `INFINITY_T` of the shaders.
pub const UNBOUNDED: f32 = 3.0e38;

/// A device that must not say anything.
pub struct Bench {
    device: Rc<Device>,
}

impl Bench {
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

    pub fn output<T: Pod>(&self, length: usize) -> Buffer<T> {
        self.device.buffer("output", length as u64).expect("a buffer")
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

impl Drop for Bench {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            support::assert_silent(&self.device);
        }
    }
}

/// Splitmix64.
pub struct Rng(pub u64);

impl Rng {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (-53.0_f64).exp2()
    }

    /// Uniform in [0, 1) with 24 bits, as the shaders draw.
    pub fn unit_f32(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (-24.0_f32).exp2()
    }

    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Between two positive bounds, each order of magnitude as likely.
    pub fn log_range(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let phi = self.range(0.0, std::f64::consts::TAU);
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    }

    /// Uniform in a cube about the origin.
    pub fn cube(&mut self, half: f64) -> DVec3 {
        DVec3::new(self.range(-half, half), self.range(-half, half), self.range(-half, half))
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
