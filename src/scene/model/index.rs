//! Indices of refraction.

use std::sync::Arc;

/// A quantity by wavelength: values that are [`ByWavelength::STEP`] apart, linear in between.
#[derive(Clone, Debug, PartialEq)]
pub struct ByWavelength(Arc<[f64]>);

impl ByWavelength {
    /// The first and the last wavelength, nm.
    pub const RANGE: [f64; 2] = [380.0, 780.0];
    /// Distance of neighbouring values, nm.
    pub const STEP: f64 = 1.0;

    /// Samples a quantity at its wavelengths, nm. Returns `None` if it is the same at all of them, or is not finite.
    pub fn new(quantity: impl Fn(f64) -> f64) -> Option<Self> {
        let [first, last] = Self::RANGE;
        let steps = ((last - first) / Self::STEP) as u32;
        let values: Arc<[f64]> = (0..=steps).map(|step| quantity(first + Self::STEP * f64::from(step))).collect();
        let differs = |value: &f64| (value - values[0]).abs() > 1e-9 * values[0].abs();
        let is_finite = values.iter().all(|value| value.is_finite());
        (is_finite && values.iter().any(differs)).then(|| Self(Arc::clone(&values)))
    }

    /// Returns the value at a wavelength in nm; outside of [`ByWavelength::RANGE`], that at its end.
    pub fn at(&self, nm: f64) -> f64 {
        let place = ((nm - Self::RANGE[0]) / Self::STEP).clamp(0.0, (self.0.len() - 1) as f64);
        let low = (place as usize).min(self.0.len() - 2);
        let t = place - low as f64;
        self.0[low] * (1.0 - t) + self.0[low + 1] * t
    }

    /// Returns the curve over its largest value.
    pub fn normalized(&self) -> Self {
        let most = self.0.iter().copied().fold(0.0, f64::max);
        Self(self.0.iter().map(|value| value / most).collect())
    }

    /// Returns the curve times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self(self.0.iter().map(|value| value * factor).collect())
    }

    /// Returns the mean from one wavelength to another, nm.
    pub fn mean(&self, first: f64, last: f64) -> f64 {
        const PARTS: u32 = 8;
        let at = |part: u32| self.at(first + (last - first) * (f64::from(part) + 0.5) / f64::from(PARTS));
        (0..PARTS).map(at).sum::<f64>() / f64::from(PARTS)
    }

    /// Returns the values, by growing wavelength.
    pub fn values(&self) -> &[f64] {
        &self.0
    }
}

/// An index of refraction: inside over outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Index {
    /// The mean over what the eye sees in daylight; positive.
    pub mean: f64,
    /// The index by wavelength; `None` if it is the mean for all.
    pub curve: Option<ByWavelength>,
}

impl From<f64> for Index {
    fn from(mean: f64) -> Self {
        Self { mean, curve: None }
    }
}
