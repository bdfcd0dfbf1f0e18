//! Mouse input on the image: it moves the camera.

use egui::{CentralPanel, Context, Frame, PointerButton, Response, Sense};

use super::session::Session;

/// The angle in radians that a drag by one point turns the camera.
const TURN: f64 = 0.008;
/// The factor of the distance to the pivot for each notch of the wheel.
const NOTCH: f64 = 0.9;
/// The scroll distance of a notch in points.
const NOTCH_POINTS: f64 = 50.0;
/// The radius of a lens that replaces a pinhole, in distances to the pivot.
const FIRST_LENS: f64 = 0.005;

/// Handles the mouse input of a frame: lets the user move the camera.
pub fn show(context: &Context, session: &mut Session) {
    CentralPanel::default().frame(Frame::NONE).show(context, |ui| {
        // The image never takes the keyboard focus, with which it would get all keys.
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

/// Handles a click: it focuses on the point under the cursor and moves the pivot there. Returns whether the
/// image changes.
fn click(response: &Response, session: &mut Session) -> bool {
    let position = response.interact_pointer_pos().filter(|_| response.clicked());
    let at = position.map(|position| session.on_image(pixels(&response.ctx, position)));
    let Some(point) = at.and_then(|at| session.point_at(at)) else { return false };
    session.control.focus(point);
    // A pinhole camera has everything in focus, so its image does not change.
    session.control.camera().lens_radius > 0.0
}

/// Handles the wheel: it moves the camera nearer, or, with Ctrl, opens the lens. Returns whether the camera
/// changed.
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
