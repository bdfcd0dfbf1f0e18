//! Tensor files: named arrays of numbers, in which Mitsuba and pbrt-v4 keep measured materials.
//!
//! Numbers are little-endian. A file starts with "tensor_file" and a zero byte, two bytes of version, and the
//! number of fields in 4 bytes. Each field has the length of its name (2 bytes), the name, the number of its
//! dimensions (2), the type of its numbers (1), the position of its data in the file (8), and its dimensions
//! (8 each), of which the last one varies fastest in the data.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use crate::base::input::{self, Budget, OverBudget};
use crate::scene::format::lexer::shorten;

const MAGIC: [u8; 12] = *b"tensor_file\0";
const VERSION: [u8; 2] = [1, 0];
/// Maximum number of fields of a file, and of dimensions of a field.
const MOST_FIELDS: u32 = 256;
const MOST_DIMENSIONS: u16 = 16;

/// The reason why a tensor file could not be read.
#[derive(Debug, thiserror::Error)]
pub(in crate::scene) enum TensorError {
    /// The file could not be opened or read.
    #[error("{0}")]
    Unreadable(io::Error),
    /// The file does not start as tensor files do.
    #[error("it is no tensor file; expected \"tensor_file\" at its start")]
    NoTensorFile,
    /// The version is not supported.
    #[error("its version of the tensor format is {}.{}; expected {}.{}", .0[0], .0[1], VERSION[0], VERSION[1])]
    Version([u8; 2]),
    /// The file ends too early.
    #[error("it ends within {0}; expected the rest of it")]
    Short(String),
    /// There are too many fields.
    #[error("it has {0} fields; expected at most {MOST_FIELDS}")]
    Fields(u32),
    /// A field is absent.
    #[error("it has no field \"{name}\"; expected {expected} of that name{hint}")]
    Missing {
        /// Name of the field.
        name: &'static str,
        /// The expected type and number of dimensions.
        expected: String,
        /// What to do about it, or nothing.
        hint: &'static str,
    },
    /// A field does not have the expected type, dimensions or values.
    #[error("its field \"{name}\" has {found}; expected {expected}")]
    Field {
        /// Name of the field.
        name: String,
        /// What it has.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// The data needs more memory than the budget has left.
    #[error("{0}")]
    OverBudget(#[from] OverBudget),
}

/// Types of numbers that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Numbers {
    Bytes,
    Floats,
}

impl Numbers {
    /// Returns the type's number in the format.
    fn code(self) -> u8 {
        match self {
            Self::Bytes => 1,
            Self::Floats => 10,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Bytes => "8-bit integers",
            Self::Floats => "32-bit floats",
        }
    }
}

/// Bytes of a number by its type's number in the format: integers of 8 to 64 bits, with and without sign, and
/// floats of 16 to 64 bits.
const SIZES: [u64; 12] = [0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];

/// An array of a file.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Field {
    pub name: String,
    /// Type of the numbers, as in the format.
    code: u8,
    /// Dimensions; their product fits into the file.
    pub shape: Vec<u64>,
    /// Position of the data in the file.
    offset: u64,
}

impl Field {
    /// Returns the error that the field has something unexpected.
    pub fn unexpected(&self, found: impl Into<String>, expected: impl Into<String>) -> TensorError {
        TensorError::Field { name: shorten(&self.name), found: found.into(), expected: expected.into() }
    }

    /// Fails unless the field has these dimensions.
    pub fn expect_shape(&self, expected: &[u64]) -> Result<(), TensorError> {
        if self.shape == expected {
            return Ok(());
        }
        Err(self.unexpected(format!("the dimensions {:?}", self.shape), format!("{expected:?}, by the other fields")))
    }
}

/// An open file whose fields are known and whose data is read on demand.
pub(in crate::scene) struct TensorFile<'a> {
    file: BufReader<File>,
    length: u64,
    fields: Vec<Field>,
    budget: &'a Budget,
}

impl<'a> TensorFile<'a> {
    /// Opens a file and reads the list of its fields. The bytes read count towards the budget.
    pub fn open(path: &Path, budget: &'a Budget) -> Result<Self, TensorError> {
        let file = input::open(path).map_err(TensorError::Unreadable)?;
        let length = file.metadata().map_err(TensorError::Unreadable)?.len();
        let mut tensor = Self { file: BufReader::new(file), length, fields: Vec::new(), budget };
        let magic: [u8; 12] = tensor.exact("the header").map_err(|error| match error {
            TensorError::Short(_) => TensorError::NoTensorFile,
            error => error,
        })?;
        if magic != MAGIC {
            return Err(TensorError::NoTensorFile);
        }
        let version = tensor.exact("the version")?;
        if version != VERSION {
            return Err(TensorError::Version(version));
        }
        let count = u32::from_le_bytes(tensor.exact("the number of fields")?);
        if count > MOST_FIELDS {
            return Err(TensorError::Fields(count));
        }
        for _ in 0..count {
            let field = tensor.read_field()?;
            tensor.fields.push(field);
        }
        Ok(tensor)
    }

    fn exact<const N: usize>(&mut self, what: &str) -> Result<[u8; N], TensorError> {
        let mut bytes = [0; N];
        self.fill(&mut bytes, what)?;
        Ok(bytes)
    }

    fn fill(&mut self, bytes: &mut [u8], what: &str) -> Result<(), TensorError> {
        self.budget.read(bytes.len() as u64)?;
        self.file.read_exact(bytes).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => TensorError::Short(what.to_string()),
            _ => TensorError::Unreadable(error),
        })
    }

    fn read_field(&mut self) -> Result<Field, TensorError> {
        let what = "the list of fields";
        let mut name = vec![0; usize::from(u16::from_le_bytes(self.exact(what)?))];
        self.fill(&mut name, what)?;
        let dimensions = u16::from_le_bytes(self.exact(what)?);
        let [code] = self.exact(what)?;
        let offset = u64::from_le_bytes(self.exact(what)?);
        let name = String::from_utf8_lossy(&name).into_owned();
        let mut field = Field { name, code, shape: Vec::new(), offset };
        if dimensions > MOST_DIMENSIONS {
            let expected = format!("at most {MOST_DIMENSIONS}");
            return Err(field.unexpected(format!("{dimensions} dimensions"), expected));
        }
        for _ in 0..dimensions {
            field.shape.push(u64::from_le_bytes(self.exact(what)?));
        }
        let size = SIZES.get(usize::from(code)).copied().unwrap_or(0);
        if size == 0 {
            return Err(field.unexpected(format!("numbers of type {code}"), "a type from 1 to 11"));
        }
        let bytes = field.shape.iter().try_fold(size, |product, side| product.checked_mul(*side));
        if bytes.and_then(|bytes| bytes.checked_add(offset)).is_none_or(|end| end > self.length) {
            let found = format!("the dimensions {:?} from byte {offset} on", field.shape);
            return Err(field.unexpected(found, format!("data that is in the file, of {} bytes", self.length)));
        }
        Ok(field)
    }

    /// Returns a field of numbers of a type, with a number of dimensions. `hint` ends the message if it is
    /// missing.
    pub fn field(
        &self,
        name: &'static str,
        numbers: Numbers,
        dimensions: usize,
        hint: &'static str,
    ) -> Result<Field, TensorError> {
        let expected = format!("{} of {dimensions} dimensions", numbers.name());
        let Some(field) = self.fields.iter().find(|field| field.name == name) else {
            return Err(TensorError::Missing { name, expected, hint });
        };
        if field.code != numbers.code() || field.shape.len() != dimensions {
            let found = format!("{} dimensions, and numbers of type {}", field.shape.len(), field.code);
            return Err(field.unexpected(found, format!("{expected} (type {})", numbers.code())));
        }
        Ok(field.clone())
    }

    /// Returns some of the numbers of a field of bytes or floats, from number `first` on. They must be finite.
    pub fn read(&mut self, field: &Field, first: u64, count: u64) -> Result<Vec<f32>, TensorError> {
        let size = SIZES[usize::from(field.code)];
        // The bytes, and the numbers.
        self.budget.check(count * (size + size_of::<f32>() as u64))?;
        let start = field.offset + first * size;
        self.file.seek(SeekFrom::Start(start)).map_err(TensorError::Unreadable)?;
        let mut bytes = vec![0; (count * size) as usize];
        self.fill(&mut bytes, &field.name)?;
        if field.code == Numbers::Bytes.code() {
            return Ok(bytes.into_iter().map(f32::from).collect());
        }
        let (words, _) = bytes.as_chunks::<4>();
        let numbers: Vec<f32> = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
        match numbers.iter().find(|number| !number.is_finite()) {
            Some(number) => Err(field.unexpected(format!("the value {number}"), "finite numbers")),
            None => Ok(numbers),
        }
    }
}
