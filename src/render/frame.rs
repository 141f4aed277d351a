//! One frame, from plan to image: THE ordered list of pass calls.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec2;

use super::reuse::{Kept, Origin, Stored, draw_stored};
use super::targets::{Targets, texture};
use super::whole::draw_whole;
use super::{Frame, FrameReport, RenderError, Renderer, StoreReadback};
use crate::gpu::{GpuError, PassTime, Recorder, Resource, go_on};
use crate::math::color::linear_from_srgb;
use crate::math::{Camera, LinearImage, Projection, ViewFrustum};
use crate::passes::capture::{LayerCounts, STATISTICS_WORDS, bucketed_k_buffer, buckets, compacted, linked_list, sort};
use crate::passes::composite::outline;
use crate::passes::features::{self, curvature, neighbours, parameters};
use crate::passes::geometry::{GpuScene, Instances};
use crate::passes::{
    BlendParameters, Context, FrameUniform, StoreLayout, composite, illustration, opacity, opaque, operators, shade,
};
use crate::plan::{Band, Capture, FramePlan, Pass};
use crate::settings::{NeighbourSearch, Settings};
use crate::transfer::{TransferFunction, hex};

/// Offsets of the samples of a pixel, in pixels: the R2 sequence (Roberts 2018) for several, the centre for one.
fn jitter(sample: u32, samples: u32) -> DVec2 {
    if samples <= 1 {
        return DVec2::ZERO;
    }
    let n = f64::from(sample);
    let (a, b) = (0.754_877_666_246_692_7, 0.569_840_290_998_053_3);
    DVec2::new((0.5 + a * n).fract() - 0.5, (0.5 + b * n).fract() - 0.5)
}

/// What one sample of a frame needs besides the plan.
pub(super) struct View<'a> {
    pub(super) scene: &'a GpuScene,
    pub(super) camera: &'a Camera,
    pub(super) frustum: ViewFrustum,
    pub(super) jitter: DVec2,
    pub(super) instances: Arc<Instances>,
}

fn frame_uniform(view: &View<'_>, plan: &FramePlan, band: Band) -> FrameUniform {
    let [width, height] = plan.size.map(f64::from);
    let (tan_x, tan_y, orthographic) = match view.camera.projection {
        Projection::Perspective { fov_y } => {
            let t = (fov_y * 0.5).tan();
            (t * width / height, t, 0)
        }
        Projection::Orthographic { height: visible } => (visible * 0.5 * width / height, visible * 0.5, 1),
    };
    // Pixel (0, 0) has its sample at its middle, moved against the jitter of the image.
    let scale = DVec2::new(2.0 * tan_x / width, -2.0 * tan_y / height);
    let offset = DVec2::new(-tan_x, tan_y) + scale * (DVec2::splat(0.5) - view.jitter);
    let sphere = view.scene.stats.bounds.bounding_sphere();
    let center_depth = -view.camera.view_from_world().transform_point3(sphere.center).z;
    let radius = if sphere.radius > 0.0 { sphere.radius } else { 1.0 };
    let clip = view.camera.clip_from_view(view.frustum, plan.size, view.jitter);
    FrameUniform {
        clip_from_view: clip.as_mat4().to_cols_array_2d(),
        unproject: [scale.x, scale.y, offset.x, offset.y].map(|v| v as f32),
        size: plan.size,
        first_row: band.first_row,
        end_row: band.end_row,
        first_output_row: band.first_output_row,
        end_output_row: band.end_output_row,
        orthographic,
        _pad: 0,
        near: view.frustum.near as f32,
        far: view.frustum.far as f32,
        depth_min: (center_depth - radius) as f32,
        depth_scale: (0.5 / radius) as f32,
    }
}

/// Draws a planned frame.
pub(super) fn draw(
    renderer: &mut Renderer,
    scene: &GpuScene,
    camera: &Camera,
    settings: &Settings,
    transfer: &TransferFunction,
    plan: FramePlan,
) -> Result<Frame, RenderError> {
    let begin = Instant::now();
    let gpu = renderer.gpu.clone();
    gpu.check()?;
    let origin = Origin::of(renderer, scene, camera, settings, &plan);
    let (kept, stored) = match (&origin, renderer.stored.take()) {
        (Some(new), Some(old)) => (new.keeps(&old.origin), Some(old)),
        _ => (Kept::Nothing, None),
    };
    let targets = Targets::ensure(&mut renderer.targets, &gpu, &plan)?;
    let (image, blank) = (targets.image.clone(), targets.blank.clone());
    let sums = targets.sums.clone();
    let (opaque_targets, mask) = (targets.opaque.clone(), targets.mask.clone());
    bind_settings(renderer, scene, camera, settings, transfer, &plan)?;
    renderer.resources.set("image", Resource::Texture(image.create_view(&Default::default())));
    if let Some([colors, _]) = &opaque_targets {
        renderer.resources.set("opaque_colors", Resource::Texture(colors.clone()));
    }

    let mut tally = Tally { collected: renderer.collected.take().map(|_| Vec::new()), ..Tally::default() };
    let frustum = camera.frustum(&scene.stats.bounds);
    let layout = &renderer.shaders.shared.instances;
    let view_from_world = camera.view_from_world();
    let instances = Arc::new(if plan.runs(Pass::Opaque) {
        scene.instances_in_part_order(&gpu, layout, &view_from_world)?
    } else {
        scene.instances(&gpu, layout, &view_from_world, renderer.draw_order)?
    });
    let selected = match mask {
        Some(mask) => Some((mask, Arc::new(scene.instances_selected(&gpu, layout, &view_from_world)?))),
        None => None,
    };
    for sample in 0..plan.samples {
        let jitter = jitter(sample, plan.samples);
        let view = View { scene, camera, frustum, jitter, instances: Arc::clone(&instances) };
        match plan.capture {
            _ if kept > Kept::Nothing
                && let Some(stored) = &stored =>
            {
                draw_stored(renderer, &plan, &view, &blank, stored, kept, &mut tally)?;
            }
            Capture::None => {
                let band = plan.bands[0];
                let mut work = Work::new(renderer, &plan, &view, band, &blank)?;
                if let Some([colors, depth]) = &opaque_targets {
                    opaque::opaque(&mut work.context(), scene, colors, depth)?;
                    composite::show_opaque(&mut work.context())?;
                }
                work.finish(&mut tally)?;
            }
            Capture::BucketedKBuffer { .. } => {
                if plan.gathers_first(plan.bands.len()) {
                    for (i, &band) in plan.bands.iter().enumerate() {
                        let mut work = Work::new(renderer, &plan, &view, band, &blank)?;
                        capture_rows(&mut work.context(), scene)?;
                        opacity::gather(&mut work.context(), i == 0)?;
                        work.submit_times(&mut tally)?;
                    }
                }
                for &band in &plan.bands {
                    let mut work = Work::new(renderer, &plan, &view, band, &blank)?;
                    let mut context = work.context();
                    if let Some(tail) = context.resources.buffer("tail") {
                        context.recorder.encoder.clear_buffer(tail, 0, None);
                    }
                    capture_rows(&mut context, scene)?;
                    if plan.bands.len() == 1 {
                        opacity::gather(&mut context, true)?;
                    }
                    light_layers(&mut context, Kept::Nothing)?;
                    composite::blend(&mut context)?;
                    work.finish(&mut tally)?;
                    tally.collect(renderer, &plan, &view, band)?;
                }
            }
            Capture::Compacted | Capture::LinkedList { .. } => {
                draw_whole(renderer, &plan, &view, &blank, &mut tally)?;
            }
        }
        if let Some((mask, instances)) = &selected {
            renderer.resources.set("outline_mask", Resource::Texture(mask.clone()));
            let view = View { instances: Arc::clone(instances), ..view };
            let mut work = Work::new(renderer, &plan, &view, whole(&plan), &blank)?;
            outline::mask(&mut work.context(), scene, mask)?;
            outline::outline(&mut work.context())?;
            work.submit_times(&mut tally)?;
        }
        if let Some(sums) = &sums {
            let view = View { scene, camera, frustum, jitter, instances: Arc::clone(&instances) };
            accumulate(renderer, &plan, &view, &blank, sample, &image, sums, &mut tally)?;
        }
    }

    let shown = match &sums {
        Some(sums) => &sums[(plan.samples as usize) % 2],
        None => &image,
    };
    let mut pixels = gpu.read_image(shown)?;
    if plan.samples > 1 {
        let weight = 1.0 / plan.samples as f32;
        pixels.iter_mut().flatten().for_each(|v| *v *= weight);
    }
    if let Some(origin) = origin
        && tally.bands == 1
    {
        renderer.stored = Some(Stored { origin, layers: tally.layers, room: tally.room });
    }
    renderer.collected = tally.collected;
    let report = FrameReport {
        kept,
        layers: tally.layers,
        passes: tally.times,
        milliseconds: begin.elapsed().as_secs_f64() * 1e3,
        bands: tally.bands,
        refilled: tally.refilled,
        buffer_bytes: renderer.resources.bytes(),
        adapter: gpu.facts().clone(),
        plan,
    };
    let [width, height] = report.plan.size;
    Ok(Frame { image: LinearImage { width, height, pixels }, report })
}

/// Milliseconds of a frame in which every fragment is lit and blended as it comes, without any order.
pub(super) fn time_unsorted(
    renderer: &mut Renderer,
    scene: &GpuScene,
    camera: &Camera,
    settings: &Settings,
    transfer: &TransferFunction,
    plan: &FramePlan,
) -> Result<f64, RenderError> {
    let begin = Instant::now();
    let gpu = renderer.gpu.clone();
    let targets = Targets::ensure(&mut renderer.targets, &gpu, plan)?;
    let (image, blank) = (targets.image.clone(), targets.blank.clone());
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let target = texture(&gpu, "unsorted", plan.size, wgpu::TextureFormat::Rgba16Float, usage);
    bind_settings(renderer, scene, camera, settings, transfer, plan)?;
    let layout = &renderer.shaders.shared.instances;
    let instances = Arc::new(scene.instances(&gpu, layout, &camera.view_from_world(), renderer.draw_order)?);
    let frustum = camera.frustum(&scene.stats.bounds);
    let view = View { scene, camera, frustum, jitter: DVec2::ZERO, instances };
    let mut work = Work::new(renderer, plan, &view, whole(plan), &blank)?;
    opaque::unsorted(&mut work.context(), scene, &target.create_view(&Default::default()))?;
    work.submit_times(&mut Tally::default())?;
    // What a frame of ours reads back, this one reads back too.
    gpu.read_image(&image)?;
    Ok(begin.elapsed().as_secs_f64() * 1e3)
}

/// Rows of k slots, from clearing them to their surfaces.
pub(super) fn capture_rows(context: &mut Context<'_>, scene: &GpuScene) -> Result<(), GpuError> {
    bucketed_k_buffer::clear(context)?;
    bucketed_k_buffer::z_insertion(context, scene)?;
    bucketed_k_buffer::count_layers(context)?;
    let found_by_bucket = context.plan.runs(Pass::PartLookup);
    if !found_by_bucket {
        bucketed_k_buffer::data_storage(context, scene)?;
    }
    bucket_passes(context)?;
    if found_by_bucket {
        bucketed_k_buffer::data_storage(context, scene)?;
    }
    parameters::parametrize(context, scene)
}

/// Whole lists, once there is room for what [`count_band`] counted.
pub(super) fn capture_counted(context: &mut Context<'_>, scene: &GpuScene) -> Result<(), GpuError> {
    compacted::prefix_sum(context)?;
    if let Capture::LinkedList { sort, .. } = context.plan.capture {
        linked_list::sort_by_depth(context, sort)?;
    } else {
        compacted::append(context, scene)?;
        compacted::sort_by_depth(context)?;
    }
    compacted::gather(context)?;
    bucket_passes(context)?;
    parameters::parametrize(context, scene)
}

/// All rows of the image.
pub(super) fn whole(plan: &FramePlan) -> Band {
    let height = plan.size[1];
    Band { first_row: 0, end_row: height, first_output_row: 0, end_output_row: height }
}

/// Counts the fragments of every pixel; linked lists are filled at the same time, as far as there is room.
pub(super) fn count_band(context: &mut Context<'_>, scene: &GpuScene) -> Result<(), GpuError> {
    let counts = context.resources.require("count", "pixel_counts")?;
    context.recorder.encoder.clear_buffer(counts, 0, None);
    context.recorder.encoder.clear_buffer(context.resources.require("count", "statistics")?, 0, None);
    if context.plan.runs(Pass::Fill) {
        linked_list::fill(context, scene)?;
    } else {
        compacted::count(context, scene)?;
    }
    compacted::sum_rows(context)
}

fn bucket_passes(context: &mut Context<'_>) -> Result<(), GpuError> {
    if context.plan.runs(Pass::PartLookup) {
        buckets::part_lookup(context)?;
    }
    if context.plan.runs(Pass::ZReordering) {
        buckets::z_reordering(context)?;
        buckets::bucket_creation(context)?;
    }
    Ok(())
}

/// Stages 2 and 3: the same for every capture; without features if they are kept.
pub(super) fn light_layers(context: &mut Context<'_>, kept: Kept) -> Result<(), GpuError> {
    let written = std::mem::replace(&mut context.frame, context.lit_frame.clone());
    if let Some(features) = context.plan.features
        && kept < Kept::Features
    {
        neighbours::search(context, &features)?;
        if features.curvature {
            curvature::curvature(context, &features)?;
        }
    }
    shade::shade(context)?;
    if context.plan.runs(Pass::Stylize) {
        opacity::stylize(context)?;
    }
    illustration::illustrate(context)?;
    context.frame = written;
    Ok(())
}

#[derive(Default)]
pub(super) struct Tally {
    pub(super) layers: LayerCounts,
    times: Vec<PassTime>,
    pub(super) bands: usize,
    pub(super) refilled: u32,
    /// Fragments and deepest pixel of a band of whole lists.
    pub(super) room: Option<(u64, u32)>,
    /// The layers of each band, if they are wanted.
    collected: Option<Vec<StoreReadback>>,
}

impl Tally {
    /// Keeps the layers of a band that is done, if they are wanted.
    pub(super) fn collect(
        &mut self,
        renderer: &Renderer,
        plan: &FramePlan,
        view: &View<'_>,
        band: Band,
    ) -> Result<(), RenderError> {
        if let Some(collected) = &mut self.collected {
            let pixels = |row: u32| (row - band.first_row) as usize * plan.size[0] as usize;
            let rows = pixels(band.first_output_row)..pixels(band.end_output_row);
            collected.push(renderer.decode(plan, view.scene, view.camera, rows)?);
        }
        Ok(())
    }
}

/// A band at work: its frame uniform, its recorder, the renderer's resources.
pub(super) struct Work<'a> {
    renderer: &'a Renderer,
    plan: &'a FramePlan,
    band: Band,
    /// The columns into which geometry is drawn.
    pub(super) columns: std::ops::Range<u32>,
    frame: wgpu::BindGroup,
    /// The same with the rows in which layers are lit.
    lit_frame: wgpu::BindGroup,
    blank: &'a wgpu::TextureView,
    instances: Arc<Instances>,
    recorder: Recorder,
}

impl<'a> Work<'a> {
    pub(super) fn new(
        renderer: &'a mut Renderer,
        plan: &'a FramePlan,
        view: &View<'_>,
        band: Band,
        blank: &'a wgpu::TextureView,
    ) -> Result<Work<'a>, GpuError> {
        go_on(renderer.cancel.as_ref())?;
        let group = |band: Band| -> Result<wgpu::BindGroup, GpuError> {
            let uniform = renderer.gpu.uniform("frame", &frame_uniform(view, plan, band))?;
            Ok(renderer.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("frame"),
                layout: &renderer.shaders.shared.frame,
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
            }))
        };
        let frame = group(band)?;
        let lit_frame = match plan.lit_apron() {
            0 => frame.clone(),
            rows => group(Band {
                first_output_row: band.first_output_row.saturating_sub(rows).max(band.first_row),
                end_output_row: (band.end_output_row + rows).min(band.end_row),
                ..band
            })?,
        };
        let mut recorder = Recorder::new(&renderer.gpu, renderer.timing, renderer.cancel.clone());
        // Whole lists clear their statistics where they are counted.
        if !plan.capture.is_whole()
            && let Some(statistics) = renderer.resources.buffer("statistics")
        {
            recorder.encoder.clear_buffer(statistics, 0, None);
        }
        let (columns, instances) = (0..plan.size[0], Arc::clone(&view.instances));
        Ok(Work { renderer, plan, band, columns, frame, lit_frame, blank, instances, recorder })
    }

    pub(super) fn context(&mut self) -> Context<'_> {
        Context {
            gpu: &self.renderer.gpu,
            shaders: &self.renderer.shaders,
            plan: self.plan,
            band: self.band,
            columns: self.columns.clone(),
            frame: self.frame.clone(),
            lit_frame: self.lit_frame.clone(),
            resources: &self.renderer.resources,
            blank: self.blank,
            deepest: u32::MAX,
            instances: Arc::clone(&self.instances),
            recorder: &mut self.recorder,
        }
    }

    pub(super) fn submit_times(self, tally: &mut Tally) -> Result<(), GpuError> {
        self.recorder.submit().add_times(&mut tally.times)
    }

    /// Submits, waits, and adds times and counts.
    pub(super) fn finish(self, tally: &mut Tally) -> Result<(), GpuError> {
        let renderer = self.renderer;
        let whole = self.plan.capture.is_whole();
        self.recorder.submit().add_times(&mut tally.times)?;
        tally.bands += 1;
        if let Some(statistics) = renderer.resources.buffer("statistics") {
            let bytes = renderer.gpu.read_buffer(statistics, 4 * STATISTICS_WORDS as u64)?;
            let mut words: Vec<u32> = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
            if whole {
                // Everything that was counted is stored, unless a list was broken.
                words[1] = words[0].saturating_sub(words[4]);
            }
            tally.layers.add_band(&words);
        }
        Ok(())
    }
}

#[expect(clippy::too_many_arguments, reason = "one call, all of it different things")]
fn accumulate(
    renderer: &mut Renderer,
    plan: &FramePlan,
    view: &View<'_>,
    blank: &wgpu::TextureView,
    sample: u32,
    image: &wgpu::Texture,
    sums: &[wgpu::Texture; 2],
    tally: &mut Tally,
) -> Result<(), RenderError> {
    let (before, after) = (&sums[sample as usize % 2], &sums[(sample as usize + 1) % 2]);
    let as_resource = |t: &wgpu::Texture| Resource::Texture(t.create_view(&Default::default()));
    renderer.resources.set("sample_image", as_resource(image));
    renderer.resources.set("sum_before", as_resource(before));
    renderer.resources.set("sum_after", as_resource(after));
    let mut work = Work::new(renderer, plan, view, whole(plan), blank)?;
    if sample == 0 {
        // The first sum is the first frame. (Clearing a texture is a feature that not every adapter has.)
        let encoder = &mut work.recorder.encoder;
        encoder.copy_texture_to_texture(image.as_image_copy(), after.as_image_copy(), image.size());
    } else {
        composite::accumulate(&mut work.context())?;
    }
    Ok(work.submit_times(tally)?)
}

/// Makes room for the fragments of a band.
pub(super) fn ensure_fragments(
    renderer: &mut Renderer,
    plan: &FramePlan,
    fragments: u64,
    deepest: u32,
) -> Result<(), GpuError> {
    let gpu = renderer.gpu.clone();
    for (name, bytes) in plan.columns() {
        renderer.resources.ensure(&gpu, name, bytes * fragments)?;
    }
    let layout = StoreLayout { k: 0, capacity: fragments as u32, chunk: features::chunk(plan, deepest), _pad: 0 };
    renderer.resources.set("store_layout", Resource::Buffer(gpu.uniform("store_layout", &layout)?));
    aliases(renderer, plan);
    Ok(())
}

/// Names under which shaders know the same buffer. To be called whenever one of them may be another buffer.
fn aliases(renderer: &mut Renderer, plan: &FramePlan) {
    if plan.runs(Pass::NeighbourCandidates) && !plan.runs(Pass::NeighbourLinks) {
        renderer.resources.alias("links_ahead", "candidates_ahead");
        renderer.resources.alias("links_behind", "candidates_behind");
    }
    if plan.features.is_some_and(|f| f.search == NeighbourSearch::Buckets) {
        // Free until layers are lit.
        renderer.resources.alias("open_layers", "lit");
    }
    // Where blending finds the fields.
    if let Some(i) = plan.illustration {
        renderer.resources.alias("field_in", operators::column_after(i.most_steps));
        // Free until fields spread.
        renderer.resources.alias("runs", operators::column_after(1));
    }
    for (alias, name) in [("atomic_keys", "keys"), ("key_words", "keys"), ("pixel_counts", "pixel_table")] {
        renderer.resources.alias(alias, name);
    }
}

/// Uniforms and tables of the settings, and buffers whose size is known before the capture.
pub(super) fn bind_settings(
    renderer: &mut Renderer,
    scene: &GpuScene,
    camera: &Camera,
    settings: &Settings,
    transfer: &TransferFunction,
    plan: &FramePlan,
) -> Result<(), RenderError> {
    let gpu = renderer.gpu.clone();
    let planned: Vec<&str> = plan.buffers.iter().map(|b| b.name).collect();
    renderer.resources.retain(|name| planned.contains(&name));
    let resources = &mut renderer.resources;
    resources.set("part_table", Resource::Buffer(scene.part_table.clone()));
    if plan.section_planes > 0 {
        resources.set("sections", Resource::Buffer(gpu.uniform("sections", &scene.sections(camera))?));
    }
    resources.set("lights", Resource::Buffer(gpu.uniform("lights", &shade::parameters(&settings.light))?));
    if let Some(features) = &plan.features {
        let parameters = curvature::parameters(features, &settings.features.curvature);
        resources.set("curvature_parameters", Resource::Buffer(gpu.uniform("curvature", &parameters)?));
    }
    let (constant, tail) = match plan.capture {
        Capture::BucketedKBuffer { k, tail, .. } => (opacity::tail_opacity(plan.opacity, &settings.opacity, k), tail),
        _ => (1.0, false),
    };
    if plan.illustration.is_some() {
        let (fields, steps) =
            illustration::parameters(&settings.opacity.illustrative.in_pixels(plan.size), plan.opacity);
        resources.set("illustration", Resource::Buffer(gpu.uniform("illustration", &fields)?));
        resources.set("step_parameters", Resource::Buffer(gpu.uniform("steps", &steps)?));
        resources.ensure(&gpu, "steps", 16)?;
        resources.ensure(&gpu, "present", 12)?;
        resources.ensure(&gpu, "step_arguments", 12)?;
    }
    if plan.runs(Pass::LayerHistogram) {
        resources.ensure(&gpu, "gathered", operators::GATHERED_BYTES)?;
        resources.ensure(&gpu, "settled", operators::GATHERED_BYTES)?;
    }
    let models = opacity::model_parameters(&settings.opacity, plan.size);
    resources.set("model_parameters", Resource::Buffer(gpu.uniform("model", &models)?));
    if plan.runs(Pass::Stylize) || tail {
        let [color, alpha] = match &renderer.tables {
            Some((of, tables)) if of == transfer => tables.clone(),
            _ => {
                let tables = opacity::tables(&gpu, transfer)?;
                renderer.tables = Some((transfer.clone(), tables.clone()));
                tables
            }
        };
        resources.set("color_table", Resource::Buffer(color));
        resources.set("opacity_table", Resource::Buffer(alpha));
        let parameters = opacity::parameters(transfer, settings.opacity.gain, constant, settings.opacity.ghost);
        resources.set("transfer", Resource::Buffer(gpu.uniform("transfer", &parameters)?));
    }
    let blend =
        BlendParameters { opacity: plan.blend_opacity() as f32, ghost: settings.opacity.ghost as f32, _pad: [0; 2] };
    resources.set("blend_parameters", Resource::Buffer(gpu.uniform("blend", &blend)?));
    if plan.runs(Pass::Outline) {
        let wrong = || RenderError::OutlineColor { color: settings.outline.color.clone() };
        let color = hex(&settings.outline.color).ok_or_else(wrong)?.map(linear_from_srgb);
        let parameters = outline::parameters(color, settings.outline.width);
        resources.set("outline_parameters", Resource::Buffer(gpu.uniform("outline", &parameters)?));
    }
    if plan.capture == Capture::None {
        return Ok(());
    }
    resources.ensure(&gpu, "statistics", 4 * STATISTICS_WORDS as u64)?;
    if plan.capture.is_whole() {
        resources.ensure(&gpu, "row_sums", 4 * u64::from(plan.size[1]))?;
    }
    if plan.runs(Pass::Sort) || plan.runs(Pass::ZReordering) {
        resources.ensure(&gpu, "sort_arguments", 12 * u64::from(sort::LARGEST_CLASS + 1))?;
        resources.ensure(&gpu, "classes", 16 * u64::from(sort::LARGEST_CLASS + 1))?;
    }
    if plan.features.is_some_and(|f| f.search == NeighbourSearch::Buckets) || plan.runs(Pass::Boundary) {
        resources.ensure(&gpu, "open_arguments", 12)?;
        resources.ensure(&gpu, "open_count", 4)?;
    }
    for buffer in plan.buffers.iter().filter(|b| b.exact && !["image", "sums", "outline_mask"].contains(&b.name)) {
        resources.ensure(&gpu, buffer.name, buffer.bytes)?;
    }
    if let Capture::BucketedKBuffer { k, .. } = plan.capture {
        let slots = plan.bands.iter().map(|b| b.end_row - b.first_row).max().unwrap_or(0) * plan.size[0] * k;
        let layout = StoreLayout { k, capacity: slots, chunk: features::chunk(plan, k), _pad: 0 };
        resources.set("store_layout", Resource::Buffer(gpu.uniform("store_layout", &layout)?));
    }
    aliases(renderer, plan);
    Ok(())
}
