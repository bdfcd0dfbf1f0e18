//! The modules of a crate and the paths that they name, read from the tokens of its files.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use proc_macro2::{Delimiter, Group, Spacing, TokenStream, TokenTree};

/// A file names an item that another file defines.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arrow {
    pub from: String,
    pub line: usize,
    /// As it is written.
    pub path: String,
    pub to: String,
    /// Whether it is in code that is only compiled for unit tests.
    pub is_test: bool,
}

/// The files of a crate, by their paths from the root of the repository, with their texts.
pub struct Crate {
    files: BTreeMap<String, String>,
    modules: BTreeMap<Vec<String>, Module>,
}

/// A module: a file, or a part of one.
#[derive(Default)]
struct Module {
    file: String,
    is_test: bool,
    /// Items that it defines, without its modules.
    items: BTreeSet<String>,
    /// What its `use` lines bring in, by the name it has here.
    imports: BTreeMap<String, Vec<String>>,
    /// Modules of which all is brought in.
    globs: Vec<Vec<String>>,
    named: Vec<Named>,
}

/// A path that is written in a module.
struct Named {
    path: Vec<String>,
    line: usize,
    is_test: bool,
    /// Makes an item of a module inside this one public: no arrow.
    is_facade: bool,
}

impl Crate {
    /// Reads all files below `folder`, a path from `root`.
    pub fn read(root: &Path, folder: &str) -> Self {
        let mut files = BTreeMap::new();
        let mut folders = vec![folder.to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(root.join(&folder)).unwrap() {
                let path = format!("{folder}/{}", entry.unwrap().file_name().into_string().unwrap());
                if root.join(&path).is_dir() {
                    folders.push(path);
                } else if path.ends_with(".rs") {
                    let text = fs::read_to_string(root.join(&path)).unwrap();
                    files.insert(path, text);
                }
            }
        }
        Self::parse(folder, files)
    }

    /// `folder` has the crate's `lib.rs`.
    pub fn parse(folder: &str, files: BTreeMap<String, String>) -> Self {
        let mut modules = BTreeMap::new();
        for (file, text) in &files {
            let tokens: TokenStream = text.parse().unwrap_or_else(|error| panic!("{file}: {error}"));
            let path = module_path(folder, file);
            let own = Module { file: file.clone(), ..Module::default() };
            Reader { modules: &mut modules }.module(tokens, path, own);
        }
        mark_test_files(&mut modules);
        Self { files, modules }
    }

    /// Each file with its text.
    pub fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files.iter().map(|(file, text)| (file.as_str(), text.as_str()))
    }

    /// Each line of a file that names an item of another file, sorted.
    pub fn arrows(&self) -> Vec<Arrow> {
        let mut arrows = BTreeSet::new();
        for (place, module) in &self.modules {
            for named in module.named.iter().filter(|named| !named.is_facade) {
                let Some(to) = self.defined_in(place, &named.path, 0).filter(|to| *to != module.file) else { continue };
                arrows.insert(Arrow {
                    from: module.file.clone(),
                    line: named.line,
                    path: named.path.join("::"),
                    to: to.to_owned(),
                    is_test: module.is_test || named.is_test,
                });
            }
        }
        // One arrow from a line to a file is enough.
        let mut arrows: Vec<Arrow> = arrows.into_iter().collect();
        arrows.sort_by(|a, b| (&a.from, a.line, &a.to).cmp(&(&b.from, b.line, &b.to)));
        arrows.dedup_by(|a, b| (&a.from, a.line, &a.to) == (&b.from, b.line, &b.to));
        arrows
    }

    /// The file that defines what a path leads to from a module; `None` if it is of another crate, or
    /// a module, of which the items that are used are named by longer paths.
    fn defined_in(&self, place: &[String], path: &[String], depth: u32) -> Option<&str> {
        // Imports may go in circles, as in `pub use self::a::*`.
        if depth > 16 {
            return None;
        }
        let mut place = place.to_vec();
        for (index, segment) in path.iter().enumerate() {
            let module = self.modules.get(&place)?;
            match segment.as_str() {
                "crate" => place.clear(),
                "self" => {}
                "super" => _ = place.pop()?,
                "*" => return Some(&module.file),
                name => {
                    let inside: Vec<String> = place.iter().cloned().chain([name.to_owned()]).collect();
                    if self.modules.contains_key(&inside) {
                        place = inside;
                    } else if module.items.contains(name) {
                        return Some(&module.file);
                    } else {
                        let rest = &path[index + 1..];
                        let through = |target: &[String], rest: &[String]| {
                            // An import that names itself, such as `use image::Image`, is of another crate.
                            (target != path).then(|| self.defined_in(&place, &[target, rest].concat(), depth + 1))?
                        };
                        return match module.imports.get(name) {
                            Some(target) => through(target, rest),
                            None => module.globs.iter().find_map(|glob| through(glob, &path[index..])),
                        };
                    }
                }
            }
        }
        None
    }
}

/// `src/scene/mod.rs` is `["scene"]`, and `src/scene/model.rs` is `["scene", "model"]`.
fn module_path(folder: &str, file: &str) -> Vec<String> {
    let inner = file.strip_prefix(folder).unwrap().trim_start_matches('/').trim_end_matches(".rs");
    let mut path: Vec<String> = inner.split('/').map(str::to_owned).collect();
    path.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
    path
}

/// The folder of the modules inside a file's module: `src/a` of `src/a/mod.rs` and of `src/a.rs`.
pub fn folder_of(file: &str) -> &str {
    let stem = file.trim_end_matches(".rs");
    ["/mod", "/lib"].iter().find_map(|end| stem.strip_suffix(end)).unwrap_or(stem)
}

/// A file is compiled for tests only if the module that declares it says so.
fn mark_test_files(modules: &mut BTreeMap<Vec<String>, Module>) {
    let marked: Vec<Vec<String>> =
        modules.iter().filter(|(_, module)| module.is_test).map(|(path, _)| path.clone()).collect();
    for (path, module) in modules.iter_mut() {
        module.is_test |= marked.iter().any(|test| path.starts_with(test));
    }
}

struct Reader<'a> {
    modules: &'a mut BTreeMap<Vec<String>, Module>,
}

impl Reader<'_> {
    /// Reads a module's tokens, and enters it.
    fn module(&mut self, tokens: TokenStream, path: Vec<String>, mut own: Module) {
        self.items(tokens, &path, &mut own, false, true);
        let entry = self.modules.entry(path).or_default();
        // The line that declares a file may have come before.
        own.is_test |= entry.is_test;
        *entry = own;
    }

    /// Reads tokens of a module; those at its top define items.
    fn items(&mut self, tokens: TokenStream, path: &[String], own: &mut Module, is_test: bool, is_top: bool) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let outer = Item { is_test, is_public: false };
        let (mut at, mut item) = (0, outer);
        while at < tokens.len() {
            let (length, is_end) = self.token(&tokens[at..], path, own, &mut item, is_top);
            at += length;
            if is_end {
                item = outer;
            }
        }
    }

    /// Reads the tokens at the start that belong together. Returns how many they are, and whether an item
    /// ends with them.
    fn token(
        &mut self,
        rest: &[TokenTree],
        path: &[String],
        own: &mut Module,
        item: &mut Item,
        is_top: bool,
    ) -> (usize, bool) {
        match rest {
            [TokenTree::Punct(hash), TokenTree::Group(attribute), ..] if hash.as_char() == '#' => {
                item.is_test |= attribute.stream().to_string().replace(' ', "") == "cfg(test)";
                (2, false)
            }
            [TokenTree::Ident(word), ..] if *word == "pub" => {
                item.is_public = true;
                (1 + usize::from(matches!(rest.get(1), Some(TokenTree::Group(_)))), false)
            }
            [TokenTree::Ident(word), TokenTree::Ident(name), TokenTree::Group(body), ..]
                if *word == "mod" && body.delimiter() == Delimiter::Brace =>
            {
                let is_test = own.is_test || item.is_test;
                let inner = Module { file: own.file.clone(), is_test, ..Module::default() };
                self.module(body.stream(), inside(path, name.to_string()), inner);
                (3, true)
            }
            [TokenTree::Ident(word), TokenTree::Ident(name), ..] if *word == "mod" => {
                self.modules.entry(inside(path, name.to_string())).or_default().is_test |= item.is_test;
                (2, true)
            }
            [TokenTree::Ident(word), ..] if *word == "use" => {
                let end = rest.iter().position(|token| is_punct(token, ';')).unwrap_or(rest.len());
                for (alias, target) in use_tree(&rest[1..end], &[]) {
                    own.import(alias, target, word.span().start().line, *item);
                }
                (end, true)
            }
            [TokenTree::Group(group), ..] => {
                self.items(Group::stream(group), path, own, item.is_test, false);
                (1, group.delimiter() == Delimiter::Brace)
            }
            [TokenTree::Ident(first), ..] => {
                let (named, length) = path_at(rest);
                if is_top && let Some(name) = defined(rest) {
                    own.items.insert(name);
                }
                if named.len() > 1 {
                    let line = first.span().start().line;
                    own.named.push(Named { path: named, line, is_test: item.is_test, is_facade: false });
                }
                (length, false)
            }
            _ => (1, is_punct(&rest[0], ';')),
        }
    }
}

/// What is said before an item.
#[derive(Clone, Copy)]
struct Item {
    /// `#[cfg(test)]`, here or around it.
    is_test: bool,
    /// `pub`, with or without bounds.
    is_public: bool,
}

impl Module {
    fn import(&mut self, alias: String, target: Vec<String>, line: usize, item: Item) {
        let is_outer = ["crate", "super"].contains(&target[0].as_str());
        let is_facade = item.is_public && !is_outer;
        self.named.push(Named { path: target.clone(), line, is_test: item.is_test, is_facade });
        if alias == "*" {
            self.globs.push(target[..target.len() - 1].to_vec());
        } else {
            self.imports.insert(alias, target);
        }
    }
}

fn inside(path: &[String], name: String) -> Vec<String> {
    path.iter().cloned().chain([name]).collect()
}

fn is_punct(token: &TokenTree, wanted: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == wanted)
}

/// Whether `::` is at the start.
fn is_path_separator(tokens: &[TokenTree]) -> bool {
    matches!(tokens, [TokenTree::Punct(a), TokenTree::Punct(b), ..]
        if a.as_char() == ':' && a.spacing() == Spacing::Joint && b.as_char() == ':')
}

/// The segments of the path at the start, which is a name, and how many tokens they are.
fn path_at(tokens: &[TokenTree]) -> (Vec<String>, usize) {
    let (mut segments, mut at) = (vec![tokens[0].to_string()], 1);
    while is_path_separator(&tokens[at..]) {
        let Some(TokenTree::Ident(name)) = tokens.get(at + 2) else { break };
        segments.push(name.to_string());
        at += 3;
    }
    (segments, at)
}

/// The name of the item that is defined at the start.
fn defined(tokens: &[TokenTree]) -> Option<String> {
    const WORDS: [&str; 8] = ["struct", "enum", "union", "fn", "const", "static", "type", "trait"];
    match tokens {
        [TokenTree::Ident(word), TokenTree::Ident(name), ..] if WORDS.iter().any(|w| word == w) => {
            Some(name.to_string())
        }
        [TokenTree::Ident(word), TokenTree::Punct(_), TokenTree::Ident(name), ..] if word == "macro_rules" => {
            Some(name.to_string())
        }
        _ => None,
    }
}

/// The names that a `use` brings in, with their paths: of `a::{b, c as d, e::*}` these are `b`, `d` and `*`.
fn use_tree(tokens: &[TokenTree], before: &[String]) -> Vec<(String, Vec<String>)> {
    let mut path = before.to_vec();
    let mut at = if is_path_separator(tokens) { 2 } else { 0 };
    while at < tokens.len() {
        match &tokens[at] {
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                return inner.split(|token| is_punct(token, ',')).flat_map(|tree| use_tree(tree, &path)).collect();
            }
            TokenTree::Ident(word) if *word == "as" => return vec![(tokens[at + 1].to_string(), path)],
            TokenTree::Ident(word) if *word == "self" && !path.is_empty() => {}
            TokenTree::Ident(word) => path.push(word.to_string()),
            star if is_punct(star, '*') => path.push("*".to_owned()),
            _ => {}
        }
        at += 1;
    }
    path.last().cloned().map(|alias| (alias, path.clone())).into_iter().collect()
}
