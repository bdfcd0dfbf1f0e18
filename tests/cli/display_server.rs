//! `--display-server`: a small server of tev's protocol decodes what goblet sends.

use std::collections::BTreeMap;
use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::thread;

use crate::support::command::Bench;

/// An image as tev holds it.
#[derive(Default)]
struct Shown {
    name: String,
    size: [usize; 2],
    channels: BTreeMap<String, Vec<f32>>,
    /// Number of messages that changed it.
    updates: usize,
}

/// A message without its length, from its beginning to what is not read yet.
struct Message<'a>(&'a [u8]);

impl Message<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (bytes, rest) = self.0.split_first_chunk().expect("a longer message");
        self.0 = rest;
        *bytes
    }

    fn number(&mut self) -> usize {
        u32::from_le_bytes(self.bytes()) as usize
    }

    fn long(&mut self) -> usize {
        u64::from_le_bytes(self.bytes()) as usize
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).expect("the end of a text");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("UTF-8");
        self.0 = &self.0[end + 1..];
        text
    }

    fn texts(&mut self) -> Vec<String> {
        let count = self.number();
        (0..count).map(|_| self.text()).collect()
    }
}

/// Reads all messages of a connection: `CreateImage` (4) and `UpdateImageV3` (6).
fn receive(mut stream: TcpStream) -> Shown {
    let mut shown = Shown::default();
    let mut length = [0; 4];
    while stream.read_exact(&mut length).is_ok() {
        let mut bytes = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut bytes).expect("a whole message");
        let mut message = Message(&bytes);
        let ([kind], [_], name) = (message.bytes(), message.bytes(), message.text());
        if kind == 4 {
            let [width, height] = [message.number(), message.number()];
            let channels = message.texts().into_iter().map(|name| (name, vec![f32::NAN; width * height]));
            shown = Shown { name, size: [width, height], channels: channels.collect(), updates: 0 };
        } else {
            assert_eq!((kind, &name), (6, &shown.name));
            update(&mut shown, &mut message);
        }
        assert!(message.0.is_empty(), "{} bytes are left", message.0.len());
    }
    shown
}

fn update(shown: &mut Shown, message: &mut Message) {
    let names = message.texts();
    let [x, y, width, height] = [(); 4].map(|()| message.number());
    let offsets: Vec<usize> = names.iter().map(|_| message.long()).collect();
    let strides: Vec<usize> = names.iter().map(|_| message.long()).collect();
    let values: Vec<f32> = message.0.chunks_exact(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect();
    message.0 = &[];
    for ((name, offset), stride) in names.iter().zip(offsets).zip(strides) {
        let plane = shown.channels.get_mut(name).expect("a channel that was created");
        for i in 0..width * height {
            plane[(y + i / width) * shown.size[0] + x + i % width] = values[offset + i * stride];
        }
    }
    shown.updates += 1;
}

#[test]
fn a_viewer_gets_the_image_and_its_channels_as_they_are_written() {
    let bench = Bench::new();
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = server.local_addr().unwrap().to_string();
    let viewer = thread::spawn(move || receive(server.accept().unwrap().0));
    let aovs = ["--aov", "normal", "--aov", "radius"];
    bench.rendered(&[&["--iterations", "3", "-o", "x.exr", "--display-server", &address], &aovs[..]].concat());
    let shown = viewer.join().unwrap();
    assert!(shown.name.contains("scene.pbrt"), "{}", shown.name);
    // The first image, and the last one.
    assert!(shown.updates >= 2, "{}", shown.updates);
    let image = exr::prelude::read_all_flat_layers_from_file(bench.path("x.exr")).unwrap();
    let written: Vec<_> = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list).collect();
    let size = image.layer_data[0].size;
    assert_eq!(shown.size, [size.width(), size.height()]);
    assert_eq!(shown.channels.len(), 3 + 3 + 1);
    for (name, plane) in &shown.channels {
        let channel = written.iter().find(|channel| channel.name == **name).unwrap_or_else(|| panic!("no {name}"));
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        assert_eq!(*plane, values, "{name}");
    }
}

#[test]
fn a_viewer_that_fails_does_not_stop_the_render() {
    let bench = Bench::new();
    let warnings = |address: &str| {
        let run = bench.rendered(&["--iterations", "3", "-o", "x.exr", "--display-server", address]);
        assert!(bench.path("x.exr").exists());
        run.stderr.matches("shows no more images").count()
    };
    // Nobody listens there.
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    assert_eq!(warnings(&closed), 1);
    assert_eq!(warnings("no.such.host.invalid:14158"), 1);
    // One that hangs up at once; a warning comes if anything is sent after that.
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = server.local_addr().unwrap().to_string();
    let viewer = thread::spawn(move || drop(server.accept().unwrap()));
    assert!(warnings(&address) <= 1);
    viewer.join().unwrap();
    for bad in ["localhost", "localhost:", ":14158", "localhost:0", "localhost:99999"] {
        bench.render(&["--display-server", bad]).assert_refused(bad, 2, &["expected a host and a port"]);
    }
}
