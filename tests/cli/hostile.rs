//! Small files that ask for any amount of memory or time: each ends in an error that says where and
//! what, or in a right result, in little memory.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::Write as _;
use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use flate2::Compression;
use flate2::write::GzEncoder;
use tempfile::TempDir;

use crate::support::command::CACHE;

/// Address space of a process, KiB, as of a small machine.
const MOST_ADDRESSES: u32 = 8_000_000;
/// Memory that may really be in use at once, KiB.
const MOST_MEMORY: u64 = 2_000_000;
/// CPU seconds of a process, over all threads: the system kills one that takes more. A busy machine
/// does not add to them.
const MOST_SECONDS: u32 = 60;
/// A process that waits for ever takes no CPU seconds.
const WATCHDOG: Duration = Duration::from_secs(1800);
/// What begins a scene.
const LIT: &str = "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n";

struct Bench(TempDir);

/// What a process did.
struct Run {
    code: Option<i32>,
    output: String,
}

impl Bench {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        fs::write(self.path(name), contents).unwrap();
    }

    /// A lit world as `scene.pbrt`.
    fn world(&self, world: &str) {
        self.write("scene.pbrt", format!("{LIT}{world}"));
    }

    /// A gzipped file: a head, `mib` MiB of a pattern whose length is a power of two, a tail.
    fn gzip(&self, name: &str, head: &[u8], mib: usize, pattern: &[u8], tail: &[u8]) {
        let mut stream = GzEncoder::new(File::create(self.path(name)).unwrap(), Compression::fast());
        stream.write_all(head).unwrap();
        let block = pattern.repeat((1 << 20) / pattern.len());
        (0..mib).for_each(|_| stream.write_all(&block).unwrap());
        stream.write_all(tail).unwrap();
        stream.finish().unwrap().sync_all().unwrap();
    }

    /// Runs goblet where it can have 8 GB of addresses, and sees how much memory it takes.
    fn run(&self, arguments: &[&str]) -> Run {
        let out = self.path("out.txt");
        let log = File::create(&out).unwrap();
        let mut child = Command::new("sh")
            .args([
                "-c",
                &format!("ulimit -v {MOST_ADDRESSES}; ulimit -t {MOST_SECONDS}; exec \"$0\" \"$@\""),
                env!("CARGO_BIN_EXE_goblet"),
            ])
            .args(arguments)
            .env(CACHE, "")
            .current_dir(self.0.path())
            .stdin(Stdio::null())
            .stdout(log.try_clone().unwrap())
            .stderr(log)
            .spawn()
            .unwrap();
        let most = wait(&mut child);
        assert!(most < MOST_MEMORY, "{arguments:?}: {most} KiB");
        let output = String::from_utf8_lossy(&fs::read(out).unwrap()).into_owned();
        Run { code: child.wait().unwrap().code(), output }
    }

    /// Runs `info` on `scene.pbrt`, with less than the default where that is to be quick.
    fn info(&self, more: &[&str]) -> Run {
        self.run(&[&["info", "scene.pbrt"], more].concat())
    }

    /// Fails unless both `info` and `render` refuse the scene, with these words.
    fn refused(&self, words: &[&str], more: &[&str]) {
        let render = ["render", "scene.pbrt", "-o", "x.png", "--iterations", "1", "--resolution", "16x16"];
        for run in [self.info(more), self.run(&[&render[..], more].concat())] {
            run.refused(words);
        }
    }
}

/// The largest memory that a process has had while it ran, KiB.
fn wait(child: &mut Child) -> u64 {
    let (start, status) = (Instant::now(), format!("/proc/{}/status", child.id()));
    let mut most = 0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        // The kernel's own record of the peak, so that none is missed but at the very end.
        let peak = text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse().ok());
        // At first, it is the memory of the test.
        if text.starts_with("Name:\tgoblet\n") {
            most = most.max(peak.unwrap_or(0));
        }
        if start.elapsed() > WATCHDOG {
            child.kill().unwrap();
            panic!("it does not end");
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    most
}

impl Run {
    /// Fails unless it stopped by itself with an error of the scene, in few words.
    fn refused(&self, words: &[&str]) {
        let Self { code, output } = self;
        let start: String = output.chars().take(4000).collect();
        assert_eq!(*code, Some(2), "{start}");
        assert!(!output.contains("panicked"), "{start}");
        assert!(output.len() < 100_000, "{} bytes are printed: {start}", output.len());
        for word in words {
            assert!(output.contains(word), "`{word}` is not in: {start}");
        }
    }

    fn done(&self) {
        let start: String = self.output.chars().take(4000).collect();
        assert_eq!(self.code, Some(0), "{start}");
    }
}

/// What a message of memory says.
const OVER: &str = "MiB (--scene-memory allows more)";
/// Less than the default, for what is slow to reach it without optimisation.
const SMALL: [&str; 2] = ["--scene-memory", "0.1"];
/// About ten files of a mebibyte.
const TINY: [&str; 2] = ["--scene-memory", "0.01"];

const TETRAHEDRON: &str = "\"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] \"integer indices\" [0 2 1 0 1 3 0 3 2 1 2 3]";

#[test]
fn subdivision_is_refused_before_it_takes_memory() {
    let bench = Bench::new();
    for (levels, count) in [(12, 1), (11, 8), (16, 1)] {
        bench.world(&format!("Shape \"loopsubdiv\" \"integer levels\" {levels} {TETRAHEDRON}\n").repeat(count));
        bench.refused(&["scene.pbrt:4:7: ", "levels make", OVER], &["--scene-memory", "1.5"]);
    }
    // Each of them fits, and not all.
    bench.world(&format!("Shape \"loopsubdiv\" \"integer levels\" 6 {TETRAHEDRON}\n").repeat(8));
    bench.refused(&["scene.pbrt:7:7: ", "too large: ", OVER], &["--scene-memory", "0.00625"]);
    bench.info(&[]).done();
}

#[test]
fn patches_are_refused_before_they_take_memory() {
    let bench = Bench::new();
    let patches = "0 1 2 3 ".repeat(30_000);
    let mesh = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1] \"integer indices\"";
    bench.world(&format!("{mesh} [{patches}]"));
    bench.refused(&["scene.pbrt:4:7: 30000 patches of 32x32 cells", OVER], &["--scene-memory", "1.5"]);
}

#[test]
fn images_are_refused_before_they_take_memory() {
    let bench = Bench::new();
    // No pixels are read: the header is enough.
    let mut hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n".to_vec();
    hdr.extend([2, 2, 0xea, 0x60]);
    bench.write("x.hdr", hdr);
    for world in [
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"x.hdr\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\"\n",
        "LightSource \"infinite\" \"string filename\" \"x.hdr\"\nShape \"sphere\"\n",
        "AreaLightSource \"diffuse\" \"string filename\" \"x.hdr\"\nShape \"sphere\"\n",
    ] {
        bench.world(world);
        bench.refused(&["scene.pbrt:4:", "x.hdr", "60000x60000", OVER], &[]);
    }
}

#[test]
fn gzipped_meshes_are_bounded() {
    let bench = Bench::new();
    bench.world("Shape \"plymesh\" \"string filename\" \"x.ply\"\n");
    let count = 100 << 20;
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty char x\nproperty char y\nproperty char z\n\
         element face 1\nproperty list uchar uchar vertex_indices\nend_header\n"
    );
    bench.gzip("x.ply", header.as_bytes(), 4, &[0], &[]);
    bench.refused(&["scene.pbrt:4:17: x.ply: byte ", "entries of at least 3 bytes"], &[]);
    let header = header.replace(&count.to_string(), &(5 << 20).to_string());
    bench.gzip("x.ply", header.as_bytes(), 15, &[0], &[3, 0, 1, 2]);
    bench.refused(&["scene.pbrt:4:17: x.ply: byte ", "120 MiB", OVER], &SMALL);
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    bench.gzip("x.ply", header.as_bytes(), 110, b" ", &[]);
    bench.refused(&["scene.pbrt:4:17: x.ply: byte ", "are to be read in all", OVER], &SMALL);
}

#[test]
fn gzipped_texts_are_bounded() {
    let bench = Bench::new();
    for pattern in [&b" "[..], b"AttributeBegin\n\n"] {
        bench.gzip("scene.pbrt", b"", 110, pattern, &[]);
        bench.refused(&["cannot read scene.pbrt: ", OVER], &SMALL);
    }
    // Blocks take more than their text.
    bench.gzip("scene.pbrt", LIT.as_bytes(), 40, b"AttributeBegin\n\n", &[]);
    bench.refused(&["scene.pbrt:", "too large: ", OVER], &SMALL);
}

/// What is inherited is shared, and counts each time that it is used.
#[test]
fn inherited_parameters_are_bounded() {
    let bench = Bench::new();
    let zeros = "0 ".repeat(300_000);
    let blocks = "AttributeBegin Attribute \"shape\" \"float x\" 1 \"float radius\" 2\n".repeat(5000);
    bench.world(&format!("Attribute \"shape\" \"point3 P\" [{zeros}]\n{blocks}"));
    bench.refused(&["scene.pbrt:5004:1: this block is never ended"], &SMALL);
    let triangles = "0 1 2 ".repeat(100_000);
    let shapes = "Shape \"trianglemesh\"\n".repeat(3000);
    let points = "0 0 0 1 0 0 0 1 0";
    bench.world(&format!(
        "Attribute \"shape\" \"point3 P\" [{points} {zeros}] \"integer indices\" [{triangles}]\n{shapes}"
    ));
    bench.refused(&["scene.pbrt:", "too large: ", OVER], &SMALL);
    // A mesh that is shared is packed for each shape.
    let mut ply = String::from(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 100000\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n",
    );
    ply += &"3 0 1 2\n".repeat(100_000);
    bench.write("x.ply", ply);
    bench.world(&"Shape \"plymesh\" \"string filename\" \"x.ply\"\n".repeat(1000));
    bench.refused(&["scene.pbrt:", "too large: ", OVER], &SMALL);
}

#[test]
fn nested_blocks_are_bounded_by_memory_alone() {
    let bench = Bench::new();
    let (begin, end) = ("AttributeBegin\n".repeat(100_000), "AttributeEnd\n".repeat(100_000));
    bench.world(&format!("{begin}Shape \"sphere\"\n{end}"));
    bench.info(&[]).done();
    bench.refused(&["scene.pbrt:", "too large: ", OVER], &["--scene-memory", "0.01"]);
}

#[test]
fn textures_within_textures_are_bounded() {
    let bench = Bench::new();
    let scale = |name: &str, tex: &str, factor: &str| {
        format!("Texture \"{name}\" \"float\" \"scale\" \"texture tex\" \"{tex}\" {factor}\n")
    };
    let mut tree = String::from("Texture \"c0\" \"float\" \"checkerboard\"\n");
    for i in 1..60 {
        let before = format!("c{}", i - 1);
        tree += &scale(&format!("c{i}"), &before, &format!("\"texture scale\" \"{before}\""));
    }
    bench.world(&format!("{tree}Shape \"sphere\" \"texture alpha\" \"c59\"\n"));
    bench.refused(&["scene.pbrt:63:23: ", "too many others"], &[]);
    // Each has 129 nodes, which shapes do not share.
    let many: String = (0..10_000)
        .map(|i| {
            scale(&format!("d{i}"), "c6", &format!("\"float scale\" 0.{}", i + 1))
                + &format!("Shape \"sphere\" \"texture alpha\" \"d{i}\"\n")
        })
        .collect();
    bench.world(&format!("{tree}{many}"));
    bench.refused(&["scene.pbrt:", "too large: ", OVER], &SMALL);
    let mut chain = String::from("Texture \"c0\" \"float\" \"checkerboard\"\n");
    (1..50_000).for_each(|i| chain += &scale(&format!("c{i}"), &format!("c{}", i - 1), "\"float scale\" 1"));
    bench.world(&format!("{chain}Shape \"sphere\" \"texture alpha\" \"c49999\"\n"));
    bench.refused(&["scene.pbrt:50003:", "too many others"], &[]);
    // Means of coats go down as far.
    let spectra =
        chain.replace("\"float\" \"scale\"", "\"spectrum\" \"scale\"").replacen("\"float\"", "\"spectrum\"", 1);
    let metal = "Material \"coatedconductor\" \"float thickness\" .01 \"texture albedo\"";
    bench.world(&format!(
        "{spectra}{metal} \"c49999\"\n{}",
        format!("{metal} \"c49998\"\nShape \"sphere\"\n").repeat(1000)
    ));
    bench.info(&[]).done();
    // Thickness itself is a texture like others.
    bench.world(&format!("{chain}Material \"coateddiffuse\" \"texture thickness\" \"c49999\"\nShape \"sphere\"\n"));
    bench.refused(&["scene.pbrt:50003:", "too many others"], &[]);
}

#[test]
fn mixes_within_mixes_are_bounded() {
    let bench = Bench::new();
    let mut mixes = String::from("MakeNamedMaterial \"m0\" \"string type\" \"diffuse\"\n");
    for i in 1..50 {
        let before = i - 1;
        let _ = writeln!(
            mixes,
            "MakeNamedMaterial \"m{i}\" \"string type\" \"mix\" \"string materials\" [\"m{before}\" \"m{before}\"]"
        );
    }
    let use_of = |i: usize| format!("NamedMaterial \"m{i}\"\nShape \"sphere\"\n");
    // Whether those within are used by themselves, too, is of no matter.
    for uses in [use_of(49), (0..50).map(use_of).collect(), use_of(4) + &use_of(5)] {
        bench.world(&format!("{mixes}{uses}"));
        bench.refused(&["more than 4 deep"], &[]);
    }
    bench.world(&format!("{mixes}{}", use_of(4)));
    bench.info(&[]).done();
}

#[test]
fn includes_end() {
    let bench = Bench::new();
    for i in 0..40 {
        bench.write(&format!("l{i}.pbrt"), format!("Include \"l{0}.pbrt\"\nInclude \"l{0}.pbrt\"\n", i + 1));
    }
    bench.write("l40.pbrt", "# ha\n");
    bench.write("scene.pbrt", "Include \"l0.pbrt\"\n");
    bench.refused(&[".pbrt:", "includes more than 65536 files"], &[]);
    bench.write("scene.pbrt", "Include \"scene.pbrt\"\n");
    bench.refused(&["scene.pbrt:1:1: ", "includes itself"], &[]);
    // Few, but large.
    bench.write("large.pbrt", " ".repeat(1 << 20));
    bench.world(&"Include \"large.pbrt\"\n".repeat(1000));
    bench.refused(&["are to be read in all", OVER], &TINY);
    bench.write("large.spd", "# \n".repeat(1 << 18) + "400 1 700 1");
    bench.world(&"Material \"diffuse\" \"spectrum reflectance\" \"large.spd\"\n".repeat(1000));
    bench.refused(&["are to be read in all", OVER], &TINY);
}

#[test]
fn parameters_take_time_by_their_number_alone() {
    let bench = Bench::new();
    let params: String = (0..100_000).map(|i| format!("\"float a{i}\" 1\n")).collect();
    bench.write("scene.pbrt", format!("Film \"rgb\" {params}\n{LIT}"));
    bench.refused(&["scene.pbrt:1:12: unknown parameter \"float a0\""], &[]);
    bench.world(&format!("Attribute \"shape\" {params}\nShape \"sphere\""));
    bench.info(&[]).done();
}

#[test]
fn what_is_no_file_is_not_read() {
    let bench = Bench::new();
    let fifo = Command::new("mkfifo").arg(bench.path("fifo")).status().unwrap();
    assert!(fifo.success());
    for name in ["fifo.pbrt", "fifo.ply", "fifo.spd", "fifo.png"] {
        fs::hard_link(bench.path("fifo"), bench.path(name)).unwrap();
    }
    for end in ["pbrt", "ply", "spd", "png"] {
        symlink("/dev/zero", bench.path(&format!("zero.{end}"))).unwrap();
    }
    for source in ["fifo", "zero"] {
        for world in [
            format!("Include \"{source}.pbrt\"\n"),
            format!("Import \"{source}.pbrt\"\n"),
            format!("Shape \"plymesh\" \"string filename\" \"{source}.ply\"\n"),
            format!("Material \"diffuse\" \"spectrum reflectance\" \"{source}.spd\"\nShape \"sphere\"\n"),
            format!("Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{source}.png\"\nShape \"sphere\"\n"),
            format!("LightSource \"infinite\" \"string filename\" \"{source}.png\"\n"),
            format!("AreaLightSource \"diffuse\" \"string filename\" \"{source}.png\"\nShape \"sphere\"\n"),
        ] {
            bench.world(&world);
            bench.refused(&["scene.pbrt:4:", "it is a pipe or a device; expected a file"], &[]);
        }
        bench.run(&["info", &format!("{source}.pbrt")]).refused(&["expected a file"]);
    }
}

/// Coordinates that are no numbers in world space, whatever comes after them.
#[test]
fn coordinates_that_overflow_are_refused_where_they_are() {
    let bench = Bench::new();
    let transform = "Transform [1e200 1e200 0 0  -1e200 -2e200 0 0  0 0 1 0  0 0 0 1]";
    for (shape, line) in [
        ("Shape \"trianglemesh\" \"point3 P\" [1e200 1e200 0  1e-200 0 1  0 1e-200 0]", 5),
        ("Shape \"trianglemesh\" \"point3 P\" [1e-200 0 1  0 1e-200 0  1e200 1e200 0]", 5),
        ("Shape \"sphere\" \"float radius\" 1e200", 5),
        ("Shape \"disk\" \"float radius\" 1e200", 5),
        ("Shape \"cylinder\" \"float radius\" 1e200", 5),
        ("Shape \"bilinearmesh\" \"point3 P\" [1e200 1e200 0  1e-200 0 1  0 1e-200 0  1 1 1]", 5),
        (
            "Shape \"loopsubdiv\" \"integer levels\" 1 \"point3 P\" [1e308 1e308 0  -1e308 0 1  0 1e308 0] \"integer indices\" [0 1 2]",
            5,
        ),
        ("ObjectBegin \"o\"\nShape \"sphere\" \"float radius\" 1e200\nObjectEnd", 6),
    ] {
        for world in [
            format!("{transform}\n{shape}\nIdentity\nShape \"sphere\"\n"),
            format!("{transform}\n{shape}\nIdentity\n{}", "Shape \"sphere\"\n".repeat(100)),
        ] {
            bench.world(&world);
            bench.refused(&[&format!("scene.pbrt:{line}:1: coordinates overflow")], &[]);
        }
    }
    // Of an object, by the transform of its instance.
    let scale = "Scale 1e110 1e110 1e110";
    bench.world(&format!(
        "ObjectBegin \"o\"\nShape \"sphere\" \"float radius\" 1e200\nObjectEnd\n{scale}\nObjectInstance \"o\"\n"
    ));
    bench.refused(&["scene.pbrt:8:1: coordinates overflow"], &[]);
    for light in ["point", "spot"] {
        bench.world(&format!("{transform}\nLightSource \"{light}\" \"point3 from\" [1e200 0 0]\nShape \"sphere\""));
        bench.refused(&["scene.pbrt:5:13: "], &[]);
    }
    bench.write("scene.pbrt", format!("Translate 1e308 0 0 Translate 1e308 0 0\n{LIT}Shape \"sphere\""));
    bench.refused(&["scene.pbrt:2:8: "], &[]);
}

/// Errors are few and short, however long and many what is wrong is.
/// Each is in contact with each.
#[test]
fn bodies_in_one_place_take_time_by_their_number_alone() {
    let bench = Bench::new();
    for body in ["Shape \"sphere\" \"texture alpha\" \"half\"\n", "Material \"dielectric\" Shape \"sphere\"\n"] {
        let texture = "Texture \"half\" \"float\" \"checkerboard\" \"float tex1\" .5\n";
        bench.world(&(texture.to_owned() + &body.repeat(14_000)));
        bench.info(&[]).done();
    }
}

#[test]
fn messages_are_short() {
    let bench = Bench::new();
    let long = "x".repeat(5_000_000);
    for (world, words) in [
        (format!("{long}\n"), "scene.pbrt:4:1: unknown directive"),
        (format!("Shape \"{long}"), "scene.pbrt:4:7: unterminated string"),
        (format!("Shape \"{long}\"\n"), "scene.pbrt:4:7: unknown Shape"),
        (format!("Include \"{long}\"\n"), "scene.pbrt:4:9: cannot read"),
        (format!("Shape \"plymesh\" \"string filename\" \"{long}\"\n"), "scene.pbrt:4:17: cannot read"),
        (format!("Material \"diffuse\" \"spectrum reflectance\" \"{long}\"\n Shape \"sphere\""), "scene.pbrt:4:20: "),
        (format!("Shape \"sphere\" \"float radius\" 1{}\n", "0".repeat(1_000_000)), "is not a finite number"),
        (format!("Shape \"curve\" {}", "\"float a\" 1 ".repeat(100_000)), "Shape \"curve\" is not supported"),
        (format!("Shape \"sphere\" {}", "\"float a\" 1 ".repeat(100_000)), "unknown parameter \"float a\""),
        ("Shape \"curve\"\n".repeat(100_000), "further faults: 99900"),
        ("Shape \"sphere\" \"texture alpha\" \"t\"\n".repeat(1000), "further faults: 900"),
    ] {
        bench.world(&world);
        bench.info(&[]).refused(&[words]);
    }
}

/// The option lowers and raises what a scene may take, for every command that reads one.
#[test]
fn the_option_is_of_every_command() {
    let bench = Bench::new();
    bench.world(&format!("Shape \"loopsubdiv\" \"integer levels\" 6 {TETRAHEDRON}\n"));
    for command in [
        &["info", "scene.pbrt"][..],
        &["render", "scene.pbrt", "-o", "x.png"],
        &["measure", "scene.pbrt", "--reference", "auto", "-o", "x"],
        &["advise", "scene.pbrt", "--time", "1"],
        &["tessellate", "scene.pbrt", "-o", "x.pbrt"],
    ] {
        bench.run(&[command, &["--scene-memory", "1e-3"]].concat()).refused(&["6 levels make 16384 triangles", OVER]);
        bench.run(&[command, &["--scene-memory", "0"]].concat()).refused(&["a number of GiB above 0"]);
    }
    bench.info(&["--scene-memory", "0.01"]).done();
}
