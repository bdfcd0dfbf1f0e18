// run_textures: evaluates textures at given points of surfaces.
#version 460
#include "geometry/surface_point.glsl"
#include "kernel/invocation.glsl"
#include "material/texture.glsl"

struct TexturedPoint {
    vec3 position;
    uint first; // node of the texture
    vec3 normal;
    float pad0;
    vec2 uv;
    vec2 pad1;
};

BUFFER(TexturedPoint, points)
UPDATED_BUFFER(vec4, values)

void main() {
    uint i = invocation_index();
    if (i >= points.data.length()) {
        return;
    }
    Surface surface;
    surface.position = points.data[i].position;
    surface.normal = points.data[i].normal;
    surface.uv = points.data[i].uv;
    values.data[i] = vec4(textured(points.data[i].first, vec3(-7.0), surface), 0.0);
}
