// spin: goes through a loop as often as asked, and reports whether the driver ended the loop early.
#version 460
#include "kernel/interruption.glsl"
#include "kernel/invocation.glsl"

struct SpinState {
    uint rounds;      // in: rounds asked for; out: rounds done
    uint interrupted; // out: 1 if the driver ended the loop early
};

UPDATED_BUFFER(SpinState, spins)

void main() {
    uint i = invocation_index();
    if (i >= spins.data.length()) {
        return;
    }
    uint rounds = 0u;
    // A sequence that no compiler computes without a loop.
    for (uint x = i + 1u; rounds < spins.data[i].rounds && x != 0u; rounds++) {
        x = x * 747796405u + 2u * rounds + 1u;
    }
    spins.data[i] = SpinState(rounds, interrupted() ? 1u : 0u);
}
