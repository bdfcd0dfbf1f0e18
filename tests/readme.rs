//! The documents: the README's first scene shows a caustic, every scene in them is read, and every
//! relative link leads to a file, and to a heading where it names one.

mod support;

use std::fs;
use std::path::{Path, PathBuf};

use goblet::Options;
use goblet::image::film::luminance;
use goblet::scene::Scene;
use support::root;

/// README.md, CHANGELOG.md and the pages of docs/.
fn documents() -> Vec<PathBuf> {
    let pages = fs::read_dir(root().join("docs")).expect("docs/").map(|entry| entry.expect("an entry").path());
    let mut documents: Vec<PathBuf> = pages.filter(|path| path.extension().is_some_and(|it| it == "md")).collect();
    documents.extend(["README.md", "CHANGELOG.md"].map(|name| root().join(name)));
    documents.sort();
    assert!(documents.len() > 10, "{documents:?}");
    documents
}

fn text_of(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The fenced blocks of a language.
fn blocks<'a>(text: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    text.split(fence.as_str()).skip(1).filter_map(|rest| rest.split_once("```")).map(|(block, _)| block).collect()
}

/// The text without fenced blocks.
fn prose(text: &str) -> String {
    text.split("```").step_by(2).collect()
}

/// The largest luminance of the first scene of the README, W/(m² sr).
fn brightest(scene: &str) -> f64 {
    let options = Options { resolution: Some([120, 90]), ..Options::default() };
    let image = support::render(scene, &options, 8).image;
    image.pixels.iter().map(|pixel| f64::from(luminance(*pixel))).fold(0.0, f64::max)
}

#[test]
fn the_first_scene_of_the_readme_has_a_caustic() {
    let readme = text_of(&root().join("README.md"));
    let scene = blocks(&readme, "pbrt")[0];
    let (without_ball, _) = scene.split_once("Material \"dielectric\"").expect("a ball of glass");
    let [focus, table] = [scene, without_ball].map(brightest);
    println!("brightest with the ball {focus:.2}, without {table:.3}");
    assert!(focus > 5.0 * table, "{focus} is no focus beside {table}");
}

#[test]
fn every_scene_in_the_documents_is_read() {
    let mut count = 0;
    for path in documents() {
        for scene in blocks(&text_of(&path), "pbrt") {
            let name = path.display().to_string();
            let scene = Scene::parse(scene, &name, root()).unwrap_or_else(|error| panic!("{error}"));
            assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
            count += 1;
        }
    }
    assert!(count >= 2, "{count} scenes");
}

/// The targets of links and images, `[text](target)`, but for those on the web.
fn links(text: &str) -> Vec<String> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    targets.map(|(target, _)| target.to_owned()).filter(|target| !target.contains("://")).collect()
}

/// The anchor that a heading gets: lower case, hyphens for blanks, no punctuation.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

fn has_heading(text: &str, wanted: &str) -> bool {
    let headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#'));
    headings.map(anchor).any(|anchor| anchor == wanted)
}

#[test]
fn every_link_of_the_documents_leads_somewhere() {
    let (mut broken, mut count) = (Vec::new(), 0);
    for path in documents() {
        let text = text_of(&path);
        for link in links(&prose(&text)) {
            count += 1;
            let (file, heading) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() { path.clone() } else { path.with_file_name(file) };
            let found = target.exists() && (heading.is_empty() || has_heading(&prose(&text_of(&target)), heading));
            if !found {
                broken.push(format!("{}: {link}", path.display()));
            }
        }
    }
    assert!(count > 50, "{count} links");
    assert!(broken.is_empty(), "{broken:#?}");
}
