//! Packing of textures as runs of nodes, and of the materials that use them.
//! `shaders/include/material/texture.glsl` evaluates the nodes.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::Zeroable;
use exr::prelude::f16;
use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::instance::Placed;
use super::material::{pack_materials, specialize};
use super::{PackError, Packer, RevolutionSolver, noise, rows};
use crate::base::input::{Budget, OverBudget};
use crate::image::film::Image;
use crate::kernels::{
    self, FROM_ANGLES, FROM_CYLINDER, FROM_SPACE, FROM_SURFACE, NONE, TEXTURE_BILINEAR, TEXTURE_CHECKS,
    TEXTURE_CONSTANT, TEXTURE_DIRECTION, TEXTURE_DOTS, TEXTURE_FBM, TEXTURE_IMAGE, TEXTURE_MARBLE, TEXTURE_MIX,
    TEXTURE_MULTIPLY, TEXTURE_STACK, TEXTURE_WIND, TEXTURE_WRINKLED, TextureNode, TriangleUvs, WRAP_BLACK, WRAP_CLAMP,
    WRAP_REPEAT,
};
use crate::scene::{
    EmissionImage, ImageTexture, Input, Mapping, Measured, Octaves, Rgb, Scene, Texture, TextureKind, Wrap,
};

/// Maximum number of nodes of one texture; a texture that is used twice in it has its nodes twice.
const MAX_NODES: usize = 1024;
/// Maximum depth of nested textures.
const MAX_DEPTH: usize = 64;

/// pbrt's texture coordinates of a triangle without any.
const DEFAULT_UVS: [DVec2; 3] = [DVec2::ZERO, DVec2::X, DVec2::ONE];

/// How a scene is packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packing {
    /// How rays are intersected with bodies of revolution.
    pub solver: RevolutionSolver,
    /// Whether triangles keep their texture coordinates, even if no texture needs them.
    pub keeps_uvs: bool,
    /// Whether photons begin by a learned density, for which images of lights have other tables.
    pub is_guided: bool,
    /// Whether glass whose index of refraction depends on the wavelength splits light; otherwise it has its mean index.
    pub has_dispersion: bool,
}

impl Default for Packing {
    fn default() -> Self {
        Self { solver: RevolutionSolver::default(), keeps_uvs: false, is_guided: false, has_dispersion: true }
    }
}

impl From<RevolutionSolver> for Packing {
    fn from(solver: RevolutionSolver) -> Self {
        Self { solver, ..Self::default() }
    }
}

/// The packed textures: those that a material or a shape uses.
#[derive(Default)]
pub(super) struct PackedTextures {
    pub nodes: Vec<TextureNode>,
    /// Two texels in each element, of four half floats each; the table of noise, and those of measured
    /// materials.
    pub texels: Vec<[u32; 4]>,
    /// Whether indices of refraction depend on the wavelength.
    pub has_dispersion: bool,
    world_from_render: DAffine3,
    scene: Vec<Texture>,
    /// The scene's budget of memory.
    budget: Arc<Budget>,
    /// First node of each packed texture.
    first: HashMap<usize, u32>,
    /// Node of each constant opacity, by its bits.
    constants: HashMap<u64, u32>,
    /// First texel of each image, by its address.
    images: HashMap<*const Image, u32>,
    /// First element of the table of noise, if a texture uses it.
    noise_table: Option<u32>,
    /// First element of the table of each measured material, by its address.
    measured: HashMap<*const Measured, u32>,
    /// First element of each table of materials, by what it is computed from.
    tables: HashMap<Vec<u64>, u32>,
}

impl PackedTextures {
    pub fn new(scene: &Scene, render_from_world: &DAffine3, has_dispersion: bool) -> Self {
        Self {
            has_dispersion,
            world_from_render: render_from_world.inverse(),
            scene: scene.textures.clone(),
            budget: Arc::clone(&scene.budget),
            ..Self::default()
        }
    }

    /// Returns the number of render units in a scene unit.
    pub fn render_units(&self) -> f64 {
        1.0 / self.world_from_render.matrix3.x_axis.x
    }

    /// Returns a texture's first node and black, or NONE and the constant.
    pub fn color(&mut self, input: &Input<Rgb>) -> Result<(u32, [f32; 3]), PackError> {
        match *input {
            Input::Constant(value) => Ok((NONE, value.as_vec3().to_array())),
            Input::Texture(index) => Ok((self.texture(index)?, [0.0; 3])),
        }
    }

    /// Returns a texture's first node and `None`, or NONE and the constant.
    pub fn number(&mut self, input: &Input<f64>) -> Result<(u32, Option<f64>), PackError> {
        match *input {
            Input::Constant(value) => Ok((NONE, Some(value))),
            Input::Texture(index) => Ok((self.texture(index)?, None)),
        }
    }

    /// Returns the first node of a texture, and adds the texture if it is not packed yet.
    fn texture(&mut self, index: usize) -> Result<u32, PackError> {
        if let Some(first) = self.first.get(&index) {
            return Ok(*first);
        }
        let first = self.run(Input::Texture(index)).map_err(|limit| {
            let location = self.scene[index].location.clone();
            match limit {
                Limit::Nodes => PackError::TextureTooDeep { location },
                Limit::Memory(over) => PackError::OverBudget { location, over },
            }
        })?;
        self.first.insert(index, first);
        Ok(first)
    }

    /// Returns the first node of an opacity; NONE if it is 0 or 1.
    fn opacity(&mut self, alpha: &Input<f64>) -> Result<u32, PackError> {
        let nodes = &mut self.nodes;
        match *alpha {
            // No ray meets a shape with an opacity of 0.
            Input::Constant(0.0 | 1.0) => Ok(NONE),
            Input::Constant(value) => Ok(*self.constants.entry(value.to_bits()).or_insert_with(|| {
                nodes.push(TextureNode { last: 1, ..node(TEXTURE_CONSTANT, [Rgb::splat(value); 4]) });
                nodes.len() as u32 - 1
            })),
            Input::Texture(index) => self.texture(index),
        }
    }

    /// Adds the nodes of an input, and returns the first one.
    fn run(&mut self, input: Input<Rgb>) -> Result<u32, Limit> {
        let first = self.nodes.len();
        let mut run = Run { textures: self, first, height: 0 };
        run.input(input, 0)?;
        if let Some(node) = self.nodes.last_mut() {
            node.last = 1;
        }
        Ok(first as u32)
    }

    fn image(&mut self, image: &Arc<Image>) -> u32 {
        if let Some(first) = self.images.get(&Arc::as_ptr(image)) {
            return *first;
        }
        let first = 2 * self.texels.len() as u32;
        let half = |value: f32| u32::from(f16::from_f32(value.clamp(-HALF_MAX, HALF_MAX)).to_bits());
        let texel = |[r, g, b]: [f32; 3]| [half(r) | half(g) << 16, half(b)];
        self.texels.extend(image.pixels.chunks(2).map(|two| {
            let ([a, b], [c, d]) = (texel(two[0]), texel(*two.last().unwrap_or(&two[0])));
            [a, b, c, d]
        }));
        self.images.insert(Arc::as_ptr(image), first);
        first
    }

    /// Returns the first element of the table of noise, and adds the table if it is not packed yet.
    fn noise_table(&mut self) -> u32 {
        *self.noise_table.get_or_insert_with(|| {
            let first = self.texels.len() as u32;
            self.texels.extend(noise::table());
            first
        })
    }

    /// Returns the first element of the table of a measured material, and adds the table if it is not packed yet.
    pub fn measured(&mut self, measured: &Arc<Measured>, table: impl Fn(&Measured) -> Vec<[u32; 4]>) -> u32 {
        *self.measured.entry(Arc::as_ptr(measured)).or_insert_with(|| {
            let first = self.texels.len() as u32;
            self.texels.extend(table(measured));
            first
        })
    }

    /// Returns the first element of a material's table, and adds the table if it is not packed yet.
    pub fn table(&mut self, key: Vec<u64>, make: impl FnOnce() -> Vec<[u32; 4]>) -> u32 {
        let texels = &mut self.texels;
        *self.tables.entry(key).or_insert_with(|| {
            let first = texels.len() as u32;
            texels.extend(make());
            first
        })
    }

    /// Returns true if a texture needs a stack.
    pub fn has_trees(&self) -> bool {
        self.nodes.iter().any(|node| node.last == 0)
    }

    /// Returns true if a texture has a node of a kind.
    pub fn has(&self, kind: u32) -> bool {
        self.nodes.iter().any(|node| node.kind == kind)
    }

    /// Returns true if a texture sums octaves of noise.
    pub fn has_noise(&self) -> bool {
        [TEXTURE_FBM, TEXTURE_WRINKLED, TEXTURE_WIND, TEXTURE_MARBLE].into_iter().any(|kind| self.has(kind))
    }
}

/// The largest half float.
const HALF_MAX: f32 = 65504.0;

/// The reason why nodes could not be added.
enum Limit {
    /// A texture has too many nodes, or needs too large a stack.
    Nodes,
    /// All textures together take too much memory.
    Memory(OverBudget),
}

/// A texture during packing: each node comes after the nodes whose values it uses.
struct Run<'a> {
    textures: &'a mut PackedTextures,
    first: usize,
    /// Height of the stack after the nodes so far.
    height: u32,
}

impl Run<'_> {
    fn push(&mut self, node: TextureNode, taken: u32) -> Result<(), Limit> {
        self.height = self.height - taken + 1;
        if self.height > TEXTURE_STACK || self.textures.nodes.len() - self.first >= MAX_NODES {
            return Err(Limit::Nodes);
        }
        let bytes = (self.textures.nodes.len() + 1) * size_of::<TextureNode>();
        self.textures.budget.check(bytes as u64).map_err(Limit::Memory)?;
        self.textures.nodes.push(node);
        Ok(())
    }

    fn input(&mut self, input: Input<Rgb>, depth: usize) -> Result<(), Limit> {
        match input {
            Input::Constant(value) => self.push(node(TEXTURE_CONSTANT, [value; 4]), 0),
            Input::Texture(index) if depth < MAX_DEPTH => {
                let texture = self.textures.scene[index].kind.clone();
                self.texture(&texture, depth + 1)
            }
            Input::Texture(_) => Err(Limit::Nodes),
        }
    }

    fn number(&mut self, input: Input<f64>, depth: usize) -> Result<(), Limit> {
        match input {
            Input::Constant(value) => self.input(Input::Constant(Rgb::splat(value)), depth),
            Input::Texture(index) => self.input(Input::Texture(index), depth),
        }
    }

    fn texture(&mut self, texture: &TextureKind, depth: usize) -> Result<(), Limit> {
        match texture {
            TextureKind::Image(image) => {
                let node = self.image(image);
                self.push(node, 0)
            }
            TextureKind::Bilerp { mapping, corners } => {
                let node = self.mapped(mapping, node(TEXTURE_BILINEAR, *corners));
                self.push(node, 0)
            }
            TextureKind::Checkerboard { mapping, textures } => {
                let weight = self.mapped(mapping, node(TEXTURE_CHECKS, [Rgb::ZERO; 4]));
                self.blend(*textures, weight, depth)
            }
            TextureKind::DirectionMix { direction, textures: [along, across] } => {
                let matrix = DMat3::from_cols(*direction, DVec3::ZERO, DVec3::ZERO).transpose();
                let mut weight = node(TEXTURE_DIRECTION, [Rgb::ZERO; 4]);
                weight.to_coordinates = rows(&DAffine3::from_mat3(matrix));
                self.blend([*across, *along], weight, depth)
            }
            TextureKind::Mix { textures, amount } => {
                self.input(textures[0], depth)?;
                self.input(textures[1], depth)?;
                self.number(*amount, depth)?;
                self.push(node(TEXTURE_MIX, [Rgb::ZERO; 4]), 3)
            }
            TextureKind::Scale { texture, factor } => {
                self.input(*texture, depth)?;
                self.number(*factor, depth)?;
                self.push(node(TEXTURE_MULTIPLY, [Rgb::ZERO; 4]), 2)
            }
            TextureKind::Dots { mapping, textures: [inside, outside] } => {
                let first = self.textures.noise_table();
                let weight = TextureNode { first, ..node(TEXTURE_DOTS, [Rgb::ZERO; 4]) };
                self.blend([*outside, *inside], self.mapped(mapping, weight), depth)
            }
            TextureKind::Fbm { mapping, octaves } => self.noise(TEXTURE_FBM, mapping, octaves, 0.0),
            TextureKind::Wrinkled { mapping, octaves } => self.noise(TEXTURE_WRINKLED, mapping, octaves, 0.0),
            TextureKind::Windy { mapping } => self.windy(mapping),
            TextureKind::Marble { mapping, octaves, variation } => {
                self.noise(TEXTURE_MARBLE, mapping, octaves, *variation)
            }
        }
    }

    /// Adds a node that sums octaves of noise.
    fn noise(&mut self, kind: u32, mapping: &Mapping, octaves: &Octaves, variation: f64) -> Result<(), Limit> {
        let values = [octaves.roughness, variation, 0.0, 0.0].map(Rgb::splat);
        let first = self.textures.noise_table();
        let sum = TextureNode { first, width: octaves.count, ..node(kind, values) };
        self.push(self.mapped(mapping, sum), 0)
    }

    /// Adds the product of the strength of the wind and the waves.
    fn windy(&mut self, mapping: &Mapping) -> Result<(), Limit> {
        let octaves = |count| Octaves { count, roughness: 0.5 };
        let coarse = match *mapping {
            Mapping::Space(from_world) => Mapping::Space(DAffine3::from_scale(DVec3::splat(0.1)) * from_world),
            other => other,
        };
        self.noise(TEXTURE_WIND, &coarse, &octaves(3), 0.0)?;
        self.noise(TEXTURE_FBM, mapping, &octaves(6), 0.0)?;
        self.push(node(TEXTURE_MULTIPLY, [Rgb::ZERO; 4]), 2)
    }

    /// Adds the mix of two inputs by a node's weight; a single node if both inputs are constant.
    fn blend(&mut self, inputs: [Input<Rgb>; 2], mut weight: TextureNode, depth: usize) -> Result<(), Limit> {
        if let [Input::Constant(a), Input::Constant(b)] = inputs {
            weight.values = [a, b, a, b].map(four);
            return self.push(weight, 0);
        }
        self.input(inputs[0], depth)?;
        self.input(inputs[1], depth)?;
        weight.values = [Rgb::ZERO, Rgb::ONE, Rgb::ZERO, Rgb::ONE].map(four);
        self.push(weight, 0)?;
        self.push(node(TEXTURE_MIX, [Rgb::ZERO; 4]), 3)
    }

    fn image(&mut self, texture: &ImageTexture) -> TextureNode {
        let [least, most] = texture.range;
        let values = [texture.offset, texture.factor, least, most].map(Rgb::splat);
        let image = TextureNode {
            first: self.textures.image(&texture.image),
            width: texture.image.width,
            height: texture.image.height,
            wrap: match texture.wrap {
                Wrap::Repeat => WRAP_REPEAT,
                Wrap::Clamp => WRAP_CLAMP,
                Wrap::Black => WRAP_BLACK,
            },
            nearest: u32::from(texture.nearest),
            ..node(TEXTURE_IMAGE, values)
        };
        self.mapped(&texture.mapping, image)
    }

    fn mapped(&self, mapping: &Mapping, node: TextureNode) -> TextureNode {
        let world = self.textures.world_from_render;
        let (from, to_coordinates) = match mapping {
            Mapping::Surface(from_uv) => (FROM_SURFACE, *from_uv),
            Mapping::Space(from_world) => (FROM_SPACE, *from_world * world),
            Mapping::Spherical(from_world) => (FROM_ANGLES, *from_world * world),
            Mapping::Cylindrical(from_world) => (FROM_CYLINDER, *from_world * world),
        };
        TextureNode { from, to_coordinates: rows(&to_coordinates), ..node }
    }
}

fn node(kind: u32, values: [Rgb; 4]) -> TextureNode {
    TextureNode { kind, values: values.map(four), ..TextureNode::zeroed() }
}

fn four(value: Rgb) -> [f32; 4] {
    let most = f64::from(f32::MAX);
    value.clamp(Rgb::splat(-most), Rgb::splat(most)).extend(0.0).as_vec4().to_array()
}

impl Packer {
    /// Packs materials and the textures in use, and sets the shapes' indices of packed materials and of
    /// emission images. A material is packed once more for each opacity of the shapes that have it.
    pub(super) fn dress(&mut self, scene: &Scene, placed: &mut Placed) -> Result<(), PackError> {
        self.materials = pack_materials(&scene.materials, &mut self.textures)?;
        let mut places: HashMap<(usize, u32), usize> = HashMap::new();
        for shape in placed.shapes_mut() {
            if let Some(image) = shape.emission.as_ref().and_then(|emission| emission.image) {
                let texture = self.textures.texture(image.texture)? as usize;
                if let Some(emission) = &mut shape.to_mut().emission {
                    emission.image = Some(EmissionImage { texture, ..image });
                }
            }
            let alpha_texture = self.textures.opacity(&shape.alpha)?;
            if alpha_texture != NONE {
                let material = kernels::Material { alpha_texture, ..self.materials[shape.material] };
                shape.to_mut().material = *places.entry((shape.material, alpha_texture)).or_insert_with(|| {
                    self.materials.push(material);
                    self.materials.len() - 1
                });
            }
        }
        self.keeps_uvs |= !self.textures.nodes.is_empty() || specialize(&self.materials).has_anisotropic;
        Ok(())
    }

    /// Adds the texture coordinates of a triangle, if a texture or a material needs them.
    pub(super) fn add_uvs(&mut self, uvs: &[DVec2], corners: [usize; 3], order: [usize; 3]) {
        if self.keeps_uvs {
            let uv = |i: usize| {
                let corner = order[i];
                uvs.get(corners[corner]).unwrap_or(&DEFAULT_UVS[corner]).as_vec2().to_array()
            };
            self.triangle_uvs.push(TriangleUvs { uv0: uv(0), uv1: uv(1), uv2: uv(2), pad: [0.0; 2] });
        }
    }
}
