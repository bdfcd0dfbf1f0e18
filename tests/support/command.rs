//! The command as people run it, in a folder of its own.

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use goblet::image::file;
use goblet::image::film::Image;
use serde_json::Value;
use tempfile::TempDir;

/// A glass ball on a floor before a wall, lit by a point. Tests replace parts of it.
pub const SCENE: &str = r#"Film "rgb" "integer xresolution" 16 "integer yresolution" 12 "string filename" "default.exr"
LookAt 0 0 -3  0 0 0  0 1 0
Camera "perspective" "float fov" 60
Sampler "independent" "integer pixelsamples" 2
Integrator "sppm" "integer maxdepth" 6 "integer photonsperiteration" 500 "float radius" 0.5
WorldBegin
LightSource "point" "point3 from" [ 0 1.5 -1 ] "rgb I" [ 5 5 5 ]
Material "diffuse"
Shape "trianglemesh" "integer indices" [ 0 2 1 0 3 2 3 5 4 3 4 2 ] "point3 P" [ -2 -1 -2  2 -1 -2  2 -1 2  -2 -1 2  2 2 2  -2 2 2 ]
AttributeBegin
Material "dielectric"
Shape "sphere" "float radius" 0.5
AttributeEnd
"#;

/// The variable that names the folder for compiled kernels; empty for none.
pub const CACHE: &str = "GOBLET_CACHE";

/// The light of [`SCENE`].
pub const LIGHT: &str = r#"LightSource "point" "point3 from" [ 0 1.5 -1 ] "rgb I" [ 5 5 5 ]"#;

/// [`SCENE`] with `from` replaced, which it must have.
pub fn scene(from: &str, to: &str) -> String {
    assert!(SCENE.contains(from), "the scene has no `{from}`");
    SCENE.replace(from, to)
}

/// The program goblet: that of the build, or the one that is carried with the tests.
pub fn goblet() -> PathBuf {
    std::env::var_os("CARGO_BIN_EXE_goblet").unwrap_or_else(|| env!("CARGO_BIN_EXE_goblet").into()).into()
}

/// Keeps goblet from what is around the tests: they may themselves be run in an array job, and the user's cache
/// is not theirs.
pub fn isolate(command: &mut Command) {
    command.env(CACHE, "");
    for index in ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX", "AWS_BATCH_JOB_ARRAY_INDEX"] {
        command.env_remove(index);
    }
}

/// A folder to run in, with `scene.pbrt` in it.
pub struct Bench(pub TempDir);

/// What a run left behind.
#[derive(Debug)]
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Bench {
    pub fn new() -> Self {
        let bench = Self(tempfile::tempdir().unwrap());
        bench.write("scene.pbrt", SCENE);
        bench
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, contents).unwrap();
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).expect("UTF-8")
    }

    /// The names of all files here, in order.
    pub fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// goblet, to be run here.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(goblet());
        command.args(arguments).current_dir(self.0.path()).stdin(Stdio::null());
        isolate(&mut command);
        command
    }

    /// Runs goblet here. It never panics, whatever it is given.
    pub fn run(&self, arguments: &[&str]) -> Run {
        Run::of(self.command(arguments).output().unwrap())
    }

    pub fn render(&self, arguments: &[&str]) -> Run {
        self.run(&[&["render", "scene.pbrt"], arguments].concat())
    }

    /// Runs what must succeed.
    pub fn rendered(&self, arguments: &[&str]) -> Run {
        let run = self.render(arguments);
        assert_eq!(run.code, 0, "{arguments:?}: {}", run.stderr);
        run
    }

    pub fn image(&self, name: &str) -> Image {
        file::read(&self.path(name)).unwrap()
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }
}

impl Run {
    /// What a process left, which exited by itself.
    pub fn of(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        let code = output.status.code().expect("an exit code");
        let run = Self { code, stdout: text(output.stdout), stderr: text(output.stderr) };
        assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
        run
    }

    /// Fails unless goblet stopped with this code and these words, and printed nothing else.
    pub fn assert_refused(&self, case: &str, code: i32, words: &[&str]) {
        assert_eq!(self.code, code, "{case}: {self:?}");
        assert_eq!(self.stdout, "", "{case}");
        for word in words {
            assert!(self.stderr.contains(word), "{case}: expected `{word}` in: {}", self.stderr);
        }
    }
}

/// Waits for what another process does.
pub fn wait_until(what: &str, holds: impl Fn() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < Duration::from_secs(300), "waited in vain until {what}");
        sleep(Duration::from_millis(2));
    }
}

/// Sends a signal, as `-TERM`.
pub fn send(signal: &str, child: &Child) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}
