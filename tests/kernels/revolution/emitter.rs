//! Light from bodies of revolution: sampled by area, each piece a light of its own.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec2, DVec3};

use crate::fixture::{Fixture, double};
use crate::generated::{LightPoint, RevolutionPiece, SampleRevolutions, Sampled};
use crate::light::{Moments, estimate, grid_from, integrate, see};
use crate::revolution::profiles::{self, Profile};
use crate::statistics::assert_near;
use crate::world::{World, affine};

/// Samples per axis of the unit square, for each piece.
const GRID: usize = 64;

const TRANSFORMS: [&str; 4] = [
    "",
    "Translate 3 4 -5 Rotate 50 1 2 3 Scale 7 7 7",
    "Rotate 20 1 0 1 Scale 1 2 0.5 Rotate 30 0 1 0",
    "Scale -0.3 0.3 2",
];

fn bodies() -> Vec<Profile> {
    let mut bodies = Vec::from(profiles::reference());
    let shapes = ["cone", "can", "wave", "cusp", "repeated points", "torus"];
    bodies.extend(profiles::special().into_iter().filter(|profile| shapes.contains(&profile.name.as_str())));
    bodies
}

fn world(profile: &Profile, transform: &str) -> World {
    World::parse(&profile.scene(&format!("{transform}\nAreaLightSource \"diffuse\" \"rgb L\" [1 2 3]"))).0
}

/// A point of a piece in render space, and its area by x and azimuth.
fn element(piece: &RevolutionPiece, render_from_unit: &DAffine3, x: f64, azimuth: f64) -> (DVec3, DVec3) {
    let (mut point, mut slope) = (DVec2::ZERO, DVec2::ZERO);
    for i in (0..9).rev() {
        let pair = piece.coefficients[i / 2].map(f64::from);
        slope = slope * x + point;
        point = point * x + DVec2::new(pair[2 * (i % 2)], pair[2 * (i % 2) + 1]);
    }
    let out = DVec2::from_angle(azimuth);
    let along = render_from_unit.transform_vector3((slope.x * out).extend(slope.y));
    let around = render_from_unit.transform_vector3((point.x * out.perp()).extend(0.0));
    (render_from_unit.transform_point3((point.x * out).extend(point.y)), around.cross(along))
}

/// Area, first moments, and a second one, of a density over points.
#[derive(Clone, Copy, Debug, Default)]
struct Areas {
    area: f64,
    first: DVec3,
    second: f64,
}

impl Areas {
    fn add(&mut self, p: DVec3, area: f64) {
        self.area += area;
        self.first += area * p;
        self.second += area * p.dot(DVec3::new(0.48, 0.6, 0.64)).powi(2);
    }

    fn assert_are(&self, exact: &Self, tolerance: f64, what: &str) {
        let errors = [self.area - exact.area, (self.first - exact.first).length(), self.second - exact.second];
        let worst = errors.map(|error| error.abs() / exact.area).into_iter().fold(0.0, f64::max);
        assert!(worst <= tolerance, "{what}: {self:?} is not {exact:?}, off by {worst:e}");
    }

    fn of(piece: &RevolutionPiece, render_from_unit: &DAffine3) -> Self {
        const ALONG: usize = 128;
        const AROUND: usize = 48;
        let mut areas = Self::default();
        for i in 0..ALONG * AROUND {
            let (x, azimuth) = ((i % ALONG) as f64 + 0.5, (i / ALONG) as f64 + 0.5);
            let (p, area) =
                element(piece, render_from_unit, 2.0 * x / ALONG as f64 - 1.0, TAU * azimuth / AROUND as f64);
            areas.add(p, area.length() * 2.0 * TAU / (ALONG * AROUND) as f64);
        }
        areas
    }
}

/// An even grid of samples of every light.
fn sample(fixture: &Fixture, world: &World) -> Vec<Vec<Sampled>> {
    let middle = |i: usize| (i as f32 + 0.5) / GRID as f32;
    let grid: Vec<[f32; 2]> = (0..GRID * GRID).map(|i| [middle(i % GRID), middle(i / GRID)]).collect();
    sample_at(fixture, world, &grid)
}

/// Samples of every light by these numbers.
fn sample_at(fixture: &Fixture, world: &World, numbers: &[[f32; 2]]) -> Vec<Vec<Sampled>> {
    let lights = lit_pieces(world);
    let mut points = Vec::new();
    for (light, _) in &lights {
        points.extend(numbers.iter().map(|u| LightPoint { u: *u, light: *light, pad0: 0.0 }));
    }
    let uploaded = world.upload(fixture);
    let (points, sampled) = (fixture.upload(&points), fixture.output(points.len()));
    let kernel = SampleRevolutions { scene: uploaded.bindings(), points: &points, sampled: &sampled };
    fixture.run(&kernel, points.len() as usize);
    fixture.read(&sampled).chunks_exact(numbers.len()).map(<[Sampled]>::to_vec).collect()
}

/// Pieces that are lights.
fn lit_pieces(world: &World) -> Vec<(u32, RevolutionPiece)> {
    let lit = world.revolution_pieces.iter().filter(|piece| piece.light != crate::generated::NONE);
    lit.map(|piece| (piece.light, *piece)).collect()
}

/// The mean of 1 / pdf is the area, wherever points are; even grids converge with their
/// square, but for pieces whose profile stands still at an end.
#[test]
fn pieces_are_sampled_by_area() {
    let fixture = Fixture::new();
    for (profile, transform) in bodies().iter().flat_map(|body| TRANSFORMS.map(|transform| (body, transform))) {
        let world = world(profile, transform);
        let render_from_unit = affine(world.revolutions[0].render_from_unit);
        for ((light, piece), sampled) in lit_pieces(&world).iter().zip(sample(&fixture, &world)) {
            let mut areas = Areas::default();
            for sampled in &sampled {
                assert!(sampled.area_pdf > 0.0, "{}: {sampled:?}", profile.name);
                areas.add(double(sampled.position), 1.0 / (f64::from(sampled.area_pdf) * (GRID * GRID) as f64));
            }
            let what = format!("{} after {transform:?}, {piece:?}", profile.name);
            let exact = Areas::of(piece, &render_from_unit);
            areas.assert_are(&exact, 5e-4, &what);
            assert_near(world.lights[*light as usize].area.into(), exact.area, 2e-3, &what);
        }
    }
}

/// The least and the largest numbers there are give points next to the axis: of a photon's
/// power, divided by a pdf, nothing may be lost.
#[test]
fn points_next_to_the_axis_have_a_pdf() {
    const STEP: f32 = 0.5 * f32::EPSILON;
    let fixture = Fixture::new();
    for profile in bodies() {
        let world = world(&profile, TRANSFORMS[2]);
        for sampled in sample_at(&fixture, &world, &[[0.0, 0.3], [STEP, 0.3], [1.0 - STEP, 0.3]]).iter().flatten() {
            assert!(double(sampled.position).is_finite(), "{}: {sampled:?}", profile.name);
            let area = 1.0 / sampled.area_pdf;
            assert!(area.is_finite() && area >= 0.0, "{}: {sampled:?}", profile.name);
        }
    }
}

/// Multiple importance sampling asks for the pdf of points that other rays find.
#[test]
fn the_area_pdf_of_a_hit_is_that_of_its_sample() {
    let fixture = Fixture::new();
    for profile in bodies() {
        let world = world(&profile, TRANSFORMS[2]);
        let (mut seen, mut unlike) = (0, 0);
        for sampled in sample(&fixture, &world).iter().flatten() {
            seen += 1;
            unlike += usize::from((sampled.pdf_of_hit - sampled.area_pdf).abs() > 1e-2 * sampled.area_pdf);
        }
        // Points next to the end of a piece belong to its neighbour for the ray.
        assert!(unlike * 50 < seen, "{}: {unlike} of {seen} points have another pdf when they are hit", profile.name);
    }
}

/// Lights' areas in closed form: similarities scale them, a stretch along the axis does so
/// with a cylinder and with the slant of a cone.
#[test]
fn areas_are_those_of_cylinders_and_cones() {
    let cylinder = Profile::new("cylinder", 1, &[[0.5, -1.0], [0.5, 1.0]]);
    let cone = Profile::new("cone", 1, &[[0.8, 0.0], [0.0, 1.5]]);
    let slant = |stretch: f64| PI * 0.8 * (0.8 * 0.8 + (1.5 * stretch).powi(2)).sqrt();
    let cases = [
        (&cylinder, "", TAU),
        (&cylinder, "Translate 1 2 3 Rotate 40 1 1 0 Scale 3 3 3", 9.0 * TAU),
        (&cylinder, "Scale 1 1 0.25", 0.25 * TAU),
        (&cone, "", slant(1.0)),
        (&cone, "Scale 0.01 0.01 0.01", 1e-4 * slant(1.0)),
        (&cone, "Rotate 10 1 2 3 Scale 1 1 3", slant(3.0)),
    ];
    for (profile, transform, area) in cases {
        let text = profile.scene(&format!("{transform}\nAreaLightSource \"diffuse\" \"rgb L\" [1 2 3]"));
        let (world, packed) = World::parse(&text);
        let lights = lit_pieces(&world);
        let sum: f64 = lights.iter().map(|(light, _)| f64::from(world.lights[*light as usize].area)).sum();
        assert_near(sum / packed.space.scale.powi(2), area, 1e-5, &format!("{} after {transform:?}", profile.name));
    }
}

/// A sphere of four cubic arcs is one to 3e-4 of its radius.
#[test]
fn the_area_of_a_sphere_is_nearly_that() {
    let k = 0.552_284_749_830_793_4;
    let sphere = [[0.0, -1.0], [k, -1.0], [1.0, -k], [1.0, 0.0], [1.0, k], [k, 1.0], [0.0, 1.0]];
    let world = world(&Profile::new("sphere", 3, &sphere), "Scale 5 5 5");
    let sum: f64 = lit_pieces(&world).iter().map(|(light, _)| f64::from(world.lights[*light as usize].area)).sum();
    let radius = affine(world.revolutions[0].render_from_unit).matrix3.x_axis.length();
    assert_near(sum, 4.0 * PI * radius * radius, 1e-3, "a sphere");
}

/// Next-event estimation: the solid angles of all pieces, near and far sides alike.
#[test]
fn a_body_is_sampled_over_the_solid_angle_it_fills() {
    for (profile, transform) in profiles::reference().iter().zip(&TRANSFORMS[1..]) {
        let mut world = world(profile, transform);
        world.lights.iter_mut().for_each(|light| light.direct_pmf = 1.0);
        let render_from_unit = affine(world.revolutions[0].render_from_unit);
        let from = DVec3::new(0.9, -0.8, 1.1);
        let (light, piece) = lit_pieces(&world).swap_remove(3);
        let seen: Moments = estimate(&see(&world, &grid_from(from, light)));
        let exact = integrate(from, false, |u, v| {
            let (p, area) = element(&piece, &render_from_unit, 2.0 * u - 1.0, TAU * v);
            (p, 2.0 * TAU * area)
        });
        seen.assert_are(&exact, 5e-4, &profile.name);
    }
}
