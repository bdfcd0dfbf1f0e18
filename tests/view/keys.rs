//! Every key of the window's list has an effect that is seen in its pixels, and is one of the effects that the list
//! names. The keys come from the program's own table, so a new one is tested too.

use std::path::Path;
use std::time::Duration;

use goblet::viewer::key_list;

use crate::desktop::{Desktop, Shot, wait_or};
use crate::{CONTROL, PANEL, finish, scene, view};

const SHIFT: u32 = 0xffe1;
const ALT: u32 = 0xffe9;

/// Where a key has its effect.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    /// On the image.
    Image,
    /// In the panel.
    Panel,
}

/// Returns the symbols of keys that are pressed together, as in "Ctrl+Shift+S".
fn symbols(name: &str) -> Vec<u32> {
    let one = |name: &str| match name {
        "Ctrl" => CONTROL,
        "Shift" => SHIFT,
        "space" => ' '.into(),
        "Esc" => 0xff1b,
        "F1" => 0xffbe,
        "left" => 0xff51,
        "up" => 0xff52,
        "right" => 0xff53,
        "down" => 0xff54,
        "PageUp" => 0xff55,
        "PageDown" => 0xff56,
        name => name.to_lowercase().chars().next().filter(|_| name.len() == 1).expect(name).into(),
    };
    // On keyboards of the X server, plus is above the equals sign.
    if name == "+" { vec![SHIFT, '+'.into()] } else { name.split('+').map(one).collect() }
}

/// Returns the keys that bring the window to a state in which a key has its effect, after the keys before it in the list,
/// and where that is seen.
fn before(name: &str) -> (&'static [&'static str], Seen) {
    match name {
        "Ctrl+Shift+Z" => (&["Ctrl+Z"], Seen::Image),
        "X" => (&["+"], Seen::Image),
        "1" => (&["5"], Seen::Image),
        "O" => (&["1"], Seen::Image),
        "B" => (&["D"], Seen::Image),
        "C" | "K" | "Ctrl+B" | "space" | "Ctrl+S" | "Ctrl+Shift+S" | "Ctrl+O" => (&[], Seen::Panel),
        _ => (&[], Seen::Image),
    }
}

/// Returns the pixels of a part of the window.
fn part(shot: &Shot, seen: Seen) -> Vec<[u8; 3]> {
    let rows = shot.pixels.chunks_exact(shot.width as usize);
    let panel = PANEL as usize;
    rows.flat_map(|row| if seen == Seen::Panel { &row[..panel] } else { &row[panel..] }).copied().collect()
}

/// Waits until the window is at rest, and returns what it shows.
fn rest(desktop: &Desktop, context: &str) -> Shot {
    let is_at_rest = || {
        let title = desktop.title();
        let shot = desktop.shot();
        std::thread::sleep(Duration::from_millis(120));
        let is_quiet = title.contains("- all iterations done -") || title.contains("- paused -");
        (is_quiet && desktop.shot().pixels == shot.pixels).then_some(shot)
    };
    wait_or(is_at_rest, || panic!("{context}: no rest in {}", desktop.title()))
}

/// Presses a key at rest, and waits for its effect.
fn press(desktop: &Desktop, name: &str, seen: Seen) {
    let before = part(&rest(desktop, name), seen);
    desktop.press(&symbols(name));
    let has_changed = || (part(&desktop.shot(), seen) != before).then_some(());
    wait_or(has_changed, || {
        let shot = Path::new(env!("CARGO_TARGET_TMPDIR")).join("key.png");
        desktop.shot().save(&shot);
        panic!("{name} has no effect: {}", shot.display())
    });
}

#[test]
fn every_key_of_the_list_has_an_effect() {
    let folder = tempfile::tempdir().expect("a folder");
    let saved = folder.path().join("saved.exr");
    let [scene, saved_text] = [scene(), saved.clone()].map(|path| path.to_str().expect("a path").to_owned());
    let mut desktop = Desktop::new();
    let options = ["--resolution", "96x96", "-o", &saved_text, "--iterations", "1", "--photons", "2000"];
    let child = view(&desktop, &[&[scene.as_str()], &options[..], &["--max-depth", "5", "--validate"]].concat());
    desktop.find_window();
    desktop.resize(640, 700);
    desktop.point([450, 350]);
    press(&desktop, "W", Seen::Image);
    let quiet = rest(&desktop, "a key without an effect");
    desktop.press(&['j'.into()]);
    std::thread::sleep(Duration::from_millis(400));
    assert!(desktop.shot().pixels == quiet.pixels, "J has no effect");

    let keys = key_list();
    let (last, keys) = keys.split_last().expect("keys");
    for (names, help) in keys {
        for name in names.split(" or ") {
            let (needed, seen) = before(name);
            needed.iter().for_each(|name| press(&desktop, name, Seen::Image));
            press(&desktop, name, seen);
            assert!(!help.is_empty());
            if name == "Ctrl+S" {
                rest(&desktop, name);
                assert!(saved.exists(), "{name}");
            }
            if name == "H" {
                press(&desktop, name, Seen::Panel);
            }
        }
    }
    // The list is open. Esc closes it, and then the window.
    assert_eq!(last.0, "Esc");
    press(&desktop, "Esc", Seen::Image);
    rest(&desktop, "Esc");
    desktop.press(&symbols("Esc"));
    finish(child);
}

/// Does something at rest, and waits until the image has changed.
fn changes(desktop: &Desktop, what: &str, act: impl FnOnce()) {
    let before = part(&rest(desktop, what), Seen::Image);
    act();
    wait_or(|| (part(&desktop.shot(), Seen::Image) != before).then_some(()), || panic!("{what} has no effect"));
}

/// Returns whether the image consists of squares of a size, except for those that are cut off at the edges.
fn has_squares(shot: &Shot, side: usize) -> bool {
    let rows: Vec<&[[u8; 3]]> =
        shot.pixels.chunks_exact(shot.width as usize).map(|row| &row[PANEL as usize..]).collect();
    let row = rows[rows.len() / 2];
    let edges: Vec<usize> = (1..row.len()).filter(|x| row[*x] != row[x - 1]).collect();
    edges.len() > 4 && edges.iter().all(|edge| edge % side == edges[0] % side)
}

#[test]
fn the_mouse_enlarges_and_moves_the_image_and_the_line_between_two() {
    let scene = scene();
    let scene = scene.to_str().expect("a path");
    let mut desktop = Desktop::new();
    let options = ["--resolution", "96x96", "--iterations", "1", "--photons", "2000", "--max-depth", "5", "--validate"];
    let child = view(&desktop, &[&[scene], &options[..]].concat());
    desktop.find_window();
    desktop.resize(640, 700);
    desktop.point([450, 350]);
    let whole = rest(&desktop, "the whole image");
    changes(&desktop, "Alt and the wheel", || desktop.with_key(ALT, || desktop.turn(6)));
    let enlarged = rest(&desktop, "the enlarged image");
    assert!(enlarged.pixels != whole.pixels);
    desktop.press(&symbols("F"));
    // Keys enlarge to whole squares.
    for _ in 0..3 {
        press(&desktop, "+", Seen::Image);
    }
    assert!(has_squares(&rest(&desktop, "squares"), 8), "8 pixels for each");
    changes(&desktop, "the middle button", || {
        desktop.drag_by(2, [[450, 350], [460, 355], [482, 366]], Duration::from_millis(30));
    });
    desktop.point([450, 350]);
    press(&desktop, "F", Seen::Image);
    assert!(part(&rest(&desktop, "F"), Seen::Image) == part(&whole, Seen::Image), "the whole image again");

    press(&desktop, "K", Seen::Panel);
    press(&desktop, "D", Seen::Image);
    press(&desktop, "V", Seen::Image);
    let middle = PANEL as i16 + (640 - PANEL as i16) / 2;
    changes(&desktop, "the line", || {
        desktop.drag((0..20).map(|step| [middle - 2 * step, 500]), Duration::from_millis(20));
    });
    desktop.close();
    finish(child);
}
