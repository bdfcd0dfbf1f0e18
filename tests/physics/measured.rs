//! Measured materials: tables of analytic surfaces reflect what those do, by eye paths, lamps and photons.

use glam::DVec3;
use goblet::{Guidance, Options};

use super::{EYE_ONLY, Shot, assert_near, camera, square};
use crate::support::measured::{Analytic, ISOTROPIC, MeasuredFile, Steps, Tables};
use crate::support::{self, mean, work};

fn lambertian(albedo: f64) -> Tables {
    Tables::new(&Analytic::lambertian(albedo), &ISOTROPIC)
}

/// Radiance of a surface in a white furnace, seen at several angles. A pixel has 256 paths, whose weights differ little.
#[test]
fn a_furnace_shows_the_albedo() {
    for (surface, name) in [(Analytic::lambertian(0.6), "Lambertian"), (Analytic::ggx([0.3; 2]), "GGX")] {
        let file = Tables::new(&surface, &ISOTROPIC).write();
        for cos in [1.0, 0.7, 0.4] {
            let to = DVec3::new(f64::sqrt(1.0 - cos * cos), 0.0, cos);
            let look = camera(&format!("{} {} {}  0 0 0  0 1 0", to.x, to.y, to.z), 5.0);
            let world = format!("LightSource \"infinite\"\n{}{}", file.material(), square(2.0, 0.0));
            let rendered = Shot { resolution: [16; 2], depth: 2, ..EYE_ONLY }.take(&look, &world);
            let expected = surface.albedo(to, 300);
            assert_near(&format!("{name} at {cos}"), mean(&rendered.image), [expected; 3], 0.01);
            assert!(mean(&rendered.image)[0] < 1.005);
        }
    }
}

/// A lamp that is large as seen from the surface: next-event estimation and eye paths share its light.
#[test]
fn a_tabulated_lambertian_surface_is_lit_as_a_diffuse_one() {
    let file = lambertian(0.6).write();
    let lamp = format!(
        "AttributeBegin Translate .5 0 1 AreaLightSource \"diffuse\" \"rgb L\" [3 2 1] \"bool twosided\" true {} AttributeEnd\n\
         LightSource \"point\" \"point3 from\" [-1 .5 .5] \"rgb I\" [.1 .2 .3]\n",
        square(0.7, 0.0)
    );
    let by = |material: &str| {
        let world = format!("{lamp}{material}{}", square(1.0, 0.0));
        let shot = Shot { resolution: [16; 2], depth: 2, ..EYE_ONLY };
        mean(&shot.take(&camera("0 -2 .6  0 0 0  0 0 1", 30.0), &world).image)
    };
    let diffuse = by("Material \"diffuse\" \"rgb reflectance\" [.6 .6 .6]\n");
    assert_near("a lamp on tables", by(&file.material()), diffuse, 0.01);
}

/// Light that a spot light sends to a surface, and the surface to a diffuse wall, where photons are counted.
fn wall_lit_by(material: &str, turn: f64) -> [f64; 3] {
    let mirror = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point2 uv\" [0 0 1 0 1 1 0 1] \
         \"point3 P\" [-.5 -.5 0 .5 -.5 0 .5 .5 0 -.5 .5 0]";
    let wall = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
         \"point3 P\" [1 -1.5 0 1 1.5 0 1 1.5 2 1 -1.5 2]";
    let text = format!(
        "PixelFilter \"box\" \"float xradius\" .5 \"float yradius\" .5\n\
         LookAt -2 0 1  1 0 1  0 0 1\nRotate -{turn} 0 1 1\nCamera \"perspective\" \"float fov\" 40\n\
         WorldBegin\nRotate {turn} 0 1 1\n\
         LightSource \"spot\" \"point3 from\" [-1 .2 1] \"point3 to\" [0 0 0] \"float coneangle\" 14 \"rgb I\" [9 9 9]\n\
         {material}{mirror}\nMaterial \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n{wall}"
    );
    let options = Options {
        guidance: Guidance::Off,
        resolution: Some([32; 2]),
        photons: Some(200_000),
        radius: Some(0.05),
        alpha: Some(1.0),
        max_depth: Some(3),
        ..Options::default()
    };
    mean(&support::render(&text, &options, work(10, 40)).image)
}

/// A metal that reflects nearly all light off rough facets, and the tables of such facets.
fn metal_and_tables(alpha: [f64; 2]) -> (String, MeasuredFile) {
    let [u, v] = alpha;
    let metal = format!(
        "Material \"conductor\" \"rgb eta\" [.001 .001 .001] \"rgb k\" [100 100 100] \"float uroughness\" {u} \
         \"float vroughness\" {v} \"bool remaproughness\" false\n"
    );
    let turning = Steps { size: [32, 32], azimuths: 25, turn: 0.5, polar_angles: 17 };
    let steps = if u == v { ISOTROPIC } else { turning };
    (metal, Tables::new(&Analytic::ggx(alpha), &steps).write())
}

#[test]
fn photons_leave_tables_as_they_leave_the_surface() {
    let lambert = lambertian(0.6).write();
    let diffuse = "Material \"diffuse\" \"rgb reflectance\" [.6 .6 .6]\n";
    assert_near("Lambertian", wall_lit_by(&lambert.material(), 0.0), wall_lit_by(diffuse, 0.0), 0.01);
    for alpha in [[0.3, 0.6], [0.4; 2], [0.6, 0.3]].into_iter().take(work(1, 3)) {
        let (metal, tables) = metal_and_tables(alpha);
        let expected = wall_lit_by(&metal, 0.0);
        assert_near(&format!("GGX {alpha:?}"), wall_lit_by(&tables.material(), 0.0), expected, 0.01);
    }
}

/// The same scene, turned with its camera, has the same image up to noise.
#[test]
fn a_turned_scene_is_reflected_alike() {
    let (_, tables) = metal_and_tables([0.6, 0.3]);
    let [straight, turned] = [0.0, 50.0].map(|turn| wall_lit_by(&tables.material(), turn));
    assert_near("turned", turned, straight, 0.01);
}
