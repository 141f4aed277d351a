//! Light on every stored layer, once (metallic-roughness, three lights, a sky). See `oracle::lighting` for the model.
//!
//! Captures write unlit surfaces, so pictures of different captures are identical bit for bit.

use crate::gpu::{GpuError, ShaderSpec};
use crate::math::{LightLevels, LightRig};
use crate::passes::store::StoreModules;
use crate::passes::{Context, ShadeParameters};
use crate::plan::{FramePlan, Pass};
use crate::settings::LightSettings;

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
