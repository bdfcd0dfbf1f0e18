// Shrinks the squared radius of a pixel by the number of photons that it has found.
//
// Hachisuka and Jensen 2009, equations 6 and 7, keep the share alpha of each iteration's photons: N is
// alpha times the number of all photons found. The counts are integers, so N does not drift. After a
// million iterations, a step changes the radius by a few roundings only; the product of the steps
// therefore carries its rounding error along (Kahan 1965).
#include "lookup/records.glsl"

void shrink_radius(inout PixelState state, uint count, float alpha) {
    float found = float(count);
    float before = alpha * (float(state.found_high) * 4294967296.0 + float(state.found_low));
    float all = before + found;
    float kept = (before + alpha * found) / all;
    // 1 - kept, without cancellation.
    float lost = (1.0 - alpha) * found / all;
    precise float change = state.rest - state.shrink * lost;
    precise float shrink = state.shrink + change;
    precise float rest = change - (shrink - state.shrink);
    // If `kept` is small, the difference would lose digits: multiply instead.
    bool little = kept < 0.5;
    state.shrink = little ? state.shrink * kept : shrink;
    state.rest = little ? state.rest * kept : rest;
    state.found_low += count;
    state.found_high += state.found_low < count ? 1u : 0u;
}
