//! Stage 3, opacity: transfer functions over curvature and depth (Murray 2016, section 5.2).
//!
//! The colour function over κ changes the lit colour, the opacity function over (depth, |κ|) gives opacity; depth is
//! normalized over the scene's bounding sphere. Both are tables that the GPU reads, so changing a function compiles nothing.
//! Functions that do not vary with κ need no curvature, and constant ones do not even need this pass.

use crate::gpu::{Gpu, GpuError, ShaderSpec};
use crate::passes::store::StoreModules;
use crate::passes::{Context, TransferParameters};
use crate::plan::{FramePlan, Opacity, Pass};
use crate::transfer::{ColorMode, TransferFunction};

/// Entries of the colour table and of each side of the opacity table.
pub const TABLE_SIZE: u32 = 256;

/// The uniform of a transfer function.
pub fn parameters(transfer: &TransferFunction, gain: f64, constant: f64) -> TransferParameters {
    TransferParameters {
        color_mode: match transfer.color.mode {
            ColorMode::Tint => 0,
            ColorMode::Multiply => 1,
        },
        gain: gain as f32,
        constant: constant as f32,
        _pad: 0,
    }
}

/// The tables as textures: colour (256×1) and opacity (256×256, x depth, y |κ|).
pub fn tables(gpu: &Gpu, transfer: &TransferFunction) -> [wgpu::TextureView; 2] {
    let baked = transfer.bake();
    let colors: Vec<[f32; 4]> = baked.color.iter().map(|c| [c[0], c[1], c[2], 1.0]).collect();
    let color = table(gpu, "color_table", wgpu::TextureFormat::Rgba32Float, 1, bytemuck::cast_slice(&colors));
    let opacity =
        table(gpu, "opacity_table", wgpu::TextureFormat::R32Float, TABLE_SIZE, bytemuck::cast_slice(&baked.opacity));
    [color, opacity]
}

fn table(gpu: &Gpu, label: &str, format: wgpu::TextureFormat, height: u32, data: &[u8]) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width: TABLE_SIZE, height, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let bytes_per_row = Some(data.len() as u32 / height);
    gpu.queue.write_texture(
        texture.as_image_copy(),
        data,
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None },
        size,
    );
    texture.create_view(&Default::default())
}

/// The shader of [`stylize`].
pub fn spec(plan: &FramePlan) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    let root = if plan.opacity == Opacity::Depth { "passes/opacity/depth_only" } else { "passes/opacity/curvature" };
    modules.keys(modules.layout(ShaderSpec::new(root)))
}

/// Colour and opacity of every layer.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn stylize(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::Stylize, &spec(context.plan), "main")
}
