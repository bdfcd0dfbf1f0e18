// A photon counts for a visible point if it lies on the same surface: the angle between the normals is
// below 60 degrees, and the distance from the tangent plane below MAX_HEIGHT radii. So light does not
// leak through thin walls or around corners.
const float MIN_COSINE = 0.5;
const float MAX_HEIGHT = 0.25;

// Whether a photon within the radius of a visible point is on its disc; d is the photon's position less
// the point's, n the point's normal.
bool is_on_disc(vec3 d, vec3 photon_normal, vec3 n, float radius2) {
    float height = dot(d, n);
    return dot(n, photon_normal) > MIN_COSINE && height * height < MAX_HEIGHT * MAX_HEIGHT * radius2;
}

// Whether a photon on the disc of a visible point is on the inner half of the disc's area.
bool is_inner(vec3 d, float radius2) {
    return dot(d, d) < 0.5 * radius2;
}
