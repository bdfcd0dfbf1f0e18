//! Sets of rays, in render space.

use std::f64::consts::PI;

use goblet::Device;
use goblet::glam::DVec3;
use goblet::kernels::TILE;
use goblet::render::options::DEFAULT_EYE_PATHS;
use goblet::render::photons_per_invocation;
use goblet_host::{Kernel, Texels};
use goblet_test_kernels::{FollowPhotons, FollowPhotonsPush, SeePixels, SeePixelsPush, TracedRay};

use crate::Result;
use crate::prepare::Prepared;
use crate::random::Rng;

/// Invocations of a workgroup.
pub const WORKGROUP_SIZE: u32 = 64;
/// The `t_max` of a ray that nothing bounds; `INFINITY_T` of the shaders.
const UNBOUNDED: f32 = 3.0e38;

/// What rays are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Set {
    /// Origins uniform in the scene's bounding box, directions uniform: no two rays go alike.
    Random,
    /// Through the pixels, as the eye pass begins its paths.
    Eye,
    /// The segments of photon paths, in the order of the photon pass.
    Photon,
}

impl Set {
    pub const ALL: [Self; 3] = [Self::Random, Self::Eye, Self::Photon];

    pub fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Eye => "eye",
            Self::Photon => "photon",
        }
    }
}

/// A set of rays on the device. Each invocation traces every `invocations`-th ray.
pub struct Rays {
    pub set: Set,
    pub texels: Texels<TracedRay>,
    pub count: u64,
    pub invocations: u64,
}

impl Rays {
    /// About `wanted` rays, in whole tiles or workgroups; `None` if the scene has none.
    pub fn new(device: &Device, scene: &Prepared, set: Set, wanted: u64) -> Result<Option<Self>> {
        // As many rays one after the other as in the pass: those of random rays are the photon pass's.
        let each = match set {
            Set::Eye => DEFAULT_EYE_PATHS.into(),
            Set::Random | Set::Photon => photons_per_invocation(device.info().kind),
        };
        let tile = u64::from(TILE);
        let side = ((wanted / each).isqrt() / tile).max(1) * tile;
        let size = u64::from(WORKGROUP_SIZE);
        let invocations = if set == Set::Eye { side * side } else { (wanted / each / size).max(1) * size };
        let count = invocations * each;
        let texels = match set {
            Set::Random => device.upload_texels("rays", &random(scene, count))?,
            Set::Eye => eye(device, scene, side as u32, count)?,
            Set::Photon if scene.has_lights => photon(device, scene, invocations, count)?,
            Set::Photon => return Ok(None),
        };
        Ok(Some(Self { set, texels, count, invocations }))
    }
}

fn random(scene: &Prepared, count: u64) -> Vec<TracedRay> {
    let mut rng = Rng(12345);
    let ray = |_| {
        let origin = scene.space.half_extent * rng.cube(1.0);
        let (z, phi) = (1.0 - 2.0 * rng.unit(), 2.0 * PI * rng.unit());
        let direction = DVec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z);
        let [origin, direction] = [origin, direction].map(|v| v.as_vec3().to_array());
        TracedRay { origin, t_max: UNBOUNDED, direction, pad0: 0.0 }
    };
    (0..count).map(ray).collect()
}

fn eye(device: &Device, scene: &Prepared, side: u32, count: u64) -> Result<Texels<TracedRay>> {
    let rays = device.texels("rays", count)?;
    let view = scene.view(side);
    let camera = device.upload_texels("camera", &[view.camera])?;
    let filter_table = device.upload_texels("filter_table", &view.filter_table)?;
    let kernel = SeePixels { scene: scene.gpu.bindings(), camera: &camera, filter_table: &filter_table, rays: &rays };
    make(device, scene, &kernel, SeePixelsPush { count: count as u32 }, u64::from(side).pow(2))?;
    Ok(rays)
}

fn photon(device: &Device, scene: &Prepared, invocations: u64, count: u64) -> Result<Texels<TracedRay>> {
    let rays = device.texels("rays", count)?;
    let (guide_nodes, guide_lights) = (device.texels("guide_nodes", 0)?, device.texels("guide_lights", 0)?);
    let (guide_nodes, guide_lights) = (&guide_nodes, &guide_lights);
    let kernel = FollowPhotons { scene: scene.gpu.bindings(), guide_nodes, guide_lights, rays: &rays };
    make(device, scene, &kernel, FollowPhotonsPush { count: count as u32 }, invocations)?;
    Ok(rays)
}

/// Runs a kernel that makes rays.
fn make<K>(device: &Device, scene: &Prepared, kernel: &K, push: K::Push, invocations: u64) -> Result<()>
where
    K: Kernel<Specialization = goblet::kernels::Specialization>,
{
    let pass = device.pass(kernel, &scene.specialization, WORKGROUP_SIZE)?;
    let mut frame = device.frame()?;
    frame.dispatch(&pass, push, invocations);
    Ok(frame.run()?)
}
