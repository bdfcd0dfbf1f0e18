//! `goblet view` in a window of its own, by mouse and keyboard: what it shows and saves is what
//! `goblet render` writes.
#![cfg(feature = "view")]

mod desktop;
mod keys;
#[path = "../support/mod.rs"]
mod support;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use desktop::{Desktop, Shot, wait_for, wait_or};

const CONTROL: u32 = 0xffe3;
const ESCAPE: u32 = 0xff1b;
const TAB: u32 = 0xff09;
const SPACE: u32 = ' ' as u32;
const H: u32 = 'h' as u32;
const ONE: u32 = '1' as u32;
const FIVE: u32 = '5' as u32;
const SEVEN: u32 = '7' as u32;
const EIGHT: u32 = '8' as u32;
const NINE: u32 = '9' as u32;
const ZERO: u32 = '0' as u32;
const R: u32 = 'r' as u32;
const S: u32 = 's' as u32;

fn goblet() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_goblet"));
    support::command::isolate(&mut command);
    command
}

fn scene() -> PathBuf {
    support::root().join("scenes/cornell-caustic.pbrt")
}

/// Of both commands.
const OPTIONS: [&str; 9] =
    ["--iterations", "3", "--photons", "4000", "--eye-paths", "2", "--max-depth", "6", "--validate"];

/// What `goblet render` makes of the scene. The window takes no guide, and files say so.
fn rendered(scene: &Path, resolution: &str, path: &Path) {
    let mut command = goblet();
    command
        .arg("render")
        .arg(scene)
        .args(OPTIONS)
        .args(["--resolution", resolution, "--guide", "off", "--quiet", "-o"])
        .arg(path);
    assert!(command.status().expect("goblet").success());
}

fn view(desktop: &Desktop, options: &[&str]) -> Child {
    let mut command = goblet();
    command.arg("view").args(options).env("DISPLAY", desktop.name()).env_remove("WAYLAND_DISPLAY");
    // Else a desktop on which the tests run would show dialogs, and wait for an answer.
    command.env("DBUS_SESSION_BUS_ADDRESS", "unix:path=/nonexistent").env("PATH", "");
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("goblet")
}

/// Width of the panel.
const PANEL: u32 = 280;

/// The largest difference of the middle of a shot, to the right of a panel of this width, from a
/// picture in a file; none if there is no room for it.
fn difference(shot: &Shot, panel: u32, path: &Path) -> Option<u8> {
    let picture = image::open(path).expect("a picture").into_rgb8();
    let (width, height) = picture.dimensions();
    let part = shot.middle(panel, [width, height])?;
    part.iter().flatten().zip(picture.as_raw()).map(|(a, b)| a.abs_diff(*b)).max()
}

/// Waits until the window shows what a file has, pixel by pixel but for roundings, in the middle of
/// what the panel leaves.
fn shows(desktop: &Desktop, path: &Path) {
    shows_beside(desktop, 0, path);
}

fn shows_beside(desktop: &Desktop, panel: u32, path: &Path) {
    let is_shown = || difference(&desktop.shot(), panel, path).is_some_and(|most| most <= 1).then_some(());
    wait_or(is_shown, || {
        let shot = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view.png");
        desktop.shot().save(&shot);
        panic!("{} does not show {}", shot.display(), path.display())
    });
}

/// Whether a square picture beside the panel is in false colours: what is not black has colours far from grey. After few
/// photons, most may be black.
fn is_in_false_colors(desktop: &Desktop, side: u32) -> bool {
    let part = desktop.shot().middle(PANEL, [side, side]).unwrap_or_default();
    let ends = |color: &[u8; 3]| (*color.iter().min().expect("red"), *color.iter().max().expect("red"));
    let lit: Vec<(u8, u8)> = part.iter().map(ends).filter(|(_, most)| *most > 20).collect();
    let far = lit.iter().filter(|(least, most)| most - least > 60).count();
    20 * lit.len() > part.len() && 10 * far > 9 * lit.len()
}

fn finish(child: Child) {
    let output = child.wait_with_output().expect("an end");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.is_empty() && output.stdout.is_empty(), "{}: {said}", output.status);
}

#[test]
fn a_window_shows_and_saves_what_goblet_render_writes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let names = ["first.png", "second.png", "third.png", "expected.exr", "saved.exr", "stats.json"].map(path);
    let [first, second, third, expected, saved, stats] = &names;
    let text = fs::read_to_string(scene()).expect("a scene");
    let [file, other] = ["scene.pbrt", "other.pbrt"].map(path);
    let from_further = text.replace("\"float fov\" 30", "\"float fov\" 45");
    assert_ne!(from_further, text);
    fs::write(&file, text).expect("a file");
    fs::write(&other, &from_further).expect("a file");
    rendered(&file, "160x120", first);
    rendered(&file, "160x120", expected);
    rendered(&file, "131x150", second);
    rendered(&other, "131x150", third);

    let mut desktop = Desktop::new();
    let text = |path: &Path| path.to_str().expect("a path").to_owned();
    let (file_text, saved_text, stats_text) = (text(&file), text(saved), text(stats));
    let own = [&file_text, "--resolution", "160x120", "-o", &saved_text, "--stats", &stats_text];
    let child = view(&desktop, &[&own[..], &OPTIONS].concat());
    desktop.find_window();
    shows_beside(&desktop, PANEL, first);
    desktop.press(&[H]);
    shows(&desktop, first);

    desktop.press(&[CONTROL, S]);
    wait_for("a file", || saved.exists().then_some(()));
    assert!(fs::read(saved).expect("a file") == fs::read(expected).expect("a file"), "the same bytes");

    desktop.drag((0..30).map(|i| [40 + 2 * i, 60]), Duration::from_millis(10));
    wait_for("another view", || difference(&desktop.shot(), 0, first).is_some_and(|most| most > 40).then_some(()));
    desktop.press(&[R]);
    shows(&desktop, first);

    desktop.press(&[SEVEN]);
    // The back wall faces the camera: no normal is as dark as what it shows of light.
    let normals = || difference(&desktop.shot(), 0, first).filter(|most| *most > 100);
    wait_for("normals", normals);
    desktop.press(&[ONE]);
    shows(&desktop, first);

    desktop.resize(200, 90);
    desktop.resize(131, 150);
    shows(&desktop, second);
    let shot = desktop.shot();
    assert_eq!((shot.width, shot.height), (131, 150), "it fills the window");

    fs::write(&file, "LookAt oops").expect("a file");
    std::thread::sleep(Duration::from_millis(1200));
    shows(&desktop, second);
    fs::write(&file, from_further).expect("a file");
    shows(&desktop, third);

    desktop.close();
    finish(child);
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(stats).expect("a file")).expect("JSON");
    // Nine pictures were waited for above, each in a frame of its own.
    assert!(stats["frames"].as_u64() >= Some(9) && stats["iterations"] == 3, "{stats}");
    for times in ["input_to_frame", "move_to_picture"] {
        assert!(stats[times]["count"].as_u64() >= Some(1), "{stats}");
    }
}

/// Saves to a file that is there: it is kept, and the image gets a number in its name.
fn saves_beside(desktop: &Desktop, saved: &Path, expected: &Path) {
    fs::write(saved, "mine").expect("a file");
    desktop.strike(&[CONTROL, S]);
    let numbered = saved.with_file_name("saved-2.png");
    wait_for("a file", || numbered.exists().then_some(()));
    std::thread::sleep(Duration::from_millis(100));
    assert!(fs::read(&numbered).expect("a file") == fs::read(expected).expect("a file"), "the same bytes");
    assert_eq!(fs::read(saved).expect("a file"), b"mine");
    fs::remove_file(saved).expect("a file");
}

/// A film of 128x128 has a window in which both it and the panel can be seen, and a paused image
/// is saved as it is shown wherever the camera has gone.
#[test]
fn a_small_film_has_a_usable_window_and_what_is_saved_is_what_is_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let [expected, saved] = ["expected.png", "saved.png"].map(|name| folder.path().join(name));
    rendered(&scene(), "128x128", &expected);
    let mut desktop = Desktop::new();
    let [scene, saved_text] = [scene(), saved.clone()].map(|path| path.to_str().expect("a path").to_owned());
    let child = view(&desktop, &[&[&scene, "--resolution", "128x128", "-o", &saved_text], &OPTIONS[..]].concat());
    desktop.find_window();
    let shot = desktop.shot();
    assert!(shot.width >= PANEL + 128 && shot.height >= 300, "{}x{}", shot.width, shot.height);
    shows_beside(&desktop, PANEL, &expected);

    // A widget has the focus, and shows it: Esc is for it, and so is what is typed.
    let before = desktop.shot();
    desktop.press(&[TAB]);
    wait_for("a widget with the focus", || (desktop.shot().pixels != before.pixels).then_some(()));
    desktop.press(&[H]);
    desktop.press(&[ESCAPE]);
    std::thread::sleep(Duration::from_millis(200));
    shows_beside(&desktop, PANEL, &expected);

    // However quickly, it is no flight backwards, and none is lost.
    for _ in 0..10 {
        desktop.strike(&[CONTROL, S]);
        wait_for("a file", || saved.exists().then_some(()));
        std::thread::sleep(Duration::from_millis(100));
        assert!(fs::read(&saved).expect("a file") == fs::read(&expected).expect("a file"), "the same bytes");
        fs::remove_file(&saved).expect("a file");
    }
    saves_beside(&desktop, &saved, &expected);
    shows_beside(&desktop, PANEL, &expected);

    desktop.press(&[SPACE]);
    desktop.press(&[EIGHT]);
    let depths = || difference(&desktop.shot(), PANEL, &expected).filter(|most| *most > 60);
    wait_for("depths", depths);
    for key in [FIVE, NINE, ZERO] {
        desktop.press(&[ONE]);
        shows_beside(&desktop, PANEL, &expected);
        assert!(!is_in_false_colors(&desktop, 128), "the image shows nothing");
        desktop.press(&[key]);
        let is_shown = || is_in_false_colors(&desktop, 128).then_some(());
        wait_or(is_shown, || {
            let shot = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view.png");
            desktop.shot().save(&shot);
            panic!("{} shows no false colours", shot.display())
        });
    }
    desktop.press(&[ONE]);
    shows_beside(&desktop, PANEL, &expected);
    desktop.drag((0..20).map(|i| [360 + 2 * i, 240]), Duration::from_millis(10));
    desktop.strike(&[CONTROL, S]);
    wait_for("a file", || saved.exists().then_some(()));
    assert!(image::open(&saved).expect("a picture").into_rgb8().as_raw().iter().any(|value| *value > 100));
    assert!(fs::read(&saved).expect("a file") != fs::read(&expected).expect("a file"), "it has moved");
    shows_beside(&desktop, PANEL, &saved);

    desktop.press(&[ESCAPE]);
    finish(child);
}

#[test]
fn without_a_display_there_is_a_clear_message() {
    let mut command = goblet();
    command.arg("view").arg(scene()).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    let output = command.env_remove("WAYLAND_SOCKET").output().expect("goblet");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("goblet: cannot open a window") && said.contains("goblet render"), "{said}");
}

#[test]
fn what_is_of_long_renders_is_refused() {
    for options in [["--time", "5"], ["--resume", "x.checkpoint"], ["--target-error", "0.1"]] {
        let output = goblet().arg("view").arg(scene()).args(options).output().expect("goblet");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(options[0]) && said.contains("goblet render"), "{said}");
    }
}
