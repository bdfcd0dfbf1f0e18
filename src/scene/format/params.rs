//! Parameter lists: declarations of a type and a name, with values.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::base::input::{Held, OverBudget};
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::kind::Kind;
use crate::scene::format::lexer::{Token, TokenKind, TokenStream, shorten};
use crate::scene::format::version3;
use crate::scene::spectrum::color_space::ColorSpace;

/// A parameter as the file has it.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Param {
    pub kind: Kind,
    pub name: String,
    pub location: Location,
    /// Byte range of the parameter in the text, values included; valid if all of it is in one file.
    pub span: Range<usize>,
    /// Values, shared by copies: inherited ones may be large.
    content: Arc<Content>,
    /// Colour space of rgb values.
    pub color_space: ColorSpace,
}

/// Values, and the memory that the parameter takes.
#[derive(Debug)]
struct Content {
    values: Values,
    held: Held,
}

#[derive(Debug)]
enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Flags(Vec<bool>),
}

impl std::fmt::Display for Param {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&declaration(self.kind, &self.name))
    }
}

fn declaration(kind: Kind, name: &str) -> String {
    format!("\"{} {}\"", kind.word(), shorten(name))
}

/// Approximate bytes of a parameter besides its values: names and lists are allocations.
const PARAM_BYTES: usize = size_of::<Param>() + size_of::<Content>() + 64;
/// Approximate bytes of a string besides its characters.
const TEXT_BYTES: usize = size_of::<String>() + 32;

/// Largest integer: integers are kept as f64, which holds them exactly up to 2^53.
const MAX_INTEGER: u64 = 1 << 53;

fn whole_number(word: &str) -> Option<f64> {
    word.parse().ok().filter(|integer: &i64| integer.unsigned_abs() <= MAX_INTEGER).map(|integer| integer as f64)
}

fn number(word: &str) -> Option<f64> {
    word.parse().ok().filter(|number: &f64| number.is_finite())
}

impl Param {
    /// Reads the one value of a parameter whose type is known without a declaration.
    pub fn read_undeclared(
        stream: &mut TokenStream,
        kind: Kind,
        name: &str,
        location: Location,
    ) -> Result<Self, SceneError> {
        let mut reading = Reading::new(stream, kind, name, location)?;
        let value = stream.required(&format!("the value of \"{}\"", shorten(name)))?;
        reading.add(value)?;
        Ok(reading.finish())
    }

    /// Reads the values of a parameter that is declared by its type and name.
    pub fn read(stream: &mut TokenStream, declaration: &str, location: Location) -> Result<Self, SceneError> {
        let mut words = declaration.split([' ', '\t']).filter(|w| !w.is_empty());
        let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
            return Err(location.invalid(format!(
                "\"{}\" does not declare a parameter; expected \"type name\"",
                shorten(declaration)
            )));
        };
        let Some(kind) = Kind::from_word(kind) else {
            let all: Vec<&str> = Kind::ALL.iter().map(|(_, word)| *word).collect();
            return Err(location.invalid(format!(
                "unknown parameter type `{}`; expected one of: {}{}",
                shorten(kind),
                all.join(", "),
                version3::hint_at_type(kind)
            )));
        };
        let mut reading = Reading::new(stream, kind, name, location)?;
        reading.read_values(stream)?;
        reading.check_group()?;
        Ok(reading.finish())
    }

    /// Replaces the values by numbers.
    ///
    /// # Errors
    /// The budget has no memory for them.
    pub fn set_numbers(&mut self, numbers: Vec<f64>) -> Result<(), SceneError> {
        let bytes = PARAM_BYTES + size_of_val(&numbers[..]);
        let held = self.content.held.budget().hold(bytes as u64).map_err(self.location.over())?;
        self.content = Arc::new(Content { values: Values::Numbers(numbers), held });
        Ok(())
    }

    /// Counts the parameter's bytes as read once more.
    ///
    /// # Errors
    /// The number of bytes read exceeds the budget.
    pub fn read_again(&self) -> Result<(), OverBudget> {
        self.content.held.read_again()
    }

    fn len(&self) -> usize {
        self.content.values.len()
    }

    /// Returns the numbers; empty if the parameter holds other values.
    pub fn numbers(&self) -> &[f64] {
        match &self.content.values {
            Values::Numbers(values) => values,
            _ => &[],
        }
    }

    /// Returns the string; `None` if the parameter does not hold exactly one.
    pub fn text(&self) -> Option<&str> {
        match &self.content.values {
            Values::Texts(values) if values.len() == 1 => Some(&values[0]),
            _ => None,
        }
    }

    /// Returns the strings; empty if the parameter holds other values.
    pub fn texts(&self) -> Vec<String> {
        match &self.content.values {
            Values::Texts(values) => values.clone(),
            _ => Vec::new(),
        }
    }

    /// Returns the numbers; fails if their count is not `N`.
    pub fn one<const N: usize>(&self) -> Result<[f64; N], SceneError> {
        <[f64; N]>::try_from(self.numbers()).map_err(|_| self.wrong_count(N))
    }

    fn wrong_count(&self, expected: usize) -> SceneError {
        let s = if expected == 1 { "" } else { "s" };
        let count = self.len();
        self.location.invalid(format!("{self} has {count} values; expected {expected} value{s}"))
    }

    /// Returns an error about the value, in the form `"float radius" is -1; expected …`.
    pub fn bad_value(&self, expected: &str) -> SceneError {
        let value = match &self.content.values {
            Values::Numbers(v) if v.len() == 1 => v[0].to_string(),
            Values::Numbers(v) if v.len() <= 4 => format!("{v:?}"),
            Values::Texts(v) if v.len() <= 4 => shorten(&format!("{v:?}")),
            _ => format!("{} values", self.len()),
        };
        self.location.invalid(format!("{self} is {value}; expected {expected}"))
    }
}

/// A parameter whose values are being read.
struct Reading {
    kind: Kind,
    name: String,
    location: Location,
    values: Values,
    held: Held,
}

impl std::fmt::Display for Reading {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&declaration(self.kind, &self.name))
    }
}

impl Reading {
    fn new(stream: &TokenStream, kind: Kind, name: &str, location: Location) -> Result<Self, SceneError> {
        let held = stream.budget().hold((PARAM_BYTES + name.len()) as u64).map_err(location.over())?;
        Ok(Self { kind, name: name.to_string(), location, values: Values::Numbers(Vec::new()), held })
    }

    fn finish(self) -> Param {
        let Self { kind, name, location, values, held } = self;
        let content = Arc::new(Content { values, held });
        Param { kind, name, location, span: 0..0, content, color_space: ColorSpace::default() }
    }

    fn read_values(&mut self, stream: &mut TokenStream) -> Result<(), SceneError> {
        let expected = format!("the value of {self}, or `[`");
        let first = stream.required(&expected)?;
        if first.kind != TokenKind::Open {
            return self.add(first);
        }
        let expected = format!("a value of {self}, or `]` to close the list");
        if let Values::Numbers(values) = &mut self.values {
            match self.kind {
                // These values may be words or strings.
                Kind::Bool | Kind::String | Kind::Texture | Kind::Spectrum => {}
                Kind::Integer => stream.number_list(whole_number, values, &mut self.held)?,
                _ => stream.number_list(number, values, &mut self.held)?,
            }
        }
        loop {
            let token = stream.required(&expected)?;
            if token.kind == TokenKind::Close {
                return Ok(());
            }
            self.add(token)?;
        }
    }

    fn add(&mut self, token: Token) -> Result<(), SceneError> {
        let fits = match (&token.kind, self.kind) {
            (TokenKind::Number { integer, .. }, Kind::Integer) => {
                integer.is_some_and(|i| i.unsigned_abs() <= MAX_INTEGER)
            }
            (TokenKind::Number { .. }, kind) => !matches!(kind, Kind::Bool | Kind::String | Kind::Texture),
            (TokenKind::Text(_), kind) => {
                matches!(kind, Kind::String | Kind::Texture | Kind::Spectrum)
            }
            (TokenKind::Word(word), Kind::Bool) => word == "true" || word == "false",
            _ => false,
        };
        let bytes = match &token.kind {
            TokenKind::Text(text) => TEXT_BYTES + text.len(),
            _ => size_of::<f64>(),
        };
        self.held.grow(bytes as u64).map_err(token.location.over())?;
        if !fits || !self.values.push(&token.kind) {
            return Err(token
                .location
                .invalid(format!("found {token} as a value of {self}; expected {}", self.expected_value())));
        }
        Ok(())
    }

    fn expected_value(&self) -> &'static str {
        match self.kind {
            Kind::Bool => "true or false, without quotes",
            Kind::Integer => "a whole number of at most 16 digits",
            Kind::String => "a string in quotes",
            Kind::Texture => "the name of a Texture in quotes",
            Kind::Spectrum => "numbers, or the name of a spectrum in quotes",
            _ => "a number, or `]` to close the list",
        }
    }

    fn check_group(&self) -> Result<(), SceneError> {
        let (group, count) = (self.kind.group(), self.values.len());
        if !count.is_multiple_of(group) {
            return Err(self.location.invalid(format!("{self} has {count} values; expected a multiple of {group}")));
        }
        Ok(())
    }
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Texts(values) => values.len(),
            Self::Flags(values) => values.len(),
        }
    }

    /// Appends a value; returns false if it is of another sort than the previous ones.
    fn push(&mut self, token: &TokenKind) -> bool {
        if matches!(self, Values::Numbers(numbers) if numbers.is_empty()) {
            match token {
                TokenKind::Text(_) => *self = Values::Texts(Vec::new()),
                TokenKind::Word(_) => *self = Values::Flags(Vec::new()),
                _ => {}
            }
        }
        match (self, token) {
            (Values::Numbers(values), TokenKind::Number { value, .. }) => values.push(*value),
            (Values::Texts(values), TokenKind::Text(text)) => values.push(text.clone()),
            (Values::Flags(values), TokenKind::Word(word)) => values.push(word == "true"),
            _ => return false,
        }
        true
    }
}

/// The parameters of one directive, in the order of the file.
#[derive(Clone, Debug, Default)]
pub(in crate::scene) struct ParamList {
    pub items: Vec<Param>,
    /// The memory of the list, if it is a copy.
    _copied: Option<Arc<Held>>,
}

impl ParamList {
    /// Returns a list of one parameter.
    pub fn of(param: Param) -> Self {
        Self { items: vec![param], _copied: None }
    }

    /// Sets parameters of a list that blocks share. If another block uses the list, this block gets a copy.
    ///
    /// # Errors
    /// The budget has no memory for a copy.
    pub fn set_all(self: &mut Arc<Self>, params: Vec<Param>) -> Result<(), SceneError> {
        if let (Some(param), None) = (params.first(), Arc::get_mut(self)) {
            let bytes = (self.items.len() * PARAM_BYTES) as u64;
            let copied = param.content.held.budget().hold(bytes).map_err(param.location.over())?;
            *self = Arc::new(Self { items: self.items.clone(), _copied: Some(Arc::new(copied)) });
        }
        if let Some(list) = Arc::get_mut(self) {
            for param in params {
                list.take(&param.name);
                list.items.push(param);
            }
        }
        Ok(())
    }

    /// Reads parameters as long as quoted strings follow. The list may contain a parameter twice.
    pub fn read(stream: &mut TokenStream) -> Result<Self, SceneError> {
        let mut list = ParamList::default();
        while let Some(Token { kind: TokenKind::Text(_), span, .. }) = stream.peek()? {
            let start = span.start;
            let (declaration, location) = stream.string("a parameter")?;
            let mut param = Param::read(stream, &declaration, location)?;
            param.span = start..stream.at();
            list.items.push(param);
        }
        Ok(list)
    }

    /// Removes and returns the parameters that repeat the type and name of an earlier one: the first one
    /// counts.
    ///
    /// # Errors
    /// A name is given with two types.
    pub fn take_repeated(&mut self) -> Result<Vec<Param>, SceneError> {
        let mut kinds = HashMap::with_capacity(self.items.len());
        let mut repeated = Vec::new();
        for param in std::mem::take(&mut self.items) {
            match kinds.get(&param.name) {
                None => {
                    kinds.insert(param.name.clone(), param.kind);
                    self.items.push(param);
                }
                Some(kind) if *kind == param.kind => repeated.push(param),
                Some(kind) => {
                    let first = kind.word();
                    let what = format!("{param} is given a second time, before as \"{first}\"; expected one of them");
                    return Err(param.location.invalid(what));
                }
            }
        }
        Ok(repeated)
    }

    pub fn get(&self, name: &str) -> Option<&Param> {
        self.items.iter().find(|param| param.name == name)
    }

    /// Removes and returns a parameter.
    pub fn take(&mut self, name: &str) -> Option<Param> {
        let index = self.items.iter().position(|param| param.name == name)?;
        Some(self.items.remove(index))
    }

    pub fn float(&self, name: &str) -> Result<Option<f64>, SceneError> {
        let one = |param: &Param| param.one::<1>().map(|[value]| value);
        self.get(name).map(one).transpose()
    }

    /// Returns a number that `accept` takes; `default` if the parameter is absent.
    pub fn float_in(
        &self,
        name: &str,
        default: f64,
        accept: impl Fn(f64) -> bool,
        expected: &str,
    ) -> Result<f64, SceneError> {
        match (self.get(name), self.float(name)?) {
            (Some(param), Some(value)) if !accept(value) => Err(param.bad_value(expected)),
            (_, value) => Ok(value.unwrap_or(default)),
        }
    }

    pub fn positive(&self, name: &str, default: f64) -> Result<f64, SceneError> {
        self.float_in(name, default, |v| v > 0.0, "a number above 0")
    }

    pub fn not_negative(&self, name: &str, default: f64) -> Result<f64, SceneError> {
        self.float_in(name, default, |v| v >= 0.0, "0 or a number above it")
    }

    /// Returns a whole number from `low` to `high`; `None` if the parameter is absent.
    pub fn integer(&self, name: &str, low: u32, high: u32) -> Result<Option<u32>, SceneError> {
        let Some(param) = self.get(name) else {
            return Ok(None);
        };
        let [value] = param.one()?;
        if !(f64::from(low)..=f64::from(high)).contains(&value) {
            return Err(param.bad_value(&format!("a whole number from {low} to {high}")));
        }
        Ok(Some(value as u32))
    }

    pub fn flag(&self, name: &str) -> Result<bool, SceneError> {
        match self.get(name) {
            None => Ok(false),
            Some(param) => match &param.content.values {
                Values::Flags(flags) if flags.len() == 1 => Ok(flags[0]),
                _ => Err(param.wrong_count(1)),
            },
        }
    }

    pub fn string(&self, name: &str) -> Result<Option<&str>, SceneError> {
        let one = |param: &Param| param.text().map(str::len).ok_or_else(|| param.wrong_count(1));
        self.get(name).map(one).transpose()?;
        Ok(self.get(name).and_then(Param::text))
    }

    pub fn point(&self, name: &str) -> Result<Option<DVec3>, SceneError> {
        let one = |param: &Param| param.one::<3>().map(DVec3::from);
        self.get(name).map(one).transpose()
    }

    pub fn triples(&self, name: &str) -> Vec<DVec3> {
        let numbers = self.get(name).map_or(&[][..], Param::numbers);
        numbers.chunks_exact(3).map(DVec3::from_slice).collect()
    }

    pub fn pairs(&self, name: &str) -> Vec<DVec2> {
        let numbers = self.get(name).map_or(&[][..], Param::numbers);
        numbers.chunks_exact(2).map(DVec2::from_slice).collect()
    }
}
