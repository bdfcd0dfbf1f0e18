//! What a kernel's SPIR-V says of its bindings, structs and constants.
//!
//! Whatever naga or a `#[repr(C)]` twin cannot express is an error with a remedy.

use crate::Result;
use crate::source::Source;
use crate::texels;
use naga::{AddressSpace, ArraySize, GlobalVariable, Handle, Module, Scalar, ScalarKind, Type, TypeInner};

/// A kernel as Rust needs to know it.
pub struct Reflected {
    pub name: String,
    pub workgroup_size: [u32; 3],
    pub bindings: Vec<Binding>,
    /// The block of push constants.
    pub push: Option<Twin>,
    pub structs: Vec<Twin>,
}

/// An array of elements, or one.
#[derive(Clone, PartialEq)]
pub struct Binding {
    pub set: u32,
    pub binding: u32,
    pub name: String,
    pub element: String,
    pub resource: Resource,
}

/// What the elements are in.
#[derive(Clone, Copy, PartialEq)]
pub enum Resource {
    /// `Element name[]` or one `Element`.
    Buffer,
    /// `TEXELS`, `STORED_TEXELS` or `UPDATED_TEXELS`.
    Texels,
}

/// A `#[repr(C)]` struct of 4-byte scalars.
#[derive(Clone, Debug, PartialEq)]
pub struct Twin {
    pub name: String,
    pub fields: Vec<(String, String)>,
    pub bytes: u32,
}

/// Reflects one kernel.
pub fn reflect(name: &str, spirv: &[u8], source: &Source) -> Result<Reflected> {
    let module = naga::front::spv::parse_u8_slice(spirv, &naga::front::spv::Options::default())
        .map_err(|error| format!("naga cannot read the SPIR-V: {error}; the limits of naga's front end apply: no buffer references, no umulExtended, no combined samplers, no arrays sized by specialization constants, no operations on specialization constants alone"))?;
    let entry = module.entry_points.first().ok_or("there is no main()")?;
    let mut kernel = Reflected {
        name: name.to_owned(),
        workgroup_size: entry.workgroup_size,
        bindings: Vec::new(),
        push: None,
        structs: Vec::new(),
    };
    for (_, variable) in module.global_variables.iter() {
        match variable.space {
            AddressSpace::Storage { .. } => {
                let place = variable.binding.as_ref().ok_or("a buffer has no layout(set, binding)")?;
                let name = variable.name.clone().filter(|name| !name.is_empty()).ok_or_else(|| {
                    format!(
                        "the buffer at set {}, binding {} needs an instance name: buffer Block {{ T data[]; }} name;",
                        place.group, place.binding
                    )
                })?;
                let element = element(&module, variable.ty, &name, &mut kernel.structs)?;
                let resource = Resource::Buffer;
                kernel.bindings.push(Binding { set: place.group, binding: place.binding, name, element, resource });
            }
            AddressSpace::Handle => kernel.bindings.push(texel_array(&module, variable, source, &mut kernel.structs)?),
            AddressSpace::Immediate => {
                let mut push = gpu_struct(&module, variable.ty, &mut kernel.structs)?;
                push.name = format!("{}Push", crate::generate::camel_case(name));
                kernel.push = Some(push);
            }
            AddressSpace::Uniform => {
                return Err("use storage buffers or texels: uniform buffers are not generated".into());
            }
            _ => {}
        }
    }
    kernel.bindings.sort_by_key(|binding| (binding.set, binding.binding));
    Ok(kernel)
}

/// An image that TEXELS or its like declared.
fn texel_array(
    module: &Module,
    variable: &GlobalVariable,
    source: &Source,
    structs: &mut Vec<Twin>,
) -> Result<Binding> {
    let name = variable.name.clone().unwrap_or_default();
    let array = source
        .find_array(&name)
        .ok_or_else(|| format!("{name}: declare images by TEXELS, STORED_TEXELS or UPDATED_TEXELS"))?;
    let place = variable.binding.as_ref().ok_or("texels have no place")?;
    if !matches!(module.types[variable.ty].inner, TypeInner::Image { .. }) {
        return Err(format!("{name} is not an image").into());
    }
    let resource = Resource::Texels;
    let element = match texels::plain_twin(&array.element) {
        Some(twin) => twin.to_owned(),
        None => {
            let twin = texels::twin(&array.element, source)?;
            if !structs.contains(&twin) {
                structs.push(twin);
            }
            array.element.clone()
        }
    };
    Ok(Binding { set: place.group, binding: place.binding, name, element, resource })
}

/// The element type of a block `{ T data[]; }` or `{ T value; }`.
fn element(module: &Module, ty: Handle<Type>, name: &str, structs: &mut Vec<Twin>) -> Result<String> {
    let TypeInner::Struct { members, .. } = &module.types[ty].inner else {
        return Err(format!("buffer {name} is not a block").into());
    };
    let [member] = members.as_slice() else {
        return Err(format!("buffer {name} has {} members; write one: T data[]; or T value;", members.len()).into());
    };
    match module.types[member.ty].inner {
        TypeInner::Array { base, size: ArraySize::Dynamic, stride } => {
            let (rust, size) = rust_type(module, base, structs)?;
            if size != stride {
                return Err(format!(
                    "buffer {name}: an element has {size} bytes but a stride of {stride}; pad it explicitly"
                )
                .into());
            }
            Ok(rust)
        }
        _ => Ok(rust_type(module, member.ty, structs)?.0),
    }
}

/// The Rust twin of a type and its size in bytes, noting the structs it needs.
fn rust_type(module: &Module, ty: Handle<Type>, structs: &mut Vec<Twin>) -> Result<(String, u32)> {
    match module.types[ty].inner {
        TypeInner::Scalar(kind) | TypeInner::Atomic(kind) => Ok((scalar(kind)?.to_owned(), 4)),
        TypeInner::Vector { size, scalar: kind } => {
            let length = size as u32;
            Ok((format!("[{}; {length}]", scalar(kind)?), 4 * length))
        }
        TypeInner::Array { base, size: ArraySize::Constant(length), stride } => {
            let (rust, size) = rust_type(module, base, structs)?;
            if size != stride {
                return Err(format!(
                    "an array of {rust} has a stride of {stride}, not {size}; use elements of 4, 8 or 16 bytes"
                )
                .into());
            }
            Ok((format!("[{rust}; {length}]"), size * length.get()))
        }
        TypeInner::Struct { span, .. } => {
            let twin = gpu_struct(module, ty, structs)?;
            let name = twin.name.clone();
            if !structs.contains(&twin) {
                structs.push(twin);
            }
            Ok((name, span))
        }
        ref other => Err(format!("{other:?} has no Rust twin").into()),
    }
}

/// A struct whose std430 layout equals `#[repr(C)]`, or an error that says where to pad.
fn gpu_struct(module: &Module, ty: Handle<Type>, structs: &mut Vec<Twin>) -> Result<Twin> {
    let TypeInner::Struct { members, span } = &module.types[ty].inner else {
        return Err("a push constant is not a block".into());
    };
    let name = module.types[ty].name.clone().ok_or("a struct has no name")?;
    let mut fields = Vec::new();
    let mut offset = 0;
    for member in members {
        let field = member.name.clone().ok_or_else(|| format!("struct {name}: a field has no name"))?;
        if member.offset != offset {
            return Err(format!("struct {name}: {field} is at byte {} but the fields before it end at {offset}; pad explicitly (4-byte scalars, vec4, or vec3 followed by a scalar)", member.offset).into());
        }
        let (rust, size) = rust_type(module, member.ty, structs)?;
        offset += size;
        fields.push((field, rust));
    }
    if *span != offset {
        return Err(
            format!("struct {name}: {} bytes of padding at its end; write them as fields", span - offset).into()
        );
    }
    Ok(Twin { name, fields, bytes: offset })
}

fn scalar(scalar: Scalar) -> Result<&'static str> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => Ok("f32"),
        (ScalarKind::Uint, 4) => Ok("u32"),
        (ScalarKind::Sint, 4) => Ok("i32"),
        (kind, width) => Err(format!("{kind:?} of {width} bytes cannot cross to the GPU; use 4-byte scalars").into()),
    }
}
