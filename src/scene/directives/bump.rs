//! Parameters of materials that bend shading normals: `displacement` and `normalmap`.

use crate::scene::directives::texture::Textures;
use crate::scene::format::error::SceneError;
use crate::scene::format::kind::Kind;
use crate::scene::format::params::ParamList;
use crate::scene::format::registry::{ParamSpec, full};
use crate::scene::model::{Bump, Input, Material};

/// Height of the surface above its shape, in scene units.
pub(in crate::scene) const DISPLACEMENT: ParamSpec = full("displacement", &[Kind::Float, Kind::Texture]);
/// Image of the normals, relative to the surface.
pub(in crate::scene) const NORMAL_MAP: ParamSpec = full("normalmap", &[Kind::String]);

/// Returns a material with the bumps that its parameters give it. As in pbrt, a normal map takes precedence over
/// a displacement. A displacement that is the same everywhere bends nothing.
pub(in crate::scene) fn bumped(
    material: Material,
    params: &ParamList,
    textures: &mut Textures,
) -> Result<Material, SceneError> {
    let displacement = params.get("displacement").map(|param| textures.number(param)).transpose()?;
    let name = params.string("normalmap")?.filter(|name| !name.is_empty());
    let bump = match (params.get("normalmap"), name, displacement) {
        (Some(param), Some(name), _) => Bump::NormalMap(textures.normal_map(name, param)?),
        (_, _, Some(Input::Texture(texture))) => Bump::Displacement(texture),
        _ => return Ok(material),
    };
    Ok(Material::Bumped { material: Box::new(material), bump })
}
