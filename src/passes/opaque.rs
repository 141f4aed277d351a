//! When every surface is opaque, nothing is captured: the nearest fragment is lit in its fragment shader and kept by the
//! depth test. Surfaces pass through the formats of the store, and equal depths keep the lower triangle number (parts are
//! drawn in order), so the picture is the one that a capture would give, bit for bit.

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::Context;
use crate::passes::geometry::{GpuScene, clip, draw_opaque, draw_unsorted, recolor};
use crate::passes::store::StoreModules;
use crate::plan::FramePlan;
use crate::scene::hard_case::{CaseCamera, Contrast, HardCase, Measure, Method, Source};

/// The hard cases of opaque pictures.
pub const CASES: &[HardCase] = &[HardCase {
    name: "faces-in-one-place",
    trap: "",
    why: "Two faces of different colours in one place, drawn by the depth test instead of a capture: the lower triangle \
          number must win, as in every list of layers, whatever the order of the triangles in the file.",
    scene: Source::Builtin("builtin:hard/equal-keys?colors=1&layers=3"),
    camera: CaseCamera::FRONT_PARALLEL,
    size: [32, 32],
    ours: Method::of("depth test", "opacity.model=opaque"),
    contrast: Some(Contrast::Planted(Method::of("normals turned away", "opacity.model=opaque").changed(
        "passes/opaque",
        "unpack_normal(pack_normal(s.normal))",
        "-unpack_normal(pack_normal(s.normal))",
    ))),
    measure: Measure::PictureError,
    bound: 0.3,
}];

/// The shader, over a vertex stage.
pub fn spec(plan: &FramePlan, vertex: ShaderSpec) -> ShaderSpec {
    StoreModules::of(plan).normals(vertex.with("passes/opaque").with(recolor(plan)).with(clip(plan)))
}

/// Draws the nearest surfaces into `target` (Rg32Uint).
///
/// # Errors
/// [`GpuError`] of the device.
pub fn opaque(
    context: &mut Context<'_>,
    scene: &GpuScene,
    target: &wgpu::TextureView,
    depth: &wgpu::TextureView,
) -> Result<(), GpuError> {
    let plan = context.plan;
    draw_opaque(context, scene, target, depth, &|vertex| spec(plan, vertex))
}

/// The shader of [`unsorted`], over a vertex stage, with one of [`super::geometry::CLIP`].
pub fn unsorted_spec(vertex: ShaderSpec, clip: &'static str) -> ShaderSpec {
    vertex.with("passes/unsorted").with(clip)
}

/// Blends every fragment as it comes into `target` (Rgba16Float): the lower bound that benchmarks compare with.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn unsorted(context: &mut Context<'_>, scene: &GpuScene, target: &wgpu::TextureView) -> Result<(), GpuError> {
    let clip = clip(context.plan);
    draw_unsorted(context, scene, target, &|vertex| unsorted_spec(vertex, clip))
}
