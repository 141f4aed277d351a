//! The techniques, one room each, with shaders in `shaders/passes/` under the same name.
//!
//! A pass reads and writes columns of the FragmentStore (`store`): layers of a pixel in depth order, found through
//! `layer_base` and `layer_count`, which exist once for rows of k slots and once for compacted lists. Everything after the
//! capture is written once and runs over either.

pub mod capture;
pub mod composite;
pub mod features;
pub mod geometry;
pub mod illustration;
pub mod opacity;
pub mod opaque;
pub mod operators;
pub mod shade;
pub mod shaders;
pub mod store;
mod uniforms;

pub use uniforms::{
    BlendParameters, CurvatureParameters, FrameUniform, IllustrationParameters, InstanceUniform, MaterialUniform,
    ModelParameters, OutlineParameters, PartFacts, Sections, ShadeParameters, StepParameters, StoreLayout,
    SweepParameters, TransferParameters,
};

use crate::gpu::{Gpu, GpuError, Recorder, Resources, ShaderSpec, Shaders};
use crate::plan::{Band, Capture, FramePlan, Pass};
use crate::settings::Technique;

/// The techniques whose accuracy can be traded for time, in the order of the stages. A new technique is listed here and
/// then part of every accuracy-time report.
pub const TECHNIQUES: &[Technique] = &[
    Technique { room: "capture/mod", axes: capture::AXES, crosses: &[] },
    Technique {
        room: "capture/bucketed_k_buffer",
        axes: capture::bucketed_k_buffer::AXES,
        crosses: capture::bucketed_k_buffer::CROSSES,
    },
    Technique { room: "capture/linked_list", axes: capture::linked_list::AXES, crosses: &[] },
    Technique { room: "store", axes: store::AXES, crosses: &[] },
    Technique { room: "features/neighbours", axes: features::neighbours::AXES, crosses: &[] },
    Technique { room: "features/curvature", axes: features::curvature::AXES, crosses: &[] },
    Technique { room: "illustration", axes: illustration::AXES, crosses: &[] },
    Technique { room: "composite/mod", axes: composite::AXES, crosses: &[] },
];

/// What every pass gets: device, shaders, the plan, the band at work and the resources.
pub struct Context<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// Compiled shaders.
    pub shaders: &'a Shaders,
    /// The plan that is executed.
    pub plan: &'a FramePlan,
    /// The rows at work.
    pub band: Band,
    /// The columns into which geometry is drawn.
    pub columns: std::ops::Range<u32>,
    /// Group 0.
    pub frame: wgpu::BindGroup,
    /// The same, with the rows in which layers are lit as those that are written.
    pub lit_frame: wgpu::BindGroup,
    /// Buffers by name.
    pub resources: &'a Resources,
    /// A target of the image's size that nothing is written to: raster passes take their size from it.
    pub blank: &'a wgpu::TextureView,
    /// Bound of the length of any pixel's list, where the capture knows one.
    pub deepest: u32,
    /// The scene's parts in draw order.
    pub instances: std::sync::Arc<geometry::Instances>,
    /// Where passes are recorded.
    pub recorder: &'a mut Recorder,
}

impl Context<'_> {
    /// Rows captured in this band.
    pub fn rows(&self) -> u32 {
        self.band.end_row - self.band.first_row
    }

    /// Width of the image.
    pub fn width(&self) -> u32 {
        self.plan.size[0]
    }

    /// A bound of the length of any pixel's list.
    pub fn longest(&self) -> u32 {
        match self.plan.capture {
            Capture::BucketedKBuffer { k, .. } => k,
            Capture::Compacted | Capture::LinkedList { .. } | Capture::None => self.deepest,
        }
    }

    /// Runs a kernel once for every pixel of the band, in groups of 16×16.
    ///
    /// # Errors
    /// [`GpuError`] if the shader does not compile or a resource is missing.
    pub fn per_pixel(&mut self, pass: Pass, spec: &ShaderSpec, entry: &str) -> Result<(), GpuError> {
        let groups = [self.width().div_ceil(16), self.rows().div_ceil(16), 1];
        self.compute(pass, spec, entry, groups)
    }

    /// Runs a kernel once for every pixel of the band and every chunk of its layers ([`features::chunk`]).
    ///
    /// # Errors
    /// [`GpuError`] if the shader does not compile or a resource is missing.
    pub fn per_chunk(&mut self, pass: Pass, spec: &ShaderSpec, entry: &str) -> Result<(), GpuError> {
        let longest = self.longest();
        let chunks = longest.div_ceil(features::chunk(self.plan, longest)).max(1);
        let groups = [self.width().div_ceil(16), self.rows().div_ceil(16), chunks];
        self.compute(pass, spec, entry, groups)
    }

    /// Runs a kernel once for every pixel of the band, in groups of 64 along rows.
    ///
    /// # Errors
    /// [`GpuError`] if the shader does not compile or a resource is missing.
    pub fn per_row_run(&mut self, pass: Pass, spec: &ShaderSpec, entry: &str) -> Result<(), GpuError> {
        let groups = [self.width().div_ceil(64), self.rows(), 1];
        self.compute(pass, spec, entry, groups)
    }

    /// Runs a kernel.
    ///
    /// # Errors
    /// [`GpuError`] if the shader does not compile or a resource is missing.
    pub fn compute(&mut self, pass: Pass, spec: &ShaderSpec, entry: &str, groups: [u32; 3]) -> Result<(), GpuError> {
        let kernel = self.shaders.kernel(spec, entry)?;
        self.recorder.compute(pass, &kernel, &self.frame, self.resources, groups)
    }
}
