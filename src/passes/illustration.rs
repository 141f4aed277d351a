//! Illustrative transparency (Carnecky, Fuchs, Mehl, Jang, Peikert 2013, section 5): surfaces are opaque at their silhouettes and
//! clear behind them, so that one sees which of two sheets lies in front.
//!
//! Three fields of every layer: α, the base opacity, from any other model; β, 1 at silhouettes; γ, 1 beside what ends in front.
//! They spread along the surface, α as heat, β and γ by max-propagation, and give the opacity
//! (1 − γ)(α + (1 − α) β), with which layers are blended like any others.
//!
//! Where we differ from what is printed (each printed form is a setting, `opacity.illustrative.printed`):
//! - Heat flows along the links that there are, λ/4 through each: stable for every λ that is allowed, and conserved (T12).
//! - β and γ go on until nothing changes, which the GPU decides; what is fixed stays fixed (T16).
//! - Silhouettes are where surfaces really end, and halos begin behind what ends openly, not at every step of the layer index
//!   (T19, [`ends`]).
//! - The bell's limit at p = 0 is its value there (T15); what passes a layer is 1 − α̂ (T14).
//! - Diffusion can be anisotropic, by local feature size ([`feature_size`]).
//! - Unknown neighbours, beyond the image or where a k-buffer lost layers, are no silhouettes (T10).
//!
//! A layer that ends and lies under another end is a silhouette: the first of the paper's rules wins. Memory a layer: 52 bytes,
//! the fields twice, the slots of the neighbours, and where it ends (56 in rows, whose layers are listed besides); and 8 a pixel.
//! Both fields and base opacity come from as many rows away as steps are taken, so bands have an apron as wide.

use crate::gpu::GpuError;
use crate::passes::operators::{self, Operator};
use crate::passes::{Context, IllustrationParameters, StepParameters};
use crate::plan::{FramePlan, Opacity, Pass};
use crate::settings::{Axis, Diffusion, Effect, IllustrativeSettings, Knob, PrintedForm, Profile};

pub mod cases;
pub mod ends;
pub mod feature_size;

const WANTED: (&str, &str) = ("opacity.model", "illustrative");

/// How far and how fast fields spread.
pub const AXES: &[Axis] = &[
    Axis {
        name: "iterations",
        knob: Knob::Setting("opacity.illustrative.iterations"),
        values: &["10", "20", "50"],
        matters_if: &[WANTED],
        effect: Effect::Look,
    },
    Axis {
        name: "lambda-beta",
        knob: Knob::Setting("opacity.illustrative.beta.lambda"),
        values: &["0.02", "0.05", "0.2"],
        matters_if: &[WANTED],
        effect: Effect::Look,
    },
    Axis {
        name: "feature-size",
        knob: Knob::Setting("opacity.illustrative.feature_size"),
        values: &["0", "24", "60"],
        matters_if: &[WANTED],
        effect: Effect::Look,
    },
    Axis {
        name: "early-stop",
        knob: Knob::Setting("opacity.illustrative.early_stop"),
        values: &["true", "false"],
        matters_if: &[WANTED],
        effect: Effect::Cost,
    },
];

/// Initial and boundary conditions.
pub const BOUNDARY: Operator = Operator::first("passes/illustration/boundary");
/// One step of isotropic diffusion.
const DIFFUSE: Operator = Operator::repeated("passes/illustration/diffuse_isotropic");
/// One step of diffusion that reaches less far where surfaces are small.
const DIFFUSE_BY_SIZE: Operator = Operator::repeated("passes/illustration/diffuse_by_feature_size");
/// Opacity out of the fields.
pub const ILLUSTRATE: Operator = Operator::pointwise("passes/illustration/illustrate");

/// One step of diffusion, as planned.
pub fn diffuse(plan: &FramePlan) -> &'static Operator {
    if plan.runs(Pass::FeatureSize) { &DIFFUSE_BY_SIZE } else { &DIFFUSE }
}

/// The uniforms of the settings.
pub fn parameters(settings: &IllustrativeSettings, opacity: Opacity) -> (IllustrationParameters, StepParameters) {
    let s = settings;
    let diffusion = |d: Diffusion| match d {
        Diffusion::None => 0,
        Diffusion::Heat => 1,
        Diffusion::Max => 2,
    };
    let profile = |p: Profile| match p {
        Profile::None => 0,
        Profile::Bell => 1,
        Profile::Power => 2,
    };
    let steps = s.steps();
    let fields = IllustrationParameters {
        lambda: [s.alpha.lambda as f32, s.beta.lambda as f32, s.gamma.lambda as f32, 0.0],
        diffusion: [diffusion(s.alpha.diffusion), diffusion(s.beta.diffusion), diffusion(s.gamma.diffusion), 0],
        profile: [0, profile(s.beta.profile), profile(s.gamma.profile), 0],
        p: [0.0, s.beta.p as f32, s.gamma.p as f32, 0.0],
        strength: [0.0, s.beta.strength as f32, s.gamma.strength as f32, 0.0],
        constant: match opacity {
            Opacity::Constant { alpha } => (alpha * s.base_gain) as f32,
            _ => s.base_gain as f32,
        },
        heat_steps: steps.heat,
        printed: match s.printed {
            PrintedForm::None | PrintedForm::Transmittance => 0,
            PrintedForm::Laplacian => 1,
            PrintedForm::Propagation => 2,
            PrintedForm::IndexSteps => 3,
        },
        feature_size: s.feature_size,
    };
    (fields, StepParameters { always: steps.heat, early_stop: u32::from(s.early_stop), _pad: [0; 2] })
}

/// Puts the opacity of every layer in place of its base opacity.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn illustrate(context: &mut Context<'_>) -> Result<(), GpuError> {
    let Some(illustration) = context.plan.illustration else { return Ok(()) };
    ends::find(context)?;
    operators::run(context, Pass::Boundary, &BOUNDARY, 0)?;
    if context.plan.runs(Pass::FeatureSize) {
        feature_size::measure(context)?;
    }
    operators::repeat(context, Pass::Diffuse, diffuse(context.plan), illustration.most_steps)?;
    operators::run(context, Pass::Illustrate, &ILLUSTRATE, illustration.most_steps)
}
