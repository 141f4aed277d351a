//! Scene → GPU memory.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::caps::Own;
use super::{GpuMaterial, GpuPart, GpuPrimitive, GpuScene};
use crate::gpu::{Gpu, GpuError, SharedLayouts};
use crate::math::color::{linear_from_srgb, srgb_from_linear};
use crate::passes::{MaterialUniform, PartFacts};
use crate::scene::cut::tinted;
use crate::scene::{
    AlphaMode, Arrangement, Cut, Image, Material, Mip, Parametrization, Part, PartStyle, Presence, Primitive, Scene,
    SceneStats, Solids, TextureRef, Wrap,
};

/// How many scenes have been uploaded.
static UPLOADS: AtomicU64 = AtomicU64::new(0);
/// Bit that says: the vertex normals oppose the winding (as in `scene/instance.wgsl`).
const OPPOSED: u32 = 0x8000_0000;

/// Puts elements into a pseudo-random order that depends only on the seed.
pub(super) fn shuffle<T>(elements: &mut [T], seed: u64) {
    let mut state = seed ^ 0x9E37_79B9_7F4A_7C15;
    for i in (1..elements.len()).rev() {
        // SplitMix64.
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        elements.swap(i, ((z ^ (z >> 31)) % (i as u64 + 1)) as usize);
    }
}

/// Triangles turned so that each begins with a vertex of its own, and for every new vertex the old one it copies.
pub(super) struct Numbered {
    pub(super) triangles: Vec<[u32; 3]>,
    /// Old index of every vertex; the first ones are the old vertices themselves.
    pub(super) sources: Vec<u32>,
    /// Number (and flags) that each vertex carries.
    pub(super) numbers: Vec<u32>,
}

fn opposes(primitive: &Primitive, triangle: [u32; 3]) -> bool {
    let at = |i: u32| glam::Vec3::from(primitive.positions[i as usize]).as_dvec3();
    let normal = |i: u32| glam::Vec3::from(primitive.normals[i as usize]).as_dvec3();
    let [a, b, c] = triangle;
    let winding = (at(b) - at(a)).cross(at(c) - at(a));
    (normal(a) + normal(b) + normal(c)).dot(winding) < 0.0
}

/// Gives every triangle a first vertex of its own that carries `first + its index`.
fn number(primitive: &Primitive, first: u32) -> Numbered {
    let carried = |i: usize, triangle| (first + i as u32) | if opposes(primitive, triangle) { OPPOSED } else { 0 };
    number_with(&primitive.triangles, primitive.positions.len(), carried)
}

/// The same from 0, for triangles whose normals agree with their winding.
pub(super) fn number_triangles(triangles: &[[u32; 3]], vertices: usize) -> Numbered {
    number_with(triangles, vertices, |i, _| i as u32)
}

fn number_with(triangles: &[[u32; 3]], count: usize, carried: impl Fn(usize, [u32; 3]) -> u32) -> Numbered {
    let mut taken = vec![false; count];
    let mut sources: Vec<u32> = (0..count as u32).collect();
    let mut numbers = vec![0; count];
    let triangles = triangles
        .iter()
        .enumerate()
        .map(|(i, &triangle)| {
            let carried = carried(i, triangle);
            match (0..3).find(|&corner| !taken[triangle[corner] as usize]) {
                Some(corner) => {
                    let vertex = triangle[corner] as usize;
                    taken[vertex] = true;
                    numbers[vertex] = carried;
                    [triangle[corner], triangle[(corner + 1) % 3], triangle[(corner + 2) % 3]]
                }
                None => {
                    sources.push(triangle[0]);
                    numbers.push(carried);
                    [sources.len() as u32 - 1, triangle[1], triangle[2]]
                }
            }
        })
        .collect();
    Numbered { triangles, sources, numbers }
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Place {
    position: [f32; 3],
    number: u32,
}

/// A vertex of the first stream.
pub(super) fn place(position: [f32; 3], number: u32) -> Place {
    Place { position, number }
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Extras {
    color: [f32; 4],
    uv: [f32; 4],
    tangent: [f32; 4],
}

fn upload_primitive(
    gpu: &Gpu,
    primitive: &Primitive,
    (needs_extras, parametrization): (bool, Option<Parametrization>),
    first: u32,
    shuffled: Option<u64>,
) -> Result<GpuPrimitive, GpuError> {
    let mut numbered = number(primitive, first);
    if let Some(seed) = shuffled {
        shuffle(&mut numbered.triangles, seed);
    }
    let sources = || numbered.sources.iter().map(|&s| s as usize);
    let places: Vec<Place> = sources()
        .zip(&numbered.numbers)
        .map(|(s, &number)| Place { position: primitive.positions[s], number })
        .collect();
    let normals: Vec<[f32; 3]> = sources().map(|s| primitive.normals[s]).collect();
    let vertex = wgpu::BufferUsages::VERTEX;
    let extras = if needs_extras {
        let or = |v: Option<&[f32; 2]>| v.copied().unwrap_or([0.0; 2]);
        let extras: Vec<Extras> = sources()
            .map(|s| {
                let [u0, u1] = [or(primitive.uvs[0].get(s)), or(primitive.uvs[1].get(s))];
                Extras {
                    color: primitive.colors.get(s).copied().unwrap_or([1.0; 4]),
                    uv: [u0[0], u0[1], u1[0], u1[1]],
                    tangent: primitive.tangents.get(s).copied().unwrap_or([0.0, 0.0, 0.0, 1.0]),
                }
            })
            .collect();
        Some(gpu.buffer_of("extras", bytemuck::cast_slice(&extras), vertex)?)
    } else {
        None
    };
    let parameters = match parametrization.filter(|_| Parametrization::covers(primitive)) {
        Some(known) => {
            let scaled: Vec<[f32; 3]> =
                sources().map(|s| known.scaled(primitive.uvs[0][s]).extend(0.0).as_vec3().to_array()).collect();
            Some(gpu.buffer_of("parameters", bytemuck::cast_slice(&scaled), vertex)?)
        }
        None => None,
    };
    Ok(GpuPrimitive {
        material: primitive.material,
        place: gpu.buffer_of("places", bytemuck::cast_slice(&places), vertex)?,
        normals: gpu.buffer_of("normals", bytemuck::cast_slice(&normals), vertex)?,
        extras,
        parameters,
        indices: gpu.buffer_of("indices", bytemuck::cast_slice(&numbered.triangles), wgpu::BufferUsages::INDEX)?,
        run: 0..3 * numbered.triangles.len() as u32,
    })
}

/// The next smaller level of an image: means of 2×2 pixels, in linear light for colours.
fn halved(image: &Image, srgb: bool) -> Image {
    let (width, height) = ((image.width / 2).max(1), (image.height / 2).max(1));
    let decode = |v: u8, channel: usize| {
        let v = f64::from(v) / 255.0;
        if srgb && channel < 3 { linear_from_srgb(v) } else { v }
    };
    let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            for channel in 0..4 {
                let mut sum = 0.0;
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let (sx, sy) = ((2 * x + dx).min(image.width - 1), (2 * y + dy).min(image.height - 1));
                    let at = 4 * (sy as usize * image.width as usize + sx as usize) + channel;
                    sum += decode(image.rgba[at], channel);
                }
                let mean = sum / 4.0;
                let encoded = if srgb && channel < 3 { srgb_from_linear(mean) } else { mean };
                rgba.push((encoded * 255.0).round() as u8);
            }
        }
    }
    Image { name: image.name.clone(), width, height, rgba }
}

fn upload_image(gpu: &Gpu, image: &Image, srgb: bool, mips: bool) -> wgpu::TextureView {
    let levels = if mips { image.width.max(image.height).ilog2() + 1 } else { 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&image.name),
        size: wgpu::Extent3d { width: image.width, height: image.height, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: if srgb { wgpu::TextureFormat::Rgba8UnormSrgb } else { wgpu::TextureFormat::Rgba8Unorm },
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let mut level_image = image.clone();
    for level in 0..levels {
        if level > 0 {
            level_image = halved(&level_image, srgb);
        }
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo { mip_level: level, ..texture.as_image_copy() },
            &level_image.rgba,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * level_image.width), rows_per_image: None },
            wgpu::Extent3d { width: level_image.width, height: level_image.height, depth_or_array_layers: 1 },
        );
    }
    texture.create_view(&Default::default())
}

fn address(wrap: Wrap) -> wgpu::AddressMode {
    match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
        Wrap::ClampToEdge => wgpu::AddressMode::ClampToEdge,
    }
}

fn filter(linear: bool) -> wgpu::FilterMode {
    if linear { wgpu::FilterMode::Linear } else { wgpu::FilterMode::Nearest }
}

fn references(material: &Material) -> [Option<&TextureRef>; 5] {
    [
        material.base_color_texture.as_ref(),
        material.metallic_roughness_texture.as_ref(),
        material.normal_texture.as_ref(),
        material.occlusion_texture.as_ref(),
        material.emissive_texture.as_ref(),
    ]
}

fn material_uniform(material: &Material) -> MaterialUniform {
    let [r, g, b] = material.emissive;
    let (mode, cutoff) = match material.alpha_mode {
        AlphaMode::Opaque => (0, 0.0),
        AlphaMode::Mask { cutoff } => (1, cutoff),
        AlphaMode::Blend => (2, 0.0),
    };
    let mut present = 0;
    let mut second_set = 0;
    let mut uv_rows = [[0.0; 4]; 10];
    for (i, reference) in references(material).into_iter().enumerate() {
        let Some(reference) = reference else { continue };
        present |= 1 << i;
        second_set |= reference.uv_set.min(1) << i;
        for row in 0..2 {
            let [a, b, c] = reference.uv_transform[row];
            uv_rows[2 * i + row] = [a, b, c, 0.0];
        }
    }
    MaterialUniform {
        base_color: material.base_color,
        emissive: [r, g, b, material.normal_scale],
        factors: [material.metallic, material.roughness, material.occlusion_strength, cutoff],
        modes: [mode, u32::from(material.unlit), present, second_set],
        uv_rows,
    }
}

struct Textures<'a> {
    gpu: &'a Gpu,
    scene: &'a Scene,
    white: wgpu::TextureView,
    /// By texture and whether it holds colours.
    views: std::collections::HashMap<(usize, bool), wgpu::TextureView>,
}

impl Textures<'_> {
    fn view(&mut self, reference: Option<&TextureRef>, srgb: bool) -> wgpu::TextureView {
        let Some(texture) = reference.and_then(|r| self.scene.textures.get(r.texture)) else {
            return self.white.clone();
        };
        let Some(image) = self.scene.images.get(texture.image) else {
            return self.white.clone();
        };
        let (gpu, mips) = (self.gpu, texture.mip != Mip::None);
        let key = (reference.map_or(0, |r| r.texture), srgb);
        self.views.entry(key).or_insert_with(|| upload_image(gpu, image, srgb, mips)).clone()
    }

    fn sampler(&self, reference: Option<&TextureRef>) -> wgpu::Sampler {
        let texture = reference.and_then(|r| self.scene.textures.get(r.texture));
        let mut descriptor = wgpu::SamplerDescriptor::default();
        if let Some(t) = texture {
            descriptor.address_mode_u = address(t.wrap[0]);
            descriptor.address_mode_v = address(t.wrap[1]);
            descriptor.mag_filter = filter(t.mag_linear);
            descriptor.min_filter = filter(t.min_linear);
            descriptor.mipmap_filter =
                if t.mip == Mip::Linear { wgpu::MipmapFilterMode::Linear } else { wgpu::MipmapFilterMode::Nearest };
        }
        self.gpu.device.create_sampler(&descriptor)
    }
}

fn upload_material(
    textures: &mut Textures<'_>,
    layouts: &SharedLayouts,
    material: &Material,
) -> Result<GpuMaterial, GpuError> {
    let gpu = textures.gpu;
    let constants = gpu.uniform("material", &material_uniform(material))?;
    let group = |layout, entries: &[wgpu::BindGroupEntry<'_>]| {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(&material.name), layout, entries })
    };
    let first = wgpu::BindGroupEntry { binding: 0, resource: constants.as_entire_binding() };
    let bound: Vec<(wgpu::TextureView, wgpu::Sampler)> = references(material)
        .into_iter()
        .enumerate()
        // Base colour and emission are colours, the rest are data.
        .map(|(i, reference)| (textures.view(reference, i == 0 || i == 4), textures.sampler(reference)))
        .collect();
    let mut entries = vec![first.clone()];
    for (i, (view, sampler)) in bound.iter().enumerate() {
        let binding = 2 * i as u32 + 1;
        entries.push(wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) });
        entries.push(wgpu::BindGroupEntry { binding: binding + 1, resource: wgpu::BindingResource::Sampler(sampler) });
    }
    Ok(GpuMaterial {
        masked: matches!(material.alpha_mode, AlphaMode::Mask { .. }),
        plain: group(&layouts.material, &[first]),
        textured: group(&layouts.textured_material, &entries),
    })
}

/// The material of a primitive that reads no vertex data but places and normals; `any` lends the groups that are never bound.
pub(super) fn upload_plain_material(
    gpu: &Gpu,
    layouts: &SharedLayouts,
    material: &Material,
    any: &GpuMaterial,
) -> Result<GpuMaterial, GpuError> {
    let constants = gpu.uniform("material", &material_uniform(material))?;
    let plain = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(&material.name),
        layout: &layouts.material,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: constants.as_entire_binding() }],
    });
    Ok(GpuMaterial { masked: false, plain, textured: any.textured.clone() })
}

/// What shaders know of each part and each cap, which looks as the part that it closes; an empty scene still has one entry,
/// that of no part.
fn part_table(scene: &Scene, arrangement: &Arrangement, cut: &Cut) -> Vec<PartFacts> {
    let facts = |(index, part): (usize, &Part)| {
        let look = arrangement.look(index as u32);
        let radius = part.bounds.bounding_sphere().radius;
        let bit = |is_set: bool, bit: u32| u32::from(is_set) << bit;
        let color = look.color.map(|c| c.map(|v| linear_from_srgb(v) as f32));
        PartFacts {
            first_triangle: part.first_triangle,
            // Reciprocals of powers of two times a radius are exact multiples, so scaling a model by 1024 changes no bit.
            inverse_radius: if radius > 0.0 { (1.0 / radius) as f32 } else { 1.0 },
            radius: if radius > 0.0 { radius as f32 } else { 1.0 },
            look: (look.opacity as f32).to_bits()
                | bit(look.style == PartStyle::Solid, 31)
                | bit(look.presence == Presence::Ghosted, 30),
            color: color.map_or([0.0; 4], |[r, g, b]| [r, g, b, 1.0]),
        }
    };
    let mut table: Vec<PartFacts> = scene.parts.iter().enumerate().map(facts).collect();
    for cap in &cut.caps {
        let owner = table[cap.part as usize];
        let [r, g, b, given] = owner.color;
        let [r, g, b] = if given == 0.0 { [r, g, b] } else { tinted([r, g, b]) };
        table.push(PartFacts { first_triangle: cap.first_triangle, color: [r, g, b, given], ..owner });
    }
    if table.is_empty() {
        table.push(bytemuck::Zeroable::zeroed());
    }
    table
}

/// How the table of parts is used.
const TABLE: wgpu::BufferUsages =
    wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::COPY_SRC).union(wgpu::BufferUsages::COPY_DST);

impl GpuScene {
    /// Shows the parts as an arrangement that fits the scene says: where they are, how they look, what the planner knows.
    ///
    /// # Errors
    /// [`GpuError`] of the device.
    pub fn arrange(
        &mut self,
        gpu: &Gpu,
        layouts: &SharedLayouts,
        scene: &Scene,
        arrangement: &Arrangement,
    ) -> Result<(), GpuError> {
        let cut = Cut::new(scene, arrangement, &self.solids);
        let placed = arrangement.placed(scene);
        for (index, (part, place)) in self.parts.iter_mut().zip(&placed.parts).enumerate() {
            part.world_from_part = place.world_from_part;
            part.sphere = place.bounds.bounding_sphere();
            part.is_drawn = arrangement.is_drawn(index as u32);
            part.is_selected = arrangement.selected.contains(&(index as u32));
        }
        self.close(gpu, layouts, scene, arrangement, cut)?;
        let table = part_table(scene, arrangement, &self.cut);
        if self.part_table.size() == size_of_val(table.as_slice()) as u64 {
            gpu.queue.write_buffer(&self.part_table, 0, bytemuck::cast_slice(&table));
        } else {
            self.part_table = gpu.buffer_of("part_table", bytemuck::cast_slice(&table), TABLE)?;
        }
        self.stats = self.cut.stats(scene, arrangement);
        self.arrangement = arrangement.clone();
        gpu.check()
    }

    /// Uploads a finished scene.
    ///
    /// `shuffled` puts the triangles of every primitive into another order (for tests; the picture must not change).
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn upload(
        gpu: &Gpu,
        layouts: &SharedLayouts,
        scene: &Scene,
        shuffled: Option<u64>,
    ) -> Result<GpuScene, GpuError> {
        let white = Image { name: "white".to_owned(), width: 1, height: 1, rgba: vec![255; 4] };
        let mut textures =
            Textures { gpu, scene, white: upload_image(gpu, &white, false, false), views: Default::default() };
        let materials = scene
            .materials
            .iter()
            .map(|m| upload_material(&mut textures, layouts, m))
            .collect::<Result<Vec<_>, _>>()?;
        let mut shown = vec![false; scene.meshes.len()];
        for part in &scene.parts {
            shown[part.mesh] = true;
        }
        let mut primitives = Vec::new();
        let mut primitives_of_mesh = Vec::with_capacity(scene.meshes.len());
        for (mesh, shown) in scene.meshes.iter().zip(shown) {
            let begin = primitives.len();
            let parametrization = if shown { Parametrization::of(mesh) } else { None };
            let mut first = 0;
            for primitive in mesh.primitives.iter().filter(|_| shown) {
                let count = primitive.triangles.len() as u32;
                if count > 0 {
                    let textured = scene.materials[primitive.material].texture_refs().next().is_some();
                    let extras = textured || !primitive.colors.is_empty();
                    let seed = shuffled.map(|s| s ^ u64::from(first));
                    primitives.push(upload_primitive(gpu, primitive, (extras, parametrization), first, seed)?);
                }
                first += count;
            }
            primitives_of_mesh.push(begin..primitives.len());
        }
        let parts: Vec<GpuPart> = scene
            .parts
            .iter()
            .map(|p| GpuPart {
                mesh: p.mesh,
                first_triangle: p.first_triangle,
                world_from_part: p.world_from_part,
                sphere: p.bounds.bounding_sphere(),
                is_drawn: true,
                is_selected: false,
            })
            .collect();
        let mut parts_by_mesh = vec![Vec::new(); scene.meshes.len()];
        for (i, part) in parts.iter().enumerate() {
            parts_by_mesh[part.mesh].push(i as u32);
        }
        let table = part_table(scene, &Arrangement::default(), &Cut::default());
        let part_table = gpu.buffer_of("part_table", bytemuck::cast_slice(&table), TABLE)?;
        gpu.check()?;
        let own = Own::new(primitives.len(), primitives_of_mesh.len(), parts.len());
        Ok(GpuScene {
            stats: SceneStats::of(scene),
            serial: UPLOADS.fetch_add(1, Ordering::Relaxed),
            primitives,
            primitives_of_mesh,
            materials,
            parts,
            parts_by_mesh,
            part_table,
            arrangement: Arrangement::default(),
            cut: Cut::default(),
            solids: Solids::of(scene),
            own,
            cap_materials: HashMap::new(),
        })
    }
}

/// A scene's GPU memory can be shared by windows and workers.
const _: fn() = || {
    fn is_send_and_sync<T: Send + Sync>() {}
    is_send_and_sync::<Arc<GpuScene>>();
};

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Primitive {
        Primitive {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            normals: vec![[-0.577, -0.577, -0.577], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [1, 2, 3], [3, 1, 2]],
            ..Primitive::default()
        }
    }

    #[test]
    fn every_triangle_begins_with_a_vertex_that_carries_its_number() {
        let primitive = tetrahedron();
        let numbered = number(&primitive, 7);
        for (i, (&turned, &original)) in numbered.triangles.iter().zip(&primitive.triangles).enumerate() {
            assert_eq!(numbered.numbers[turned[0] as usize] & !OPPOSED, 7 + i as u32);
            // The same vertices in the same cyclic order.
            let old = turned.map(|v| numbered.sources[v as usize]);
            let rotations = [0, 1, 2].map(|r| [original[r], original[(r + 1) % 3], original[(r + 2) % 3]]);
            assert!(rotations.contains(&old), "{old:?} is no turn of {original:?}");
        }
        // Four vertices for six triangles: two are doubled.
        assert_eq!(numbered.sources.len(), 6);
    }

    #[test]
    fn normals_against_the_winding_are_flagged() {
        let mut primitive = tetrahedron();
        primitive.triangles = vec![[1, 2, 3]];
        assert_eq!(number(&primitive, 0).numbers[1] & OPPOSED, 0);
        primitive.triangles = vec![[1, 3, 2]];
        assert_eq!(number(&primitive, 0).numbers[1] & OPPOSED, OPPOSED);
    }

    #[test]
    fn halving_averages_colours_in_linear_light() {
        let image = Image { name: String::new(), width: 2, height: 1, rgba: vec![0, 0, 0, 0, 255, 255, 255, 255] };
        let half = halved(&image, true);
        assert_eq!((half.width, half.height), (1, 1));
        assert_eq!(half.rgba, [188, 188, 188, 128]);
        assert_eq!(halved(&image, false).rgba, [128, 128, 128, 128]);
    }
}
