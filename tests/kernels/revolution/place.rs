//! Bodies of any size, anywhere, turned and mirrored: as those about the origin.

use crate::fixture::{EPS, Fixture, Rng};
use crate::revolution::lab::Lab;
use crate::revolution::profiles::{self, Profile};
use crate::revolution::rays::Kind;
use crate::revolution::tally::{HEADING, Tally};

const COUNT: usize = 1024;

/// A transform that does not keep the bits rounds a ray from 5 away: its origin by four
/// roundings of that, and as much again over its length. Distances are off by these 40 EPS
/// over |N.D|, so that another root is one that is farther off than 1e-3.
const OFF: f64 = 40.0 * EPS;
const SAME: f64 = 1e-3;

fn bodies() -> Vec<Profile> {
    let mut bodies = Vec::from(profiles::reference());
    bodies.push(profiles::vase(1e-3));
    bodies
}

/// Rays at bodies after these directives.
fn check(directives: &str) {
    let fixture = Fixture::new();
    let mut rng = Rng(1);
    let mut tally = Tally::default();
    for profile in bodies() {
        let lab = Lab::new(&fixture, &profile, directives, COUNT, SAME);
        let alone = Lab::exact(&fixture, &profile, COUNT);
        assert_eq!(lab.world.revolution_pieces, alone.world.revolution_pieces, "{}: {directives}", profile.name);
        for kind in [Kind::Primary5, Kind::Refracted, Kind::NearHorizontal, Kind::ThroughAxis] {
            tally.merge(&lab.tally(kind, &mut rng, COUNT, true));
        }
    }
    let clean = tally.clean();
    println!("{directives}\n{HEADING}\n{tally}");
    assert_eq!(clean.wrong, 0, "{directives}: nearest hits are wrong");
    assert_eq!(clean.missed, 0, "{directives}: roots are missed");
    assert!(clean.off <= OFF, "{directives}: surfaces are {:e} from where they are", clean.off);
}

#[test]
fn size_does_not_matter() {
    check("Scale 1e-4 1e-4 1e-4");
    check("Scale 1e6 1e6 1e6");
}

#[test]
fn place_does_not_matter() {
    check("Translate 1e5 -1e5 1e5");
    check("Translate 1e5 2e4 -5e4 Scale 1e-2 1e-2 1e-2");
}

#[test]
fn turns_and_mirrors_do_not_matter() {
    check("Rotate 70 0.3 -0.5 0.8");
    check("Translate 1e5 1e5 0 Rotate 200 0.5 0.6 -0.2 Scale -3 3 3");
}

/// Distances grow with the stretch, and the errors of unit space with them.
#[test]
fn bodies_may_be_stretched() {
    check("Rotate 30 1 1 0 Scale 1 1 0.6");
    check("Scale 0.8 0.8 -1.5");
}
