//! The application: it handles the events of the window and draws frames.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Context, ViewportId};
use glam::DVec3;
use goblet_host::Interface;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Window, WindowId};

use super::display::Display;
use super::keys::{Busy, Keys, Stroke, With};
use super::latency::Latency;
use super::layout::{Area, Opening, panel_pixels};
use super::session::{Effect, Session};
use super::{area, dialog, help, panel};
use crate::cli::Failure;

/// The application that the event loop drives.
pub struct App {
    /// The state of the user's session.
    pub session: Session,
    /// Measures the time that the user waits.
    pub latency: Latency,
    /// The error that ended the application early.
    pub failure: Option<Failure>,
    /// Messages of the validation layers, once the window is closed.
    pub validation: Vec<String>,
    device: Option<String>,
    validate: bool,
    context: Context,
    keys: Keys,
    /// The strokes since the last frame, each with the modifiers that were held with it.
    strokes: Vec<Stroke>,
    has_super: bool,
    /// The time to draw the next frame; `None` if no frame is due.
    draw_at: Option<Instant>,
    /// The earliest time of the next frame, which leaves time to render.
    draw_after: Instant,
    opened: Option<Opened>,
}

/// The pause after a frame, in multiples of the time that drawing the frame took.
const PAUSE: u32 = 2;
/// The longest pause after a frame.
const MOST_PAUSE: Duration = Duration::from_millis(25);
/// The speed of flight, in distances to the pivot per second.
const SPEED: f64 = 0.4;
/// The longest time of flight per frame, in seconds.
const LONGEST_FLIGHT: f32 = 0.1;

/// The state of an open window. The display is dropped before the window.
struct Opened {
    display: Display,
    input: egui_winit::State,
    window: Arc<Window>,
    /// The size of the window in the last frame, in pixels.
    size: [u32; 2],
    /// The title of the window.
    title: String,
    /// Whether the size of the window may differ from the size of the display.
    is_stale: bool,
}

impl App {
    /// Returns an application whose window opens on the named device, or on the first device that fits.
    pub fn new(session: Session, device: Option<String>, validate: bool) -> Self {
        Self {
            session,
            latency: Latency::default(),
            failure: None,
            validation: Vec::new(),
            device,
            validate,
            context: Context::default(),
            keys: Keys::default(),
            strokes: Vec::new(),
            has_super: false,
            draw_at: None,
            draw_after: Instant::now(),
            opened: None,
        }
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), Failure> {
        let screen = events.primary_monitor().or_else(|| events.available_monitors().next());
        let panel = panel_pixels(screen.as_ref().map_or(1.0, |screen| screen.scale_factor() as f32));
        let opening = Opening::new(self.session.image(), panel, screen.map(|screen| screen.size().into()));
        self.session.opens_with(opening.image);
        let title = self.session.title();
        let attributes = Window::default_attributes()
            .with_title(&title)
            .with_inner_size(PhysicalSize::<u32>::from(opening.window))
            .with_min_inner_size(PhysicalSize::<u32>::from(Opening::least(panel)));
        let window = events.create_window(attributes).map_err(Failure::window)?;
        let window = Arc::new(window);
        let display = Display::new(Arc::clone(&window), self.device.as_deref(), self.validate)?;
        let scale = window.scale_factor() as f32;
        let input =
            egui_winit::State::new(self.context.clone(), ViewportId::ROOT, &*window, Some(scale), window.theme(), None);
        let size = window.inner_size().into();
        self.opened = Some(Opened { display, input, window, size, title, is_stale: false });
        self.redraw();
        Ok(())
    }

    /// Adapts to the size of the window and takes the news. Returns false if the window has no area or is not
    /// open.
    fn catch_up(&mut self) -> Result<bool, Failure> {
        let Some(Opened { display, window, size: known, title: known_title, is_stale, .. }) = &mut self.opened else {
            return Ok(false);
        };
        let size: [u32; 2] = window.inner_size().into();
        if size.contains(&0) {
            return Ok(false);
        }
        let pixels_per_point = self.context.zoom_factor() * window.scale_factor() as f32;
        self.session.area = Area::of_image(size, self.session.has_panel, pixels_per_point);
        if std::mem::take(is_stale) {
            display.resize(size)?;
        }
        if std::mem::replace(known, size) != size {
            self.session.resized();
        }
        self.session.take_news();
        self.session.repaint(|shown| display.take(shown.size, &shown.pixels, shown.shade))?;
        let title = self.session.title();
        if *known_title != title {
            window.set_title(&title);
            *known_title = title;
        }
        Ok(true)
    }

    /// Draws a frame.
    fn draw(&mut self, events: &ActiveEventLoop) -> Result<(), Failure> {
        let start = Instant::now();
        self.draw_at = None;
        if !self.catch_up()? {
            return Ok(());
        }
        let (busy, moves) = (Busy::of(&self.context), self.session.moves);
        let Some(Opened { input, window, .. }) = &mut self.opened else { return Ok(()) };
        let mut asks = Vec::new();
        let output = self.context.run(input.take_egui_input(window), |context| {
            let asked = panel::show(context, &mut self.session);
            asks.extend(asked);
            area::show(context, &mut self.session);
            help::show(context, &mut self.session);
        });
        asks.into_iter().for_each(|asked| self.carry_out(events, asked));
        self.take_keys(events, busy.until(Busy::of(&self.context)));
        let Some(Opened { display, input, window, is_stale, .. }) = &mut self.opened else { return Ok(()) };
        if self.session.moves != moves {
            self.latency.moved(self.session.moves);
        }
        input.handle_platform_output(window, output.platform_output);
        let primitives = self.context.tessellate(output.shapes, output.pixels_per_point);
        let textures = output.textures_delta;
        let interface = Interface { primitives, textures, pixels_per_point: output.pixels_per_point };
        if display.show(self.session.look, self.session.placement(), interface)? {
            self.latency.shown(self.session.seen);
        } else {
            *is_stale = true;
            self.draw_at = Some(start);
        }
        self.draw_after = Instant::now() + MOST_PAUSE.min(PAUSE * start.elapsed());
        if let Some(viewport) = output.viewport_output.get(&ViewportId::ROOT) {
            let then = Instant::now().checked_add(viewport.repaint_delay);
            self.draw_at = self.draw_at.into_iter().chain(then).min();
        }
        Ok(())
    }

    /// Carries out the commands of the strokes since the last frame, and flies.
    fn take_keys(&mut self, events: &ActiveEventLoop, busy: Busy) {
        let strokes = std::mem::take(&mut self.strokes);
        if busy.with_keys {
            self.keys.release();
        }
        for stroke in &strokes {
            if let Some(effect) = self.keys.take(*stroke, busy).and_then(|command| self.session.obey(command)) {
                self.carry_out(events, effect);
            }
        }
        let Some(Opened { input, .. }) = &mut self.opened else { return };
        let by = self.keys.flight(input.egui_input().modifiers.shift);
        let time = self.context.input(|input| input.stable_dt.min(LONGEST_FLIGHT));
        if by != DVec3::ZERO {
            self.session.moves(|control| control.fly(by * SPEED * f64::from(time)));
        }
        if by != DVec3::ZERO || !strokes.is_empty() {
            self.redraw();
        }
    }

    /// Carries out the part of a command that needs the window.
    fn carry_out(&mut self, events: &ActiveEventLoop, effect: Effect) {
        let Some(Opened { input, window, .. }) = &mut self.opened else { return };
        match effect {
            Effect::Copy(text) => input.set_clipboard_text(text),
            Effect::Ask(question, start) => {
                let shared = self.session.shared();
                let tell = move |answer| shared.tell(|news| news.answer = Some((question, answer)));
                dialog::ask(question, &start, window, tell);
            }
            Effect::Quit => events.exit(),
        }
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

/// An event from another thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wake {
    /// The render thread has news.
    News,
    /// A file of the scene has changed.
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
        let known = opened.input.egui_input().events.len();
        let response = opened.input.on_window_event(&opened.window, &event);
        match &event {
            WindowEvent::KeyboardInput { event, .. } => {
                let input = opened.input.egui_input();
                let is_repeat = event.repeat;
                self.strokes
                    .extend(input.events[known..].iter().filter_map(|event| stroke(event, is_repeat, self.has_super)));
                self.latency.input();
            }
            WindowEvent::ModifiersChanged(modifiers) => self.has_super = modifiers.state().super_key(),
            WindowEvent::Focused(false) => self.strokes.extend(Keys::all_up()),
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => {
                let outcome = self.draw(events);
                return self.check(events, outcome);
            }
            WindowEvent::Resized(_) => opened.is_stale = true,
            WindowEvent::DroppedFile(path) => self.session.drop_file(path),
            WindowEvent::CursorMoved { .. } | WindowEvent::MouseInput { .. } | WindowEvent::MouseWheel { .. } => {
                self.latency.input()
            }
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

/// Returns the stroke of a key event; `None` for other events.
fn stroke(event: &egui::Event, is_repeat: bool, has_super: bool) -> Option<Stroke> {
    let egui::Event::Key { key, pressed, modifiers, .. } = event else { return None };
    let egui::Modifiers { alt, ctrl, shift, command, .. } = *modifiers;
    // If Cmd is the key of commands, it is also the Super key, and Ctrl is not the key of commands.
    let is_cmd = command && !ctrl;
    let other = alt || (ctrl && !command) || (has_super && !is_cmd);
    Some(Stroke { key: *key, is_pressed: *pressed, is_repeat, with: With { command, other, shift } })
}
