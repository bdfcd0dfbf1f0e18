//! Arrays of structs in images. lavapipe loads texels eight at a time, and from storage buffers
//! word by word, lane by lane: several times slower. Graphics cards do not mind. So
//!
//! ```glsl
//! TEXELS(0, 3, Triangle, triangles)            // to read: Triangle triangles_at(uint i)
//! STORED_TEXELS(1, 2, Triangle, new_triangles) // to write: void store_new_triangles(uint i, Triangle value)
//! UPDATED_TEXELS(1, 3, uvec4, sums)            // both
//! ```
//!
//! become an image and functions, by the struct's fields in types.glsl.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;

use crate::reflect::Struct;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Components of a texel.
const WORDS: u32 = 4;

/// Of texel `t`.
const PLACE: &str = "ivec2(t % TEXELS_PER_ROW, t / TEXELS_PER_ROW)";

/// What a kernel does with texels: their macro, whether it loads and stores, and the qualifier.
struct Access {
    prefix: &'static str,
    loads: bool,
    stores: bool,
    qualifier: &'static str,
}

const ACCESSES: [Access; 3] = [
    Access { prefix: "TEXELS(", loads: true, stores: false, qualifier: "readonly " },
    Access { prefix: "STORED_TEXELS(", loads: false, stores: true, qualifier: "writeonly " },
    Access { prefix: "UPDATED_TEXELS(", loads: true, stores: true, qualifier: "" },
];

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
            Some((access, [set, binding, element, name])) => {
                elements.insert(name.to_owned(), element.to_owned());
                out +=
                    &declare(access, set, binding, element, name, types).map_err(|error| format!("{line}: {error}"))?;
            }
        }
        out.push('\n');
    }
    Ok(out)
}

/// If a line declares texels, their access and its arguments.
fn parse(line: &str) -> Result<Option<(&'static Access, [&str; 4])>> {
    let Some(access) = ACCESSES.iter().find(|access| line.starts_with(access.prefix)) else {
        return Ok(None);
    };
    let rest = &line[access.prefix.len()..];
    let arguments: Vec<&str> = rest.split(')').next().unwrap_or("").split(',').map(str::trim).collect();
    let arguments = arguments.try_into().map_err(|_| format!("{line}: expected (set, binding, type, name)"))?;
    Ok(Some((access, arguments)))
}

fn declare(access: &Access, set: &str, binding: &str, element: &str, name: &str, types: &str) -> Result<String> {
    let format = if scalar_twin(element).is_some() { "r32ui" } else { "rgba32ui" };
    let qualifier = access.qualifier;
    let mut out = format!("layout({format}, set = {set}, binding = {binding}) uniform {qualifier}uimage2D {name};");
    if access.loads {
        out += &load(element, name, types)?;
    }
    if access.stores {
        out += &store(element, name, types)?;
    }
    Ok(out)
}

/// The function that loads an element.
fn load(element: &str, name: &str, types: &str) -> Result<String> {
    let (texels, value) = match plain_twin(element) {
        Some(_) if scalar_twin(element).is_some() => (1, from_bits(element, "t0.x")),
        Some(_) => (1, from_bits(element, "t0")),
        None => {
            let fields = fields(element, types)?;
            (size(&fields)? / WORDS, unpack(element, &fields)?)
        }
    };
    let mut out = format!(" {element} {name}_at(uint i) {{ uint t = {texels}u * i;");
    for texel in 0..texels {
        write!(out, " uvec4 t{texel} = imageLoad({name}, {PLACE}); t++;")?;
    }
    write!(out, " return {value}; }}")?;
    Ok(out)
}

/// The function that stores an element.
fn store(element: &str, name: &str, types: &str) -> Result<String> {
    let values = match plain_twin(element) {
        Some(_) => vec![format!("uvec4({})", to_bits(element, "value"))],
        None => pack(&fields(element, types)?)?,
    };
    let texels = values.len();
    let mut out = format!(" void store_{name}(uint i, {element} value) {{ uint t = {texels}u * i;");
    for value in values {
        write!(out, " imageStore({name}, {PLACE}, {value}); t++;")?;
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
