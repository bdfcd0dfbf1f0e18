//! What is shown, in which colours, and how brightly.

use egui::{Color32, ComboBox, Rect, RichText, Sense, Slider, SliderClamping, Ui, vec2};

use super::parts::{between, figure};
use crate::image::exposure::Exposure;
use crate::image::false_color::Palette;
use crate::viewer::display::Curve;
use crate::viewer::paint::{Colors, Scale, Shade};
use crate::viewer::quantity::Quantity;
use crate::viewer::session::{EXPOSURES, Session};

/// Width of the lists in points.
const WIDTH: f32 = 190.0;

/// Shows the controls of the picture's look.
pub fn show(ui: &mut Ui, session: &mut Session) {
    let mut wanted = session.quantity;
    ComboBox::from_label("shown").width(WIDTH).selected_text(wanted.name()).show_ui(ui, |ui| {
        for quantity in Quantity::ALL {
            ui.selectable_value(&mut wanted, quantity, quantity.name()).on_hover_text(quantity.help());
        }
    });
    session.show(wanted);
    let (quantity, mut colors) = (session.quantity, session.colors);
    ComboBox::from_label("colours").selected_text(colors.name(quantity)).width(WIDTH).show_ui(ui, |ui| {
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
    ui.add_enabled_ui(shade != Shade::Fixed, |ui| exposure(ui, session));
    ui.add_enabled_ui(shade == Shade::Light, |ui| {
        ComboBox::from_label("tone map").width(WIDTH).selected_text(session.look.curve.name()).show_ui(ui, |ui| {
            for curve in Curve::ALL {
                ui.selectable_value(&mut session.look.curve, curve, curve.name());
            }
        });
    });
}

/// Shows the exposure in stops, and whether it follows from the image.
fn exposure(ui: &mut Ui, session: &mut Session) {
    ui.horizontal(|ui| {
        let mut stops = session.look.stops;
        // A number from the command line may be beyond the range of the slider.
        let slider = Slider::new(&mut stops, EXPOSURES[0]..=EXPOSURES[1]).clamping(SliderClamping::Edits);
        let slider = slider.fixed_decimals(2).text("exposure");
        let response = ui.add(slider).on_hover_text("in stops; O: darker; P: brighter");
        if response.changed() && stops != session.look.stops {
            session.set_exposure(Exposure::Stops(stops));
        }
        let mut is_auto = session.has_auto_exposure;
        ui.checkbox(&mut is_auto, "auto").on_hover_text("L: middle grey for the mean of the image");
        if is_auto != session.has_auto_exposure {
            session.auto_expose(is_auto);
        }
    });
}

/// Shows the value that is white.
fn white(ui: &mut Ui, session: &Session) {
    let picture = session.picture.as_ref();
    let white = picture.and_then(|picture| picture.ends).map_or(1.0, |[_, most]| most) * (-session.look.stops).exp2();
    let is_white = matches!(session.colors.shade(session.quantity), Shade::Light) || session.quantity.axes().len() == 1;
    let text = match (is_white, white.is_finite()) {
        (true, true) => format!("white is {} {}", figure(white), session.unit()),
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
        let [r, g, b] = Palette::Viridis.color(at).map(|channel| (255.0 * channel).round() as u8);
        ui.painter().rect_filled(part.intersect(bar), 0.0, Color32::from_rgb(r, g, b));
    }
    let [first, last] = scale.ends.map(figure);
    between(ui, &first, &last);
    let kind = if scale.is_log { "logarithmic" } else { "linear" };
    let text = if unit.is_empty() { format!("{kind} scale") } else { format!("{unit}, {kind} scale") };
    ui.label(RichText::new(text).small());
}
