//! Attributes of EXR headers: what a file says of its image.

use std::collections::BTreeSet;

use exr::meta::attribute::{AttributeValue, Chromaticities};
use exr::prelude::{LayerAttributes, Text, Vec2};
use glam::DVec2;

use crate::base::color::{Primaries, REC709};

/// The value of an attribute. Its type in the file follows from its variant.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// A `string`, in UTF-8.
    Text(String),
    /// An `int` if it fits into 32 bits, else a `double`: the format has no larger integers.
    Integer(i64),
    /// A `double`.
    Number(f64),
    /// A `float`.
    Float(f32),
    /// An `m44f`, its rows one after another.
    Matrix([[f32; 4]; 4]),
}

impl Attribute {
    /// Returns the value that a text stands for: an integer, else a finite number, else the text itself.
    #[must_use]
    pub fn of_text(text: &str) -> Self {
        let number = || text.parse::<f64>().ok().filter(|number| number.is_finite()).map(Self::Number);
        text.parse().ok().map(Self::Integer).or_else(number).unwrap_or_else(|| Self::Text(text.to_owned()))
    }

    fn encode(&self) -> AttributeValue {
        match self {
            Self::Text(text) => AttributeValue::Text(utf8(text)),
            Self::Integer(number) => {
                i32::try_from(*number).map_or(AttributeValue::F64(*number as f64), AttributeValue::I32)
            }
            Self::Number(number) => AttributeValue::F64(*number),
            Self::Float(number) => AttributeValue::F32(*number),
            Self::Matrix(rows) => {
                let mut elements = [0.0; 16];
                elements.copy_from_slice(rows.as_flattened());
                AttributeValue::Matrix4x4(elements)
            }
        }
    }
}

/// The format allows UTF-8 in keys and values; the crate's checked constructor does not.
fn utf8(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// Adds metadata to the attributes of a header.
///
/// # Errors
/// A key is empty, too long, has a zero byte, or occurs twice.
pub(super) fn add(attributes: &mut LayerAttributes, metadata: &[(String, Attribute)]) -> Result<(), String> {
    let mut seen = BTreeSet::new();
    for (key, value) in metadata {
        if key.is_empty() || key.len() > 255 || key.contains('\0') {
            return Err(format!("the metadata key {key:?} must have 1 to 255 bytes, none of them zero"));
        }
        if !seen.insert(key) {
            return Err(format!("the metadata key {key:?} occurs twice"));
        }
        // Attributes that the standard names have fields of their own in the crate.
        match (key.as_str(), value.encode()) {
            ("worldToCamera", AttributeValue::Matrix4x4(matrix)) => attributes.world_to_camera = Some(matrix),
            ("worldToNDC", AttributeValue::Matrix4x4(matrix)) => attributes.world_to_normalized_device = Some(matrix),
            (_, value) => {
                attributes.other.insert(utf8(key), value);
            }
        }
    }
    Ok(())
}

/// Returns the chromaticities of the images that goblet writes.
pub(super) fn chromaticities() -> Chromaticities {
    let vector = |DVec2 { x, y }: DVec2| Vec2(x as f32, y as f32);
    let Primaries { red, green, blue, white } = REC709;
    Chromaticities { red: vector(red), green: vector(green), blue: vector(blue), white: vector(white) }
}

/// Sorts the attributes of a header by name. The format leaves their order free, and the `exr` crate
/// writes them in the order of a randomly seeded hash map, so that the bytes of an image would differ
/// between runs. No offset changes.
///
/// `None` if the header is not that of a file with a single part.
pub(super) fn sort(file: &mut [u8]) -> Option<()> {
    const MAGIC_AND_VERSION: usize = 8;
    let text_end = |from: usize| Some(from + file.get(from..)?.iter().position(|&b| b == 0)?);

    let mut attributes = Vec::new();
    let mut start = MAGIC_AND_VERSION;
    while *file.get(start)? != 0 {
        let name_end = text_end(start)?;
        let type_end = text_end(name_end + 1)?;
        let size_bytes = file.get(type_end + 1..type_end + 5)?;
        let size = u32::from_le_bytes(size_bytes.try_into().ok()?) as usize;
        let end = type_end + 5 + size;
        attributes.push((file.get(start..name_end)?, file.get(start..end)?));
        start = end;
    }
    attributes.sort();
    let sorted: Vec<u8> = attributes.iter().flat_map(|(_, bytes)| bytes.iter().copied()).collect();
    file.get_mut(MAGIC_AND_VERSION..start)?.copy_from_slice(&sorted);
    Some(())
}
