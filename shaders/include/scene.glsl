// The scene: set 0 of every kernel that traces rays.
#include "types.glsl"
#include "specialization.glsl"

layout(std430, set = 0, binding = 0) readonly buffer SceneBlock { SceneInfo value; } scene_info;
layout(std430, set = 0, binding = 1) readonly buffer PairBlock { BvhPair data[]; } bvh_pairs;
layout(std430, set = 0, binding = 2) readonly buffer PrimitiveBlock { uint data[]; } primitives;
layout(std430, set = 0, binding = 3) readonly buffer TriangleBlock { Triangle data[]; } triangles;
layout(std430, set = 0, binding = 4) readonly buffer NormalBlock { TriangleNormals data[]; } triangle_normals;
layout(std430, set = 0, binding = 5) readonly buffer QuadricBlock { Quadric data[]; } quadrics;
layout(std430, set = 0, binding = 6) readonly buffer MaterialBlock { Material data[]; } materials;
layout(std430, set = 0, binding = 7) readonly buffer LightBlock { Light data[]; } lights;
layout(std430, set = 0, binding = 8) readonly buffer EmissionBlock { AliasEntry data[]; } emission_table;
layout(std430, set = 0, binding = 9) readonly buffer DirectBlock { AliasEntry data[]; } direct_table;
layout(std430, set = 0, binding = 10) readonly buffer RevolutionBlock { Revolution data[]; } revolutions;
layout(std430, set = 0, binding = 11) readonly buffer PieceBlock { RevolutionPiece data[]; } revolution_pieces;
layout(std430, set = 0, binding = 12) readonly buffer SegmentBlock { RevolutionSegment data[]; } revolution_segments;
layout(std430, set = 0, binding = 13) readonly buffer StartBlock { NewtonStart data[]; } newton_starts;
