//! emission.glsl: photons carry the power of the lights, from where and whither they shine.

use std::f64::consts::{PI, TAU};

use bytemuck::Zeroable;
use glam::{DAffine3, DMat3, DVec3};

use crate::fixture::{Fixture, Rng, double, frame};
use crate::generated::{
    AREA, AliasEntry, DISK, DISTANT, EmitPhotons, Emitted, INFINITE, InvertSmoothstep, KIND_SHIFT, Light, NONE, POINT,
    Quadric, SPHERE, SPOT, SceneArrays, SceneInfo, TRIANGLE, Triangle,
};
use crate::statistics::{assert_near, assert_quantiles, assert_uniform, cells};
use crate::world::{World, quadric, triangle};

const COUNT: usize = 1 << 18;

fn emit(world: &World) -> Vec<Emitted> {
    let fixture = Fixture::new();
    let world = world.upload(&fixture);
    let emitted = fixture.output(COUNT);
    let (guide_nodes, guide_lights) = (&fixture.output_texels(0), &fixture.output_texels(0));
    fixture.run(&EmitPhotons { scene: world.bindings(), guide_nodes, guide_lights, emitted: &emitted }, COUNT);
    fixture.read(&emitted)
}

const EMISSION: [f32; 3] = [1.0, 2.0, 3.0];
const CENTER: DVec3 = DVec3::new(0.01, -0.02, 0.03);
const HALF_EXTENT: DVec3 = DVec3::new(0.6, 0.3, 0.2);
/// Of a sphere around the box.
const RADIUS: f64 = 0.75;

/// One light, whose photons therefore have the weight of its power in units of 1 W.
fn lone(light: Light, world: World) -> World {
    let light = Light { emission: EMISSION, emission_pmf: 1.0, direct_pmf: 1.0, ..light };
    let table = vec![AliasEntry { threshold: 1.0, keep: 0, alias: 0, chance: 0.0 }];
    let info = SceneInfo {
        center: CENTER.as_vec3().to_array(),
        radius: RADIUS as f32,
        half_extent: HALF_EXTENT.as_vec3().to_array(),
        mean_power: 1.0,
        emission_count: 1,
        direct_count: 1,
        seed: 3,
        ..SceneInfo::zeroed()
    };
    let lights = vec![light];
    let arrays = SceneArrays { lights, emission_table: table.clone(), direct_table: table, ..world.arrays };
    World { info, arrays }
}

fn mean_weight(emitted: &[Emitted]) -> DVec3 {
    emitted.iter().map(|photon| double(photon.weight)).sum::<DVec3>() / emitted.len() as f64
}

fn assert_power(emitted: &[Emitted], unit_power: f64, tolerance: f64, what: &str) {
    let mean = mean_weight(emitted);
    for channel in 0..3 {
        assert_near(mean[channel], unit_power * f64::from(EMISSION[channel]), tolerance, what);
    }
}

fn azimuth(x: f64, y: f64) -> f64 {
    y.atan2(x).rem_euclid(TAU) / TAU
}

/// Directions uniform in the squared cosine to their normals, which is to be positive.
fn assert_cosine_lobe(pairs: impl Iterator<Item = (DVec3, DVec3)>, what: &str) {
    let quantiles = pairs.map(|(direction, normal)| {
        let (s, t) = frame(normal);
        let cos = direction.dot(normal);
        assert!(cos >= -1e-6, "{what}: {direction} is behind {normal}");
        [(cos * cos).min(1.0), azimuth(direction.dot(s), direction.dot(t))]
    });
    assert_uniform(&cells(quantiles, 32), what);
}

fn sphere_directions(emitted: &[Emitted]) -> Vec<u32> {
    let place = |w: DVec3| [0.5 * (w.z + 1.0), azimuth(w.x, w.y)];
    cells(emitted.iter().map(|photon| place(double(photon.direction))), 32)
}

#[test]
fn point_lights_shine_all_around() {
    let position = [0.3, 0.2, 0.1];
    let emitted = emit(&lone(Light { kind: POINT, position, ..Light::zeroed() }, World::default()));
    assert_power(&emitted, 4.0 * PI, 1e-6, "point light");
    assert!(emitted.iter().all(|photon| photon.origin == position));
    assert_uniform(&sphere_directions(&emitted), "directions of a point light");
}

/// Integral over the cosine of the smoothstep falloff, over 2 pi, from the axis to `cos`.
fn spot_share(cos: f64, cos_start: f64, cos_end: f64) -> f64 {
    if cos > cos_start {
        return 1.0 - cos;
    }
    let x = ((cos - cos_end) / (cos_start - cos_end)).max(0.0);
    // The integral of 3 x^2 - 2 x^3 from x to 1.
    let rim = 0.5 - (x.powi(3) - 0.5 * x.powi(4));
    1.0 - cos_start + (cos_start - cos_end) * rim
}

#[test]
fn spot_lights_shine_with_their_falloff() {
    let one_minus_cos = |angle: f64| (2.0 * (0.5 * angle.to_radians()).sin().powi(2)) as f32;
    // Wide, narrow, nearly without a rim, and all rim.
    for (start, end) in [(25.0, 40.0), (1.0, 2.0), (29.9, 30.0), (0.0, 80.0), (60.0, 60.0)] {
        let direction = DVec3::new(0.48, -0.6, 0.64);
        let light = Light {
            kind: SPOT,
            position: [0.3, 0.2, 0.1],
            direction: direction.as_vec3().to_array(),
            falloff_start: one_minus_cos(start),
            falloff_end: one_minus_cos(end),
            ..Light::zeroed()
        };
        let (cos_start, cos_end) = (1.0 - f64::from(light.falloff_start), 1.0 - f64::from(light.falloff_end));
        let whole = spot_share(cos_end, cos_start, cos_end);
        let emitted = emit(&lone(light, World::default()));
        let what = format!("spot light of {start} to {end} degrees");
        assert_power(&emitted, TAU * whole, 1e-5, &what);
        let (s, t) = frame(direction);
        let mut quantiles = Vec::new();
        let mut azimuths = Vec::new();
        for photon in &emitted {
            let w = double(photon.direction);
            // The cosine from the sine, which has more digits near the axis.
            let cos = (1.0 - w.cross(direction).length_squared()).max(0.0).sqrt();
            assert!(w.dot(direction) > cos_end - 1e-6, "{what}: {w} is outside the cone");
            quantiles.push(spot_share(cos.max(cos_end), cos_start, cos_end) / whole);
            azimuths.push(azimuth(w.dot(s), w.dot(t)));
        }
        let joint = quantiles.iter().zip(&azimuths).map(|(a, b)| [*a, *b]);
        assert_uniform(&cells(joint, 32), &what);
        assert_quantiles(quantiles, &what);
    }
}

/// Solved to 1e-5; in value, the cumulative distribution is met to a few EPS.
#[test]
fn quantiles_of_smoothstep_are_right() {
    let mut rng = Rng(1);
    let mut uniforms: Vec<f32> = (0..500_000).map(|_| rng.unit_f32()).collect();
    uniforms.extend((0..1000).map(|_| rng.log_range(1e-30, 1.0) as f32));
    uniforms.extend([0.0, 1.0, 1.0 - f32::EPSILON, 1.0 - 0.5 * f32::EPSILON, 1e-7, f32::MIN_POSITIVE]);
    let fixture = Fixture::new();
    let world = World::default().upload(&fixture);
    let (inputs, quantiles) = (fixture.upload(&uniforms), fixture.output(uniforms.len()));
    let (guide_nodes, guide_lights) = (&fixture.output_texels(0), &fixture.output_texels(0));
    let scene = world.bindings();
    let kernel = InvertSmoothstep { scene, guide_nodes, guide_lights, uniforms: &inputs, quantiles: &quantiles };
    fixture.run(&kernel, uniforms.len());
    for (u, x) in uniforms.iter().zip(fixture.read(&quantiles)) {
        let (u, x) = (f64::from(*u), f64::from(x));
        // The exact quantile, by bisection.
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if middle.powi(3) * (2.0 - middle) < u { low = middle } else { high = middle }
        }
        let value = x.powi(3) * (2.0 - x);
        assert!((value - u).abs() <= 1e-6, "{u}: the distribution is {value} at {x}");
        assert!((x - low).abs() <= 1e-5 * low.max(0.1), "the quantile of {u} is {low}, not {x}");
    }
}

/// Areas of the faces of the bounding box across each axis.
fn faces() -> DVec3 {
    let e = HALF_EXTENT;
    4.0 * DVec3::new(e.y * e.z, e.z * e.x, e.x * e.y)
}

/// Photons of parallel light enter the scene's bounding box evenly through the faces that it shows
/// to `directions`, each with the power of what it shows.
fn assert_enters_box(emitted: &[Emitted], what: &str) {
    let mut places = [const { Vec::new() }; 3];
    let mut shown = DVec3::ZERO;
    for photon in emitted {
        let direction = double(photon.direction);
        let from = double(photon.origin) - CENTER;
        assert!((from.dot(direction) + RADIUS).abs() < 1e-6, "{what}: {photon:?} starts at the wrong height");
        // The last of the planes that it enters through.
        let entries = (-HALF_EXTENT.copysign(direction) - from) / direction;
        let axis = (0..3).max_by(|a, b| entries[*a].total_cmp(&entries[*b])).unwrap();
        let place = (from + entries[axis] * direction) / HALF_EXTENT;
        assert!(place.abs().max_element() < 1.0 + 1e-4, "{what}: {photon:?} misses the scene");
        places[axis].push([1, 2].map(|next| (0.5 + 0.5 * place[(axis + next) % 3]).clamp(0.0, 1.0)));
        shown += faces() * direction.abs() / faces().dot(direction.abs());
    }
    for (axis, places) in places.into_iter().enumerate() {
        assert_near(places.len() as f64, shown[axis], 0.01, what);
        assert_uniform(&cells(places, 16), what);
    }
}

#[test]
fn distant_lights_shine_through_the_scene() {
    let direction = [0.48, -0.6, 0.64];
    let emitted = emit(&lone(Light { kind: DISTANT, direction, ..Light::zeroed() }, World::default()));
    assert_power(&emitted, faces().dot(DVec3::new(0.48, 0.6, 0.64)), 1e-6, "distant light");
    assert!(emitted.iter().all(|photon| photon.direction == direction));
    assert_enters_box(&emitted, "places of a distant light");
}

/// Along an axis, one face is all that it meets.
#[test]
fn distant_lights_along_an_axis_shine_through_one_face() {
    for axis in 0..3 {
        let mut direction = [0.0; 3];
        direction[axis] = -1.0;
        let emitted = emit(&lone(Light { kind: DISTANT, direction, ..Light::zeroed() }, World::default()));
        assert_power(&emitted, faces()[axis], 1e-6, "distant light along an axis");
        let places = emitted.iter().map(|photon| {
            let place = (double(photon.origin) - CENTER) / HALF_EXTENT;
            [1, 2].map(|next| (0.5 + 0.5 * place[(axis + next) % 3]).clamp(0.0, 1.0))
        });
        assert_uniform(&cells(places, 32), "places of a distant light along an axis");
    }
}

#[test]
fn infinite_light_comes_from_all_around() {
    let emitted = emit(&lone(Light { kind: INFINITE, ..Light::zeroed() }, World::default()));
    // The mean of what a convex body shows is a quarter of its surface.
    assert_power(&emitted, 4.0 * PI * 0.5 * faces().element_sum(), 2e-4, "infinite light");
    assert_uniform(&sphere_directions(&emitted), "directions of infinite light");
    assert_enters_box(&emitted, "places of infinite light");
}

fn area_light(kind: u32, area: f64) -> Light {
    Light { kind: AREA, primitive: kind << KIND_SHIFT, area: area as f32, image: NONE, ..Light::zeroed() }
}

#[test]
fn triangles_emit_evenly_from_their_front() {
    let corners = [[0.1, 0.2, -0.3], [0.5, 0.1, -0.2], [0.2, 0.6, 0.1]];
    let [p0, p1, p2] = corners.map(double);
    let normal = (p1 - p0).cross(p2 - p0);
    let shape = Triangle { light: 0, ..triangle(corners) };
    let world = World::of(SceneArrays { triangles: vec![shape], ..SceneArrays::default() });
    let emitted = emit(&lone(area_light(TRIANGLE, 0.5 * normal.length()), world));
    assert_power(&emitted, PI * 0.5 * normal.length(), 1e-5, "triangle light");
    let place = |photon: &Emitted| {
        let from = double(photon.origin) - p0;
        assert!(from.dot(normal.normalize()).abs() < 1e-5, "{photon:?} starts beside the triangle");
        let b1 = from.cross(p2 - p0).dot(normal) / normal.length_squared();
        let b2 = (p1 - p0).cross(from).dot(normal) / normal.length_squared();
        [(b1 + b2).clamp(0.0, 1.0).powi(2), (b1 / (b1 + b2).max(1e-9)).clamp(0.0, 1.0)]
    };
    assert_uniform(&cells(emitted.iter().map(place), 32), "places on a triangle light");
    let normal = normal.normalize();
    let both = |photon: &Emitted| [place(photon)[0], double(photon.direction).dot(normal).powi(2)];
    assert_uniform(&cells(emitted.iter().map(both), 32), "places and directions together");
    assert_cosine_lobe(emitted.iter().map(|photon| (double(photon.direction), normal)), "directions of a triangle");
}

fn skewed() -> DAffine3 {
    let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0);
    let back = DMat3::from_axis_angle(DVec3::new(0.0, 0.6, 0.8), 2.0);
    let matrix = turn * DMat3::from_diagonal(DVec3::new(0.3, 0.1, 0.2)) * back;
    DAffine3 { matrix3: matrix, translation: DVec3::new(0.1, 0.2, 0.3) }
}

#[test]
fn disks_emit_evenly_from_what_their_cuts_leave() {
    let transform = skewed();
    let matrix = transform.matrix3;
    let normal = matrix.x_axis.cross(matrix.y_axis);
    for (inner_radius, phi_max, flipped) in [(0.0_f32, TAU as f32, 0), (0.5, 4.0, 1)] {
        let (inner2, phi_max64) = (f64::from(inner_radius).powi(2), f64::from(phi_max));
        let area = 0.5 * phi_max64 * (1.0 - inner2) * normal.length();
        let shape = Quadric { light: 0, inner_radius, phi_max, flipped, ..quadric(&transform) };
        let emitted = emit(&lone(
            area_light(DISK, area),
            World::of(SceneArrays { quadrics: vec![shape], ..SceneArrays::default() }),
        ));
        assert_power(&emitted, PI * area, 1e-5, "disk light");
        let inverse = transform.inverse();
        let places = emitted.iter().map(|photon| {
            let p = inverse.transform_point3(double(photon.origin));
            assert!(p.z.abs() < 1e-4, "{photon:?} starts beside the disk");
            let r2 = (p.truncate().length_squared() - inner2) / (1.0 - inner2);
            [r2.clamp(0.0, 1.0), azimuth(p.x, p.y) * TAU / phi_max64]
        });
        assert_uniform(&cells(places, 32), "places on a disk light");
        let normal = normal.normalize() * if flipped == 1 { -1.0 } else { 1.0 };
        assert_cosine_lobe(emitted.iter().map(|photon| (double(photon.direction), normal)), "directions of a disk");
    }
}

#[test]
fn two_sided_lights_emit_twice_the_power() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let shape = Triangle { light: 0, ..triangle(corners) };
    let light = Light { two_sided: 1, ..area_light(TRIANGLE, 0.5) };
    let emitted = emit(&lone(light, World::of(SceneArrays { triangles: vec![shape], ..SceneArrays::default() })));
    assert_power(&emitted, PI, 1e-5, "two-sided light");
    let up = emitted.iter().filter(|photon| photon.direction[2] > 0.0).count();
    assert!((up as f64 / COUNT as f64 - 0.5).abs() < 0.005, "{up} of {COUNT} go up");
    assert!(emitted.iter().all(|photon| photon.origin[2] * photon.direction[2] >= 0.0), "a photon starts behind");
    let side = |photon: &Emitted| (double(photon.direction).with_z(photon.direction[2].abs().into()), DVec3::Z);
    assert_cosine_lobe(emitted.iter().map(side), "directions of a two-sided light");
}

/// Points are uniform in object space; weights make up for how its area grows. Moments of
/// the emitted power over the surface check both.
#[test]
fn spheres_emit_by_area_whatever_their_transform() {
    let similarity = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.25),
        glam::DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0),
        DVec3::new(0.1, 0.2, 0.3),
    );
    for (transform, z, phi_max) in
        [(similarity, [-1.0_f32, 1.0], TAU as f32), (skewed(), [-1.0, 1.0], TAU as f32), (skewed(), [-0.5, 0.75], 4.0)]
    {
        let shape = Quadric { light: 0, z_min: z[0], z_max: z[1], phi_max, ..quadric(&transform) };
        let emitted = emit(&lone(
            area_light(SPHERE, 0.0),
            World::of(SceneArrays { quadrics: vec![shape], ..SceneArrays::default() }),
        ));
        let cofactors = transform.matrix3.determinant().abs() * transform.matrix3.inverse().transpose();
        let (area, exact) = area_moments(&transform, cofactors, z.map(f64::from), phi_max.into());
        assert_power(&emitted, PI * area, 2e-4, "sphere light");
        let inverse = transform.inverse();
        let mut moments = DVec3::ZERO;
        let mut places = Vec::new();
        let mut lobes = Vec::new();
        for photon in &emitted {
            let p = inverse.transform_point3(double(photon.origin));
            assert!((p.length() - 1.0).abs() < 1e-4, "{photon:?} starts beside the sphere");
            let height = (p.z - f64::from(z[0])) / f64::from(z[1] - z[0]);
            places.push([height.clamp(0.0, 1.0), azimuth(p.x, p.y) * TAU / f64::from(phi_max)]);
            lobes.push((double(photon.direction), (cofactors * p).normalize()));
            moments += f64::from(photon.weight[0]) / PI * p * p / COUNT as f64;
        }
        assert_uniform(&cells(places, 32), "places on a sphere light");
        assert_cosine_lobe(lobes.into_iter(), "directions of a sphere light");
        assert!((moments - exact).abs().max_element() < 3e-4 * area, "{moments} is not {exact}");
    }
}

/// The area of what is left of a transformed sphere, and the squares of object coordinates
/// over it.
fn area_moments(transform: &DAffine3, cofactors: DMat3, z: [f64; 2], phi_max: f64) -> (f64, DVec3) {
    const STEPS: usize = 500;
    assert!(transform.is_finite());
    let (mut area, mut squares) = (0.0, DVec3::ZERO);
    for i in 0..STEPS * STEPS {
        let middle = |i: usize| (i as f64 + 0.5) / STEPS as f64;
        let height = z[0] + (z[1] - z[0]) * middle(i % STEPS);
        let phi = phi_max * middle(i / STEPS);
        let r = (1.0 - height * height).sqrt();
        let p = DVec3::new(r * phi.cos(), r * phi.sin(), height);
        let share = (cofactors * p).length() * (z[1] - z[0]) * phi_max / (STEPS * STEPS) as f64;
        area += share;
        squares += share * p * p;
    }
    (area, squares)
}

const SCENE: &str = r#"
WorldBegin
LightSource "point" "rgb I" [1 2 3] "point3 from" [.5 .6 -.7]
LightSource "spot" "rgb I" [30 20 10] "point3 from" [-1 1 0] "point3 to" [0 0 0] "float coneangle" 40 "float conedeltaangle" 15
LightSource "distant" "rgb L" [2 2 1] "point3 from" [0 0 0] "point3 to" [1 -2 2]
LightSource "infinite" "rgb L" [.1 .2 .3]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [5 4 3] "bool twosided" true
Shape "disk" "float radius" .5 "float height" 1
AttributeEnd
AttributeBegin
AreaLightSource "diffuse" "rgb L" [.5 .4 3]
Scale 2 1 1
Shape "sphere" "float radius" .3
AttributeEnd
AttributeBegin
AreaLightSource "diffuse" "rgb L" [7 0 0]
Shape "trianglemesh" "point3 P" [0 0 2  1 0 2  0 1 2  1 1 2] "integer indices" [0 1 2 1 3 2]
AttributeEnd
"#;

/// The power of each light of SCENE per channel, by its formula, W; its bounding box has the half
/// extent `e`.
fn scene_power(e: DVec3) -> DVec3 {
    let rim = |inner: f64, outer: f64| 1.0 - 0.5 * (inner.to_radians().cos() + outer.to_radians().cos());
    let faces = 4.0 * DVec3::new(e.y * e.z, e.z * e.x, e.x * e.y);
    // A spheroid of semi-axes 0.6, 0.3, 0.3.
    let e = (1.0 - 0.25_f64).sqrt();
    let spheroid = TAU * 0.09 * (1.0 + 2.0 / e * e.asin());
    DVec3::new(1.0, 2.0, 3.0) * 4.0 * PI
        + DVec3::new(30.0, 20.0, 10.0) * TAU * rim(25.0, 40.0)
        + DVec3::new(2.0, 2.0, 1.0) * faces.dot(DVec3::new(1.0, 2.0, 2.0) / 3.0)
        + DVec3::new(0.1, 0.2, 0.3) * 4.0 * PI * 0.5 * faces.element_sum()
        + DVec3::new(5.0, 4.0, 3.0) * 2.0 * PI * PI * 0.25
        + DVec3::new(0.5, 0.4, 3.0) * PI * spheroid
        + DVec3::new(7.0, 0.0, 0.0) * PI
}

#[test]
fn photons_of_a_scene_carry_the_power_of_all_lights() {
    let (world, packed) = World::parse(SCENE);
    let area_scale = packed.space.scale * packed.space.scale;
    let power = scene_power(packed.space.half_extent / packed.space.scale);
    assert_near(packed.mean_power / area_scale, power.element_sum() / 3.0, 1e-4, "mean power");
    let expected = power / (power.element_sum() / 3.0);
    let mean = mean_weight(&emit(&world));
    // Lights are chosen by one number that a (0,2)-sequence stratifies; the spheroid's
    // weights vary besides.
    for channel in 0..3 {
        assert_near(mean[channel], expected[channel], 5e-4, "mean weight");
    }
}
