// The point of an eye path at which photons on rough surfaces are gathered: one of its rough vertices, each with the
// same chance, so that the number of vertices is the factor of its light.
#include "lookup/rough.glsl"
#include "scene/features.glsl"

UPDATED_TEXELS(RoughPoint, rough_points) // of the last path of each pixel

// Chooses the point of a path that has met a surface: with the same chance this one or any before. `met` becomes the
// number of rough surfaces so far; u is uniform in [0, 1).
void choose_rough_point(inout RoughPoint chosen, inout uint met, RoughPoint point, bool is_rough, float u) {
    if (is_rough) {
        met++;
        if (u * float(met) < 1.0) {
            chosen = point;
        }
    }
}

// Keeps the point of a segment's end, if there is one.
void keep_rough_point(RoughPoint point, uint pixel) {
    if (point.path_length > 0.0) {
        store_rough_points(pixel, point);
    }
}

// Completes the point of a path that has met `met` rough surfaces.
void finish_rough_point(uint pixel, uint met) {
    RoughPoint point = no_rough_point();
    if (met > 0u) {
        point = rough_points_at(pixel);
        point.throughput *= float(met);
    }
    store_rough_points(pixel, point);
}
