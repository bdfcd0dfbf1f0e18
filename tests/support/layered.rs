//! pbrt-v4's layered BSDF (Pharr and others 2023, section 14.3) in f64: a random walk between a dielectric boundary
//! and a Lambertian base, in a slab that absorbs and scatters. Lengths are in mean free paths, z is up.

use std::f64::consts::PI;

use glam::DVec3;

use super::random::Rng;

/// A coat over a Lambertian base.
#[derive(Clone, Copy, Debug)]
pub struct Layered {
    /// Thickness in mean free paths.
    pub thickness: f64,
    /// Share of the extinguished light that is scattered.
    pub albedo: f64,
    /// Mean cosine of scattering.
    pub g: f64,
    /// Albedo of the base.
    pub reflectance: f64,
    /// Index of the coat over that outside.
    pub eta: f64,
    /// GGX's alpha of the boundary; 0 is smooth.
    pub alpha: f64,
}

/// Where a walk is: going down from the boundary, at the base, or at a point inside.
struct Walker {
    /// Height over the base.
    z: f64,
    /// Direction of travel, inside.
    w: DVec3,
    weight: f64,
}

pub fn fresnel(cos_i: f64, eta: f64) -> f64 {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

fn phase(cos: f64, g: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5))
}

fn about(axis: DVec3, cos: f64, phi: f64) -> DVec3 {
    let (x, y) = axis.any_orthonormal_pair();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    axis * cos + sin * (phi.cos() * x + phi.sin() * y)
}

impl Layered {
    /// What a walk meets: returns the share of light from a direction (its cosine outside) that goes back, all lobes
    /// together, as the mean of `walks`.
    pub fn albedo(&self, cos: f64, walks: usize, rng: &mut Rng) -> f64 {
        let from = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        let mut sum = 0.0;
        for _ in 0..walks {
            let (mut weight, outward) = (1.0, -from);
            match self.meet_boundary(outward, &mut weight, rng) {
                Some(w) if w.z > 0.0 => sum += weight,
                Some(w) => sum += self.walk(w, weight, rng, &mut |_, _| ()),
                None => {}
            }
        }
        sum / walks as f64
    }

    /// Returns the BSDF of a smooth coat without the reflection off the coat, 1/sr, as the mean of `walks`.
    pub fn bsdf(&self, from: DVec3, to: DVec3, walks: usize, rng: &mut Rng) -> f64 {
        assert!(self.alpha == 0.0);
        let inside = |w: DVec3| {
            let flat = DVec3::new(w.x, w.y, 0.0) / self.eta;
            DVec3::new(flat.x, flat.y, (1.0 - flat.length_squared()).sqrt())
        };
        let (up, down) = (inside(to), -inside(from));
        let leaving = (1.0 - fresnel(to.z, self.eta)) / (self.eta * self.eta);
        let mut sum = 0.0;
        for _ in 0..walks {
            // The boundary passes the same share of each walk.
            let weight = 1.0 - fresnel(from.z, self.eta);
            self.walk(down, weight, rng, &mut |walker, is_base| {
                let height = self.thickness - walker.z;
                let shown =
                    if is_base { self.reflectance / PI } else { self.albedo * phase(walker.w.dot(up), self.g) / up.z };
                sum += walker.weight * shown * (-height / up.z).exp() * leaving;
            });
        }
        sum / walks as f64
    }

    /// Follows light that has entered. Calls `event` where it scatters, before it does. Returns the weight that leaves.
    fn walk(&self, w: DVec3, weight: f64, rng: &mut Rng, event: &mut dyn FnMut(&Walker, bool)) -> f64 {
        let mut walker = Walker { z: self.thickness, w, weight };
        loop {
            // Russian roulette, by the weight alone.
            if walker.weight < 0.05 {
                if rng.unit() < 0.5 {
                    return 0.0;
                }
                walker.weight *= 2.0;
            }
            let free = -(1.0 - rng.unit()).ln() * walker.w.z;
            let z = walker.z + free;
            if self.albedo > 0.0 && 0.0 < z && z < self.thickness {
                walker.z = z;
                event(&walker, false);
                walker.weight *= self.albedo;
                walker.w = self.scattered(walker.w, rng);
                continue;
            }
            if self.albedo == 0.0 {
                let way = if walker.w.z > 0.0 { self.thickness - walker.z } else { walker.z };
                walker.weight *= (-way / walker.w.z.abs()).exp();
            }
            if walker.w.z < 0.0 {
                walker.z = 0.0;
                event(&walker, true);
                walker.weight *= self.reflectance;
                let (cos, phi) = (rng.unit().sqrt(), 2.0 * PI * rng.unit());
                walker.w = about(DVec3::Z, cos, phi);
            } else {
                walker.z = self.thickness;
                match self.meet_boundary(walker.w, &mut walker.weight, rng) {
                    Some(w) if w.z > 0.0 => return walker.weight,
                    Some(w) => walker.w = w,
                    None => return 0.0,
                }
            }
            if walker.weight == 0.0 {
                return 0.0;
            }
        }
    }

    fn scattered(&self, w: DVec3, rng: &mut Rng) -> DVec3 {
        let (g, u) = (self.g, rng.unit());
        let cos = if g.abs() < 1e-3 {
            2.0 * u - 1.0
        } else {
            let root = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
            (1.0 + g * g - root * root) / (2.0 * g)
        };
        about(w, cos.clamp(-1.0, 1.0), 2.0 * PI * rng.unit())
    }

    /// Meets the boundary from either side with a direction of travel, and goes on as chance has it. The new direction
    /// is up outside, down inside; `None` if facets block it.
    fn meet_boundary(&self, w: DVec3, weight: &mut f64, rng: &mut Rng) -> Option<DVec3> {
        let is_inside = w.z > 0.0;
        let eta = if is_inside { 1.0 / self.eta } else { self.eta };
        // In a frame in which the side of arrival is up.
        let side = if is_inside { -1.0 } else { 1.0 };
        let wo = DVec3::new(-w.x, -w.y, -w.z * side);
        let m = self.facet(wo, rng);
        let cos = wo.dot(m).min(1.0);
        let sin2_t = (1.0 - cos * cos) / (eta * eta);
        let reflects = rng.unit() < fresnel(cos, eta);
        let out = if reflects { 2.0 * cos * m - wo } else { (cos * m - wo) / eta - (1.0 - sin2_t).max(0.0).sqrt() * m };
        if (out.z > 0.0) != reflects {
            return None;
        }
        *weight *= self.masking(wo, out);
        Some(DVec3::new(out.x, out.y, out.z * side))
    }

    /// Samples a visible normal (Heitz 2018).
    fn facet(&self, wo: DVec3, rng: &mut Rng) -> DVec3 {
        let a = self.alpha;
        if a == 0.0 {
            return DVec3::Z;
        }
        let stretched = DVec3::new(a * wo.x, a * wo.y, wo.z).normalize();
        let flat = DVec3::new(-stretched.y, stretched.x, 0.0).try_normalize().unwrap_or(DVec3::X);
        let (r, phi) = (rng.unit().sqrt(), 2.0 * PI * rng.unit());
        let (x, s) = (r * phi.cos(), 0.5 * (1.0 + stretched.z));
        let y = (1.0 - s) * (1.0 - x * x).sqrt() + s * r * phi.sin();
        let normal = x * flat + y * stretched.cross(flat) + (1.0 - x * x - y * y).max(0.0).sqrt() * stretched;
        DVec3::new(a * normal.x, a * normal.y, normal.z.max(0.0)).normalize()
    }

    /// Smith's joint masking over that of wo alone.
    fn masking(&self, wo: DVec3, out: DVec3) -> f64 {
        let lambda = |w: DVec3| {
            let tan2 = (1.0 - w.z * w.z).max(0.0) / (w.z * w.z);
            0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
        };
        (1.0 + lambda(wo)) / (1.0 + lambda(wo) + lambda(out))
    }
}
