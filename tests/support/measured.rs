//! Measured materials: tables of analytic surfaces, as the paper makes them of measurements (Dupuy and Jakob, "An
//! Adaptive Parameterization for Efficient Material Acquisition and Rendering", 2018), files of the tables, and the f64
//! twin of `shaders/include/material/measured.glsl`.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::PathBuf;

use glam::{DVec2, DVec3};

/// What a surface reflects: BRDF times the cosine of the second direction, 1/sr.
pub type Reflect = Box<dyn Fn(DVec3, DVec3) -> f64>;

/// An analytic surface, and the GGX alphas of the normals that its tables are by.
pub struct Analytic {
    pub alpha: [f64; 2],
    pub reflect: Reflect,
}

/// Microfacets of the GGX distribution.
#[derive(Clone, Copy)]
struct Facets([f64; 2]);

impl Facets {
    fn density(self, m: DVec3) -> f64 {
        let Facets([u, v]) = self;
        let stretched = DVec3::new(m.x / u, m.y / v, m.z);
        1.0 / (PI * u * v * stretched.length_squared().powi(2))
    }

    /// Area projected along a direction, of facets that do not hide each other.
    fn area(self, w: DVec3) -> f64 {
        let Facets([u, v]) = self;
        0.5 * (w.z + DVec3::new(u * w.x, v * w.y, w.z).length())
    }
}

impl Analytic {
    pub fn lambertian(albedo: f64) -> Self {
        Self { alpha: [1.0; 2], reflect: Box::new(move |_, wi| albedo * wi.z / PI) }
    }

    /// Facets that reflect all light, once, with Smith's joint masking.
    pub fn ggx(alpha: [f64; 2]) -> Self {
        let facets = Facets(alpha);
        let reflect = move |wo: DVec3, wi: DVec3| {
            let lambda_i = facets.area(wi) / wi.z - 1.0;
            facets.density((wo + wi).normalize()) / (4.0 * (facets.area(wo) + wo.z * lambda_i))
        };
        Self { alpha, reflect: Box::new(reflect) }
    }

    /// The share of light from a direction that is reflected, by quadrature over `steps` cosines.
    pub fn albedo(&self, wo: DVec3, steps: usize) -> f64 {
        let mut sum = 0.0;
        for i in 0..steps * steps {
            let z = ((i / steps) as f64 + 0.5) / steps as f64;
            let phi = ((i % steps) as f64 + 0.5) / steps as f64 * 2.0 * PI;
            sum += (self.reflect)(wo, direction(z.acos(), phi));
        }
        sum * 2.0 * PI / (steps * steps) as f64
    }
}

fn direction(polar: f64, azimuth: f64) -> DVec3 {
    DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
}

fn polar(w: DVec3) -> f64 {
    w.truncate().length().atan2(w.z)
}

fn azimuth(w: DVec3) -> f64 {
    w.y.atan2(w.x)
}

/// The direction of a point of the unit square, and the area of the square per solid angle, inverted.
fn direction_of(p: DVec2) -> (DVec3, f64) {
    let angle = p.x * p.x * FRAC_PI_2;
    (direction(angle, (2.0 * p.y - 1.0) * PI), 2.0 * PI * PI * p.x * angle.sin())
}

fn point_of(polar: f64, azimuth: f64) -> DVec2 {
    DVec2::new((polar / FRAC_PI_2).sqrt(), (0.5 + azimuth / (2.0 * PI)).rem_euclid(1.0))
}

/// Values over the unit square, row by row, corners included.
#[derive(Clone)]
pub struct Grid {
    width: usize,
    height: usize,
    values: Vec<f64>,
    /// Integrals of the rows of a density.
    totals: Vec<f64>,
}

impl Grid {
    /// Values as fp32 has them.
    fn new([width, height]: [usize; 2], value: impl Fn(DVec2) -> f64) -> Self {
        let at =
            |i: usize| DVec2::new((i % width) as f64 / (width - 1) as f64, (i / width) as f64 / (height - 1) as f64);
        let values = (0..width * height).map(|i| f64::from(value(at(i)) as f32)).collect();
        Self { width, height, values, totals: Vec::new() }
    }

    fn cell(&self, p: DVec2) -> (usize, DVec2) {
        let scaled = p.clamp(DVec2::ZERO, DVec2::ONE) * DVec2::new((self.width - 1) as f64, (self.height - 1) as f64);
        let x = (scaled.x as usize).min(self.width - 2);
        let y = (scaled.y as usize).min(self.height - 2);
        (y * self.width + x, scaled - DVec2::new(x as f64, y as f64))
    }

    fn at(&self, p: DVec2) -> f64 {
        let (i, t) = self.cell(p);
        let [a, b, c, d] = [i, i + 1, i + self.width, i + self.width + 1].map(|i| self.values[i]);
        (a * (1.0 - t.x) + b * t.x) * (1.0 - t.y) + (c * (1.0 - t.x) + d * t.x) * t.y
    }

    fn blend(grids: &[(f64, Grid)]) -> Self {
        let mut blend = Grid { values: vec![0.0; grids[0].1.values.len()], ..grids[0].1.clone() };
        for (weight, grid) in grids {
            blend.values.iter_mut().zip(&grid.values).for_each(|(sum, value)| *sum += weight * value);
        }
        blend
    }

    /// The integral of a row, from its start to a place, where the row is between two rows.
    fn along(&self, row: usize, y: f64, x: f64) -> f64 {
        let mut sum = 0.0;
        let end = (x as usize + 1).min(self.width - 1);
        for column in 0..end {
            let part = (x - column as f64).min(1.0);
            let at = |i: usize| {
                let i = row * self.width + i;
                self.values[i] * (1.0 - y) + self.values[i + self.width] * y
            };
            sum += linear(at(column), at(column + 1), part);
        }
        sum
    }

    /// The integral over all rows from the first to a place.
    fn down(&self, y: f64) -> f64 {
        let part = |row: usize| (y - row as f64).clamp(0.0, 1.0);
        self.totals.windows(2).enumerate().map(|(row, two)| linear(two[0], two[1], part(row))).sum()
    }

    /// The same density with an integral of 1 over cells of area 1.
    fn normalized(&self) -> Self {
        let total = |row: &[f64]| row.windows(2).map(|two| 0.5 * (two[0] + two[1])).sum();
        let totals: Vec<f64> = self.values.chunks(self.width).map(total).collect();
        let all: f64 = totals.windows(2).map(|two| 0.5 * (two[0] + two[1])).sum();
        let scaled = |values: &[f64]| values.iter().map(|value| value / all).collect();
        Grid { values: scaled(&self.values), totals: scaled(&totals), ..*self }
    }

    /// The density at a point by area of the unit square, of a normalized grid.
    fn pdf(&self, p: DVec2) -> f64 {
        self.at(p) * ((self.width - 1) * (self.height - 1)) as f64
    }

    /// The point that a normalized grid warps numbers to, by bisection.
    fn sample(&self, u: DVec2) -> DVec2 {
        let y = bisect((self.height - 1) as f64, |y| self.down(y) < u.y);
        let row = (y as usize).min(self.height - 2);
        let part = y - row as f64;
        let all = self.along(row, part, self.width as f64);
        let x = bisect((self.width - 1) as f64, |x| self.along(row, part, x) < u.x * all);
        DVec2::new(x / (self.width - 1) as f64, y / (self.height - 1) as f64)
    }

    /// The numbers that a normalized grid warps to a point.
    fn invert(&self, p: DVec2) -> DVec2 {
        let (i, t) = self.cell(p);
        let (row, column) = (i / self.width, i % self.width);
        let all = self.along(row, t.y, self.width as f64);
        DVec2::new(self.along(row, t.y, column as f64 + t.x) / all.max(1e-300), self.down(row as f64 + t.y))
    }
}

/// The integral up to x of a density that is linear from a to b.
fn linear(a: f64, b: f64, x: f64) -> f64 {
    x * (a + 0.5 * x * (b - a))
}

fn bisect(end: f64, is_before: impl Fn(f64) -> bool) -> f64 {
    let [mut low, mut high] = [0.0, end];
    for _ in 0..32 {
        let middle = 0.5 * (low + high);
        if is_before(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// How finely a surface is tabulated.
pub struct Steps {
    /// Values of each grid along the polar angle and the azimuth.
    pub size: [usize; 2],
    /// Azimuths of incident directions, from -pi on, and the share of a full turn that they cover; one azimuth for an
    /// isotropic surface.
    pub azimuths: usize,
    pub turn: f64,
    /// Polar angles of incident directions.
    pub polar_angles: usize,
}

/// Isotropic tables.
pub const ISOTROPIC: Steps = Steps { size: [48, 24], azimuths: 1, turn: 0.0, polar_angles: 24 };

/// The tables of a grey surface.
pub struct Tables {
    azimuths: Vec<f64>,
    polar_angles: Vec<f64>,
    reduction: usize,
    normals: Grid,
    area: Grid,
    visible: Vec<Grid>,
    luminance: Vec<Grid>,
}

impl Tables {
    pub fn new(surface: &Analytic, steps: &Steps) -> Self {
        let facets = Facets(surface.alpha);
        let single = |value: f64| f64::from(value as f32);
        let azimuths: Vec<f64> = match steps.azimuths {
            1 => vec![0.0],
            count => (0..count).map(|i| single(-PI + steps.turn * 2.0 * PI * i as f64 / (count - 1) as f64)).collect(),
        };
        let last = (steps.polar_angles - 1) as f64;
        let polar_angles: Vec<f64> = (0..steps.polar_angles).map(|i| single(FRAC_PI_2 * i as f64 / last)).collect();
        let tabulate = |value: &dyn Fn(DVec2) -> f64| Grid::new(steps.size, value);
        let (mut visible, mut luminance) = (Vec::new(), Vec::new());
        for azimuth in &azimuths {
            for angle in &polar_angles {
                // Not quite grazing.
                let wo = direction(angle.min(1.5), *azimuth);
                let seen = tabulate(&|p| {
                    let (m, jacobian) = direction_of(p);
                    facets.density(m) * m.dot(wo).max(0.0) / facets.area(wo) * jacobian
                });
                let warp = seen.normalized();
                luminance.push(tabulate(&|u| {
                    let (m, _) = direction_of(warp.sample(u));
                    let wi = 2.0 * m.dot(wo) * m - wo;
                    let scale = 4.0 * facets.area(wo) / facets.density(m);
                    if wi.z > 0.0 { (surface.reflect)(wo, wi) * scale } else { 0.0 }
                }));
                visible.push(seen);
            }
        }
        Self {
            reduction: if steps.azimuths == 1 { 1 } else { (1.0 / steps.turn).round() as usize },
            azimuths,
            polar_angles,
            normals: tabulate(&|p| facets.density(direction_of(p).0)),
            area: tabulate(&|p| facets.area(direction_of(p).0)),
            visible,
            luminance,
        }
    }

    /// The fields of a file. Spectra are the luminance times a tint at each wavelength in nm.
    pub fn fields(&self, tint: &[[f32; 2]]) -> Vec<Field> {
        let steps = [self.azimuths.len(), self.polar_angles.len()];
        let sides = [self.normals.height, self.normals.width];
        let all = |grids: &[Grid]| grids.iter().flat_map(|grid| grid.values.clone()).collect::<Vec<f64>>();
        let spectra = self.luminance.iter().flat_map(|grid| {
            tint.iter().flat_map(|[_, tint]| grid.values.iter().map(|value| value * f64::from(*tint)))
        });
        let wavelengths: Vec<f64> = tint.iter().map(|[nm, _]| f64::from(*nm)).collect();
        vec![
            Field { name: "description", code: 1, shape: vec![4], data: b"test".to_vec() },
            Field { name: "jacobian", code: 1, shape: vec![1], data: vec![1] },
            Field::floats("phi_i", &[steps[0]], &self.azimuths),
            Field::floats("theta_i", &[steps[1]], &self.polar_angles),
            Field::floats("wavelengths", &[tint.len()], &wavelengths),
            Field::floats("ndf", &sides, &self.normals.values),
            Field::floats("sigma", &sides, &self.area.values),
            Field::floats("vndf", &[steps, sides].concat(), &all(&self.visible)),
            Field::floats("luminance", &[steps, sides].concat(), &all(&self.luminance)),
            Field::floats("spectra", &[&steps[..], &[tint.len()], &sides].concat(), &spectra.collect::<Vec<_>>()),
        ]
    }

    /// A file of the tables.
    pub fn write(&self) -> MeasuredFile {
        MeasuredFile::new(&tensor(&self.fields(&[[400.0, 1.0], [700.0, 1.0]])))
    }

    /// The tables for light or paths from a direction.
    pub fn incident(&self, wo: DVec3) -> Incident<'_> {
        let turned = |x: f64| if x < 0.0 { 1.0 } else { -1.0 };
        let signs = match self.reduction {
            4 => DVec3::new(turned(wo.x), turned(wo.y), 1.0),
            2 => DVec3::new(turned(wo.y), turned(wo.y), 1.0),
            _ => DVec3::ONE,
        };
        let wo = wo * signs;
        let place = |angles: &[f64], angle: f64| {
            let low = angles.partition_point(|node| *node <= angle).clamp(1, (angles.len() - 1).max(1)) - 1;
            let step = angles.get(low + 1).map_or(1.0, |next| next - angles[low]);
            (low, if angles.len() == 1 { 0.0 } else { ((angle - angles[low]) / step).clamp(0.0, 1.0) })
        };
        let ((i, s), (j, t)) = (place(&self.azimuths, azimuth(wo)), place(&self.polar_angles, polar(wo)));
        let mut weights = vec![((i, j), (1.0 - s) * (1.0 - t)), ((i, j + 1), (1.0 - s) * t)];
        weights.extend([((i + 1, j), s * (1.0 - t)), ((i + 1, j + 1), s * t)]);
        weights.retain(|(_, weight)| *weight > 0.0);
        let blended = |grids: &[Grid], of: fn(&Grid) -> Grid| {
            let grid = |(i, j): (usize, usize)| of(&grids[i * self.polar_angles.len() + j]);
            Grid::blend(&weights.iter().map(|(at, weight)| (*weight, grid(*at))).collect::<Vec<_>>())
        };
        let normalized = |grids: &[Grid]| blended(grids, Grid::normalized).normalized();
        Incident {
            tables: self,
            wo,
            signs,
            azimuth: if self.azimuths.len() <= 2 { azimuth(wo) } else { 0.0 },
            area: self.area.at(point_of(polar(wo), azimuth(wo))),
            visible: normalized(&self.visible),
            luminance: normalized(&self.luminance),
            colors: blended(&self.luminance, Grid::clone),
        }
    }
}

/// Tables as they are seen from a direction.
pub struct Incident<'a> {
    tables: &'a Tables,
    wo: DVec3,
    signs: DVec3,
    azimuth: f64,
    area: f64,
    visible: Grid,
    luminance: Grid,
    colors: Grid,
}

impl Incident<'_> {
    /// BRDF times the cosine of wi, and the pdf of sampling wi; 1/sr.
    pub fn evaluate(&self, wi: DVec3) -> [f64; 2] {
        let m = (self.wo + wi * self.signs).normalize();
        let p = point_of(polar(m), azimuth(m) - self.azimuth);
        let u = self.visible.invert(p);
        let jacobian = 2.0 * PI * PI * p.x * polar(m).sin();
        let density = self.visible.pdf(p) * self.luminance.pdf(u);
        [self.colors.at(u) * self.tables.normals.at(p) / (4.0 * self.area), density / (4.0 * m.dot(self.wo) * jacobian)]
    }

    /// The direction that numbers sample.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let p = self.visible.sample(self.luminance.sample(u));
        let m = direction(p.x * p.x * FRAC_PI_2, (2.0 * p.y - 1.0) * PI + self.azimuth);
        (2.0 * m.dot(self.wo) * m - self.wo) * self.signs
    }
}

/// A field of a tensor file.
#[derive(Clone)]
pub struct Field {
    pub name: &'static str,
    /// Type of its numbers: 1 for bytes, 10 for fp32.
    pub code: u8,
    pub shape: Vec<u64>,
    pub data: Vec<u8>,
}

impl Field {
    pub fn floats(name: &'static str, shape: &[usize], values: &[f64]) -> Self {
        let data = values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect();
        Self { name, code: 10, shape: shape.iter().map(|side| *side as u64).collect(), data }
    }
}

/// A tensor file, version 1.0.
pub fn tensor(fields: &[Field]) -> Vec<u8> {
    let header: usize = fields.iter().map(|field| 13 + field.name.len() + 8 * field.shape.len()).sum();
    let mut offset = 18 + header;
    let mut bytes = b"tensor_file\0\x01\0".to_vec();
    bytes.extend((fields.len() as u32).to_le_bytes());
    for field in fields {
        bytes.extend((field.name.len() as u16).to_le_bytes());
        bytes.extend(field.name.as_bytes());
        bytes.extend((field.shape.len() as u16).to_le_bytes());
        bytes.push(field.code);
        bytes.extend((offset as u64).to_le_bytes());
        bytes.extend(field.shape.iter().flat_map(|side| side.to_le_bytes()));
        offset += field.data.len();
    }
    bytes.extend(fields.iter().flat_map(|field| field.data.clone()));
    bytes
}

/// A file that a scene can name.
pub struct MeasuredFile {
    folder: tempfile::TempDir,
}

impl MeasuredFile {
    pub fn new(bytes: &[u8]) -> Self {
        let file = Self { folder: tempfile::tempdir().expect("a folder") };
        std::fs::write(file.path(), bytes).expect("a file");
        file
    }

    /// As scenes name it.
    pub fn path(&self) -> PathBuf {
        self.folder.path().join("measured.bsdf")
    }

    /// The directive of the material.
    pub fn material(&self) -> String {
        format!("Material \"measured\" \"string filename\" \"{}\"\n", self.path().display())
    }
}
