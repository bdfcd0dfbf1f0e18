//! What is shown, in which colours, and how brightly.

use egui::{Align, Color32, ComboBox, Layout, Rect, RichText, Sense, Slider, Ui, vec2};

use crate::viewer::display::Curve;
use crate::viewer::false_color;
use crate::viewer::paint::{Colors, Scale, Shade};
use crate::viewer::quantity::Quantity;
use crate::viewer::session::{EXPOSURES, Session};

/// Shows the controls of the picture's look.
pub fn show(ui: &mut Ui, session: &mut Session) {
    let mut wanted = session.quantity;
    ComboBox::from_label("shown").selected_text(wanted.name()).show_ui(ui, |ui| {
        for quantity in Quantity::ALL {
            ui.selectable_value(&mut wanted, quantity, quantity.name()).on_hover_text(quantity.help());
        }
    });
    session.show(wanted);
    let (quantity, mut colors) = (session.quantity, session.colors);
    ComboBox::from_label("colours").selected_text(colors.name(quantity)).width(190.0).show_ui(ui, |ui| {
        for other in Colors::all(quantity) {
            ui.selectable_value(&mut colors, other, other.name(quantity));
        }
    });
    session.color(colors);
    match session.scale {
        Some(scale) => bar(ui, &scale, &session.unit()),
        None => white(ui, session),
    }
    let shade = colors.shade(quantity);
    let exposure = Slider::new(&mut session.look.stops, EXPOSURES[0]..=EXPOSURES[1]).text("exposure, stops");
    ui.add_enabled(shade != Shade::Fixed, exposure).on_hover_text("O: darker; P: brighter");
    ui.add_enabled_ui(shade == Shade::Light, |ui| {
        ComboBox::from_label("tone map").selected_text(session.look.curve.name()).show_ui(ui, |ui| {
            for curve in Curve::ALL {
                ui.selectable_value(&mut session.look.curve, curve, curve.name());
            }
        });
    });
}

/// Shows the value that is white.
fn white(ui: &mut Ui, session: &Session) {
    let picture = session.picture.as_ref();
    let white = picture.and_then(|picture| picture.ends).map_or(1.0, |[_, most]| most) * (-session.look.stops).exp2();
    let is_white = matches!(session.colors.shade(session.quantity), Shade::Light) || session.quantity.axes().len() == 1;
    let text = match (is_white, white.is_finite()) {
        (true, true) => format!("white is {} {}", super::figure(white), session.unit()),
        (true, false) => "not known after so few iterations".to_owned(),
        (false, _) => session.unit(),
    };
    ui.label(RichText::new(text).small());
}

/// Shows the scale of false colours between its ends, with the unit.
fn bar(ui: &mut Ui, scale: &Scale, unit: &str) {
    let (bar, response) = ui.allocate_exact_size(vec2(ui.available_width(), 12.0), Sense::hover());
    response.on_hover_text("black is no value, or 0");
    let steps = bar.width().max(1.0) as u32;
    for step in 0..steps {
        let at = step as f32 / steps as f32;
        let part = Rect::from_min_size(bar.min + vec2(at * bar.width(), 0.0), vec2(1.5, bar.height()));
        let [r, g, b] = false_color::color(at).map(|channel| (255.0 * channel).round() as u8);
        ui.painter().rect_filled(part.intersect(bar), 0.0, Color32::from_rgb(r, g, b));
    }
    let [first, last] = scale.ends.map(super::figure);
    between(ui, &first, &last);
    let kind = if scale.is_log { "logarithmic" } else { "linear" };
    let text = if unit.is_empty() { format!("{kind} scale") } else { format!("{unit}, {kind} scale") };
    ui.label(RichText::new(text).small());
}

/// Shows a text at the left and one at the right.
pub fn between(ui: &mut Ui, first: &str, last: &str) {
    ui.horizontal(|ui| {
        ui.label(first);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.label(last));
    });
}
