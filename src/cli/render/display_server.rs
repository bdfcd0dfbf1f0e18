//! `--display-server`: the live image in tev, or in another viewer that understands its protocol.
//!
//! A thread sends the images, so that no connection delays the render. An image is prepared only when the one
//! before is sent, and so seldom that preparing images takes a small share of the time.

use std::fmt::{self, Display};
use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use crate::cli::{Failure, terminal};
use crate::image::estimate::Estimate;
use crate::image::film::Image;
use crate::render::aov::{self, Aov};
use crate::render::renderer::Renderer;

/// The address of a display server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    host: String,
    port: u16,
}

impl Address {
    /// Reads `HOST:PORT`; a host may be an IPv6 address in brackets.
    ///
    /// # Errors
    /// The text is another one. The error says what was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let parts = text.rsplit_once(':').and_then(|(host, port)| Some((host, port.parse().ok()?)));
        let inside = |host: &str| host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).map(str::to_owned);
        match parts {
            Some((host, port)) if port > 0 && !host.is_empty() && (inside(host).is_some() || !host.contains(':')) => {
                Ok(Self { host: inside(host).unwrap_or_else(|| host.to_owned()), port })
            }
            _ => Err("expected HOST:PORT, as localhost:14158".to_owned()),
        }
    }
}

impl Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if self.host.contains(':') {
            return write!(f, "[{}]:{}", self.host, self.port);
        }
        write!(f, "{}:{}", self.host, self.port)
    }
}

/// The shortest time from one image to the next.
const INTERVAL: Duration = Duration::from_millis(250);
/// The time from one image to the next is at least as many times that of preparing an image.
const SHARE: u32 = 20;
/// The longest time in which a connection must be made, or a server must take some more bytes.
const PATIENCE: Duration = Duration::from_secs(3);

/// The planes of an image, one after the other.
struct Planes {
    size: [u32; 2],
    names: Vec<String>,
    values: Vec<f32>,
}

/// A viewer that shows the image while it is rendered.
pub struct DisplayServer {
    images: SyncSender<Planes>,
    thread: JoinHandle<()>,
    /// Whether the thread sends an image.
    is_sending: Arc<AtomicBool>,
    /// When the next image may be prepared.
    next: Instant,
    aovs: Vec<&'static Aov>,
}

impl DisplayServer {
    /// Starts to send images to a server. `name` is the image's name there. A server that cannot be reached is
    /// reported once, and tried again with each image.
    pub fn new(address: Address, name: String, aovs: &[&'static Aov], quiet: bool) -> Self {
        let (images, received) = sync_channel(1);
        let is_sending = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&is_sending);
        let connection = Connection { address, name, client: None, warns: !quiet };
        let thread = std::thread::spawn(move || connection.send_all(&received, &flag));
        Self { images, thread, is_sending, next: Instant::now(), aovs: aovs.to_vec() }
    }

    /// Sends the image, unless the one before is still being sent or was sent just now.
    ///
    /// # Errors
    /// The device fails.
    pub fn show(&mut self, renderer: &Renderer) -> Result<(), Failure> {
        let start = Instant::now();
        if start < self.next || self.is_sending.load(Ordering::Acquire) {
            return Ok(());
        }
        self.send(renderer)?;
        self.next = Instant::now() + INTERVAL.max(start.elapsed() * SHARE);
        Ok(())
    }

    fn send(&self, renderer: &Renderer) -> Result<(), Failure> {
        let planes = planes(&renderer.estimate()?, &self.aovs)?;
        self.is_sending.store(true, Ordering::Release);
        // The thread receives as long as there is a sender.
        let _ = self.images.send(planes);
        Ok(())
    }

    /// Sends the last image, and waits until it is sent or the server does not take it.
    ///
    /// # Errors
    /// The device fails.
    pub fn finish(self, renderer: &Renderer) -> Result<(), Failure> {
        let sent = self.send(renderer);
        drop(self.images);
        // A panic of the thread is already on standard error.
        let _ = self.thread.join();
        sent
    }
}

/// Returns the image and the AOVs as they are in an EXR.
fn planes(estimate: &Estimate, aovs: &[&'static Aov]) -> Result<Planes, Failure> {
    let Image { width, height, pixels } = estimate.image();
    let mut names = ["R", "G", "B"].map(str::to_owned).to_vec();
    let mut values: Vec<f32> = (0..3).flat_map(|channel| pixels.iter().map(move |pixel| pixel[channel])).collect();
    for channel in aov::channels(aovs, estimate)? {
        names.push(channel.name);
        values.extend(channel.values);
    }
    Ok(Planes { size: [width, height], names, values })
}

/// The connection to a server, which may break and be made again.
struct Connection {
    address: Address,
    name: String,
    client: Option<TevClient>,
    /// Whether the next failure is reported.
    warns: bool,
}

impl Connection {
    fn send_all(mut self, images: &Receiver<Planes>, is_sending: &AtomicBool) {
        for planes in images {
            if let Err(reason) = self.send(&planes) {
                self.client = None;
                if std::mem::take(&mut self.warns) {
                    terminal::warn(format_args!(
                        "display server {}: {reason}; the render goes on, and tries again with each image",
                        self.address
                    ));
                }
            }
            is_sending.store(false, Ordering::Release);
        }
    }

    fn send(&mut self, planes: &Planes) -> io::Result<()> {
        let [width, height] = planes.size;
        let client = match &mut self.client {
            Some(client) => client,
            none => {
                let mut client = TevClient::wrap(connect(&self.address)?);
                client.send(PacketCreateImage {
                    image_name: &self.name,
                    grab_focus: true,
                    width,
                    height,
                    channel_names: &planes.names,
                })?;
                none.insert(client)
            }
        };
        let size = u64::from(width) * u64::from(height);
        let offsets: Vec<u64> = (0..planes.names.len() as u64).map(|plane| plane * size).collect();
        client.send(PacketUpdateImage {
            image_name: &self.name,
            grab_focus: false,
            channel_names: &planes.names,
            channel_offsets: &offsets,
            channel_strides: &vec![1; offsets.len()],
            x: 0,
            y: 0,
            width,
            height,
            data: &planes.values,
        })
    }
}

fn connect(address: &Address) -> io::Result<TcpStream> {
    let mut last = io::Error::other("the host has no address");
    for address in (address.host.as_str(), address.port).to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(stream) => {
                stream.set_write_timeout(Some(PATIENCE))?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_have_a_host_and_a_port() {
        for (text, host, port) in
            [("localhost:14158", "localhost", 14158), ("10.0.0.1:1", "10.0.0.1", 1), ("[::1]:65535", "::1", 65535)]
        {
            let address = Address::parse(text).expect("an address");
            assert_eq!(address, Address { host: host.to_owned(), port });
            assert_eq!(address.to_string(), text);
        }
        for text in ["", "localhost", ":14158", "localhost:", "localhost:0", "localhost:65536", "::1:80", "[::1]"] {
            assert!(Address::parse(text).is_err(), "{text}");
        }
    }
}
