//! The picture in the window: pixel for pixel, past egui's colours.
//!
//! An exact picture has as many pixels as the viewport, and each goes to its place unchanged: no filter, no blending, no
//! dithering, so a screenshot of the viewport is the PNG of `pellucid render`. A preview, and an exact picture while the window
//! changes its size, is scaled by the ratio of heights (the vertical angle of view is what the camera keeps) and filtered.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use egui_wgpu::{CallbackResources, CallbackTrait, ScreenDescriptor};

/// A picture to show.
pub struct Shown {
    /// Another picture has another one.
    pub serial: u64,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// 8-bit sRGB, straight alpha.
    pub rgba: Vec<u8>,
    /// The file's background around it, sRGB; `None` shows a checkerboard through.
    pub background: Option<[f32; 3]>,
}

/// Draws a picture into a rectangle of physical pixels: a paint callback for egui.
pub struct Paint {
    /// The picture.
    pub picture: Arc<Shown>,
    /// Left and top, pixels of the window.
    pub origin: [u32; 2],
    /// Width and height, pixels.
    pub size: [u32; 2],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Place {
    origin: [f32; 2],
    size: [f32; 2],
    picture: [f32; 2],
    checker: f32,
    _pad: f32,
    background: [f32; 4],
}

/// What is kept on the window's device between frames.
pub struct Screen {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    place: wgpu::Buffer,
    picture: Option<OnScreen>,
}

struct OnScreen {
    serial: u64,
    texture: wgpu::Texture,
    group: wgpu::BindGroup,
}

impl Screen {
    /// For a window whose surface has this format.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Screen {
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("viewport"),
            source: wgpu::ShaderSource::Wgsl(include_str!("viewport.wgsl").into()),
        });
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("viewport"),
            entries: &[
                entry(
                    0,
                    wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: false },
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    },
                ),
                entry(
                    1,
                    wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                ),
            ],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("viewport"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("viewport"),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("show"),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let place = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("viewport"),
            size: std::mem::size_of::<Place>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Screen { pipeline, layout, place, picture: None }
    }

    fn upload(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, shown: &Shown) {
        if self.picture.as_ref().is_some_and(|p| p.serial == shown.serial) {
            return;
        }
        let size = wgpu::Extent3d { width: shown.size[0], height: shown.size[1], depth_or_array_layers: 1 };
        let (texture, group) = match self.picture.take() {
            Some(p) if p.texture.size() == size => (p.texture, p.group),
            _ => {
                let texture = device.create_texture(&wgpu::TextureDescriptor {
                    label: Some("viewport"),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: wgpu::TextureFormat::Rgba8Unorm,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                    view_formats: &[],
                });
                let view = texture.create_view(&Default::default());
                let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("viewport"),
                    layout: &self.layout,
                    entries: &[
                        wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
                        wgpu::BindGroupEntry { binding: 1, resource: self.place.as_entire_binding() },
                    ],
                });
                (texture, group)
            }
        };
        queue.write_texture(
            texture.as_image_copy(),
            &shown.rgba,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * shown.size[0]), rows_per_image: None },
            size,
        );
        self.picture = Some(OnScreen { serial: shown.serial, texture, group });
    }
}

impl CallbackTrait for Paint {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let limit = device.limits().max_texture_dimension_2d;
        let fits = self.picture.size.iter().all(|&n| n > 0 && n <= limit);
        if let Some(screen) = resources.get_mut::<Screen>()
            && fits
        {
            screen.upload(device, queue, &self.picture);
            let floats = |v: [u32; 2]| v.map(|n| n as f32);
            let background = self.picture.background.unwrap_or_default();
            let place = Place {
                origin: floats(self.origin),
                size: floats(self.size),
                picture: floats(self.picture.size),
                checker: f32::from(u8::from(self.picture.background.is_none())),
                _pad: 0.0,
                background: [background[0], background[1], background[2], 1.0],
            };
            queue.write_buffer(&screen.place, 0, bytemuck::bytes_of(&place));
        }
        Vec::new()
    }

    fn paint(
        &self,
        info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        let Some((screen, picture)) = resources.get::<Screen>().and_then(|s| Some((s, s.picture.as_ref()?))) else {
            return;
        };
        let [width, height] = info.screen_size_px;
        let clip = info.clip_rect_in_pixels();
        let least = |at: u32, other: i32| at.max(u32::try_from(other).unwrap_or(0));
        let most = |end: u32, other: i32, bound: u32| end.min(u32::try_from(other).unwrap_or(0)).min(bound);
        let (left, top) = (least(self.origin[0], clip.left_px), least(self.origin[1], clip.top_px));
        let right = most(self.origin[0].saturating_add(self.size[0]), clip.left_px + clip.width_px, width);
        let bottom = most(self.origin[1].saturating_add(self.size[1]), clip.top_px + clip.height_px, height);
        if left >= right || top >= bottom || picture.serial != self.picture.serial {
            return;
        }
        pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(left, top, right - left, bottom - top);
        pass.set_pipeline(&screen.pipeline);
        pass.set_bind_group(0, &picture.group, &[]);
        pass.draw(0..3, 0..1);
    }
}
