//! Files of measured materials, as pbrt-v4 and Mitsuba read them.

use std::cell::RefCell;
use std::collections::HashMap;
use std::f32::consts::{FRAC_PI_2, TAU};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::tensor::{Field, Numbers, TensorError, TensorFile};
use crate::base::input::Budget;
use crate::scene::format::error::{Location, SceneError};
use crate::scene::model::{Grid, Measured, Rgb};
use crate::scene::spectrum::samples::colors_of_samples;

mod tensor;

/// Files of measured materials; each file is read once.
#[derive(Debug, Default)]
pub(in crate::scene) struct MeasuredFiles {
    read: RefCell<HashMap<PathBuf, Arc<Measured>>>,
}

impl MeasuredFiles {
    /// Returns the material in a file. `location` is the place that names the file.
    pub fn get(&self, path: &Path, budget: &Budget, location: &Location) -> Result<Arc<Measured>, SceneError> {
        if let Some(measured) = self.read.borrow().get(path) {
            return Ok(Arc::clone(measured));
        }
        let measured = Arc::new(read(path, budget).map_err(|error| match error {
            TensorError::Unreadable(source) => {
                SceneError::Unreadable { path: path.to_path_buf(), location: Some(location.clone()), source }
            }
            TensorError::OverBudget(over) => location.too_large(&format!("{}: ", path.display()), over),
            error => location.invalid(format!("{}: {error}", path.display())),
        })?);
        self.read.borrow_mut().insert(path.to_path_buf(), Arc::clone(&measured));
        Ok(measured)
    }
}

/// Maximum number of values of all tables, and of nodes of one angle.
const MOST_VALUES: u64 = 1 << 24;
const MOST_NODES: u64 = 1 << 12;
/// Bytes of a value on the device, at most.
const PACKED_VALUE: u64 = 16;

fn read(path: &Path, budget: &Budget) -> Result<Measured, TensorError> {
    let mut file = TensorFile::open(path, budget)?;
    check_jacobian(&mut file)?;
    let limit = [-TAU, TAU];
    let azimuths = ascending(&mut file, "phi_i", limit, "numbers from -2 pi to 2 pi")?;
    let polar_angles = ascending(&mut file, "theta_i", [0.0, FRAC_PI_2 + 1e-4], "numbers from 0 to pi / 2")?;
    let wavelengths = ascending(&mut file, "wavelengths", [1.0, 1e6], "wavelengths in nm")?;
    let reduction = reduction(&file, &azimuths)?;
    let steps = [azimuths.len() as u64, polar_angles.len() as u64];
    let mut budget = Remaining { values: MOST_VALUES, budget };
    let normals = grid(&mut file, "ndf", &[], &mut budget)?;
    let projected_area = grid(&mut file, "sigma", &[], &mut budget)?;
    if let Some(area) = projected_area.values.iter().find(|area| **area <= 0.0) {
        let field = file.field("sigma", Numbers::Floats, 2, "")?;
        return Err(field.unexpected(format!("the value {area}"), "numbers above 0"));
    }
    let visible_normals = grid(&mut file, "vndf", &steps, &mut budget)?;
    let luminance = grid(&mut file, "luminance", &steps, &mut budget)?;
    let colors = colors(&mut file, &wavelengths, steps, &luminance, &mut budget)?;
    Ok(Measured { azimuths, polar_angles, reduction, normals, projected_area, visible_normals, luminance, colors })
}

/// Fails unless the table of visible normals includes the Jacobian of the unit square, as in all files of the
/// database.
fn check_jacobian(file: &mut TensorFile<'_>) -> Result<(), TensorError> {
    let field = file.field("jacobian", Numbers::Bytes, 1, "")?;
    field.expect_shape(&[1])?;
    match file.read(&field, 0, 1)?[..] {
        [1.0] => Ok(()),
        ref found => Err(field.unexpected(format!("the value {found:?}"), "1")),
    }
}

/// Returns a field of ascending numbers between two bounds.
fn ascending(
    file: &mut TensorFile<'_>,
    name: &'static str,
    [least, most]: [f32; 2],
    expected: &str,
) -> Result<Vec<f32>, TensorError> {
    let field = file.field(name, Numbers::Floats, 1, OF_SPECTRA)?;
    let count = field.shape[0];
    if count == 0 || count > MOST_NODES {
        return Err(field.unexpected(format!("{count} values"), format!("1 to {MOST_NODES}")));
    }
    let numbers = file.read(&field, 0, count)?;
    if numbers.iter().any(|number| !(least..=most).contains(number)) || numbers.windows(2).any(|two| two[0] >= two[1]) {
        return Err(field.unexpected("other values", format!("{expected}, ascending")));
    }
    Ok(numbers)
}

/// Ends the message about a field that files without wavelengths do not have.
const OF_SPECTRA: &str = " (files of the RGL database that have all fields end in _spec.bsdf)";

/// Returns how many times the range of the azimuths goes into a full turn; 1 for isotropic materials.
fn reduction(file: &TensorFile<'_>, azimuths: &[f32]) -> Result<u32, TensorError> {
    let [first, .., last] = azimuths else { return Ok(1) };
    if azimuths.len() == 2 {
        return Ok(1);
    }
    let times = (TAU / (last - first)).round();
    let found = [1, 2, 4].into_iter().find(|reduction| times == *reduction as f32);
    found.ok_or_else(|| match file.field("phi_i", Numbers::Floats, 1, "") {
        Ok(field) => field.unexpected(
            format!("azimuths from {first} to {last}"),
            "a full turn, a half or a quarter of one; or one or two azimuths, if the material is isotropic",
        ),
        Err(error) => error,
    })
}

/// The values that a file may still have, and the budget of memory.
struct Remaining<'a> {
    values: u64,
    budget: &'a Budget,
}

impl Remaining<'_> {
    /// Takes the memory of `count` values of a field, on the host and on the device.
    fn take(&mut self, field: &Field, count: u64, bytes: usize) -> Result<(), TensorError> {
        self.values = self
            .values
            .checked_sub(count)
            .ok_or_else(|| field.unexpected(format!("{count} values"), format!("at most {MOST_VALUES} in all")))?;
        self.budget.take(count * bytes as u64)?;
        Ok(self.budget.take_later(count * PACKED_VALUE)?)
    }
}

/// Returns a field that is a grid, or one for each step of the incident angles. Its values are 0 or more, and not
/// all of a slice are 0.
fn grid(
    file: &mut TensorFile<'_>,
    name: &'static str,
    steps: &[u64],
    remaining: &mut Remaining<'_>,
) -> Result<Grid<f32>, TensorError> {
    let field = file.field(name, Numbers::Floats, steps.len() + 2, OF_SPECTRA)?;
    let (before, sides) = field.shape.split_at(steps.len());
    let &[height, width] = sides else { return Err(field.unexpected("too few dimensions", "more")) };
    if width < 2 || height < 2 {
        return Err(field.unexpected(format!("a grid of {height} x {width} values"), "2 or more in each dimension"));
    }
    if before != steps {
        field.expect_shape(&[steps, sides].concat())?;
    }
    // The product fits into the file.
    let count = field.shape.iter().product();
    remaining.take(&field, count, size_of::<f32>())?;
    let values = file.read(&field, 0, count)?;
    if let Some(value) = values.iter().find(|value| **value < 0.0) {
        return Err(field.unexpected(format!("the value {value}"), "0 or more"));
    }
    let grid = Grid { width: width as usize, height: height as usize, values };
    // Halves of values are added: the trapezoids of a slice are positive if any value is.
    let is_black = |slice: &[f32]| slice.iter().all(|value| *value == 0.0);
    if grid.values.chunks(grid.width * grid.height).any(is_black) {
        return Err(field.unexpected("a grid of zeros", "a value above 0 in each grid"));
    }
    Ok(grid)
}

/// Returns the colours of the spectra, which are on the grid of the luminance. As for other reflectances, colours
/// outside of sRGB's gamut are clamped to it; but they may be brighter than white.
fn colors(
    file: &mut TensorFile<'_>,
    wavelengths: &[f32],
    [azimuths, polar_angles]: [u64; 2],
    luminance: &Grid<f32>,
    remaining: &mut Remaining<'_>,
) -> Result<Grid<[f32; 3]>, TensorError> {
    let field = file.field("spectra", Numbers::Floats, 5, OF_SPECTRA)?;
    let (width, height) = (luminance.width, luminance.height);
    field.expect_shape(&[azimuths, polar_angles, wavelengths.len() as u64, height as u64, width as u64])?;
    let texels = width * height;
    remaining.take(&field, azimuths * polar_angles * texels as u64, size_of::<[f32; 3]>())?;
    let weights = colors_of_samples(wavelengths);
    let mut values = Vec::with_capacity(luminance.values.len());
    let block = (wavelengths.len() * texels) as u64;
    for slice in 0..azimuths * polar_angles {
        let spectra = file.read(&field, slice * block, block)?;
        let mut colors = vec![Rgb::ZERO; texels];
        for (samples, weight) in spectra.chunks(texels).zip(&weights) {
            for (color, sample) in colors.iter_mut().zip(samples) {
                *color += *weight * f64::from(sample.max(0.0));
            }
        }
        values.extend(colors.iter().map(|color| color.max(Rgb::ZERO).as_vec3().to_array()));
    }
    Ok(Grid { width, height, values })
}
