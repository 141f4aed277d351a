//! The layers of one pixel, as the frame sees them: what lies under the cursor.
//!
//! Only the pixel and what features reach around it are captured, by the machinery that draws large pictures in bands: a
//! band of one row and its apron, and geometry scissored to as many columns. Viewport, matrices and positions are those of
//! the whole picture, so what is found is what the frame has stored there, bit for bit (but for ties of packed keys, which
//! are a race in every frame). Parts that cannot be seen there are not drawn. Buffers are kept apart from the
//! frame's, whose store stays readable.

use std::sync::Arc;

use glam::{DMat4, DVec2, DVec3, Vec3};

use super::frame::{self, Tally, View, Work};
use super::{GpuScene, Kept, RenderError, Renderer, targets};
use crate::gpu::{GpuError, Resources};
use crate::math::{Camera, Sphere};
use crate::oracle;
use crate::passes::capture::{BAND_DEEPEST, STATISTICS_WORDS};
use crate::passes::opacity;
use crate::plan::{self, Capture, FramePlan, Pass, ViewStats};
use crate::scene::{PartLook, PartStyle, Presence};
use crate::settings::Settings;
use crate::transfer::TransferFunction;

/// One layer under a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickedLayer {
    /// Index of the part; of a cap, the part that it closes.
    pub part: u32,
    /// Distance along the view, scene units.
    pub depth: f64,
    /// Where the sight line through the pixel's middle meets it, scene space.
    pub position: DVec3,
    /// Unit normal on the viewer's side, scene space.
    pub normal: DVec3,
    /// κ under the settings' kind, unit and scale; computed also where the picture does not need it.
    pub kappa: f32,
    /// Opacity with which the layer is blended, 0 to 1.
    pub opacity: f32,
}

/// Columns beyond the reach of features in which geometry is drawn: a link there is only looked at from inside.
const MARGIN: u32 = 2;

/// What picking keeps from one time to the next.
#[derive(Default)]
pub(super) struct Picking {
    resources: Resources,
    blank: Option<([u32; 2], wgpu::TextureView)>,
}

/// The opacity of a layer of a part, in the arithmetic of `passes/opacity/looks_by_part.wgsl`.
pub(super) fn part_alpha(look: &PartLook, alpha: f32, ghost: f32) -> f32 {
    let whole = if look.style == PartStyle::Solid { 1.0 } else { alpha };
    whole * look.opacity as f32 * if look.presence == Presence::Ghosted { ghost } else { 1.0 }
}

/// Whether something inside a sphere may be seen at most `reach` pixels from a pixel, across and along. Never wrong in
/// saying no: the window is taken as wide as it is at the sphere's far end, and a hundredth wider.
fn may_cover(view: &oracle::View, [x, y]: [u32; 2], reach: u32, view_from_world: DMat4, sphere: &Sphere) -> bool {
    let center = view_from_world.transform_point3(sphere.center);
    let farthest = (sphere.radius - center.z).max(0.0);
    let half = f64::from(reach + 1) * view.pixel_size(farthest).length();
    // A point of the sight line, and where it goes.
    let (from, along) = if view.perspective {
        (DVec3::ZERO, view.position(x, y, 1.0).normalize())
    } else {
        (view.position(x, y, 0.0), DVec3::NEG_Z)
    };
    let off = (center - from).reject_from_normalized(along).length();
    off <= 1.01 * (sphere.radius + half)
}

impl Renderer {
    /// The layers of `pixel` (column, row) of a picture of `size`, nearest first: those that the frame with these settings
    /// stores there, the first sample's if it has several. An opaque picture's hidden layers are found too. Outside the
    /// picture there are none.
    ///
    /// # Errors
    /// [`RenderError`] says what was refused or failed.
    pub fn pick(
        &mut self,
        scene: &GpuScene,
        camera: &Camera,
        settings: &Settings,
        size: [u32; 2],
        pixel: [u32; 2],
    ) -> Result<Vec<PickedLayer>, RenderError> {
        let transfer = settings.opacity.transfer.resolve(None)?;
        self.pick_with(scene, camera, settings, &transfer, size, pixel)
    }

    /// [`Renderer::pick`] with transfer functions that are already resolved.
    ///
    /// # Errors
    /// [`RenderError`] says what was refused or failed.
    pub fn pick_with(
        &mut self,
        scene: &GpuScene,
        camera: &Camera,
        settings: &Settings,
        transfer: &TransferFunction,
        size: [u32; 2],
        pixel: [u32; 2],
    ) -> Result<Vec<PickedLayer>, RenderError> {
        if pixel[0] >= size[0] || pixel[1] >= size[1] {
            return Ok(Vec::new());
        }
        let view = ViewStats::of(camera);
        let capabilities = self.gpu.capabilities();
        let plan = plan::plan_pick(settings, transfer, &scene.stats, &view, capabilities, size, pixel[1])?;
        std::mem::swap(&mut self.resources, &mut self.picking.resources);
        let picked = self.pick_planned(scene, camera, settings, transfer, &plan, pixel);
        std::mem::swap(&mut self.resources, &mut self.picking.resources);
        picked
    }

    fn pick_planned(
        &mut self,
        scene: &GpuScene,
        camera: &Camera,
        settings: &Settings,
        transfer: &TransferFunction,
        plan: &FramePlan,
        [x, y]: [u32; 2],
    ) -> Result<Vec<PickedLayer>, RenderError> {
        let gpu = self.gpu.clone();
        gpu.check()?;
        let blank = match self.targets.as_ref().and_then(|t| t.blank(plan.size)) {
            Some(blank) => blank.clone(),
            None => {
                let kept = self.picking.blank.take().filter(|(size, _)| *size == plan.size);
                self.picking
                    .blank
                    .insert(kept.unwrap_or_else(|| (plan.size, targets::blank(&gpu, plan.size))))
                    .1
                    .clone()
            }
        };
        frame::bind_settings(self, scene, camera, settings, transfer, plan)?;
        let view_from_world = camera.view_from_world();
        let layout = &self.shaders.shared.instances;
        let seen = oracle::View::new(camera, plan.size, DVec2::ZERO);
        let reach = plan.apron + MARGIN;
        let in_window = |sphere: &Sphere| may_cover(&seen, [x, y], reach, view_from_world, sphere);
        let order = self.draw_order;
        let instances = Arc::new(scene.instances_where(&gpu, layout, &view_from_world, order, &in_window)?);
        let frustum = camera.frustum(&scene.stats.bounds);
        let view = View { scene, camera, frustum, jitter: DVec2::ZERO, instances };
        let band = plan.bands[0];
        let columns = x.saturating_sub(reach)..plan.size[0].min(x + reach + 1);
        let mut tally = Tally::default();
        let mut deepest = u32::MAX;
        if plan.capture == Capture::Compacted {
            let mut work = Work::new(self, plan, &view, band, &blank)?;
            work.columns = columns.clone();
            frame::count_band(&mut work.context(), scene)?;
            work.submit_times(&mut tally)?;
            let words = |name, count: u64| -> Result<Vec<u32>, GpuError> {
                let bytes = gpu.read_buffer(self.resources.require("prefix sum", name)?, 4 * count)?;
                Ok(bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect())
            };
            let rows = words("row_sums", u64::from(band.end_row - band.first_row))?;
            deepest = words("statistics", STATISTICS_WORDS as u64)?[BAND_DEEPEST];
            let (fragments, most) = (rows.into_iter().map(u64::from).sum(), gpu.capabilities().most_layers);
            if deepest > most {
                return Err(RenderError::PixelTooDeep { layers: deepest, limit: most });
            }
            let limit = gpu.capabilities().largest_buffer() / plan.widest_column();
            if fragments > limit {
                return Err(RenderError::RowTooDeep { row: y, fragments, limit });
            }
            frame::ensure_fragments(self, plan, fragments, deepest)?;
        }
        let mut work = Work::new(self, plan, &view, band, &blank)?;
        work.columns = columns;
        let mut context = work.context();
        context.deepest = deepest;
        if plan.capture == Capture::Compacted {
            frame::capture_counted(&mut context, scene)?;
        } else {
            if let Some(tail) = context.resources.buffer("tail") {
                context.recorder.encoder.clear_buffer(tail, 0, None);
            }
            frame::capture_rows(&mut context, scene)?;
        }
        if plan.runs(Pass::LayerHistogram) {
            work.submit_times(&mut tally)?;
            // From all rows, not the picked one alone.
            let mut all = Work::new(self, plan, &view, frame::whole(plan), &blank)?;
            opacity::gather(&mut all.context(), true)?;
            all.submit_times(&mut tally)?;
            work = Work::new(self, plan, &view, band, &blank)?;
            context = work.context();
            context.deepest = deepest;
        }
        frame::light_layers(&mut context, Kept::Nothing)?;
        work.submit_times(&mut tally)?;

        let at = ((y - band.first_row) * plan.size[0] + x) as usize;
        let store = self.decode(plan, scene, camera, at..at + 1)?;
        let constant = plan.blend_opacity() as f32;
        let ghost = settings.opacity.ghost as f32;
        let world_from_view = view_from_world.inverse();
        let layer = |i: usize| {
            let (part, depth) = (scene.cut.owner(store.layers.part[i]), store.layers.depth[i]);
            let alpha = (store.lit[i][3] * constant).clamp(0.0, 1.0);
            PickedLayer {
                part,
                depth,
                position: world_from_view.transform_point3(seen.position(x, y, depth)),
                normal: world_from_view.transform_vector3(Vec3::from(store.layers.normal[i]).as_dvec3()).normalize(),
                kappa: store.kappa[i],
                opacity: part_alpha(&scene.arrangement.look(part), alpha, ghost),
            }
        };
        Ok((0..store.layers.len()).map(layer).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Projection;

    #[test]
    fn parts_beside_the_window_are_left_out_and_none_within() {
        let size = [100, 100];
        for projection in [Projection::Perspective { fov_y: 0.8 }, Projection::Orthographic { height: 8.0 }] {
            let camera = Camera {
                position: DVec3::new(0.0, 0.0, 10.0),
                focal_point: DVec3::ZERO,
                view_up: DVec3::Y,
                projection,
            };
            let view = oracle::View::new(&camera, size, DVec2::ZERO);
            let world_from_view = camera.view_from_world().inverse();
            for (pixel, reach) in [([50, 50], 3), ([0, 99], 0), ([90, 10], 5)] {
                for (dx, dy, depth, radius) in
                    [(0, 0, 9.0, 0.0), (reach, 0, 3.0, 1e-6), (0, reach, 40.0, 0.1), (reach, reach, 0.5, 1e-9)]
                {
                    // The centre of a pixel at the window's edge: it must be found however small it is.
                    let (x, y) = (pixel[0] + dx as u32, pixel[1] + dy as u32);
                    let center = world_from_view.transform_point3(view.position(x, y, depth));
                    let sphere = Sphere { center, radius };
                    assert!(may_cover(&view, pixel, reach as u32, camera.view_from_world(), &sphere));
                    let far = world_from_view.transform_point3(view.position(x + 60, y, depth));
                    let beside = Sphere { center: far, radius: radius.min(0.01) };
                    assert!(!may_cover(&view, pixel, reach as u32, camera.view_from_world(), &beside));
                }
            }
        }
    }
}
