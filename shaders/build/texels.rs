//! Arrays of structs in images. lavapipe loads texels eight at a time, and from storage buffers
//! word by word, lane by lane: several times slower. Graphics cards do not mind. So
//!
//! ```glsl
//! TEXELS(0, 3, Triangle, triangles)            // to read: Triangle triangles_at(uint i)
//! STORED_TEXELS(1, 2, Triangle, new_triangles) // to write: void store_new_triangles(uint i, Triangle value)
//! ```
//!
//! become an image and a function, by the struct's fields in types.glsl.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;

use crate::reflect::Struct;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Components of a texel.
const WORDS: u32 = 4;

/// A field of a struct.
struct Field {
    name: String,
    kind: String,
    /// Elements, if it is an array.
    length: Option<u32>,
}

/// Replaces declarations of texels, line by line; notes the element type of each name.
pub fn expand(text: &str, types: &str, elements: &mut BTreeMap<String, String>) -> Result<String> {
    let mut out = String::new();
    for line in text.lines() {
        match parse(line)? {
            None => out += line,
            Some((stored, [set, binding, element, name])) => {
                elements.insert(name.to_owned(), element.to_owned());
                out +=
                    &declare(stored, set, binding, element, name, types).map_err(|error| format!("{line}: {error}"))?;
            }
        }
        out.push('\n');
    }
    Ok(out)
}

/// Whether a line declares texels, whether to be written, and its arguments.
fn parse(line: &str) -> Result<Option<(bool, [&str; 4])>> {
    let stored = line.strip_prefix("STORED_TEXELS(");
    let Some(rest) = stored.or_else(|| line.strip_prefix("TEXELS(")) else {
        return Ok(None);
    };
    let arguments: Vec<&str> = rest.split(')').next().unwrap_or("").split(',').map(str::trim).collect();
    let arguments = arguments.try_into().map_err(|_| format!("{line}: expected (set, binding, type, name)"))?;
    Ok(Some((stored.is_some(), arguments)))
}

fn declare(stored: bool, set: &str, binding: &str, element: &str, name: &str, types: &str) -> Result<String> {
    let place = "ivec2(t % TEXELS_PER_ROW, t / TEXELS_PER_ROW)";
    let scalar = element == "uint" || element == "float";
    let fields = if scalar { Vec::new() } else { fields(element, types)? };
    let texels = if scalar { 1 } else { size(&fields)? / WORDS };
    let format = if scalar { "r32ui" } else { "rgba32ui" };
    let mut out = String::new();
    if stored {
        write!(out, "layout({format}, set = {set}, binding = {binding}) uniform writeonly uimage2D {name};")?;
        write!(out, " void store_{name}(uint i, {element} value) {{ uint t = {texels}u * i;")?;
        let values = if scalar { vec![format!("uvec4({})", to_bits(element, "value"))] } else { pack(&fields)? };
        for value in values {
            write!(out, " imageStore({name}, {place}, {value}); t++;")?;
        }
        write!(out, " }}")?;
    } else {
        write!(out, "layout({format}, set = {set}, binding = {binding}) uniform readonly uimage2D {name};")?;
        write!(out, " {element} {name}_at(uint i) {{ uint t = {texels}u * i;")?;
        for texel in 0..texels {
            write!(out, " uvec4 t{texel} = imageLoad({name}, {place}); t++;")?;
        }
        let value = if scalar { from_bits(element, "t0.x") } else { unpack(element, &fields)? };
        write!(out, " return {value}; }}")?;
    }
    Ok(out)
}

/// The Rust twin of a struct in types.glsl.
pub fn twin(element: &str, types: &str) -> Result<Struct> {
    let fields = fields(element, types)?;
    let bytes = 4 * size(&fields)?;
    let mut twins = Vec::new();
    for field in fields {
        let scalar = if field.kind.starts_with('u') { "u32" } else { "f32" };
        let count = words(&field.kind)?;
        let one = if count == 1 { scalar.to_owned() } else { format!("[{scalar}; {count}]") };
        twins.push((field.name, field.length.map_or(one.clone(), |length| format!("[{one}; {length}]"))));
    }
    Ok(Struct { name: element.to_owned(), fields: twins, bytes })
}

/// The fields of a struct in types.glsl.
fn fields(element: &str, types: &str) -> Result<Vec<Field>> {
    let body = types.split_once(&format!("struct {element} {{")).and_then(|(_, rest)| rest.split_once("};"));
    let body = body.ok_or_else(|| format!("types.glsl has no struct {element}"))?.0;
    let mut fields = Vec::new();
    for line in body.lines().map(|line| line.split("//").next().unwrap_or("").trim()).filter(|line| !line.is_empty()) {
        let declaration = line.strip_suffix(';').ok_or_else(|| format!("{element}: write one field a line"))?;
        let (kind, name) = declaration.split_once(' ').ok_or_else(|| format!("{element}: {line}"))?;
        let (name, length) = match name.split_once('[') {
            None => (name, None),
            Some((name, length)) => (name, Some(length.trim_end_matches(']').parse()?)),
        };
        fields.push(Field { name: name.to_owned(), kind: kind.to_owned(), length });
    }
    Ok(fields)
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
        total += words(&field.kind)? * field.length.unwrap_or(1);
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
        for _ in 0..field.length.unwrap_or(1) {
            parts.push(from_bits(&field.kind, &part(word, count)?));
            word += count;
        }
        arguments.push(match field.length {
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
        for i in 0..field.length.unwrap_or(1) {
            let index = field.length.map_or(String::new(), |_| format!("[{i}]"));
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
