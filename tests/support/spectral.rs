//! The f64 twins: glasses, and the colours of single wavelengths.

/// Coefficients of Sellmeier's formula, squared micrometres for `c`.
pub struct Glass {
    b: [f64; 3],
    c: [f64; 3],
}

/// Flint glass that splits light strongly: SF11 of Schott's catalogue.
pub const FLINT: Glass = Glass { b: [1.73759695, 0.313747346, 1.89878101], c: [0.013188707, 0.0623068142, 155.23629] };

/// Crown glass: BK7.
pub const CROWN: Glass =
    Glass { b: [1.03961212, 0.231792344, 1.01046945], c: [0.00600069867, 0.0200179144, 103.560653] };

impl Glass {
    /// The index at a wavelength in nm.
    pub fn eta(&self, nm: f64) -> f64 {
        let squared = (nm / 1000.0).powi(2);
        let terms = self.b.iter().zip(&self.c).map(|(b, c)| b * squared / (squared - c));
        (1.0 + terms.sum::<f64>()).sqrt()
    }

    /// The mean index for the eye in daylight.
    pub fn mean(&self) -> f64 {
        mean(|nm| self.eta(nm))
    }

    /// What each channel sees of white light whose wavelengths are multiplied by a function of their index.
    pub fn seen(&self, factor: impl Fn(f64) -> f64) -> [f64; 3] {
        seen(|nm| factor(self.eta(nm)))
    }
}

/// The mean of a function of the wavelength in nm for the eye in daylight.
pub fn mean(function: impl Fn(f64) -> f64) -> f64 {
    LINES.with(|lines| {
        let all: f64 = lines.iter().map(|line| line.xyz[1]).sum();
        lines.iter().map(|line| line.xyz[1] * function(line.nm)).sum::<f64>() / all
    })
}

/// What each channel sees of white light whose wavelengths in nm are multiplied by a function.
pub fn seen(factor: impl Fn(f64) -> f64) -> [f64; 3] {
    LINES.with(|lines| {
        let add = |sum: [f64; 3], line: &Line| {
            let factor = factor(line.nm);
            [0, 1, 2].map(|channel| sum[channel] + line.rgb[channel] * factor)
        };
        lines.iter().fold([0.0; 3], add)
    })
}

/// Light of 1 nm of daylight.
pub struct Line {
    pub nm: f64,
    /// All lines add up to (1, 1, 1).
    pub rgb: [f64; 3],
    /// Never negative; not normalised.
    pub xyz: [f64; 3],
}

thread_local! {
    /// The lines that one sees.
    pub static LINES: Vec<Line> = lines();
}

fn lines() -> Vec<Line> {
    let light = |nm| {
        let xyz = observer(nm).map(|value| value * daylight(nm));
        Line { nm, rgb: rgb_of(xyz), xyz }
    };
    let mut lines: Vec<Line> = (380..780).map(|nm| light(f64::from(nm) + 0.5)).collect();
    let white = [0, 1, 2].map(|channel| lines.iter().map(|line| line.rgb[channel]).sum::<f64>());
    for line in &mut lines {
        line.rgb = [0, 1, 2].map(|channel| line.rgb[channel] / white[channel]);
    }
    lines
}

/// The observer of 1931: the sums of lobes of Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE XYZ
/// Color Matching Functions" (JCGT 2013). They are within about 1 % of the largest value.
fn observer(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, peak: f64, below: f64, above: f64| {
        let width = if nm < peak { below } else { above };
        height * (-0.5 * ((nm - peak) / width).powi(2)).exp()
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

/// D65 from 380 nm, in steps of 10 nm.
const D65: [f64; 41] = [
    49.98, 54.65, 82.75, 91.49, 93.43, 86.68, 104.86, 117.01, 117.81, 114.86, 115.92, 108.81, 109.35, 107.80, 104.79,
    107.69, 104.41, 104.05, 100.00, 96.33, 95.79, 88.69, 90.01, 89.60, 87.70, 83.29, 83.70, 80.03, 80.21, 82.28, 78.28,
    69.72, 71.61, 74.35, 61.60, 69.89, 75.09, 63.59, 46.42, 66.81, 63.38,
];

/// D65, linear between its samples.
pub fn daylight(nm: f64) -> f64 {
    let place = (nm - 380.0) / 10.0;
    let low = (place as usize).min(D65.len() - 2);
    let t = place - low as f64;
    D65[low] * (1.0 - t) + D65[low + 1] * t
}

fn rgb_of([x, y, z]: [f64; 3]) -> [f64; 3] {
    [3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z, 0.0557 * x - 0.2040 * y + 1.0570 * z]
}

/// CIE XYZ of linear sRGB.
pub fn xyz_of([r, g, b]: [f64; 3]) -> [f64; 3] {
    [0.4124 * r + 0.3576 * g + 0.1805 * b, 0.2126 * r + 0.7152 * g + 0.0722 * b, 0.0193 * r + 0.1192 * g + 0.9505 * b]
}

/// Reflectance of a boundary for unpolarised light. `eta` is the index of the far side over that of the near side.
pub fn reflectance(cos_i: f64, eta: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}
