//! Default parameters, which `Attribute` sets.

use crate::scene::directives::light;
use crate::scene::directives::material;
use crate::scene::directives::medium;
use crate::scene::directives::shape;
use crate::scene::directives::state::SceneBuilder;
use crate::scene::directives::texture;
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::lexer::shorten;
use crate::scene::format::params::ParamList;
use crate::scene::format::registry::Family;

impl SceneBuilder {
    /// Executes `Attribute`: sets default parameters of later directives.
    pub fn attribute(&mut self, target: &str, params: ParamList, location: &Location) -> Result<(), SceneError> {
        let (defaults, families): (_, &[&Family]) = match target {
            "shape" => (&mut self.state.shape_defaults, &[&shape::FAMILY]),
            "light" => (&mut self.state.light_defaults, &[&light::FAMILY, &light::AREA_FAMILY]),
            "material" => (&mut self.state.material_defaults, &[&material::FAMILY]),
            "texture" => (&mut self.state.texture_defaults, &[&texture::FLOAT_FAMILY, &texture::SPECTRUM_FAMILY]),
            "medium" => (&mut self.state.medium_defaults, &[&medium::FAMILY]),
            _ => {
                return Err(location.invalid(format!(
                    "unknown Attribute \"{}\"; expected one of: \"shape\", \"light\", \
                     \"material\", \"medium\", \"texture\"",
                    shorten(target)
                )));
            }
        };
        // Parameters that no type has are dropped, which bounds the number kept.
        let mut known = params.items;
        known.retain(|param| families.iter().any(|family| family.knows(&param.name)));
        ParamList::set_all(defaults, known)
    }
}
