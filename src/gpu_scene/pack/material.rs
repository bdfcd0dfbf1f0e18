//! Packing of materials.

mod boundary;
mod coat;
mod dispersion;
mod measured;
mod scattering;
mod slab;

use coat::Base;
use dispersion::with_dispersion;

use super::PackError;
use super::texture::PackedTextures;
use crate::kernels::{
    self, BY_REFLECTANCE, COATED_CONDUCTOR, COATED_DIFFUSE, CONDUCTOR, DIELECTRIC, DIFFUSE, DIFFUSE_TRANSMISSION,
    DISPERSIVE, DISPLACED, HAS_FACETS, HAS_LAMBERTIAN, INTERFACE, MEASURED, MIX, MaterialFeatures, NONE, NORMAL_MAPPED,
    REMAPPED, REMAPPED_COAT, SCATTERING_COAT, THIN_DIELECTRIC,
};
use crate::scene::{Bump, Coat, Input, Material, Metal, Rgb, Roughness, Scattering};

/// Maximum alpha: rougher surfaces look the same.
const MOST_ALPHA: f64 = 100.0;
/// Maximum optical constant: metals with larger ones have the same reflectance, and their fourth powers
/// would overflow fp32.
const MOST_INDEX: f64 = 1e9;

/// Packs all materials of a scene, and the textures that they use.
pub(super) fn pack_materials(
    materials: &[Material],
    textures: &mut PackedTextures,
) -> Result<Vec<kernels::Material>, PackError> {
    let pack = |material| pack_material(material, textures);
    let mut packed = materials.iter().map(pack).collect::<Result<Vec<_>, _>>()?;
    for (i, material) in materials.iter().enumerate() {
        // The materials of a mix come before it.
        if let Material::Mix { materials: [first, second], .. } = material {
            packed[i].flags = (packed[*first].flags | packed[*second].flags) & HAS_LAMBERTIAN;
        }
    }
    Ok(packed)
}

fn pack_material(material: &Material, textures: &mut PackedTextures) -> Result<kernels::Material, PackError> {
    let zero = kernels::Material {
        kind: DIFFUSE,
        color_texture: NONE,
        second_texture: NONE,
        alpha_u_texture: NONE,
        alpha_v_texture: NONE,
        amount_texture: NONE,
        coat_u_texture: NONE,
        coat_v_texture: NONE,
        alpha_texture: NONE,
        ..bytemuck::Zeroable::zeroed()
    };
    Ok(match material {
        Material::Diffuse { reflectance } => {
            with_color(kernels::Material { flags: HAS_LAMBERTIAN, ..zero }, reflectance, textures)?
        }
        Material::Interface => kernels::Material { kind: INTERFACE, ..zero },
        Material::DiffuseTransmission { reflectance, transmittance, scale } => {
            let sheet = kernels::Material { kind: DIFFUSE_TRANSMISSION, flags: HAS_LAMBERTIAN, ..zero };
            let sheet = with_color(sheet, reflectance, textures)?;
            let (second_texture, second) = textures.color(transmittance)?;
            kernels::Material {
                color: scaled(sheet.color, *scale),
                second: scaled(second, *scale),
                second_texture,
                amount: *scale as f32,
                ..sheet
            }
        }
        Material::Conductor { metal, roughness } => {
            let smooth = with_metal(kernels::Material { kind: CONDUCTOR, ..zero }, metal, textures)?;
            with_roughness(smooth, roughness, textures)?
        }
        Material::Dielectric { eta, transmittance, roughness } => {
            let color = transmittance.as_vec3().to_array();
            let clear = kernels::Material { kind: DIELECTRIC, color, eta: [eta.mean as f32; 3], ..zero };
            with_roughness(with_dispersion(clear, eta, textures), roughness, textures)?
        }
        Material::ThinDielectric { eta } => {
            let pane = kernels::Material { kind: THIN_DIELECTRIC, eta: [eta.mean as f32; 3], ..zero };
            with_dispersion(pane, eta, textures)
        }
        Material::CoatedDiffuse { reflectance, coat } => {
            let base = kernels::Material { kind: COATED_DIFFUSE, flags: HAS_LAMBERTIAN, ..zero };
            let base = with_color(base, reflectance, textures)?;
            with_coat(base, coat, Base::Lambertian, textures)?
        }
        Material::CoatedConductor { metal, roughness, coat } => {
            let base = with_metal(kernels::Material { kind: COATED_CONDUCTOR, ..zero }, metal, textures)?;
            let base = with_roughness(base, roughness, textures)?;
            let alpha = base.alpha_u.max(base.alpha_v);
            with_coat(base, coat, Base::Facets { alpha: alpha.into() }, textures)?
        }
        Material::Measured(measured) => kernels::Material {
            kind: MEASURED,
            alpha_u: SOME_ALPHA as f32,
            alpha_v: SOME_ALPHA as f32,
            first: textures.measured(measured, measured::table),
            second_part: u32::from(!measured.is_isotropic()),
            ..zero
        },
        Material::Mix { materials, amount } => {
            let (amount_texture, amount) = textures.number(amount)?;
            let [first, second_part] = materials.map(|index| index as u32);
            let amount = amount.unwrap_or_default() as f32;
            kernels::Material { kind: MIX, amount, amount_texture, first, second_part, ..zero }
        }
        Material::Bumped { material, bump } => with_bump(pack_material(material, textures)?, *bump, textures)?,
    })
}

fn scaled(color: [f32; 3], scale: f64) -> [f32; 3] {
    color.map(|channel| (f64::from(channel) * scale).clamp(0.0, 1.0) as f32)
}

fn with_color(
    material: kernels::Material,
    input: &Input<Rgb>,
    textures: &mut PackedTextures,
) -> Result<kernels::Material, PackError> {
    let (color_texture, color) = textures.color(input)?;
    Ok(kernels::Material { color, color_texture, ..material })
}

fn with_metal(
    material: kernels::Material,
    metal: &Metal,
    textures: &mut PackedTextures,
) -> Result<kernels::Material, PackError> {
    Ok(match metal {
        Metal::Index { eta, k } => {
            let [eta, k] = [eta, k].map(|index| index.min(Rgb::splat(MOST_INDEX)).as_vec3().to_array());
            kernels::Material { eta, k, ..material }
        }
        Metal::Reflectance(input) => {
            let material = with_color(material, input, textures)?;
            kernels::Material { flags: material.flags | BY_REFLECTANCE, ..material }
        }
    })
}

/// Placeholder for a roughness that is not a constant: not 0, which would be smooth.
const SOME_ALPHA: f64 = 0.5;

/// Returns GGX's alpha along both directions, and the textures that give it.
fn roughness_of(roughness: &Roughness, textures: &mut PackedTextures) -> Result<([f32; 2], [u32; 2]), PackError> {
    let (u_texture, u) = textures.number(&roughness.u)?;
    let (v_texture, v) = textures.number(&roughness.v)?;
    let alpha = |value: Option<f64>| {
        let alpha = value.map_or(SOME_ALPHA, |value| roughness.alpha(value));
        if roughness.is_smooth() { 0.0 } else { alpha.clamp(Roughness::LEAST_ALPHA, MOST_ALPHA) as f32 }
    };
    Ok(([alpha(u), alpha(v)], [u_texture, v_texture]))
}

fn with_roughness(
    material: kernels::Material,
    roughness: &Roughness,
    textures: &mut PackedTextures,
) -> Result<kernels::Material, PackError> {
    let ([alpha_u, alpha_v], [alpha_u_texture, alpha_v_texture]) = roughness_of(roughness, textures)?;
    let flags = material.flags | if roughness.remap { REMAPPED } else { 0 };
    Ok(kernels::Material { alpha_u, alpha_v, alpha_u_texture, alpha_v_texture, flags, ..material })
}

fn with_coat(
    material: kernels::Material,
    coat: &Coat,
    base: Base,
    textures: &mut PackedTextures,
) -> Result<kernels::Material, PackError> {
    let ([coat_alpha_u, coat_alpha_v], [coat_u_texture, coat_v_texture]) = roughness_of(&coat.roughness, textures)?;
    let flags = material.flags | if coat.roughness.remap { REMAPPED_COAT } else { 0 };
    let eta = coat.eta.mean;
    let coat_eta = eta as f32;
    let material =
        kernels::Material { coat_eta, coat_alpha_u, coat_alpha_v, coat_u_texture, coat_v_texture, flags, ..material };
    let material = with_dispersion(material, &coat.eta, textures);
    if let Some(scattering) = &coat.scattering {
        return with_scattering(material, coat, scattering, textures);
    }
    Ok(match textures.number(&coat.thickness)? {
        (amount_texture, None) => {
            let second_part = textures.table(base.key(eta), || base.table(eta).collect());
            kernels::Material { amount_texture, amount: coat.absorbed as f32, second_part, ..material }
        }
        (_, Some(thickness)) => {
            let thickness = thickness * coat.absorbed;
            let sent_back = base.sent_back(eta, thickness) as f32;
            kernels::Material { coat_thickness: thickness as f32, coat_sent_back: sent_back, ..material }
        }
    })
}

fn with_bump(
    material: kernels::Material,
    bump: Bump,
    textures: &mut PackedTextures,
) -> Result<kernels::Material, PackError> {
    let (flag, texture) = match bump {
        Bump::Displacement(texture) => (DISPLACED, texture),
        Bump::NormalMap(texture) => (NORMAL_MAPPED, texture),
    };
    let (bump_texture, _) = textures.color(&Input::Texture(texture))?;
    let bump_scale = textures.render_units() as f32;
    Ok(kernels::Material { flags: material.flags | flag, bump_texture, bump_scale, ..material })
}

/// Returns true if a material colors light by wavelength: glass or a pane. A coat alone does not, since paths take no
/// wavelength there.
pub(super) fn has_dispersion(materials: &[kernels::Material]) -> bool {
    let is_glass = |material: &kernels::Material| matches!(material.kind, DIELECTRIC | THIN_DIELECTRIC);
    materials.iter().any(|material| material.flags & DISPERSIVE != 0 && is_glass(material))
}

/// Returns true if a texture bends the normals of a material.
pub(super) fn has_bumps(materials: &[kernels::Material]) -> bool {
    materials.iter().any(|material| material.flags & (DISPLACED | NORMAL_MAPPED) != 0)
}

fn with_scattering(
    material: kernels::Material,
    coat: &Coat,
    scattering: &Scattering,
    textures: &mut PackedTextures,
) -> Result<kernels::Material, PackError> {
    let (amount_texture, thickness) = textures.number(&coat.thickness)?;
    let (second_texture, second) = textures.color(&scattering.albedo)?;
    let (first, g) = textures.number(&scattering.g)?;
    // Tables know one alpha: textured boundaries pass light as smooth ones do.
    let is_textured = material.coat_u_texture != NONE || material.coat_v_texture != NONE;
    let alpha = if is_textured { 0.0 } else { f64::from(material.coat_alpha_u * material.coat_alpha_v).sqrt() };
    let key = scattering::key(coat, alpha, scattering);
    Ok(kernels::Material {
        amount_texture,
        coat_thickness: thickness.unwrap_or_default() as f32,
        second_texture,
        second,
        first,
        amount: g.unwrap_or_default() as f32,
        second_part: textures.table(key, || scattering::table(coat, alpha, scattering)),
        flags: material.flags | SCATTERING_COAT,
        ..material
    })
}

/// Marks the materials with a rough lobe, and the mixes of them.
pub(super) fn mark_facets(materials: &mut [kernels::Material]) {
    for i in 0..materials.len() {
        let material = &materials[i];
        // The materials of a mix come before it.
        let parts = [material.first, material.second_part].map(|part| part as usize);
        let is_marked = |part: &usize| materials[*part].flags & HAS_FACETS != 0;
        let has_facets = if material.kind == MIX {
            parts.iter().any(is_marked)
        } else {
            material.alpha_u > 0.0 || material.coat_alpha_u > 0.0
        };
        materials[i].flags |= if has_facets { HAS_FACETS } else { 0 };
    }
}

/// Returns the features that a scene's materials require of kernels.
pub(super) fn specialize(materials: &[kernels::Material]) -> MaterialFeatures {
    let has = |kind| materials.iter().any(|material| material.kind == kind);
    let has_coats = has(COATED_DIFFUSE) || has(COATED_CONDUCTOR);
    let has_conductors = has(CONDUCTOR) || has(COATED_CONDUCTOR);
    let has_dielectrics = has(DIELECTRIC);
    let has_thin = has(THIN_DIELECTRIC);
    let is_textured_coat = |m: &kernels::Material| m.coat_eta > 0.0 && m.amount_texture != NONE;
    let is_scattering = |m: &kernels::Material| m.flags & SCATTERING_COAT != 0;
    let is_rough = |m: &kernels::Material| m.alpha_u > 0.0 || m.coat_alpha_u > 0.0;
    let is_anisotropic = |m: &kernels::Material| {
        [(m.alpha_u, m.alpha_v), (m.coat_alpha_u, m.coat_alpha_v)].iter().any(|(u, v)| u != v)
            || m.alpha_u_texture != m.alpha_v_texture
            || m.coat_u_texture != m.coat_v_texture
            || m.kind == MEASURED && m.second_part != 0
    };
    MaterialFeatures {
        has_conductors,
        has_dielectrics,
        has_coats,
        has_thin,
        has_diffuse_transmission: has(DIFFUSE_TRANSMISSION),
        has_mixes: has(MIX),
        has_measured: has(MEASURED),
        has_layers: has_coats || has(DIFFUSE_TRANSMISSION) || has(MIX),
        has_specular: has_conductors || has_dielectrics || has_coats || has_thin || has(MEASURED),
        has_textured_coats: materials.iter().any(is_textured_coat),
        has_scattering_coats: materials.iter().any(is_scattering),
        has_rough: materials.iter().any(is_rough),
        has_anisotropic: materials.iter().any(is_anisotropic),
        has_dispersion: has_dispersion(materials),
        has_bumps: has_bumps(materials),
        has_displacements: materials.iter().any(|material| material.flags & DISPLACED != 0),
        has_normal_maps: materials.iter().any(|material| material.flags & NORMAL_MAPPED != 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_roughness_is_none_and_perceptual_values_are_squares() {
        let alphas = |[u, v]: [Input<f64>; 2], remap| {
            roughness_of(&Roughness { u, v, remap }, &mut PackedTextures::default()).unwrap().0
        };
        let constant = |value| [Input::Constant(value); 2];
        assert_eq!(alphas(constant(9e-4), false), [0.0; 2]);
        assert_eq!(alphas(constant(0.25), true), [0.5; 2]);
        assert_eq!(alphas(constant(0.25), false), [0.25; 2]);
        assert_eq!(alphas([Input::Constant(0.25), Input::Constant(0.0)], false), [0.25, 1e-3]);
    }
}
