// The scene: set 0 of every kernel that traces rays. The build script makes from this list the structs
// that hold the arrays on the host and on the device, the upload, the count of bytes, and what the
// identity of a render digests. The first word of each line says what the array tells of: shapes,
// materials, media or lights; `derived` ones follow from the others. A checkpoint's digests take arrays in
// the order of their lines: append to a part, and old checkpoints of scenes that have the array are
// refused.
#include "scene/constants.glsl"
#include "scene/info.glsl"
#include "scene/lights.glsl"
#include "scene/materials.glsl"
#include "scene/media.glsl"
#include "scene/primitives.glsl"
#include "scene/revolutions.glsl"

// What there is besides the arrays; one.
TEXELS(SceneInfo, scene_info)
// A kernel reads it once, at its start: llvmpipe takes nothing out of loops. Nothing writes it later.
SceneInfo scene = scene_info_at(0u);

// Bounding volume hierarchies: BVH_PLANES of each inner node, of four children each. The scene's root is
// the first node. None where there is no surface.
SCENE_TEXELS(derived, vec4, bvh_planes)
SCENE_TEXELS(derived, uvec4, bvh_children) // references to the children of inner nodes
SCENE_TEXELS(shapes, Triangle, triangles) // of all meshes, in the order of the leaves
SCENE_TEXELS(shapes, TriangleNormals, triangle_normals) // of those triangles that have shading normals
SCENE_TEXELS(shapes, TriangleUvs, triangle_uvs) // of all triangles, or of none if nothing asks for them
SCENE_TEXELS(shapes, Quadric, quadrics) // spheres and disks
SCENE_TEXELS(shapes, Revolution, revolutions) // bodies of revolution
SCENE_TEXELS(shapes, RevolutionPiece, revolution_pieces) // the stretches of their profiles
SCENE_TEXELS(shapes, Instance, instances) // places of objects that have hierarchies of their own
// Whole segments of profiles; empty but for the classical solver.
SCENE_BUFFER(derived, RevolutionSegment, revolution_segments)
// Vertices of the segments' approximations.
SCENE_BUFFER(derived, NewtonStart, newton_starts)
// Materials: the scene's, then those of surfaces that are not all there.
SCENE_TEXELS(materials, Material, materials)
SCENE_TEXELS(materials, TextureNode, texture_nodes) // each after the nodes that it is made of
SCENE_TEXELS(materials, uvec4, texture_texels) // texels of images: two in each, of four half floats; tables of noise, of coats and of measured materials
// Media: the first is the vacuum. None where nothing absorbs light on its way.
SCENE_TEXELS(media, Medium, media)
SCENE_TEXELS(media, MediumInterface, medium_interfaces) // of each material
// Lights: skies first, then others that are no surface, then every emitting primitive.
SCENE_TEXELS(lights, Light, lights)
SCENE_TEXELS(lights, LightImage, light_images) // the images of lights that have one
SCENE_TEXELS(lights, LightTexel, light_texels) // their rows and texels
SCENE_TEXELS(derived, AliasEntry, emission_table) // chooses lights for photons, by power
SCENE_TEXELS(derived, AliasEntry, direct_table) // chooses lights for next-event estimation
