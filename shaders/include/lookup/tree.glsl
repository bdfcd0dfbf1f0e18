// Walks the kd-tree over visible points. It is left-balanced: the children of node n are nodes 2n and
// 2n + 1, counted from 1.

// A node of the kd-tree is the pixel of its visible point, and above it the axis that it splits, from
// this bit on.
export const uint AXIS_SHIFT = 28u;
export const uint PIXEL_MASK = 0x0fffffffu; // the pixel of a node

// A visible point as a node of the kd-tree.
struct TreePoint {
    vec3 position; // render units
    float radius2; // squared radius, render units
    uint normal;   // packed: normal.glsl
    uint owner;    // pixel, and the axis above it
    uint pad0;
    uint pad1;
};

// Where an invocation of gather_tree has got to.
struct TreePlace {
    uint photon;  // that is added
    uint node;    // to be taken next, counted from 1; 0 where the photon has none left
    uint pending; // siblings that are left to take, a bit a level: next_node
};

// Goes on to the next node that may have a point within the radius, or to node 0 if there is none. d is
// the photon's position less the position of the current node, which splits `axis`.
//
// Each node is visited once, its left child before its right child. The state is one bit per level: a set
// bit is a right sibling still to visit, bit 0 that of the current node (Barringer and Akenine-Möller,
// "Dynamic Stackless Binary Tree Traversal", JCGT 2013).
void next_node(inout TreePlace place, vec3 d, uint axis, float radius, uint node_count) {
    float along = axis == 0u ? d.x : axis == 1u ? d.y : d.z;
    uint left = 2u * place.node;
    bool takes_left = along <= radius && left <= node_count;
    bool takes_right = along >= -radius && left < node_count;
    if (takes_left || takes_right) {
        place.pending = place.pending << 1u | uint(takes_left && takes_right);
        place.node = left + uint(!takes_left);
    } else if (place.pending != 0u) {
        uint levels = uint(findLSB(place.pending));
        place.pending = (place.pending >> levels) - 1u;
        place.node = (place.node >> levels) + 1u;
    } else {
        place.node = 0u;
    }
}
