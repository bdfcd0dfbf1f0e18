//! The scenes: files, and meshes of any size.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use goblet::glam::DVec3;
use goblet::scene::{Geometry, Mesh, Scene};

use crate::Result;
use crate::arguments::Arguments;
use crate::place::root;
use crate::random::Rng;

/// Of the project, so that the benchmark may run in any folder.
const FLAT: &str = "scenes/cornell-caustic.pbrt";
const REVOLUTION: &str = "scenes/wine-cup.pbrt";

/// Triangles of the meshes of water, about, by their names.
const WATERS: [(&str, u32); 5] =
    [("water-1e3", 1000), ("water-1e4", 10_000), ("water-1e5", 100_000), ("water-1e6", 1_000_000), (LARGE, 10_000_000)];
/// The one that takes a minute to build.
const LARGE: &str = "water-1e7";

const INSTANCES: usize = 1000;
/// Triangles of an instance, about.
const BALL_TRIANGLES: u32 = 1000;

/// The shape that a generated mesh takes the place of.
const PLACEHOLDER: &str = "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2 ] \"point3 P\" [ 0 0 0 1 0 0 0 0 1 ]\n";

/// A box without its front, with a lamp under its ceiling.
const BOX: &str = r#"
LookAt 0 0.9 3.4  0 0.3 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
Material "diffuse" "rgb reflectance" [ 0.7 0.7 0.7 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 4 6 5 4 7 6 0 4 5 0 5 1 0 3 7 0 7 4 1 5 6 1 6 2 ]
  "point3 P" [ -1 -0.5 -1  1 -0.5 -1  1 -0.5 1  -1 -0.5 1  -1 1.5 -1  1 1.5 -1  1 1.5 1  -1 1.5 1 ]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [ 15 15 15 ]
  Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ]
    "point3 P" [ -0.25 1.48 -0.25  0.25 1.48 -0.25  0.25 1.48 0.25  -0.25 1.48 0.25 ]
AttributeEnd
"#;

/// What a scene comes from.
pub enum Source {
    File(PathBuf),
    /// A surface of water in a box: its name and its approximate number of triangles.
    Water(&'static str, u32),
    /// Many instances of a small mesh over a floor.
    Instances,
}

/// The scenes that are asked for.
pub fn sources(arguments: &Arguments) -> Vec<Source> {
    let mut sources = vec![Source::File(root().join(FLAT))];
    let waters = WATERS.into_iter().filter(|(name, _)| arguments.large || *name != LARGE);
    sources.extend(waters.map(|(name, triangles)| Source::Water(name, triangles)));
    sources.extend([Source::Instances, Source::File(root().join(REVOLUTION))]);
    sources.extend(arguments.scenes.iter().cloned().map(Source::File));
    sources.retain(|source| source.name().contains(&arguments.only));
    sources
}

impl Source {
    /// The name of the scene; that of a file is without folder and extension.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            Self::Water(name, _) => (*name).into(),
            Self::Instances => format!("instances-{INSTANCES}"),
        }
    }

    pub fn load(&self) -> Result<Scene> {
        match self {
            Self::File(path) => Ok(Scene::load(path)?),
            Self::Water(name, triangles) => water(name, *triangles),
            Self::Instances => instances(),
        }
    }
}

/// The number of triangles that a ray may meet: those of instances count for each.
pub fn triangles(scene: &Scene) -> usize {
    let copies = |object| scene.instances.iter().filter(|instance| instance.object == object).count();
    let count = |shape: &goblet::scene::Shape| match &shape.geometry {
        Geometry::Mesh(mesh) => mesh.triangles.len() * shape.object.map_or(1, copies),
        _ => 0,
    };
    scene.shapes.iter().map(count).sum()
}

fn water(name: &str, triangles: u32) -> Result<Scene> {
    let text = format!("{BOX}Material \"dielectric\" \"float eta\" 1.33\n{PLACEHOLDER}");
    let mut scene = Scene::parse(&text, name, Path::new("."))?;
    let shape = scene.shapes.last_mut().ok_or("no shape")?;
    shape.geometry = grid(triangles, 1.0, |u, v| {
        let (x, z) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        let height =
            0.05 * (5.0 * x + 3.0 * z).sin() + 0.03 * (11.0 * z - 7.0 * x).sin() + 0.01 * (31.0 * x + 23.0 * z).sin();
        DVec3::new(x, height, z)
    });
    Ok(scene)
}

fn instances() -> Result<Scene> {
    let mut rng = Rng(1);
    let mut text = format!("{BOX}ObjectBegin \"ball\"\n{PLACEHOLDER}ObjectEnd\n");
    for _ in 0..INSTANCES {
        let place = rng.cube(0.9) + DVec3::new(0.0, 0.45, 0.0);
        let (axis, angle, size) = (rng.direction(), rng.range(0.0, 360.0), rng.range(0.02, 0.06));
        write!(text, "AttributeBegin\nTranslate {} {} {}\n", place.x, place.y, place.z)?;
        write!(text, "Rotate {angle} {} {} {}\nScale {size} {size} {size}\n", axis.x, axis.y, axis.z)?;
        text += "ObjectInstance \"ball\"\nAttributeEnd\n";
    }
    let mut scene = Scene::parse(&text, "instances", Path::new("."))?;
    let shape = scene.shapes.iter_mut().find(|shape| shape.object.is_some()).ok_or("no object")?;
    // A bumpy ball with small holes at its poles.
    shape.geometry = grid(BALL_TRIANGLES, 2.0, |u, v| {
        let (phi, theta) = (TAU * u, PI * (0.01 + 0.98 * v));
        let radius = 1.0 + 0.1 * (6.0 * phi).sin() * (5.0 * theta).sin();
        radius * DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    });
    Ok(scene)
}

/// A mesh of about `triangles` triangles: the image of the unit square. `aspect` is the number of cells along u
/// over that along v.
fn grid(triangles: u32, aspect: f64, at: impl Fn(f64, f64) -> DVec3) -> Geometry {
    let rows = (f64::from(triangles) / (2.0 * aspect)).sqrt().round() as u32;
    let columns = (f64::from(rows) * aspect).round() as u32;
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        let point = |column| at(f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
        mesh.positions.extend((0..=columns).map(point));
    }
    for row in 0..rows {
        for column in 0..columns {
            let corner = row * (columns + 1) + column;
            let above = corner + columns + 1;
            mesh.triangles.extend([[corner, above, corner + 1], [corner + 1, above, above + 1]]);
        }
    }
    Geometry::Mesh(Arc::new(mesh))
}
