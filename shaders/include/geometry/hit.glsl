// Where a ray meets a surface.

struct Hit {
    float t;          // in lengths of the ray's direction
    uint primitive;   // reference, or NONE
    vec2 barycentric; // weights of p1 and p2 of a triangle; in x: where on a profile's piece
    uint instance;    // that it is in, or NONE
};
