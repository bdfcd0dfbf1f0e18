//! A display of its own, and a hand at its mouse and keyboard.
#![allow(dead_code, reason = "the test and the measurement use a part of this each")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ClientMessageEvent, ConfigureWindowAux, ConnectionExt as _,
    EventMask, ImageFormat, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// A condition that does not hold after this time is taken to hold never, on any machine.
const PATIENCE: Duration = Duration::from_secs(300);

/// An X server without a screen, and a program's window on it.
pub struct Desktop {
    server: Child,
    name: String,
    connection: RustConnection,
    root: Window,
    window: Window,
}

/// Rows of pixels: red, green, blue.
pub struct Shot {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[u8; 3]>,
}

impl Shot {
    /// The middle of what is to the right of a panel, of this size; none if there is no room.
    pub fn middle(&self, panel: u32, [width, height]: [u32; 2]) -> Option<Vec<[u8; 3]>> {
        let x = panel + self.width.checked_sub(panel)?.checked_sub(width)? / 2;
        let y = self.height.checked_sub(height)? / 2;
        let row = |y: u32| {
            let first = (y * self.width + x) as usize;
            &self.pixels[first..first + width as usize]
        };
        Some((y..y + height).map(row).collect::<Vec<_>>().concat())
    }

    /// Writes a PNG.
    pub fn save(&self, path: &Path) {
        let bytes = self.pixels.concat();
        image::save_buffer(path, &bytes, self.width, self.height, image::ColorType::Rgb8).expect("a file");
    }
}

impl Desktop {
    /// Starts the server.
    pub fn new() -> Self {
        let mut command = Command::new("Xvfb");
        command.args(["-displayfd", "1", "-screen", "0", "1600x900x24", "-nolisten", "tcp"]);
        let spawned = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let mut server = spawned.unwrap_or_else(|error| panic!("no Xvfb ({error}): apt-get install xvfb"));
        let mut number = String::new();
        BufReader::new(server.stdout.take().expect("its output")).read_line(&mut number).expect("a display");
        let name = format!(":{}", number.trim());
        let (connection, screen) = x11rb::connect(Some(&name)).expect("a connection");
        let root = connection.setup().roots[screen].root;
        Self { server, name, connection, root, window: root }
    }

    /// As `DISPLAY` has it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Waits for the program's window.
    pub fn find_window(&mut self) {
        self.window = wait_for("a window", || {
            let children = self.connection.query_tree(self.root).ok()?.reply().ok()?.children;
            children.into_iter().find(|window| self.title_of(*window).is_some_and(|title| title.ends_with("goblet")))
        });
        self.connection.set_input_focus(InputFocus::PARENT, self.window, x11rb::CURRENT_TIME).expect("focus");
        self.connection.flush().expect("a connection");
    }

    /// The title of the window.
    pub fn title(&self) -> String {
        self.title_of(self.window).unwrap_or_default()
    }

    fn title_of(&self, window: Window) -> Option<String> {
        let property = self.connection.get_property(false, window, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 64).ok()?;
        String::from_utf8(property.reply().ok()?.value).ok()
    }

    /// Moves the mouse without a button.
    pub fn point(&self, place: [i16; 2]) {
        self.input(MOTION_NOTIFY_EVENT, 0, place);
    }

    /// Turns the wheel by notches, away from the hand.
    pub fn turn(&self, notches: u32) {
        for _ in 0..notches {
            self.input(BUTTON_PRESS_EVENT, 4, [0, 0]);
            self.input(BUTTON_RELEASE_EVENT, 4, [0, 0]);
        }
    }

    /// Holds a key down while something is done.
    pub fn with_key(&self, symbol: u32, act: impl FnOnce()) {
        let code = self.key_code(symbol);
        self.input(KEY_PRESS_EVENT, code, [0, 0]);
        act();
        std::thread::sleep(Duration::from_millis(200));
        self.input(KEY_RELEASE_EVENT, code, [0, 0]);
    }

    /// What the window shows.
    pub fn shot(&self) -> Shot {
        let geometry = self.connection.get_geometry(self.window).expect("a request").reply().expect("a geometry");
        let (width, height) = (geometry.width, geometry.height);
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, self.window, 0, 0, width, height, u32::MAX);
        let data = image.expect("a request").reply().expect("an image").data;
        let pixels = data.chunks_exact(4).map(|bgrx| [bgrx[2], bgrx[1], bgrx[0]]).collect();
        Shot { width: width.into(), height: height.into(), pixels }
    }

    fn input(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) {
        self.connection.xtest_fake_input(kind, detail, x11rb::CURRENT_TIME, self.root, x, y, 0).expect("an event");
        self.connection.flush().expect("a connection");
    }

    /// Presses the left button and moves it along a path.
    pub fn drag(&self, path: impl IntoIterator<Item = [i16; 2]>, between: Duration) {
        self.drag_by(1, path, between);
    }

    /// Presses a button (1 is the left one, 2 the middle one) and moves it along a path.
    pub fn drag_by(&self, button: u8, path: impl IntoIterator<Item = [i16; 2]>, between: Duration) {
        let mut path = path.into_iter();
        self.input(MOTION_NOTIFY_EVENT, 0, path.next().expect("a start"));
        self.input(BUTTON_PRESS_EVENT, button, [0, 0]);
        for place in path {
            std::thread::sleep(between);
            self.input(MOTION_NOTIFY_EVENT, 0, place);
        }
        self.input(BUTTON_RELEASE_EVENT, button, [0, 0]);
    }

    /// Presses keys together, as a hand does.
    pub fn press(&self, symbols: &[u32]) {
        self.press_for(symbols, Duration::from_millis(50));
    }

    /// Presses keys together, and lets them go at once.
    pub fn strike(&self, symbols: &[u32]) {
        self.press_for(symbols, Duration::ZERO);
    }

    fn press_for(&self, symbols: &[u32], time: Duration) {
        let codes: Vec<u8> = symbols.iter().map(|symbol| self.key_code(*symbol)).collect();
        codes.iter().for_each(|code| self.input(KEY_PRESS_EVENT, *code, [0, 0]));
        std::thread::sleep(time);
        codes.iter().rev().for_each(|code| self.input(KEY_RELEASE_EVENT, *code, [0, 0]));
    }

    fn key_code(&self, symbol: u32) -> u8 {
        let setup = self.connection.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let mapping = self.connection.get_keyboard_mapping(first, last - first + 1).expect("a request");
        let mapping = mapping.reply().expect("a mapping");
        let each = usize::from(mapping.keysyms_per_keycode);
        let place = mapping.keysyms.chunks(each).position(|symbols| symbols.contains(&symbol));
        first + place.expect("a key") as u8
    }

    /// Gives the window another size.
    pub fn resize(&self, width: u32, height: u32) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.connection.configure_window(self.window, &size).expect("a request");
        self.connection.flush().expect("a connection");
    }

    /// Closes the window as a desktop does.
    pub fn close(&self) {
        let atom =
            |name: &[u8]| self.connection.intern_atom(false, name).expect("a request").reply().expect("an atom").atom;
        let data = [atom(b"WM_DELETE_WINDOW"), x11rb::CURRENT_TIME, 0, 0, 0];
        let message = ClientMessageEvent::new(32, self.window, atom(b"WM_PROTOCOLS"), data);
        self.connection.send_event(false, self.window, EventMask::NO_EVENT, message).expect("a request");
        self.connection.flush().expect("a connection");
    }
}

impl Drop for Desktop {
    fn drop(&mut self) {
        // It has nothing to lose.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Asks again and again until there is an answer.
pub fn wait_for<T>(what: &str, ask: impl FnMut() -> Option<T>) -> T {
    wait_or(ask, || panic!("waited in vain for {what}"))
}

/// As [`wait_for`], with something else to do in the end.
pub fn wait_or<T>(mut ask: impl FnMut() -> Option<T>, fail: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        if let Some(answer) = ask() {
            return answer;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    fail()
}
