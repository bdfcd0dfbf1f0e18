//! Arrays of structs, of vectors or of words, that kernels load whole elements of. lavapipe loads from images
//! eight texels at a time, and from storage buffers word by word, lane by lane: several times slower. Graphics
//! cards load from both alike, and some bind few images. So
//!
//! ```glsl
//! TEXELS(Triangle, triangles)            // to read: Triangle triangles_at(uint i)
//! STORED_TEXELS(Triangle, new_triangles) // to write: void store_new_triangles(uint i, Triangle value)
//! UPDATED_TEXELS(uvec4, sums)            // both
//! ```
//!
//! become functions, by the fields of the struct, and an image or a buffer with the same words in the same
//! order. Arrays of a group are in one buffer, at whose start the host has written where each begins, in
//! texels.

use std::fmt::Write;

use crate::reflect::Twin;
use crate::source::{Array, Field, Member, Source};
use crate::{ArrayKind, Result};

/// Components of a texel.
const WORDS: u32 = 4;

/// Where the functions of an array find its texels.
struct Place {
    /// The variable that has them.
    variable: String,
    /// The texel where the array begins, as the start of a sum.
    first: String,
    is_image: bool,
    /// Whether a texel is one word.
    is_scalar: bool,
}

/// The image or buffer, and the functions, of an array that one of the macros declares.
pub fn declare(macro_name: &str, at: &str, array: &Array, source: &Source, arrays: ArrayKind) -> Result<String> {
    let (qualifier, loads, stores) = match macro_name {
        "TEXELS" => ("readonly ", true, false),
        "STORED_TEXELS" => ("writeonly ", false, true),
        _ => ("", true, true),
    };
    let Array { name, element, member, .. } = array;
    let is_scalar = scalar_twin(element).is_some();
    let (variable, first, is_image) = (name.clone(), String::new(), arrays == ArrayKind::Images);
    let mut place = Place { variable, first, is_image, is_scalar };
    if is_scalar && member.is_some() {
        return Err(format!("{name}: an array of a group has whole texels of four words").into());
    }
    let mut out = String::new();
    if is_image {
        let format = if is_scalar { "r32ui" } else { "rgba32ui" };
        write!(out, "layout({format}, {at}) uniform {qualifier}uimage2D {name};")?;
    } else {
        if let Some(Member { group, number, .. }) = member {
            let number = *number as u32;
            place.variable = format!("{group}_group");
            place.first = format!("{}.data[{}].{} + ", place.variable, number / WORDS, component(number));
        }
        if member.as_ref().is_none_or(|member| member.number == 0) {
            let (kind, name) = (if is_scalar { "uint" } else { "uvec4" }, &place.variable);
            write!(out, "layout(std430, {at}) restrict {qualifier}buffer {name}_block {{ {kind} data[]; }} {name};")?;
        }
    }
    if loads {
        out += &load(element, name, &place, source)?;
    }
    if stores {
        out += &store(element, name, &place, source)?;
    }
    Ok(out)
}

impl Place {
    /// A load of texel `t`.
    fn loaded(&self) -> String {
        let variable = &self.variable;
        match (self.is_image, self.is_scalar) {
            (true, _) => format!("imageLoad({variable}, ivec2(t % TEXELS_PER_ROW, t / TEXELS_PER_ROW))"),
            (false, false) => format!("{variable}.data[t]"),
            (false, true) => format!("uvec4({variable}.data[t])"),
        }
    }

    /// A store of a value to texel `t`.
    fn stored(&self, value: &str) -> String {
        let variable = &self.variable;
        match (self.is_image, self.is_scalar) {
            (true, _) => format!("imageStore({variable}, ivec2(t % TEXELS_PER_ROW, t / TEXELS_PER_ROW), {value})"),
            (false, false) => format!("{variable}.data[t] = {value}"),
            (false, true) => format!("{variable}.data[t] = {value}.x"),
        }
    }
}

/// The name of a component of a texel.
fn component(word: u32) -> &'static str {
    let first = (word % WORDS) as usize;
    &"xyzw"[first..=first]
}

/// The function that loads an element.
fn load(element: &str, name: &str, place: &Place, source: &Source) -> Result<String> {
    let (texels, value) = match plain_twin(element) {
        Some(_) if place.is_scalar => (1, from_bits(element, "t0.x")),
        Some(_) => (1, from_bits(element, "t0")),
        None => {
            let fields = fields(element, source)?;
            (size(fields)? / WORDS, unpack(element, fields)?)
        }
    };
    let mut out = format!(" {element} {name}_at(uint i) {{ uint t = {}{texels}u * i;", place.first);
    for texel in 0..texels {
        write!(out, " uvec4 t{texel} = {}; t++;", place.loaded())?;
    }
    write!(out, " return {value}; }}")?;
    Ok(out)
}

/// The function that stores an element.
fn store(element: &str, name: &str, place: &Place, source: &Source) -> Result<String> {
    let values = match plain_twin(element) {
        Some(_) => vec![format!("uvec4({})", to_bits(element, "value"))],
        None => pack(fields(element, source)?)?,
    };
    let texels = values.len();
    let mut out = format!(" void store_{name}(uint i, {element} value) {{ uint t = {}{texels}u * i;", place.first);
    for value in values {
        write!(out, " {}; t++;", place.stored(&value))?;
    }
    write!(out, " }}")?;
    Ok(out)
}

fn scalar_twin(element: &str) -> Option<&'static str> {
    match element {
        "uint" => Some("u32"),
        "float" => Some("f32"),
        _ => None,
    }
}

/// The Rust twin of an element that is no struct.
pub fn plain_twin(element: &str) -> Option<&'static str> {
    scalar_twin(element).or(match element {
        "uvec4" => Some("[u32; 4]"),
        "vec4" => Some("[f32; 4]"),
        _ => None,
    })
}

/// The Rust twin of a struct.
pub fn twin(element: &str, source: &Source) -> Result<Twin> {
    let fields = fields(element, source)?;
    let bytes = 4 * size(fields)?;
    let mut twins = Vec::new();
    for field in fields {
        let scalar = if field.kind.starts_with('u') { "u32" } else { "f32" };
        let count = words(&field.kind)?;
        let one = if count == 1 { scalar.to_owned() } else { format!("[{scalar}; {count}]") };
        let length = length(field)?;
        twins.push((field.name.clone(), length.map_or(one.clone(), |length| format!("[{one}; {length}]"))));
    }
    Ok(Twin { name: element.to_owned(), fields: twins, bytes })
}

fn fields<'a>(element: &str, source: &'a Source) -> Result<&'a [Field]> {
    let declared = source.find_struct(element);
    Ok(&declared.ok_or_else(|| format!("{element} is no struct that has been declared before"))?.fields)
}

fn length(field: &Field) -> Result<Option<u32>> {
    Ok(field.length.as_ref().map(|length| length.parse()).transpose()?)
}

fn words(kind: &str) -> Result<u32> {
    match kind {
        "float" | "uint" => Ok(1),
        "vec2" | "uvec2" => Ok(2),
        "vec3" | "uvec3" => Ok(3),
        "vec4" | "uvec4" => Ok(4),
        _ => Err(format!("{kind} cannot be in texels").into()),
    }
}

fn size(fields: &[Field]) -> Result<u32> {
    let mut total = 0;
    for field in fields {
        total += words(&field.kind)? * length(field)?.unwrap_or(1);
    }
    if total % WORDS == 0 { Ok(total) } else { Err("pad it to whole texels of four words".into()) }
}

/// An expression of the words from `word` on; none may cross from one texel to the next.
fn part(word: u32, count: u32) -> Result<String> {
    let first = word % WORDS;
    if first + count > WORDS {
        return Err("a field crosses from one texel to the next; order or pad the fields".into());
    }
    let swizzle = &"xyzw"[first as usize..(first + count) as usize];
    Ok(format!("t{}.{swizzle}", word / WORDS))
}

fn from_bits(kind: &str, value: &str) -> String {
    if kind.starts_with('u') { value.to_owned() } else { format!("uintBitsToFloat({value})") }
}

fn to_bits(kind: &str, value: &str) -> String {
    if kind.starts_with('u') { value.to_owned() } else { format!("floatBitsToUint({value})") }
}

/// A constructor of the struct from texels t0, t1, ..
fn unpack(element: &str, fields: &[Field]) -> Result<String> {
    let mut word = 0;
    let mut arguments = Vec::new();
    for field in fields {
        let count = words(&field.kind)?;
        let mut parts = Vec::new();
        for _ in 0..length(field)?.unwrap_or(1) {
            parts.push(from_bits(&field.kind, &part(word, count)?));
            word += count;
        }
        arguments.push(match length(field)? {
            None => parts.remove(0),
            Some(length) => format!("{}[{length}]({})", field.kind, parts.join(", ")),
        });
    }
    Ok(format!("{element}({})", arguments.join(", ")))
}

/// The texels of `value`.
fn pack(fields: &[Field]) -> Result<Vec<String>> {
    let mut texels = Vec::new();
    let mut parts = Vec::new();
    let mut filled = 0;
    for field in fields {
        for i in 0..length(field)?.unwrap_or(1) {
            let index = if field.length.is_some() { format!("[{i}]") } else { String::new() };
            part(filled, words(&field.kind)?)?;
            parts.push(to_bits(&field.kind, &format!("value.{}{index}", field.name)));
            filled += words(&field.kind)?;
            if filled == WORDS {
                texels.push(format!("uvec4({})", parts.join(", ")));
                parts.clear();
                filled = 0;
            }
        }
    }
    Ok(texels)
}
