//! Every kind of light on a floor, found by the eye and carried by photons.

use std::f64::consts::PI;

use glam::DVec3;
use goblet::image::compare::{Gates, compare};
use goblet::image::film::Image;

use super::{EYE_ONLY, Shot, camera, square, support};

/// A light above a floor in the plane z = 0, and the irradiance that it casts there.
struct Lamp {
    name: &'static str,
    text: String,
    irradiance: Box<dyn Fn(DVec3) -> f64>,
}

impl Lamp {
    fn new(name: &'static str, text: &str, irradiance: impl Fn(DVec3) -> f64 + 'static) -> Self {
        Self { name, text: text.to_owned(), irradiance: Box::new(irradiance) }
    }

    /// A black surface of radiance 4.
    fn area(name: &'static str, text: &str, two_sided: bool, irradiance: impl Fn(DVec3) -> f64 + 'static) -> Self {
        let text = format!(
            "AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
             AreaLightSource \"diffuse\" \"rgb L\" [4 4 4] \"bool twosided\" {two_sided}\n{text}\nAttributeEnd\n"
        );
        Self::new(name, &text, move |p| 4.0 * irradiance(p))
    }
}

fn lamps() -> Vec<Lamp> {
    let at = DVec3::new;
    let from_point = |light: DVec3| {
        move |p: DVec3| {
            let d = light - p;
            d.z / d.length().powi(3)
        }
    };
    let bulb = from_point(at(0.3, 0.2, 1.2));
    let torch = from_point(at(0.9, 0.8, 1.2));
    let beam = move |p: DVec3| {
        let cos = (p - at(0.9, 0.8, 1.2)).normalize().dot(at(-0.4, -0.3, -1.2).normalize());
        let [rim, core] = [35.0, 15.0].map(|degrees: f64| degrees.to_radians().cos());
        let x = ((cos - rim) / (core - rim)).clamp(0.0, 1.0);
        5.0 * torch(p) * x * x * (3.0 - 2.0 * x)
    };
    // A ball of radius r and radiance 1 is a point of intensity π r².
    let ball = from_point(at(-0.7, 0.2, 1.2));
    // The view factor of a disk from a parallel element at a distance from its axis.
    let plate = move |p: DVec3| {
        let [h2, a2, r2] = [1.1 * 1.1, (p - at(0.5, 0.3, 0.0)).length_squared(), 0.4 * 0.4];
        let z = h2 + a2 + r2;
        PI / 2.0 * (1.0 - (z - 2.0 * r2) / (z * z - 4.0 * a2 * r2).sqrt())
    };
    let sail = [at(-0.9, -0.9, 0.9), at(-0.2, -1.1, 1.2), at(-0.6, -0.4, 1.3)];
    let tile = [at(-0.2, -0.6, 1.1), at(0.5, -0.6, 1.1), at(0.5, -0.2, 1.1), at(-0.2, -0.2, 1.1)];
    let egg = move |p: DVec3, d: DVec3| {
        let size = at(-0.4, 0.25, 0.15);
        unit_sphere_hits((p - at(-1.0, 1.0, 1.2)) / size, d / size).is_some()
    };
    let in_turn = |q: DVec3, degrees: f64| q.y.atan2(q.x).rem_euclid(2.0 * PI) <= degrees.to_radians();
    let bowl = move |p: DVec3, d: DVec3| {
        let o = (p - at(-0.2, 0.1, 1.2)) / 0.3;
        unit_sphere_hits(o, d / 0.3).is_some_and(|ts| {
            let hits = ts.map(|t| o + t * d / 0.3);
            hits.iter().any(|q| q.z <= 0.2 && in_turn(*q, 200.0))
        })
    };
    let fan = move |p: DVec3, d: DVec3| {
        let q = p + d * (1.1 - p.z) / d.z - at(0.4, 0.1, 1.1);
        (0.2..0.5).contains(&q.length()) && in_turn(q, 250.0)
    };
    vec![
        Lamp::new("point", "LightSource \"point\" \"point3 from\" [.3 .2 1.2] \"rgb I\" [4 4 4]", move |p| {
            4.0 * bulb(p)
        }),
        Lamp::new(
            "spot",
            "LightSource \"spot\" \"point3 from\" [.9 .8 1.2] \"point3 to\" [.5 .5 0] \"rgb I\" [5 5 5] \
             \"float coneangle\" 35 \"float conedeltaangle\" 20",
            beam,
        ),
        Lamp::area(
            "triangle",
            "Shape \"trianglemesh\" \"integer indices\" [0 2 1] \"point3 P\" [-.9 -.9 .9  -.2 -1.1 1.2  -.6 -.4 1.3]",
            false,
            move |p| polygon(&sail, p),
        ),
        Lamp::area(
            "mirrored ellipsoid",
            "Translate -1 1 1.2\nScale -.4 .25 .15\nReverseOrientation\nShape \"sphere\"",
            false,
            move |p| quadrature(p, egg),
        ),
        Lamp::area("sphere", "Translate -.7 .2 1.2\nShape \"sphere\" \"float radius\" .3", false, move |p| {
            PI * 0.09 * ball(p)
        }),
        Lamp::area(
            "disk",
            "Translate .5 .3 0\nReverseOrientation\nShape \"disk\" \"float radius\" .4 \"float height\" 1.1",
            false,
            plate,
        ),
        Lamp::area(
            "two-sided rectangle",
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
             \"point3 P\" [-.2 -.6 1.1  .5 -.6 1.1  .5 -.2 1.1  -.2 -.2 1.1]",
            true,
            move |p| polygon(&tile, p),
        ),
        Lamp::area(
            "two-sided cut sphere",
            "Translate -.2 .1 1.2\nShape \"sphere\" \"float radius\" .3 \"float zmax\" .06 \"float phimax\" 200",
            true,
            move |p| quadrature(p, bowl),
        ),
        Lamp::area(
            "two-sided cut disk",
            "Translate .4 .1 1.1\nShape \"disk\" \"float radius\" .5 \"float innerradius\" .2 \"float phimax\" 250",
            true,
            move |p| quadrature(p, fan),
        ),
    ]
}

/// Lambert's formula: the irradiance from a polygon of radiance 1.
fn polygon(corners: &[DVec3], p: DVec3) -> f64 {
    let directions: Vec<DVec3> = corners.iter().map(|corner| (*corner - p).normalize()).collect();
    let edges = directions.iter().zip(directions.iter().cycle().skip(1));
    0.5 * edges.map(|(a, b)| a.angle_between(*b) * a.cross(*b).normalize().z).sum::<f64>().abs()
}

/// Irradiance from a shape of radiance 1: the part that it fills of the unit disk, onto
/// which the directions are projected.
fn quadrature(p: DVec3, hits: impl Fn(DVec3, DVec3) -> bool) -> f64 {
    const STEPS: u32 = 150;
    let place = |i: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(STEPS) - 1.0;
    let cells = (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (place(i), place(j))));
    let filled = cells.filter(|(x, y)| {
        let z2 = 1.0 - x * x - y * y;
        z2 > 0.0 && hits(p, DVec3::new(*x, *y, z2.sqrt()))
    });
    filled.count() as f64 * (2.0 / f64::from(STEPS)).powi(2)
}

fn unit_sphere_hits(o: DVec3, d: DVec3) -> Option<[f64; 2]> {
    let [a, b, c] = [d.length_squared(), o.dot(d), o.length_squared() - 1.0];
    let root = (b * b - a * c).sqrt();
    (root >= 0.0).then(|| [(-b - root) / a, (-b + root) / a])
}

/// A floor from -1.2 to 1.2, seen from above, has the radiance that the irradiance makes.
pub fn assert_lights_floor(name: &str, lights: &str, radius: f64, irradiance: &dyn Fn(DVec3) -> f64) {
    const PIXELS: u32 = 16;
    const ALBEDO: f64 = 0.5;
    let floor = format!("{lights}\nMaterial \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n{}\n", square(1.5, 0.0));
    let look = camera("0 0 .6  0 0 0  0 1 0", 2.0 * 2_f64.atan().to_degrees());
    // Screen right is -x. Irradiance curves: a pixel is the mean of four points.
    let place = |i: u32, half: f64| 1.2 * (1.0 - 2.0 * (f64::from(i) + half) / f64::from(PIXELS));
    let radiance = |i: u32| {
        let quarters =
            [0.211, 0.789].map(|x| [0.211, 0.789].map(|y| DVec3::new(place(i % PIXELS, x), place(i / PIXELS, y), 0.0)));
        quarters.as_flattened().iter().map(|p| irradiance(*p)).sum::<f64>() / 4.0 * ALBEDO / PI
    };
    let pixels = (0..PIXELS * PIXELS).map(|i| [radiance(i) as f32; 3]).collect();
    let expected = Image::from_pixels(PIXELS, PIXELS, pixels).expect("an image");

    // Under a dome that refracts next to nothing, lights are out of reach of the eye.
    let dome = format!("{floor}Material \"dielectric\" \"float eta\" 1.0001\nScale 2 2 .8\nShape \"sphere\"");
    let by_eye = Shot { resolution: [PIXELS; 2], iterations: 8, ..EYE_ONLY };
    // Two iterations of four visible points a pixel: images of twice the size, of which four pixels are one.
    let by_photons = Shot {
        resolution: [2 * PIXELS; 2],
        photons: 524_288,
        iterations: 2,
        radius,
        alpha: 1.0,
        depth: 10,
        eye_paths: 1,
    };
    // By eye, a pixel is the mean of n = 64 * 8 paths. If the standard deviation of a path were its
    // mean, relMSE would be 1 / n = 0.002, and the energy of 256 such pixels would be off by
    // 1 / sqrt(256 n) = 0.0028. The bounds are the first and less than twice the second; a lamp that is seen
    // whole has less noise, and Sobol points have less again.
    //
    // By photons, at least a tenth of a million photons meet the floor of 9 square units: 132 on a disc of
    // radius 0.06. The eight discs of a pixel cover twice that or more, so that relMSE is 1 / 264 = 0.004. The
    // energy has the noise of 100,000 photons, 0.003, and of 8 visible points a pixel, 2048 in all: at the rim of
    // the spot, which is a third of the image, radiance varies within pixels by half of the image's mean, which
    // makes 0.5 * sqrt(1 / 3 / 2048) = 0.006.
    for (how, shot, world, max_energy, max_relmse) in
        [("eye", by_eye, floor, 0.005, 0.002), ("photons", by_photons, dome, 0.01, 0.004)]
    {
        let image = support::variants::boxed(&shot.take(&look, &world).image, shot.resolution[0] / PIXELS);
        let comparison = compare(&image, &expected).expect("images of one size");
        println!("{name} by {how}: {:.4}, relMSE {:.5}", comparison.energy_ratio, comparison.relmse);
        let gates = Gates { max_relmse: Some(max_relmse), max_energy: Some(max_energy) };
        assert!(comparison.failures(&gates).is_empty(), "{name} by {how}: {comparison:#?}");
    }
}

#[test]
fn every_light_has_its_closed_form_by_eye_and_by_photons() {
    for lamp in lamps() {
        assert_lights_floor(lamp.name, &lamp.text, 0.06, &lamp.irradiance);
    }
}

#[test]
fn lights_from_infinity_have_their_closed_form_by_eye_and_by_photons() {
    let sky = "LightSource \"infinite\" \"rgb L\" [2 2 2]\n";
    let sun = "LightSource \"distant\" \"point3 from\" [1 .5 2] \"rgb L\" [3 3 3] \"point3 to\" [0 0 0]\n";
    let from_sun = 3.0 * 2.0 / (1.0 + 0.25 + 4.0_f64).sqrt();
    assert_lights_floor("infinite", sky, 0.25, &|_| 2.0 * PI);
    assert_lights_floor("distant", sun, 0.25, &|_| from_sun);
    assert_lights_floor("both", &format!("{sky}{sun}{sky}"), 0.25, &|_| 4.0 * PI + from_sun);
}

#[test]
fn lights_add_up() {
    // Four that do not stand in each other's light.
    let lamps = &lamps()[..4];
    let text: String = lamps.iter().map(|lamp| lamp.text.clone() + "\n").collect();
    assert_lights_floor("all", &text, 0.06, &|p| lamps.iter().map(|lamp| (lamp.irradiance)(p)).sum());
}
