//! The share of light that a rough boundary of dielectrics reflects, and the share that it transmits.

use std::f64::consts::TAU;

use glam::DVec3;

use super::coat::fresnel;

/// Samples of each of the two random numbers of a microfacet.
const SIDE: u32 = 16;

/// Returns the shares of light from a cosine that the boundary reflects and passes, for microfacets of GGX's alpha,
/// with Smith's joint masking; what facets block is lost. `eta` is the index of the far side over the near one.
pub(super) fn shares(cos: f64, eta: f64, alpha: f64) -> (f64, f64) {
    if alpha == 0.0 {
        let reflected = fresnel(cos, eta);
        return (reflected, 1.0 - reflected);
    }
    let wo = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let (mut reflected, mut passed) = (0.0, 0.0);
    for i in 0..SIDE * SIDE {
        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
        let m = visible_normal(wo, alpha, [place(i / SIDE), place(i % SIDE)]);
        let cos = wo.dot(m).min(1.0);
        let share = fresnel(cos, eta);
        let mirrored = 2.0 * cos * m - wo;
        if mirrored.z > 0.0 {
            reflected += share * masking(wo, mirrored, alpha);
        }
        let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0).sqrt();
        let refracted = (cos * m - wo) / eta - cos_t * m;
        if refracted.z < 0.0 {
            passed += (1.0 - share) * masking(wo, refracted, alpha);
        }
    }
    let count = f64::from(SIDE * SIDE);
    (reflected / count, passed / count)
}

/// Samples a normal by those that are visible from wo (Heitz 2018, "Sampling the GGX distribution of visible normals").
fn visible_normal(wo: DVec3, alpha: f64, [u, v]: [f64; 2]) -> DVec3 {
    let stretched = DVec3::new(alpha * wo.x, 0.0, wo.z).normalize();
    let (r, phi) = (u.sqrt(), TAU * v);
    let (x, middle) = (r * phi.cos(), 0.5 * (1.0 + stretched.z));
    let y = (1.0 - middle) * (1.0 - x * x).sqrt() + middle * r * phi.sin();
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let normal = x * DVec3::Y + y * stretched.cross(DVec3::Y) + z * stretched;
    DVec3::new(alpha * normal.x, alpha * normal.y, normal.z.max(0.0)).normalize()
}

/// Returns Smith's joint masking and shadowing over the masking of wo.
fn masking(wo: DVec3, wi: DVec3, alpha: f64) -> f64 {
    let lambda = |w: DVec3| 0.5 * ((1.0 + alpha * alpha * (1.0 - w.z * w.z).max(0.0) / (w.z * w.z)).sqrt() - 1.0);
    (1.0 + lambda(wo)) / (1.0 + lambda(wo) + lambda(wi))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn almost_smooth_boundaries_are_like_smooth_ones() {
        for eta in [1.5, 1.0 / 1.5] {
            for cos in [0.3, 0.6, 0.95] {
                let (rough, smooth) = (shares(cos, eta, 0.005), shares(cos, eta, 0.0));
                assert!((rough.0 - smooth.0).abs() < 0.01 && (rough.1 - smooth.1).abs() < 0.01, "{rough:?} {smooth:?}");
            }
        }
    }

    #[test]
    fn rough_boundaries_lose_a_little_and_gain_nothing() {
        for eta in [1.5, 1.0 / 1.5] {
            for cos in [0.1, 0.4, 0.9] {
                let (reflected, passed) = shares(cos, eta, 0.4);
                let whole = reflected + passed;
                assert!((0.6..1.0).contains(&whole), "{eta} at {cos}: {whole}");
            }
        }
    }
}
