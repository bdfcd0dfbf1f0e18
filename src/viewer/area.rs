//! The image in the window: mouse input that moves the camera or the image, and the line between two images.

use egui::{
    Align2, CentralPanel, Color32, Context, Event, FontId, Frame, PointerButton, Pos2, Rect, Response, Sense, Stroke,
};
use egui::{Ui, pos2, vec2};

use super::compared::Beside;
use super::layout::Placement;
use super::session::Session;

/// The angle in radians that a drag by one point turns the camera.
const TURN: f64 = 0.008;
/// The factor of the distance to the pivot for each notch of the wheel.
const NOTCH: f64 = 0.9;
/// The scroll distance of a notch in points.
const NOTCH_POINTS: f64 = 50.0;
/// The scroll distance in points by which the image is enlarged to twice its size.
const DOUBLE_POINTS: f32 = 100.0;
/// The radius of a lens that replaces a pinhole, in distances to the pivot.
const FIRST_LENS: f64 = 0.005;
/// The distance in points from the line between two images at which the mouse takes it.
const NEAR_LINE: f32 = 6.0;

/// Handles the mouse input of a frame: lets the user move the camera, the image in the window, and the line between two
/// images.
pub fn show(context: &Context, session: &mut Session) {
    CentralPanel::default().frame(Frame::NONE).show(context, |ui| {
        // The image never takes the keyboard focus, with which it would get all keys.
        let response = ui.interact(ui.max_rect(), ui.id().with("image"), Sense::CLICK | Sense::DRAG);
        let is_there = ui.rect_contains_pointer(ui.max_rect());
        session.cursor = context.pointer_latest_pos().filter(|_| is_there).map(|position| pixels(context, position));
        let is_alt = context.input(|input| input.modifiers.alt);
        if !line(ui, &response, session) {
            drag(&response, session, is_alt);
            click(&response, session);
        }
        wheel(context, &response, session);
    });
}

/// Draws the line between two images, and lets the user drag it. Returns whether it is being dragged.
fn line(ui: &Ui, response: &Response, session: &mut Session) -> bool {
    let Beside::Split(share) = session.compared.beside else { return false };
    let Some(other) = session.compared.other.as_ref().filter(|_| session.shows_other()) else { return false };
    let points = 1.0 / ui.ctx().pixels_per_point();
    let Placement { origin, size, .. } = session.placement();
    let (left, width) = (origin[0] * points, size[0] * points);
    let area = response.rect;
    let top = (origin[1] * points).max(area.top());
    let x = left + share * width;
    let painter = ui.painter_at(area);
    painter.vline(x, area.y_range(), Stroke::new(1.0, Color32::WHITE));
    for (name, align, side) in [("this image", Align2::RIGHT_TOP, -6.0), (&other.name, Align2::LEFT_TOP, 6.0)] {
        label(&painter, pos2(x + side, top + 6.0), align, name);
    }
    let id = response.id.with("line");
    let grip = Rect::from_x_y_ranges(x - NEAR_LINE..=x + NEAR_LINE, area.y_range()).intersect(area);
    let grip = ui.interact(grip, id, Sense::DRAG).on_hover_and_drag_cursor(egui::CursorIcon::ResizeHorizontal);
    if let Some(position) = grip.interact_pointer_pos().filter(|_| grip.dragged()) {
        session.set_beside(Beside::Split((position.x - left) / width.max(1.0)));
    }
    grip.dragged()
}

/// Writes a text on the image, with a dark ground.
fn label(painter: &egui::Painter, place: Pos2, align: Align2, text: &str) {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(13.0), Color32::WHITE);
    let rect = align.anchor_size(place, galley.size());
    painter.rect_filled(rect.expand2(vec2(4.0, 2.0)), 3.0, Color32::from_black_alpha(170));
    painter.galley(rect.min, galley, Color32::WHITE);
}

fn pixels(context: &Context, position: egui::Pos2) -> [f32; 2] {
    [position.x, position.y].map(|point| point * context.pixels_per_point())
}

fn drag(response: &Response, session: &mut Session, is_alt: bool) {
    let delta = response.drag_delta();
    let Some(position) = response.interact_pointer_pos().filter(|_| response.dragged()) else {
        session.grabbed = None;
        return;
    };
    if delta == egui::Vec2::ZERO {
        return;
    }
    let pans = !response.dragged_by(PointerButton::Primary) || response.ctx.input(|input| input.modifiers.shift);
    if is_alt || response.dragged_by(PointerButton::Middle) {
        let by = pixels(&response.ctx, delta.to_pos2());
        session.zoom = session.zoom.dragged(by, session.area, session.image());
    } else if pans {
        let [from, to] = [position - delta, position].map(|position| session.on_image(pixels(&response.ctx, position)));
        if session.grabbed.is_none() {
            session.grabbed = session.point_at(from).map(|point| session.control.depth_of(point));
        }
        session.pan(from, to);
    } else {
        session.moves(|control| control.orbit(TURN * f64::from(delta.x), TURN * f64::from(delta.y)));
    }
}

/// Handles a click: it focuses on the point under the cursor and moves the pivot there.
fn click(response: &Response, session: &mut Session) {
    let position = response.interact_pointer_pos().filter(|_| response.clicked());
    let at = position.map(|position| session.on_image(pixels(&response.ctx, position)));
    let Some(point) = at.and_then(|at| session.point_at(at)) else { return };
    session.moves_if(|control| {
        control.focus(point);
        // A pinhole camera has everything in focus, so its image does not change.
        control.camera().lens_radius > 0.0
    });
}

/// Handles the wheel: it moves the camera nearer, opens the lens with Ctrl, or enlarges the image with Alt.
fn wheel(context: &Context, response: &Response, session: &mut Session) {
    // The last turn goes on smoothly for some frames, even if Alt is released meanwhile.
    let with_alt = |event: &Event| match event {
        Event::MouseWheel { modifiers, .. } => Some(modifiers.alt),
        _ => None,
    };
    let turned = context.input(|input| input.events.iter().rev().find_map(with_alt));
    session.enlarges = turned.unwrap_or(session.enlarges);
    let Some(position) = response.hover_pos() else { return };
    let (scroll, zoom) = context.input(|input| (input.smooth_scroll_delta.y, input.zoom_delta()));
    if zoom != 1.0 {
        session.moves(|control| {
            let camera = *control.camera();
            let radius = if camera.lens_radius > 0.0 { camera.lens_radius } else { FIRST_LENS * control.distance() };
            control.set_lens(radius * f64::from(zoom), camera.focal_distance);
        });
    } else if scroll != 0.0 && session.enlarges {
        let at = pixels(context, position);
        session.zoom = session.zoom.by((scroll / DOUBLE_POINTS).exp2(), at, session.area, session.image());
    } else if scroll != 0.0 {
        session.moves(|control| control.dolly(NOTCH.powf(f64::from(scroll) / NOTCH_POINTS)));
    }
}
