//! The options of the render in the panel: those that trade time, noise and blur.

use egui::emath::Numeric;
use egui::{ComboBox, DragValue, Ui};

use crate::base::names::Named;
use crate::gpu_scene::pack::RevolutionSolver;
use crate::render::options::table::{Fallback, RenderOption, find};
use crate::viewer::session::Session;

const PHOTONS: &RenderOption = find("photons");
const EYE_PATHS: &RenderOption = find("eye-paths");
const ALPHA: &RenderOption = find("alpha");
const RADIUS: &RenderOption = find("radius");
const RADIUS_SCHEDULE: &RenderOption = find("radius-schedule");
const LOOKUP: &RenderOption = find("lookup");
const DIRECT: &RenderOption = find("direct");
const SAMPLER: &RenderOption = find("sampler");
const GUIDE: &RenderOption = find("guide");
const DISPERSION: &RenderOption = find("dispersion");

/// Returns the name of an option in the panel.
fn label(option: &RenderOption) -> String {
    option.name.replace('-', " ")
}

/// Shows a list of the names of an option's values.
fn choice<T: Named>(ui: &mut Ui, option: &RenderOption, value: &mut T) {
    let list = ComboBox::from_label(label(option)).selected_text(value.name()).show_ui(ui, |ui| {
        for (other, (name, line)) in T::ALL.iter().zip(T::NAMES) {
            ui.selectable_value(value, *other, *name).on_hover_text(line.trim());
        }
    });
    list.response.on_hover_text(option.help);
}

/// Shows a field for a number, if the option has a number as its default. `speed` is the change per point of
/// a drag.
fn number<T: Numeric>(ui: &mut Ui, option: &RenderOption, value: &mut Option<T>, speed: f64) {
    if let (Fallback::Number(first, _), Some(range)) = (&option.fallback, option.range()) {
        number_from(ui, option, value, (T::from_f64(*first), range.map(T::from_f64)), speed);
    }
}

/// Shows a field for a number. When the user enables the field, the number is `first`; edits keep it within
/// the range.
fn number_from<T: Numeric>(
    ui: &mut Ui,
    option: &RenderOption,
    value: &mut Option<T>,
    (first, [least, most]): (T, [T; 2]),
    speed: f64,
) {
    ui.horizontal(|ui| {
        let mut is_own = value.is_some();
        ui.checkbox(&mut is_own, label(option)).on_hover_text(option.help);
        *value = is_own.then(|| value.unwrap_or(first));
        if let Some(value) = value {
            // A range may change with the camera; a value that the user has set does not change.
            let number = DragValue::new(value).range(least..=most).clamp_existing_to_range(false);
            ui.add(number.speed(speed).update_while_editing(false));
        }
    });
}

/// Shows the options.
pub fn show(ui: &mut Ui, session: &mut Session) {
    let (photons, radius) = (session.own_photons(), session.own_radius());
    let options = &mut session.options;
    let before = options.clone();
    if let Some([least, most]) = PHOTONS.range() {
        number_from(ui, PHOTONS, &mut options.photons, (photons, [least as u64, most as u64]), 1e3);
    }
    number(ui, EYE_PATHS, &mut options.eye_paths, 0.05);
    number(ui, ALPHA, &mut options.alpha, 0.005);
    number_from(ui, RADIUS, &mut options.radius, (radius, [0.01 * radius, 1e4 * radius]), 0.02 * radius);
    choice(ui, RADIUS_SCHEDULE, &mut options.radius_schedule);
    choice(ui, LOOKUP, &mut options.lookup);
    choice(ui, DIRECT, &mut options.direct);
    choice(ui, GUIDE, &mut options.guidance);
    choice(ui, DISPERSION, &mut options.dispersion);
    choice(ui, SAMPLER, &mut options.sampler);
    let mut newton = options.revolution_solver != RevolutionSolver::Certified;
    ui.checkbox(&mut newton, "classical solver for bodies of revolution");
    if newton != (options.revolution_solver != RevolutionSolver::Certified) {
        options.revolution_solver = if newton { RevolutionSolver::NEWTON } else { RevolutionSolver::Certified };
    }
    if *options != before {
        session.changed_options();
    }
}
