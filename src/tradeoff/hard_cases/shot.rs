//! Scenes of cases, and a frame with its store.

use super::CaseError;
use crate::gpu::shader_files;
use crate::math::Camera;
use crate::plan::Capture;
use crate::render::{Frame, GpuScene, Renderer, StoreReadback};
use crate::scene::hard_case::{ShaderChange, Source};
use crate::scene::{Scene, builtin};
use crate::settings::Settings;
use crate::{export, import};

/// The text of a shader module with a change in it.
///
/// # Errors
/// [`CaseError::NoSuchText`] if there is nothing to change.
pub fn changed_module(change: &ShaderChange) -> Result<String, CaseError> {
    let file = format!("{}.wgsl", change.module);
    let text = shader_files().into_iter().find(|(name, _)| *name == file).map(|(_, text)| text);
    match text.filter(|text| text.contains(change.from)) {
        Some(text) => Ok(text.replace(change.from, change.to)),
        None => Err(CaseError::NoSuchText { module: change.module.to_owned(), text: change.from.to_owned() }),
    }
}

/// The scene that a case means.
///
/// # Errors
/// [`CaseError`] if it cannot be built, written or read.
pub fn scene_of(source: &Source) -> Result<Scene, CaseError> {
    Ok(match source {
        Source::Builtin(name) | Source::Cut(name, ..) => builtin::build(name)?,
        Source::ThroughFile(name) => {
            let bytes = export::glb::write_glb(&builtin::build(name)?)?;
            import::load_bytes(&bytes, name, None)?
        }
        Source::Bytes(make) => import::load_bytes(&make(), "bytes", None)?,
    })
}

/// A frame and its store; the store is empty where there is none, or only that of the last band.
pub struct Shot {
    /// Picture and report.
    pub frame: Frame,
    /// What was captured and computed.
    pub store: StoreReadback,
}

impl Shot {
    /// Uploads, draws and reads back.
    ///
    /// # Errors
    /// [`crate::render::RenderError`] of the renderer.
    pub fn take(
        r: &mut Renderer,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        size: [u32; 2],
    ) -> Result<Shot, crate::render::RenderError> {
        let loaded = r.load(scene)?;
        Shot::of(r, &loaded, camera, settings, size)
    }

    /// Draws a scene that is uploaded already, and reads back.
    ///
    /// # Errors
    /// As [`Shot::take`].
    pub fn of(
        r: &mut Renderer,
        scene: &GpuScene,
        camera: &Camera,
        settings: &Settings,
        size: [u32; 2],
    ) -> Result<Shot, crate::render::RenderError> {
        let frame = r.render(scene, camera, settings, size)?;
        let report = &frame.report;
        let readable = report.bands == 1 && report.plan.samples == 1 && report.plan.capture != Capture::None;
        let store = if readable { r.read_store(report, scene, camera)? } else { StoreReadback::default() };
        Ok(Shot { frame, store })
    }

    /// The picture's bits, for exact comparison.
    pub fn bits(&self) -> Vec<[u32; 4]> {
        self.frame.image.pixels.iter().map(|p| p.map(f32::to_bits)).collect()
    }

    /// Colour and opacity of every layer as they are blended.
    pub fn colors(&self) -> Vec<[f64; 4]> {
        let constant = self.frame.report.plan.blend_opacity();
        let of_layer = |c: &[f32; 4]| {
            let [r, g, b, a] = c.map(f64::from);
            [r, g, b, constant * a]
        };
        self.store.lit.iter().map(of_layer).collect()
    }

    /// What no picture may have: numbers that are not finite, κ beyond its range.
    pub fn fault(&self) -> Option<&'static str> {
        let finite = |v: &f32| v.is_finite();
        if !self.frame.image.pixels.iter().flatten().all(finite) {
            Some("the picture has numbers that are not finite")
        } else if !self.store.kappa.iter().all(|k| k.is_finite() && k.abs() <= 1.0) {
            Some("κ is not finite, or beyond ±1")
        } else if !self.store.layers.normal.iter().flatten().all(finite) {
            Some("a stored normal is not finite")
        } else {
            None
        }
    }
}
