//! Scene and settings in, image out: the one renderer behind the command line, the window, the tests and the benchmarks.

mod frame;
mod histogram;
mod layers;
mod pick;
mod readback;
mod reuse;
mod targets;
mod whole;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use crate::gpu::{AdapterFacts, Gpu, GpuError, PassTime, Resources, Shaders, Timing};
use crate::math::{Bounds, Camera, LinearImage};
use crate::passes::capture::LayerCounts;
pub use crate::passes::geometry::{DrawOrder, GpuScene};
use crate::plan::{self, FramePlan, Refusal, ViewStats};
use crate::scene::{Arrangement, ArrangementError, Presence, Scene};
use crate::settings::{OpacityModel, Settings};
use crate::transfer::{TransferError, TransferFunction};

pub use histogram::LayerHistogram;
pub use layers::Layers;
pub use pick::PickedLayer;
pub use readback::{PixelBuckets, StoreReadback};
pub use reuse::Kept;

/// Why a picture was not drawn.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The plan cannot be made on this adapter.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The device failed.
    #[error(transparent)]
    Gpu(GpuError),
    /// The picture was no longer wanted: [`Renderer::cancel`].
    #[error("cancelled")]
    Cancelled,
    /// The transfer functions could not be read.
    #[error(transparent)]
    Transfer(#[from] TransferError),
    /// The colour of the outline is none.
    #[error("outline.color = '{color}': expected the form #rrggbb")]
    OutlineColor {
        /// What it says.
        color: String,
    },
    /// The arrangement does not fit the scene.
    #[error(transparent)]
    Arrangement(#[from] ArrangementError),
    /// One pixel has more layers than a list may have.
    #[error(
        "a pixel has {layers} layers; a list holds {limit}. capture.kind = bucketed_k_buffer keeps the nearest k and counts \
         the rest"
    )]
    PixelTooDeep {
        /// Layers of the deepest pixel.
        layers: u32,
        /// Layers that a list may have.
        limit: u32,
    },
    /// One row of pixels has more fragments than a binding holds.
    #[error(
        "row {row} of the image has {fragments} fragments with its neighbours; a binding of this adapter holds {limit}. \
         A smaller image or curvature radius is needed"
    )]
    RowTooDeep {
        /// Row of the image.
        row: u32,
        /// Fragments of its smallest band.
        fragments: u64,
        /// Fragments that fit.
        limit: u64,
    },
    /// One row of pixels has more fragments than the memory of linked lists holds.
    #[error(
        "row {row} of the image has {fragments} fragments with its neighbours; capture.linked_list.memory = {memory} MiB \
         holds {limit}"
    )]
    ListsTooLarge {
        /// Row of the image.
        row: u32,
        /// Fragments of its smallest band.
        fragments: u64,
        /// Fragments that fit.
        limit: u64,
        /// Memory that is allowed, MiB.
        memory: u64,
    },
}

impl From<GpuError> for RenderError {
    fn from(error: GpuError) -> RenderError {
        if error == GpuError::Cancelled { RenderError::Cancelled } else { RenderError::Gpu(error) }
    }
}

/// What drawing a frame cost and counted.
#[derive(Clone, Debug, Serialize)]
pub struct FrameReport {
    /// Layers, over all samples.
    pub layers: LayerCounts,
    /// GPU time of every pass; empty without timestamp queries.
    pub passes: Vec<PassTime>,
    /// Wall time of the whole frame, milliseconds.
    pub milliseconds: f64,
    /// Bands that it took.
    pub bands: usize,
    /// What was taken from the frame before, which `passes` then lacks: see [`Renderer::keeps_layers`].
    pub kept: Kept,
    /// Bands whose linked lists were filled a second time, because the buffers had been too small for all fragments.
    pub refilled: u32,
    /// Bytes of the buffers that the frame used.
    pub buffer_bytes: u64,
    /// What was executed.
    pub plan: FramePlan,
    /// Who executed it.
    pub adapter: AdapterFacts,
}

/// What became of a scene's parts.
#[derive(Clone, Debug, PartialEq)]
pub struct ArrangementReport {
    /// Parts that are shown.
    pub shown: usize,
    /// Parts that are ghosted.
    pub ghosted: usize,
    /// Parts that are not drawn.
    pub hidden: usize,
    /// The box around what is drawn, in scene space.
    pub bounds: Bounds,
    /// Caps that close what section planes cut.
    pub caps: usize,
    /// What a user should know: parts that could not be closed, one sentence a section.
    pub notices: Vec<String>,
}

/// A picture and its report.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The picture.
    pub image: LinearImage,
    /// The report.
    pub report: FrameReport,
}

/// Draws scenes.
pub struct Renderer {
    gpu: Gpu,
    shaders: Shaders,
    resources: Resources,
    /// In which order parts are drawn.
    pub draw_order: DrawOrder,
    /// How passes are timed.
    pub timing: Timing,
    /// Raised from another thread when the picture at work is no longer wanted. It is looked at between bands and samples
    /// and, under [`Timing::Serial`], between passes.
    pub cancel: Option<Arc<AtomicBool>>,
    /// Whether a frame may begin with the layers of the one before where they are the same, as while a transfer function is
    /// dragged. Off by default, because then times are not those of whole frames.
    pub keeps_layers: bool,
    stored: Option<reuse::Stored>,
    /// The last transfer functions and their tables.
    tables: Option<(TransferFunction, [wgpu::Buffer; 2])>,
    targets: Option<targets::Targets>,
    /// The layers of each band of the last frame; a frame that finds something here keeps its own.
    collected: Option<Vec<StoreReadback>>,
    picking: pick::Picking,
}

impl Renderer {
    /// A renderer on this device.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] if the device failed.
    pub fn new(gpu: Gpu) -> Result<Renderer, RenderError> {
        let shaders = Shaders::new(&gpu);
        gpu.check()?;
        Ok(Renderer {
            gpu,
            shaders,
            resources: Resources::default(),
            draw_order: DrawOrder::default(),
            timing: Timing::default(),
            cancel: None,
            keeps_layers: false,
            stored: None,
            tables: None,
            targets: None,
            collected: None,
            picking: pick::Picking::default(),
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Compiled shaders.
    pub fn shaders(&self) -> &Shaders {
        &self.shaders
    }

    /// Lets another text stand in for a shader module: see [`Shaders::replace`].
    pub fn replace_shader(&mut self, module: &str, text: Option<String>) {
        self.shaders.replace(module, text);
    }

    /// Compiles what sorts the lists of a plan, however long they are: a frame compiles no more of it than it needs, so a later
    /// one with longer lists would take half a second for it.
    ///
    /// # Errors
    /// [`GpuError`] if a shader does not compile.
    pub fn warm_up(&self, plan: &FramePlan) -> Result<(), GpuError> {
        for (spec, entries) in crate::passes::shaders::sorts(plan) {
            for entry in entries {
                self.shaders.kernel(&spec, entry)?;
            }
        }
        self.gpu.check()
    }

    /// Uploads a finished scene.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] if memory runs out.
    pub fn load(&mut self, scene: &Scene) -> Result<GpuScene, RenderError> {
        Ok(GpuScene::upload(&self.gpu, &self.shaders.shared, scene, None)?)
    }

    /// Uploads a scene with the triangles of every primitive in another order; the picture must not change (T27).
    ///
    /// # Errors
    /// [`RenderError::Gpu`] if memory runs out.
    pub fn load_shuffled(&mut self, scene: &Scene, seed: u64) -> Result<GpuScene, RenderError> {
        Ok(GpuScene::upload(&self.gpu, &self.shaders.shared, scene, Some(seed))?)
    }

    /// Shows the parts of an uploaded scene as `arrangement` says, from the next frame on. `scene` is what was uploaded.
    ///
    /// # Errors
    /// [`RenderError::Arrangement`] if it does not fit the scene, which then stays as it was.
    pub fn arrange(
        &self,
        loaded: &mut GpuScene,
        scene: &Scene,
        arrangement: &Arrangement,
    ) -> Result<ArrangementReport, RenderError> {
        arrangement.check(scene)?;
        loaded.arrange(&self.gpu, &self.shaders.shared, scene, arrangement)?;
        let count = |presence| {
            let parts = 0..scene.parts.len() as u32;
            parts.filter(|&part| arrangement.look(part).presence == presence).count()
        };
        Ok(ArrangementReport {
            shown: count(Presence::Shown),
            ghosted: count(Presence::Ghosted),
            hidden: count(Presence::Hidden),
            bounds: loaded.stats.bounds,
            caps: loaded.cut.caps.len(),
            notices: loaded.cut.notices(scene),
        })
    }

    /// What a frame would do.
    ///
    /// # Errors
    /// [`RenderError::Refused`] if it cannot be drawn here.
    pub fn plan(
        &self,
        scene: &GpuScene,
        camera: &Camera,
        settings: &Settings,
        size: [u32; 2],
    ) -> Result<FramePlan, RenderError> {
        let transfer = settings.opacity.transfer.resolve(None)?;
        Ok(plan::plan(settings, &transfer, &scene.stats, &ViewStats::of(camera), self.gpu.capabilities(), size)?)
    }

    /// Draws a picture. Transfer functions that the settings name are read anew, from their file if it is one: for many pictures
    /// resolve them once and call [`Renderer::render_with`].
    ///
    /// # Errors
    /// [`RenderError`] says what was refused or failed.
    pub fn render(
        &mut self,
        scene: &GpuScene,
        camera: &Camera,
        settings: &Settings,
        size: [u32; 2],
    ) -> Result<Frame, RenderError> {
        let transfer: TransferFunction = settings.opacity.transfer.resolve(None)?;
        self.render_with(scene, camera, settings, &transfer, size)
    }

    /// Draws a picture with transfer functions that are already resolved.
    ///
    /// # Errors
    /// [`RenderError`] says what was refused or failed.
    pub fn render_with(
        &mut self,
        scene: &GpuScene,
        camera: &Camera,
        settings: &Settings,
        transfer: &TransferFunction,
        size: [u32; 2],
    ) -> Result<Frame, RenderError> {
        let view = ViewStats::of(camera);
        let plan = plan::plan(settings, transfer, &scene.stats, &view, self.gpu.capabilities(), size)?;
        frame::draw(self, scene, camera, settings, transfer, plan)
    }

    /// Wall time, in milliseconds, of the same picture with every fragment lit and blended as it comes: the lower bound of
    /// what transparency can cost, and a wrong picture. For benchmarks; nothing is returned but the time.
    ///
    /// # Errors
    /// [`RenderError`] says what was refused or failed.
    pub fn time_unsorted(
        &mut self,
        scene: &GpuScene,
        camera: &Camera,
        settings: &Settings,
        size: [u32; 2],
    ) -> Result<f64, RenderError> {
        let mut settings = settings.clone();
        settings.opacity.model = OpacityModel::Constant;
        let transfer = settings.opacity.transfer.resolve(None)?;
        let view = ViewStats::of(camera);
        let mut plan = plan::plan(&settings, &transfer, &scene.stats, &view, self.gpu.capabilities(), size)?;
        // It captures nothing: only what the lights and the blend need is bound.
        plan.capture = plan::Capture::None;
        plan.passes.clear();
        plan.buffers.clear();
        frame::time_unsorted(self, scene, camera, &settings, &transfer, &plan)
    }
}
