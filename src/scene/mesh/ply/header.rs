//! The stream of a PLY file, and its header.

use std::io::{self, BufRead};

use crate::scene::format::lexer::shorten;
use crate::scene::mesh::ply::error::PlyError;

/// A stream of bytes with its offset.
pub(in crate::scene) struct Source<'a> {
    pub stream: &'a mut dyn BufRead,
    pub at: u64,
    /// Upper bound of the stream's length, in bytes.
    pub length: u64,
}

impl Source<'_> {
    pub fn invalid(&self, what: impl std::fmt::Display) -> PlyError {
        PlyError::Invalid(format!("byte {}: {what}", self.at))
    }

    pub fn failed(&self, error: &io::Error, during: &str) -> PlyError {
        if error.kind() == io::ErrorKind::UnexpectedEof {
            return self.invalid(format!("the file ends within {during}"));
        }
        self.invalid(format!("{error} within {during}"))
    }

    pub fn exact<const N: usize>(&mut self, during: &str) -> Result<[u8; N], PlyError> {
        let mut bytes = [0; N];
        match self.stream.read_exact(&mut bytes) {
            Ok(()) => self.at += N as u64,
            Err(error) => return Err(self.failed(&error, during)),
        }
        Ok(bytes)
    }

    /// Returns the next byte without consuming it; `None` at the end.
    pub fn peek(&mut self, during: &str) -> Result<Option<u8>, PlyError> {
        match self.stream.fill_buf() {
            Ok(buffer) => Ok(buffer.first().copied()),
            Err(error) => Err(self.failed(&error, during)),
        }
    }

    pub fn byte(&mut self, during: &str) -> Result<Option<u8>, PlyError> {
        let next = self.peek(during)?;
        if next.is_some() {
            self.stream.consume(1);
            self.at += 1;
        }
        Ok(next)
    }

    /// Reads bytes up to one that `ends` accepts, which is consumed, and returns them without it. Fails
    /// after 4096 bytes.
    pub fn run(&mut self, mut ends: impl FnMut(u8) -> bool, during: &str) -> Result<String, PlyError> {
        const LONGEST: usize = 4096;
        let mut run = Vec::new();
        while let Some(byte) = self.byte(during)? {
            if ends(byte) {
                return Ok(String::from_utf8_lossy(&run).into_owned());
            }
            run.push(byte);
            if run.len() > LONGEST {
                return Err(self.invalid(format!("{LONGEST} bytes without an end in {during}")));
            }
        }
        if run.is_empty() {
            return Err(self.invalid(format!("the file ends within {during}")));
        }
        Ok(String::from_utf8_lossy(&run).into_owned())
    }

    /// Reads a word of an ASCII body.
    pub fn word(&mut self, during: &str) -> Result<String, PlyError> {
        self.skip_blank(during)?;
        self.run(|byte| byte.is_ascii_whitespace(), during)
    }

    /// Skips blanks, a buffer at a time: there may be any number of them.
    fn skip_blank(&mut self, during: &str) -> Result<(), PlyError> {
        loop {
            let buffer = match self.stream.fill_buf() {
                Ok(buffer) => buffer,
                Err(error) => return Err(self.failed(&error, during)),
            };
            let blank = buffer.iter().position(|byte| !byte.is_ascii_whitespace());
            let count = blank.unwrap_or(buffer.len());
            let ends = blank.is_some() || buffer.is_empty();
            self.stream.consume(count);
            self.at += count as u64;
            if ends {
                return Ok(());
            }
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    pub fn from_word(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }

    pub fn size(self) -> u64 {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::F64 => 8,
        }
    }
}

#[derive(Debug)]
pub(in crate::scene) struct Property {
    pub name: String,
    /// Type of the list's length, if the property is a list.
    pub list: Option<Scalar>,
    pub scalar: Scalar,
}

#[derive(Debug)]
pub(in crate::scene) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    pub fn scalar_index(&self, name: &str) -> Option<usize> {
        let mut properties = self.properties.iter();
        properties.position(|p| p.name == name && p.list.is_none())
    }

    /// Returns the minimum number of bytes of one entry.
    pub fn least_size(&self, format: Format) -> u64 {
        let size = |p: &Property| p.list.unwrap_or(p.scalar).size();
        match format {
            // Each property takes a digit and a separator.
            Format::Ascii => 2 * self.properties.len() as u64,
            _ => self.properties.iter().map(size).sum(),
        }
    }
}

#[derive(Debug)]
pub(in crate::scene) struct Header {
    pub format: Format,
    pub elements: Vec<Element>,
}

/// Maximum number of elements of a header; it may have 64 times as many lines.
const MAX_PROPERTIES: usize = 1024;

impl Header {
    pub fn read(source: &mut Source) -> Result<Self, PlyError> {
        let (magic, line_end) = first_line(source)?;
        if magic.trim() != "ply" {
            return Err(source.invalid("expected a PLY file, which starts with the line `ply`"));
        }
        let mut format = None;
        let mut elements = Vec::new();
        let mut entries = 0;
        loop {
            let line = source.run(|byte| byte == line_end, HEADER)?;
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words.as_slice() {
                ["end_header"] => break,
                ["comment" | "obj_info", ..] | [] => {}
                ["format", kind, _version] => format = Some(parse_format(kind, source)?),
                ["element", name, count] => elements.push(parse_element(name, count, source)?),
                ["property", rest @ ..] => {
                    let element: Option<&mut Element> = elements.last_mut();
                    match (element, parse_property(rest)) {
                        (Some(element), Some(property)) => element.properties.push(property),
                        _ => return Err(bad_line(source, &line)),
                    }
                }
                _ => return Err(bad_line(source, &line)),
            }
            entries += 1;
            if elements.len() > MAX_PROPERTIES || entries > 64 * MAX_PROPERTIES {
                return Err(source.invalid("the header does not end; expected `end_header`"));
            }
        }
        let format = format.ok_or_else(|| source.invalid("the header has no `format` line; expected one"))?;
        Ok(Header { format, elements })
    }

    pub fn element(&self, name: &str, source: &Source) -> Result<&Element, PlyError> {
        let mut named = self.elements.iter().filter(|e| e.name == name);
        match (named.next(), named.next()) {
            (Some(element), None) if element.count > 0 => Ok(element),
            (Some(_), Some(_)) => Err(source.invalid(format!("two elements `{name}`"))),
            _ => Err(source.invalid(format!("the mesh has no `{name}`; expected at least one"))),
        }
    }
}

const HEADER: &str = "the header";

/// Returns the first line, and the byte that ends all lines of the header: LF, perhaps after CR, or CR
/// alone, as on old Macs.
fn first_line(source: &mut Source) -> Result<(String, u8), PlyError> {
    let mut end = b'\n';
    let is_end = |byte| {
        end = byte;
        matches!(byte, b'\n' | b'\r')
    };
    let line = source.run(is_end, HEADER)?;
    if end == b'\r' && source.peek(HEADER)? == Some(b'\n') {
        source.byte(HEADER)?;
        end = b'\n';
    }
    Ok((line, end))
}

fn bad_line(source: &Source, line: &str) -> PlyError {
    source.invalid(format!("cannot read the header line `{}`", shorten(line.trim())))
}

fn parse_format(kind: &str, source: &Source) -> Result<Format, PlyError> {
    match kind {
        "ascii" => Ok(Format::Ascii),
        "binary_little_endian" => Ok(Format::LittleEndian),
        "binary_big_endian" => Ok(Format::BigEndian),
        _ => Err(source.invalid(format!(
            "unknown format `{}`; expected ascii, binary_little_endian or binary_big_endian",
            shorten(kind)
        ))),
    }
}

fn parse_element(name: &str, count: &str, source: &Source) -> Result<Element, PlyError> {
    let count = count.parse().map_err(|_| {
        source.invalid(format!(
            "element {} has the count `{}`; expected a whole number, 0 or more",
            shorten(name),
            shorten(count)
        ))
    })?;
    Ok(Element { name: name.to_string(), count, properties: Vec::new() })
}

fn parse_property(words: &[&str]) -> Option<Property> {
    let (list, scalar, name) = match words {
        ["list", length, scalar, name] => (Some(Scalar::from_word(length)?), scalar, name),
        [scalar, name] => (None, scalar, name),
        _ => return None,
    };
    if matches!(list, Some(Scalar::F32 | Scalar::F64)) {
        return None;
    }
    Some(Property { name: name.to_string(), list, scalar: Scalar::from_word(scalar)? })
}
