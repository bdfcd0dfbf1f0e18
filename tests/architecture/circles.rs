//! Circles of files: strongly connected components of the graph of dependencies.
//!
//! The first file of a folder (`mod.rs`, or `name.rs` of a folder `name`) lists a circle within that
//! folder, itself included, with a line `// Circle: a.rs <-> b.rs: reason`. The files of such a line
//! count as one.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::modules::{Arrow, folder_of};

/// A circle that a folder lists: its files, and where it is listed.
pub struct Listed {
    files: Vec<String>,
    place: String,
}

/// The circles that a file lists. Panics where a line is not of the form above.
pub fn listed(file: &str, text: &str) -> Vec<Listed> {
    let lines = text.lines().enumerate();
    let circles = lines.filter_map(|(index, line)| Some((index, line.trim().strip_prefix("// Circle: ")?)));
    let parse = |(index, line): (usize, &str)| {
        let place = format!("{file}:{}", index + 1);
        let parts =
            line.split_once(": ").filter(|(files, reason)| files.contains(" <-> ") && !reason.trim().is_empty());
        let (files, _) = parts.unwrap_or_else(|| panic!("{place}: expected `// Circle: a.rs <-> b.rs: reason`"));
        let full = |name: &str| {
            if file.ends_with(&format!("/{name}")) { file.to_owned() } else { format!("{}/{name}", folder_of(file)) }
        };
        let files = files.split(" <-> ").map(full).collect();
        Listed { files, place }
    };
    circles.map(parse).collect()
}

/// A message for each circle that remains once the listed ones count as one file each.
pub fn unlisted(arrows: &[Arrow], listed: &[Listed]) -> Vec<String> {
    let mut names = BTreeMap::new();
    for circle in listed {
        // Lists that share a file are one circle.
        let merged: BTreeSet<&str> = circle.files.iter().map(|file| name(&names, file)).collect();
        let first = *merged.first().expect("a circle has files");
        for other in names.values_mut().filter(|other| merged.contains(**other)) {
            *other = first;
        }
        names.extend(circle.files.iter().map(|file| (file.as_str(), first)));
    }
    let mut graph = Graph::default();
    for arrow in arrows {
        let (from, to) = (name(&names, &arrow.from), name(&names, &arrow.to));
        if from != to {
            graph.entry(from).or_default().entry(to).or_insert(arrow);
        }
    }
    circles(&graph).iter().map(message).collect()
}

/// A message for each list that has a file which is in no circle with the others.
pub fn stale(arrows: &[Arrow], listed: &[Listed]) -> Vec<String> {
    let mut graph = Graph::default();
    for arrow in arrows {
        graph.entry(&arrow.from).or_default().entry(&arrow.to).or_insert(arrow);
    }
    let is_circle = |circle: &Listed| {
        circle.files.iter().all(|from| circle.files.iter().all(|to| path(&graph, from, to).is_some()))
    };
    listed.iter().filter(|circle| !is_circle(circle)).map(|circle| circle.place.clone()).collect()
}

/// From each file, the files that it depends on, each with one arrow to it.
type Graph<'a> = BTreeMap<&'a str, BTreeMap<&'a str, &'a Arrow>>;

fn name<'a>(names: &BTreeMap<&'a str, &'a str>, file: &'a str) -> &'a str {
    names.get(file).copied().unwrap_or(file)
}

/// Files of which each depends on each other one, by way of others or not.
struct Circle<'a> {
    files: Vec<&'a str>,
    /// From the first file back to itself, as few as possible.
    arrows: Vec<&'a Arrow>,
}

fn circles<'a>(graph: &Graph<'a>) -> Vec<Circle<'a>> {
    let mut found: Vec<Circle<'a>> = Vec::new();
    for file in graph.keys() {
        if found.iter().any(|circle| circle.files.contains(file)) {
            continue;
        }
        if let Some(arrows) = path(graph, file, file) {
            let there_and_back =
                |other: &&str| path(graph, file, other).is_some() && path(graph, other, file).is_some();
            found.push(Circle { files: graph.keys().copied().filter(there_and_back).collect(), arrows });
        }
    }
    found
}

/// The shortest sequence of at least one arrow from a file to a file.
fn path<'a>(graph: &Graph<'a>, from: &str, to: &str) -> Option<Vec<&'a Arrow>> {
    let mut waiting = VecDeque::from([(from, Vec::new())]);
    let mut seen = BTreeSet::new();
    while let Some((file, arrows)) = waiting.pop_front() {
        for (next, arrow) in graph.get(file).into_iter().flatten() {
            let longer: Vec<&Arrow> = arrows.iter().copied().chain([*arrow]).collect();
            if *next == to {
                return Some(longer);
            }
            if seen.insert(*next) {
                waiting.push_back((next, longer));
            }
        }
    }
    None
}

fn message(circle: &Circle) -> String {
    let Circle { files, arrows } = circle;
    let step = |arrow: &&Arrow| format!("\n    {}:{} `{}` is in {}", arrow.from, arrow.line, arrow.path, arrow.to);
    format!("{}{}", files.join(" <-> "), arrows.iter().map(step).collect::<String>())
}
