//! The window: events in, frames out.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Context, ViewportCommand, ViewportId};
use goblet_host::Interface;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Window, WindowId};

use super::display::Display;
use super::latency::Latency;
use super::session::Session;
use super::{area, panel};
use crate::cli::Failure;

/// What the event loop drives.
pub struct App {
    /// What the user looks at.
    pub session: Session,
    /// How long the user waits.
    pub latency: Latency,
    /// Why it has ended early.
    pub failure: Option<Failure>,
    /// Messages of the validation layer.
    pub validation: Vec<String>,
    size: [u32; 2],
    device: Option<String>,
    validate: bool,
    context: Context,
    /// When the window is to be drawn next, if it is.
    draw_at: Option<Instant>,
    /// But not before: drawing must leave time to render.
    draw_after: Instant,
    opened: Option<Opened>,
}

/// The window pauses so many times as long as it draws ..
const PAUSE: u32 = 2;
/// .. but no longer than this.
const MOST_PAUSE: Duration = Duration::from_millis(25);

/// What there is once the window is open. The display goes before the window.
struct Opened {
    display: Display,
    input: egui_winit::State,
    window: Arc<Window>,
    /// Whether the window may have another size than its pixels.
    is_stale: bool,
}

impl App {
    /// With a window of this size, on the device that is named, or the first that fits.
    pub fn new(session: Session, size: [u32; 2], device: Option<String>, validate: bool) -> Self {
        Self {
            session,
            latency: Latency::default(),
            failure: None,
            validation: Vec::new(),
            size,
            device,
            validate,
            context: Context::default(),
            draw_at: None,
            draw_after: Instant::now(),
            opened: None,
        }
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), Failure> {
        let screen = events.primary_monitor().or_else(|| events.available_monitors().next());
        let [width, height] = fit(self.size, screen.map(|screen| screen.size().into()));
        let attributes =
            Window::default_attributes().with_title("goblet").with_inner_size(PhysicalSize::new(width, height));
        let window = events.create_window(attributes).map_err(|error| Failure::Window(error.to_string()))?;
        let window = Arc::new(window);
        let display = Display::new(Arc::clone(&window), self.device.as_deref(), self.validate)?;
        let scale = window.scale_factor() as f32;
        let input =
            egui_winit::State::new(self.context.clone(), ViewportId::ROOT, &*window, Some(scale), window.theme(), None);
        self.session.resized(window.inner_size().into());
        self.opened = Some(Opened { display, input, window, is_stale: false });
        self.redraw();
        Ok(())
    }

    /// Shows what there is.
    fn draw(&mut self, events: &ActiveEventLoop) -> Result<(), Failure> {
        let Some(Opened { display, input, window, is_stale }) = &mut self.opened else { return Ok(()) };
        let start = Instant::now();
        self.draw_at = None;
        let size: [u32; 2] = window.inner_size().into();
        if size.contains(&0) {
            return Ok(()); // there is nothing to be seen
        }
        if std::mem::take(is_stale) {
            display.resize(size)?;
            self.session.resized(size);
        }
        if let Some(picture) = self.session.take_news() {
            display.take(&picture)?;
        }
        self.session.placement = display.placement();
        let moves = self.session.moves;
        let output = self.context.run(input.take_egui_input(window), |context| {
            panel::show(context, &mut self.session);
            area::show(context, &mut self.session);
        });
        if self.session.moves != moves {
            self.latency.moved(self.session.moves);
        }
        input.handle_platform_output(window, output.platform_output);
        let primitives = self.context.tessellate(output.shapes, output.pixels_per_point);
        let textures = output.textures_delta;
        let interface = Interface { primitives, textures, pixels_per_point: output.pixels_per_point };
        if display.show(self.session.look, interface)? {
            self.latency.shown(self.session.seen);
        } else {
            *is_stale = true;
            self.draw_at = Some(start);
        }
        self.draw_after = Instant::now() + MOST_PAUSE.min(PAUSE * start.elapsed());
        if let Some(viewport) = output.viewport_output.get(&ViewportId::ROOT) {
            if viewport.commands.contains(&ViewportCommand::Close) {
                events.exit();
            }
            let then = Instant::now().checked_add(viewport.repaint_delay);
            self.draw_at = self.draw_at.into_iter().chain(then).min();
        }
        Ok(())
    }

    fn check(&mut self, events: &ActiveEventLoop, outcome: Result<(), Failure>) {
        if let Err(failure) = outcome {
            self.failure = Some(failure);
            events.exit();
        }
    }

    fn redraw(&mut self) {
        self.draw_at = Some(Instant::now());
    }
}

/// An event of another thread: there are news, or files have changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wake {
    /// The thread that renders has something to tell.
    News,
    /// A file of the scene is another one.
    Changed,
}

impl ApplicationHandler<Wake> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.opened.is_none() {
            let outcome = self.open(events);
            self.check(events, outcome);
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, _: StartCause) {
        self.latency.looks();
    }

    fn user_event(&mut self, _: &ActiveEventLoop, wake: Wake) {
        if wake == Wake::Changed {
            self.session.reload();
        }
        self.redraw();
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(opened) = &mut self.opened else { return };
        let response = opened.input.on_window_event(&opened.window, &event);
        match &event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => {
                let outcome = self.draw(events);
                return self.check(events, outcome);
            }
            WindowEvent::Resized(_) => opened.is_stale = true,
            WindowEvent::DroppedFile(path) => self.session.open(path),
            WindowEvent::CursorMoved { .. }
            | WindowEvent::MouseInput { .. }
            | WindowEvent::MouseWheel { .. }
            | WindowEvent::KeyboardInput { .. } => self.latency.input(),
            _ => {}
        }
        if response.repaint {
            self.redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let draw_at = self.draw_at.map(|when| when.max(self.draw_after));
        match (draw_at, &self.opened) {
            (Some(when), Some(opened)) if when <= Instant::now() => opened.window.request_redraw(),
            (Some(when), _) => events.set_control_flow(ControlFlow::WaitUntil(when)),
            (None, _) => events.set_control_flow(ControlFlow::Wait),
        }
        self.latency.rests();
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        if let Some(opened) = self.opened.take() {
            self.validation = opened.display.validation_messages();
        }
    }
}

/// A size that fits a screen, in the same proportions.
fn fit([width, height]: [u32; 2], screen: Option<[u32; 2]>) -> [u32; 2] {
    let [most_width, most_height] = screen.unwrap_or([width, height]).map(f64::from);
    let scale = (most_width / f64::from(width)).min(most_height / f64::from(height)).min(1.0);
    [width, height].map(|side| ((f64::from(side) * scale) as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::fit;

    #[test]
    fn windows_are_no_larger_than_the_screen() {
        assert_eq!(fit([640, 480], Some([1920, 1080])), [640, 480]);
        assert_eq!(fit([4000, 1000], Some([2000, 1000])), [2000, 500]);
        assert_eq!(fit([4000, 1000], None), [4000, 1000]);
    }
}
