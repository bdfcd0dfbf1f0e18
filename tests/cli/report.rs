//! The page that `goblet measure` writes, opened in a browser: its plots are there, in the colours of its settings,
//! its sliders move, it fits a phone, and it asks nothing of anybody.

use std::path::{Path, PathBuf};

use crate::browser::{Browser, DESKTOP, PHONE, Screen};
use crate::support::command::Bench;
use crate::support::work;

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

fn assert_report(browser: &mut Browser, report: &Path, settings: usize, schemes: &[bool]) {
    for is_dark in schemes.iter().copied() {
        browser.open(report, Screen { is_dark, ..DESKTOP });
        assert_eq!(browser.console(), Vec::<String>::new());
        assert_eq!(browser.requests(), Vec::<String>::new());
        let mut count_of = |selector: &str| browser.number(&format!("document.querySelectorAll({selector:?}).length"));
        assert_eq!(count_of("svg"), 5.0, "plots");
        assert_eq!(count_of("svg + .legend"), 5.0, "legends");
        assert!(count_of("svg polyline") >= 4.0 * settings as f64, "lines");
        assert_eq!(count_of(".slide"), settings as f64);
        assert_eq!(count_of("img[alt^=difference]"), settings as f64);
        assert_eq!(count_of("tr.best"), 1.0, "a winner");
        let sentence = browser.value("document.querySelector('.verdict').innerText");
        let sentence = sentence.as_str().expect("a sentence");
        assert!(
            sentence.starts_with("At equal time, after ") && sentence.contains("has the least error"),
            "{sentence}"
        );
        for word in ["relMSE", "trimmed", "bias", "noise", "FLIP"] {
            let is_word = format!("[...document.querySelectorAll('dt')].some(it => it.innerText == '{word}')");
            assert_eq!(browser.value(&is_word), true, "{word} is not explained");
        }
        assert_axes(browser);
        let is_loaded = "[...document.images].every(it => it.complete && it.naturalWidth > 0)";
        assert_eq!(browser.value(is_loaded), true);

        let picture = browser.picture(None);
        // The lines of the first settings, and the page around them.
        for color in [[57, 119, 214], [224, 140, 20]] {
            assert!(count(&picture, color) > 500, "{color:?}");
        }
        let background = if is_dark { [21, 24, 28] } else { [255, 255, 255] };
        assert!(count(&picture, background) > picture.pixels().len() / 3);
    }
    assert_fits_a_phone(browser, report);
}

/// Each plot has both labels, and at least four values at each axis.
fn assert_axes(browser: &mut Browser) {
    let texts = browser.value("[...document.querySelectorAll('svg')].map(it => [...it.querySelectorAll('text')].map(it => it.textContent.trim()))");
    for plot in texts.as_array().expect("plots") {
        let texts: Vec<&str> = plot.as_array().expect("texts").iter().filter_map(|text| text.as_str()).collect();
        let (numbers, labels): (Vec<&str>, Vec<&str>) = texts.iter().partition(|text| text.parse::<f64>().is_ok());
        assert!(numbers.len() >= 8 && labels.len() == 2, "{texts:?}");
    }
}

/// Nothing is wider than the screen but what scrolls in a box of its own.
fn assert_fits_a_phone(browser: &mut Browser, report: &Path) {
    browser.open(report, PHONE);
    for width in
        ["document.documentElement.scrollWidth", "document.body.scrollWidth", "innerWidth", "visualViewport.width"]
    {
        assert!(browser.number(width) <= 375.0, "{width}: {}", browser.number(width));
    }
    assert_eq!(browser.console(), Vec::<String>::new());
}

/// The slider goes where it is dragged to: left of it is the render, right of it the reference.
fn assert_sliders_move(browser: &mut Browser, report: &Path) {
    const SLIDE: &str = ".slide";
    const INPUT: &str = ".slide input";
    for screen in [DESKTOP, PHONE] {
        browser.open(report, screen);
        let shown = |browser: &mut Browser, from: f64, to: f64| {
            browser.drag(SLIDE, [from, to], screen.is_phone);
            let value = browser.number(&format!("+document.querySelector({INPUT:?}).value"));
            assert!((value - 100.0 * to).abs() < 2.0, "dragged to {to}: {value}");
            let area = browser.area(SLIDE);
            browser.picture(Some(area))
        };
        let middle = shown(browser, 0.5, 0.3);
        let reference = shown(browser, 0.3, 0.0);
        let render = shown(browser, 0.0, 1.0);
        assert_split(&middle, &render, &reference, 0.3);
        // By keys: steps of 0.1 %.
        browser.value(&format!("document.querySelector({INPUT:?}).focus()"));
        let before = browser.number(&format!("+document.querySelector({INPUT:?}).value"));
        browser.press("ArrowLeft", 37);
        assert!(browser.number(&format!("+document.querySelector({INPUT:?}).value")) < before);
        assert_eq!(browser.console(), Vec::<String>::new());
    }
    // Without scripts, both stand side by side.
    browser.open(report, Screen { has_scripts: false, ..DESKTOP });
    let [left, right] = [".slide img", ".slide .reference"].map(|it| browser.area(it));
    assert!(left[0] + left[2] <= right[0] && left[1] == right[1] && left[2] > 100.0, "{left:?} {right:?}");
}

/// Columns to the left of a share of the width are those of one picture, to the right those of another. The line and
/// its handle are left out, as are the names at the lower edge.
fn assert_split(middle: &image::RgbImage, left: &image::RgbImage, right: &image::RgbImage, share: f64) {
    let (width, height) = middle.dimensions();
    assert!(left.dimensions() == (width, height) && right.dimensions() == (width, height));
    let differences = |other: &image::RgbImage, from: f64, to: f64| {
        let columns = (from * f64::from(width)) as u32..(to * f64::from(width)) as u32;
        let at = |x: u32| (0..height * 8 / 10).filter(move |y| middle.get_pixel(x, *y) != other.get_pixel(x, *y));
        columns.flat_map(at).count()
    };
    let handle = 30.0 / f64::from(width);
    assert_eq!(differences(left, handle, share - handle), 0);
    assert_eq!(differences(right, share + handle, 1.0 - handle), 0);
    let all = (width * height) as usize;
    assert!(differences(right, handle, share - handle) > all / 50, "the pictures are the same");
    assert!(differences(left, share + handle, 1.0 - handle) > all / 50, "the pictures are the same");
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
    let mut browser = Browser::start();
    assert_report(&mut browser, &report, 2, &[false, true]);
    assert_sliders_move(&mut browser, &report);

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
    assert_report(&mut Browser::start(), &report, 2, work(&[false][..], &[false, true]));
}

/// Goblet's own reference is rendered for longer than the budget, and the page says whose it is.
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
    // How many it is depends on what else the machine does.
    assert!(results["reference"]["own_iterations"].as_u64() >= Some(1));
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

/// The check itself: a page that asks for something, fails at something and is too wide is found out.
#[test]
fn a_page_that_is_not_self_contained_is_noticed() {
    let bench = Bench::new();
    let wide = "<div style='width:500px'>x</div>";
    let page = "<body><img src=\"http://127.0.0.1:9/a.png\"><script>nothing.here()</script></body>";
    bench.write("page.html", format!("<meta name='viewport' content='width=device-width'>{page}{wide}"));
    let mut browser = Browser::start();
    browser.open(&bench.path("page.html"), PHONE);
    let console = browser.console();
    assert!(console.iter().any(|line| line.contains("nothing is not defined")), "{console:?}");
    let requests = browser.requests();
    assert!(requests.iter().any(|url| url == "http://127.0.0.1:9/a.png"), "{requests:?}");
    assert!(browser.number("document.documentElement.scrollWidth") > 375.0);
}
