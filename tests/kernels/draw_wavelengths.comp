// draw_wavelengths: looks up what paths of given wavelengths are: their colors, and the first material's index.
#version 460
#include "kernel/invocation.glsl"
#include "material/dispersion.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

struct DrawnWavelength {
    vec3 color;
    float wavelength; // share of paths with a shorter one
    vec3 channels;    // mean indices
    float eta;
    float window;
    float slope;
    vec2 pad1;
};

UPDATED_BUFFER(DrawnWavelength, drawn) // the wavelengths and windows are given

void main() {
    uint i = invocation_index();
    if (i >= drawn.data.length()) {
        return;
    }
    Material material = materials_at(0u);
    Hue hue = Hue(drawn.data[i].wavelength, drawn.data[i].window, drawn.data[i].slope, 1.0);
    drawn.data[i].color = color_of(scene.colors, hue);
    drawn.data[i].channels = channel_indices(material);
    drawn.data[i].eta = index_at(material, hue);
}
