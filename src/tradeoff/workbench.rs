//! What the sweep measures: two renderers on one device, or a stand-in for tests.
//!
//! The baseline has a renderer of its own, so that drawing it in turn with a candidate makes no buffers anew.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::gpu::{AdapterFacts, Gpu, PassTime, Timing};
use crate::math::{Camera, LinearImage};
use crate::passes::capture::LayerCounts;
use crate::plan::Capture;
use crate::render::{GpuScene, RenderError, Renderer, StoreReadback};
use crate::scene::{Arrangement, Scene};
use crate::settings::Settings;

/// Which renderer draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lane {
    /// The one that keeps the baseline ready.
    Baseline,
    /// The one for everything else.
    Candidate,
}

/// What a frame gave.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The picture.
    pub image: LinearImage,
    /// Wall time of the frame, milliseconds.
    pub milliseconds: f64,
    /// Times of the passes.
    pub passes: Vec<PassTime>,
    /// What the capture counted.
    pub counts: LayerCounts,
    /// Bytes of the frame's buffers.
    pub buffer_bytes: u64,
    /// The layers, if they were asked for and can be read.
    pub layers: Option<Layers>,
}

/// The layers of a frame.
#[derive(Clone, Debug)]
pub struct Layers {
    /// The store.
    pub store: StoreReadback,
    /// Whether its keys hold triangle numbers.
    pub wide: bool,
}

/// What is asked of a frame besides the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The layers, where the frame has one band and one sample.
    pub layers: bool,
    /// Times of the passes ([`AdapterFacts::pass_timing`]). Where each is run alone, the frame as a whole is slower.
    pub pass_times: bool,
}

/// Draws one scene from one camera.
pub trait Workbench {
    /// Draws a frame.
    ///
    /// # Errors
    /// [`RenderError`] says what was refused or failed.
    fn draw(&mut self, lane: Lane, settings: &Settings, size: [u32; 2], wanted: Wanted) -> Result<Drawn, RenderError>;

    /// How long draws have waited for their turn so far: nobody's time, neither a frame's nor a limit's.
    fn idle(&self) -> Duration {
        Duration::ZERO
    }
}

/// The renderer as a workbench.
pub struct RendererBench {
    lanes: [(Renderer, GpuScene); 2],
    camera: Camera,
}

impl RendererBench {
    /// Uploads the scene, once for each lane.
    ///
    /// # Errors
    /// [`RenderError`] of the device.
    pub fn new(gpu: &Gpu, scene: &Scene, camera: &Camera) -> Result<RendererBench, RenderError> {
        let lane = || {
            let mut renderer = Renderer::new(gpu.clone())?;
            let loaded = renderer.load(scene)?;
            Ok::<_, RenderError>((renderer, loaded))
        };
        Ok(RendererBench { lanes: [lane()?, lane()?], camera: *camera })
    }

    /// Shows the parts of the uploaded scene as `arrangement` says.
    ///
    /// # Errors
    /// [`RenderError::Arrangement`] if it does not fit the scene.
    pub fn arrange(&mut self, scene: &Scene, arrangement: &Arrangement) -> Result<(), RenderError> {
        for (renderer, loaded) in &mut self.lanes {
            renderer.arrange(loaded, scene, arrangement)?;
        }
        Ok(())
    }

    /// Gives frames up, where they are drawn pass by pass, while this is raised.
    pub fn cancelled_by(&mut self, raised: &Arc<AtomicBool>) {
        for (renderer, _) in &mut self.lanes {
            renderer.cancel = Some(Arc::clone(raised));
        }
    }

    /// The adapter.
    pub fn facts(&self) -> &AdapterFacts {
        self.lanes[0].0.gpu().facts()
    }
}

impl Workbench for RendererBench {
    fn draw(&mut self, lane: Lane, settings: &Settings, size: [u32; 2], wanted: Wanted) -> Result<Drawn, RenderError> {
        let (renderer, scene) = &mut self.lanes[usize::from(lane == Lane::Candidate)];
        renderer.timing = if wanted.pass_times { renderer.gpu().facts().pass_timing() } else { Timing::Timestamps };
        let frame = renderer.render(scene, &self.camera, settings, size)?;
        let report = frame.report;
        let plan = &report.plan;
        let readable = report.bands == 1 && plan.samples == 1 && plan.capture != Capture::None;
        let layers = if wanted.layers && readable {
            let store = renderer.read_store(&report, scene, &self.camera)?;
            Some(Layers { store, wide: plan.capture.is_wide() })
        } else {
            None
        };
        Ok(Drawn {
            image: frame.image,
            milliseconds: report.milliseconds,
            passes: report.passes,
            counts: report.layers,
            buffer_bytes: report.buffer_bytes,
            layers,
        })
    }
}
