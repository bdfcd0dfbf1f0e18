//! The `Shape` directive.

// Circle: shape.rs <-> bilinear.rs <-> cylinder.rs <-> subdivision.rs: one file per type of shape, with the checks of parameters that all meshes share here.

mod bilinear;
mod cylinder;
mod subdivision;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::base::input::Budget;
use crate::geometry::bezier::{Curve, MAX_DEGREE};

use crate::scene::directives::texture::Textures;
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::kind::Kind;
use crate::scene::format::params::{Param, ParamList};
use crate::scene::format::registry::{Family, ParamSpec, full, ignored, later, not_yet, supported};
use crate::scene::mesh::ply::{self, PlyError};
use crate::scene::model::{Geometry, Input, Mesh, Profile};

const FLOAT: &[Kind] = &[Kind::Float];
const ALPHA: ParamSpec = full("alpha", &[Kind::Float, Kind::Texture]);

/// The shapes of pbrt, and goblet's `revolution`.
pub(in crate::scene) const FAMILY: Family = Family {
    directive: "Shape",
    types: &[
        supported(
            "bilinearmesh",
            &[
                full("indices", &[Kind::Integer]),
                full("P", &[Kind::Point3]),
                full("N", &[Kind::Normal]),
                full("uv", &[Kind::Point2]),
                // A hint where to sample the patch as a light, whose radiance it does not change.
                ignored("emissionfilename", &[Kind::String]),
                ignored("faceIndices", &[Kind::Integer]),
                ALPHA,
            ],
        ),
        supported(
            "cylinder",
            &[full("radius", FLOAT), full("zmin", FLOAT), full("zmax", FLOAT), full("phimax", FLOAT), ALPHA],
        ),
        supported(
            "disk",
            &[full("height", FLOAT), full("radius", FLOAT), full("innerradius", FLOAT), full("phimax", FLOAT), ALPHA],
        ),
        supported(
            "loopsubdiv",
            &[
                full("levels", &[Kind::Integer]),
                full("indices", &[Kind::Integer]),
                full("P", &[Kind::Point3]),
                // pbrt has only one scheme.
                ignored("scheme", &[Kind::String]),
                ALPHA,
            ],
        ),
        supported(
            "plymesh",
            &[
                full("filename", &[Kind::String]),
                later("displacement", &[Kind::Float, Kind::Texture]),
                ignored("displacement.edgelength", FLOAT),
                ALPHA,
            ],
        ),
        supported("revolution", &[full("P", &[Kind::Point2]), full("degree", &[Kind::Integer]), ALPHA]),
        supported(
            "sphere",
            &[full("radius", FLOAT), full("zmin", FLOAT), full("zmax", FLOAT), full("phimax", FLOAT), ALPHA],
        ),
        supported(
            "trianglemesh",
            &[
                full("indices", &[Kind::Integer]),
                full("P", &[Kind::Point3]),
                full("N", &[Kind::Normal]),
                full("uv", &[Kind::Point2]),
                // Tangents and face numbers are only used by features that are not supported yet.
                ignored("S", &[Kind::Vector3]),
                ignored("faceIndices", &[Kind::Integer]),
                ALPHA,
            ],
        ),
        not_yet("curve"),
    ],
};

/// Mesh files; each file is read once.
#[derive(Debug)]
pub(in crate::scene) struct MeshFiles {
    /// Directory that file names are relative to: the folder of the scene file, as in pbrt.
    pub directory: PathBuf,
    read: HashMap<PathBuf, Arc<Mesh>>,
    pub(in crate::scene) budget: Arc<Budget>,
}

impl MeshFiles {
    pub fn new(directory: &Path, budget: &Arc<Budget>) -> Self {
        Self { directory: directory.to_path_buf(), read: HashMap::new(), budget: Arc::clone(budget) }
    }

    fn get(&mut self, name: &str, location: &Location) -> Result<Arc<Mesh>, SceneError> {
        let path = self.directory.join(name);
        if let Some(mesh) = self.read.get(&path) {
            return Ok(Arc::clone(mesh));
        }
        let mesh = ply::read(&path, &self.budget).map_err(|error| match error {
            PlyError::Unreadable(source) => {
                SceneError::Unreadable { path: path.clone(), location: Some(location.clone()), source }
            }
            PlyError::Invalid(what) => location.invalid(format!("{}: {what}", path.display())),
        })?;
        self.budget.take(mesh.bytes() + path.as_os_str().len() as u64).map_err(location.over())?;
        let mesh = Arc::new(mesh);
        self.read.insert(path, Arc::clone(&mesh));
        Ok(mesh)
    }
}

/// Returns a shape's alpha, 0 to 1; 1 by default.
pub(in crate::scene) fn alpha(params: &ParamList, textures: &Textures) -> Result<Input<f64>, SceneError> {
    let Some(param) = params.get("alpha") else {
        return Ok(Input::Constant(1.0));
    };
    match textures.number(param)? {
        Input::Constant(alpha) if !(0.0..=1.0).contains(&alpha) => Err(param.bad_value("a number from 0 to 1")),
        alpha => Ok(alpha),
    }
}

/// Returns a shape's geometry from parameters that [`FAMILY`] has checked.
pub(in crate::scene) fn geometry(
    name: &str,
    params: &ParamList,
    files: &mut MeshFiles,
    location: &Location,
) -> Result<Geometry, SceneError> {
    let budget = &*files.budget;
    let kept = |mesh: Mesh| {
        budget.take(mesh.bytes()).map_err(location.over())?;
        Ok(Geometry::Mesh(Arc::new(mesh)))
    };
    match name {
        "bilinearmesh" => bilinear::mesh(params, budget, location).and_then(kept),
        "cylinder" => cylinder::geometry(params),
        "disk" => disk(params),
        "loopsubdiv" => subdivision::mesh(params, budget, location).and_then(kept),
        "revolution" => Ok(Geometry::Revolution(Arc::new(profile(params, budget, location)?))),
        "sphere" => sphere(params),
        "trianglemesh" => triangle_mesh(params, budget, location).and_then(kept),
        _ => {
            let file = params
                .get("filename")
                .ok_or_else(|| location.invalid("Shape \"plymesh\" has no \"string filename\"; expected one"))?;
            let name = params.string("filename")?.unwrap_or_default();
            Ok(Geometry::Mesh(files.get(name, &file.location)?))
        }
    }
}

/// Returns true if rays can meet a shape that its transform has flattened: only the triangles of a mesh.
/// Removes the mesh's normals.
pub(in crate::scene) fn stays_when_flattened(geometry: &mut Geometry) -> bool {
    let Geometry::Mesh(mesh) = geometry else { return false };
    // A singular transform has no transform of normals.
    if !mesh.normals.is_empty() {
        Arc::make_mut(mesh).normals.clear();
    }
    true
}

/// Fails if a light has a power and its shape consists of several emitters in goblet.
pub(in crate::scene) fn check_power(name: &str, geometry: &Geometry, location: &Location) -> Result<(), SceneError> {
    let is_cut = name == "bilinearmesh" || name == "cylinder" && matches!(geometry, Geometry::Mesh(_));
    if is_cut {
        let what = format!("the \"float power\" of a light that is a {name}");
        return Err(location.unsupported(&what, "its radiance alone"));
    }
    Ok(())
}

fn sphere(params: &ParamList) -> Result<Geometry, SceneError> {
    let radius = params.positive("radius", 1.0)?;
    let z0 = params.float("zmin")?.unwrap_or(-radius);
    let z1 = params.float("zmax")?.unwrap_or(radius);
    let [z_min, z_max] = [z0.min(z1), z0.max(z1)].map(|z| z.clamp(-radius, radius));
    if let Some(param) = params.get("zmin").or(params.get("zmax"))
        && z_min >= z_max
    {
        return Err(param.bad_value("cuts that leave some of the sphere"));
    }
    Ok(Geometry::Sphere { radius, z_min, z_max, phi_max: phi_max(params)? })
}

fn disk(params: &ParamList) -> Result<Geometry, SceneError> {
    let radius = params.positive("radius", 1.0)?;
    Ok(Geometry::Disk {
        height: params.float("height")?.unwrap_or(0.0),
        radius,
        inner_radius: params.float_in(
            "innerradius",
            0.0,
            |v| (0.0..radius).contains(&v),
            "0 or more, below the radius",
        )?,
        phi_max: phi_max(params)?,
    })
}

/// Minimum and maximum of radii and heights of a profile: their squares must be finite and not 0.
const PROFILE_SIZES: [f64; 2] = [1e-30, 1e30];

/// Bytes of a segment of a profile without its points: in the scene, and as pieces on the device.
const SEGMENT_BYTES: usize = 1024;

fn profile(params: &ParamList, budget: &Budget, location: &Location) -> Result<Profile, SceneError> {
    let degree = params.integer("degree", 1, MAX_DEGREE as u32)?.unwrap_or(3) as usize;
    let param = params.get("P").ok_or_else(|| {
        location.invalid("Shape \"revolution\" has no \"point2 P\"; expected the radius and height of each point")
    })?;
    let points = params.pairs("P");
    if points.len() <= degree || !(points.len() - 1).is_multiple_of(degree) {
        return Err(param.location.invalid(format!(
            "{param} has {} points; expected {degree} for each segment and one more, for degree {degree}",
            points.len()
        )));
    }
    let [least, most] = PROFILE_SIZES;
    if let Some(at) = points.iter().position(|point| point.x < 0.0 || point.abs().max_element() > most) {
        return Err(param.location.invalid(format!(
            "{param} has ({}, {}) at position {at}; expected a radius from 0 and a height, up to {most:e}",
            points[at].x, points[at].y
        )));
    }
    let widest = points.iter().map(|point| point.x).fold(0.0, f64::max);
    let extent = points.iter().map(|point| (*point - points[0]).abs().max_element()).fold(0.0, f64::max);
    if widest < least || extent < least {
        let what = if widest < least { "stays on the axis" } else { "is a single point" };
        return Err(param.location.invalid(format!("{param} {what}; expected a profile that makes a surface")));
    }
    let bytes = (points.len() - 1) / degree * (SEGMENT_BYTES + (degree + 1) * size_of::<DVec2>());
    budget.take(bytes as u64).map_err(param.location.over())?;
    let segment = |first: usize| Curve { points: points[first..=first + degree].to_vec() };
    Ok(Profile { segments: (0..points.len() - 1).step_by(degree).map(segment).collect() })
}

/// Returns the sweep in radians; as in pbrt, more than a full turn is a full turn.
fn phi_max(params: &ParamList) -> Result<f64, SceneError> {
    let degrees = params.float_in("phimax", 360.0, |v| v > 0.0, "an angle above 0°")?;
    Ok(degrees.min(360.0).to_radians())
}

fn triangle_mesh(params: &ParamList, budget: &Budget, location: &Location) -> Result<Mesh, SceneError> {
    check_copies(params, budget, location)?;
    let positions = positions("trianglemesh", params, location)?;
    let triangles = match params.get("indices") {
        Some(indices) => faces(indices, positions.len())?,
        None if positions.len() == 3 => vec![[0, 1, 2]],
        None => return Err(no_indices("trianglemesh", positions.len(), location)),
    };
    let (normals, uvs) = attributes(params, positions.len())?;
    Ok(Mesh { positions, normals, uvs, triangles })
}

/// Fails if the budget has no memory for the arrays of a mesh besides its parameters. The arrays take no
/// more memory than the parameters.
fn check_copies(params: &ParamList, budget: &Budget, location: &Location) -> Result<(), SceneError> {
    let numbers: usize = params.items.iter().map(|param| param.numbers().len()).sum();
    budget.check((numbers * size_of::<f64>()) as u64).map_err(location.over())
}

fn positions(shape: &str, params: &ParamList, location: &Location) -> Result<Vec<DVec3>, SceneError> {
    let positions = params.triples("P");
    if positions.is_empty() {
        return Err(location.invalid(format!("Shape \"{shape}\" has no \"point3 P\"; expected vertices")));
    }
    Ok(positions)
}

fn no_indices(shape: &str, vertices: usize, location: &Location) -> SceneError {
    location.invalid(format!("Shape \"{shape}\" has {vertices} vertices and no \"integer indices\"; expected indices"))
}

/// Returns normals and texture coordinates: one per vertex, or none.
fn attributes(params: &ParamList, vertices: usize) -> Result<(Vec<DVec3>, Vec<DVec2>), SceneError> {
    let (normals, uvs) = (params.triples("N"), params.pairs("uv"));
    for (name, count) in [("N", normals.len()), ("uv", uvs.len())] {
        if let Some(param) = params.get(name).filter(|_| count != vertices) {
            return Err(param
                .location
                .invalid(format!("{param} has {count} entries; expected one for each of the {vertices} vertices")));
        }
    }
    Ok((normals, uvs))
}

/// Returns faces of `N` vertex indices each, all below `vertices`.
fn faces<const N: usize>(param: &Param, vertices: usize) -> Result<Vec<[u32; N]>, SceneError> {
    let indices = param.numbers();
    if indices.is_empty() || !indices.len().is_multiple_of(N) {
        return Err(param
            .location
            .invalid(format!("{param} has {} values; expected {N} for each face", indices.len())));
    }
    let in_range = |index: &f64| (0.0..vertices as f64).contains(index) && *index <= f64::from(u32::MAX);
    if let Some(at) = indices.iter().position(|index| !in_range(index)) {
        return Err(param.location.invalid(format!(
            "{param} has {} at position {at}; expected 0 to {}",
            indices[at],
            vertices - 1
        )));
    }
    let face = |face: &[f64]| std::array::from_fn(|corner| face[corner] as u32);
    Ok(indices.chunks_exact(N).map(face).collect())
}
