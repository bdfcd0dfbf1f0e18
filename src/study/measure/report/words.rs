//! The words of a report, explained for people who have not met them.

use maud::{Markup, html};

/// Each word of the report and what it means.
const WORDS: [(&str, &str); 11] = [
    (
        "setting",
        "The options of a render that are compared here. Each has a colour, which is the same everywhere on this page.",
    ),
    ("reference", "The image that is taken to be right. Every error on this page is a difference from it."),
    (
        "turn, seed",
        "Every setting is rendered once in a turn. Each turn has another seed, which is the start of the random numbers: \
         all that differs between turns is noise. Figures are means over turns.",
    ),
    (
        "relMSE",
        "Relative mean squared error. For each pixel and each of red, green and blue: the squared difference from the \
         reference, divided by the squared reference plus 0.01 (so that dark pixels do not count beyond measure). relMSE is \
         their mean. 0.01 is a relative error of about 10 % in a typical pixel; half the error is a quarter of the relMSE.",
    ),
    (
        "trimmed",
        "relMSE without the 0.1 % of pixels that are furthest off. If it is much smaller than relMSE, a few very bright \
         pixels (fireflies) make most of the error.",
    ),
    (
        "noise",
        "The part of relMSE that changes with the seed: grain and spots. It falls with more iterations. Known from two turns on.",
    ),
    (
        "bias",
        "The part of relMSE that all seeds have in common. Here it is blur mostly: photons are gathered within a radius. It \
         falls as the radius shrinks. The noise of the reference counts as bias, too. It is the difference of two measured \
         numbers, and may be below 0 where it is small.",
    ),
    (
        "mean energy",
        "The mean brightness of the image divided by that of the reference. 1 is right; anything else is light that is missing \
         or counted twice.",
    ),
    (
        "FLIP",
        "What a person sees when image and reference are shown in turn, from 0 (nothing) to 1 (black against white). This is \
         LDR-FLIP (Andersson and others 2020) of the images as a PNG shows them (exposure 0, unless this page says \
         otherwise), at 67 pixels a degree.",
    ),
    (
        "start",
        "Seconds before the first iteration: reading, building the hierarchy, compiling kernels. Times of iterations are without it.",
    ),
    (
        "front",
        "Whether it is on the Pareto front: at some time, no other setting had a smaller error in the same time or less.",
    ),
];

/// A list of all words.
pub fn list() -> Markup {
    html! {
        dl {
            @for (word, meaning) in WORDS {
                dt { (word) }
                dd { (meaning) }
            }
        }
    }
}
