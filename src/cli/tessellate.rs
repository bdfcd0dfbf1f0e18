//! The subcommand `goblet tessellate`: replaces the bodies of revolution of a scene by meshes.

use std::collections::HashMap;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Component, Path, PathBuf};

use super::failure::TessellateError;
use super::outputs::Files;
use super::{Failure, TessellateArgs, terminal};
use crate::base::output::Replacement;
use crate::scene::mesh::tessellate::Tessellation;
use crate::scene::{self, Geometry, Profile, Rewrite, Scene};

/// Writes the meshes, then the scene. Each file is written atomically.
///
/// # Errors
/// The scene or an option is invalid, or a file cannot be written. Everything that can be checked in advance
/// is checked before the first mesh is written.
pub fn run(args: &TessellateArgs) -> Result<(), Failure> {
    let (scene, source) = scene::load_with_text(&args.scene, args.scene_memory.budget())?;
    let bodies = Bodies::of(&scene)?;
    let meshes = bodies.meshes(args.tolerance)?;
    let files = mesh_files(&args.output, meshes.len())?;
    let folder = way_back(args)?;
    let names: Vec<&str> = files.iter().filter_map(|file| file.file_name()?.to_str()).collect();
    let mesh_of = |mesh: &Option<usize>| mesh.map(|mesh| names[mesh]);
    let rewrite = Rewrite { meshes: bodies.mesh_of.iter().map(mesh_of).collect(), folder: &folder };
    let rewritten = rewrite.apply(&source.text)?;

    // The inputs include files that the text names and the scene does not read.
    let named = rewritten.files.iter().map(|file| scene::directory(&args.scene).join(file));
    let inputs = source.files.into_iter().chain(named);
    let inputs = inputs.fold(Files::default(), |files, input| files.reads_for_scene(&input));
    inputs.writes("the scene", [&args.output]).writes("the mesh", &files).check()?;
    write(&args.output, &rewritten.text, &files, &meshes)?;
    Ok(())
}

/// Writes all files. The scene is the last, so that it never names a mesh that does not exist.
fn write(output: &Path, text: &str, files: &[PathBuf], meshes: &[Tessellation]) -> Result<(), TessellateError> {
    let mut scene = Replacement::create(output).map_err(|reason| cannot_write(output, reason))?;
    for (path, mesh) in files.iter().zip(meshes) {
        write_mesh(path, mesh).map_err(|reason| cannot_write(path, reason))?;
        terminal::say(format_args!("wrote {}: {} triangles", path.display(), mesh.triangle_count()));
    }
    let written = scene.write_all(text.as_bytes()).and_then(|()| scene.commit());
    written.map_err(|reason| cannot_write(output, reason))?;
    let copy = if meshes.is_empty() { ", a copy: the scene has no Shape \"revolution\"" } else { "" };
    terminal::say(format_args!("wrote {}{copy}", output.display()));
    Ok(())
}

/// The bodies of revolution of a scene.
struct Bodies<'a> {
    /// The distinct bodies: profile, whether the body is mirrored, and the location of the first one in the
    /// text.
    distinct: Vec<(&'a Profile, bool, &'a str)>,
    /// For each `Shape "revolution"` in the text, its index in `distinct`; `None` if the shape is not
    /// rendered.
    mesh_of: Vec<Option<usize>>,
}

impl<'a> Bodies<'a> {
    fn of(scene: &'a Scene) -> Result<Self, TessellateError> {
        let mut bodies = Self { distinct: Vec::new(), mesh_of: Vec::new() };
        let mut places = HashMap::new();
        for shape in &scene.shapes {
            let (Geometry::Revolution(profile), Some(directive)) = (&shape.geometry, shape.revolution) else {
                continue;
            };
            let location = shape.location.as_str();
            if shape.emission.as_ref().is_some_and(|emission| emission.power.is_some()) {
                return Err(TessellateError::Power { location: location.to_owned() });
            }
            // A mirroring transform flips the normal of a body, but not the normal of a mesh.
            // ReverseOrientation flips both.
            let mirrored = shape.world_from_object.matrix3.determinant() < 0.0;
            let place = *places.entry((bits(profile), mirrored)).or_insert(bodies.distinct.len());
            if place == bodies.distinct.len() {
                bodies.distinct.push((&**profile, mirrored, location));
            }
            bodies.mesh_of.resize(bodies.mesh_of.len().max(directive + 1), None);
            bodies.mesh_of[directive] = Some(place);
        }
        Ok(bodies)
    }

    fn meshes(&self, tolerance: f64) -> Result<Vec<Tessellation>, TessellateError> {
        let mesh = |(profile, mirrored, location): &(&Profile, bool, &str)| {
            let too_fine = |reason| TessellateError::TooFine { location: (*location).to_owned(), reason };
            Tessellation::new(profile, tolerance, *mirrored).map_err(too_fine)
        };
        self.distinct.iter().map(mesh).collect()
    }
}

/// Returns the bits of a profile's points, by which profiles are compared.
fn bits(profile: &Profile) -> Vec<Vec<[u64; 2]>> {
    let bits = |segment: &crate::geometry::bezier::Curve| {
        segment.points.iter().map(|point| point.to_array().map(f64::to_bits)).collect()
    };
    profile.segments.iter().map(bits).collect()
}

/// Returns the names of the meshes: `OUT-1.ply` and so on, in the folder of `OUT.pbrt`.
fn mesh_files(output: &Path, count: usize) -> Result<Vec<PathBuf>, TessellateError> {
    let stem = output.file_stem().and_then(|stem| stem.to_str());
    let stem = stem.ok_or_else(|| TessellateError::Name(output.to_owned()))?;
    Ok((1..=count).map(|i| output.with_file_name(format!("{stem}-{i}.ply"))).collect())
}

/// Returns the relative path from the folder of the new scene to the folder of the old one; empty if they are
/// the same.
fn way_back(args: &TessellateArgs) -> Result<String, TessellateError> {
    let canonical = |file: &Path| {
        let folder = scene::directory(file);
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        fs::canonicalize(folder).map_err(|reason| cannot_write(&args.output, reason))
    };
    let way = way(&canonical(&args.output)?, &canonical(&args.scene)?);
    way.into_os_string().into_string().map_err(|way| TessellateError::Name(way.into()))
}

/// Returns the relative path from one folder to another; empty if they are the same.
fn way(from: &Path, to: &Path) -> PathBuf {
    let common = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return to.to_owned();
    }
    let up = from.components().skip(common).map(|_| Component::ParentDir);
    up.chain(to.components().skip(common)).collect()
}

fn write_mesh(path: &Path, mesh: &Tessellation) -> io::Result<()> {
    let mut replacement = Replacement::create(path)?;
    let mut out = BufWriter::new(&mut replacement);
    mesh.write_ply(&mut out)?;
    out.flush()?;
    drop(out);
    replacement.commit()
}

fn cannot_write(path: &Path, reason: io::Error) -> TessellateError {
    TessellateError::Write { path: path.to_owned(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_between_folders() {
        for (from, to, expected) in [
            ("/a/b", "/a/b", ""),
            ("/a", "/a/b/c", "b/c"),
            ("/a/b/c", "/a", "../.."),
            ("/a/b", "/a/c/d", "../c/d"),
            ("/a", "/b", "../b"),
        ] {
            assert_eq!(way(Path::new(from), Path::new(to)), Path::new(expected), "{from} to {to}");
        }
    }
}
