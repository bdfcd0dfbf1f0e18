// The camera.

// Cells of the pixel filter along an axis, of which a sample takes any with the same chance. With
// this number, a few cells are in the negative lobes of a filter.
export const uint FILTER_CELLS = 1023u;

// A camera with a thin lens. Camera space: x right, y up, z forward.
struct Camera {
    vec4 render_from_camera[3]; // rows
    vec2 image_lower;           // where the image begins: left, top; projection.glsl
    vec2 image_extent;          // where it ends, less the beginning
    float lens_radius;          // camera units; 0 is a pinhole
    float focal_distance;       // camera units
    uint width;                 // pixels in a row
    uint height;                // rows
};
