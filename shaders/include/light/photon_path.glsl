// The path of a photon, and how it is kept in memory from one dispatch to the next.
#include "geometry/contact.glsl"
#include "math/random.glsl"
#include "spectrum/spread.glsl"
#include "spectrum/wavelength.glsl"

struct Path {
    Ray ray;          // its next segment
    vec3 weight;      // flux over the mean flux of a photon, per channel
    uint depth;       // segments so far
    float medium_eta; // refractive index of the medium that the path is in, over that where it began
    Random random;
    bool met_diffuse; // HAS_CAUSTIC_LAYER: a diffuse lobe has scattered it
    bool met_rough;   // HAS_ROUGH_GATHER: a diffuse or rough lobe has scattered it
    Hue hue;          // HAS_DISPERSION
    Spread spread;    // HAS_DISPERSION: of its wavelengths
};

// The path of an invocation that another dispatch goes on with.
struct PhotonPlace {
    vec3 origin;      // of the path's next ray, render units
    float medium_eta; // refractive index of the medium that the path is in, over that where it began
    vec3 direction;   // of that ray
    uint depth;       // segments of the path so far
    vec3 weight;      // flux over the mean flux of a photon, per channel
    uint photon;      // number of the photon to begin next; the path is that of the one before
    uint state;       // FINISHED, UNFINISHED or STUCK
    uint alive;       // 1 if there is a path; 2 if it has met something diffuse; 4 if a lobe was not smooth
    float begin;      // of the ray: contact.glsl
    uint contacts;    // of the ray: contact.glsl
    uint medium;      // of the ray: index into media
    float wavelength; // of the Hue
    float window;     // of the Hue
    float slope;      // of the Hue
    vec3 spread_position; // of the Spread
    float widest;     // of the Hue
    vec3 spread_direction; // of the Spread
    uint pad0;
    vec3 spread_middle; // of the Spread
    uint pad1;
};

Path path_of(PhotonPlace place, Random random) {
    Ray ray = saved_ray(place.origin, place.direction, place.begin, place.contacts, place.medium);
    return Path(ray, place.weight, place.depth, place.medium_eta, random, (place.alive & 2u) != 0u,
                (place.alive & 4u) != 0u, Hue(place.wavelength, place.window, place.slope, place.widest),
                Spread(place.spread_position, place.spread_direction, place.spread_middle));
}

// Keeps a path, whether there is one, the number of the photon to begin next, and the state of the invocation.
PhotonPlace place_of(Path path, bool is_alive, uint photon, uint state) {
    uint alive = (is_alive ? 1u : 0u) | (path.met_diffuse ? 2u : 0u) | (path.met_rough ? 4u : 0u);
    return PhotonPlace(path.ray.origin, path.medium_eta, path.ray.direction, path.depth, path.weight, photon, state, alive,
                       begin_of(path.ray), contacts_of(path.ray), path.ray.medium, path.hue.wavelength, path.hue.window, path.hue.slope,
                       path.spread.position, path.hue.widest, path.spread.direction, 0u, path.spread.middle, 0u);
}

// Takes a path from a surface by a diffuse lobe: the next direction is the same for all wavelengths. A path whose color
// is the mean of all of them has no wavelength any more.
void diffuse_hue(inout Path path) {
    bool is_white = path.hue.window >= 1.0;
    path.hue = is_white ? no_hue() : path.hue;
    path.spread = Spread(is_white ? vec3(0.0) : path.spread.position, vec3(0.0), vec3(0.0));
}
