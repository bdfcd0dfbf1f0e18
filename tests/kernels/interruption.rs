//! Loops that a driver ends early are told from those that end by themselves.

use crate::fixture::Fixture;
use crate::generated::{Spin, SpinState};

/// Asks 64 invocations for a number of rounds. Returns the rounds that each did, and whether it found its loop
/// ended early.
fn spin(asked: u32) -> Vec<SpinState> {
    let fixture = Fixture::new();
    let spins = fixture.upload(&[SpinState { rounds: asked, interrupted: 0 }; 64]);
    fixture.run(&Spin { spins: &spins }, 64);
    fixture.read(&spins)
}

#[test]
fn an_invocation_knows_that_its_loops_were_ended() {
    for asked in [0, 1, 60_000, 65_535, 65_536, 70_000, 1_000_000] {
        for state in spin(asked) {
            assert!(state.rounds == asked || state.interrupted == 1, "{} of {asked} rounds", state.rounds);
            // Half of what Mesa allows, whatever the device.
            assert!(asked > 32_768 || state.interrupted == 0, "{asked} rounds are too many");
        }
    }
}
