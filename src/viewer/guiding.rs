//! What the panel says about guided emission: where photons begin, and why there.

use std::time::Duration;

use crate::cli::stats::percent;
use crate::render::guide::guidance::{Finding, Guidance, Guide};
use crate::render::options::Options;

/// Where the photons of a render begin.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Guiding {
    /// There is no render yet.
    #[default]
    Unknown,
    /// The render follows no photons.
    NoPhotons,
    /// By the power of the lights alone, as the options say.
    Off,
    /// By the power of the lights alone, because the options leave it to the window.
    NotInWindows,
    /// A pilot finds out at the start of the next iteration.
    Pending,
    /// Where a pilot has found.
    Found(Found),
}

/// What a pilot has found, without its tree: the fields of [`Guide`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    finding: Finding,
    gain: f64,
    reached: [f64; 2],
    time: Duration,
}

/// How photons begin without a guide.
const ALONE: &str = "Photons begin by the power of the lights alone";

impl Guiding {
    /// Returns where photons begin in a render with these options. `guide` is what its pilot has found.
    pub fn of(options: &Options, follows_photons: bool, guide: Option<&Guide>) -> Self {
        if !follows_photons {
            return Self::NoPhotons;
        }
        match (options.guidance, guide) {
            (Guidance::Off, _) => Self::Off,
            _ if !options.is_guided() => Self::NotInWindows,
            (_, None) => Self::Pending,
            (_, Some(Guide { finding, gain, reached, time, .. })) => {
                Self::Found(Found { finding: *finding, gain: *gain, reached: *reached, time: *time })
            }
        }
    }

    /// Returns the state in a few words.
    pub fn short(&self) -> String {
        match self {
            Self::Unknown => "-".to_owned(),
            Self::NoPhotons => "no photons".to_owned(),
            Self::Off => "off".to_owned(),
            Self::NotInWindows => "none in a window".to_owned(),
            Self::Pending => "to be found".to_owned(),
            Self::Found(Found { finding: Finding::Guided, reached: [without, with], .. }) => {
                format!("{} to {}", percent(*without), percent(*with))
            }
            Self::Found(_) => "none".to_owned(),
        }
    }

    /// Returns the state in sentences.
    pub fn sentences(&self) -> String {
        match self {
            Self::Unknown => "There is no render yet.".to_owned(),
            Self::NoPhotons => "No photons are followed: the window shows direct light, or no light shines on a \
                                surface."
                .to_owned(),
            Self::Off => format!("{ALONE}: the guide is off."),
            Self::NotInWindows => format!(
                "{ALONE}: auto takes no guide in a window, because its pilot would delay the picture after each move. \
                 On takes one."
            ),
            Self::Pending => "A pilot finds at the start of the next iteration where photons bring light to what is \
                              seen."
                .to_owned(),
            Self::Found(found) => found.sentences(),
        }
    }
}

impl Found {
    fn sentences(&self) -> String {
        let Self { finding, gain, reached: [without, with], time } = self;
        let time = format!("The pilot took {:.2} s.", time.as_secs_f64());
        match finding {
            Finding::Guided => format!(
                "Photons begin where they bring light to what is seen: {} of them do so without the guide, {} with it. It \
                 lowers the product of variance and time {gain:.1} times, as far as its pilot tells. {time}",
                percent(*without),
                percent(*with)
            ),
            Finding::NotWorthwhile => format!(
                "{ALONE}: a guide would not pay. {} of them bring light to what is seen. {time}",
                percent(*without)
            ),
            Finding::NothingFound => {
                format!("{ALONE}: no photon of the pilot brought light to what is seen. {time}")
            }
            Finding::PhotonsDoNotMatter => format!(
                "{ALONE}: they can bring no light to what is seen, because all surfaces are in one plane, or the \
                 depth is 1."
            ),
            Finding::NothingSeen => format!("{ALONE}: no surface is seen that gathers their light."),
            Finding::RoughSurfaces => format!(
                "{ALONE}: rough surfaces gather light of theirs, of which a pilot knows nothing. On takes a guide all \
                 the same."
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::guide::tree::Tree;

    fn found(finding: Finding) -> Guiding {
        let (gain, reached, time) = (6.14, [0.003_12, 0.163], Duration::from_millis(420));
        let guide = Guide { finding, tree: Tree::uniform(), direct: None, gain, reached, time };
        let options = Options { guidance: Guidance::On, responsive: true, ..Options::default() };
        Guiding::of(&options, true, Some(&guide))
    }

    #[test]
    fn the_guide_of_a_render_has_its_figures() {
        assert_eq!(found(Finding::Guided).short(), "0.31 % to 16 %");
        let said = found(Finding::Guided).sentences();
        for words in ["0.31 % of them do so without the guide, 16 % with it", "6.1 times", "took 0.42 s"] {
            assert!(said.contains(words), "{said}");
        }
    }

    #[test]
    fn where_there_is_no_guide_it_is_said_why() {
        for (finding, why) in [
            (
                Finding::NotWorthwhile,
                "would not pay. 0.31 % of them bring light to what is seen. The pilot took 0.42 s.",
            ),
            (Finding::NothingFound, "no photon of the pilot brought light"),
            (Finding::PhotonsDoNotMatter, "can bring no light"),
            (Finding::NothingSeen, "no surface is seen"),
            (Finding::RoughSurfaces, "rough surfaces"),
        ] {
            let said = found(finding).sentences();
            assert!(said.starts_with(ALONE) && said.contains(why), "{said}");
            assert_eq!(found(finding).short(), "none");
        }
    }

    #[test]
    fn the_options_of_a_window_decide() {
        let of = |guidance, responsive, follows_photons| {
            Guiding::of(&Options { guidance, responsive, ..Options::default() }, follows_photons, None)
        };
        assert_eq!(of(Guidance::Auto, true, true), Guiding::NotInWindows);
        assert_eq!(of(Guidance::Auto, false, true), Guiding::Pending);
        assert_eq!(of(Guidance::On, true, true), Guiding::Pending);
        for responsive in [false, true] {
            assert_eq!(of(Guidance::Off, responsive, true), Guiding::Off);
            assert_eq!(of(Guidance::On, responsive, false), Guiding::NoPhotons);
        }
        for state in [Guiding::NotInWindows, Guiding::Off] {
            assert!(state.sentences().starts_with(ALONE), "{state:?}");
        }
    }
}
