//! Scenes with something changed at random: each is read and packed, or refused, and nothing
//! panics. `GOBLET_MUTATIONS=100000 cargo test --test scene mutations` tries 100,000 scenes, others for
//! each `GOBLET_MUTATIONS_SEED`.

use std::fs;
use std::path::{Path, PathBuf};

use goblet::RevolutionSolver;
use goblet::gpu_scene::pack::pack;
use goblet::scene::{FAMILIES, Scene};

use crate::support::random::Rng;
use crate::support::work;

/// Directives and options that the scenes at hand do not have.
const SINK: &str = r#"
Option "integer seed" 3 Option "bool disablepixeljitter" true ColorSpace "rec2020"
Film "spectral" "float cropwindow" [.1 .9 .2 .8] "integer pixelbounds" [0 9 0 9] "float iso" 200 "string sensor" "x"
"float whitebalance" 4000
PixelFilter "mitchell" "float B" .3 "float C" .3 PixelFilter "sinc" "float tau" 3 "float xradius" 4
ActiveTransform EndTime Translate 0 1 0 ActiveTransform All TransformTimes 0 1
Camera "orthographic" "float screenwindow" [-1 1 -1 1] "float lensradius" .1 "float focaldistance" 3
Camera "spherical" "string mapping" "equirectangular" "float shutteropen" 0 "float shutterclose" .5
WorldBegin
Attribute "shape" "float radius" 2 Include "none.pbrt" Import "none.pbrt" CoordSysTransform "camera"
Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" [400 1 700 2] ReverseOrientation
Material "dielectric" "spectrum eta" "eta.spd" "rgb transmittance" [1 .5 1]
LightSource "distant" "blackbody L" 5000 LightSource "infinite" "spectrum L" "stdillum-D50" "float illuminance" 3
LightSource "spot" "float coneangle" 40 "float conedeltaangle" 9 "float power" 10
AreaLightSource "diffuse" "rgb L" [1 2 3] "float power" 3 "bool twosided" true
Texture "h" "float" "windy" Material "coateddiffuse" "texture displacement" "h" "string normalmap" "none.png"
Shape "sphere" "float zmin" -.5 "float zmax" .5 "float phimax" 90 Shape "plymesh" "string filename" "m.ply"
Material "measured" "string filename" "m.bsdf"
Shape "revolution" "integer degree" 4 "point2 P" [0 0 1 0 1 .5 2 1 .5 2] ObjectBegin "a" ObjectEnd ObjectInstance "a"
"#;

const NUMBERS: [&str; 20] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e-30",
    "1e30",
    "-1e30",
    "1e300",
    "1e-300",
    "5e-324",
    "4294967295",
    "4294967296",
    "-2147483649",
    "9007199254740993",
    "1e18",
    "65536",
    "3.4e38",
    "180",
];

/// Pieces between blanks, and quoted strings whole; without comments.
fn pieces(text: &str) -> Vec<String> {
    let mut pieces = vec![String::new()];
    let mut quoted = false;
    for character in text.lines().flat_map(|line| line.split('#').next().unwrap_or_default().chars().chain(['\n'])) {
        quoted ^= character == '"';
        if !quoted && (character.is_whitespace() || character == '[' || character == ']') {
            pieces.push(character.to_string());
            pieces.push(String::new());
        } else if let Some(last) = pieces.last_mut() {
            last.push(character);
        }
    }
    pieces.retain(|piece| !piece.trim().is_empty());
    pieces
}

fn corpus() -> Vec<Vec<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["scenes", "tests/reference"].map(|folder| fs::read_dir(root.join(folder)).unwrap());
    let mut paths: Vec<PathBuf> = folders.into_iter().flatten().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "pbrt"));
    paths.sort();
    let mut texts: Vec<String> = paths.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    texts.push(SINK.to_owned());
    texts.iter().map(|text| pieces(text)).collect()
}

/// All that a scene can say, in quotes.
fn words() -> Vec<String> {
    let mut words = Vec::new();
    for spec in FAMILIES.iter().flat_map(|family| family.types) {
        words.push(format!("\"{}\"", spec.name));
        for param in spec.parameters {
            words.extend(param.kinds.iter().map(|kind| format!("\"{} {}\"", kind.word(), param.name)));
        }
    }
    words
}

fn mutate(scene: &mut Vec<String>, others: &[Vec<String>], words: &[String], rng: &mut Rng) {
    let at = rng.below(scene.len());
    let number = rng.pick(&NUMBERS).to_owned();
    match rng.below(10) {
        0 => drop(scene.remove(at)),
        1 => scene.insert(at, number),
        2 => scene[at] = words[rng.below(words.len())].clone(),
        3 => scene.insert(at, words[rng.below(words.len())].clone()),
        4 => {
            let other = &others[rng.below(others.len())];
            let from = rng.below(other.len());
            let to = (from + 1 + rng.below(12)).min(other.len());
            scene.splice(at..at, other[from..to].iter().cloned());
        }
        5 => {
            let mut characters: Vec<char> = scene[at].chars().collect();
            let place = rng.below(characters.len());
            characters[place] = rng.pick(&["\"", "[", "\u{e9}", "#", "e", "9", "-"]).chars().next().unwrap_or(' ');
            scene[at] = characters.into_iter().collect();
        }
        _ => {
            // Numbers are what does the most.
            let found = (at..scene.len()).find(|i| scene[*i].parse::<f64>().is_ok());
            if let Some(i) = found {
                scene[i] = number;
            }
        }
    }
    if scene.is_empty() {
        scene.push("WorldBegin".to_owned());
    }
}

/// Scenes to try, unless there is another number.
const CASES: u64 = 1000;
const CASES_IN_FULL: u64 = 100_000;

#[test]
fn no_scene_makes_a_panic() {
    let variable = |name: &str| std::env::var(name).ok().and_then(|value| value.parse::<u64>().ok());
    let cases = variable("GOBLET_MUTATIONS").unwrap_or(work(CASES, CASES_IN_FULL));
    let seed = variable("GOBLET_MUTATIONS_SEED").unwrap_or(1);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference");
    let last = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutated.pbrt");
    let (corpus, words) = (corpus(), words());
    let mut packed = 0;
    for case in 0..cases {
        let mut rng = Rng(seed << 40 | case);
        let mut scene = corpus[rng.below(corpus.len())].clone();
        for _ in 0..1 + rng.below(4) {
            mutate(&mut scene, &corpus, &words, &mut rng);
        }
        let text = scene.join(" ");
        // An abort leaves no message.
        fs::write(&last, &text).unwrap();
        let outcome = std::panic::catch_unwind(|| {
            let scene = Scene::parse(&text, "mutated.pbrt", &folder).ok()?;
            pack(&scene, RevolutionSolver::default()).ok().map(|_| ())
        });
        match outcome {
            Ok(packs) => packed += u64::from(packs.is_some()),
            Err(_) => panic!("seed {seed}, case {case}: this scene makes a panic:\n{text}"),
        }
    }
    println!("{cases} scenes, of which {packed} could be rendered");
    assert!(packed * 50 > cases, "{packed} of {cases}: mutations leave too little to test");
}
