//! `goblet view`: a window that shows a render. The thread of the window draws with a device of its own.
//! The render thread uses the device that `goblet render` would use, and follows the wishes of the window
//! as soon as the dispatch in flight is done.

mod app;
mod area;
mod bindings;
mod camera_control;
pub mod command;
mod compared;
mod dialog;
mod display;
mod doing;
mod guiding;
mod help;
mod histogram;
mod history;
#[cfg(test)]
mod key_tests;
mod keys;
mod latency;
mod layout;
mod paint;
mod panel;
mod plan;
mod quantity;
mod render_thread;
mod rendering;
mod session;
mod shared;
#[cfg(test)]
mod state_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod truth;
mod watch;

use std::path::Path;
use std::sync::Arc;

use app::{App, Wake};
use session::Session;
use shared::{Shared, Target, Wish};
use winit::event_loop::{EventLoop, EventLoopProxy};

use crate::cli::{Failure, RenderArgs};
use crate::render::options::Options;
use crate::scene::Scene;

pub use bindings::key_list;
pub use latency::LatencyStats;

/// Opens a window, and shows a scene until the window is closed. Returns the statistics of the window.
///
/// # Errors
/// There is no display, a device fails, a file cannot be written, or the validation layers have messages.
pub fn run(args: &RenderArgs, scene: Scene) -> Result<LatencyStats, Failure> {
    let events = EventLoop::<Wake>::with_user_event().build().map_err(Failure::window)?;
    let size = args.request.options.resolution.unwrap_or(scene.film.resolution);
    let options = Options { resolution: Some(size), ..args.options() };
    let proxy = events.create_proxy();
    let shared = Shared::new(first_wish(&args.scene, &options), move || wake(&proxy, Wake::News));
    let shared = Arc::new(shared);
    let save = args.output.first().map(|path| path.as_path());
    let mut session = Session::new(&args.scene, &scene, options, save, Arc::clone(&shared));
    session.set_exposure(args.exposure);
    let mut app = App::new(session, args.device.clone(), args.validate);
    let files = render_thread::files(&args.scene, &scene);
    let proxy = events.create_proxy();
    let outcome = std::thread::scope(|threads| {
        threads.spawn(|| render_thread::run(&shared, args, scene));
        threads.spawn(|| watch::run(&shared, files, || wake(&proxy, Wake::Changed)));
        let outcome = events.run_app(&mut app);
        shared.close();
        outcome
    });
    outcome.map_err(Failure::window)?;
    if let Some(failure) = app.failure {
        return Err(failure);
    }
    let mut news = shared.news();
    if let Some(failure) = news.unwritten.drain(..).next() {
        return Err(failure);
    }
    let messages: Vec<String> = app.validation.into_iter().chain(news.validation.drain(..)).collect();
    if !messages.is_empty() {
        return Err(Failure::Validation(messages));
    }
    Ok(LatencyStats { iterations: news.status.iterations, ..app.latency.stats })
}

fn wake(window: &EventLoopProxy<Wake>, wake: Wake) {
    // Sending fails only after the window is closed.
    let _ = window.send_event(wake);
}

fn first_wish(scene: &Path, options: &Options) -> Wish {
    Wish {
        scene: scene.to_owned(),
        target: Target { loads: 0, camera: None, options: Options { responsive: true, ..options.clone() } },
        moves: 0,
        moved: None,
        quantity: quantity::Quantity::Image,
        paused: false,
        saves: Vec::new(),
        close: false,
    }
}
