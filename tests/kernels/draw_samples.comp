// draw_samples: samples points and directions by given uniform numbers.
#version 460
#include "kernel/invocation.glsl"
#include "math/sampling.glsl"

struct Draw {
    vec2 u;
    float one_minus_z_min;
    float pad0;
    vec3 normal;
    float pad1;
};

struct Drawn {
    vec2 disk;
    vec2 triangle;
    vec3 cosine;
    float pad0;
    vec3 cap;
    float pad1;
    vec3 s;
    float pad2;
    vec3 t;
    float pad3;
};

BUFFER(Draw, draws)
UPDATED_BUFFER(Drawn, drawn)

void main() {
    uint i = invocation_index();
    if (i >= draws.data.length()) {
        return;
    }
    Draw draw = draws.data[i];
    vec3 s, t;
    make_frame(draw.normal, s, t);
    drawn.data[i] = Drawn(sample_disk(draw.u), sample_triangle(draw.u), sample_cosine(draw.u, draw.normal), 0.0,
                          sample_cap(draw.u, draw.one_minus_z_min), 0.0, s, 0.0, t, 0.0);
}
