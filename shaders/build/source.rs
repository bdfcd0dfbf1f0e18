//! A kernel's text with its includes, and what it declares that crosses to the GPU.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::{ArrayKind, Result, texels};

/// A kernel, ready for the compiler.
#[derive(Default)]
pub struct Source {
    /// Plain GLSL.
    pub text: String,
    /// Names of the files that it is made of, by the numbers that `#line` gives them.
    pub files: Vec<String>,
    /// The comment that the kernel's file begins with.
    pub doc: String,
    /// Arrays, in order.
    pub arrays: Vec<Array>,
    /// Structs, and the block of push constants under the name `Push`.
    pub structs: Vec<Struct>,
    /// Numbers that Rust knows too.
    pub constants: Vec<Constant>,
    /// Groups of specialization constants.
    pub features: Vec<Features>,
}

/// An array, or one value.
#[derive(Clone, PartialEq)]
pub struct Array {
    pub name: String,
    /// As GLSL names its type.
    pub element: String,
    pub doc: String,
    pub part: Option<Part>,
    pub member: Option<Member>,
}

/// An array's place in a group.
#[derive(Clone, PartialEq)]
pub struct Member {
    pub group: String,
    /// The binding of the group's buffer, which is that of its first array.
    pub binding: usize,
    /// Its number in the group.
    pub number: usize,
}

/// What an array of the scene tells of, for the identity of a render.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
pub enum Part {
    Shapes,
    Materials,
    Media,
    Lights,
    /// It follows from the others.
    Derived,
}

/// A struct as it is written.
#[derive(Clone)]
pub struct Struct {
    pub name: String,
    pub doc: String,
    pub fields: Vec<Field>,
    /// Whether the kernel's own file has it, and no include.
    pub is_own: bool,
}

/// A field of a struct.
#[derive(Clone)]
pub struct Field {
    pub name: String,
    pub kind: String,
    /// Elements, if it is an array: a number or a constant's name.
    pub length: Option<String>,
    pub doc: String,
}

/// `export const uint NAME = 1u;`
#[derive(Clone, PartialEq)]
pub struct Constant {
    pub name: String,
    pub value: String,
    pub doc: String,
    pub is_own: bool,
}

/// Specialization constants that are decided in one place.
#[derive(Clone, PartialEq)]
pub struct Features {
    pub name: String,
    pub doc: String,
    pub constants: Vec<Feature>,
}

/// A specialization constant.
#[derive(Clone, PartialEq)]
pub struct Feature {
    pub id: usize,
    pub name: String,
    /// `bool`, `uint` or `float`.
    pub kind: String,
    /// What it is where nobody says otherwise.
    pub default: String,
    pub doc: String,
}

impl Source {
    /// A struct by its name.
    pub fn find_struct(&self, name: &str) -> Option<&Struct> {
        self.structs.iter().find(|declared| declared.name == name)
    }

    /// An array by its name.
    pub fn find_array(&self, name: &str) -> Option<&Array> {
        self.arrays.iter().find(|array| array.name == name)
    }
}

/// Reads a kernel, shown to people by a name. Errors name file and line.
pub fn read(root: &Path, path: &Path, shown: &str, arrays: ArrayKind) -> Result<Source> {
    let mut reader = Reader { includes: root.join("shaders/include"), arrays, ..Reader::default() };
    reader.read_file(path, shown)?;
    let Reader { mut source, extensions, body, .. } = reader;
    source.text = format!("#version 460\n{extensions}{body}");
    Ok(source)
}

/// The file with the scene's arrays: they are in set 0, all others in set 1.
const SCENE: &str = "scene/scene.glsl";

/// The group of the scene's texels.
const SCENE_GROUP: &str = "scene";

#[derive(Default)]
struct Reader {
    includes: PathBuf,
    /// Files that are in the text.
    read: BTreeSet<PathBuf>,
    source: Source,
    /// `#extension` lines: they come first.
    extensions: String,
    body: String,
    /// How many bindings of each set, and how many specialization constants there are.
    bindings: [usize; 2],
    constants: usize,
    arrays: ArrayKind,
    /// The binding of each group, and how many arrays it has so far.
    groups: BTreeMap<String, (usize, usize)>,
}

/// A block that goes over several lines.
enum Block {
    None,
    Struct(Struct),
    Features(Features),
}

impl Reader {
    fn read_file(&mut self, path: &Path, shown: &str) -> Result<()> {
        if !self.read.insert(path.to_owned()) {
            return Ok(());
        }
        let text = fs::read_to_string(path).map_err(|error| format!("{shown}: {error}"))?;
        let file = self.source.files.len();
        self.source.files.push(shown.to_owned());
        if file == 0 {
            self.source.doc = text.lines().map_while(|line| line.strip_prefix("//")).map(str::trim).fold(
                String::new(),
                |doc, line| if doc.is_empty() { line.to_owned() } else { format!("{doc}\n{line}") },
            );
        }
        self.body += &format!("#line 1 {file}\n");
        let (mut doc, mut block) = (String::new(), Block::None);
        for (i, line) in text.lines().enumerate() {
            let at = |error| format!("{shown}:{}: {error}", i + 1);
            if let Some(name) = line.strip_prefix("#include \"").and_then(|rest| rest.strip_suffix('"')) {
                let path = self.includes.join(name);
                self.read_file(&path, &format!("shaders/include/{name}"))?;
                self.body += &format!("#line {} {file}\n", i + 2);
                continue;
            }
            let is_scene = path == self.includes.join(SCENE);
            block = self.read_line(line, block, &doc, is_scene, file == 0).map_err(at)?;
            match line.trim().strip_prefix("//") {
                Some(comment) => doc = join(&doc, comment.trim()),
                None => doc.clear(),
            }
        }
        Ok(())
    }

    /// Adds a line to the text, expanded where it is one of the build's own.
    fn read_line(&mut self, line: &str, block: Block, doc: &str, is_scene: bool, is_own: bool) -> Result<Block> {
        let code = line.split("//").next().unwrap_or("").trim_end();
        let doc = join(doc, line.split_once("//").map_or("", |(_, comment)| comment.trim()));
        let mut next = Block::None;
        let out = match block {
            _ if code.starts_with("#version") => String::new(),
            _ if code.starts_with("#extension") => {
                if !self.extensions.contains(code) {
                    self.extensions += &format!("{code}\n");
                }
                String::new()
            }
            Block::Struct(mut declared) => {
                if code.starts_with('}') {
                    self.source.structs.push(declared);
                } else {
                    declared.fields.extend(field(code, &doc)?);
                    next = Block::Struct(declared);
                }
                line.to_owned()
            }
            Block::Features(mut features) => {
                if code.starts_with('}') {
                    self.source.features.push(features);
                    String::new()
                } else {
                    let expanded = self.feature(code, doc, &mut features)?;
                    next = Block::Features(features);
                    expanded
                }
            }
            Block::None => {
                next = opening(code, &doc, is_own);
                if matches!(next, Block::Features(_)) {
                    String::new()
                } else {
                    self.declaration(line, code, doc, is_scene, is_own)?
                }
            }
        };
        self.body += &out;
        self.body.push('\n');
        Ok(next)
    }

    fn feature(&mut self, code: &str, doc: String, features: &mut Features) -> Result<String> {
        if code.is_empty() {
            return Ok(String::new());
        }
        let parsed = code.trim().strip_suffix(';').and_then(|code| code.split_once(" = "));
        let parsed = parsed.and_then(|(left, default)| Some((left.split_once(' ')?, default)));
        let ((kind, name), default) = parsed.ok_or("expected `bool NAME = true; // doc`")?;
        let (id, name, kind, default) = (self.constants, name.to_owned(), kind.to_owned(), default.to_owned());
        self.constants += 1;
        let expanded = format!("layout(constant_id = {id}) const {kind} {name} = {default};");
        features.constants.push(Feature { id, name, kind, default, doc });
        Ok(expanded)
    }

    /// A line outside of blocks.
    fn declaration(&mut self, line: &str, code: &str, doc: String, is_scene: bool, is_own: bool) -> Result<String> {
        if let Some(constant) = code.strip_prefix("export ") {
            let value = constant.strip_prefix("const uint ").and_then(|rest| rest.strip_suffix("u;"));
            let (name, value) =
                value.and_then(|rest| rest.split_once(" = ")).ok_or("write `export const uint NAME = 1u;`")?;
            let (name, value) = (name.to_owned(), value.to_owned());
            self.source.constants.push(Constant { name, value, doc, is_own });
            return Ok(constant.to_owned());
        }
        let Some((macro_name, arguments)) = call(code) else {
            return Ok(line.to_owned());
        };
        let (macro_name, part, group, arguments) = match (macro_name.split_once('_'), arguments.as_slice()) {
            (Some(("SCENE", name)), [part, arguments @ ..]) => (name, Some(part_of(part)?), None, arguments),
            (Some(("GROUPED", name)), [group, arguments @ ..]) => (name, None, Some(*group), arguments),
            _ => (macro_name, None, None, arguments.as_slice()),
        };
        let [element, name] = arguments else {
            return Err(format!("expected {macro_name}(type, name)").into());
        };
        let set = usize::from(!is_scene);
        let place = format!("set = {set}, binding = {}", self.bindings[set]);
        let has_texels = macro_name.ends_with("TEXELS");
        let group = if is_scene { Some(SCENE_GROUP) } else { group };
        let member = group.filter(|_| has_texels).map(|group| self.join(group, self.bindings[set]));
        self.bindings[set] += 1;
        let array = Array { name: (*name).to_owned(), element: (*element).to_owned(), doc, part, member };
        self.source.arrays.push(array.clone());
        match macro_name {
            "BUFFER" => Ok(buffer(&place, "readonly ", element, "data[]", name)),
            "UPDATED_BUFFER" => Ok(buffer(&place, "", element, "data[]", name)),
            "VALUE" => Ok(buffer(&place, "readonly ", element, "value", name)),
            "UPDATED_VALUE" => Ok(buffer(&place, "", element, "value", name)),
            _ => texels::declare(macro_name, &place, &array, &self.source, self.arrays),
        }
    }

    /// Gives an array at a binding a place in a group.
    fn join(&mut self, group: &str, binding: usize) -> Member {
        let (binding, length) = self.groups.entry(group.to_owned()).or_insert((binding, 0));
        *length += 1;
        Member { group: group.to_owned(), binding: *binding, number: *length - 1 }
    }
}

/// The macros that declare arrays, without SCENE_ or GROUPED_.
const MACROS: [&str; 7] =
    ["BUFFER", "UPDATED_BUFFER", "VALUE", "UPDATED_VALUE", "TEXELS", "STORED_TEXELS", "UPDATED_TEXELS"];

/// A line that declares an array: the macro and its arguments.
fn call(code: &str) -> Option<(&str, Vec<&str>)> {
    let (name, arguments) = code.strip_suffix(')')?.split_once('(')?;
    let plain = name.strip_prefix("SCENE_").or_else(|| name.strip_prefix("GROUPED_").filter(|n| n.ends_with("TEXELS")));
    MACROS.contains(&plain.unwrap_or(name)).then(|| (name, arguments.split(", ").collect()))
}

fn buffer(place: &str, access: &str, element: &str, member: &str, name: &str) -> String {
    format!("layout(std430, {place}) {access}buffer {name}_block {{ {element} {member}; }} {name};")
}

fn part_of(name: &str) -> Result<Part> {
    match name {
        "shapes" => Ok(Part::Shapes),
        "materials" => Ok(Part::Materials),
        "media" => Ok(Part::Media),
        "lights" => Ok(Part::Lights),
        "derived" => Ok(Part::Derived),
        _ => Err(format!("{name} is no part of a scene; expected shapes, materials, media, lights or derived").into()),
    }
}

/// What a line opens.
fn opening(code: &str, doc: &str, is_own: bool) -> Block {
    let (doc, named) = (doc.to_owned(), |name: &str| name.to_owned());
    if let Some(name) = code.strip_prefix("struct ").and_then(|rest| rest.strip_suffix(" {")) {
        return Block::Struct(Struct { name: named(name), doc, fields: Vec::new(), is_own });
    }
    if code.starts_with("layout(push_constant)") && code.ends_with('{') {
        return Block::Struct(Struct { name: named("Push"), doc, fields: Vec::new(), is_own });
    }
    match code.strip_prefix("FEATURES ").and_then(|rest| rest.strip_suffix(" {")) {
        Some(name) => Block::Features(Features { name: named(name), doc, constants: Vec::new() }),
        None => Block::None,
    }
}

/// A field of a struct, if a line has one.
fn field(code: &str, doc: &str) -> Result<Option<Field>> {
    let code = code.trim();
    if code.is_empty() || code.starts_with('#') {
        return Ok(None);
    }
    let declaration = code.strip_suffix(';').and_then(|code| code.split_once(' '));
    let (kind, name) = declaration.ok_or("write one field of a struct a line")?;
    let (name, length) = match name.split_once('[') {
        None => (name, None),
        Some((name, length)) => (name, Some(length.trim_end_matches(']').to_owned())),
    };
    Ok(Some(Field { name: name.to_owned(), kind: kind.to_owned(), length, doc: doc.to_owned() }))
}

fn join(a: &str, b: &str) -> String {
    if a.is_empty() || b.is_empty() { format!("{a}{b}") } else { format!("{a}\n{b}") }
}
