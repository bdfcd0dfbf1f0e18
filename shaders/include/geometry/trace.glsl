// Traces the rays of an invocation, one after the other, and lets a pass work on each answer.
//
// The pass defines, before it includes this, the struct Work, and after it
//   bool next_query(inout Work work, inout Query query, Hit hit)
// which takes the answer to a query, except on its first call, and asks the next one. It returns false if
// there is none.
//
// Rays take from a few to hundreds of steps. If each lane of a SIMD vector waited for the slowest one, a
// third of them would work. So where IS_QUEUE, lanes go on together but each on its own ray (Aila and Laine,
// "Understanding the Efficiency of Ray Traversal on GPUs", 2009): they leave the inner nodes once few of
// them are at one, and work on answers once most of them have one. On other devices, each lane finishes
// its ray, and then waits for those of its subgroup.
#include "geometry/hierarchy.glsl"
#include "geometry/hit.glsl"
#include "geometry/intersect.glsl"
#include "geometry/query.glsl"
#include "kernel/interruption.glsl"
#include "kernel/lanes.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/primitives.glsl"
#include "scene/scene.glsl"

// Where a ray is in the hierarchy, besides inner nodes and leaves: at its end, before the next child of its
// group or of a group on the stack, and at the end of its way through an instance.
const uint AT_END = NONE;
const uint AT_NEXT = 0xfffffffeu;
const uint AT_EXIT = 0xfffffffdu;
// Entries of the stack: one for each level of the hierarchy, two for an instance, and up to two levels more
// for a leaf of primitives of which some must be alone, in the scene and in an object.
const uint MAX_GROUPS = MAX_BVH_DEPTH + 8u;
// An entry of the stack: the end of the walk through an instance. No group, whose count is not 0.
const uint LEAVE = 4u;

bool next_query(inout Work work, inout Query query, Hit hit);

bool is_inner(uint node) {
    return node >> COUNT_SHIFT == 0u;
}

bool is_triangles(uint node) {
    return (node >> COUNT_SHIFT) - 1u < MAX_LEAF_COUNT;
}

bool is_leaf_of(uint node, uint kind) {
    return node >> COUNT_SHIFT == kind && node < AT_EXIT;
}

// Tests the primitives of the leaf that a ray is at. Returns where it goes on, or stays: at an instance, or at
// a body for which other lanes are waited for.
//
// Loops of one round instead of `if`: a CPU driver skips a loop if no lane needs it.
uint test_leaf(uint node, Space space, bool any_hit, inout Hit hit) {
    bool is_tested = is_triangles(node);
    bool found = false;
    uint triangle = node & FIRST_MASK;
    uint end = is_tested ? triangle + (node >> COUNT_SHIFT) : 0u;
    for (; triangle < end && !(any_hit && found); triangle++) {
        uint primitive = TRIANGLE << KIND_SHIFT | triangle;
        found = intersect_triangle(triangles_at(triangle), space.ray, space.shear, primitive, space.instance, hit) || found;
    }
    if (HAS_QUADRICS) {
        for (bool tests = is_leaf_of(node, QUADRIC_LEAF); tests; tests = false) {
            uint index = node & FIRST_MASK;
            uint primitive = quadrics_at(index).kind << KIND_SHIFT | index;
            found = intersect_quadric(primitive, space.ray, space.instance, hit);
            is_tested = true;
        }
    }
    if (HAS_REVOLUTIONS) {
        bool is_body = is_leaf_of(node, REVOLUTION_LEAF);
        bool is_turn = is_turn_of(is_body, node != AT_END && !is_body);
        for (bool tests = is_body && is_turn; tests; tests = false) {
            found = test_body(node & FIRST_MASK, space.ray, any_hit, space.instance, hit);
            is_tested = true;
        }
    }
    return !is_tested ? node : any_hit && found ? AT_END : AT_NEXT;
}

// The space that a ray is traced in. Without instances the ray is that of the query, and is not kept twice.
Space space_of(Space space, Query query) {
    if (HAS_INSTANCES) {
        return space;
    }
    space.ray = query.ray;
    return space;
}

// Answers the queries of an invocation until there is none. All invocations of a subgroup must call this
// together; `is_busy` is false for one that has nothing to do.
void trace_queries(inout Work work, bool is_busy) {
    Query query = no_query();
    Hit hit = no_hit(0.0);
    Space space;
    uint stack[MAX_GROUPS];
    uint height;
    uint group;
    uint node = AT_END;
    while (any_lane(is_busy)) {
        // Those whose walk has ended; at first, all.
        if (is_busy && node == AT_END) {
            if (is_answered(query, hit)) {
                is_busy = next_query(work, query, hit);
            }
            hit = no_hit(query.t_max);
            space = enter_space(NONE, query.ray);
            node = is_busy && query.t_max >= 0.0 ? 0u : AT_END;
            height = 0u;
            group = 0u;
        }
        if (IS_FLAT) {
            hit = test_all(query.ray, query.t_max, query.any_hit);
            node = AT_END;
        } else {
            do {
                do {
                    if (node == AT_NEXT) {
                        if (group == 0u && height > 0u) {
                            group = stack[--height];
                        }
                        if (HAS_INSTANCES && group == LEAVE) {
                            node = AT_EXIT;
                            group = 0u;
                        } else {
                            node = group == 0u ? AT_END : take_child(group);
                        }
                    }
                    if (is_inner(node)) {
                        Entered entered = enter_children(node, space_of(space, query), hit.t);
                        if (entered.count > 1u) {
                            stack[height] = group;
                            height += group != 0u ? 1u : 0u;
                            group = group_of(node, entered.order >> 2u, entered.count - 1u);
                        }
                        node = entered.count > 0u ? entered.first : AT_NEXT;
                    }
                } while (goes_on(is_inner(node) || node == AT_NEXT, INNER_LANES));
                node = test_leaf(node, space_of(space, query), query.any_hit, hit);
                if (HAS_INSTANCES) {
                    bool enters = is_leaf_of(node, INSTANCE_LEAF);
                    for (bool moves = enters || node == AT_EXIT; moves; moves = false) {
                        uint instance = enters ? node & FIRST_MASK : NONE;
                        node = AT_NEXT;
                        if (enters) {
                            stack[height] = group;
                            height += group != 0u ? 1u : 0u;
                            stack[height++] = LEAVE;
                            group = 0u;
                            node = instances_at(instance).root;
                        }
                        space = enter_space(instance, query.ray);
                    }
                }
            } while (waits_for(node != AT_END, is_busy && node == AT_END));
        }
        if (IS_RESUMABLE) {
            if (interrupted()) {
                break; // the driver ended this walk early: it does not count
            }
        }
    }
}
