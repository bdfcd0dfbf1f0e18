// spin: goes through a loop as often as asked, and reports whether the driver ended the loop early.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "kernel/interruption.glsl"

struct SpinState {
    uint rounds;      // in: rounds asked for; out: rounds done
    uint interrupted; // out: 1 if the driver ended the loop early
};

layout(std430, set = 1, binding = 0) buffer SpinBlock { SpinState data[]; } spins;

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
