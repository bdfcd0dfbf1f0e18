//! Which setting is best: the one with the least error after the same time, and which others are as good as that
//! within the noise of the seeds.

use std::fmt::Write;

use serde::Serialize;

use super::measured::{Bias, Measured, Point};

/// What the results say of the settings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The time at which settings are compared: the one at which the first of them has ended, seconds of iterations.
    pub seconds: f64,
    /// The settings that have an image by then, the least error first.
    pub ranking: Vec<Rank>,
}

/// A setting at the time of the comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rank {
    /// The setting's place in the results, from 0.
    pub setting: usize,
    /// relMSE, mean over turns, between the two nearest points of the setting.
    pub relmse: f64,
    /// The least and the largest relMSE of a turn.
    pub seeds: [f64; 2],
    /// Noise and bias at the nearest point; null for a single turn.
    pub separated: Option<Bias>,
    /// Whether the difference from the best setting may be an accident of the seeds: 0 is in the confidence interval
    /// of 95 % of the mean difference of logarithms; null for a single turn.
    pub as_good: Option<bool>,
}

/// Quantiles of Student's distribution for intervals of 95 %, for 1 to 10 degrees of freedom.
const STUDENT: [f64; 10] = [12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23];

impl Verdict {
    /// Compares settings. `None` if none has an image.
    pub fn new(settings: &[Measured]) -> Option<Self> {
        let ends = settings.iter().filter_map(|setting| setting.points.last()).map(|point| point.seconds);
        let seconds = ends.min_by(f64::total_cmp)?;
        let at = |(setting, measured): (usize, &Measured)| Some((setting, Sample::new(&measured.points, seconds)?));
        let mut samples: Vec<(usize, Sample)> = settings.iter().enumerate().filter_map(at).collect();
        samples.sort_by(|(_, a), (_, b)| a.relmse.total_cmp(&b.relmse));
        let best = samples.first()?.1.clone();
        let rank = |(setting, sample): (usize, Sample)| Rank {
            setting,
            relmse: sample.relmse,
            seeds: sample.range(),
            separated: sample.separated,
            as_good: sample.is_as_good_as(&best),
        };
        Some(Self { seconds, ranking: samples.into_iter().map(rank).collect() })
    }

    /// Returns sentences for people, the winner first; `names` has one for each setting of the results.
    pub fn sentences(&self, names: &[String]) -> Vec<String> {
        // A name of several words needs marks in a sentence.
        let quoted = |name: &String| if name.contains(' ') { format!("“{name}”") } else { name.clone() };
        let names: Vec<String> = names.iter().map(quoted).collect();
        let name = |rank: &Rank| names[rank.setting].as_str();
        let Some((best, others)) = self.ranking.split_first() else { return Vec::new() };
        let mut said = vec![self.first_sentence(name(best), best, names.len())];
        let (equal, worse): (Vec<&Rank>, Vec<&Rank>) = others.iter().partition(|rank| rank.as_good == Some(true));
        if !equal.is_empty() {
            let list: Vec<&str> = equal.iter().map(|rank| name(rank)).collect();
            let [verb, pronoun] = if list.len() == 1 { ["is", "it"] } else { ["are", "they"] };
            said.push(format!(
                "Within the noise of the seeds, {} {verb} as good: {pronoun} may win with other seeds.",
                listed(&list)
            ));
        }
        if let Some(next) = worse.first() {
            said.push(reason(best, next, name(next)));
        }
        if best.separated.is_none() && !others.is_empty() {
            said.push("With a single turn, it is not known how much of this is an accident of the seed.".to_owned());
        }
        let ranked = |setting: usize| self.ranking.iter().any(|rank| rank.setting == setting);
        let late: Vec<&str> =
            names.iter().enumerate().filter(|(setting, _)| !ranked(*setting)).map(|(_, name)| name.as_str()).collect();
        if !late.is_empty() {
            let verb = if late.len() == 1 { "has" } else { "have" };
            said.push(format!("By then, {} {verb} not finished the first iteration.", listed(&late)));
        }
        said
    }

    fn first_sentence(&self, name: &str, best: &Rank, settings: usize) -> String {
        let [least, most] = best.seeds.map(figures);
        let seeds = if least == most { String::new() } else { format!("; {least} to {most} depending on the seed") };
        let relmse = format!("relMSE {}{seeds}", figures(best.relmse));
        let percent = 100.0 * best.relmse.sqrt();
        // Where a reference is dark beside the image, percents say nothing.
        let error = if percent < 100.0 { format!("about {} % ({relmse})", figures(percent)) } else { relmse };
        let time = figures(self.seconds);
        if settings == 1 {
            format!("After {time} s of iterations, {name} has an error of {error}.")
        } else {
            format!("At equal time, after {time} s of iterations, {name} has the least error: {error}.")
        }
    }
}

/// The least share of the larger difference, of noise and bias, with which the other one is named.
const LEAST_REASON: f64 = 0.02;

/// Says how the next setting differs from the best one, and whether by noise or by bias.
fn reason(best: &Rank, next: &Rank, name: &str) -> String {
    let mut text = format!("The next, {name}, has {} times its error", figures(next.relmse / best.relmse));
    if let (Some(ours), Some(theirs)) = (best.separated, next.separated) {
        let [noise, bias] = [theirs.noise - ours.noise, theirs.bias - ours.bias];
        let of = |what: &str, ours: f64, theirs: f64| {
            format!(
                "{} {what} ({} against {})",
                if theirs > ours { "more" } else { "less" },
                figures(theirs),
                figures(ours)
            )
        };
        let noise_text = of("noise", ours.noise, theirs.noise);
        let bias_text = of("bias", ours.bias, theirs.bias);
        let mut parts = [(noise, noise_text), (bias, bias_text)];
        parts.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let [(first, first_text), (second, second_text)] = parts;
        let _ = write!(text, ": {first_text}");
        // A part that hardly differs is no reason.
        if second.abs() > LEAST_REASON * first.abs() {
            let but = if (first > 0.0) == (second > 0.0) { "and" } else { "but" };
            let _ = write!(text, " {but} {second_text}");
        }
    }
    text + "."
}

/// The turns of a setting at a time.
#[derive(Clone)]
struct Sample {
    relmse: f64,
    turns: Vec<f64>,
    separated: Option<Bias>,
}

impl Sample {
    /// `None` if there is no image by then, or one that is not finite.
    fn new(points: &[Point], seconds: f64) -> Option<Self> {
        // Sums of times are not exact.
        let until = seconds * (1.0 + 1e-9);
        let after = points.iter().position(|point| point.seconds > until).unwrap_or(points.len());
        let before = points.get(after.checked_sub(1)?)?;
        let next = points.get(after).unwrap_or(before);
        let length = (next.seconds / before.seconds).ln();
        let t = if length > 0.0 { ((seconds / before.seconds).ln() / length).clamp(0.0, 1.0) } else { 0.0 };
        let between = |a: f64, b: f64| (a.ln() * (1.0 - t) + b.ln() * t).exp();
        let relmse = if before.relmse > 0.0 { between(before.relmse, next.relmse) } else { before.relmse };
        let turns = before.runs.iter().zip(&next.runs);
        let turns = turns.map(|(a, b)| if a.relmse > 0.0 { between(a.relmse, b.relmse) } else { a.relmse }).collect();
        let separated = if t < 0.5 { before.separated } else { next.separated };
        relmse.is_finite().then_some(Self { relmse, turns, separated })
    }

    /// The least and the largest of all turns.
    fn range(&self) -> [f64; 2] {
        let [least, most] = [f64::INFINITY, f64::NEG_INFINITY];
        self.turns.iter().fold([least, most], |[least, most], value| [least.min(*value), most.max(*value)])
    }

    /// Whether the difference may be an accident. Both have the same seed in a turn, so that differences of turns are
    /// compared, and not those of means.
    fn is_as_good_as(&self, best: &Self) -> Option<bool> {
        let logs: Vec<f64> = self.turns.iter().zip(&best.turns).map(|(own, best)| (own / best).ln()).collect();
        let count = logs.len() as f64;
        let quantile = STUDENT.get(logs.len().checked_sub(2)?).copied().unwrap_or(2.2);
        let mean = logs.iter().sum::<f64>() / count;
        let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Some(mean.abs() <= quantile * (variance / count).sqrt())
    }
}

/// As in `a, b and c`.
fn listed(names: &[&str]) -> String {
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => names.join(""),
    }
}

/// Three significant figures.
pub fn figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 12);
    format!("{value:.*}", decimals as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::measure::measured::Run;

    /// A setting that is measured at some times, with the relMSE of each turn.
    fn setting(points: &[(f64, &[f64])]) -> Measured {
        let point = |(seconds, turns): &(f64, &[f64])| {
            let relmse = turns.iter().sum::<f64>() / turns.len() as f64;
            let run = |relmse: &f64| Run { seconds: *seconds, relmse: *relmse, ..Run::default() };
            Point {
                seconds: *seconds,
                relmse,
                // A quarter of it is bias.
                separated: Bias::new(relmse, 0.25 * relmse + 0.75 * relmse / turns.len() as f64, turns.len()),
                runs: turns.iter().map(run).collect(),
                ..Point::default()
            }
        };
        Measured { points: points.iter().map(point).collect(), ..Measured::default() }
    }

    fn said(settings: &[Measured]) -> Vec<String> {
        let names: Vec<String> =
            ["a", "b", "c=1 d=2"].iter().take(settings.len()).map(|&name| name.to_owned()).collect();
        Verdict::new(settings).unwrap().sentences(&names)
    }

    #[test]
    fn the_winner_has_the_least_error_at_equal_time() {
        // At 4 s, the second has the error between those of 1 s and 16 s on logarithmic axes.
        let settings = [
            setting(&[(1.0, &[0.4, 0.48]), (4.0, &[0.2, 0.24])]),
            setting(&[(1.0, &[0.2, 0.22]), (16.0, &[0.05, 0.055])]),
            setting(&[(5.0, &[0.001, 0.001])]),
        ];
        let verdict = Verdict::new(&settings).unwrap();
        assert_eq!(verdict.seconds, 4.0);
        let order: Vec<usize> = verdict.ranking.iter().map(|rank| rank.setting).collect();
        assert_eq!(order, [1, 0], "the third has no image yet");
        assert!((verdict.ranking[0].relmse - 0.105).abs() < 1e-9, "{verdict:?}");
        assert!((verdict.ranking[0].seeds[1] - 0.11).abs() < 1e-9, "{verdict:?}");
        assert_eq!(
            said(&settings),
            [
                "At equal time, after 4.00 s of iterations, b has the least error: about 32.4 % (relMSE 0.105; 0.100 to \
                 0.110 depending on the seed).",
                "The next, a, has 2.10 times its error: more noise (0.165 against 0.0394) and more bias (0.0550 against \
                 0.0131).",
                "By then, “c=1 d=2” has not finished the first iteration.",
            ]
        );
    }

    #[test]
    fn what_the_seeds_do_not_tell_apart_is_as_good() {
        let settings = [
            setting(&[(1.0, &[0.10, 0.12, 0.11])]),
            setting(&[(1.0, &[0.12, 0.11, 0.115])]),
            setting(&[(1.0, &[0.30, 0.36, 0.33])]),
        ];
        let verdict = Verdict::new(&settings).unwrap();
        let as_good: Vec<Option<bool>> = verdict.ranking.iter().map(|rank| rank.as_good).collect();
        assert_eq!(as_good, [Some(true), Some(true), Some(false)]);
        let said = said(&settings);
        assert_eq!(said[1], "Within the noise of the seeds, b is as good: it may win with other seeds.");
        assert!(said[2].starts_with("The next, “c=1 d=2”, has 3.00 times its error"), "{said:?}");
    }

    #[test]
    fn one_turn_knows_no_noise_and_one_setting_no_winner() {
        let two = said(&[setting(&[(1.0, &[0.1])]), setting(&[(1.0, &[0.2])])]);
        assert_eq!(
            two[0],
            "At equal time, after 1.00 s of iterations, a has the least error: about 31.6 % (relMSE 0.100)."
        );
        assert_eq!(two[1], "The next, b, has 2.00 times its error.");
        assert!(two[2].contains("single turn") && two.len() == 3, "{two:?}");
        let one = said(&[setting(&[(1.0, &[0.1, 0.1])])]);
        assert_eq!(one, ["After 1.00 s of iterations, a has an error of about 31.6 % (relMSE 0.100)."]);
        assert_eq!(Verdict::new(&[]), None);
    }

    #[test]
    fn figures_are_three() {
        for (value, expected) in [(0.001234, "0.00123"), (12.345, "12.3"), (1234.0, "1234"), (0.0, "0")] {
            assert_eq!(figures(value), expected);
        }
    }
}
