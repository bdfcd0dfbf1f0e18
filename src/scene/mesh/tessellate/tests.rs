use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::geometry::bezier::MAX_DEGREE;

fn profile(degree: usize, points: &[(f64, f64)]) -> Profile {
    let points: Vec<DVec2> = points.iter().copied().map(DVec2::from).collect();
    assert_eq!((points.len() - 1) % degree, 0);
    let segment = |first: usize| Curve { points: points[first..=first + degree].to_vec() };
    Profile { segments: (0..points.len() - 1).step_by(degree).map(segment).collect() }
}

/// Returns a circle of four cubics around the given radius, or the outer half of one around the axis.
fn round(middle: f64, radius: f64, height: f64) -> Profile {
    let k = radius * 0.552_284_75;
    let (outer, inner) = (middle + radius, middle - radius);
    let mut points = vec![(middle, -radius), (middle + k, -radius), (outer, -k), (outer, 0.0)];
    points.extend([(outer, k), (middle + k, radius), (middle, radius)]);
    if middle > 0.0 {
        points.extend([(middle - k, radius), (inner, k), (inner, 0.0)]);
        points.extend([(inner, -k), (middle - k, -radius), (middle, -radius)]);
    }
    points.iter_mut().for_each(|point| point.1 += height);
    profile(3, &points)
}

/// Returns profiles that are each difficult in one way.
fn cases() -> Vec<(&'static str, Profile)> {
    let high = [(0.2, 0.0), (0.9, -0.3), (0.1, 0.6), (1.2, 0.2), (0.4, 1.0), (0.8, 1.4), (0.0, 1.1), (0.6, 1.5)];
    let mut cases = vec![
        ("cylinder", profile(1, &[(1.0, 0.0), (1.0, 2.0)])),
        ("cone", profile(1, &[(1.0, 0.0), (0.0, 2.0)])),
        ("disk", profile(1, &[(1.0, 3.0), (0.0, 3.0)])),
        ("tower", profile(1, &[(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.0, 3.0)])),
        ("hourglass", profile(1, &[(1.0, -1.0), (0.0, 0.0), (1.0, 1.0)])),
        ("partly on the axis", profile(1, &[(0.0, -1.0), (0.0, 0.0), (1.0, 1.0), (0.0, 2.0), (0.0, 3.0)])),
        ("parabola", profile(2, &[(0.0, 0.0), (0.0, 1.0), (1.0, 1.0)])),
        ("out and back", profile(2, &[(1.0, 0.0), (2.0, 0.0), (1.0, 0.0)])),
        ("needle", profile(2, &[(0.0, 0.0), (1e-6, 0.5), (0.0, 1.0)])),
        ("wire", round(100.0, 1e-3, 0.0)),
        ("ball", round(0.0, 1.0, 0.0)),
        ("far ball", round(0.0, 1.0, 1e9)),
        ("torus", round(1.0, 0.5, 0.0)),
        ("cusp", profile(3, &[(0.5, 0.0), (1.5, 1.0), (0.5, 1.0), (1.5, 0.0)])),
        ("repeated at the ends", profile(3, &[(0.0, 0.0), (0.0, 0.0), (1.0, 1.0), (1.0, 1.0)])),
        ("repeated inside", profile(4, &[(0.5, 0.0), (1.0, 1.0), (1.0, 1.0), (1.0, 1.0), (0.5, 2.0)])),
        ("repeated joint", profile(2, &[(1.0, 0.0), (1.0, 1.0), (1.0, 1.0), (1.0, 1.0), (2.0, 1.0)])),
    ];
    for degree in 4..=MAX_DEGREE {
        let points: Vec<_> = high.iter().copied().chain([(0.3, 2.0)]).take(degree + 1).collect();
        cases.push(("high degree", profile(degree, &points)));
    }
    cases
}

fn sample(profile: &Profile, per_segment: usize) -> Vec<DVec2> {
    let at = |i: usize| i as f64 / per_segment as f64;
    profile.segments.iter().flat_map(|segment| (0..=per_segment).map(move |i| segment.at(at(i)))).collect()
}

fn size(samples: &[DVec2]) -> f64 {
    let least = samples.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let most = samples.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    (2.0 * most.x).max(most.y - least.y)
}

fn distance_to_segment(point: DVec2, a: DVec2, b: DVec2) -> f64 {
    let t = ((point - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    (point - a - (b - a) * if t.is_nan() { 0.0 } else { t }).length()
}

/// Returns the distance from a point to the true surface, represented by samples.
fn distance_to_surface(point: DVec3, samples: &[DVec2]) -> f64 {
    let point = DVec2::new(point.truncate().length(), point.z);
    samples.windows(2).map(|pair| distance_to_segment(point, pair[0], pair[1])).fold(f64::INFINITY, f64::min)
}

fn distance_to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside = |from: DVec3, to: DVec3| normal.dot((to - from).cross(point - from)) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) {
        return (point - a).dot(normal).abs() / normal.length();
    }
    let to_edge = |from: DVec3, to: DVec3| {
        let edge = to - from;
        let t = ((point - from).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        (point - from - edge * t).length()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

/// Returns the corners of every triangle.
fn corners(mesh: &Tessellation) -> Vec<[Vertex; 3]> {
    let vertices: Vec<Vertex> = mesh.vertices().collect();
    assert_eq!(vertices.len() as u64, mesh.vertex_count());
    let triangles: Vec<_> = mesh.triangles().map(|indices| indices.map(|index| vertices[index as usize])).collect();
    assert_eq!(triangles.len() as u64, mesh.triangle_count());
    assert!(!triangles.is_empty());
    triangles
}

/// Checks the tolerance in both directions, at points that `random` chooses from [0, 1).
fn assert_within(name: &str, profile: &Profile, tolerance: f64, points: u32, mut random: impl FnMut() -> f64) {
    let samples = sample(profile, 4000);
    let limit = tolerance * size(&samples) * (1.0 + 1e-6) + 1e-15 * samples[0].length();
    let mesh = Tessellation::new(profile, tolerance, false).unwrap();
    let triangles: Vec<[DVec3; 3]> = corners(&mesh).iter().map(|corners| corners.map(|v| v.position)).collect();
    for _ in 0..points {
        let on_profile = samples[(random() * samples.len() as f64) as usize];
        let point = (DVec2::from_angle(TAU * random()) * on_profile.x).extend(on_profile.y);
        // A stretch on the axis is no surface, up to the point where the profile leaves it or ends.
        let along_axis = |pair: &[DVec2]| pair.iter().all(|point| point.x == 0.0) && pair.contains(&on_profile);
        let on_axis = samples.windows(2).any(along_axis);
        let distance = triangles.iter().map(|t| distance_to_triangle(point, *t)).fold(f64::INFINITY, f64::min);
        assert!(distance <= limit || on_axis, "{name} at {tolerance}: {point} is {distance} from the mesh");

        let [a, b, c] = triangles[(random() * triangles.len() as f64) as usize];
        let (s, t) = (random(), random());
        let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
        let point = a + (b - a) * s + (c - a) * t;
        let distance = distance_to_surface(point, &samples);
        assert!(distance <= limit, "{name} at {tolerance}: {point} is {distance} from the surface");
    }
}

/// Returns a generator of pseudorandom numbers in [0, 1).
fn sequence() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[test]
fn meshes_keep_the_tolerance_both_ways() {
    for (name, profile) in cases() {
        for tolerance in [0.1, 1e-2, 1e-3] {
            assert_within(name, &profile, tolerance, 300, sequence());
        }
    }
}

#[test]
fn triangles_have_areas_and_face_as_their_normals() {
    for (name, profile) in cases() {
        for inside_out in [false, true] {
            for triangle in corners(&Tessellation::new(&profile, 3e-3, inside_out).unwrap()) {
                let [a, b, c] = triangle.map(|vertex| vertex.position);
                let normal = (b - a).cross(c - a).normalize_or_zero();
                assert_ne!(normal, DVec3::ZERO, "{name}: {a} {b} {c} is degenerate");
                for vertex in triangle {
                    assert!((vertex.normal.length() - 1.0).abs() < 1e-9, "{name}: {vertex:?}");
                    assert!(vertex.normal.dot(normal) > -1e-3, "{name}: {vertex:?} at a triangle that faces {normal}");
                }
                assert!(triangle.iter().map(|v| v.normal).sum::<DVec3>().dot(normal) > 0.1, "{name}: {normal}");
            }
        }
    }
}

#[test]
fn vertices_are_on_the_surface_with_its_normal() {
    for (name, profile) in cases() {
        let count = profile.segments.len() as f64;
        for vertex in Tessellation::new(&profile, 3e-3, false).unwrap().vertices() {
            let (along, azimuth) = (vertex.uv.y * count, DVec2::from_angle(TAU * vertex.uv.x));
            // A joint is the end of one segment and the start of the next.
            let matches = [along.ceil() - 1.0, along.floor()].iter().any(|segment| {
                let (t, segment) = (along - segment, segment.clamp(0.0, count - 1.0) as usize);
                let segment = &profile.segments[segment];
                let point = segment.at(t);
                let way = match &segment.hodograph()[..] {
                    [only] => *only,
                    more => Curve { points: more.to_vec() }.at(t),
                };
                let normal = (azimuth * way.y).extend(-way.x).normalize_or_zero();
                let there = ((azimuth * point.x).extend(point.y) - vertex.position).length();
                // A derivative of 0 has no direction.
                there < 1e-9 * (1.0 + point.y.abs()) && (way.length() < 1e-6 || normal.dot(vertex.normal) > 1.0 - 1e-6)
            });
            assert!(matches, "{name}: {vertex:?}");
        }
    }
}

#[test]
fn closed_bodies_are_watertight() {
    for (name, profile) in cases() {
        if !["tower", "ball", "far ball", "torus", "wire", "needle", "out and back"].contains(&name) {
            continue;
        }
        let mut edges = HashMap::new();
        for triangle in corners(&Tessellation::new(&profile, 1e-2, false).unwrap()) {
            let bits = triangle.map(|vertex| vertex.position.to_array().map(|x| (x + 0.0).to_bits()));
            for i in 0..3 {
                let (from, to) = (bits[i], bits[(i + 1) % 3]);
                *edges.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|sum| *sum == 0), "{name} has an edge with a single side");
    }
}

#[test]
fn creases_are_kept_and_smooth_joints_shared() {
    let rings = |profile: &Profile| -> Vec<usize> {
        Tessellation::new(profile, 0.01, false).unwrap().strips.iter().map(Vec::len).collect()
    };
    assert_eq!(rings(&profile(1, &[(1.0, 0.0), (1.0, 1.0), (2.0, 1.0)])), [2, 2]);
    assert_eq!(rings(&profile(1, &[(1.0, 0.0), (1.0, 1.0), (1.0, 3.0)])), [3]);
    assert_eq!(rings(&profile(1, &[(0.0, -1.0), (0.0, 0.0), (1.0, 1.0)])), [2]);
    assert_eq!(rings(&round(0.0, 1.0, 0.0)).len(), 1);
    assert_eq!(rings(&round(1.0, 0.5, 0.0)).len(), 1);
    // At the cusp the profile turns back, with the axis' direction on either side.
    let cusp = Tessellation::new(&profile(3, &[(0.5, 0.0), (1.5, 1.0), (0.5, 1.0), (1.5, 0.0)]), 0.01, false).unwrap();
    let [before, after] = &cusp.strips[..] else { panic!("{cusp:?}") };
    let (before, after) = (before[before.len() - 1], after[0]);
    assert_eq!(before.radius, after.radius);
    assert!((before.normal - DVec2::X).length() < 1e-6, "{before:?}");
    assert!((after.normal + DVec2::X).length() < 1e-6, "{after:?}");
    // Three points in one place: the tangent is towards the fourth.
    let blunt = profile(3, &[(0.5, 0.0), (0.5, 0.0), (0.5, 0.0), (1.5, 1.0)]);
    let ring = Tessellation::new(&blunt, 0.01, false).unwrap().strips[0][0];
    assert!((ring.normal - DVec2::new(1.0, -1.0).normalize()).length() < 1e-6, "{ring:?}");
}

#[test]
fn cusps_are_creases_wherever_they_are() {
    for i in 1..100 {
        // The derivative is (t - cusp) (3, 6 - 9 t), which rounding may keep from vanishing.
        let cusp = f64::from(i) / 100.0;
        let hodograph =
            [(-3.0 * cusp, -6.0 * cusp), (1.5 - 3.0 * cusp, 3.0 - 1.5 * cusp), (3.0 - 3.0 * cusp, 3.0 * cusp - 3.0)];
        let mut points = vec![(2.0, 0.0)];
        for (i, (u, v)) in hodograph.into_iter().enumerate() {
            points.push((points[i].0 + u / 3.0, points[i].1 + v / 3.0));
        }
        let mesh = Tessellation::new(&profile(3, &points), 0.01, false).unwrap();
        let [before, after] = &mesh.strips[..] else { panic!("{cusp}: {mesh:?}") };
        let (before, after) = (before[before.len() - 1], after[0]);
        assert!((before.along - cusp).abs() < 1e-6, "{cusp}: {before:?}");
        let normal = DVec2::new(9.0 * cusp - 6.0, 3.0).normalize();
        assert!((before.normal - normal).length() < 1e-5, "{cusp}: {before:?} instead of {normal}");
        assert!((after.normal + normal).length() < 1e-5, "{cusp}: {after:?} instead of {}", -normal);
    }
}

#[test]
fn normals_turn_little_from_ring_to_ring() {
    for (name, profile) in cases() {
        for strip in Tessellation::new(&profile, 0.1, false).unwrap().strips {
            for pair in strip.windows(2) {
                assert!(pair[0].normal.dot(pair[1].normal) > MOST_TURN - 1e-3, "{name}: {pair:?}");
            }
        }
    }
}

#[test]
fn a_cylinder_has_the_fewest_corners_that_will_do() {
    let tolerance = 1e-3;
    let mesh = Tessellation::new(&profile(1, &[(1.0, 0.0), (1.0, 2.0)]), tolerance, false).unwrap();
    let sagitta = |corners: u32| 1.0 - (PI / f64::from(corners)).cos();
    assert!(sagitta(mesh.sectors) <= tolerance && sagitta(mesh.sectors - 1) > tolerance, "{}", mesh.sectors);
    assert_eq!(
        (mesh.triangle_count(), mesh.vertex_count()),
        (2 * u64::from(mesh.sectors), 2 * u64::from(mesh.sectors) + 2)
    );
}

#[test]
fn a_mesh_that_is_too_large_is_refused_with_a_tolerance_that_fits() {
    let waves: Vec<(f64, f64)> = (0..=900).map(|i| (if i % 3 == 1 { 3.0 } else { 1.0 }, f64::from(i) / 50.0)).collect();
    let waves = profile(3, &waves);
    let error = Tessellation::new(&waves, 1e-7, false).unwrap_err();
    assert!(error.triangles > MAX_TRIANGLES);
    let fitting: f64 = error.fitting.clone().unwrap().parse().unwrap();
    assert!(error.to_string().ends_with(&format!(", as a tolerance of {} gives", error.fitting.unwrap())));
    assert!(Tessellation::new(&waves, fitting, false).unwrap().triangle_count() > MAX_TRIANGLES / 10);
}

#[test]
fn senseless_tolerances_are_taken_to_the_nearest_that_makes_sense() {
    let wall = profile(1, &[(1.0, 0.0), (1.0, 2.0)]);
    let count = |tolerance| Tessellation::new(&wall, tolerance, false).unwrap().triangle_count();
    for (tolerance, taken_as) in [(0.0, 1e-7), (-1.0, 1e-7), (f64::NAN, 1e-7), (f64::INFINITY, 0.1)] {
        assert_eq!(count(tolerance), count(taken_as), "{tolerance}");
    }
}

fn profiles() -> impl Strategy<Value = Profile> {
    // Some points are on the axis, or at the place of another point.
    let coordinate = || prop_oneof![3 => 0.0..1.0, 1 => Just(0.0), 1 => Just(0.5)];
    (1..=MAX_DEGREE, 1..=3_usize).prop_flat_map(move |(degree, segments)| {
        prop::collection::vec((coordinate(), coordinate()), degree * segments + 1)
            .prop_filter("no surface", |points| points.iter().any(|point| point.0 > 0.0))
            .prop_map(move |points| profile(degree, &points))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_profile_keeps_the_tolerance(
        profile in profiles(),
        power in 1.0..3.0_f64,
        random in prop::collection::vec(0.0..1.0, 97),
    ) {
        let at_random = || {
            let mut numbers = random.iter().copied().cycle();
            move || numbers.next().unwrap_or_default()
        };
        let points = sample(&profile, 8);
        prop_assume!(points.iter().any(|point| *point != points[0]) && points.iter().any(|point| point.x > 0.0));
        assert_within("random", &profile, 10_f64.powf(-power), 50, at_random());
    }
}
