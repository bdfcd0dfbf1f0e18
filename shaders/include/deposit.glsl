// A photon's weight on a visible point, for every way to find the points that it reaches.
// The kernel binds flux_low, flux_high and counters.

// A photon belongs to the visible point's own surface when their normals agree to within
// 60 degrees and it is this near the tangent plane, in radii: light must not leak through
// thin walls and around corners.
const float MIN_COSINE = 0.5;
const float MAX_HEIGHT = 0.25;

// Whether a photon inside a point's sphere is on its disc; d points from it to the photon.
bool is_on_disc(vec3 d, vec3 photon_normal, vec3 n, float radius2) {
    float height = dot(d, n);
    return dot(n, photon_normal) > MIN_COSINE && height * height < MAX_HEIGHT * MAX_HEIGHT * radius2;
}

void add_channel(uint index, uvec2 fixed_point) {
    uint low = atomicAdd(flux_low.data[index], fixed_point.x);
    uint high = fixed_point.y + (low + fixed_point.x < low ? 1u : 0u);
    if (high > 0u) {
        uint before = atomicAdd(flux_high.data[index], high);
        if (before + high < before) {
            atomicAdd(counters.value.saturated, 1u);
        }
    }
}

void deposit(uint pixel, uvec2 red, uvec2 green, uvec2 blue) {
    add_channel(4u * pixel, red);
    add_channel(4u * pixel + 1u, green);
    add_channel(4u * pixel + 2u, blue);
    atomicAdd(flux_low.data[4u * pixel + 3u], 1u);
}
