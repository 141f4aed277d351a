//! Curvature of every layer: κ = tanh(s (κ₁ + κ₂)) in [−1, 1], −1 convex and +1 concave (Murray 2016, section 5.1).
//!
//! Two kinds, by name (T8). `ViewCentred` is the paper's, after Vergne 2009: the gradient of (n_x, n_y) / n_z, that is the
//! Hessian of depth; it grows without bound towards silhouettes. `Surface`, the default, is the trace of the shape operator,
//! from how the normal changes as the position moves, and so the same from every side.
//!
//! Where we differ:
//! - Units: the scale is a length (visible height by default), pixels do not enter. Doubling the resolution changes nothing.
//! - Estimation over a radius: linear regression of normal and position along the links, up to a number of steps that
//!   follows the resolution. Tessellation steps average out (T31). The walk stops at creases, so edges stay sharp.
//! - Creases and missing neighbours are lines with a width and a soft edge. κ = −1 where a neighbour is missing, as printed;
//!   never where it is unknown (T10).

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::store::StoreModules;
use crate::passes::{Context, CurvatureParameters};
use crate::plan::{Features, FramePlan, Pass};
use crate::settings::{Axis, CurvatureKind, CurvatureSettings, Effect, Knob};

const WANTED: (&str, &str) = ("opacity.model", "curvature");

/// Which curvature, and over which radius (T8, T31). Both decide what is shown: neither value is wrong.
pub const AXES: &[Axis] = &[
    Axis {
        name: "curvature",
        knob: Knob::Setting("features.curvature.kind"),
        values: &["surface", "view_centred"],
        matters_if: &[WANTED],
        effect: Effect::Look,
    },
    Axis {
        name: "radius",
        knob: Knob::Setting("features.curvature.radius"),
        values: &["0.0", "0.005", "0.01"],
        matters_if: &[WANTED],
        effect: Effect::Look,
    },
];

/// The uniform of a plan.
pub fn parameters(features: &Features, settings: &CurvatureSettings) -> CurvatureParameters {
    CurvatureParameters {
        scale: features.scale as f32,
        part_scale: features.scale as f32,
        radius: features.radius,
        reach: features.reach,
        line: features.line as f32,
        // At 180 degrees nothing is a crease, whatever rounding does to the cosine.
        crease_cosine: if settings.crease_angle >= 180.0 {
            -2.0
        } else {
            settings.crease_angle.to_radians().cos() as f32
        },
        kind: match settings.kind {
            CurvatureKind::Surface => 0,
            CurvatureKind::ViewCentred => 1,
        },
        _pad: 0,
    }
}

/// The shader.
pub fn spec(plan: &FramePlan, features: &Features) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    let scale = if features.scale_by_part { "passes/features/scale_part" } else { "passes/features/scale_uniform" };
    let spec = ShaderSpec::new("passes/features/curvature").with(scale);
    modules.normals(modules.keys(modules.layout(spec)))
}

/// Curvature of every layer in the rows that are written.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn curvature(context: &mut Context<'_>, features: &Features) -> Result<(), GpuError> {
    context.per_chunk(Pass::Curvature, &spec(context.plan, features), "main")
}
