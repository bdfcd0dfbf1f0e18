//! Tasks of any size: scenes in a folder, and how to render them. The work beside what grows
//! stays as it is: so do radii.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use goblet::Options;

use super::Result;

/// A task.
pub struct Case {
    /// The size that it really has.
    pub size: u64,
    pub scene: PathBuf,
    pub options: Options,
}

const PHOTONS: u64 = 65_536;
const CORNELL: &str = "scenes/cornell-caustic.pbrt";

/// A room that is open in front, seen as the Cornell box is: 10 triangles.
const ROOM: &str = r#"Film "rgb" "string filename" "room.exr"
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Integrator "sppm" "integer maxdepth" 20 "float radius" 0.025
LookAt 0 1 4.9  0 1 0  0 1 0
Camera "perspective" "float fov" 30
WorldBegin
Material "diffuse" "rgb reflectance" [ 0.7 0.7 0.7 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3  4 5 6 4 6 7  1 2 6 1 6 5  0 1 5 0 5 4  3 2 6 3 6 7 ]
  "point3 P" [ -1 0 1  -1 0 -1  1 0 -1  1 0 1  -1 2 1  -1 2 -1  1 2 -1  1 2 1 ]
"#;

/// Two triangles below the ceiling of the room.
const LAMP: &str = r#"AttributeBegin
  AreaLightSource "diffuse" "rgb L" [ 15 15 15 ] "bool twosided" true
  Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ]
    "point3 P" [ -0.25 1.98 -0.25  0.25 1.98 -0.25  0.25 1.98 0.25  -0.25 1.98 0.25 ]
AttributeEnd
"#;

fn options(side: u32, photons: u64) -> Options {
    Options { resolution: Some([side; 2]), photons: Some(photons), alpha: Some(1.0), ..Options::default() }
}

/// A square image of about `size` pixels.
pub fn pixels(_: &Path, size: u64) -> Result<Case> {
    let side = size.isqrt() as u32;
    Ok(Case { size: u64::from(side).pow(2), scene: CORNELL.into(), options: options(side, PHOTONS) })
}

/// So many photons an iteration.
pub fn photons(_: &Path, size: u64) -> Result<Case> {
    Ok(Case { size, scene: CORNELL.into(), options: options(128, size) })
}

/// A hilly floor of about `size` triangles. The hills do not depend on `size`.
pub fn triangles(folder: &Path, size: u64) -> Result<Case> {
    let cells = ((size as f64 / 2.0).sqrt().round() as u32).max(1);
    write_hills(&folder.join("hills.ply"), cells)?;
    let scene = folder.join("triangles.pbrt");
    fs::write(&scene, format!("{ROOM}Shape \"plymesh\" \"string filename\" \"hills.ply\"\n{LAMP}"))?;
    Ok(Case { size: 2 * u64::from(cells).pow(2) + 12, scene, options: options(256, PHOTONS) })
}

/// Binary PLY of a height field of `cells` by `cells` squares, two triangles each.
fn write_hills(path: &Path, cells: u32) -> Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    let (vertices, faces) = (u64::from(cells + 1).pow(2), 2 * u64::from(cells).pow(2));
    write!(file, "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\n")?;
    write!(file, "property float x\nproperty float y\nproperty float z\nelement face {faces}\n")?;
    write!(file, "property list uchar int vertex_indices\nend_header\n")?;
    let at = |i: u32| 1.96 * f64::from(i) / f64::from(cells) - 0.98;
    for (x, z) in (0..=cells).flat_map(|i| (0..=cells).map(move |j| (at(i), at(j)))) {
        let y = 0.3 + 0.1 * (3.0 * PI * x).sin() * (3.0 * PI * z).cos();
        [x, y, z].into_iter().try_for_each(|value| file.write_all(&(value as f32).to_le_bytes()))?;
    }
    for first in (0..cells).flat_map(|i| (0..cells).map(move |j| i * (cells + 1) + j)) {
        let [a, b, c, d] = [first, first + 1, first + cells + 2, first + cells + 1];
        for corners in [[a, b, c], [a, c, d]] {
            file.write_all(&[3])?;
            corners.into_iter().try_for_each(|corner| file.write_all(&corner.to_le_bytes()))?;
        }
    }
    Ok(file.flush()?)
}

/// So many point lights, of seven powers, above the floor; all power is theirs together.
pub fn lights(folder: &Path, size: u64) -> Result<Case> {
    let mut text = ROOM.to_owned();
    for i in 0..size {
        // Roberts's sequence: points that are spread evenly.
        let [x, z] = [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (0.5 + step * i as f64).fract() - 0.5);
        let intensity = 0.75 * (1 + i % 7) as f64 / size as f64;
        let place = format!("[ {x:.6} 1.5 {z:.6} ]");
        writeln!(
            text,
            "LightSource \"point\" \"point3 from\" {place} \"rgb I\" [ {intensity:e} {intensity:e} {intensity:e} ]"
        )?;
    }
    let scene = folder.join("lights.pbrt");
    fs::write(&scene, text)?;
    Ok(Case { size, scene, options: options(256, PHOTONS) })
}
