// How a pixel's squared radius shrinks by the photons that it finds.
//
// Hachisuka and Jensen 2009, eq. 6 and 7, keep alpha of every iteration's photons: of all that
// were found, N = alpha * found. With counts that are exact, N does not drift. After a million
// iterations the radius changes by a few roundings a step, so the product of the steps keeps
// what rounding leaves out of it (Kahan 1965).
#include "lookup/records.glsl"

void shrink_radius(inout PixelState state, uint count, float alpha) {
    float found = float(count);
    float before = alpha * (float(state.found_high) * 4294967296.0 + float(state.found_low));
    float all = before + found;
    float kept = (before + alpha * found) / all;
    // One less `kept`, without cancellation.
    float lost = (1.0 - alpha) * found / all;
    precise float change = state.rest - state.shrink * lost;
    precise float shrink = state.shrink + change;
    precise float rest = change - (shrink - state.shrink);
    // Where little is kept, it is the difference that would lose digits.
    bool little = kept < 0.5;
    state.shrink = little ? state.shrink * kept : shrink;
    state.rest = little ? state.rest * kept : rest;
    state.found_low += count;
    state.found_high += state.found_low < count ? 1u : 0u;
}
