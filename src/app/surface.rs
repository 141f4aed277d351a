//! The window's own device: its surface and egui's painting on it.
//!
//! A surface of no size or beyond the largest texture is a validation error, so the first is not drawn and the second is
//! clamped. A lost or outdated surface is configured again; after a lost device everything here is made anew.

mod damage;
mod painter;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use wgpu::CurrentSurfaceTexture as Current;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use damage::Damage;
use painter::Painter;

use super::AppError;

/// Surfaces that are made anew in a row before the device is held to be lost.
const MOST_REMADE: u32 = 8;

/// The window's last frame.
struct Canvas {
    /// As large as the surface, once there has been a frame.
    texture: Option<wgpu::Texture>,
    damage: Damage,
}

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawn {
    /// It is on its way to the display.
    Presented,
    /// Nothing can be drawn now; the window system will say when.
    Skipped,
    /// It has to be drawn again at once.
    Again,
    /// The device is gone.
    Lost,
}

/// A device that draws into a window.
pub struct Surface {
    window: Arc<Window>,
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    device: wgpu::Device,
    queue: wgpu::Queue,
    config: wgpu::SurfaceConfiguration,
    largest: u32,
    painter: Painter,
    /// The window's last frame, where only what has changed is drawn: on a software rasterizer.
    canvas: Option<Canvas>,
    lost: Arc<AtomicBool>,
    /// Surfaces that were made anew since the last one that could be drawn on.
    remade: u32,
    #[cfg(debug_assertions)]
    surface_lost: bool,
    reported: Arc<Mutex<Option<String>>>,
}

impl Surface {
    /// Opens a device for a window.
    ///
    /// # Errors
    /// [`AppError::Display`] if no adapter can draw into it.
    pub fn new(event_loop: &ActiveEventLoop, window: Arc<Window>) -> Result<Surface, AppError> {
        let refused = |e: &dyn std::fmt::Display| AppError::Display(e.to_string());
        let display = Box::new(event_loop.owned_display_handle());
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_with_display_handle_from_env(display));
        let surface = instance.create_surface(Arc::clone(&window)).map_err(|e| refused(&e))?;
        let adapter = pollster::block_on(wgpu::util::initialize_adapter_from_env_or_default(&instance, Some(&surface)))
            .map_err(|e| refused(&e))?;
        let limits = adapter.limits();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("window"),
            required_limits: wgpu::Limits::downlevel_defaults().using_resolution(limits.clone()),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| refused(&e))?;
        let lost: Arc<AtomicBool> = Arc::default();
        let noticed = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            tracing::error!("the window's device was lost ({reason:?}): {message}");
            noticed.store(true, Ordering::Relaxed);
        });
        let reported: Arc<Mutex<Option<String>>> = Arc::default();
        let kept = Arc::clone(&reported);
        device.on_uncaptured_error(Arc::new(move |error| {
            let text = error.to_string();
            tracing::error!("the window's device reports: {text}");
            *kept.lock().unwrap_or_else(PoisonError::into_inner) = Some(text);
        }));
        let capabilities = surface.get_capabilities(&adapter);
        // What is drawn is sRGB already, so the surface must not encode it once more.
        let format = capabilities
            .formats
            .iter()
            .copied()
            .find(|f| matches!(f, wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Rgba8Unorm))
            .or(capabilities.formats.first().copied())
            .ok_or_else(|| AppError::Display(format!("'{}' cannot draw into windows", adapter.get_info().name)))?;
        // Frames are drawn only when something changed, so waiting for the display would only delay them.
        let present_mode = [wgpu::PresentMode::Mailbox, wgpu::PresentMode::Immediate]
            .into_iter()
            .find(|m| capabilities.present_modes.contains(m))
            .unwrap_or(wgpu::PresentMode::Fifo);
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| AppError::Display(format!("'{}' cannot draw into windows", adapter.get_info().name)))?;
        config.format = format;
        config.present_mode = present_mode;
        config.desired_maximum_frame_latency = 1;
        let software = adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        let canvas = (software && capabilities.usages.contains(wgpu::TextureUsages::COPY_DST)).then(|| {
            config.usage |= wgpu::TextureUsages::COPY_DST;
            Canvas { texture: None, damage: Damage::default() }
        });
        let painter = Painter::new(&device, format);
        let largest = device.limits().max_texture_dimension_2d;
        tracing::debug!("window: {}, {format:?}, {present_mode:?}", adapter.get_info().name);
        let mut new = Surface {
            window,
            instance,
            surface,
            device,
            queue,
            config,
            largest,
            painter,
            canvas,
            lost,
            remade: 0,
            #[cfg(debug_assertions)]
            surface_lost: false,
            reported,
        };
        new.configure();
        Ok(new)
    }

    /// The largest texture, which bounds egui's.
    pub fn largest(&self) -> u32 {
        self.largest
    }

    /// What the device has complained about since the last call.
    pub fn complaint(&self) -> Option<String> {
        self.reported.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Takes over the window's size. Nothing is drawn into a window of no size.
    fn configure(&mut self) -> bool {
        let size = self.window.inner_size();
        if size.width == 0 || size.height == 0 {
            return false;
        }
        self.config.width = size.width.min(self.largest);
        self.config.height = size.height.min(self.largest);
        self.surface.configure(&self.device, &self.config);
        true
    }

    /// Changes egui's textures and draws.
    pub fn draw(
        &mut self,
        shapes: &[egui::ClippedPrimitive],
        mut textures: egui::TexturesDelta,
        pixels_per_point: f32,
        trace: bool,
    ) -> Drawn {
        if let Some(canvas) = &mut self.canvas {
            canvas.damage.repaint(&textures);
        }
        // Taken out, not looked at: what is left when a delta is dropped counts as forgotten.
        let set = std::mem::take(&mut textures.set);
        // Egui and wgpu panic where a device goes away between two calls.
        let drawn = catch_unwind(AssertUnwindSafe(|| {
            for (id, deltas) in set {
                for delta in &deltas {
                    self.painter.update_texture(&self.device, &self.queue, id, delta);
                }
            }
            self.present(shapes, pixels_per_point, trace)
        }));
        let drawn = drawn.unwrap_or(Drawn::Lost);
        for id in std::mem::take(&mut textures.free) {
            self.painter.free_texture(id);
        }
        if self.lost.load(Ordering::Relaxed) { Drawn::Lost } else { drawn }
    }

    /// The texture to draw the next frame into.
    fn acquire(&mut self) -> Current {
        #[cfg(debug_assertions)]
        if std::mem::take(&mut self.surface_lost) {
            return Current::Lost;
        }
        self.surface.get_current_texture()
    }

    /// Loses the device, or only the surface, as happens when a graphics driver is restarted: for tests.
    #[cfg(debug_assertions)]
    pub fn lose(&mut self, only_the_surface: bool) {
        if only_the_surface {
            self.surface_lost = true;
        } else {
            self.device.destroy();
        }
    }

    fn present(&mut self, shapes: &[egui::ClippedPrimitive], pixels_per_point: f32, trace: bool) -> Drawn {
        let size = self.window.inner_size();
        let clamped = [size.width.min(self.largest), size.height.min(self.largest)];
        if clamped != [self.config.width, self.config.height] && !self.configure() || clamped.contains(&0) {
            return Drawn::Skipped;
        }
        let (frame, stale) = match self.acquire() {
            Current::Success(frame) => (frame, false),
            Current::Suboptimal(frame) => (frame, true),
            Current::Outdated | Current::Lost if self.remade >= MOST_REMADE => return Drawn::Lost,
            Current::Outdated => {
                self.remade += 1;
                self.configure();
                return Drawn::Again;
            }
            Current::Lost => {
                self.remade += 1;
                tracing::warn!("the window's surface was lost and is made anew");
                match self.instance.create_surface(Arc::clone(&self.window)) {
                    Ok(surface) => self.surface = surface,
                    Err(e) => {
                        tracing::error!("the window's surface cannot be made anew: {e}");
                        return Drawn::Lost;
                    }
                }
                self.configure();
                return Drawn::Again;
            }
            Current::Timeout => return Drawn::Again,
            Current::Occluded => return Drawn::Skipped,
            Current::Validation => return Drawn::Lost,
        };
        self.remade = 0;
        let size = [self.config.width, self.config.height];
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let kept = self.canvas.is_some();
        let (target, patches) = match &mut self.canvas {
            None => (&frame.texture, None),
            Some(canvas) => canvas.begin(&self.device, &frame.texture, shapes, pixels_per_point),
        };
        let patch = patches.as_deref();
        let (shapes, load) = match patch {
            None => (shapes, wgpu::LoadOp::Clear(wgpu::Color::BLACK)),
            Some(patch) => (patch, wgpu::LoadOp::Load),
        };
        self.painter.upload(&self.device, &self.queue, shapes, size, pixels_per_point);
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("window"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &target.create_view(&Default::default()),
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
                })],
                depth_stencil_attachment: None,
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            self.painter.paint(&mut pass, size);
        }
        if kept {
            encoder.copy_texture_to_texture(target.as_image_copy(), frame.texture.as_image_copy(), target.size());
        }
        self.queue.submit([encoder.finish()]);
        self.window.pre_present_notify();
        self.queue.present(frame);
        if trace {
            // Only then is a time up to here one of a picture that is there.
            let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
        }
        if stale {
            self.configure();
        }
        Drawn::Presented
    }
}

impl Canvas {
    /// Where to draw a frame for this surface, and what: only the patches that differ from what is there, or all of it.
    fn begin(
        &mut self,
        device: &wgpu::Device,
        surface: &wgpu::Texture,
        shapes: &[egui::ClippedPrimitive],
        pixels_per_point: f32,
    ) -> (&wgpu::Texture, Option<Vec<egui::ClippedPrimitive>>) {
        let size = surface.size();
        if self.texture.as_ref().is_some_and(|t| t.size() != size) {
            self.texture = None;
        }
        if self.texture.is_none() {
            self.damage.forget();
        }
        let points = egui::vec2(size.width as f32, size.height as f32) / pixels_per_point;
        let patches = self.damage.of(shapes, points, pixels_per_point);
        let texture = self.texture.get_or_insert_with(|| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("window"),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: surface.format(),
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        });
        (texture, patches.map(|rects| damage::within(shapes, &rects)))
    }
}
