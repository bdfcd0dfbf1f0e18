//! Scene text with meshes in place of bodies of revolution. All other text is kept, comments and blanks
//! included, except that names of files are adapted to the new text's folder.

use std::ops::Range;
use std::path::Path;

use crate::scene::format::error::SceneError;
use crate::scene::format::kind::Kind;
use crate::scene::format::lexer::{Token, TokenKind, TokenStream};
use crate::scene::format::params::{Param, ParamList};

/// The replacements in the text of a scene that was read without an error.
pub(crate) struct Rewrite<'a> {
    /// File names of the meshes: one for each `Shape "revolution"`, in the order of the text; `None` where
    /// the body is kept.
    pub meshes: Vec<Option<&'a str>>,
    /// Path of the scene's folder relative to the folder of the new text; empty if both are the same.
    pub folder: &'a str,
}

/// The result of a rewrite: the new text, and the files that it names.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Rewritten {
    pub text: String,
    /// The files that the text names, with the names that the old text has.
    pub files: Vec<String>,
}

impl Rewrite<'_> {
    /// Rewrites a scene's text. Included files must already be in it.
    ///
    /// # Errors
    /// The text is not a valid scene.
    pub fn apply(&self, text: &str) -> Result<Rewritten, SceneError> {
        let mut stream = TokenStream::new(text.to_owned(), "", None);
        let mut edits = Edits { text, kept: 0, result: Rewritten::default() };
        let mut meshes = self.meshes.iter();
        while let Some(token) = stream.next()? {
            let TokenKind::Word(directive) = &token.kind else { continue };
            let mut names = Vec::new();
            for _ in 0..name_count(directive) {
                names.push(stream.required("a name")?);
            }
            let [first, ..] = &names[..] else { continue };
            let params = ParamList::read(&mut stream)?;
            match directive.as_str() {
                "Shape" if is(first, "revolution") => {
                    if let Some(mesh) = meshes.next().copied().flatten() {
                        let file = format!("\"plymesh\" \"string filename\" {}", quoted(mesh));
                        edits.replace(&first.span, &file);
                        self.edit(&params, &mut edits, &["P", "degree"]);
                    } else {
                        self.edit(&params, &mut edits, &[]);
                    }
                }
                // Bodies ignore these parameters, but the new meshes would not. No other shape of a scene
                // that was read without an error uses them.
                "Attribute" if is(first, "shape") && !self.meshes.is_empty() => {
                    self.edit(&params, &mut edits, &["displacement", "displacement.edgelength"]);
                }
                _ => self.edit(&params, &mut edits, &[]),
            }
        }
        Ok(edits.finish())
    }

    /// Renames files and deletes unwanted parameters.
    fn edit(&self, params: &ParamList, edits: &mut Edits, unwanted: &[&str]) {
        for param in &params.items {
            if unwanted.contains(&&*param.name) {
                edits.delete(&param.span);
                continue;
            }
            let Some(file) = file_name(param) else { continue };
            edits.result.files.push(file.to_owned());
            if !self.folder.is_empty() && Path::new(file).is_relative() {
                let moved = Path::new(self.folder).join(file);
                let (kind, name) = (param.kind.word(), &param.name);
                let text = format!("\"{kind} {name}\" {}", quoted(&moved.to_string_lossy()));
                edits.replace(&param.span, &text);
            }
        }
    }
}

/// The new text during the rewrite.
struct Edits<'a> {
    text: &'a str,
    /// Number of bytes of the old text that have been copied or replaced.
    kept: usize,
    result: Rewritten,
}

impl Edits<'_> {
    fn replace(&mut self, span: &Range<usize>, text: &str) {
        self.result.text.push_str(&self.text[self.kept..span.start]);
        self.result.text.push_str(text);
        self.kept = span.end;
    }

    /// Deletes text and the blanks before it. Tokens that were apart stay apart.
    fn delete(&mut self, span: &Range<usize>) {
        let before = self.text[self.kept..span.start].trim_end_matches([' ', '\t']).len();
        let apart = self.text[span.end..].starts_with([' ', '\t', '\n', '\r']);
        self.replace(&(self.kept + before..span.end), if apart { "" } else { " " });
    }

    fn finish(mut self) -> Rewritten {
        self.result.text.push_str(&self.text[self.kept..]);
        self.result
    }
}

/// Returns the number of strings between a directive and its parameters, for directives that may name
/// files; 0 for others. A film's file is an output, in the working directory.
fn name_count(directive: &str) -> usize {
    match directive {
        "AreaLightSource" | "Attribute" | "LightSource" | "MakeNamedMaterial" | "MakeNamedMedium" | "Material"
        | "Shape" => 1,
        "Texture" => 3,
        _ => 0,
    }
}

/// Returns the name of the file that a directive reads by a parameter, if any. A film's file is an output.
pub(in crate::scene) fn input_file<'a>(directive: &str, param: &'a Param) -> Option<&'a str> {
    file_name(param).filter(|_| directive != "Film")
}

/// Returns the name of the file that a parameter names, if any.
fn file_name(param: &Param) -> Option<&str> {
    let names_file = |value: &&str| match param.kind {
        Kind::String => matches!(param.name.as_str(), "filename" | "normalmap"),
        // No name of pbrt's built-in spectra has a dot.
        Kind::Spectrum => value.contains('.'),
        _ => false,
    };
    param.text().filter(|value| !value.is_empty()).filter(names_file)
}

fn is(token: &Token, name: &str) -> bool {
    matches!(&token.kind, TokenKind::Text(text) if text == name)
}

/// Returns a string in quotes, with escapes, as in scene text.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '\n' => quoted.push_str("\\n"),
            '\r' => quoted.push_str("\\r"),
            '\t' => quoted.push_str("\\t"),
            _ => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::base::input::Budget;
    use crate::scene::load_with_text;

    fn rewritten(text: &str, folder: &str) -> String {
        let rewrite = Rewrite { meshes: vec![Some("x-1.ply"), Some("\\\"x\".ply")], folder };
        rewrite.apply(text).unwrap().text
    }

    #[test]
    fn bodies_become_meshes_and_all_else_stays() {
        for (text, expected) in [
            (
                "Shape \"revolution\" \"point2 P\" [ 0 0 1 1 ] \"integer degree\" 1\n# end",
                "Shape \"plymesh\" \"string filename\" \"x-1.ply\"\n# end",
            ),
            (
                "\tShape # a body\n\"revolution\"#!\n  \"integer degree\" [1] # of lines\n  \"float alpha\" 1\n \"point2 P\" [ 0 0\n1 1 # top\n]",
                "\tShape # a body\n\"plymesh\" \"string filename\" \"x-1.ply\"#!\n # of lines\n  \"float alpha\" 1\n ",
            ),
            (
                "Shape\"revolution\"\"float alpha\"1\"point2 P\"[0 0 1 1]Shape\"revolution\"\"integer degree\"[3]Shape\"sphere\"",
                "Shape\"plymesh\" \"string filename\" \"x-1.ply\"\"float alpha\"1 Shape\"plymesh\" \"string filename\" \"\\\\\\\"x\\\".ply\" Shape\"sphere\"",
            ),
            (
                "Attribute \"shape\" \"integer degree\" 2 \"texture displacement\" \"t\" \"float alpha\" 1",
                "Attribute \"shape\" \"integer degree\" 2 \"float alpha\" 1",
            ),
            ("NamedMaterial \"Shape\" # Shape \"revolution\"", "NamedMaterial \"Shape\" # Shape \"revolution\""),
        ] {
            assert_eq!(rewritten(text, ""), expected);
        }
    }

    #[test]
    fn files_are_found_from_another_folder() {
        for (text, expected) in [
            (
                "Shape \"plymesh\" \"string filename\" [ \"a.ply\" ]",
                "Shape \"plymesh\" \"string filename\" \"../b/a.ply\"",
            ),
            (
                "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"../a\\\"\"",
                "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"../b/../a\\\"\"",
            ),
            (
                "Attribute \"shape\" \"string filename\" \"/a.ply\"",
                "Attribute \"shape\" \"string filename\" \"/a.ply\"",
            ),
            ("Film \"rgb\" \"string filename\" \"a.exr\"", "Film \"rgb\" \"string filename\" \"a.exr\""),
            (
                "Material \"hair\" \"spectrum s\" \"a.spd\" \"spectrum t\" \"glass-BK7\"",
                "Material \"hair\" \"spectrum s\" \"../b/a.spd\" \"spectrum t\" \"glass-BK7\"",
            ),
        ] {
            assert_eq!(rewritten(text, "../b"), expected);
            assert_eq!(rewritten(text, ""), text);
        }
    }

    #[test]
    fn included_files_are_put_in_their_place() {
        let folder = tempfile::tempdir().unwrap();
        let scene =
            "WorldBegin Include \"a\" \"c\"# after c\nTranslate 1 2 3\n  Include \"b\" # after b\nShape \"sphere\"";
        for (name, text) in [
            ("scene", scene),
            ("a", "\u{feff}# a\nInclude \"b\"\nInclude # c"),
            ("b", "Scale 1 1 1 # b"),
            ("c", "LightSource \"point\"\n"),
        ] {
            fs::write(folder.path().join(name), text).unwrap();
        }
        let (scene, source) = load_with_text(&folder.path().join("scene"), Budget::default()).unwrap();
        assert_eq!((scene.shapes.len(), scene.lights.len()), (1, 1));
        let expected = "WorldBegin # a\nScale 1 1 1 # b\n\nLightSource \"point\"\n# after c\nTranslate 1 2 3\n  \
                        Scale 1 1 1 # b\n # after b\nShape \"sphere\"";
        assert_eq!(source.text, expected);
        assert_eq!(source.files.len(), 5);
    }
}
