// meet_skies: evaluates the radiance of infinite lights in given directions.
#version 460
#include "kernel/invocation.glsl"
#include "light/light.glsl"

struct Escape {
    vec3 direction;
    float bsdf_pdf;
};

BUFFER(Escape, escapes)
UPDATED_BUFFER(vec4, radiances)

void main() {
    uint i = invocation_index();
    if (i < escapes.data.length()) {
        vec3 radiance = radiance_from_infinity(vec3(0.0), escapes.data[i].direction, no_hue(), escapes.data[i].bsdf_pdf);
        radiances.data[i] = vec4(radiance, 0.0);
    }
}
