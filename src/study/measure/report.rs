//! `report.html`: the results as one page that needs nothing else.

use std::error::Error;
use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::plot::{color, passes, plots};
use super::results::{Conditions, Measured, Results};
use crate::image::file::encode_png;
use crate::image::film::Image;

/// Difference images are shown at most so large.
const SHOWN: usize = 64;

/// The page. `differences` has an image for each setting, in their order.
///
/// # Errors
/// A plot cannot be drawn or an image not encoded.
pub fn html(results: &Results, differences: &[Option<Image>]) -> Result<String, Box<dyn Error>> {
    let mut page = String::new();
    let title = format!("goblet measure: {}", escape(&results.conditions.scene));
    write!(
        page,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{title}</title>\n\
         <link rel=\"icon\" href=\"data:,\">\n<style>\n{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n",
        include_str!("report.css")
    )?;
    conditions(&mut page, &results.conditions)?;
    table(&mut page, results)?;
    page.push_str("<div class=\"plots\">\n");
    for plot in plots(results)? {
        writeln!(page, "<figure aria-label=\"{}\">{}</figure>", escape(plot.title), plot.svg)?;
    }
    page.push_str("</div>\n<h2>Passes</h2>\n<p>");
    for (i, pass) in passes(results).into_iter().enumerate() {
        write!(page, "{}{pass} &nbsp; ", swatch(i))?;
    }
    page.push_str("</p>\n<h2>Where the last images are off</h2>\n<p>Red is too bright, blue too dark, green not finite; full colour is a root mean squared relative error of 1.</p>\n<div class=\"plots\">\n");
    for ((i, setting), difference) in results.settings.iter().enumerate().zip(differences).take(SHOWN) {
        let Some(image) = difference else { continue };
        writeln!(
            page,
            "<figure><img alt=\"difference\" width=\"{}\" height=\"{}\" src=\"data:image/png;base64,{}\">\
             <figcaption>{}{}</figcaption></figure>",
            image.width,
            image.height,
            STANDARD.encode(encode_png(image)?),
            swatch(i),
            escape(&setting.label)
        )?;
    }
    page.push_str("</div>\n</body>\n</html>\n");
    Ok(page)
}

fn conditions(page: &mut String, conditions: &Conditions) -> std::fmt::Result {
    let Conditions { machine, command, reference, budget, repeat, .. } = conditions;
    let commit = machine.commit.as_deref().unwrap_or("unknown");
    let cpus = machine.cpus.map_or_else(String::new, |cpus| format!(", {cpus} CPU threads"));
    let [width, height] = reference.resolution;
    let own = reference.own_iterations.map_or_else(String::new, |iterations| {
        let noise = reference.own_relative_error.map_or_else(String::new, |error| format!(", noise {error:.4}"));
        format!(
            ". It is goblet's own, of {iterations} iterations{noise}: its noise counts as error, and what blur \
             it shares with the settings does not"
        )
    });
    writeln!(
        page,
        "<p><code>{}</code></p>\n<p>{} (driver {}){cpus}; goblet {} at commit {commit}; {}.</p>\n\
         <p>Reference: {} ({width}x{height}){own}.</p>\n\
         <p>{budget} s for each setting in the first turn; {repeat} turn{}, each with another seed. Settings take \
         slices of time one after the other, to and fro. Times are of iterations alone; figures are means over turns.</p>",
        escape(command),
        escape(&machine.device),
        escape(&machine.driver),
        machine.goblet,
        machine.date,
        escape(&reference.path),
        if *repeat == 1 { "" } else { "s" },
    )
}

fn table(page: &mut String, results: &Results) -> std::fmt::Result {
    page.push_str(
        "<div class=\"wide\"><table>\n<tr><th>setting</th><th>iterations</th><th>photons</th><th>start, s</th>\
         <th>time, s</th><th>relMSE</th><th>trimmed</th><th>noise</th><th>bias</th><th>mean energy</th>\
         <th>FLIP</th><th>memory, MiB</th><th>on the front</th></tr>\n",
    );
    for (i, setting) in results.settings.iter().enumerate() {
        row(page, i, setting)?;
    }
    page.push_str("</table></div>\n");
    Ok(())
}

fn row(page: &mut String, index: usize, setting: &Measured) -> std::fmt::Result {
    let Some(last) = setting.points.last() else { return Ok(()) };
    let [noise, bias] = last.separated.map_or_else(Default::default, |it| [it.noise, it.bias].map(figures));
    writeln!(
        page,
        "<tr><td>{}{}</td><td>{}</td><td>{}</td><td>{:.2}</td><td>{:.2}</td><td>{}</td><td>{}</td>\
         <td>{noise}</td><td>{bias}</td><td>{:.4}</td><td>{}</td><td>{:.0}</td><td>{}</td></tr>",
        swatch(index),
        escape(&setting.label),
        last.iterations,
        last.photons,
        setting.start_seconds,
        last.seconds,
        figures(last.relmse),
        figures(last.relmse_trimmed),
        last.energy_ratio,
        figures(last.flip),
        setting.device_memory_bytes as f64 / f64::from(1 << 20),
        if setting.on_front { "yes" } else { "" },
    )
}

/// Three significant figures.
fn figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 12);
    format!("{value:.*}", decimals as usize)
}

fn swatch(index: usize) -> String {
    let plotters::style::RGBColor(r, g, b) = color(index);
    format!("<span class=\"swatch\" style=\"background:rgb({r},{g},{b})\"></span>")
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
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

    #[test]
    fn names_are_not_markup() {
        assert_eq!(escape("<a & \"b\">"), "&lt;a &amp; &quot;b&quot;&gt;");
    }
}
