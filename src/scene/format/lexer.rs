//! Lexer: the tokens of a text, across included files.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use crate::base::input::{Budget, Held};
use crate::scene::format::error::{Location, SceneError};

/// A token and its place.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct Token {
    pub kind: TokenKind,
    pub location: Location,
    /// Byte range of the token in the text of its file.
    pub span: Range<usize>,
}

#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) enum TokenKind {
    /// A bare word: a directive, `true`, `false`.
    Word(String),
    /// A quoted string, escapes resolved.
    Text(String),
    /// A finite number; `integer` is set if the number is written as an integer.
    Number { value: f64, integer: Option<i64>, written: Box<str> },
    /// `[`
    Open,
    /// `]`
    Close,
}

impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            TokenKind::Word(word) => write!(f, "`{}`", shorten(word)),
            TokenKind::Text(text) => write!(f, "\"{}\"", shorten(text)),
            TokenKind::Number { written, .. } => write!(f, "`{}`", shorten(written)),
            TokenKind::Open => f.write_str("`[`"),
            TokenKind::Close => f.write_str("`]`"),
        }
    }
}

/// Shortens a text to 60 characters and replaces control characters, so that a message stays on one screen
/// line.
pub(crate) fn shorten(text: &str) -> String {
    const MOST: usize = 60;
    let mut short: String = text.chars().take(MOST).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.chars().nth(MOST).is_some() {
        short.push('…');
    }
    short
}

/// Reads the tokens of one file.
#[derive(Debug)]
struct Lexer {
    text: String,
    /// Byte offset of the next character.
    at: usize,
    /// Byte offset of the first byte that is not in [`FlatText`] yet.
    kept: usize,
    location: Location,
    /// Identity of the file on disk, if there is one; it detects cycles of includes.
    path: Option<PathBuf>,
    /// The memory that the text takes from the budget, if the text is from a file.
    _held: Option<Held>,
}

/// Number of numbers for which memory is reserved at a time.
const NUMBERS_AT_A_TIME: usize = 4096;

impl Lexer {
    fn new(text: String, file: &str, path: Option<PathBuf>, held: Option<Held>) -> Self {
        let byte_order_mark = if text.starts_with('\u{feff}') { 3 } else { 0 };
        let location = Location { file: Arc::from(file), line: 1, column: 1 };
        Self { text, at: byte_order_mark, kept: byte_order_mark, location, path, _held: held }
    }

    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn bump(&mut self) -> Option<char> {
        let c = self.peek()?;
        let ends_line = ends_line(self.text.as_bytes(), self.at);
        self.at += c.len_utf8();
        if ends_line {
            self.location.line = self.location.line.saturating_add(1);
            self.location.column = 1;
        } else {
            self.location.column = self.location.column.saturating_add(1);
        }
        Some(c)
    }

    fn skip_blank(&mut self) {
        let mut in_comment = false;
        let bytes = self.text.as_bytes();
        while let Some(byte) = bytes.get(self.at) {
            in_comment = (in_comment || *byte == b'#') && !matches!(byte, b'\n' | b'\r');
            if !in_comment && !is_blank(*byte) {
                return;
            }
            let ends_line = ends_line(bytes, self.at);
            self.at += 1;
            if ends_line {
                self.location.line = self.location.line.saturating_add(1);
                self.location.column = 1;
            } else if byte & 0xc0 != 0x80 {
                // The first byte of a character.
                self.location.column = self.location.column.saturating_add(1);
            }
        }
    }

    /// Returns the text up to the next blank, quote or bracket.
    fn word_ahead(&self) -> &str {
        let rest = &self.text[self.at..];
        let end = rest.bytes().position(|byte| is_blank(byte) || matches!(byte, b'"' | b'[' | b']'));
        &rest[..end.unwrap_or(rest.len())]
    }

    /// Advances within a line by a number of bytes, which are a number of characters.
    fn skip(&mut self, bytes: usize, characters: usize) {
        self.at += bytes;
        let characters = u32::try_from(characters).unwrap_or(u32::MAX);
        self.location.column = self.location.column.saturating_add(characters);
    }

    /// Appends the numbers at this place to `values`, up to the first word that `parse` refuses. Most of a
    /// large scene's text is lists of numbers, and tokens would take several times as long. Fails if the
    /// budget of memory is exhausted.
    fn numbers(
        &mut self,
        parse: fn(&str) -> Option<f64>,
        values: &mut Vec<f64>,
        held: &mut Held,
    ) -> Result<(), SceneError> {
        let size = |count: usize| (count * size_of::<f64>()) as u64;
        let mut room = 0;
        loop {
            self.skip_blank();
            let word = self.word_ahead();
            let Some(value) = Some(word).filter(|word| is_number(word)).and_then(parse) else {
                held.shrink(size(room));
                return Ok(());
            };
            if room == 0 {
                held.grow(size(NUMBERS_AT_A_TIME)).map_err(self.location.over())?;
                room = NUMBERS_AT_A_TIME;
            }
            values.push(value);
            room -= 1;
            let length = word.len();
            self.skip(length, length);
        }
    }

    fn next(&mut self) -> Result<Option<Token>, SceneError> {
        self.skip_blank();
        let (location, start) = (self.location.clone(), self.at);
        let kind = match self.peek() {
            None => return Ok(None),
            Some('[') => {
                self.bump();
                TokenKind::Open
            }
            Some(']') => {
                self.bump();
                TokenKind::Close
            }
            Some('"') => TokenKind::Text(self.text(&location)?),
            Some(_) => self.word(&location)?,
        };
        Ok(Some(Token { kind, location, span: start..self.at }))
    }

    fn word(&mut self, location: &Location) -> Result<TokenKind, SceneError> {
        let word = self.word_ahead().to_string();
        self.skip(word.len(), word.chars().count());
        if !is_number(&word) {
            return Ok(TokenKind::Word(word));
        }
        match word.parse::<f64>() {
            Ok(value) if value.is_finite() => {
                Ok(TokenKind::Number { value, integer: word.parse().ok(), written: word.into() })
            }
            Ok(_) => Err(location.invalid(format!(
                "`{}` is not a finite number; expected one below 1.8e308 in magnitude",
                shorten(&word)
            ))),
            Err(_) => Err(location.invalid(format!("`{}` is not a number", shorten(&word)))),
        }
    }

    fn text(&mut self, location: &Location) -> Result<String, SceneError> {
        self.bump();
        let mut text = String::new();
        loop {
            let here = self.location.clone();
            match self.bump() {
                Some('"') => return Ok(text),
                Some('\\') => text.push(self.escape(&here)?),
                Some('\n' | '\r') | None => {
                    return Err(location.invalid(format!(
                        "unterminated string \"{}; expected a closing \" on the same line",
                        shorten(&text)
                    )));
                }
                Some(c) => text.push(c),
            }
        }
    }

    fn escape(&mut self, location: &Location) -> Result<char, SceneError> {
        match self.bump() {
            Some('b') => Ok('\u{8}'),
            Some('f') => Ok('\u{c}'),
            Some('n') => Ok('\n'),
            Some('r') => Ok('\r'),
            Some('t') => Ok('\t'),
            Some(c @ ('\\' | '\'' | '"')) => Ok(c),
            Some(c) => Err(location.invalid(format!(
                "unknown escape `\\{}`; expected one of \\b \\f \\n \\r \\t \\\\ \\' \\\"",
                shorten(&c.to_string())
            ))),
            None => Err(location.invalid("the file ends inside a string")),
        }
    }
}

/// Returns true if a line ends with the byte at offset `at`: LF, or CR without a following LF, as on old
/// Macs.
fn ends_line(text: &[u8], at: usize) -> bool {
    text[at] == b'\n' || text[at] == b'\r' && text.get(at + 1) != Some(&b'\n')
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r')
}

/// Returns true if a word starts like a number.
fn is_number(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'))
}

/// The tokens of a scene: of its file, with the tokens of each included file at the place of its `Include`.
#[derive(Debug)]
pub(in crate::scene) struct TokenStream {
    files: Vec<Lexer>,
    ahead: Option<Token>,
    /// Place of the end of the last file that has ended.
    end: Location,
    /// The text so far, if it is kept.
    flat: Option<FlatText>,
    /// The scene's budget of memory.
    budget: Arc<Budget>,
    /// Number of files included so far.
    includes: u32,
}

/// The text of a scene with the text of every included file in place of its `Include`.
#[derive(Debug, Default)]
pub(crate) struct FlatText {
    pub text: String,
    /// Identities of the files that the text is from: equal for all names of the same file.
    pub files: Vec<PathBuf>,
    /// Length of the text before its last bare word, in bytes.
    before_word: usize,
}

impl FlatText {
    /// Appends the text of a file up to byte offset `end`.
    fn keep(&mut self, file: &mut Lexer, end: usize) {
        self.text.push_str(&file.text[file.kept..end]);
        file.kept = end;
    }
}

/// Maximum depth of nested `Include`s; deeper nesting is a mistake.
const MAX_INCLUDE_DEPTH: usize = 64;
/// Maximum number of included files: each may include two others, and so on.
const MAX_INCLUDES: u32 = 1 << 16;

impl TokenStream {
    /// Returns the tokens of a text that does not count towards a scene's budget.
    pub fn new(text: String, file: &str, path: Option<PathBuf>) -> Self {
        Self::within(Arc::default(), Lexer::new(text, file, path, None))
    }

    /// Returns the tokens of a file's text. Included files and values are charged to `budget`.
    pub fn of_file((text, held): (String, Held), file: &str, path: PathBuf, budget: &Arc<Budget>) -> Self {
        Self::within(Arc::clone(budget), Lexer::new(text, file, Some(path), Some(held)))
    }

    fn within(budget: Arc<Budget>, lexer: Lexer) -> Self {
        Self { end: lexer.location.clone(), files: vec![lexer], ahead: None, flat: None, budget, includes: 0 }
    }

    /// Returns the scene's budget of memory.
    pub fn budget(&self) -> &Arc<Budget> {
        &self.budget
    }

    /// Returns the stream, which now keeps the text for [`flat_text`](Self::flat_text).
    ///
    /// # Errors
    /// The budget has no memory for the text.
    pub fn keeping_text(mut self) -> Result<Self, SceneError> {
        let files = self.files.iter().filter_map(|file| file.path.clone()).collect();
        let length = self.files.iter().map(|file| file.text.len() as u64).sum();
        self.budget.take(length).map_err(self.end.over())?;
        self.flat = Some(FlatText { files, ..FlatText::default() });
        Ok(self)
    }

    /// Returns the text if it was kept; complete after `next` has returned `None`.
    pub fn flat_text(&mut self) -> FlatText {
        self.flat.take().unwrap_or_default()
    }

    /// Fails if including `path` from `location` would recurse without end, or if too many files are
    /// included.
    pub fn check_include(&mut self, path: &PathBuf, location: &Location) -> Result<(), SceneError> {
        self.includes += 1;
        if self.includes > MAX_INCLUDES {
            return Err(location.invalid(format!("the scene includes more than {MAX_INCLUDES} files; expected fewer")));
        }
        if self.files.iter().any(|file| file.path.as_ref() == Some(path)) {
            let chain: Vec<&str> = self.files.iter().map(|f| &*f.location.file).collect();
            return Err(location.invalid(format!(
                "Include \"{}\" includes itself: {} is being read already",
                path.display(),
                chain.join(" > ")
            )));
        }
        if self.files.len() >= MAX_INCLUDE_DEPTH {
            return Err(
                location.invalid(format!("Include nests deeper than {MAX_INCLUDE_DEPTH} files; expected no recursion"))
            );
        }
        Ok(())
    }

    /// Continues with an included file, and returns to the present one at its end. The last tokens must be
    /// the directive and the file's name.
    ///
    /// # Errors
    /// The text is kept, and the budget has no memory for it.
    pub fn include(&mut self, (text, held): (String, Held), file: &str, path: PathBuf) -> Result<(), SceneError> {
        debug_assert!(self.ahead.is_none(), "a token would be taken out of order");
        if let (Some(flat), Some(outer)) = (&mut self.flat, self.files.last_mut()) {
            self.budget.take(text.len() as u64).map_err(outer.location.over())?;
            flat.text.truncate(flat.before_word);
            flat.files.push(path.clone());
            outer.kept = outer.at;
        }
        self.files.push(Lexer::new(text, file, Some(path), Some(held)));
        Ok(())
    }

    /// Continues with an included file in an attribute block of its own, which the caller has begun. Fails
    /// as [`include`](Self::include) does.
    pub fn import(&mut self, (mut text, held): (String, Held), file: &str, path: PathBuf) -> Result<(), SceneError> {
        text.push_str("\nAttributeEnd\n");
        self.include((text, held), file, path)?;
        if let Some(flat) = &mut self.flat {
            flat.text.push_str("AttributeBegin\n");
        }
        Ok(())
    }

    /// Returns the next token, or `None` at the end of the scene.
    pub fn next(&mut self) -> Result<Option<Token>, SceneError> {
        if let Some(token) = self.ahead.take() {
            return Ok(Some(token));
        }
        while let Some(file) = self.files.last_mut() {
            if let Some(token) = file.next()? {
                if let (Some(flat), TokenKind::Word(_)) = (&mut self.flat, &token.kind) {
                    flat.keep(file, token.span.start);
                    flat.before_word = flat.text.len();
                }
                return Ok(Some(token));
            }
            self.end = file.location.clone();
            if let Some(flat) = &mut self.flat {
                flat.keep(file, file.text.len());
                // The text after an included file must not join its last word or comment.
                if self.files.len() > 1 && !flat.text.ends_with('\n') {
                    flat.text.push('\n');
                }
            }
            self.files.pop();
        }
        Ok(None)
    }

    /// Returns the next token without consuming it.
    pub fn peek(&mut self) -> Result<Option<&Token>, SceneError> {
        if self.ahead.is_none() {
            self.ahead = self.next()?;
        }
        Ok(self.ahead.as_ref())
    }

    /// Appends the bare numbers that come next to `values`, up to the first word that `parse` refuses.
    /// Their memory is added to `held`.
    ///
    /// # Errors
    /// The budget has no memory for them.
    pub fn number_list(
        &mut self,
        parse: fn(&str) -> Option<f64>,
        values: &mut Vec<f64>,
        held: &mut Held,
    ) -> Result<(), SceneError> {
        match (&self.ahead, self.files.last_mut()) {
            (None, Some(file)) => file.numbers(parse, values, held),
            _ => Ok(()),
        }
    }

    /// Returns the next token; fails at the end of the scene.
    pub fn required(&mut self, expected: &str) -> Result<Token, SceneError> {
        self.next()?.ok_or_else(|| self.end.invalid(format!("the file ends here; expected {expected}")))
    }

    /// Reads a quoted string, and returns it with its place.
    pub fn string(&mut self, expected: &str) -> Result<(String, Location), SceneError> {
        let token = self.required(expected)?;
        match token.kind {
            TokenKind::Text(text) => Ok((text, token.location)),
            _ => Err(token.location.invalid(format!("found {token}; expected {expected} in quotes"))),
        }
    }

    /// Reads `N` bare numbers, as `LookAt` and `Translate` have.
    pub fn numbers<const N: usize>(&mut self, of: &str) -> Result<[f64; N], SceneError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let expected = format!("{N} numbers after {of}");
            let token = self.required(&expected)?;
            match token.kind {
                TokenKind::Number { value, .. } => *number = value,
                _ => {
                    return Err(token.location.invalid(format!("found {token}; expected {expected}")));
                }
            }
        }
        Ok(numbers)
    }

    /// Reads `[`, sixteen numbers and `]`.
    pub fn matrix(&mut self, of: &str) -> Result<[f64; 16], SceneError> {
        self.bracket(&TokenKind::Open, "`[` and 16 numbers", of)?;
        let numbers = self.numbers(of)?;
        self.bracket(&TokenKind::Close, "`]` after 16 numbers", of)?;
        Ok(numbers)
    }

    fn bracket(&mut self, kind: &TokenKind, expected: &str, of: &str) -> Result<(), SceneError> {
        let token = self.required(expected)?;
        if token.kind == *kind {
            return Ok(());
        }
        Err(token.location.invalid(format!("found {token} in {of}; expected {expected}")))
    }

    /// Returns the byte offset of the end of the last token in its file; valid unless the next token was
    /// peeked at.
    pub fn at(&self) -> usize {
        self.files.last().map_or(0, |file| file.at)
    }

    /// Returns the place where the scene ended; valid after `next` has returned `None`.
    pub fn end(&self) -> &Location {
        &self.end
    }
}

#[cfg(test)]
mod tests;
