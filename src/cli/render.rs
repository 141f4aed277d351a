//! The renderer as the command line sees it. But for the sweep, nothing else in this room names the GPU, the planner or the
//! renderer.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::failure::{Exit, Failure, printable};
use super::output::grouped;
use crate::gpu::{AdapterFacts, Gpu, GpuError, GpuOptions, Timing};
use crate::math::Camera;
use crate::plan::{Capture, FramePlan};
use crate::render::{Frame, GpuScene, RenderError};
pub use crate::render::{FrameReport, Layers, Renderer};
use crate::scene::{Arrangement, Scene};
use crate::settings::Settings;
use crate::tradeoff::flicker::{self, Orbit, OrbitOptions};

/// A scene on an adapter.
pub struct Session {
    renderer: Renderer,
    scene: GpuScene,
    /// What the arrangement could not do, one sentence each.
    pub notices: Vec<String>,
}

impl Session {
    /// Takes an adapter (`WGPU_BACKEND` and `WGPU_ADAPTER_NAME` choose among several) and uploads the scene.
    ///
    /// # Errors
    /// [`Exit::NoAdapter`], or as [`Session::render`].
    pub fn open(scene: &Scene) -> Result<Session, Failure> {
        let gpu = Gpu::new(&GpuOptions::default()).map_err(|e| Failure::of(Exit::NoAdapter, &e))?;
        let mut renderer = Renderer::new(gpu).map_err(failed)?;
        let scene = renderer.load(scene).map_err(failed)?;
        Ok(Session { renderer, scene, notices: Vec::new() })
    }

    /// The same, with the scene's parts as an arrangement shows them.
    ///
    /// # Errors
    /// As [`Session::open`].
    pub fn open_arranged(scene: &Scene, arrangement: &Arrangement) -> Result<Session, Failure> {
        Session::open_with(None, None, scene, arrangement)
    }

    /// The same with a renderer that has drawn before, if there is one, and a flag by which drawing is called off.
    ///
    /// # Errors
    /// As [`Session::open`].
    pub fn open_with(
        renderer: Option<Renderer>,
        cancel: Option<Arc<AtomicBool>>,
        scene: &Scene,
        arrangement: &Arrangement,
    ) -> Result<Session, Failure> {
        let mut session = match renderer {
            Some(mut renderer) => {
                let scene = renderer.load(scene).map_err(failed)?;
                Session { renderer, scene, notices: Vec::new() }
            }
            None => Session::open(scene)?,
        };
        session.renderer.cancel = cancel;
        let report = session.renderer.arrange(&mut session.scene, scene, arrangement).map_err(failed)?;
        session.notices = report.notices;
        Ok(session)
    }

    /// Renders a picture.
    ///
    /// # Errors
    /// [`Exit::Limits`] if the planner refuses, [`Exit::General`] otherwise.
    pub fn render(&mut self, camera: &Camera, settings: &Settings, size: [u32; 2]) -> Result<Frame, Failure> {
        self.renderer.render(&self.scene, camera, settings, size).map_err(failed)
    }

    /// Renders a picture with one sample a pixel and reads back its layers, the `most` nearest of each pixel.
    ///
    /// # Errors
    /// As [`Session::render`].
    pub fn layers(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        size: [u32; 2],
        most: u32,
    ) -> Result<(FrameReport, Layers), Failure> {
        let (frame, layers) = self.renderer.render_layers(&self.scene, camera, settings, size, most).map_err(failed)?;
        Ok((frame.report, layers))
    }

    /// The renderer, for another scene.
    pub fn into_renderer(self) -> Renderer {
        self.renderer
    }

    /// Milliseconds of the same picture blended without order.
    ///
    /// # Errors
    /// As [`Session::render`].
    pub fn time_unsorted(&mut self, camera: &Camera, settings: &Settings, size: [u32; 2]) -> Result<f64, Failure> {
        self.renderer.time_unsorted(&self.scene, camera, settings, size).map_err(failed)
    }

    /// What flickers in an orbit.
    ///
    /// # Errors
    /// As [`Session::render`].
    pub fn flicker(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        options: &OrbitOptions,
        say: &mut dyn FnMut(u32),
    ) -> Result<Orbit, Failure> {
        flicker::orbit(&mut self.renderer, &self.scene, camera, settings, options, say).map_err(failed)
    }

    /// Whether each pass is run alone and timed by the wall clock; otherwise by timestamps on the GPU.
    pub fn time_serially(&mut self, serially: bool) {
        self.renderer.timing = if serially { Timing::Serial } else { Timing::Timestamps };
    }

    /// Times passes as well as this adapter allows, and says how. A software rasterizer's timestamps are wrong for compute
    /// passes, so each pass is run alone there.
    pub fn time_passes(&mut self) -> &'static str {
        self.renderer.timing = self.renderer.gpu().facts().pass_timing();
        self.renderer.timing.name()
    }

    /// Plans a picture without rendering it.
    ///
    /// # Errors
    /// As [`Session::render`].
    pub fn plan(&self, camera: &Camera, settings: &Settings, size: [u32; 2]) -> Result<FramePlan, Failure> {
        self.renderer.plan(&self.scene, camera, settings, size).map_err(failed)
    }
}

/// The failure that an error of the renderer is.
pub fn failed(error: RenderError) -> Failure {
    let exit = match &error {
        RenderError::Refused(_)
        | RenderError::RowTooDeep { .. }
        | RenderError::ListsTooLarge { .. }
        | RenderError::PixelTooDeep { .. } => Exit::Limits,
        RenderError::Gpu(GpuError::OutOfMemory { .. } | GpuError::Exhausted) => Exit::Limits,
        _ => Exit::General,
    };
    Failure::of(exit, &error)
}

/// What became of the layers, how long it took and on what, in one line.
pub fn summary(name: &str, size: [u32; 2], report: &FrameReport) -> String {
    let layers = &report.layers;
    let mut text = format!(
        "{name}: {}×{}, layers: {} stored, {} merged, {} dropped",
        size[0],
        size[1],
        grouped(layers.stored),
        grouped(layers.merged),
        grouped(layers.dropped)
    );
    if let (1.., Capture::BucketedKBuffer { .. }) = (layers.dropped, report.plan.capture) {
        text += &format!(" (the deepest pixel has {})", layers.deepest);
    }
    if layers.lost > 0 {
        text += &format!(", {} LOST", grouped(layers.lost));
    }
    if layers.rasterized == 0 && report.plan.capture != Capture::None {
        text += ": nothing is in view";
    }
    text + &format!("; {:.1} ms on {}", report.milliseconds, report.adapter.name)
}

/// The adapters of this machine, as text or JSON.
///
/// # Errors
/// [`Exit::NoAdapter`] if none can be used; the list is given all the same.
pub fn adapters(as_json: bool) -> Result<(), Failure> {
    #[derive(Serialize)]
    struct Listing<'a> {
        adapters: &'a [AdapterFacts],
    }
    let found = Gpu::adapters();
    let text = if as_json {
        super::output::json(&Listing { adapters: &found })?
    } else {
        found.iter().map(describe).collect()
    };
    super::output::print(text.as_bytes())?;
    if found.iter().any(|a| a.unusable.is_none()) {
        Ok(())
    } else {
        Err(Failure::new(Exit::NoAdapter, "no graphics adapter can be used; on Debian, mesa-vulkan-drivers has one"))
    }
}

fn describe(adapter: &AdapterFacts) -> String {
    let AdapterFacts { name, driver, driver_info, backend, device_type, features, limits, unusable, .. } = adapter;
    let usable = unusable.as_ref().map_or_else(|| "can be used".to_owned(), |why| format!("cannot be used: {why}"));
    let limits: Vec<String> = limits.iter().map(|(limit, value)| format!("{limit} {}", grouped(*value))).collect();
    format!(
        "{}\n  {backend}, {device_type}, driver {}\n  {}\n  features: {}\n  limits: {}\n",
        printable(name),
        printable(&format!("{driver} {driver_info}")),
        printable(&usable),
        features.join(", "),
        limits.join(", ")
    )
}
