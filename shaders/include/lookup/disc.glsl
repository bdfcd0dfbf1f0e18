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
