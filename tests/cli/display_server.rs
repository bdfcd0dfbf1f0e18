//! `goblet render --display-server`, against a server that understands tev's protocol.

use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::thread;

use goblet::render::aov::Aov;

use crate::aov::channel;
use crate::support::command::Bench;

/// A message of tev's protocol: after its length, its kind and its contents.
#[derive(Debug, PartialEq)]
enum Message {
    Create { name: String, size: [u32; 2], channels: Vec<String> },
    Update { name: String, origin: [u32; 2], size: [u32; 2], channels: Vec<(String, Vec<f32>)> },
}

/// Reads the contents of a message from their beginning.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (taken, rest) = self.0.split_first_chunk().expect("more bytes");
        self.0 = rest;
        *taken
    }

    fn flag(&mut self) -> bool {
        u8::from_le_bytes(self.take()) != 0
    }

    fn number(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn long(&mut self) -> usize {
        u64::from_le_bytes(self.take()) as usize
    }

    fn pair(&mut self) -> [u32; 2] {
        [self.number(), self.number()]
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).expect("a zero");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("UTF-8");
        self.0 = &self.0[end + 1..];
        text
    }

    fn texts(&mut self) -> Vec<String> {
        (0..self.number()).map(|_| self.text()).collect()
    }
}

/// Reads a message; `None` at the end of the connection.
fn read_message(stream: &mut TcpStream) -> Option<Message> {
    let mut length = [0; 4];
    stream.read_exact(&mut length).ok()?;
    let mut contents = vec![0; u32::from_le_bytes(length) as usize - 4];
    stream.read_exact(&mut contents).expect("a whole message");
    let mut reader = Reader(&contents);
    let [kind] = reader.take();
    reader.flag();
    let name = reader.text();
    let message = match kind {
        4 => Message::Create { name, size: reader.pair(), channels: reader.texts() },
        6 => {
            let names = reader.texts();
            let (origin, size) = (reader.pair(), reader.pair());
            let mut longs = || -> Vec<usize> { names.iter().map(|_| reader.long()).collect() };
            let (offsets, strides) = (longs(), longs());
            let values: Vec<f32> =
                reader.0.chunks(4).map(|value| f32::from_le_bytes(value.try_into().unwrap())).collect();
            reader.0 = &[];
            let count = (size[0] * size[1]) as usize;
            let plane = |(offset, stride): (usize, usize)| (0..count).map(|i| values[offset + i * stride]).collect();
            let planes = offsets.into_iter().zip(strides).map(plane);
            Message::Update { name, origin, size, channels: names.iter().cloned().zip(planes).collect() }
        }
        kind => panic!("a message of kind {kind}"),
    };
    assert!(reader.0.is_empty(), "{} bytes too many", reader.0.len());
    Some(message)
}

/// Listens on a port of its own; returns its address.
fn listen() -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    (listener, address)
}

#[test]
fn a_viewer_gets_what_is_written() {
    let (listener, address) = listen();
    let server = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        std::iter::from_fn(|| read_message(&mut stream)).collect::<Vec<_>>()
    });
    let bench = Bench::new();
    let run = bench.rendered(&["--iterations", "5", "--aov", "radius", "-o", "x.exr", "--display-server", &address]);
    assert!(!run.stderr.contains("warning"), "{run:?}");
    let messages = server.join().unwrap();
    let image = bench.image("x.exr");
    let radius = Aov::named("radius").unwrap().channels[0];
    let channels = ["R", "G", "B", radius].map(str::to_owned).to_vec();
    assert_eq!(messages[0], Message::Create { name: "scene.pbrt".to_owned(), size: [16, 12], channels });
    let plane = |c: usize| image.pixels.iter().map(|pixel| pixel[c]).collect::<Vec<f32>>();
    let channels = vec![
        ("R".to_owned(), plane(0)),
        ("G".to_owned(), plane(1)),
        ("B".to_owned(), plane(2)),
        (radius.to_owned(), channel(&bench, "x.exr", radius)),
    ];
    let last = Message::Update { name: "scene.pbrt".to_owned(), origin: [0, 0], size: [16, 12], channels };
    assert_eq!(messages.last(), Some(&last));
}

/// The image is that of a render without a viewer, and there is one warning.
#[test]
fn a_viewer_that_is_not_there_or_leaves_changes_nothing() {
    let bench = Bench::new();
    let arguments = ["--iterations", "3", "-o", "x.exr"];
    bench.rendered(&arguments);
    let expected = bench.bytes("x.exr");
    let assert_same = |address: &str| {
        let run = bench.rendered(&[&arguments[..], &["--display-server", address]].concat());
        assert_eq!(bench.bytes("x.exr"), expected);
        let warnings = run.stderr.matches("warning: display server").count();
        (warnings, run)
    };

    let (listener, absent) = listen();
    drop(listener);
    let (warnings, run) = assert_same(&absent);
    assert_eq!(warnings, 1, "{run:?}");
    assert!(run.stderr.contains(&format!("display server {absent}: ")), "{run:?}");

    let (listener, address) = listen();
    let server = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let first = read_message(&mut stream);
        drop((stream, listener));
        assert!(matches!(first, Some(Message::Create { .. })), "{first:?}");
    });
    let (warnings, run) = assert_same(&address);
    server.join().unwrap();
    assert!(warnings <= 1, "{run:?}");
}

#[test]
fn an_address_has_a_host_and_a_port() {
    let run = Bench::new().render(&["--display-server", "localhost"]);
    run.assert_refused("no port", 2, &["expected HOST:PORT"]);
}
