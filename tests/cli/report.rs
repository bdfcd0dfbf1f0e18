//! The page that `goblet measure` writes, opened in a browser: its plots are there, in the
//! colours of its settings, and it asks nothing of anybody.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::support::command::Bench;
use crate::support::work;

/// What a browser made of a page.
struct Page {
    /// After it was laid out.
    dom: String,
    /// What it and the browser said to the console.
    console: Vec<String>,
    /// What it asked for besides itself.
    requests: BTreeSet<String>,
    picture: image::RgbImage,
}

/// Opens a file in headless Chromium.
fn open(file: &Path, folder: &Path, dark: bool) -> Page {
    let [log, picture, profile] = ["net.json", "page.png", "profile"].map(|name| folder.join(name));
    let url = format!("file://{}", file.display());
    let mut browser = Command::new(browser());
    browser.args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]);
    browser.args(["--disable-background-networking", "--disable-component-update", "--disable-sync"]);
    browser.args(["--enable-logging=stderr", "--window-size=1400,3000", "--hide-scrollbars"]);
    browser.arg(format!("--user-data-dir={}", profile.display()));
    browser.arg(format!("--log-net-log={}", log.display()));
    if dark {
        browser.arg("--blink-settings=preferredColorScheme=0");
    }
    browser.args(["--dump-dom", &format!("--screenshot={}", picture.display()), &url]);
    let output = browser.output().expect("Chromium");
    assert!(output.status.success(), "{output:?}");
    let [dom, console] = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    let console = console.lines().filter(|line| line.contains(":CONSOLE")).map(str::to_owned).collect();
    let requests = requests(&fs::read_to_string(&log).expect("a log of requests"), &url);
    Page { dom, console, requests, picture: image::open(picture).expect("a picture").into_rgb8() }
}

fn browser() -> PathBuf {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&folders).flat_map(|folder| names.map(|name| folder.join(name)));
    let installed = "no Chromium: `sh install.sh --tests` installs it";
    found.into_iter().find(|path| path.is_file()).expect(installed)
}

/// URLs in the browser's own log, but for the page, what is in it, and what the browser asks
/// on its own behalf.
fn requests(log: &str, page: &str) -> BTreeSet<String> {
    // A browser that is done quickly may leave the end of the list open.
    let log: Value = serde_json::from_str(log)
        .or_else(|_| serde_json::from_str(&format!("{}]}}", log.trim_end().trim_end_matches(','))))
        .expect("JSON");
    let events = log["events"].as_array().expect("events");
    let url = |event: &Value| event["params"]["url"].as_str().map(str::to_owned);
    // A browser's own requests have no frame that initiated them.
    let of_page = |event: &&Value| event["params"]["initiator"].as_str().is_some_and(|it| it != "not an origin");
    let urls = events.iter().filter(of_page).filter_map(url);
    urls.filter(|url| url != page && !url.starts_with("data:")).collect()
}

fn measure(bench: &Bench, scene: &str, arguments: &[&str]) -> PathBuf {
    let scene = format!("{}/{scene}", env!("CARGO_MANIFEST_DIR"));
    let run = bench.run(&[&["measure", &scene, "--quiet", "-o", "out"], arguments].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    bench.path("out/report.html")
}

/// Pixels of about one colour.
fn count(picture: &image::RgbImage, color: [u8; 3]) -> usize {
    let near = |pixel: &&image::Rgb<u8>| pixel.0.iter().zip(color).all(|(a, b)| a.abs_diff(b) < 8);
    picture.pixels().filter(near).count()
}

fn assert_report(bench: &Bench, report: &Path, settings: usize, schemes: &[bool]) {
    for dark in schemes.iter().copied() {
        let page = open(report, bench.0.path(), dark);
        assert_eq!(page.console, Vec::<String>::new());
        assert_eq!(page.requests, BTreeSet::new());
        assert_eq!(page.dom.matches("<svg").count(), 6, "plots");
        assert!(page.dom.matches("<polyline").count() >= 4 * settings, "lines");
        assert_eq!(page.dom.matches("src=\"data:image/png;base64,").count(), settings, "differences");
        // The lines of the first settings, and the page around them.
        for color in [[57, 119, 214], [224, 140, 20]] {
            assert!(count(&page.picture, color) > 500, "{color:?}");
        }
        let background = if dark { [21, 24, 28] } else { [255, 255, 255] };
        assert!(count(&page.picture, background) > page.picture.pixels().len() / 3);
    }
}

#[test]
fn the_report_of_cornell_caustic_opens_in_a_browser() {
    let bench = Bench::new();
    let reference = format!("{}/tests/reference/cornell-caustic.exr", env!("CARGO_MANIFEST_DIR"));
    let vary = ["--vary", "radius=1px,3px", "--vary", "iterations=4", "--repeat", "2"];
    let report = measure(
        &bench,
        "tests/reference/cornell-caustic.pbrt",
        &[&["--reference", &reference, "--budget", "60"], &vary[..]].concat(),
    );
    assert_report(&bench, &report, 2, &[false, true]);

    let results = bench.json("out/results.json");
    for setting in results["settings"].as_array().expect("settings") {
        let points = setting["points"].as_array().expect("points");
        let iterations: Vec<u64> = points.iter().filter_map(|point| point["iterations"].as_u64()).collect();
        assert_eq!(iterations, [1, 2, 3, 4]);
        let last = &points[3];
        let number = |name: &str| last[name].as_f64().expect(name);
        let separated = |name: &str| last["separated"][name].as_f64().expect(name);
        assert!((separated("noise") + separated("bias") - number("relmse")).abs() < 1e-9);
        assert!((number("energy_ratio") - 1.0).abs() < 0.03 && number("flip") > 0.0);
        assert!(setting["passes"]["photon"].as_f64().expect("a pass") > 0.0);
    }
    // Wider discs have less noise and more bias.
    let separated = |i: usize, name: &str| results["settings"][i]["points"][3]["separated"][name].as_f64().expect(name);
    assert!(separated(0, "noise") > 2.0 * separated(1, "noise"));
    assert!(separated(0, "bias") < separated(1, "bias"));
    let csv = String::from_utf8(bench.bytes("out/results.csv")).expect("UTF-8");
    assert_eq!(csv.lines().count(), 1 + 2 * 4);
    assert!(bench.image("out/setting-2.exr").width == 128);
}

#[test]
fn the_report_of_wine_cup_opens_in_a_browser() {
    let bench = Bench::new();
    let reference = format!("{}/tests/reference/wine-cup.exr", env!("CARGO_MANIFEST_DIR"));
    // Shown as large as the reference.
    let vary = ["--vary", "resolution=64x64,32x32", "--vary", "iterations=2", "--repeat", "2"];
    let report = measure(&bench, "tests/reference/wine-cup.pbrt", &[&["--reference", &reference], &vary[..]].concat());
    // The other test has both schemes of colours.
    assert_report(&bench, &report, 2, work(&[false][..], &[false, true]));
}

/// Goblet's own reference is so much longer than the budget, and the page says whose it is.
#[test]
fn a_reference_can_be_rendered_first() {
    let bench = Bench::new();
    let run =
        bench.run(&["measure", "scene.pbrt", "--reference", "auto", "--budget", "0.2", "--repeat", "1", "-o", "out"]);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stderr.contains("rendering a reference for 2 s"), "{run:?}");
    let report = String::from_utf8(bench.bytes("out/report.html")).expect("UTF-8");
    assert!(report.contains("goblet rendered it itself"));
    let results = bench.json("out/results.json");
    assert!(
        results["reference"]["own_iterations"].as_u64() > results["settings"][0]["points"][0]["iterations"].as_u64()
    );
    assert_eq!(bench.image("out/reference.exr").width, 16);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let bench = Bench::new();
    let reference = format!("{}/tests/reference/cornell-caustic.exr", env!("CARGO_MANIFEST_DIR"));
    let refuse = |arguments: &[&str], words: &[&str]| {
        let run = bench.run(&[&["measure", "scene.pbrt", "-o", "out"], arguments].concat());
        run.assert_refused(&arguments.join(" "), 2, words);
    };
    refuse(&["--reference", &reference], &["16x12", "128x128"]);
    refuse(&["--reference", "nothing.exr"], &["nothing.exr"]);
    refuse(&["--reference", "auto", "--vary", "alpha=2"], &["alpha=2"]);
    refuse(&["--reference", "auto", "--vary", "colour=red"], &["photons"]);
    refuse(&["--reference", "auto", "--vary", "radius=1e9"], &["radius of 1000000000"]);
    assert!(!bench.path("out/report.html").exists());
}

/// The check itself: a page that asks for something and fails at something is found out.
#[test]
fn a_page_that_is_not_self_contained_is_noticed() {
    let bench = Bench::new();
    bench.write("page.html", "<body><img src=\"http://127.0.0.1:9/a.png\"><script>nothing.here()</script></body>");
    let page = open(&bench.path("page.html"), bench.0.path(), false);
    assert!(page.console.iter().any(|line| line.contains("nothing is not defined")), "{:?}", page.console);
    assert!(page.requests.contains("http://127.0.0.1:9/a.png"), "{:?}", page.requests);
}
