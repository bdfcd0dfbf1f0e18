// spin: loops as often as asked, and says whether the driver let it.
#version 460
#include "kernel/interruption.glsl"
#include "kernel/invocation.glsl"

struct SpinState {
    uint rounds;      // asked for, then gone
    uint interrupted;
};

UPDATED_BUFFER(SpinState, spins)
VALUE(uint, two)

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
