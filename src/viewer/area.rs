//! The mouse on the image.

use egui::{CentralPanel, Context, Frame, PointerButton, Response, Sense};

use super::session::Session;

/// Radians of a drag across a point.
const TURN: f64 = 0.008;
/// Nearer by so much with each notch of the wheel.
const NOTCH: f64 = 0.9;
/// Points of a notch.
const NOTCH_POINTS: f64 = 50.0;
/// A lens where there was none, in distances to the pivot.
const FIRST_LENS: f64 = 0.005;

/// Lets the user move the camera.
pub fn show(context: &Context, session: &mut Session) {
    CentralPanel::default().frame(Frame::NONE).show(context, |ui| {
        // It never has the focus of the keyboard, with which keys would be for it alone.
        let response = ui.interact(ui.max_rect(), ui.id().with("image"), Sense::CLICK | Sense::DRAG);
        let mut moved = drag(&response, session);
        moved |= click(&response, session);
        moved |= wheel(context, &response, session);
        if moved {
            session.moved();
        }
    });
}

fn pixels(context: &Context, position: egui::Pos2) -> [f32; 2] {
    [position.x, position.y].map(|point| point * context.pixels_per_point())
}

fn drag(response: &Response, session: &mut Session) -> bool {
    let delta = response.drag_delta();
    let Some(position) = response.interact_pointer_pos().filter(|_| response.dragged()) else {
        session.grabbed = None;
        return false;
    };
    let pans = !response.dragged_by(PointerButton::Primary) || response.ctx.input(|input| input.modifiers.shift);
    if delta == egui::Vec2::ZERO {
        return false;
    }
    if pans {
        let [from, to] = [position - delta, position].map(|position| session.on_image(pixels(&response.ctx, position)));
        if session.grabbed.is_none() {
            session.grabbed = session.point_at(from).map(|point| session.control.depth_of(point));
        }
        session.pan(from, to);
    } else {
        session.control.orbit(TURN * f64::from(delta.x), TURN * f64::from(delta.y));
    }
    true
}

/// A click focuses, and what it hits is what the camera turns about.
fn click(response: &Response, session: &mut Session) -> bool {
    let position = response.interact_pointer_pos().filter(|_| response.clicked());
    let at = position.map(|position| session.on_image(pixels(&response.ctx, position)));
    let Some(point) = at.and_then(|at| session.point_at(at)) else { return false };
    session.control.focus(point);
    // Through a pinhole everything is sharp.
    session.control.camera().lens_radius > 0.0
}

/// The wheel goes nearer; with Ctrl it opens the lens.
fn wheel(context: &Context, response: &Response, session: &mut Session) -> bool {
    if !response.hovered() {
        return false;
    }
    let (scroll, zoom) = context.input(|input| (input.smooth_scroll_delta.y, input.zoom_delta()));
    if zoom != 1.0 {
        let camera = *session.control.camera();
        let radius =
            if camera.lens_radius > 0.0 { camera.lens_radius } else { FIRST_LENS * session.control.distance() };
        session.control.set_lens(radius * f64::from(zoom), camera.focal_distance);
        return true;
    }
    if scroll == 0.0 {
        return false;
    }
    session.control.dolly(NOTCH.powf(f64::from(scroll) / NOTCH_POINTS));
    true
}
