//! The scene's arrays: on the host, on the device, and as kernels bind them.

use std::fmt::Write;

use super::{array_type, write_doc, write_field};
use crate::Result;
use crate::reflect::{Binding, Resource};
use crate::source::{self, Part};

/// An array of the scene.
pub struct Array {
    pub binding: Binding,
    pub declared: source::Array,
}

/// Parts of a scene whose arrays are digested, and what they are called.
const PARTS: [(Part, &str); 4] =
    [(Part::Shapes, "shapes"), (Part::Materials, "materials"), (Part::Media, "media"), (Part::Lights, "lights")];

/// Writes the structs of the scene's arrays. Arrays that are no part of the scene are given when it
/// is uploaded, as one value.
pub fn write(out: &mut String, arrays: &[Array]) -> Result<()> {
    let packed: Vec<&Array> = arrays.iter().filter(|array| array.declared.part.is_some()).collect();
    writeln!(out, "/// The arrays of a scene, as scene.glsl declares them.")?;
    writeln!(out, "#[derive(Clone, Debug, Default)]\npub struct SceneArrays {{")?;
    for Array { binding, declared } in &packed {
        write_doc(out, 1, &declared.doc)?;
        writeln!(out, "    pub {}: Vec<{}>,", binding.name, binding.element)?;
    }
    writeln!(out, "}}\n\nimpl SceneArrays {{")?;
    write_bytes(out, &packed)?;
    for (part, name) in PARTS {
        write_part(out, &packed, part, name)?;
    }
    write_upload(out, arrays)?;
    writeln!(out, "}}\n")?;
    write_device(out, arrays)?;
    writeln!(out, "/// The scene's arrays as kernels bind them: set 0.")?;
    writeln!(out, "#[derive(Clone, Copy)]\npub struct SceneBindings<'a> {{")?;
    for Array { binding, declared } in arrays {
        write_field(out, binding, &declared.doc)?;
    }
    writeln!(out, "}}\n")?;
    Ok(())
}

fn write_bytes(out: &mut String, packed: &[&Array]) -> Result<()> {
    writeln!(out, "    /// Bytes of all arrays.\n    pub fn bytes(&self) -> u64 {{\n        [")?;
    for array in packed {
        writeln!(out, "            size_of_val(&self.{}[..]),", array.binding.name)?;
    }
    writeln!(out, "        ].iter().map(|bytes| *bytes as u64).sum()\n    }}\n")?;
    Ok(())
}

fn write_part(out: &mut String, packed: &[&Array], part: Part, name: &str) -> Result<()> {
    writeln!(out, "    /// Bytes of the arrays that tell the {name}, in the order of their declarations.")?;
    writeln!(out, "    pub fn {name}(&self) -> Vec<&[u8]> {{\n        vec![")?;
    for array in packed.iter().filter(|array| array.declared.part == Some(part)) {
        writeln!(out, "            bytemuck::cast_slice(&self.{}),", array.binding.name)?;
    }
    writeln!(out, "        ]\n    }}\n")?;
    Ok(())
}

fn write_upload(out: &mut String, arrays: &[Array]) -> Result<()> {
    let given = || arrays.iter().filter(|array| array.declared.part.is_none());
    let grouped = || arrays.iter().filter(|array| array.binding.resource == Resource::Texels);
    let data = |Array { binding: Binding { name, .. }, declared }: &Array| match declared.part {
        None => format!("std::slice::from_ref({name})"),
        Some(_) => format!("&self.{name}"),
    };
    writeln!(out, "    /// Copies the arrays to a device.\n    ///\n    /// # Errors")?;
    writeln!(out, "    /// Out of device memory, or an array is larger than the device can bind.")?;
    let values: String =
        given().map(|Array { binding, .. }| format!(", {}: &{}", binding.name, binding.element)).collect();
    writeln!(
        out,
        "    pub fn upload(&self, device: &goblet_host::Device{values}) -> goblet_host::Result<GpuScene> {{"
    )?;
    writeln!(out, "        let mut group = device.group(\"scene\", &[")?;
    for array in grouped() {
        let Binding { name, element, .. } = &array.binding;
        let length = array.declared.part.map_or("1".to_owned(), |_| format!("self.{name}.len() as u64"));
        writeln!(out, "            goblet_host::Extent::of::<{element}>(\"{name}\", {length}),")?;
    }
    writeln!(out, "        ])?;\n        let scene = GpuScene {{")?;
    for array in arrays {
        let name = &array.binding.name;
        let made = match array.binding.resource {
            Resource::Texels => "group.take()".to_owned(),
            Resource::Buffer => format!("device.upload(\"{name}\", {})?", data(array)),
        };
        writeln!(out, "            {name}: {made},")?;
    }
    writeln!(out, "        }};")?;
    for array in grouped() {
        writeln!(out, "        device.write_texels(&scene.{}, {})?;", array.binding.name, data(array))?;
    }
    writeln!(out, "        Ok(scene)\n    }}")?;
    Ok(())
}

fn write_device(out: &mut String, arrays: &[Array]) -> Result<()> {
    writeln!(out, "/// The arrays of a scene in device memory.\npub struct GpuScene {{")?;
    for array in arrays {
        writeln!(out, "    {}: {},", array.binding.name, array_type(&array.binding))?;
    }
    writeln!(out, "}}\n\nimpl GpuScene {{\n    /// The arrays as kernels bind them.")?;
    writeln!(out, "    pub fn bindings(&self) -> SceneBindings<'_> {{\n        SceneBindings {{")?;
    for array in arrays {
        writeln!(out, "            {0}: &self.{0},", array.binding.name)?;
    }
    writeln!(out, "        }}\n    }}\n}}\n")?;
    Ok(())
}
