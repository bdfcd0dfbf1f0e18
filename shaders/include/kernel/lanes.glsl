// The lanes of a subgroup that work together on a queue of rays.
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "kernel/subgroup.glsl"
#include "scene/features.glsl"

// A loop over inner nodes goes on while this many eighths of the lanes are at one.
const uint INNER_LANES = 4u;
// Lanes with an answer wait until this many eighths of the lanes have one.
const uint ANSWERED_LANES = 5u;

// Lanes at a body of revolution wait until this many eighths of the lanes are at one.
const uint BODY_LANES = 4u;

// The sum over all lanes, which must be active. A few shuffles: CPU drivers make loops over lanes of ballots
// and sums.
uint sum_of_lanes(uint value) {
    [[unroll]] for (uint step = 1u; step < subgroup_lanes(); step <<= 1u) {
        value += subgroupShuffle(value, gl_SubgroupInvocationID ^ step);
    }
    return value;
}

// Whether any lane has something to do, or where lanes do not wait for each other, this one.
bool any_lane(bool busy) {
    if (IS_QUEUE) {
        return sum_of_lanes(busy ? 1u : 0u) > 0u;
    }
    return busy;
}

// Whether a loop goes on in which `lane` has something to do.
bool goes_on(bool lane, uint eighths) {
    if (IS_QUEUE) {
        return 8u * sum_of_lanes(lane ? 1u : 0u) >= eighths * subgroup_lanes();
    }
    return lane;
}

// Whether lanes that wait for an answer are walked on: some walk, and not enough have an answer.
bool waits_for(bool walks, bool is_answered) {
    if (IS_QUEUE) {
        uint sum = sum_of_lanes((walks ? 1u : 0u) | (is_answered ? 0x10000u : 0u));
        return (sum & 0xffffu) > 0u && 8u * (sum >> 16u) < ANSWERED_LANES * subgroup_lanes();
    }
    return walks;
}

// Whether it is the turn of the lanes that wait for others: enough of them wait, or no lane walks.
bool is_turn_of(bool waits, bool walks) {
    if (IS_QUEUE) {
        uint sum = sum_of_lanes((waits ? 1u : 0u) | (walks ? 0x10000u : 0u));
        return 8u * (sum & 0xffffu) >= BODY_LANES * subgroup_lanes() || sum >> 16u == 0u;
    }
    return true;
}
