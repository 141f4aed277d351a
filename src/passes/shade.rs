//! Light on every stored layer, once (metallic-roughness, three lights, a sky). See `oracle::lighting` for the model.
//!
//! Captures write unlit surfaces, so pictures of different captures are identical bit for bit.

use crate::gpu::{GpuError, ShaderSpec};
use crate::math::{LightLevels, LightRig};
use crate::passes::store::StoreModules;
use crate::passes::{Context, ShadeParameters};
use crate::plan::{FramePlan, Pass};
use crate::scene::hard_case::{CaseCamera, Contrast, HardCase, Measure, Method, Source};
use crate::settings::LightSettings;

/// The hard cases of light.
pub const CASES: &[HardCase] = &[HardCase {
    name: "grazing-light",
    trap: "",
    why: "Normals at every angle, half of them within a degree of edge-on: the terms of a specular reflection divide by \
          cosines that are nearly zero there, and the curve that keeps bright light below 1 meets its ends. Light has to \
          be finite and the oracle's.",
    scene: Source::Builtin("builtin:hard/normals"),
    camera: CaseCamera::FRONT,
    size: [96, 96],
    ours: Method::of("ours", "light.exposure=3"),
    contrast: Some(Contrast::Planted(Method::of("shoulder moved", "light.exposure=3").changed(
        "common/lighting",
        "SHOULDER_START: f32 = 0.75",
        "SHOULDER_START: f32 = 0.6",
    ))),
    measure: Measure::LightError,
    bound: 1.0,
}];

/// The uniform of the light settings.
pub fn parameters(settings: &LightSettings) -> ShadeParameters {
    let levels = LightLevels {
        exposure: settings.exposure,
        key: settings.key,
        fill: settings.fill,
        rim: settings.rim,
        ambient: settings.ambient,
    };
    ShadeParameters { lights: LightRig::studio(levels).to_vec4s() }
}

/// The shader.
pub fn spec(plan: &FramePlan) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    let spec = modules.layout(ShaderSpec::new("passes/shade"));
    modules.colors(modules.normals(modules.keys(spec)))
}

/// Lights every layer.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn shade(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::Shade, &spec(context.plan), "main")
}
