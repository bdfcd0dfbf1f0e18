// Walks the kd-tree over visible points. It is left-balanced: the children of node n are nodes 2n and
// 2n + 1, counted from 1.

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
