// Textures: values that vary over surfaces. Kernels of scenes without textures leave out this code.
#include "geometry/quadric.glsl"
#include "geometry/surface_point.glsl"
#include "material/noise.glsl"
#include "math/sampling.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// Wraps the coordinate of a texel; -1 stands for black.
int wrap_coordinate(int i, int size, uint wrap) {
    if (wrap == WRAP_REPEAT) {
        i = i < 0 ? i + size : i >= size ? i - size : i;
    } else if (wrap != WRAP_CLAMP && (i < 0 || i >= size)) {
        return -1;
    }
    // Coordinates that are NaN convert to any integer.
    return clamp(i, 0, size - 1);
}

vec3 texel(TextureNode image, int x, int y) {
    x = wrap_coordinate(x, int(image.width), image.wrap);
    y = wrap_coordinate(y, int(image.height), image.wrap);
    if (min(x, y) < 0) {
        return vec3(0.0);
    }
    uint at = image.first + uint(y) * image.width + uint(x);
    uvec4 pair = texture_texels_at(at >> 1u);
    uvec2 halves = (at & 1u) != 0u ? pair.zw : pair.xy;
    return vec3(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y).x);
}

// Interpolates an image at coordinates with (0, 0) at its lower left corner; its first row is the top.
vec3 sample_image_texture(TextureNode image, vec2 at) {
    at.y = 1.0 - at.y;
    // Farther outside, all coordinates have the value of the edge, or black.
    at = image.wrap == WRAP_REPEAT ? fract(at) : clamp(at, -1.0, 2.0);
    vec2 place = at * vec2(image.width, image.height) - 0.5;
    vec2 corner = floor(place);
    vec2 weight = place - corner;
    weight = image.nearest != 0u ? floor(weight + 0.5) : weight;
    int x = int(corner.x);
    int y = int(corner.y);
    vec3 upper = mix(texel(image, x, y), texel(image, x + 1, y), weight.x);
    vec3 lower = mix(texel(image, x, y + 1), texel(image, x + 1, y + 1), weight.x);
    vec3 value = image.values[0].xyz + image.values[1].xyz * mix(upper, lower, weight.y);
    return clamp(value, image.values[2].xyz, image.values[3].xyz);
}

vec3 texture_coordinates(TextureNode node, Surface surface) {
    vec3 p = node.from == FROM_SURFACE ? vec3(surface.uv, 0.0) : surface.position;
    vec3 at = transform_point(node.to_coordinates, p);
    if (node.from == FROM_ANGLES) {
        return vec3(atan(length(at.xy), at.z) / PI, azimuth(at.xy) / (2.0 * PI), 0.0);
    }
    if (node.from == FROM_CYLINDER) {
        return vec3(0.5 + atan(at.y, at.x) / (2.0 * PI), at.z, 0.0);
    }
    return at;
}

// The value of a node without operands.
vec3 node_value(TextureNode node, Surface surface) {
    vec3 at = texture_coordinates(node, surface);
    if (HAS_IMAGE_TEXTURES && node.kind == TEXTURE_IMAGE) {
        return sample_image_texture(node, at.xy);
    }
    if (HAS_NOISE) {
        if (node.kind >= TEXTURE_FBM) {
            return noise_value(node, at);
        }
    }
    vec2 weight = node.kind == TEXTURE_BILINEAR ? at.xy : vec2(0.0);
    if (node.kind == TEXTURE_CHECKS) {
        vec3 cell = floor(at);
        weight.x = mod(cell.x + cell.y + cell.z, 2.0);
    }
    if (HAS_DOTS) {
        if (node.kind == TEXTURE_DOTS) {
            weight.x = is_in_dot(node.first, at.xy) ? 1.0 : 0.0;
        }
    }
    if (node.kind == TEXTURE_DIRECTION) {
        weight.x = min(abs(dot(node.to_coordinates[0].xyz, surface.normal)), 1.0);
    }
    vec3 lower = mix(node.values[0].xyz, node.values[1].xyz, weight.x);
    vec3 upper = mix(node.values[2].xyz, node.values[3].xyz, weight.x);
    return mix(lower, upper, weight.y);
}

// Evaluates a texture of several nodes on a stack, from its first node on.
vec3 run_texture(uint first, Surface surface) {
    vec3 stack[TEXTURE_STACK];
    uint height = 0u;
    bool more = true;
    for (uint i = first; more; i++) {
        TextureNode node = texture_nodes_at(i);
        more = node.last == 0u;
        vec3 value;
        if (node.kind == TEXTURE_MULTIPLY) {
            height -= 2u;
            value = stack[height] * stack[height + 1u];
        } else if (node.kind == TEXTURE_MIX) {
            height -= 3u;
            value = mix(stack[height], stack[height + 1u], stack[height + 2u]);
        } else {
            value = node_value(node, surface);
        }
        stack[height++] = value;
    }
    return stack[0];
}

// The value of a texture at a point of a surface, or the constant where the texture is NONE. Textures of
// numbers have their value in x.
vec3 textured(uint first, vec3 constant, Surface surface) {
    if (HAS_TEXTURES && first != NONE) {
        if (HAS_TEXTURE_TREES) {
            return run_texture(first, surface);
        }
        return node_value(texture_nodes_at(first), surface);
    }
    return constant;
}

// The color of a material: a reflectance or transmittance, in [0, 1].
vec3 color_at(Material material, Surface surface) {
    if (HAS_TEXTURES) {
        return clamp(textured(material.color_texture, material.color, surface), 0.0, 1.0);
    }
    return material.color;
}

// Alpha of a surface at a point: the probability that a ray meets it, in [0, 1].
float opacity(Surface surface) {
    if (HAS_ALPHA) {
        return clamp(textured(materials_at(surface.material).alpha_texture, vec3(1.0), surface).x, 0.0, 1.0);
    }
    return 1.0;
}
