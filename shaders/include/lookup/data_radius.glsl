// Radii from the data: what a pixel keeps of the photons on its discs, and the radius that follows.
//
// If the density of photons at the distance d from the centre of a disc is p (1 + c d^2), its mean over the disc is
// p (1 + c r^2 / 2), and the outer half of the disc's area has n c r^2 / 4 photons more than the inner half, of n. So
// the relative bias is k r^2 with k = 2 (outer - inner) / (n r^2). With p photons per squared radius and iteration,
// the relative squared error after i iterations with discs of squared radius x is (k x)^2 + 1 / (p x i). It is least
// where x^3 = 1 / (2 k^2 p i). That x falls as i^(-1/3), as the radii of the other schedules do.
//
// Balancing the bias against the noise: Kaplanyan and Dachsbacher 2013, "Adaptive Progressive Photon Mapping". Testing
// how photons are spread over parts of a disc: Lin and others 2020, "CPPM: Chi-squared Progressive Photon Mapping".
#include "lookup/records.glsl"
#include "scene/features.glsl"

// A squared radius is that of the global schedule times a factor in this range. So it tends to 0, while a disc finds
// ever more photons, whatever the photons say.
const float LEAST_FACTOR = 0.125;
const float LARGEST_FACTOR = 8.0;
// The least square of the difference between outer and inner photons, over its mean where the density is even.
const float LEAST_SIGNAL = 0.1;

// What a pixel keeps of its discs: the words of PixelState in another meaning. An iteration adds to each sum; sums
// of floats, in the order of the iterations.
struct DiscSums {
    float found;  // photons
    float excess; // photons on the outer halves less those on the inner halves
    float reach;  // squared radius times photons, squared render units
    float area;   // squared radius, squared render units
};

DiscSums disc_sums(PixelState state) {
    return DiscSums(uintBitsToFloat(state.found_low), uintBitsToFloat(state.found_high), state.shrink, state.rest);
}

PixelState state_of(DiscSums sums) {
    return PixelState(floatBitsToUint(sums.found), floatBitsToUint(sums.excess), sums.reach, sums.area);
}

// What a pixel keeps before its first iteration.
PixelState first_state() {
    if (HAS_DATA_RADII) {
        return state_of(DiscSums(0.0, 0.0, 0.0, 0.0));
    }
    return PixelState(0u, 0u, 1.0, 0.0);
}

// Adds the photons of an iteration, of which `inner` are on the inner half of the disc. `kept` is the share of the
// sums before it that stays.
void add_disc(inout DiscSums sums, uint count, uint inner, float radius2, float kept) {
    uint outer = count - inner;
    float excess = outer > inner ? float(outer - inner) : -float(inner - outer);
    sums.found = kept * sums.found + float(count);
    sums.excess = kept * sums.excess + excess;
    sums.reach = kept * sums.reach + float(count) * radius2;
    sums.area = kept * sums.area + radius2;
}

// Sums over several pixels, with squared radii in a unit of the caller.
struct DiscPool {
    float found;
    float excess2; // squared excess
    float reach2;  // squared reach
    float area;
};

void add_pixel(inout DiscPool pool, DiscSums sums, float unit) {
    float reach = sums.reach / unit;
    pool.found += sums.found;
    pool.excess2 += sums.excess * sums.excess;
    pool.reach2 += reach * reach;
    pool.area += sums.area / unit;
}

// The factor of the squared radius of the global schedule, which is the pool's unit, in the last of so many
// iterations. Where the density is even, the mean of a squared excess is the number of photons: it is noise.
float factor_of(DiscPool pool, float iterations) {
    if (!(pool.reach2 > 0.0)) {
        return LARGEST_FACTOR;
    }
    float signal = max(pool.excess2 - pool.found, LEAST_SIGNAL * pool.found);
    float bias2 = 4.0 * signal / pool.reach2;
    float density = pool.found / pool.area;
    return clamp(pow(2.0 * bias2 * density * iterations, -1.0 / 3.0), LEAST_FACTOR, LARGEST_FACTOR);
}
