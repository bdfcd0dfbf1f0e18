//! Profiles: of every degree, with all that makes them hard.

use std::fmt::Write;

use glam::DVec2;
use goblet::geometry::bezier::Curve;

use crate::fixture::Rng;

/// Segments of a degree that share end points (radius, height).
#[derive(Clone, Debug)]
pub struct Profile {
    pub name: String,
    pub degree: usize,
    pub points: Vec<[f64; 2]>,
}

impl Profile {
    /// Coordinates are multiples of 2^-36, so that unit space is an exact scaling.
    pub fn new(name: &str, degree: usize, points: &[[f64; 2]]) -> Self {
        let round = |x: f64| (x * 36.0_f64.exp2()).round() * (-36.0_f64).exp2();
        let points = points.iter().map(|point| point.map(round)).collect();
        Self { name: name.to_owned(), degree, points }
    }

    fn scaled(&self, name: &str, [across, along]: [f64; 2]) -> Self {
        let points: Vec<_> = self.points.iter().map(|[u, v]| [u * across, v * along]).collect();
        Self::new(name, self.degree, &points)
    }

    /// The segments.
    pub fn curves(&self) -> Vec<Curve> {
        let curve = |first: usize| {
            let points = &self.points[first..=first + self.degree];
            Curve { points: points.iter().map(|point| DVec2::from(*point)).collect() }
        };
        (0..self.points.len() - 1).step_by(self.degree).map(curve).collect()
    }

    /// A scene of the body alone, of glass, after some directives.
    pub fn scene(&self, directives: &str) -> String {
        let mut text = format!(
            "WorldBegin\nLightSource \"point\"\nMaterial \"dielectric\" \"float eta\" 1.5\n{directives}\n\
             Shape \"revolution\" \"integer degree\" {} \"point2 P\" [",
            self.degree
        );
        for [u, v] in &self.points {
            write!(text, " {u} {v}").expect("text");
        }
        text.push_str(" ]\n");
        text
    }
}

/// The bodies of the reference scene.
pub fn reference() -> [Profile; 3] {
    let cup = [
        [0.0, 0.02],
        [0.25, 0.02],
        [0.55, 0.02],
        [0.62, 0.03],
        [0.69, 0.04],
        [0.69, 0.09],
        [0.55, 0.1],
        [0.3, 0.12],
        [0.09, 0.16],
        [0.075, 0.45],
        [0.06, 0.75],
        [0.055, 0.95],
        [0.11, 1.06],
        [0.2, 1.2],
        [0.62, 1.28],
        [0.66, 1.75],
        [0.69, 2.05],
        [0.62, 2.3],
        [0.55, 2.52],
        [0.54, 2.56],
        [0.5, 2.56],
        [0.505, 2.52],
        [0.57, 2.3],
        [0.63, 2.05],
        [0.605, 1.75],
        [0.575, 1.36],
        [0.2, 1.3],
        [0.0, 1.3],
    ];
    let bottle = [[0.0, 0.0], [0.9, 0.0], [1.15, 0.5], [0.5, 1.1], [0.25, 1.6], [0.62, 1.95], [0.3, 2.2], [0.0, 2.2]];
    let egg = [[0.0, 0.0], [0.55, 0.0], [0.75, 0.55], [0.3, 1.0], [0.0, 1.0]];
    [Profile::new("cup", 3, &cup), Profile::new("bottle", 7, &bottle), Profile::new("egg", 4, &egg)]
}

/// A vase whose wall is this thick, with a round rim.
pub fn vase(wall: f64) -> Profile {
    let rim = 0.5 - 0.5 * wall;
    let points = [
        [0.0, 0.0],
        [0.4, 0.0],
        [0.7, 0.3],
        [0.6, 0.7],
        [0.5, 1.0],
        [0.4, 1.2],
        [0.5, 1.5],
        [0.5, 1.5 + 0.6 * wall],
        [rim - 0.5 * wall, 1.5 + 0.6 * wall],
        [rim - 0.5 * wall, 1.5],
        [0.4 - wall, 1.2],
        [0.5 - wall, 1.0],
        [0.6 - wall, 0.7],
        [0.7 - wall, 0.3 + wall],
        [0.4 - wall, wall],
        [0.0, wall],
    ];
    Profile::new(&format!("vase {wall:e}"), 3, &points)
}

/// Control points all over, now and then one twice, or an end on the axis; its name tells.
pub fn random(rng: &mut Rng, degree: usize) -> Profile {
    let last = degree * (1 + rng.below(3));
    let short = |x: f64| (1000.0 * x).round() / 1000.0;
    let mut points: Vec<[f64; 2]> = Vec::new();
    for i in 0..=last {
        let repeated = i > 1 && rng.chance(0.1);
        let point = [rng.range(0.001, 1.0), rng.range(-1.0, 1.0)].map(short);
        points.push(if repeated { points[i - 1] } else { point });
    }
    for end in [0, last] {
        // Not all of the profile.
        if rng.chance(0.5) && last > 1 {
            points[end][0] = 0.0;
        }
    }
    Profile::new(&format!("degree {degree} {points:?}"), degree, &points)
}

/// Bodies with one difficulty each.
pub fn special() -> Vec<Profile> {
    let wave: Vec<_> = (0..9).map(|i| [if i % 2 == 0 { 0.2 } else { 0.9 }, 0.25 * f64::from(i) - 1.0]).collect();
    let quintic = [[0.3, -1.0], [1.0, -0.6], [0.0, -0.2], [1.0, 0.2], [0.0, 0.6], [0.6, 1.0]];
    let [cup, _, egg] = reference();
    vec![
        Profile::new("cylinder", 1, &[[0.5, -1.0], [0.5, 1.0]]),
        Profile::new("cone", 1, &[[0.8, 0.0], [0.0, 1.5]]),
        Profile::new("can", 1, &[[0.0, -1.0], [0.6, -1.0], [0.6, 1.0], [0.0, 1.0]]),
        Profile::new("paraboloid", 2, &[[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]),
        Profile::new("inflections", 5, &quintic),
        Profile::new("wave", 8, &wave),
        Profile::new(
            "cusp",
            3,
            &[[0.0, -1.0], [0.9, -0.5], [0.5, 0.0], [0.7, 0.0], [0.3, 0.0], [0.9, 0.5], [0.0, 1.0]],
        ),
        // A curve with a cusp of its own at t = 1/2.
        Profile::new("cusp inside", 3, &[[0.2, -0.5], [0.8, 0.5], [0.2, 0.5], [0.8, -0.5]]),
        Profile::new(
            "repeated points",
            4,
            &[
                [0.0, 0.0],
                [0.0, 0.0],
                [0.7, 0.2],
                [0.7, 0.2],
                [0.7, 0.2],
                [0.7, 0.2],
                [0.7, 0.2],
                [0.4, 1.0],
                [0.4, 1.0],
            ],
        ),
        Profile::new(
            "torus",
            2,
            &[
                [0.5, 0.0],
                [0.5, 0.2],
                [0.7, 0.2],
                [0.9, 0.2],
                [0.9, 0.0],
                [0.9, -0.2],
                [0.7, -0.2],
                [0.5, -0.2],
                [0.5, 0.0],
            ],
        ),
        Profile::new(
            "steps",
            6,
            &[[0.9, -1.0], [0.1, -1.0], [0.9, 0.0], [0.5, 0.0], [0.1, 0.0], [0.9, 1.0], [0.1, 1.0]],
        ),
        cup.scaled("disc", [1.0, 1e-3]),
        egg.scaled("flat disc", [1.0, 1e-5]),
        egg.scaled("needle", [1e-3, 2.0]),
    ]
}

/// All of them: 40 or so.
pub fn all(rng: &mut Rng) -> Vec<Profile> {
    let mut all = Vec::from(reference());
    all.extend(special());
    all.extend([1e-1, 1e-2, 1e-3, 1e-4, 1e-5].map(vase));
    all.extend((1..=8).map(|degree| random(rng, degree)));
    all
}
