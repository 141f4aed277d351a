//! Operators over the store, as the illustration buffer has them (Carnecky 2013, section 4.5): a new one is a function in WGSL and
//! an [`Operator`].
//!
//! - **Pointwise**: `fn operate(at: Layer, color: vec4<f32>) -> vec4<f32>` gives a layer's lit colour and opacity anew, in place.
//!   It may read the layers of its pixel (`at.count` of them from `at.base` on), features, and neighbours through
//!   `passes/operators/around`, but no other layer's lit colour.
//! - **Local**: `fn operate(at: Layer, own: vec4<f32>, around: Around, beside: Beside) -> vec4<f32>` gives a layer's fields
//!   (four numbers that mean what the operator says) from its own and its neighbours'. Fields are read from `field_in`
//!   (`field_of(slot)`) and written to `field_out`, the two columns changing places (ping-pong), so the order of layers does
//!   not matter; the first operator of a frame reads none.
//! - **Repeated**: a local operator of many steps, [`repeat`]: `fn operate(slot: u32, own: vec4<f32>, slots: vec4<u32>) -> vec4<f32>`
//!   gets the slots of its neighbours, which the first operator left in a column of 16 bytes a layer, and runs over layers
//!   instead of pixels. `fn has_changed(own, next) -> bool` says whether a step was worth it, and the GPU stops where none was.
//! - **Global**: `fn gather(at: Layer)` adds to counters (`gathered`) for every layer of the image, `fn settle()` makes a table of
//!   them (`settled`), and a pointwise operator reads that. A frame in several bands is gathered from all of them before the
//!   first is lit.
//!
//! Which modules give access to the store is added here, so that an operator runs over every capture. A plan whose fields come
//! from n rows away captures and lights n rows more above and below a band ([`FramePlan::lit_apron`]).

use crate::gpu::{GpuError, Resources, ShaderSpec};
use crate::passes::Context;
use crate::passes::store::StoreModules;
use crate::plan::{Capture, FramePlan, Pass};

/// What an operator takes and gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Colour and opacity of a layer, in place.
    Pointwise,
    /// Fields of a layer, from nothing into the first column.
    First,
    /// Fields of a layer, from one column into the other.
    Local,
    /// The same, many times.
    Repeated,
}

/// An operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Operator {
    /// What it takes and gives.
    pub kind: Kind,
    /// The shader module that declares `operate`.
    pub module: &'static str,
}

impl Operator {
    /// A pointwise operator.
    pub const fn pointwise(module: &'static str) -> Operator {
        Operator { kind: Kind::Pointwise, module }
    }

    /// A local operator that makes the first fields.
    pub const fn first(module: &'static str) -> Operator {
        Operator { kind: Kind::First, module }
    }

    /// A local operator.
    pub const fn local(module: &'static str) -> Operator {
        Operator { kind: Kind::Local, module }
    }

    /// A local operator that is repeated.
    pub const fn repeated(module: &'static str) -> Operator {
        Operator { kind: Kind::Repeated, module }
    }

    /// The shader.
    pub fn spec(&self, plan: &FramePlan) -> ShaderSpec {
        let modules = StoreModules::of(plan);
        let around = match (self.kind, plan.runs(Pass::Diffuse)) {
            (Kind::First, true) => KEPT,
            _ => "passes/operators/around_dropped",
        };
        let local = || ShaderSpec::new("passes/operators/local").with(around);
        let root = match self.kind {
            Kind::Pointwise => ShaderSpec::new("passes/operators/pointwise"),
            Kind::First => local().with("passes/operators/field_none"),
            Kind::Local => local().with("passes/operators/field_before"),
            Kind::Repeated => {
                let root = ShaderSpec::new("passes/operators/repeated").with(self.module).with(listing(plan));
                return modules.layout(root).constant("STEP_ROW", STEP_ROW);
            }
        };
        let root = if around == KEPT { root.with(listing(plan)) } else { root };
        modules.normals(modules.keys(modules.layout(root.with(self.module))))
    }
}

/// What all layers of the image together say, for a pointwise operator to read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Global {
    /// The shader module that declares `gather`.
    pub gather: &'static str,
    /// The one that declares `settle`.
    pub settle: &'static str,
}

/// Bytes of what a global operator gathers, and of the table.
pub const GATHERED_BYTES: u64 = 4 * 256;

impl Global {
    /// The shader that gathers.
    pub fn gather_spec(&self, plan: &FramePlan) -> ShaderSpec {
        StoreModules::of(plan).layout(ShaderSpec::new("passes/operators/global").with(self.gather))
    }

    /// The shader that settles.
    pub fn settle_spec(&self) -> ShaderSpec {
        ShaderSpec::new("passes/operators/settle").with(self.settle)
    }
}

/// Forgets what was gathered.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn forget(context: &mut Context<'_>, pass: Pass) -> Result<(), GpuError> {
    let gathered = context.resources.require(pass.name(), "gathered")?;
    context.recorder.encoder.clear_buffer(gathered, 0, None);
    Ok(())
}

/// Gathers from the rows that the band writes.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn gather(context: &mut Context<'_>, pass: Pass, operator: &Global) -> Result<(), GpuError> {
    context.per_pixel(pass, &operator.gather_spec(context.plan), "main")
}

/// Makes the table of what was gathered.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn settle(context: &mut Context<'_>, pass: Pass, operator: &Global) -> Result<(), GpuError> {
    context.compute(pass, &operator.settle_spec(), "main", [1, 1, 1])
}

/// The module that keeps the neighbours of every layer.
const KEPT: &str = "passes/operators/around_kept";

/// The module that says which slots hold layers, for operators that are repeated.
fn listing(plan: &FramePlan) -> &'static str {
    match plan.capture {
        Capture::BucketedKBuffer { .. } => "passes/operators/layers_listed",
        Capture::Compacted | Capture::LinkedList { .. } | Capture::None => "passes/operators/layers_without_gaps",
    }
}

/// Workgroups in a row of a step's dispatch; more are put into further rows.
const STEP_ROW: &str = "32768u";

/// The shader that decides before each step of [`repeat`] whether it is taken.
pub fn next_step_spec(plan: &FramePlan) -> ShaderSpec {
    StoreModules::of(plan)
        .layout(ShaderSpec::new("passes/operators/next_step").with(listing(plan)))
        .constant("STEP_ROW", STEP_ROW)
}

/// The columns of the fields: the one that is written first, and the other.
const COLUMNS: [&str; 2] = ["fields_even", "fields_odd"];

/// The column that holds the fields after so many steps.
pub fn column_after(steps: u32) -> &'static str {
    COLUMNS[steps as usize % 2]
}

/// The resources in which fields are read from the column of step `step` and written to the next one's.
fn columns_of(resources: &Resources, step: u32) -> Resources {
    let mut turned = resources.clone();
    turned.alias("field_in", column_after(step));
    turned.alias("field_out", column_after(step + 1));
    turned
}

/// Runs an operator once: a pointwise one over the fields after `step` steps, if it reads any; a local one from them to the
/// next.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn run(context: &mut Context<'_>, pass: Pass, operator: &Operator, step: u32) -> Result<(), GpuError> {
    let kernel = context.shaders.kernel(&operator.spec(context.plan), "main")?;
    let groups = [context.width().div_ceil(16), context.rows().div_ceil(16), 1];
    let mut resources = columns_of(context.resources, step);
    if operator.kind == Kind::First {
        resources.alias("field_out", column_after(0));
        context.recorder.encoder.clear_buffer(context.resources.require(pass.name(), "steps")?, 0, None);
    }
    context.recorder.compute(pass, &kernel, &context.frame, &resources, groups)
}

/// Repeats an operator `most` times, or until a step changes nothing, after one of [`Kind::First`]. The fields are then in `column_after(most)`,
/// however many steps were taken.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn repeat(context: &mut Context<'_>, pass: Pass, operator: &Operator, most: u32) -> Result<(), GpuError> {
    let next = context.shaders.kernel(&next_step_spec(context.plan), "main")?;
    let kernel = context.shaders.kernel(&operator.spec(context.plan), "main")?;
    let arguments = context.resources.require(pass.name(), "step_arguments")?.clone();
    let both = [columns_of(context.resources, 0), columns_of(context.resources, 1)];
    for step in 0..most {
        context.recorder.compute(pass, &next, &context.frame, context.resources, [1, 1, 1])?;
        let resources = &both[step as usize % 2];
        context.recorder.compute_indirect(pass, &kernel, &context.frame, resources, (&arguments, 0))?;
    }
    Ok(())
}
