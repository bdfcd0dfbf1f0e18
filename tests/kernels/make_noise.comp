// make_noise: noise at given points, and what textures make of it.
#version 460
#include "kernel/invocation.glsl"
#include "material/noise.glsl"

struct NoisePoint {
    vec3 position;
    uint kind; // of the node: TEXTURE_FBM, ..
    float roughness;
    float variation;
    uint octaves;
    uint pad;
};

BUFFER(NoisePoint, points)
UPDATED_BUFFER(vec4, values) // the node's value, then the noise

void main() {
    uint i = invocation_index();
    if (i >= points.data.length()) {
        return;
    }
    NoisePoint point = points.data[i];
    TextureNode node = texture_nodes_at(0u);
    node.kind = point.kind;
    node.width = point.octaves;
    node.values[0] = vec4(point.roughness);
    node.values[1] = vec4(point.variation);
    vec3 value = node.kind == TEXTURE_DOTS ? vec3(is_in_dot(node.first, point.position.xy) ? 1.0 : 0.0)
                                           : noise_value(node, point.position);
    values.data[i] = vec4(value, noise(node.first, point.position));
}
