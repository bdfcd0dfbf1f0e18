//! `report.html`: the results as one page that needs no other file and no network.

use std::error::Error;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::plot::{color, passes, plots};
use super::results::{Conditions, Measured, Results};
use crate::image::file::encode_png;
use crate::image::film::Image;

/// The page shows the difference images of this many settings.
const SHOWN: usize = 64;

/// Returns the page. `differences` has an image for each setting, in their order.
///
/// # Errors
/// A plot cannot be drawn or an image not encoded.
pub fn html(results: &Results, differences: &[Option<Image>]) -> Result<String, Box<dyn Error>> {
    let title = format!("goblet measure: {}", results.conditions.scene);
    let plots = plots(results)?;
    let differences = differences_of(results, differences)?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width";
                title { (title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(include_str!("report.css"))) }
            }
            body {
                h1 { (title) }
                (conditions(&results.conditions))
                (table(results))
                div.plots {
                    @for plot in plots {
                        figure aria-label=(plot.title) { (PreEscaped(plot.svg)) }
                    }
                }
                h2 { "Passes" }
                p {
                    @for (index, pass) in passes(results).into_iter().enumerate() {
                        (swatch(index)) (pass) (PreEscaped(" &nbsp; "))
                    }
                }
                h2 { "Where the last images are off" }
                p {
                    "Red is too bright, blue too dark, green not finite; full colour is a root mean squared \
                     relative error of 1."
                }
                div.plots { (differences) }
            }
        }
    };
    Ok(page.into_string())
}

/// The difference images, each with the name of its setting.
fn differences_of(results: &Results, differences: &[Option<Image>]) -> Result<Markup, Box<dyn Error>> {
    let mut figures = Vec::new();
    for ((index, setting), difference) in results.settings.iter().enumerate().zip(differences).take(SHOWN) {
        let Some(image) = difference else { continue };
        let source = format!("data:image/png;base64,{}", STANDARD.encode(encode_png(image)?));
        figures.push(html! {
            figure {
                img alt="difference" width=(image.width) height=(image.height) src=(source);
                figcaption { (swatch(index)) (setting.label) }
            }
        });
    }
    Ok(html! { @for figure in figures { (figure) } })
}

fn conditions(conditions: &Conditions) -> Markup {
    let Conditions { machine, command, reference, budget, repeat, .. } = conditions;
    let commit = machine.commit.unwrap_or("unknown");
    let [width, height] = reference.resolution;
    html! {
        p { code { (command) } }
        p {
            (machine.device) " (driver " (machine.driver) ")"
            @if let Some(cpus) = machine.cpus { ", " (cpus) " CPU threads" }
            "; goblet " (machine.goblet) " at commit " (commit) "; " (machine.date) "."
        }
        p {
            "Reference: " (reference.path) " (" (width) "x" (height) ")"
            @if let Some(iterations) = reference.own_iterations {
                ". goblet rendered it itself, with " (iterations) " iterations"
                @if let Some(error) = reference.own_relative_error { " and a noise of " (format!("{error:.4}")) }
                ": its noise counts as error of the settings; blur that it has in common with them does not"
            }
            "."
        }
        p {
            (budget) " s for each setting in the first turn; " (repeat) " turn" @if *repeat != 1 { "s" }
            ", each with another seed. Settings take turns of a slice of time each. Times are of iterations \
             alone; figures are means over turns."
        }
    }
}

fn table(results: &Results) -> Markup {
    const HEADS: [&str; 13] = [
        "setting",
        "iterations",
        "photons",
        "start, s",
        "time, s",
        "relMSE",
        "trimmed",
        "noise",
        "bias",
        "mean energy",
        "FLIP",
        "memory, MiB",
        "on the front",
    ];
    html! {
        div.wide {
            table {
                tr { @for head in HEADS { th { (head) } } }
                @for (index, setting) in results.settings.iter().enumerate() { (row(index, setting)) }
            }
        }
    }
}

fn row(index: usize, setting: &Measured) -> Markup {
    let Some(last) = setting.points.last() else { return Markup::default() };
    let [noise, bias] = last.separated.map_or_else(Default::default, |it| [it.noise, it.bias].map(figures));
    let memory = setting.device_memory_bytes as f64 / f64::from(1 << 20);
    html! {
        tr {
            td { (swatch(index)) (setting.label) }
            td { (last.iterations) }
            td { (last.photons) }
            td { (format!("{:.2}", setting.start_seconds)) }
            td { (format!("{:.2}", last.seconds)) }
            td { (figures(last.relmse)) }
            td { (figures(last.relmse_trimmed)) }
            td { (noise) }
            td { (bias) }
            td { (format!("{:.4}", last.energy_ratio)) }
            td { (figures(last.flip)) }
            td { (format!("{memory:.0}")) }
            td { @if setting.on_front { "yes" } }
        }
    }
}

/// Three significant figures.
fn figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 12);
    format!("{value:.*}", decimals as usize)
}

fn swatch(index: usize) -> Markup {
    let plotters::style::RGBColor(r, g, b) = color(index);
    html! { span.swatch style=(format!("background:rgb({r},{g},{b})")) {} }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_three() {
        for (value, expected) in [(0.001234, "0.00123"), (12.345, "12.3"), (1234.0, "1234"), (0.0, "0")] {
            assert_eq!(figures(value), expected);
        }
    }
}
