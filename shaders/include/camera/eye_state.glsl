// The state of an eye path, and how it is kept in memory from one dispatch to the next.
#include "camera/rough_path.glsl"
#include "geometry/contact.glsl"
#include "kernel/interruption.glsl"
#include "spectrum/spread.glsl"
#include "spectrum/wavelength.glsl"

// Least length of a path, in render units: a length of 0 stands for "no visible point".
const float SHORTEST_PATH = 1.0e-12;

// An eye path that has met no diffuse surface yet: the state from which it is continued.
struct EyeState {
    Ray ray;           // its next segment
    vec3 throughput;
    float medium_eta;  // refractive index of the medium that the path is in, over the camera's
    float travelled;   // length of the path so far, render units
    RoughVertex rough; // the vertex that the ray leaves, if that was rough
    uint depth;        // segments so far
    vec3 radiance;     // emission met so far, W/(m^2 sr)
    uint rough_met;    // HAS_ROUGH_GATHER: rough surfaces met so far
    Hue hue;           // HAS_DISPERSION: of the path; at a visible point, what it is there
    Spread spread;     // HAS_DISPERSION: of its wavelengths
};

// The path of an invocation that another dispatch goes on with: it has met no diffuse surface yet.
struct EyePlace {
    vec3 origin;        // of the path's next ray, render units
    float medium_eta;   // refractive index of the medium that the path is in, over the camera's
    vec3 direction;     // of that ray
    float travelled;    // length of the path so far, render units
    vec3 throughput;    // of the path so far
    uint depth;         // segments of the path so far
    vec3 radiance;      // emission met so far, W/(m^2 sr)
    uint path;          // number of the path among those of its pixel
    vec3 last_position; // of the RoughVertex
    float last_pdf;     // of the RoughVertex
    uint state;         // FINISHED, UNFINISHED or STUCK
    float begin;        // of the ray: contact.glsl
    uint contacts;      // of the ray: contact.glsl
    uint medium;        // of the ray: index into media
    uint rough_met;     // rough surfaces that the path has met
    float wavelength;   // of the Hue
    float window;       // of the Hue
    float slope;        // of the Hue
    vec3 spread_position; // of the Spread
    float widest;       // of the Hue
    vec3 spread_direction; // of the Spread
    uint pad0;
    vec3 spread_middle; // of the Spread
    uint pad1;
};

EyeState state_at_camera(Ray ray) {
    return EyeState(ray, vec3(1.0), 1.0, 0.0, no_rough_vertex(), 0u, vec3(0.0), 0u, no_hue(), no_spread());
}

EyeState state_of(EyePlace place) {
    Ray ray = saved_ray(place.origin, place.direction, place.begin, place.contacts, place.medium);
    RoughVertex rough = RoughVertex(place.last_position, place.last_pdf);
    return EyeState(ray, place.throughput, place.medium_eta, place.travelled, rough, place.depth, place.radiance, place.rough_met,
                    Hue(place.wavelength, place.window, place.slope, place.widest),
                    Spread(place.spread_position, place.spread_direction, place.spread_middle));
}

EyePlace place_of(EyeState state) {
    return EyePlace(state.ray.origin, state.medium_eta, state.ray.direction, state.travelled, state.throughput, state.depth,
                    state.radiance, 0u, state.rough.position, state.rough.pdf, FINISHED, begin_of(state.ray), contacts_of(state.ray), state.ray.medium,
                    state.rough_met, state.hue.wavelength, state.hue.window, state.hue.slope, state.spread.position,
                    state.hue.widest, state.spread.direction, 0u, state.spread.middle, 0u);
}

// Finds over which wavelengths the color of a path is averaged, at the end of a segment of length t on a surface with
// normal n. `radius` and `radius_per_length` times the length of the path are the radius of the image's blur there.
void find_window(inout EyeState state, float t, vec3 n, float radius, float radius_per_length) {
    move_spread(state.spread, state.ray.direction, t, n);
    state.hue.window = window_of(state.spread, radius + radius_per_length * state.travelled);
}

// The hue of a path for light that a rough surface scatters into it, from about this distance: wavelengths that the
// surface has just spread count as spread.
Hue hue_beyond(EyeState state, float way, float radius, float radius_per_length) {
    Spread spread = Spread(state.spread.position + way * state.spread.direction, vec3(0.0), vec3(0.0));
    float window = window_of(spread, radius + radius_per_length * (state.travelled + way));
    return Hue(state.hue.wavelength, min(state.hue.window, window), state.hue.slope, state.hue.widest);
}

// What the next segment of a path begins with.
Split split_of(EyeState state, float radius, float radius_per_length) {
    return Split(state.hue, state.spread, radius + radius_per_length * state.travelled);
}
