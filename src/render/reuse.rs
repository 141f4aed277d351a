//! Layers of the frame before, taken again: a frame begins at the first stage whose inputs have changed.
//!
//! Capture and features depend on scene, camera and their own settings; light, opacity and composition only on what they left
//! in the store. Where a transfer function is dragged, or the light, the store of the frame before is the store of this one,
//! and only the last passes run. The picture is the same bit for bit: the same shaders read the same buffers.
//!
//! It is asked for by [`Renderer::keeps_layers`], never by default: a benchmark would measure less than a frame. Frames of
//! several samples or bands, and rows with an averaged tail (whose weights are opacities), leave no whole store behind.
//!
//! [`Renderer::keeps_layers`]: super::Renderer::keeps_layers

use serde::Serialize;

use super::frame::{Tally, View, Work, ensure_fragments, light_layers, whole};
use super::{RenderError, Renderer};
use crate::math::Camera;
use crate::passes::capture::LayerCounts;
use crate::passes::geometry::{DrawOrder, GpuScene};
use crate::passes::{composite, opacity};
use crate::plan::{Capture, FramePlan, Pass, PlannedBuffer};
use crate::scene::{Arrangement, PartLook, Presence};
use crate::settings::{FeatureSettings, Settings};

/// What a frame took from the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kept {
    /// Nothing: everything was drawn.
    Nothing,
    /// Its layers; features were computed anew.
    Layers,
    /// Its layers and their features.
    Features,
}

impl Kept {
    /// Whether the pass need not run.
    pub fn spares(self, pass: Pass) -> bool {
        match self {
            Kept::Nothing => false,
            Kept::Layers => pass < Pass::NeighbourCandidates,
            Kept::Features => pass < Pass::Shade,
        }
    }
}

/// Everything that the layers in a store and their features depend on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Origin {
    scene: u64,
    shown: Arrangement,
    camera: Camera,
    draw_order: DrawOrder,
    shaders: u64,
    features: FeatureSettings,
    plan: FramePlan,
}

/// A whole store on the device.
#[derive(Clone, Debug)]
pub(super) struct Stored {
    pub(super) origin: Origin,
    /// Its layers.
    pub(super) layers: LayerCounts,
    /// Fragments and deepest pixel, which say how large the columns of compacted lists are.
    pub(super) room: Option<(u64, u32)>,
}

impl Origin {
    /// Of a frame; `None` if its store is of no use afterwards.
    pub(super) fn of(
        renderer: &Renderer,
        scene: &GpuScene,
        camera: &Camera,
        settings: &Settings,
        plan: &FramePlan,
    ) -> Option<Origin> {
        let tail = matches!(plan.capture, Capture::BucketedKBuffer { tail: true, .. });
        (renderer.keeps_layers && plan.samples == 1 && plan.capture != Capture::None && !tail).then(|| Origin {
            scene: scene.serial,
            shown: as_captured(&scene.arrangement),
            camera: *camera,
            draw_order: renderer.draw_order,
            shaders: renderer.shaders.revision(),
            features: settings.features.clone(),
            plan: plan.clone(),
        })
    }

    /// What a frame of this origin can take from the store of another one.
    pub(super) fn keeps(&self, other: &Origin) -> Kept {
        let same_scene = (self.scene, self.camera, self.draw_order, self.shaders)
            == (other.scene, other.camera, other.draw_order, other.shaders)
            && self.shown == other.shown;
        let (new, old) = (&self.plan, &other.plan);
        // The plan has everything of the capture that matters: settings of a capture that was not chosen do not. The same
        // columns, because what the capture leaves out for want of a reader is not there. How wide the apron of bands would be
        // is of no interest where there is one band.
        let same_store = (new.size, new.capture, new.normals, new.recolored, new.section_planes)
            == (old.size, old.capture, old.normals, old.recolored, old.section_planes)
            && (&new.bands, new.most_rows) == (&old.bands, old.most_rows)
            && passes(new).eq(passes(old))
            && columns(new).eq(columns(old))
            && new.features.map(|f| f.search) == old.features.map(|f| f.search);
        match same_scene && same_store {
            false => Kept::Nothing,
            true if self.features == other.features && new.features == old.features => Kept::Features,
            true => Kept::Layers,
        }
    }
}

/// The passes that fill the store.
fn passes(plan: &FramePlan) -> impl Iterator<Item = Pass> {
    plan.passes.iter().map(|p| p.pass).filter(|&p| p < Pass::Shade)
}

/// The buffers, targets of the image apart.
fn columns(plan: &FramePlan) -> impl Iterator<Item = &PlannedBuffer> {
    plan.buffers.iter().filter(|b| !["image", "sums", "outline_mask"].contains(&b.name))
}

/// What of an arrangement a capture sees: not what is selected, nor how opaque parts are. Caps are made for the parts as they
/// are shown, so where planes cut, all of it counts.
fn as_captured(arrangement: &Arrangement) -> Arrangement {
    let mut shown = arrangement.clone();
    shown.selected.clear();
    if shown.sections.is_empty() {
        for look in shown.parts.values_mut() {
            let presence = if look.presence == Presence::Hidden { Presence::Hidden } else { Presence::Shown };
            *look = PartLook { presence, color: look.color, ..PartLook::default() };
        }
        shown.parts.retain(|_, look| *look != PartLook::default());
    }
    shown
}

/// The frame from where it differs from the one whose layers are stored.
pub(super) fn draw_stored(
    renderer: &mut Renderer,
    plan: &FramePlan,
    view: &View<'_>,
    blank: &wgpu::TextureView,
    stored: &Stored,
    kept: Kept,
    tally: &mut Tally,
) -> Result<(), RenderError> {
    let mut deepest = u32::MAX;
    if let Some((fragments, deepest_pixel)) = stored.room {
        ensure_fragments(renderer, plan, fragments, deepest_pixel)?;
        deepest = deepest_pixel;
    }
    let mut work = Work::new(renderer, plan, view, whole(plan), blank)?;
    let mut context = work.context();
    context.deepest = deepest;
    opacity::gather(&mut context, true)?;
    light_layers(&mut context, kept)?;
    composite::blend(&mut context)?;
    work.submit_times(tally)?;
    (tally.layers, tally.room, tally.bands) = (stored.layers, stored.room, 1);
    Ok(())
}
