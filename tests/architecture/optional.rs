//! Crates that a library without a feature does not have.

use std::path::Path;

/// The features that bring optional crates, by the manifest that lists them, and where their code is. Modules
/// there are left out with the feature.
const FEATURES: [(&str, &str, &[&str]); 4] = [
    ("Cargo.toml", "cli", &["src/cli", "src/main.rs", "src/viewer"]),
    ("Cargo.toml", "study", &["src/study", "src/cli"]),
    ("Cargo.toml", "view", &["src/viewer", "src/cli"]),
    ("host/Cargo.toml", "present", &["host/src/present"]),
];

/// A message for each file outside of the code of a feature that names a crate of that feature. `files` are paths
/// and texts.
pub fn strayed(root: &Path, files: &[(&str, &str)]) -> Vec<String> {
    let mut messages = Vec::new();
    for (manifest, feature, homes) in FEATURES {
        let source = manifest.replace("Cargo.toml", "src/");
        let crates = crates_of(&std::fs::read_to_string(root.join(manifest)).expect("a manifest"), feature);
        assert!(crates.len() > 3, "{manifest}: the feature `{feature}` has only the crates {crates:?}");
        let is_home = |file: &str| homes.iter().any(|home| file.starts_with(home));
        for (file, text) in files.iter().filter(|(file, _)| file.starts_with(&source) && !is_home(file)) {
            let named = crates.iter().filter(|name| names(text, name));
            messages.extend(named.map(|name| format!("{file}: `{name}` is there with the feature `{feature}` only")));
        }
    }
    messages
}

/// The crates of a feature, as code names them.
fn crates_of(manifest: &str, feature: &str) -> Vec<String> {
    let line = manifest.lines().find(|line| line.starts_with(&format!("{feature} = ["))).expect(feature);
    line.split('"').filter_map(|word| word.strip_prefix("dep:")).map(|name| name.replace('-', "_")).collect()
}

/// Whether a text has a path that begins with a name.
fn names(text: &str, name: &str) -> bool {
    let path = format!("{name}::");
    let begins = |at: usize| !text[..at].ends_with(|last: char| last.is_alphanumeric() || last == '_' || last == ':');
    text.match_indices(&path).any(|(at, _)| begins(at))
}

#[test]
fn a_crate_of_a_feature_is_named_where_it_strays() {
    let files =
        [("src/scene/a.rs", "use csv::Reader;"), ("src/scene/b.rs", "my_csv::x"), ("src/study/c.rs", "csv::x()")];
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let expected = "src/scene/a.rs: `csv` is there with the feature `study` only";
    assert_eq!(strayed(root, &files), [expected]);
}
