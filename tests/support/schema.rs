//! The keys of JSON that commands print, and the types of their values.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

/// Types of values by the paths of their keys, as in `film.resolution`. An item of a list has the path of the list
/// with `[]` at its end.
#[derive(Default)]
pub struct Schema {
    types: BTreeMap<String, BTreeSet<&'static str>>,
    /// Paths of objects whose keys are not of the schema, such as names of kernels. The schema has `*` for them.
    open: &'static [&'static str],
}

impl Schema {
    /// Returns a schema without keys, in which these objects may have any.
    pub fn with_open(open: &'static [&'static str]) -> Self {
        Self { open, ..Self::default() }
    }

    /// Adds the keys of a value.
    pub fn add(&mut self, value: &Value) {
        self.add_at("", value);
    }

    fn add_at(&mut self, path: &str, value: &Value) {
        let name = match value {
            Value::Null => "null",
            Value::Bool(_) => "boolean",
            Value::Number(number) if number.is_f64() => "number",
            Value::Number(_) => "integer",
            Value::String(_) => "string",
            Value::Array(_) => "list",
            Value::Object(_) => "object",
        };
        self.types.entry(path.to_owned()).or_default().insert(name);
        match value {
            Value::Object(fields) => {
                for (key, value) in fields {
                    let key = if self.open.contains(&path) { "*" } else { key };
                    let path = if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
                    self.add_at(&path, value);
                }
            }
            Value::Array(items) => items.iter().for_each(|item| self.add_at(&format!("{path}[]"), item)),
            _ => (),
        }
    }

    fn text(&self) -> String {
        let line = |(path, types): (&String, &BTreeSet<&str>)| {
            format!("{path}: {}\n", types.iter().copied().collect::<Vec<_>>().join(" or "))
        };
        self.types.iter().filter(|(path, _)| !path.is_empty()).map(line).collect()
    }

    /// Fails unless the schema is the one that `tests/cli/schemas` has for its version. Programs of users rely on it:
    /// when a key vanishes or its type changes, the version is to be raised.
    pub fn assert_is(&self, expected: &str, file: &str) {
        let found = self.text();
        if std::env::var_os("GOBLET_WRITE_DOCS").is_some() {
            let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/schemas");
            std::fs::write(format!("{folder}/{file}"), &found).unwrap();
        }
        assert_eq!(found, expected, "tests/cli/schemas/{file}");
    }

    /// Fails unless docs/json.md has exactly these keys in its section of a command.
    pub fn assert_documented(&self, command: &str) {
        let page = include_str!("../../docs/json.md");
        let heading = format!("## `{command}`\n");
        let (_, section) = page.split_once(&heading).unwrap_or_else(|| panic!("docs/json.md has no {heading}"));
        let section = section.split("\n## ").next().unwrap();
        let rows = section.lines().filter_map(|line| line.strip_prefix("| `"));
        // Names between back quotes in the first column.
        let names =
            |row: &'static str| row.split('|').next().into_iter().flat_map(|column| column.split('`').step_by(2));
        let documented: BTreeSet<String> = rows.flat_map(names).filter(|it| *it != " ").map(str::to_owned).collect();
        let keys: BTreeSet<String> =
            self.types.keys().map(|path| path.replace("[]", "")).filter(|it| !it.is_empty()).collect();
        assert_eq!(keys.difference(&documented).collect::<Vec<_>>(), Vec::<&String>::new(), "not documented");
        assert_eq!(
            documented.difference(&keys).collect::<Vec<_>>(),
            Vec::<&String>::new(),
            "documented, but not there"
        );
    }
}
