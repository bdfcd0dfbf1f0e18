//! The specialization constants: a struct for each group of features.

use std::fmt::Write;

use super::write_doc;
use crate::Result;
use crate::source::{Feature, Features};

/// Writes a struct for each group, and one of all groups. None of them has a default: whoever
/// decides a group says all of it.
pub fn write(out: &mut String, groups: &[Features]) -> Result<()> {
    for group in groups {
        write_group(out, group)?;
    }
    writeln!(out, "/// What kernels are specialised to: every specialization constant.")?;
    writeln!(out, "#[derive(Clone, Copy, Debug, PartialEq)]\npub struct Specialization {{")?;
    for group in groups {
        write_doc(out, 1, &group.doc)?;
        writeln!(out, "    pub {}: {},", field(group), group.name)?;
    }
    writeln!(out, "}}\n\nimpl Specialization {{")?;
    writeln!(out, "    /// The values that the GLSL declares: kernels that can do all that a scene may ask for.")?;
    writeln!(out, "    pub const DECLARED: Self = Self {{")?;
    for group in groups {
        writeln!(out, "        {}: {} {{", field(group), group.name)?;
        for constant in &group.constants {
            let value = constant.default.trim_end_matches('u');
            writeln!(out, "            {}: {value},", constant.name.to_lowercase())?;
        }
        writeln!(out, "        }},")?;
    }
    writeln!(out, "    }};\n\n    /// Names and values of all constants.")?;
    writeln!(out, "    pub fn values(&self) -> Vec<(&'static str, Constant)> {{\n        vec![")?;
    for (group, constant) in all(groups) {
        let (field, name) = (field(group), constant.name.to_lowercase());
        writeln!(out, "            (\"{name}\", Constant::from(self.{field}.{name})),")?;
    }
    writeln!(out, "        ]\n    }}\n}}\n")?;
    writeln!(out, "impl goblet_host::SpecializationValues for Specialization {{")?;
    writeln!(out, "    fn value(&self, id: u32) -> Option<[u8; 4]> {{\n        match id {{")?;
    for (group, constant) in all(groups) {
        writeln!(out, "            {} => Some({}.to_ne_bytes()),", constant.id, value(group, constant))?;
    }
    writeln!(out, "            _ => None,\n        }}\n    }}\n}}\n")?;
    Ok(())
}

fn write_group(out: &mut String, group: &Features) -> Result<()> {
    write_doc(out, 0, &group.doc)?;
    writeln!(out, "#[derive(Clone, Copy, Debug, PartialEq)]\npub struct {} {{", group.name)?;
    for constant in &group.constants {
        let kind = match constant.kind.as_str() {
            "bool" => "bool",
            "uint" => "u32",
            "float" => "f32",
            other => return Err(format!("{}: {other} is no bool, uint or float", constant.name).into()),
        };
        write_doc(out, 1, &constant.doc)?;
        writeln!(out, "    pub {}: {kind},", constant.name.to_lowercase())?;
    }
    writeln!(out, "}}\n")?;
    Ok(())
}

fn all(groups: &[Features]) -> impl Iterator<Item = (&Features, &Feature)> {
    groups.iter().flat_map(|group| group.constants.iter().map(move |constant| (group, constant)))
}

/// `SceneFeatures` to `scene`.
fn field(group: &Features) -> String {
    group.name.trim_end_matches("Features").to_lowercase()
}

/// The value of a constant, as a number of four bytes.
fn value(group: &Features, constant: &Feature) -> String {
    let path = format!("self.{}.{}", field(group), constant.name.to_lowercase());
    if constant.kind == "bool" { format!("u32::from({path})") } else { path }
}
