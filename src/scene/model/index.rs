//! Indices of refraction.

use std::sync::Arc;

/// A quantity by wavelength: values that are [`ByWavelength::STEP`] apart, linear in between.
#[derive(Clone, Debug, PartialEq)]
pub struct ByWavelength(Arc<[f64]>);

impl ByWavelength {
    /// The first and the last wavelength, nm.
    pub const RANGE: [f64; 2] = [380.0, 780.0];
    /// Distance of neighbouring values, nm.
    pub const STEP: f64 = 5.0;

    /// Samples a quantity at its wavelengths, nm. Returns `None` if it is the same at all of them.
    pub fn new(quantity: impl Fn(f64) -> f64) -> Option<Self> {
        let [first, last] = Self::RANGE;
        let steps = ((last - first) / Self::STEP) as u32;
        let values: Arc<[f64]> = (0..=steps).map(|step| quantity(first + Self::STEP * f64::from(step))).collect();
        let differs = |value: &f64| (value - values[0]).abs() > 1e-9 * values[0].abs();
        values.iter().any(differs).then(|| Self(Arc::clone(&values)))
    }

    /// Returns the value at a wavelength in nm; outside of [`ByWavelength::RANGE`], that at its end.
    pub fn at(&self, nm: f64) -> f64 {
        let place = ((nm - Self::RANGE[0]) / Self::STEP).clamp(0.0, (self.0.len() - 1) as f64);
        let low = (place as usize).min(self.0.len() - 2);
        let t = place - low as f64;
        self.0[low] * (1.0 - t) + self.0[low + 1] * t
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
