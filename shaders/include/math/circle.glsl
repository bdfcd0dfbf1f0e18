// The cosine and the sine of an angle, to the last digits of fp32 on every device: Vulkan lets those of GLSL err
// by 2^-11, and SwiftShader's do by 1e-4.

// (cos, sin) of an angle between -8 and 8, with errors below 2^-23.
vec2 circle_point(float angle) {
    // The nearest quarter of a turn, and what is left: at most pi / 4. Two parts of pi / 2, of which the first has few
    // digits, so that its multiples are exact (Cody and Waite, "Software Manual for the Elementary Functions",
    // 1980, section 8).
    float quarter = roundEven(angle * 0.636619772);
    float x = (angle - quarter * 1.5703125) - quarter * 4.83826794897e-4;
    // Taylor's polynomials: the terms left out are below 2.5e-8.
    float x2 = x * x;
    float sine = x + x * x2 * (-1.0 / 6.0 + x2 * (1.0 / 120.0 + x2 * (-1.0 / 5040.0 + x2 * (1.0 / 362880.0))));
    float cosine = 1.0 + x2 * (-0.5 + x2 * (1.0 / 24.0 + x2 * (-1.0 / 720.0 + x2 * (1.0 / 40320.0))));
    int turns = int(quarter);
    vec2 point = (turns & 1) == 0 ? vec2(cosine, sine) : vec2(-sine, cosine);
    return (turns & 2) == 0 ? point : -point;
}
