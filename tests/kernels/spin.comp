// spin: loops as often as asked, and says whether the driver let it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "kernel/interruption.glsl"

struct SpinState {
    uint rounds;      // asked for, then gone
    uint interrupted;
};

layout(std430, set = 1, binding = 0) buffer SpinBlock { SpinState data[]; } spins;
layout(std430, set = 1, binding = 1) readonly buffer TwoBlock { uint value; } two;

void main() {
    uint i = invocation_index();
    if (i >= spins.data.length()) {
        return;
    }
    uint rounds = 0u;
    // Nothing that could be computed without a loop.
    for (uint x = i + 1u; rounds < spins.data[i].rounds && x != 0u; rounds++) {
        x = x * 747796405u + 2u * rounds + 1u;
    }
    spins.data[i] = SpinState(rounds, interrupted(two.value) ? 1u : 0u);
}
