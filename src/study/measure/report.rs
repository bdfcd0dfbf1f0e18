//! `report.html`: the results as one page that needs no other file and no network.

mod pictures;
mod words;

use std::collections::BTreeSet;
use std::error::Error;
use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::measured::Measured;
use super::plot::{Plot, color, is_dashed, passes, plots};
use super::results::{Conditions, Results};
use super::verdict::figures;
use crate::image::film::Image;
use pictures::SHOWN;

pub use pictures::LastImage;

/// What a page may load: nothing but what is in it. Browsers hold it to that.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// Returns the page. `shown` has the pictures of each setting, in their order; `None` for a setting without any.
///
/// # Errors
/// A plot cannot be drawn or an image not encoded.
pub fn html(results: &Results, reference: &Image, shown: &[Option<LastImage>]) -> Result<String, Box<dyn Error>> {
    let scene = Path::new(&results.conditions.scene);
    let title = format!("goblet measure: {}", scene.file_name().unwrap_or(scene.as_os_str()).display());
    let names = Names::new(&results.settings);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(include_str!("report.css"))) (pictures::reference_style(reference, results.exposure_stops)?) }
                script { (PreEscaped(include_str!("report.js"))) }
            }
            body {
                h1 { (title) }
                (verdict(results, &names))
                (shared(&names))
                (table(results, &names))
                (turns(results, &names))
                h2 { "Charts" }
                div.grid { @for plot in plots(results)? { (figure(plot, &names)) } }
                h2 { "Where the time of an iteration goes" }
                (stack(results, &names))
                (all_pictures(&names, results.exposure_stops, shown)?)
                h2 { "What the words mean" }
                (words::list())
                h2 { "How it was measured" }
                (conditions(&results.conditions))
            }
        }
    };
    Ok(page.into_string())
}

/// The names of settings on the page: what all have in common is said once.
struct Names {
    /// For each setting.
    names: Vec<String>,
    /// The options of all settings, as `goblet render` takes them; empty if there are none.
    shared: String,
}

impl Names {
    fn new(settings: &[Measured]) -> Self {
        let all: Vec<BTreeSet<_>> = settings.iter().map(|setting| setting.knobs.iter().collect()).collect();
        let common = all.iter().cloned().reduce(|a, b| &a & &b).filter(|_| settings.len() > 1).unwrap_or_default();
        let name = |setting: &Measured, own: &BTreeSet<(&&'static str, &String)>| {
            let rest: Vec<String> = own.difference(&common).map(|(knob, value)| format!("{knob}={value}")).collect();
            if rest.is_empty() && !common.is_empty() {
                "no other option".to_owned()
            } else if rest.is_empty() {
                setting.label.clone()
            } else {
                rest.join(" ")
            }
        };
        let names = settings.iter().zip(&all).map(|(setting, own)| name(setting, own)).collect();
        let shared: Vec<String> = common.iter().map(|(knob, value)| format!("--{knob} {value}")).collect();
        Self { names, shared: shared.join(" ") }
    }
}

fn verdict(results: &Results, names: &Names) -> Markup {
    let sentences = results.verdict.as_ref().map(|verdict| verdict.sentences(&names.names)).unwrap_or_default();
    html! {
        div.verdict {
            @for sentence in &sentences { p { (sentence) } }
            @if sentences.is_empty() { p { "No setting has an image whose error is a number." } }
        }
    }
}

fn shared(names: &Names) -> Markup {
    html! {
        @if !names.shared.is_empty() {
            p { "All settings have " code { (names.shared) } "; the names below say what differs." }
        }
    }
}

/// The last image of each setting in figures.
fn table(results: &Results, names: &Names) -> Markup {
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
        "front",
    ];
    let best = results.verdict.as_ref().and_then(|verdict| verdict.ranking.first()).map(|rank| rank.setting);
    html! {
        div.wide tabindex="0" {
            table {
                tr { @for head in HEADS { th scope="col" { (head) } } }
                @for (index, setting) in results.settings.iter().enumerate() {
                    (row(index, setting, &names.names[index], best == Some(index) && results.settings.len() > 1))
                }
            }
        }
        p.faint { "The last image of each setting; means over turns. The words are explained below." }
    }
}

fn row(index: usize, setting: &Measured, name: &str, is_best: bool) -> Markup {
    let Some(last) = setting.points.last() else { return Markup::default() };
    let [noise, bias] = last.separated.map_or_else(Default::default, |it| [it.noise, it.bias].map(figures));
    let memory = setting.device_memory_bytes as f64 / f64::from(1 << 20);
    html! {
        tr.best[is_best] {
            td { (swatch(index)) (name) @if is_best { span.badge { "least error" } } }
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
            td { @if setting.on_front { "yes" } @else { "no" } }
        }
    }
}

/// The last image of each turn: what limits of a test in continuous integration may follow from.
fn turns(results: &Results, names: &Names) -> Markup {
    const HEADS: [&str; 6] = ["setting", "turn", "relMSE", "trimmed", "mean energy", "FLIP"];
    html! {
        details {
            summary { "Each turn by itself" }
            div.wide tabindex="0" {
                table {
                    tr { @for head in HEADS { th scope="col" { (head) } } }
                    @for (index, (name, setting)) in names.names.iter().zip(&results.settings).enumerate() {
                        @for (turn, run) in setting.points.last().iter().flat_map(|last| last.runs.iter().enumerate()) {
                            tr {
                                td { (swatch(index)) (name) }
                                td { (turn + 1) }
                                td { (figures(run.relmse)) }
                                td { (figures(run.relmse_trimmed)) }
                                td { (format!("{:.4}", run.energy_ratio)) }
                                td { (figures(run.flip)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn figure(plot: Plot, names: &Names) -> Markup {
    html! {
        figure aria-label=(plot.title) {
            h3 { (plot.title) }
            (PreEscaped(plot.svg))
            ul.legend { @for (index, name) in names.names.iter().enumerate() { li { (swatch(index)) (name) } } }
            figcaption { (plot.caption) }
        }
    }
}

/// A bar for each setting: the times of its passes in an iteration.
fn stack(results: &Results, names: &Names) -> Markup {
    let total = |setting: &Measured| 1e3 * setting.passes.values().sum::<f64>();
    let most = results.settings.iter().map(total).fold(f64::MIN_POSITIVE, f64::max);
    let passes = passes(results);
    html! {
        ul.legend { @for (index, pass) in passes.iter().enumerate() { li { (pass_swatch(index)) (pass) } } }
        div.passes {
            @for (name, setting) in names.names.iter().zip(&results.settings) {
                span { (name) }
                span.bar {
                    @for (index, pass) in passes.iter().enumerate() {
                        @let time = 1e3 * setting.passes.get(pass).copied().unwrap_or(0.0);
                        // The rest is for the text.
                        i title=(format!("{pass}: {} ms", figures(time)))
                            style=(format!("width:{:.2}%;background:{}", 70.0 * time / most, rgb(index))) {}
                    }
                    b { (figures(total(setting))) " ms" }
                }
            }
        }
        p.faint { "Milliseconds of the device in an iteration, by kernel. Kernels are explained in docs/architecture.md." }
    }
}

/// The pictures of each setting.
fn all_pictures(names: &Names, stops: f32, shown: &[Option<LastImage>]) -> Result<Markup, Box<dyn Error>> {
    let differences: Vec<_> = shown.iter().flatten().filter_map(|shown| shown.difference.as_ref()).collect();
    let scale = pictures::common_scale(&differences);
    let mut cards = Vec::new();
    for (index, (name, shown)) in names.names.iter().zip(shown).enumerate().take(SHOWN) {
        let Some(LastImage { image, difference, .. }) = shown else { continue };
        let slider = pictures::slider(name, image, stops)?;
        let difference = difference.as_ref().map(|map| pictures::difference(name, map, &scale)).transpose()?;
        cards.push(html! {
            h3 { (swatch(index)) (name) }
            div.grid { (slider) @if let Some(difference) = difference { (difference) } }
        });
    }
    Ok(html! {
        h2 { "Pictures" }
        p {
            "The last image of each setting, of the last turn. Drag the line, or use the arrow keys. \
             All differences have one scale, so that they can be compared."
            @if stops != 0.0 {
                " The reference is very bright or very dark: pictures, and FLIP, are at an exposure of " (stops) " stops."
            }
            @if names.names.len() > SHOWN { " These are the first " (SHOWN) " settings; the files beside this page are of all." }
        }
        @for card in cards { (card) }
    })
}

fn conditions(conditions: &Conditions) -> Markup {
    let Conditions { machine, command, scene, reference, budget, repeat } = conditions;
    let commit = machine.commit.unwrap_or("unknown");
    let [width, height] = reference.resolution;
    html! {
        p { code { (command) } }
        p { "Scene: " (scene) "." }
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
            ", each with another seed. Settings take turns of a slice of time each, so that other work of the machine \
             slows all of them. Times are of iterations alone."
        }
    }
}

fn rgb(index: usize) -> String {
    let plotters::style::RGBColor(r, g, b) = color(index);
    format!("rgb({r},{g},{b})")
}

/// The colour of a setting.
fn swatch(index: usize) -> Markup {
    html! { span.swatch.dashed[is_dashed(index)] style=(format!("background:{}", rgb(index))) {} }
}

/// The colour of a pass.
fn pass_swatch(index: usize) -> Markup {
    html! { span.swatch style=(format!("background:{}", rgb(index))) {} }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn setting(knobs: &[(&'static str, &str)]) -> Measured {
        let knobs: BTreeMap<_, _> = knobs.iter().map(|(knob, value)| (*knob, (*value).to_owned())).collect();
        Measured { label: "default".to_owned(), knobs, ..Measured::default() }
    }

    fn names(settings: &[Measured]) -> (Vec<String>, String) {
        let Names { names, shared } = Names::new(settings);
        (names, shared)
    }

    #[test]
    fn what_settings_share_is_said_once() {
        let [a, b] = ["1px", "2px"].map(|radius| setting(&[("iterations", "4"), ("radius", radius)]));
        let expected = (vec!["radius=1px".to_owned(), "radius=2px".to_owned()], "--iterations 4".to_owned());
        assert_eq!(names(&[a.clone(), b]), expected);
        // With --each, one setting has nothing of its own.
        let (found, shared) = names(&[setting(&[("iterations", "4")]), a]);
        assert_eq!(
            (found, shared),
            (vec!["no other option".to_owned(), "radius=1px".to_owned()], "--iterations 4".to_owned())
        );
        assert_eq!(names(&[setting(&[("photons", "3")])]), (vec!["photons=3".to_owned()], String::new()));
        assert_eq!(names(&[setting(&[])]), (vec!["default".to_owned()], String::new()));
    }

    #[test]
    fn names_cannot_become_markup() {
        let names = Names { names: vec!["<script>".to_owned()], shared: "<b>".to_owned() };
        assert!(shared(&names).into_string().contains("&lt;b&gt;"));
        let plot = Plot { title: "t", caption: "c", svg: String::new() };
        assert!(figure(plot, &names).into_string().contains("&lt;script&gt;"));
    }
}
