//! Measured reflection.

/// Values on a grid over the unit square. Its corners are values.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T> {
    /// Number of values along the first coordinate; 2 or more.
    pub width: usize,
    /// Number of values along the second coordinate; 2 or more.
    pub height: usize,
    /// Rows of the values of all slices: one grid, or one for each azimuth and each polar angle, polar angles
    /// fastest.
    pub values: Vec<T>,
}

/// The tables of a measured material (Dupuy and Jakob, "An Adaptive Parameterization for Efficient Material
/// Acquisition and Rendering", 2018).
///
/// Directions are points of the unit square: the first coordinate is the square root of twice the polar angle over
/// pi, the second is the azimuth over 2 pi, plus 1/2. The incident direction is that from which the tables were
/// measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Azimuths of incident directions, in radians, ascending; one or two for an isotropic material.
    pub azimuths: Vec<f32>,
    /// Polar angles of incident directions, in radians, ascending.
    pub polar_angles: Vec<f32>,
    /// How many times the azimuths' range goes into a full turn, by the material's symmetry: 1, 2 or 4.
    pub reduction: u32,
    /// Distribution of microfacet normals by their direction, 1/sr.
    pub normals: Grid<f32>,
    /// Projected area of the microfacets by the incident direction.
    pub projected_area: Grid<f32>,
    /// Distribution of visible normals, times the area of the unit square per solid angle: slices by the normal's
    /// direction, relative to the incident azimuth if the material is isotropic. Their scale does not matter.
    pub visible_normals: Grid<f32>,
    /// Luminance that a light reflects: slices by the numbers that sample a visible normal. Their scale does not
    /// matter.
    pub luminance: Grid<f32>,
    /// BRDF times the cosine of the outgoing direction and 4 projected areas over the normals' distribution, in
    /// linear sRGB: slices as those of `luminance`.
    pub colors: Grid<[f32; 3]>,
}

impl Measured {
    /// Returns true if the reflection does not depend on the azimuth of the incident direction.
    pub fn is_isotropic(&self) -> bool {
        self.azimuths.len() <= 2
    }

    /// Returns the number of slices of grids that have them.
    pub fn slices(&self) -> usize {
        self.azimuths.len() * self.polar_angles.len()
    }
}
