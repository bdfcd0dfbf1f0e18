// The scene: set 0 of every kernel that traces rays.
#include "scene/types.glsl"
#include "scene/specialization.glsl"

TEXELS(0, 0, SceneInfo, scene_info)
// A kernel that asks for it reads it once, at its start: llvmpipe takes nothing out of loops.
SceneInfo scene;
TEXELS(0, 1, BvhPair, bvh_pairs)
TEXELS(0, 2, uint, primitives)
TEXELS(0, 3, Triangle, triangles)
TEXELS(0, 4, TriangleNormals, triangle_normals)
TEXELS(0, 5, Quadric, quadrics)
TEXELS(0, 6, Material, materials)
TEXELS(0, 7, Light, lights)
TEXELS(0, 8, AliasEntry, emission_table)
TEXELS(0, 9, AliasEntry, direct_table)
TEXELS(0, 10, Revolution, revolutions)
TEXELS(0, 11, RevolutionPiece, revolution_pieces)
TEXELS(0, 20, LightImage, light_images)
TEXELS(0, 21, LightTexel, light_texels)
TEXELS(0, 24, Instance, instances)
TEXELS(0, 16, TextureNode, texture_nodes)
TEXELS(0, 17, uvec4, texture_texels) // two in each, of four half floats
TEXELS(0, 18, TriangleUvs, triangle_uvs) // of all triangles, or of none
// Only a research solver reads these.
layout(std430, set = 0, binding = 12) readonly buffer SegmentBlock { RevolutionSegment data[]; } revolution_segments;
layout(std430, set = 0, binding = 13) readonly buffer StartBlock { NewtonStart data[]; } newton_starts;
