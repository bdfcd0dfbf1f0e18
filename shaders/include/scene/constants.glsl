// Numbers that everything uses.

// No index.
export const uint NONE = 0xffffffffu;
const float INFINITY_T = 3.0e38; // t of a ray that nothing bounds
// Half a unit in the last place of 1: the largest relative rounding error.
const float ROUNDING = 5.9604644775390625e-8; // 2^-24
// Texels in a row of an image that holds an array.
export const uint TEXELS_PER_ROW = 4096u;
