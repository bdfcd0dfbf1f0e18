//! The display server: a viewer that shows the image while it is rendered, by the protocol of tev.
//!
//! A thread of its own connects and sends. A slow viewer misses images; one that fails is left, with a warning.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use super::RenderArgs;
use crate::cli::terminal;
use crate::image::file::Channel;
use crate::image::film::Image;
use crate::render::aov;
use crate::render::error::RenderError;
use crate::render::renderer::Renderer;

/// The least time between two images.
const INTERVAL: Duration = Duration::from_secs(1);
/// The least time between two images, over the time that it takes to make one.
const LEAST_GAP: u32 = 20;
/// The time in which the viewer must answer a connection, or take a part of an image.
const TIMEOUT: Duration = Duration::from_secs(3);
/// The time in which the viewer must take the last image.
const LAST_TIMEOUT: Duration = Duration::from_secs(10);
/// Rows of an image in one message.
const ROWS: usize = 64;

/// What the viewer shows at a time.
pub struct Frame {
    size: [u32; 2],
    /// Names of the channels.
    names: Vec<String>,
    /// The values of each channel, row by row, the top row first.
    planes: Vec<Vec<f32>>,
}

impl Frame {
    /// Returns the channels R, G and B of an image, and further ones.
    pub fn new(image: &Image, channels: &[Channel]) -> Self {
        let colours = ["R", "G", "B"].map(str::to_owned);
        let names = colours.into_iter().chain(channels.iter().map(|channel| channel.name.clone()));
        let plane = |c: usize| image.pixels.iter().map(|pixel| pixel[c]).collect();
        let planes = (0..3).map(plane).chain(channels.iter().map(|channel| channel.values.clone()));
        Self { size: [image.width, image.height], names: names.collect(), planes: planes.collect() }
    }
}

/// The connection to a display server.
pub struct DisplayServer {
    frames: SyncSender<Frame>,
    /// Receives nothing; it is closed when the thread ends.
    ended: Receiver<()>,
    thread: JoinHandle<()>,
    /// When the next image is due.
    due: Instant,
}

impl DisplayServer {
    /// Begins to connect to the server of `--display-server`, if there is one. The image is called `name`.
    pub fn new(args: &RenderArgs, name: String) -> Option<Self> {
        let address = args.display_server.clone()?;
        let quiet = args.quiet;
        let (frames, receiver) = mpsc::sync_channel(1);
        let (end, ended) = mpsc::channel();
        let thread = thread::spawn(move || {
            if let Err(reason) = serve(&address, &name, &receiver)
                && !quiet
            {
                terminal::warn(format_args!("the display server {address} shows no more images: {reason}"));
            }
            drop(end);
        });
        Some(Self { frames, ended, thread, due: Instant::now() })
    }

    /// Sends the image so far, with the channels of `--aov`, if it is due.
    ///
    /// # Errors
    /// The device fails.
    pub fn show(&mut self, args: &RenderArgs, renderer: &mut Renderer) -> Result<(), RenderError> {
        let start = Instant::now();
        if start < self.due || self.thread.is_finished() {
            return Ok(());
        }
        let estimate = renderer.estimate()?;
        let channels = aov::channels(&args.aov, &estimate, Some(renderer))?;
        // If the one before is not taken yet, the viewer misses this one.
        let _ = self.frames.try_send(Frame::new(&estimate.image(), &channels));
        self.due = Instant::now() + INTERVAL.max(LEAST_GAP * start.elapsed());
        Ok(())
    }

    /// Sends the last image, and waits until the viewer has it or has failed.
    pub fn finish(self, frame: Frame) {
        let start = Instant::now();
        let mut waiting = Some(frame);
        while let Some(frame) = waiting.take() {
            match self.frames.try_send(frame) {
                Err(mpsc::TrySendError::Full(frame)) if start.elapsed() < LAST_TIMEOUT => {
                    thread::sleep(Duration::from_millis(10));
                    waiting = Some(frame);
                }
                _ => {}
            }
        }
        drop(self.frames);
        // A thread that is stuck ends with the process.
        let _ = self.ended.recv_timeout(LAST_TIMEOUT);
    }
}

/// Connects, and sends images until there are no more.
fn serve(address: &str, name: &str, frames: &Receiver<Frame>) -> io::Result<()> {
    let mut client = TevClient::wrap(connect(address)?);
    let mut is_created = false;
    for frame in frames {
        let [width, height] = frame.size;
        if !is_created {
            let channel_names = &frame.names[..];
            client.send(PacketCreateImage { image_name: name, grab_focus: true, width, height, channel_names })?;
            is_created = true;
        }
        for first in (0..height as usize).step_by(ROWS) {
            send_rows(&mut client, name, &frame, first)?;
        }
    }
    Ok(())
}

/// Sends [`ROWS`] rows of all channels, or those that are left.
fn send_rows(client: &mut TevClient, name: &str, frame: &Frame, first: usize) -> io::Result<()> {
    let [width, height] = frame.size;
    let rows = ROWS.min(height as usize - first);
    let pixels = first * width as usize..(first + rows) * width as usize;
    let data: Vec<f32> = frame.planes.iter().flat_map(|plane| &plane[pixels.clone()]).copied().collect();
    let channel_offsets: Vec<u64> = (0..frame.planes.len()).map(|i| (i * pixels.len()) as u64).collect();
    client.send(PacketUpdateImage {
        image_name: name,
        grab_focus: false,
        channel_names: &frame.names,
        channel_offsets: &channel_offsets,
        channel_strides: &vec![1; frame.planes.len()],
        x: 0,
        y: first as u32,
        width,
        height: rows as u32,
        data: &data,
    })
}

fn connect(address: &str) -> io::Result<TcpStream> {
    let mut failure = io::Error::other("the name has no address");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, TIMEOUT) {
            Ok(stream) => {
                stream.set_write_timeout(Some(TIMEOUT))?;
                return Ok(stream);
            }
            Err(reason) => failure = reason,
        }
    }
    Err(failure)
}
