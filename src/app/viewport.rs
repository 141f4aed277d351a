//! The picture in the window: pixel for pixel, past egui's colours.
//!
//! An exact picture has as many pixels as the viewport, and each goes to its place unchanged: no filter, no blending, no
//! dithering, so a screenshot of the viewport is the PNG of `pellucid render`. Any other picture (a preview, or one of a moment
//! ago while the view moves) is *moved along*: shown as if all of it lay in the plane of the focal point, which is right for
//! moving and zooming there and near enough for small turns, so that the window answers before anything is drawn anew.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec2, DVec3, DVec4};

use crate::math::{Bounds, Camera};

/// The shader.
const SHADER: &str = concat!(include_str!("encoding.wgsl"), include_str!("viewport.wgsl"));
/// A texture that is filtered.
pub const FILTERED: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: true },
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

/// The constants of a shader that draws into a surface of this format.
pub fn encoding(format: wgpu::TextureFormat) -> [(&'static str, f64); 1] {
    [("encodes", f64::from(u8::from(format.is_srgb())))]
}

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
    /// Which of the two pictures that can be on screen at once it is, 0 or 1; egui's clipping says where.
    pub slot: usize,
    /// Left and top, pixels of the window.
    pub origin: [u32; 2],
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// From the viewport to the picture, both from −1 to 1 with y up, homogeneous ([`moved_along`]); `None` if the picture is of
    /// just this view.
    pub moved: Option<DMat3>,
}

impl Paint {
    /// The callback, as a shape of egui's.
    pub fn within(self, rect: egui::Rect) -> egui::Shape {
        egui::Shape::Callback(egui::PaintCallback { rect, callback: Arc::new(self) })
    }
}

/// A view: a camera and the size of its viewport, pixels.
pub type View<'a> = (&'a Camera, [u32; 2]);

/// Where in the picture of one view a point of another's viewport is found, if it lies in the plane of the new focal point that
/// faces both; `None` if that cannot be said.
pub fn moved_along(then: View<'_>, now: View<'_>, bounds: &Bounds) -> Option<DMat3> {
    let facing = (then.0.direction() + now.0.direction()).try_normalize()?;
    let right = facing.any_orthonormal_vector();
    let up = right.cross(facing);
    let origin = now.0.focal_point;
    // Clip x, y and w of the plane's points, as a matrix on (u, v, 1).
    let clip_from_plane = |(camera, size): View<'_>| {
        let clip = camera.clip_from_view(camera.frustum(bounds), size, DVec2::ZERO) * camera.view_from_world();
        let column = |p: DVec3, w: f64| {
            let c: DVec4 = clip * p.extend(w);
            DVec3::new(c.x, c.y, c.w)
        };
        DMat3::from_cols(column(right, 0.0), column(up, 0.0), column(origin, 1.0))
    };
    let plane_from_now = clip_from_plane(now).inverse();
    let moved = clip_from_plane(then) * plane_from_now;
    moved.is_finite().then_some(moved)
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Place {
    origin: [f32; 2],
    size: [f32; 2],
    moved: [[f32; 4]; 3],
    background: [f32; 4],
    checker: f32,
    _pad: [f32; 3],
}

/// What is kept on the window's device between frames.
pub struct Screen {
    /// Pixel for pixel.
    unchanged: wgpu::RenderPipeline,
    /// Moved along and filtered. Apart, because a CPU rasterizer executes the branch that is not taken too.
    moved: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
    layout: wgpu::BindGroupLayout,
    slots: [Slot; 2],
}

/// Room for a picture.
struct Slot {
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
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
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
                entry(0, FILTERED),
                entry(
                    1,
                    wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                ),
                entry(2, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
            ],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("viewport"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let encodes = encoding(format);
        let pipeline = |show| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(show),
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
                    entry_point: Some(show),
                    compilation_options: wgpu::PipelineCompilationOptions { constants: &encodes, ..Default::default() },
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let place = || {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("viewport"),
                size: std::mem::size_of::<Place>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("viewport"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let (unchanged, moved) = (pipeline("unchanged"), pipeline("moved"));
        let slots = [(); 2].map(|()| Slot { place: place(), picture: None });
        Screen { unchanged, moved, sampler, layout, slots }
    }

    fn upload(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, slot: usize, shown: &Shown) {
        let Some(Slot { place, picture }) = self.slots.get_mut(slot) else {
            return;
        };
        if picture.as_ref().is_some_and(|p| p.serial == shown.serial) {
            return;
        }
        let size = wgpu::Extent3d { width: shown.size[0], height: shown.size[1], depth_or_array_layers: 1 };
        let (texture, group) = match picture.take() {
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
                        wgpu::BindGroupEntry { binding: 1, resource: place.as_entire_binding() },
                        wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(&self.sampler) },
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
        *picture = Some(OnScreen { serial: shown.serial, texture, group });
    }
}

impl Paint {
    /// Brings the picture to the device, unless it is there.
    pub fn upload(&self, device: &wgpu::Device, queue: &wgpu::Queue, screen: &mut Screen) {
        let limit = device.limits().max_texture_dimension_2d;
        if !self.picture.size.iter().all(|&n| n > 0 && n <= limit) {
            return;
        }
        screen.upload(device, queue, self.slot, &self.picture);
        let floats = |v: [u32; 2]| v.map(|n| n as f32);
        let moved = self.moved.unwrap_or(DMat3::IDENTITY);
        let background = self.picture.background.unwrap_or_default();
        let place = Place {
            origin: floats(self.origin),
            size: floats(self.size),
            moved: [moved.x_axis, moved.y_axis, moved.z_axis].map(|c| c.as_vec3().extend(0.0).to_array()),
            checker: f32::from(u8::from(self.picture.background.is_none())),
            _pad: [0.0; 3],
            background: [background[0], background[1], background[2], 1.0],
        };
        if let Some(slot) = screen.slots.get(self.slot) {
            queue.write_buffer(&slot.place, 0, bytemuck::bytes_of(&place));
        }
    }

    /// Draws it where egui's clipping lets it show. The pass's viewport and pipeline are other ones then.
    pub fn paint(&self, info: &egui::PaintCallbackInfo, pass: &mut wgpu::RenderPass, screen: &Screen) {
        let Some(picture) = screen.slots.get(self.slot).and_then(|s| s.picture.as_ref()) else {
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
        let unchanged = self.moved.is_none() && self.picture.size == self.size;
        pass.set_pipeline(if unchanged { &screen.unchanged } else { &screen.moved });
        pass.set_bind_group(0, &picture.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::camera::{self, Frame};

    #[test]
    fn points_of_the_focal_plane_are_found_where_they_were() {
        let bounds = Bounds::of_points([DVec3::NEG_ONE, DVec3::ONE]);
        let then = camera::first(&bounds, 2.0);
        let frame = Frame { size: DVec2::new(400.0, 300.0) };
        let flat = camera::other_projection(&then);
        for now in [
            camera::pan(&then, frame, DVec2::new(31.0, -9.0)),
            camera::zoom(&then, frame, DVec2::new(50.0, 60.0), 0.7, &bounds),
            camera::pan(&flat, frame, DVec2::new(31.0, -9.0)),
        ] {
            let moved = moved_along((&then, [200, 100]), (&now, [400, 300]), &bounds).unwrap();
            for pixel in [DVec2::new(10.0, 20.0), DVec2::new(390.0, 150.0)] {
                let point = frame.point_at(&now, pixel);
                let clip = |camera: &Camera, size| {
                    let clip = camera.clip_from_view(camera.frustum(&bounds), size, DVec2::ZERO);
                    (clip * camera.view_from_world()).project_point3(point).truncate()
                };
                let (at, wanted) = (clip(&now, [400, 300]), clip(&then, [200, 100]));
                let found = moved * at.extend(1.0);
                assert!((found.truncate() / found.z - wanted).length() < 1e-9, "{pixel}");
            }
        }
        let same = moved_along((&then, [200, 100]), (&then, [200, 100]), &bounds).unwrap();
        assert!((same * (1.0 / same.z_axis.z)).abs_diff_eq(DMat3::IDENTITY, 1e-9));
        let behind = Camera { position: then.focal_point * 2.0 - then.position, ..then };
        assert!(moved_along((&then, [9, 9]), (&behind, [9, 9]), &bounds).is_none(), "from the other side");
    }

    #[test]
    fn the_shader_is_valid_and_its_uniform_is_ours() {
        let module = naga::front::wgsl::parse_str(SHADER).unwrap_or_else(|e| panic!("{e}"));
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), Default::default());
        validator.validate(&module).unwrap();
        let sizes = module.types.iter().filter_map(|(_, t)| match &t.inner {
            naga::TypeInner::Struct { span, .. } if t.name.as_deref() == Some("Place") => Some(*span as usize),
            _ => None,
        });
        assert_eq!(sizes.collect::<Vec<_>>(), [std::mem::size_of::<Place>()]);
    }
}
