//! Egui's meshes and the picture between them, on the window's device.
//!
//! Not by egui-wgpu: its fragment shader keeps four loads with wrapped coordinates and dithering behind branches on a uniform,
//! and a rasterizer without hardware evaluates both sides of a branch for every pixel. There the window's frames took twice as
//! long as they do here, where a pixel takes one sample at most, and none where no texture shows: triangles of a mesh that
//! stand in its texture's white corner are drawn apart, in their order.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use egui::epaint::textures::{TextureFilter, TextureOptions, TextureWrapMode};
use egui::epaint::{ClippedPrimitive, ImageData, ImageDelta, Mesh, Primitive, Vertex, WHITE_UV};
use egui::{PaintCallbackInfo, Rect, TextureId};

use crate::app::viewport::{FILTERED, Paint, Screen, encoding};

/// The shader.
const SHADER: &str = concat!(include_str!("../encoding.wgsl"), include_str!("painter.wgsl"));

/// Vertices and indices for which there is room at first.
const FIRST_ROOM: u64 = 1 << 16;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Window {
    size: [f32; 2],
    _pad: [f32; 2],
}

/// A texture of egui's.
struct Texture {
    texture: wgpu::Texture,
    options: TextureOptions,
    group: wgpu::BindGroup,
}

/// What is drawn one after the other.
enum Step {
    /// Triangles of a mesh.
    Triangles {
        /// Left, top, width and height, pixels.
        scissor: [u32; 4],
        /// None where no texture shows.
        texture: Option<TextureId>,
        /// Of all indices.
        indices: Range<u32>,
        /// Where the mesh's vertices begin.
        base: i32,
    },
    /// The picture.
    Picture(PaintCallbackInfo, Arc<Paint>),
}

/// Draws egui's shapes.
pub struct Painter {
    plain: wgpu::RenderPipeline,
    textured: wgpu::RenderPipeline,
    window: wgpu::Buffer,
    window_group: wgpu::BindGroup,
    texture_layout: wgpu::BindGroupLayout,
    samplers: HashMap<TextureOptions, wgpu::Sampler>,
    textures: HashMap<TextureId, Texture>,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    screen: Screen,
    steps: Vec<Step>,
}

impl Painter {
    /// For a window whose surface has this format.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Painter {
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("painter"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let window_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("painter's window"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let texture_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("painter's texture"),
            entries: &[entry(0, FILTERED), entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering))],
        });
        let pipeline = |shows: &str, layouts: &[Option<&wgpu::BindGroupLayout>]| {
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("painter"),
                bind_group_layouts: layouts,
                immediate_size: 0,
            });
            pipeline(device, &shader, &layout, shows, format)
        };
        let plain = pipeline("plain", &[Some(&window_layout)]);
        let textured = pipeline("textured", &[Some(&window_layout), Some(&texture_layout)]);
        let window = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("painter's window"),
            size: std::mem::size_of::<Window>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let window_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("painter's window"),
            layout: &window_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: window.as_entire_binding() }],
        });
        Painter {
            plain,
            textured,
            window,
            window_group,
            texture_layout,
            samplers: HashMap::new(),
            textures: HashMap::new(),
            vertices: room(device, wgpu::BufferUsages::VERTEX, FIRST_ROOM),
            indices: room(device, wgpu::BufferUsages::INDEX, FIRST_ROOM),
            screen: Screen::new(device, format),
            steps: Vec::new(),
        }
    }

    /// Takes over a texture of egui's, or the part of one that has changed.
    pub fn update_texture(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, id: TextureId, delta: &ImageDelta) {
        let ImageData::Color(image) = &delta.image;
        let size = image.size.map(|n| n as u32);
        let extent = wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 };
        let texture = match (delta.pos, self.textures.remove(&id)) {
            // A part of what is there.
            (Some(_), Some(before)) if before.options == delta.options => before,
            (Some(_), Some(before)) => self.bound(device, before.texture, delta.options),
            (Some(_), None) => {
                tracing::error!("a part of the texture {id:?} has changed, which is not there");
                return;
            }
            (None, _) => {
                let texture = device.create_texture(&wgpu::TextureDescriptor {
                    label: Some("egui"),
                    size: extent,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: wgpu::TextureFormat::Rgba8Unorm,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                    view_formats: &[],
                });
                self.bound(device, texture, delta.options)
            }
        };
        let [x, y] = delta.pos.unwrap_or_default().map(|n| n as u32);
        queue.write_texture(
            wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z: 0 }, ..texture.texture.as_image_copy() },
            bytemuck::cast_slice(&image.pixels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size[0]), rows_per_image: None },
            extent,
        );
        self.textures.insert(id, texture);
    }

    fn bound(&mut self, device: &wgpu::Device, texture: wgpu::Texture, options: TextureOptions) -> Texture {
        let sampler = self.samplers.entry(options).or_insert_with(|| sampler(device, options));
        let view = texture.create_view(&Default::default());
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("egui"),
            layout: &self.texture_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(sampler) },
            ],
        });
        Texture { texture, options, group }
    }

    /// Forgets a texture.
    pub fn free_texture(&mut self, id: TextureId) {
        self.textures.remove(&id);
    }

    /// Brings to the device what [`Painter::paint`] draws: `shapes` in a window of `size` pixels.
    pub fn upload(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        shapes: &[ClippedPrimitive],
        size: [u32; 2],
        pixels_per_point: f32,
    ) {
        self.steps.clear();
        let mut vertices: Vec<Vertex> = Vec::new();
        let mut indices: Vec<u32> = Vec::new();
        for shape in shapes {
            let scissor = scissor(shape.clip_rect, size, pixels_per_point);
            if scissor[2] == 0 || scissor[3] == 0 {
                continue;
            }
            match &shape.primitive {
                Primitive::Mesh(mesh) => {
                    let (base, first) = (vertices.len() as i32, indices.len() as u32);
                    for (textured, run) in runs(mesh) {
                        self.steps.push(Step::Triangles {
                            scissor,
                            texture: textured.then_some(mesh.texture_id),
                            indices: first + run.start as u32..first + run.end as u32,
                            base,
                        });
                    }
                    vertices.extend_from_slice(&mesh.vertices);
                    indices.extend_from_slice(&mesh.indices);
                }
                Primitive::Callback(callback) => {
                    let Ok(paint) = Arc::clone(&callback.callback).downcast::<Paint>() else {
                        tracing::error!("a paint callback is none of ours");
                        continue;
                    };
                    paint.upload(device, queue, &mut self.screen);
                    let info = PaintCallbackInfo {
                        viewport: callback.rect,
                        clip_rect: shape.clip_rect,
                        pixels_per_point,
                        screen_size_px: size,
                    };
                    self.steps.push(Step::Picture(info, paint));
                }
            }
        }
        let [width, height] = size.map(|n| n as f32 / pixels_per_point);
        queue.write_buffer(&self.window, 0, bytemuck::bytes_of(&Window { size: [width, height], _pad: [0.0; 2] }));
        fill(device, queue, &mut self.vertices, bytemuck::cast_slice(&vertices));
        fill(device, queue, &mut self.indices, bytemuck::cast_slice(&indices));
    }

    /// Draws what was uploaded.
    pub fn paint(&self, pass: &mut wgpu::RenderPass, size: [u32; 2]) {
        // Pictures use other pipelines and leave nothing as it was.
        let mut ready = false;
        let mut last: Option<bool> = None;
        for step in &self.steps {
            match step {
                Step::Triangles { scissor: [x, y, width, height], texture, indices, base } => {
                    if !ready {
                        pass.set_viewport(0.0, 0.0, size[0] as f32, size[1] as f32, 0.0, 1.0);
                        pass.set_vertex_buffer(0, self.vertices.slice(..));
                        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
                        (ready, last) = (true, None);
                    }
                    let group = match texture.map(|id| self.textures.get(&id)) {
                        None => None,
                        Some(Some(texture)) => Some(&texture.group),
                        Some(None) => {
                            tracing::error!("the texture {texture:?} is not there");
                            continue;
                        }
                    };
                    if last != Some(group.is_some()) {
                        pass.set_pipeline(if group.is_some() { &self.textured } else { &self.plain });
                        pass.set_bind_group(0, &self.window_group, &[]);
                        last = Some(group.is_some());
                    }
                    if let Some(group) = group {
                        pass.set_bind_group(1, group, &[]);
                    }
                    pass.set_scissor_rect(*x, *y, *width, *height);
                    pass.draw_indexed(indices.clone(), *base, 0..1);
                }
                Step::Picture(info, paint) => {
                    paint.paint(info, pass, &self.screen);
                    ready = false;
                }
            }
        }
    }
}

/// Pixels within a rectangle of points: left, top, width and height, inside the window.
fn scissor(clip: Rect, size: [u32; 2], pixels_per_point: f32) -> [u32; 4] {
    // Of what is not finite, nothing is seen.
    let pixel = |at: f32, most: u32| (at * pixels_per_point).round().clamp(0.0, most as f32) as u32;
    let (left, top) = (pixel(clip.left(), size[0]), pixel(clip.top(), size[1]));
    let (right, bottom) = (pixel(clip.right(), size[0]), pixel(clip.bottom(), size[1]));
    [left, top, right.saturating_sub(left), bottom.saturating_sub(top)]
}

/// Indices of a mesh in runs of triangles that show its texture or not.
fn runs(mesh: &Mesh) -> Vec<(bool, Range<usize>)> {
    let white = |&i: &u32| mesh.vertices.get(i as usize).is_some_and(|v| v.uv == WHITE_UV);
    let mut all: Vec<(bool, Range<usize>)> = Vec::new();
    for (number, triangle) in mesh.indices.chunks_exact(3).enumerate() {
        // Only the texture of letters has a white corner.
        let textured = mesh.texture_id != TextureId::default() || !triangle.iter().all(white);
        match all.last_mut() {
            Some((same, run)) if *same == textured => run.end += 3,
            _ => all.push((textured, 3 * number..3 * number + 3)),
        }
    }
    all
}

fn pipeline(
    device: &wgpu::Device,
    shader: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    shows: &str,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let encodes = encoding(format);
    let over =
        |src_factor, dst_factor| wgpu::BlendComponent { src_factor, dst_factor, operation: wgpu::BlendOperation::Add };
    let blend = wgpu::BlendState {
        color: over(wgpu::BlendFactor::One, wgpu::BlendFactor::OneMinusSrcAlpha),
        alpha: over(wgpu::BlendFactor::OneMinusDstAlpha, wgpu::BlendFactor::One),
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(shows),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some("corner"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: std::mem::size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4],
            })],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some(shows),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &encodes, ..Default::default() },
            targets: &[Some(wgpu::ColorTargetState { format, blend: Some(blend), write_mask: wgpu::ColorWrites::ALL })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn sampler(device: &wgpu::Device, options: TextureOptions) -> wgpu::Sampler {
    let filter = |filter| match filter {
        TextureFilter::Nearest => wgpu::FilterMode::Nearest,
        TextureFilter::Linear => wgpu::FilterMode::Linear,
    };
    let wrap = match options.wrap_mode {
        TextureWrapMode::ClampToEdge => wgpu::AddressMode::ClampToEdge,
        TextureWrapMode::Repeat => wgpu::AddressMode::Repeat,
        TextureWrapMode::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
    };
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("egui"),
        mag_filter: filter(options.magnification),
        min_filter: filter(options.minification),
        address_mode_u: wrap,
        address_mode_v: wrap,
        ..Default::default()
    })
}

fn room(device: &wgpu::Device, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("painter"),
        size,
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Writes a buffer, which is made larger if there is not room enough.
fn fill(device: &wgpu::Device, queue: &wgpu::Queue, buffer: &mut wgpu::Buffer, bytes: &[u8]) {
    let needed = bytes.len() as u64;
    if buffer.size() < needed {
        *buffer = room(device, buffer.usage(), needed.next_power_of_two());
    }
    if needed > 0 {
        queue.write_buffer(buffer, 0, bytes);
    }
}

#[cfg(test)]
mod tests {
    use egui::epaint::ColorImage;
    use egui::{Color32, Pos2, pos2};

    use super::*;
    use crate::gpu::{Gpu, GpuOptions};

    const SIDE: u32 = 64;

    fn square(mesh: &mut Mesh, [left, top, right, bottom]: [f32; 4], uv: [Pos2; 2], color: Color32) {
        let rect = Rect::from_min_max(pos2(left, top), pos2(right, bottom));
        mesh.add_rect_with_uv(rect, Rect::from_min_max(uv[0], uv[1]), color);
    }

    fn clipped(mesh: Mesh) -> ClippedPrimitive {
        let clip_rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(20.0, 32.0));
        ClippedPrimitive { clip_rect, primitive: Primitive::Mesh(mesh) }
    }

    #[test]
    fn triangles_are_parted_by_what_shows_the_texture_and_stay_in_order() {
        let mut mesh = Mesh::default();
        let letter = [pos2(0.25, 0.25), pos2(0.5, 0.5)];
        square(&mut mesh, [0.0, 0.0, 1.0, 1.0], [WHITE_UV; 2], Color32::RED);
        square(&mut mesh, [0.0, 0.0, 1.0, 1.0], [WHITE_UV; 2], Color32::RED);
        square(&mut mesh, [0.0, 0.0, 1.0, 1.0], letter, Color32::RED);
        square(&mut mesh, [0.0, 0.0, 1.0, 1.0], [WHITE_UV; 2], Color32::RED);
        assert_eq!(runs(&mesh), [(false, 0..12), (true, 12..18), (false, 18..24)]);
        let picture = Mesh { texture_id: TextureId::User(1), ..mesh };
        assert_eq!(runs(&picture), [(true, 0..24)], "no white corner is known of other textures");
        assert_eq!(runs(&Mesh::default()), []);
    }

    #[test]
    fn clipping_is_on_whole_pixels_within_the_window() {
        let rect = |a: f32, b: f32| Rect::from_min_max(pos2(a, a), pos2(b, b));
        assert_eq!(scissor(rect(1.2, 3.4), [100, 5], 2.0), [2, 2, 5, 3]);
        assert_eq!(scissor(rect(-9.0, f32::INFINITY), [100, 5], 1.0), [0, 0, 100, 5]);
        assert_eq!(scissor(Rect::NOTHING, [100, 5], 1.0)[2..], [0, 0]);
        assert_eq!(scissor(Rect::NAN, [100, 5], 1.0)[2..], [0, 0]);
    }

    /// What a painter paints over black, two pixels a point.
    fn painted(gpu: &Gpu, painter: &mut Painter, shapes: &[ClippedPrimitive]) -> Vec<[u8; 4]> {
        let size = wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 };
        let target = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let bytes = u64::from(4 * SIDE * SIDE);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let buffer = gpu.buffer("painted", bytes, usage).unwrap();
        painter.upload(&gpu.device, &gpu.queue, shapes, [SIDE, SIDE], 2.0);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target.create_view(&Default::default()),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        painter.paint(&mut pass, [SIDE, SIDE]);
        drop(pass);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * SIDE), rows_per_image: None };
        let into = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(target.as_image_copy(), into, size);
        gpu.queue.submit([encoder.finish()]);
        gpu.check().unwrap();
        bytemuck::cast_slice(&gpu.read_buffer(&buffer, bytes).unwrap()).to_vec()
    }

    #[test]
    fn meshes_are_painted_as_egui_means_them() {
        let gpu = match Gpu::new(&GpuOptions::default()) {
            Ok(gpu) => gpu,
            Err(e) => {
                assert!(std::env::var_os("CI").is_none(), "{e}");
                println!("SKIPPED: painter: {e}");
                return;
            }
        };
        let (letters, picture) = (TextureId::default(), TextureId::User(7));
        let image = |size: [usize; 2], color| ColorImage::new(size, vec![color; size[0] * size[1]]);
        let options = TextureOptions::NEAREST;
        let delta = |image, pos| ImageDelta { image: ImageData::Color(Arc::new(image)), options, pos };
        let mut painter = Painter::new(&gpu.device, wgpu::TextureFormat::Rgba8Unorm);
        let mut update = |id, delta| painter.update_texture(&gpu.device, &gpu.queue, id, &delta);
        update(letters, delta(image([4, 4], Color32::WHITE), None));
        update(picture, delta(image([4, 4], Color32::WHITE), None));
        // A part of it becomes green.
        update(picture, delta(image([2, 4], Color32::GREEN), Some([2, 0])));
        update(TextureId::User(9), delta(image([1, 1], Color32::WHITE), Some([0, 0])));

        let half = Color32::from_rgba_premultiplied(0, 0, 100, 128);
        let whole = [pos2(0.0, 0.0), pos2(1.0, 1.0)];
        let mut plain = Mesh::default();
        square(&mut plain, [2.0, 2.0, 30.0, 30.0], [WHITE_UV; 2], Color32::RED);
        square(&mut plain, [10.0, 2.0, 30.0, 30.0], [WHITE_UV; 2], half);
        let mut textured = Mesh::with_texture(picture);
        square(&mut textured, [4.0, 8.0, 16.0, 12.0], whole, Color32::WHITE);
        let lost = Mesh { texture_id: TextureId::User(9), ..textured.clone() };
        let shapes = [plain.clone(), textured, lost].map(clipped);
        let pixels = painted(&gpu, &mut painter, &shapes);
        let at = |x: u32, y: u32| pixels[(y * SIDE + x) as usize];
        assert_eq!(at(3, 3), [0, 0, 0, 255], "outside");
        assert_eq!(at(4, 4), [255, 0, 0, 255]);
        let over = at(20, 8);
        assert!((126..=128).contains(&over[0]) && over[2] == 100, "half over red: {over:?}");
        assert_eq!([at(39, 50), at(40, 50)], [over, [0, 0, 0, 255]], "clipped at 20 points");
        assert_eq!([at(8, 16), at(19, 23)], [[255; 4]; 2], "the picture's left half");
        assert_eq!([at(20, 16), at(31, 23)], [[0, 255, 0, 255]; 2], "and its right one");
        // A texture that is white says the same as none.
        let white = Mesh { texture_id: TextureId::User(8), ..plain.clone() };
        painter.update_texture(
            &gpu.device,
            &gpu.queue,
            TextureId::User(8),
            &delta(image([1, 1], Color32::WHITE), None),
        );
        let [without, with] = [plain, white].map(|mesh| painted(&gpu, &mut painter, &[clipped(mesh)]));
        assert_eq!(without, with);
        painter.free_texture(TextureId::User(8));
        // What is drawn again in part is what was drawn as a whole, gradients and their last bits too.
        let mut fade = Mesh::default();
        for (y, alpha) in [(3.0, 0), (31.0, 230)] {
            for x in [1.0, 30.0] {
                fade.colored_vertex(pos2(x, y), Color32::from_rgba_unmultiplied(29, 32, 37, alpha));
            }
        }
        fade.indices = vec![0, 1, 2, 1, 2, 3];
        let mut ground = Mesh::default();
        square(&mut ground, [0.0, 0.0, 32.0, 32.0], [WHITE_UV; 2], Color32::from_rgb(29, 32, 37));
        let whole = painted(&gpu, &mut painter, &[clipped(ground.clone()), clipped(fade.clone())]);
        for (triangle, [left, top, right, bottom]) in
            [(vec![1, 2, 3], [16.0, 24.0, 19.0, 30.0]), (vec![0, 1, 2, 1, 2, 3], [3.0, 8.0, 11.0, 20.0])]
        {
            let clip_rect = Rect::from_min_max(pos2(left, top), pos2(right, bottom));
            let part = [ground.clone(), Mesh { indices: triangle, ..fade.clone() }]
                .map(|mesh| ClippedPrimitive { clip_rect, primitive: Primitive::Mesh(mesh) });
            let pixels = painted(&gpu, &mut painter, &part);
            for y in 2 * top as u32..2 * bottom as u32 {
                for x in 2 * left as u32..2 * right as u32 {
                    let at = (y * SIDE + x) as usize;
                    assert_eq!(pixels[at], whole[at], "pixel {x}, {y}");
                }
            }
        }
    }
}
