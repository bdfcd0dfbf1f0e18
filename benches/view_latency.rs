//! Measures how long `goblet view` lets its user wait: the camera moves for ten seconds, and the
//! window's `--stats` are printed. Writes a picture of each window after a minute or more:
//! `cargo bench --bench view_latency -- OUT_DIR`
//!
//! Needs Xvfb, and a machine that does nothing else. Takes seven minutes.

#[path = "../tests/view/desktop.rs"]
mod desktop;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::thread::sleep;
use std::time::Duration;

use desktop::Desktop;

const ONE: u32 = '1' as u32;
const FIVE: u32 = '5' as u32;
const R: u32 = 'r' as u32;

/// A scene, the size of its image, the key of what is shown in the end, and the seconds until the
/// picture is taken.
const WINDOWS: [(&str, &str, u32, u64); 3] =
    [("cornell-caustic", "720x540", FIVE, 60), ("wine-cup", "1280x720", ONE, 90), ("wine-cup", "840x520", ONE, 200)];

fn main() -> ExitCode {
    // Cargo adds `--bench`.
    let Some(folder) = std::env::args_os().skip(1).find(|word| word != "--bench").map(PathBuf::from) else {
        eprintln!("usage: cargo bench --bench view_latency -- OUT_DIR");
        return ExitCode::from(2);
    };
    fs::create_dir_all(&folder).expect("a folder");
    for (name, resolution, key, patience) in WINDOWS {
        let path = |extension: &str| folder.join(format!("{name}-{resolution}.{extension}"));
        measure(name, resolution, key, Duration::from_secs(patience), &path("json"), &path("png"));
        println!("{name}, {resolution}: {}", fs::read_to_string(path("json")).expect("statistics"));
    }
    ExitCode::SUCCESS
}

fn measure(scene: &str, resolution: &str, key: u32, patience: Duration, stats: &Path, picture: &Path) {
    let mut desktop = Desktop::new();
    let mut command = Command::new(env!("CARGO_BIN_EXE_goblet"));
    command.arg("view").arg(format!("{}/scenes/{scene}.pbrt", env!("CARGO_MANIFEST_DIR")));
    command.args(["--resolution", resolution, "--quiet", "--stats"]).arg(stats);
    command.env("DISPLAY", desktop.name()).env_remove("WAYLAND_DISPLAY").stdout(Stdio::null());
    let mut child = command.spawn().expect("goblet");
    desktop.find_window();
    sleep(Duration::from_secs(5));
    // To and fro, so that the camera stays in the room.
    let swing = |i: i16| [600 + ((f32::from(i) * 0.03).sin() * 25.0) as i16, 400 + (i % 20 - 10).abs()];
    desktop.drag((0..1000).map(swing), Duration::from_millis(10));
    desktop.press(&[R]);
    desktop.press(&[key]);
    sleep(patience);
    desktop.shot().save(picture);
    desktop.close();
    assert!(child.wait().expect("an end").success());
}
