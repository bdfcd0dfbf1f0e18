//! Materials as kernels read them.

use crate::kernels::{
    self, BY_REFLECTANCE, COATED_CONDUCTOR, COATED_DIFFUSE, CONDUCTOR, DIELECTRIC, DIFFUSE, DIFFUSE_TRANSMISSION,
    HAS_LAMBERTIAN, MIX, NONE, REMAPPED, REMAPPED_COAT, Specialization, THIN_DIELECTRIC,
};
use crate::scene::{Coat, Input, Material, Metal, Rgb, Roughness};

/// Smoother surfaces are mirrors: pbrt's bound.
const LEAST_ALPHA: f64 = 1e-3;
/// Beyond it, facets stand on end: rougher ones look the same.
const MOST_ALPHA: f64 = 100.0;

/// Packs all materials of a scene.
pub(super) fn pack_materials(materials: &[Material]) -> Vec<kernels::Material> {
    let mut packed: Vec<kernels::Material> = materials.iter().map(pack_material).collect();
    for (i, material) in materials.iter().enumerate() {
        // What a mix is of stands before it.
        if let Material::Mix { materials: [first, second], .. } = material {
            packed[i].flags = (packed[*first].flags | packed[*second].flags) & HAS_LAMBERTIAN;
        }
    }
    packed
}

fn pack_material(material: &Material) -> kernels::Material {
    let zero = kernels::Material {
        kind: DIFFUSE,
        color_texture: NONE,
        second_texture: NONE,
        alpha_u_texture: NONE,
        alpha_v_texture: NONE,
        amount_texture: NONE,
        coat_u_texture: NONE,
        coat_v_texture: NONE,
        ..bytemuck::Zeroable::zeroed()
    };
    match material {
        Material::Diffuse { reflectance } => {
            with_color(kernels::Material { flags: HAS_LAMBERTIAN, ..zero }, reflectance)
        }
        // No shape is of it.
        Material::Interface => zero,
        Material::DiffuseTransmission { reflectance, transmittance, scale } => {
            let (second, second_texture) = color(transmittance);
            let [reflected, transmitted] = [color(reflectance).0, second].map(|part| scaled(part, *scale));
            kernels::Material {
                kind: DIFFUSE_TRANSMISSION,
                color: reflected,
                second: transmitted,
                second_texture,
                amount: *scale as f32,
                flags: HAS_LAMBERTIAN,
                ..with_color(zero, reflectance)
            }
        }
        Material::Conductor { metal, roughness } => {
            with_roughness(with_metal(kernels::Material { kind: CONDUCTOR, ..zero }, metal), roughness)
        }
        Material::Dielectric { eta, transmittance, roughness } => {
            let smooth = kernels::Material {
                kind: DIELECTRIC,
                color: transmittance.as_vec3().to_array(),
                eta: [*eta as f32; 3],
                ..zero
            };
            with_roughness(smooth, roughness)
        }
        Material::ThinDielectric { eta } => kernels::Material { kind: THIN_DIELECTRIC, eta: [*eta as f32; 3], ..zero },
        Material::CoatedDiffuse { reflectance, coat } => {
            let base = kernels::Material { kind: COATED_DIFFUSE, flags: HAS_LAMBERTIAN, ..zero };
            with_coat(with_color(base, reflectance), coat, sent_back_diffusely(coat))
        }
        Material::CoatedConductor { metal, roughness, coat } => {
            let base = with_metal(kernels::Material { kind: COATED_CONDUCTOR, ..zero }, metal);
            let base = with_roughness(base, roughness);
            with_coat(base, coat, sent_back_by_facets(coat, f64::from(base.alpha_u.max(base.alpha_v))))
        }
        Material::Mix { materials, amount } => {
            let (amount, amount_texture) = number(amount);
            let [first, second_part] = materials.map(|index| index as u32);
            kernels::Material { kind: MIX, amount: amount as f32, amount_texture, first, second_part, ..zero }
        }
    }
}

fn color(input: &Input<Rgb>) -> ([f32; 3], u32) {
    match input {
        Input::Constant(rgb) => (rgb.as_vec3().to_array(), NONE),
        Input::Texture(index) => ([1.0; 3], *index as u32),
    }
}

/// The value of a texture is not known here: what stands for it is not 0, which would be smooth.
fn number(input: &Input<f64>) -> (f64, u32) {
    match input {
        Input::Constant(value) => (*value, NONE),
        Input::Texture(index) => (0.5, *index as u32),
    }
}

fn scaled(color: [f32; 3], scale: f64) -> [f32; 3] {
    color.map(|channel| (f64::from(channel) * scale).clamp(0.0, 1.0) as f32)
}

fn with_color(material: kernels::Material, input: &Input<Rgb>) -> kernels::Material {
    let (color, color_texture) = color(input);
    kernels::Material { color, color_texture, ..material }
}

fn with_metal(material: kernels::Material, metal: &Metal) -> kernels::Material {
    match metal {
        Metal::Index { eta, k } => {
            kernels::Material { eta: eta.as_vec3().to_array(), k: k.as_vec3().to_array(), ..material }
        }
        Metal::Reflectance(input) => {
            let material = with_color(material, input);
            kernels::Material { flags: material.flags | BY_REFLECTANCE, ..material }
        }
    }
}

/// GGX's alpha along both directions, and the textures that give it.
fn alphas(roughness: &Roughness) -> ([f32; 2], [u32; 2]) {
    let along = |input| {
        let (value, texture) = number(input);
        (if roughness.remap { value.sqrt() } else { value }, texture)
    };
    let [(u, u_texture), (v, v_texture)] = [&roughness.u, &roughness.v].map(along);
    let is_smooth = u.max(v) < LEAST_ALPHA;
    let alpha = |alpha: f64| if is_smooth { 0.0 } else { alpha.clamp(LEAST_ALPHA, MOST_ALPHA) as f32 };
    ([alpha(u), alpha(v)], [u_texture, v_texture])
}

fn with_roughness(material: kernels::Material, roughness: &Roughness) -> kernels::Material {
    let ([alpha_u, alpha_v], [alpha_u_texture, alpha_v_texture]) = alphas(roughness);
    let flags = material.flags | if roughness.remap { REMAPPED } else { 0 };
    kernels::Material { alpha_u, alpha_v, alpha_u_texture, alpha_v_texture, flags, ..material }
}

fn with_coat(material: kernels::Material, coat: &Coat, sent_back: f64) -> kernels::Material {
    let ([coat_alpha_u, coat_alpha_v], [coat_u_texture, coat_v_texture]) = alphas(&coat.roughness);
    kernels::Material {
        coat_eta: coat.eta as f32,
        coat_thickness: coat.thickness as f32,
        coat_alpha_u,
        coat_alpha_v,
        coat_u_texture,
        coat_v_texture,
        coat_sent_back: sent_back as f32,
        flags: material.flags | if coat.roughness.remap { REMAPPED_COAT } else { 0 },
        ..material
    }
}

/// Reflectance of a boundary between dielectrics for unpolarised light; eta: the far side over
/// the near side.
fn fresnel(cos_i: f64, eta: f64) -> f64 {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

const STEPS: u32 = 512;

/// The mean of `value` over quantiles.
fn mean_over(value: impl Fn(f64) -> f64) -> f64 {
    (0..STEPS).map(|i| value((f64::from(i) + 0.5) / f64::from(STEPS))).sum::<f64>() / f64::from(STEPS)
}

/// What part of the light that a Lambertian surface sends up through a coat comes back to it.
fn sent_back_diffusely(coat: &Coat) -> f64 {
    mean_over(|quantile| {
        let cos = quantile.sqrt();
        fresnel(cos, 1.0 / coat.eta) * (-2.0 * coat.thickness / cos).exp()
    })
}

/// The same for facets that are lit straight from above (Walter and others 2007, eq. 35).
fn sent_back_by_facets(coat: &Coat, alpha: f64) -> f64 {
    mean_over(|quantile| {
        let cos2 = (1.0 - quantile) / (1.0 - quantile + alpha * alpha * quantile);
        let cos = 2.0 * cos2 - 1.0; // of twice the facet's angle
        if cos <= 0.0 {
            return 0.0;
        }
        fresnel(cos, 1.0 / coat.eta) * (-coat.thickness * (1.0 + 1.0 / cos)).exp()
    })
}

/// What kernels need to know of a scene's materials.
pub(super) fn specialize(materials: &[kernels::Material]) -> Specialization {
    let has = |kind| materials.iter().any(|material| material.kind == kind);
    let has_coats = has(COATED_DIFFUSE) || has(COATED_CONDUCTOR);
    let has_conductors = has(CONDUCTOR) || has(COATED_CONDUCTOR);
    let has_dielectrics = has(DIELECTRIC);
    let has_thin = has(THIN_DIELECTRIC);
    let is_rough = |m: &kernels::Material| m.alpha_u > 0.0 || m.coat_alpha_u > 0.0;
    let is_anisotropic = |m: &kernels::Material| {
        [(m.alpha_u, m.alpha_v), (m.coat_alpha_u, m.coat_alpha_v)].iter().any(|(u, v)| u != v)
            || m.alpha_u_texture != m.alpha_v_texture
            || m.coat_u_texture != m.coat_v_texture
    };
    Specialization {
        has_conductors,
        has_dielectrics,
        has_coats,
        has_thin,
        has_diffuse_transmission: has(DIFFUSE_TRANSMISSION),
        has_mixes: has(MIX),
        has_layers: has_coats || has(DIFFUSE_TRANSMISSION) || has(MIX),
        has_specular: has_conductors || has_dielectrics || has_coats || has_thin,
        has_rough: materials.iter().any(is_rough),
        has_anisotropic: materials.iter().any(is_anisotropic),
        ..Specialization::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coat(eta: f64, thickness: f64) -> Coat {
        Coat { eta, thickness, roughness: Roughness::SMOOTH }
    }

    /// What a Lambertian hemisphere loses at an index: the mean over the outside of 1 - F is
    /// eta² times the mean over the inside, since both are the same beams.
    #[test]
    fn a_coat_sends_back_what_reciprocity_says() {
        for eta in [1.0, 1.33, 1.5, 2.5] {
            let outside = mean_over(|quantile| fresnel(quantile.sqrt(), eta));
            let inside = sent_back_diffusely(&coat(eta, 0.0));
            assert!(((1.0 - inside) * eta * eta - (1.0 - outside)).abs() < 0.01, "{eta}: {inside} {outside}");
        }
    }

    #[test]
    fn smooth_facets_send_back_the_reflectance_straight_up() {
        assert!((sent_back_by_facets(&coat(1.5, 0.0), 0.0) - 0.04).abs() < 1e-12);
        let dim = sent_back_by_facets(&coat(1.5, 0.5), 0.0);
        assert!((dim - 0.04 * (-1.0_f64).exp()).abs() < 1e-12);
    }

    #[test]
    fn small_roughness_is_none_and_perceptual_values_are_squares() {
        let roughness = |value, remap| Roughness { u: Input::Constant(value), v: Input::Constant(value), remap };
        assert_eq!(alphas(&roughness(9e-4, false)).0, [0.0; 2]);
        assert_eq!(alphas(&roughness(0.25, true)).0, [0.5; 2]);
        assert_eq!(alphas(&roughness(0.25, false)).0, [0.25; 2]);
    }
}
