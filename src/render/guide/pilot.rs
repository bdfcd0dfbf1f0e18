//! The photons of a pilot: the random numbers by which they were emitted, and the light that they brought.

use std::time::Duration;

use crate::kernels::{EmissionNumbers, PILOT_DIRECT, PhotonRecord};
use crate::render::error::RenderError;
use crate::render::guide::cell::Sample;
use crate::render::guide::direct::{self, Lit};
use crate::render::guide::guidance::{Finding, Guide, PHOTONS_OF_ROUND};
use crate::render::guide::lights::{self, GuideLights};
use crate::render::guide::seen::{Brought, Seen};
use crate::render::guide::tree::Tree;
use crate::render::passes::PhotonPass;
use crate::render::progress::Progress;
use crate::render::stage::Stage;

/// The number of photons that must bring light to visible points before the pilot learns from this light only. With fewer,
/// it also learns from the distances of photons to the visible points.
const ENOUGH: usize = 32;

/// The factor of nearness for a record whose light eye paths find: a photon straight from its light.
const DIRECT_LEAD: f64 = 0.1;

/// The photons of all rounds of a pilot so far.
pub struct Pilot {
    /// The largest number of photons whose records have fitted into a batch.
    batch: u64,
    photons: Vec<PilotPhoton>,
    /// The light that the photons bring to visible points, ordered by photon.
    brought: Vec<Brought>,
    /// The light that the photons bring straight from lights, in any order.
    lit: Vec<Lit>,
    /// The records of the last round with the indices of their photons, ordered by photon.
    records: Vec<(u32, PhotonRecord)>,
    /// The densities of the rounds so far.
    trees: Vec<Tree>,
}

/// A photon of a pilot.
struct PilotPhoton {
    numbers: EmissionNumbers,
    /// The number of records of its path, plus 1.
    cost: f64,
    /// The largest nearness of its records to the visible points ([`Seen::nearness`]), times its flux at density 1. 0 if
    /// enough photons have brought light before.
    nearness: f64,
    /// The sum of the densities of all rounds so far at its random numbers.
    densities: f64,
}

impl PilotPhoton {
    fn numbers(&self) -> [f32; 6] {
        let EmissionNumbers { light, position, direction, .. } = self.numbers;
        [light[0], light[1], position[0], position[1], direction[0], direction[1]]
    }
}

/// Returns the substitute for the square of a photon's light, which is used as long as few photons bring light. In a
/// plane, its root falls with the distance to the visible points in such a way that the next round has at least as many
/// photons in each smaller octave of distances.
fn lead(photon: &PilotPhoton) -> f64 {
    photon.nearness.powf(1.5)
}

/// The size of a photon's weight. Colors of single wavelengths have negative channels.
fn mean_weight(photon: &PhotonRecord) -> f64 {
    photon.weight.iter().map(|weight| f64::from(weight.abs())).sum::<f64>() / 3.0
}

impl Pilot {
    /// Returns a pilot that has not traced any photon yet.
    pub fn new() -> Self {
        Self {
            batch: PHOTONS_OF_ROUND,
            photons: Vec::new(),
            brought: Vec::new(),
            lit: Vec::new(),
            records: Vec::new(),
            trees: Vec::new(),
        }
    }

    /// Traces the photons of a round, and reads their records.
    ///
    /// # Errors
    /// The device fails, or the caller cancels the iteration.
    pub fn follow(
        &mut self,
        photon: &mut PhotonPass,
        on: Stage<'_>,
        round: u32,
        progress: &mut Progress,
    ) -> Result<(), RenderError> {
        let before = self.photons.len() as u32;
        let mut first = 0;
        while first < PHOTONS_OF_ROUND {
            let end = PHOTONS_OF_ROUND.min(first + self.batch);
            let Some(recorded) = photon.run_pilot(on, round, first..end, progress)? else {
                self.batch = (self.batch / 2).max(1);
                continue;
            };
            let records = on.device.read_first_texels(&on.buffers.photons, recorded.into())?;
            let photon_of = |record: PhotonRecord| (before + (record.cell & !PILOT_DIRECT), record);
            self.records.extend(records.into_iter().map(photon_of));
            first = end;
        }
        // The device stores records in any order.
        self.records.sort_unstable_by_key(|(photon, record)| {
            (*photon, record.cell, record.position.map(f32::to_bits), record.weight.map(f32::to_bits))
        });
        let numbers = on.device.read_first_texels(&on.buffers.pilot_numbers, PHOTONS_OF_ROUND)?;
        let photon = |numbers| PilotPhoton { numbers, cost: 1.0, nearness: 0.0, densities: 0.0 };
        self.photons.extend(numbers.into_iter().map(photon));
        Ok(())
    }

    /// Computes the light that the photons of the last round bring to visible points. `tree` is the density by which they
    /// were emitted.
    pub fn see(&mut self, seen: &Seen, tree: Tree, lights: &GuideLights) {
        let mut straight = Vec::new();
        let knows_enough = self.knows_enough();
        for (index, record) in self.records.drain(..) {
            let photon = &mut self.photons[index as usize];
            let density = 1.0 / f64::from(photon.numbers.weight);
            photon.cost += 1.0;
            let is_finite = record.position.iter().all(|x| x.is_finite());
            if !is_finite {
                continue;
            }
            if !knows_enough {
                // The light at a first surface is direct light, which eye paths find. It only shows the way.
                let lead = if record.cell & PILOT_DIRECT == 0 { 1.0 } else { DIRECT_LEAD };
                let nearness = lead * seen.nearness(&record) * mean_weight(&record) * density;
                photon.nearness = photon.nearness.max(nearness);
            }
            if record.cell & PILOT_DIRECT == 0 {
                seen.add_brought(&record, index, density, &mut self.brought);
            } else {
                seen.add_brought(&record, index, density, &mut straight);
            }
        }
        self.lit.extend(straight.into_iter().map(|brought| {
            let number = self.photons[brought.sample as usize].numbers.light[0];
            Lit { brought, light: lights::light_of(&lights.order, number) }
        }));
        // Each photon is weighted as if all densities could have emitted it, the earlier ones and the new one.
        let of_round = self.photons.len() - PHOTONS_OF_ROUND as usize;
        for (index, photon) in self.photons.iter_mut().enumerate() {
            let numbers = photon.numbers();
            if index >= of_round {
                photon.densities = self.trees.iter().map(|tree| tree.density(&numbers)).sum();
            }
            photon.densities += tree.density(&numbers);
        }
        self.trees.push(tree);
    }

    /// Returns all photons as samples from which a density is learned. `power` is the power of all lights in W.
    pub fn samples(&self, seen: &Seen, power: f64) -> Vec<Sample> {
        let weight = |photon: &PilotPhoton| 1.0 / (PHOTONS_OF_ROUND as f64 * photon.densities);
        let weights: Vec<f64> = self.photons.iter().map(weight).collect();
        let importances = seen.importances(&self.brought, &weights, power);
        let squares = self.squares(&importances);
        let of_nearness = (1.0 - self.hits() as f64 / ENOUGH as f64).max(0.0);
        let integral = |squares: &mut dyn Iterator<Item = f64>| -> f64 {
            let sum: f64 = squares.zip(&weights).map(|(square, weight)| square * weight).sum();
            if sum > 0.0 { 1.0 / sum } else { 0.0 }
        };
        let near = of_nearness * integral(&mut self.photons.iter().map(lead));
        let brought = (1.0 - of_nearness) * integral(&mut squares.iter().copied());
        let sample = |((photon, weight), square): ((&PilotPhoton, &f64), &f64)| Sample {
            numbers: photon.numbers(),
            weight: *weight,
            square: brought * square + near * lead(photon),
            cost: photon.cost,
        };
        self.photons.iter().zip(&weights).zip(&squares).map(sample).collect()
    }

    /// Returns for each photon the square of the radiance that it brings to a point at density 1, summed over points with
    /// their importances as weights.
    fn squares(&self, importances: &[f64]) -> Vec<f64> {
        let mut squares = vec![0.0; self.photons.len()];
        for of_photon in self.brought.chunk_by(|a, b| a.sample == b.sample) {
            // Records of one path on the disc of one point are added before the square.
            let mut of_photon = of_photon.to_vec();
            of_photon.sort_by_key(|brought| brought.point);
            for of_point in of_photon.chunk_by(|a, b| a.point == b.point) {
                let radiance: f64 = of_point.iter().map(|brought| brought.radiance).sum();
                squares[of_point[0].sample as usize] += importances[of_point[0].point as usize] * radiance * radiance;
            }
        }
        squares
    }

    /// Returns whether enough photons bring light to visible points, so that the pilot learns from this light only.
    fn knows_enough(&self) -> bool {
        self.hits() >= ENOUGH
    }

    /// Returns the number of photons that bring light to visible points.
    pub fn hits(&self) -> usize {
        self.brought.chunk_by(|a, b| a.sample == b.sample).count()
    }

    /// Returns the result of the pilot. `guide` is the learned density and its [`Guide::gain`], `None` if a guide is not
    /// worthwhile.
    pub fn found(&self, seen: &Seen, samples: &[Sample], guide: Option<(Tree, f64)>, on: Stage<'_>) -> Guide {
        let finding = match &guide {
            None if self.brought.is_empty() => Finding::NothingFound,
            None => Finding::NotWorthwhile,
            Some((tree, _)) if tree.is_uniform() => Finding::NothingFound,
            Some(_) => Finding::Guided,
        };
        let (tree, gain) = guide.unwrap_or_else(|| (Tree::uniform(), 1.0));
        let mut reached = [0.0; 2];
        for of_photon in self.brought.chunk_by(|a, b| a.sample == b.sample) {
            let Sample { numbers, weight, .. } = &samples[of_photon[0].sample as usize];
            reached[0] += weight;
            reached[1] += weight * tree.density(numbers);
        }
        let weights: Vec<f64> = samples.iter().map(|sample| sample.weight).collect();
        let direct = direct::learn(seen, &self.lit, &weights, on.settings.mean_power, &on.lights.direct);
        Guide { finding, gain, reached: reached.map(|share| share.min(1.0)), tree, direct, time: Duration::ZERO }
    }
}
