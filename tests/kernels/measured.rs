//! measured.glsl against its f64 twin, and against the surfaces that the tables are of.

use std::fmt::Write;

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

use crate::fixture::{Rng, double, frame, single};
use crate::generated::{MEASURED, Material, Meeting};
use crate::rough::{directions_follow_the_pdf, scatter_in};
use crate::support::measured::{Analytic, ISOTROPIC, Steps, Tables};
use crate::world::World;

const COARSE: Steps = Steps { size: [20, 17], azimuths: 1, turn: 0.0, polar_angles: 9 };

/// Anisotropic tables over a part of a turn.
fn anisotropic(turn: f64) -> Steps {
    Steps { size: [20, 17], azimuths: 9, turn, polar_angles: 9 }
}

/// Tables, and the world in which they are materials.
fn worlds(tables: &[Tables]) -> (World, Vec<Material>) {
    let mut scene = String::from("WorldBegin LightSource \"infinite\"\n");
    let files: Vec<_> = tables.iter().map(Tables::write).collect();
    for file in &files {
        writeln!(scene, "{} Shape \"sphere\"", file.material()).expect("text");
    }
    let (world, _) = World::parse(&scene);
    let materials = world.arrays.materials.clone();
    assert!(materials.len() == tables.len() && materials.iter().all(|material| material.kind == MEASURED));
    (world, materials)
}

/// A meeting in a random frame, with both directions on one side, and the same directions in the frame.
fn meeting(rng: &mut Rng, material: usize, [wo, wi]: [DVec3; 2]) -> Meeting {
    let n = rng.direction();
    let (s, t) = frame(n);
    let (cos, sin) = (rng.unit().cos(), rng.unit().sin());
    let s = (cos * s + sin * t).normalize();
    let t = n.cross(s);
    // Behind the surface, pbrt takes directions through the point: where n is the other way, so are x and y.
    let behind = rng.chance(0.5);
    let world = |w: DVec3| single(if behind { -w.x * s + w.y * t + w.z * n } else { w.x * s + w.y * t + w.z * n });
    Meeting {
        wo: world(wo),
        wi: world(wi),
        normal: single(if behind { -n } else { n }),
        tangent: single(s),
        material: material as u32,
        u: [rng.unit_f32(), rng.unit_f32()],
        carries_radiance: u32::from(rng.chance(0.5)),
        ..Meeting::zeroed()
    }
}

/// A direction above the horizon.
fn above(rng: &mut Rng, least: f64) -> DVec3 {
    loop {
        let w = rng.direction();
        if w.z > least {
            return w;
        }
    }
}

fn all_tables() -> Vec<Tables> {
    let metal = |steps: &Steps| Tables::new(&Analytic::ggx([0.6, 0.25]), steps);
    vec![
        Tables::new(&Analytic::lambertian(0.6), &COARSE),
        Tables::new(&Analytic::ggx([0.3; 2]), &COARSE),
        metal(&anisotropic(1.0)),
        metal(&anisotropic(0.5)),
        metal(&anisotropic(0.25)),
    ]
}

#[test]
fn values_and_pdfs_agree_with_f64() {
    const COUNT: usize = 4000;
    let (tables, mut rng) = (all_tables(), Rng(1));
    let (world, materials) = worlds(&tables);
    let mut pairs: Vec<[DVec3; 2]> = (0..COUNT).map(|_| [above(&mut rng, 0.02), above(&mut rng, 0.02)]).collect();
    // Along the normal, and reflected straight back.
    pairs.extend([[DVec3::Z, DVec3::new(0.6, 0.0, 0.8)], [DVec3::new(0.0, 0.6, 0.8), DVec3::Z]]);
    let meetings: Vec<_> =
        pairs.iter().enumerate().map(|(i, pair)| meeting(&mut rng, i % tables.len(), *pair)).collect();
    for ((i, [wo, wi]), outcome) in pairs.iter().enumerate().zip(scatter_in(&world, &materials, &meetings)) {
        let expected = tables[i % tables.len()].incident(*wo).evaluate(*wi);
        let found = [outcome.value[0], outcome.pdf].map(f64::from);
        for (found, expected) in found.iter().zip(expected) {
            // A direction's rounding moves a point in cells of a twentieth of the square, and its numbers with it.
            let bound = 2e-3 * expected + 1e-4;
            assert!(
                (found - expected).abs() <= bound,
                "table {} {wo} {wi}: {found} is not {expected}",
                i % tables.len()
            );
        }
        assert!(outcome.value.iter().all(|value| (value - outcome.value[0]).abs() <= 1e-5 * outcome.value[0]));
    }
}

#[test]
fn sampled_directions_agree_with_f64() {
    let (tables, mut rng) = (all_tables(), Rng(2));
    let (world, materials) = worlds(&tables);
    let wos: Vec<DVec3> = (0..1000).map(|_| above(&mut rng, 0.1)).collect();
    let mut meetings = Vec::new();
    for (i, wo) in wos.iter().enumerate() {
        meetings.push(Meeting {
            wo: single(*wo),
            normal: [0.0, 0.0, 1.0],
            tangent: [1.0, 0.0, 0.0],
            material: (i % tables.len()) as u32,
            u: [rng.unit_f32(), rng.unit_f32()],
            ..Meeting::zeroed()
        });
    }
    let mut compared = 0;
    for ((i, wo), outcome) in wos.iter().enumerate().zip(scatter_in(&world, &materials, &meetings)) {
        let expected = tables[i % tables.len()].incident(*wo).sample(DVec2::from(meetings[i].u.map(f64::from)));
        if outcome.weight != [0.0; 3] {
            compared += 1;
            let off = (double(outcome.wi) - expected).length();
            // Where a table is nearly 0, many numbers select the same place.
            assert!(off < 5e-3, "table {} {wo}: {:?} is not {expected}", i % tables.len(), outcome.wi);
        }
    }
    assert!(compared > 800, "{compared}");
}

#[test]
fn weights_are_the_value_over_the_pdf() {
    let (tables, mut rng) = (all_tables(), Rng(3));
    let (world, materials) = worlds(&tables);
    let meetings: Vec<_> = (0..50_000)
        .map(|i| {
            let wo = above(&mut rng, 0.05);
            Meeting { wi: [0.0; 3], ..meeting(&mut rng, i % tables.len(), [wo, wo]) }
        })
        .collect();
    let mut compared = 0;
    for (meeting, outcome) in meetings.iter().zip(scatter_in(&world, &materials, &meetings)) {
        let cos = double(outcome.wi).dot(double(meeting.normal)).abs();
        if outcome.weight == [0.0; 3] || cos < 0.02 || outcome.pdf < 1e-3 {
            continue;
        }
        compared += 1;
        let (weight, expected) = (outcome.weight[0], outcome.value[0] / outcome.pdf);
        assert!((weight - expected).abs() <= 0.01 * expected + 1e-4, "{meeting:?}: {outcome:?}, {weight} {expected}");
    }
    assert!(compared > 40_000, "{compared}");
}

#[test]
fn measured_directions_follow_their_pdf() {
    let tables = all_tables();
    let (world, materials) = worlds(&tables);
    for wo in [DVec3::new(0.5, 0.2, 0.7), DVec3::new(-0.2, 0.6, 0.4)] {
        for material in &materials {
            directions_follow_the_pdf(&world, *material, wo.normalize());
        }
    }
}

/// Mean weight of directions from a material at an angle and an azimuth.
fn albedo(world: &World, materials: &[Material], material: usize, wo: DVec3) -> f64 {
    const SAMPLES: usize = 60_000;
    let mut rng = Rng(5);
    let draw = |_| Meeting {
        wo: single(wo),
        normal: [0.0, 0.0, 1.0],
        tangent: [1.0, 0.0, 0.0],
        material: material as u32,
        u: [rng.unit_f32(), rng.unit_f32()],
        ..Meeting::zeroed()
    };
    let meetings: Vec<_> = (0..SAMPLES).map(draw).collect();
    let outcomes = scatter_in(world, materials, &meetings);
    outcomes.iter().map(|outcome| f64::from(outcome.weight[0])).sum::<f64>() / SAMPLES as f64
}

/// In a furnace, tables reflect what the surface does that they are of, and no table reflects more than all light.
#[test]
fn tables_reflect_what_their_surfaces_do() {
    let surfaces =
        [Analytic::lambertian(0.6), Analytic::ggx([0.25; 2]), Analytic::ggx([0.8; 2]), Analytic::lambertian(1.0)];
    let tables: Vec<_> = surfaces.iter().map(|surface| Tables::new(surface, &ISOTROPIC)).collect();
    let (world, materials) = worlds(&tables);
    for (i, surface) in surfaces.iter().enumerate() {
        for cos in [0.95, 0.6, 0.3] {
            let wo = DVec3::new(f64::sqrt(1.0 - cos * cos), 0.0, cos);
            let (found, exact) = (albedo(&world, &materials, i, wo), surface.albedo(wo, 400));
            println!("surface {i} at {cos}: {found:.4}, exactly {exact:.4}");
            assert!((found / exact - 1.0).abs() < 0.01, "surface {i} at {cos}: {found} is not {exact}");
            assert!(found < 1.005, "surface {i} at {cos}: {found}");
        }
    }
}

/// Tables of a surface that obeys Helmholtz's reciprocity do so, up to their resolution.
#[test]
fn light_goes_both_ways_alike_on_measured_surfaces() {
    let tables = [0.5, 0.8].map(|alpha| Tables::new(&Analytic::ggx([alpha; 2]), &ISOTROPIC));
    let (world, materials) = worlds(&tables);
    let mut rng = Rng(6);
    let pairs: Vec<[DVec3; 2]> = (0..4000).map(|_| [above(&mut rng, 0.3), above(&mut rng, 0.3)]).collect();
    let meetings = |swap: bool, rng: &mut Rng| -> Vec<Meeting> {
        let pair = |[wo, wi]: [DVec3; 2]| if swap { [wi, wo] } else { [wo, wi] };
        pairs.iter().enumerate().map(|(i, two)| meeting(rng, i % 2, pair(*two))).collect()
    };
    let there = scatter_in(&world, &materials, &meetings(false, &mut rng));
    let back = scatter_in(&world, &materials, &meetings(true, &mut rng));
    let (mut worst, mut sum) = (0.0_f64, 0.0);
    for ((pair, there), back) in pairs.iter().zip(&there).zip(&back) {
        let [f, g] = [f64::from(there.value[0]) / pair[1].z, f64::from(back.value[0]) / pair[0].z];
        let off = (f - g).abs() / f.max(g);
        (worst, sum) = (worst.max(off), sum + off);
    }
    println!("off by {:.4} in the mean, {worst:.4} at most", sum / pairs.len() as f64);
    // Normals near that of the surface are in few cells.
    assert!(worst < 0.15 && sum / (pairs.len() as f64) < 0.01, "{worst} {sum}");
}
