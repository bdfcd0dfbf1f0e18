// Bodies of revolution: revolution.glsl.

// Pieces come in groups of this size, with a ring around all.
export const uint GROUP = 4u;
// Pieces of a body, at most: masks have a bit for each group and each piece.
export const uint MAX_PIECES = 128u;
// Coefficients of the square of a radius or height of degree 8.
export const uint NEWTON_COEFFICIENTS = 17u;

// A body of revolution about z, in unit space: radii up to 1, heights in [-1, 1]; or a part
// of one, where its profile has many pieces.
struct Revolution {
    vec4 unit_from_render[3]; // rows
    vec4 render_from_unit[3]; // rows
    uint first_piece;  // into revolution_pieces
    uint piece_count;  // up to MAX_PIECES
    uint material;     // index into materials, and its layer
    uint flipped;      // 1 where the normal is reversed
    vec3 lower;        // lower corner of its box, render units
    float determinant; // of render_from_unit, positive
    vec3 upper;        // upper corner of its box
    uint pad;
};

// A stretch of a profile (u, v) = (radius, height) on which both are monotone, as
// polynomials in x in [-1, 1].
struct RevolutionPiece {
    vec4 ring;       // least and most height, squares of least and most radius; all widened
    vec4 group_ring; // the same of the group that begins here, if one does
    vec4 ends;       // u, v at x = -1 and at x = 1; neighbours share them to the bit
    vec2 curvature;  // bounds of |u''| and |v''|
    vec2 along;      // parameter of the whole profile at x = -1 and at x = 1, in [0, 1]
    uint body;       // index into revolutions
    uint light;      // index into lights, or NONE
    vec2 pad;
    vec4 coefficients[5]; // of u, v by powers of x: 0 and 1, 2 and 3, .., 8
};

// A whole segment of a profile, for the classical solver: newton.glsl.
struct RevolutionSegment {
    uint body;        // index into revolutions
    uint degree;      // of u^2 and v^2: twice the segment's own
    uint first_piece; // index of its first piece in revolution_pieces
    uint piece_count; // number of its pieces
    uint first_start; // index of its first vertex in newton_starts
    uint start_count; // number of its vertices
    vec2 along;       // parameter of the whole profile at t = 0 and at t = 1, in [0, 1]
    vec4 powers[NEWTON_COEFFICIENTS]; // by powers of t in [0, 1]: coefficients of u^2, v^2, u, v
};

// A vertex of a piecewise linear approximation of a segment. Where t falls from one vertex
// to the next, another approximation begins.
struct NewtonStart {
    vec2 point; // u, v
    float t;    // parameter of the segment, in [0, 1]
    float pad;
};
