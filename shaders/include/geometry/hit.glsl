// The point at which a ray meets a primitive.

struct Hit {
    float t;          // ray parameter, in lengths of the ray's direction
    uint primitive;   // primitive reference, or NONE
    vec2 barycentric; // triangle: weights of p1 and p2; body of revolution: parameter of the piece, in x
    uint instance;    // instance that contains the primitive, or NONE
};
