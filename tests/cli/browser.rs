//! A headless Chromium that tests steer: by its own protocol (Chrome DevTools Protocol) over two pipes, so that no
//! port is opened and no driver has to have the browser's version.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use tempfile::TempDir;

/// A browser that says nothing for so long has failed. Its answers take milliseconds; its start, seconds.
const PATIENCE: Duration = Duration::from_secs(240);

/// How a page is shown.
#[derive(Clone, Copy)]
pub struct Screen {
    /// Width and height in CSS pixels.
    pub size: [u32; 2],
    /// A phone: touched, and pages say how wide they are.
    pub is_phone: bool,
    pub is_dark: bool,
    pub has_scripts: bool,
}

pub const DESKTOP: Screen = Screen { size: [1400, 3000], is_phone: false, is_dark: false, has_scripts: true };
/// The narrowest phones that are common.
pub const PHONE: Screen = Screen { size: [375, 667], is_phone: true, is_dark: false, has_scripts: true };

/// A browser with one page.
pub struct Browser {
    child: Child,
    commands: ChildStdin,
    messages: Receiver<Value>,
    session: String,
    sent: u64,
    /// What the page reported since it was opened.
    events: Vec<Value>,
    profile: TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        // The folder of the profile goes after the browser.
        let _ = &self.profile;
    }
}

fn program() -> PathBuf {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&folders).flat_map(|folder| names.map(|name| folder.join(name)));
    let installed = "no Chromium: `sh install.sh --tests` installs it";
    found.into_iter().find(|path| path.is_file()).expect(installed)
}

impl Browser {
    pub fn start() -> Self {
        let profile = tempfile::tempdir().expect("a folder");
        // Chromium reads commands from file 3 and writes messages to file 4.
        let mut command = Command::new("sh");
        command.args(["-c", "exec \"$@\" 3<&0 4>&1 </dev/null >&2", "sh"]).arg(program());
        command.args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]);
        command.args(["--disable-background-networking", "--disable-component-update", "--disable-sync"]);
        command.args(["--hide-scrollbars", "--remote-debugging-pipe"]);
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().expect("Chromium");
        let commands = child.stdin.take().expect("a pipe");
        let mut pipe = BufReader::new(child.stdout.take().expect("a pipe"));
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            let mut message = Vec::new();
            while pipe.read_until(0, &mut message).is_ok_and(|length| length > 0) {
                message.pop();
                let parsed = serde_json::from_slice(&message).expect("JSON");
                if sender.send(parsed).is_err() {
                    return;
                }
                message.clear();
            }
        });
        let mut browser =
            Self { child, commands, messages, session: String::new(), sent: 0, events: Vec::new(), profile };
        let target = browser.ask("Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        browser.session =
            browser.ask("Target.attachToTarget", attach)["sessionId"].as_str().expect("a session").to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.ask(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// Sends a command and returns its result.
    fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.sent += 1;
        let mut message = json!({ "id": self.sent, "method": method, "params": parameters });
        if !self.session.is_empty() {
            message["sessionId"] = self.session.as_str().into();
        }
        self.commands.write_all(format!("{message}\0").as_bytes()).expect("a browser that listens");
        loop {
            let message = self.messages.recv_timeout(PATIENCE).unwrap_or_else(|error| panic!("{method}: {error}"));
            if message["id"] == self.sent {
                assert!(message.get("error").is_none(), "{method}: {message}");
                return message["result"].clone();
            }
            self.events.push(message);
        }
    }

    /// Opens a file, and waits until it is there with all that it loads.
    pub fn open(&mut self, file: &Path, screen: Screen) {
        let Screen { size: [width, height], is_phone, is_dark, has_scripts } = screen;
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": is_phone });
        self.ask("Emulation.setDeviceMetricsOverride", metrics);
        self.ask("Emulation.setTouchEmulationEnabled", json!({ "enabled": is_phone }));
        let scheme = json!({ "name": "prefers-color-scheme", "value": if is_dark { "dark" } else { "light" } });
        self.ask("Emulation.setEmulatedMedia", json!({ "features": [scheme] }));
        self.ask("Emulation.setScriptExecutionDisabled", json!({ "value": !has_scripts }));
        self.events.clear();
        let url = format!("file://{}", file.display());
        let answer = self.ask("Page.navigate", json!({ "url": url }));
        assert!(answer.get("errorText").is_none(), "{url}: {answer}");
        while !self.events.iter().any(|event| event["method"] == "Page.loadEventFired") {
            let event = self.messages.recv_timeout(PATIENCE).expect("a page that is loaded");
            self.events.push(event);
        }
    }

    /// The value of an expression on the page.
    pub fn value(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true });
        let answer = self.ask("Runtime.evaluate", parameters);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    pub fn number(&mut self, expression: &str) -> f64 {
        let value = self.value(expression);
        value.as_f64().unwrap_or_else(|| panic!("{expression}: {value}"))
    }

    /// What the page, or the browser about it, has said to the console.
    pub fn console(&mut self) -> Vec<String> {
        // An answer comes after all events before it.
        self.value("0");
        let said = ["Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"];
        let events = self.events.iter().filter(|event| said.iter().any(|method| event["method"] == *method));
        events.map(|event| event["params"].to_string()).collect()
    }

    /// What the page has asked for besides itself and what is in it.
    pub fn requests(&mut self) -> Vec<String> {
        self.value("0");
        let asked = self.events.iter().filter(|event| event["method"] == "Network.requestWillBeSent");
        // The page itself is a document.
        let asked = asked.filter(|event| event["params"]["type"] != "Document");
        let urls = asked.filter_map(|event| event["params"]["request"]["url"].as_str());
        urls.filter(|url| !url.starts_with("data:")).map(str::to_owned).collect()
    }

    /// The box of an element in CSS pixels of the page: left, top, width, height.
    pub fn area(&mut self, selector: &str) -> [f64; 4] {
        let rectangle = format!("document.querySelector({selector:?}).getBoundingClientRect()");
        let values = self.value(&format!("(r => [r.left + scrollX, r.top + scrollY, r.width, r.height])({rectangle})"));
        [0, 1, 2, 3].map(|i| values[i].as_f64().expect("a number"))
    }

    /// A picture of a part of the page, or of the window.
    pub fn picture(&mut self, area: Option<[f64; 4]>) -> image::RgbImage {
        let mut parameters = json!({ "format": "png" });
        if let Some([x, y, width, height]) = area {
            parameters["clip"] = json!({ "x": x, "y": y, "width": width, "height": height, "scale": 1 });
            parameters["captureBeyondViewport"] = true.into();
        }
        let answer = self.ask("Page.captureScreenshot", parameters);
        let bytes = STANDARD.decode(answer["data"].as_str().expect("a picture")).expect("base64");
        image::load_from_memory(&bytes).expect("PNG").into_rgb8()
    }

    /// Scrolls to an element, and drags from one place on it to another: shares of its width, half way down. By
    /// finger on a phone.
    pub fn drag(&mut self, selector: &str, [from, to]: [f64; 2], is_phone: bool) {
        self.value(&format!("document.querySelector({selector:?}).scrollIntoView({{ block: 'center' }})"));
        let [left, top, width, height] = self.area(selector);
        let scrolled = self.value("[scrollX, scrollY]");
        let [x, y] = [left - scrolled[0].as_f64().unwrap_or(0.0), top - scrolled[1].as_f64().unwrap_or(0.0)];
        let place = |share: f64| [x + share * width, y + 0.5 * height];
        let steps = 8;
        for step in 0..=steps + 1 {
            let share = from + (to - from) * f64::from(step.min(steps)) / f64::from(steps);
            let [x, y] = place(share);
            if is_phone {
                let kind = ["touchStart", "touchMove", "touchEnd"][usize::from(step > 0) + usize::from(step > steps)];
                let points = if step > steps { json!([]) } else { json!([{ "x": x, "y": y }]) };
                self.ask("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
            } else {
                let kind =
                    ["mousePressed", "mouseMoved", "mouseReleased"][usize::from(step > 0) + usize::from(step > steps)];
                let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1 });
                self.ask("Input.dispatchMouseEvent", event);
            }
        }
    }

    /// Presses a key, by its name and its code in Windows.
    pub fn press(&mut self, key: &str, code: u32) {
        for kind in ["rawKeyDown", "keyUp"] {
            let event = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code });
            self.ask("Input.dispatchKeyEvent", event);
        }
    }
}
