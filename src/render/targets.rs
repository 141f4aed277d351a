//! The textures that a renderer keeps from frame to frame.

use crate::gpu::{Gpu, GpuError};
use crate::plan::{FramePlan, Pass};

/// Textures of the image's size.
pub(super) struct Targets {
    size: [u32; 2],
    /// What the composition writes.
    pub(super) image: wgpu::Texture,
    /// Gives raster passes their size; never written.
    pub(super) blank: wgpu::TextureView,
    /// Sums of jittered frames, read and written in turn.
    pub(super) sums: Option<[wgpu::Texture; 2]>,
    /// Colours and depth of the opaque pass.
    pub(super) opaque: Option<[wgpu::TextureView; 2]>,
    /// What the selected parts cover.
    pub(super) mask: Option<wgpu::TextureView>,
}

/// A texture of one level.
pub(super) fn texture(
    gpu: &Gpu,
    label: &str,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// A target that gives raster passes their size; never written.
pub(super) fn blank(gpu: &Gpu, size: [u32; 2]) -> wgpu::TextureView {
    let (format, usage) = (wgpu::TextureFormat::R8Unorm, wgpu::TextureUsages::RENDER_ATTACHMENT);
    texture(gpu, "blank", size, format, usage).create_view(&Default::default())
}

impl Targets {
    /// The blank target, if it has this size.
    pub(super) fn blank(&self, size: [u32; 2]) -> Option<&wgpu::TextureView> {
        (self.size == size).then_some(&self.blank)
    }

    /// Keeps what fits the plan and makes the rest.
    ///
    /// # Errors
    /// [`GpuError`] of the device.
    pub(super) fn ensure<'a>(
        kept: &'a mut Option<Targets>,
        gpu: &Gpu,
        plan: &FramePlan,
    ) -> Result<&'a Targets, GpuError> {
        use wgpu::{TextureFormat as Format, TextureUsages as Usage};
        let image_usage = Usage::STORAGE_BINDING | Usage::TEXTURE_BINDING | Usage::COPY_SRC | Usage::COPY_DST;
        let image = |label| texture(gpu, label, plan.size, Format::Rgba32Float, image_usage);
        let old = kept.take().filter(|t| t.size == plan.size);
        let mut targets = old.unwrap_or_else(|| Targets {
            size: plan.size,
            image: image("image"),
            blank: blank(gpu, plan.size),
            sums: None,
            opaque: None,
            mask: None,
        });
        if !plan.runs(Pass::OutlineMask) {
            targets.mask = None;
        } else if targets.mask.is_none() {
            let usage = Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING;
            let mask = texture(gpu, "outline mask", plan.size, Format::R8Unorm, usage);
            targets.mask = Some(mask.create_view(&Default::default()));
        }
        if !plan.runs(Pass::Accumulate) {
            targets.sums = None;
        } else if targets.sums.is_none() {
            let usage = image_usage | Usage::RENDER_ATTACHMENT;
            targets.sums =
                Some(["sum", "other sum"].map(|label| texture(gpu, label, plan.size, Format::Rgba32Float, usage)));
        }
        if !plan.runs(Pass::Opaque) {
            targets.opaque = None;
        } else if targets.opaque.is_none() {
            let usage = Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING;
            targets.opaque = Some([
                texture(gpu, "opaque colours", plan.size, Format::Rg32Uint, usage).create_view(&Default::default()),
                texture(gpu, "opaque depth", plan.size, Format::Depth32Float, Usage::RENDER_ATTACHMENT)
                    .create_view(&Default::default()),
            ]);
        }
        gpu.check()?;
        Ok(kept.insert(targets))
    }
}
