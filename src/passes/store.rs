//! The FragmentStore: which shader modules give access to its columns for a plan.
//!
//! Layers of a pixel lie in depth order from `layer_base(pixel)` on, `layer_count(pixel)` of them. Columns are buffers of one
//! element a layer, named as in the shaders: `keys`, `shapes`, `colors`, `materials`, `lit`, and where planned `parts`,
//! `by_part`, `buckets`, `candidates_…`, `links_…`, `kappas`. A pass binds only the columns that it names.

use crate::gpu::ShaderSpec;
use crate::plan::{Capture, FramePlan};
use crate::settings::{Axis, DepthQuantization, Effect, Knob, NormalEncoding};

/// What the packing of normals loses (T9).
pub const AXES: &[Axis] = &[Axis {
    name: "normals",
    knob: Knob::Setting("capture.normals"),
    values: &["octahedral", "xy15", "full"],
    matters_if: &[],
    effect: Effect::Accuracy { exact: "full" },
}];

/// Shader modules of a plan's store.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoreModules {
    capture: Capture,
    normals: NormalEncoding,
}

impl StoreModules {
    /// The modules for this plan.
    pub fn of(plan: &FramePlan) -> StoreModules {
        StoreModules { capture: plan.capture, normals: plan.normals }
    }

    /// Adds the types of the shape column's words.
    fn shape_words(&self, spec: ShaderSpec) -> ShaderSpec {
        spec.with(match self.normals {
            NormalEncoding::Octahedral | NormalEncoding::Xy15 => "store/shape_words_two",
            NormalEncoding::Full => "store/shape_words_four",
        })
    }

    /// Adds the way in which a normal is written beside a depth that is there already.
    pub fn normals_alone(&self, spec: ShaderSpec) -> ShaderSpec {
        self.shape_words(spec).with(match self.normals {
            NormalEncoding::Octahedral | NormalEncoding::Xy15 => "store/place_normal_two",
            NormalEncoding::Full => "store/place_normal_four",
        })
    }

    /// Adds access to the layers of a pixel.
    pub fn layout(&self, spec: ShaderSpec) -> ShaderSpec {
        self.shape_words(spec).with(match self.capture {
            Capture::BucketedKBuffer { .. } => "store/layout_rows",
            Capture::Compacted | Capture::LinkedList { .. } | Capture::None => "store/layout_compacted",
        })
    }

    /// Adds the key column.
    pub fn keys(&self, spec: ShaderSpec) -> ShaderSpec {
        match self.capture {
            Capture::BucketedKBuffer { depth, .. } if !self.capture.is_wide() => {
                spec.with("store/key_packed32").constant("PACKED_DEPTH", packed_depth(depth))
            }
            _ => spec.with("store/key_wide64"),
        }
    }

    /// Adds the packing of normals.
    pub fn normals(&self, spec: ShaderSpec) -> ShaderSpec {
        self.shape_words(spec).with(match self.normals {
            NormalEncoding::Octahedral => "store/normal_octahedral",
            NormalEncoding::Xy15 => "store/normal_xy15",
            NormalEncoding::Full => "store/normal_full",
        })
    }

    /// Adds the colour column.
    pub fn colors(&self, spec: ShaderSpec) -> ShaderSpec {
        spec.with(if self.capture.is_wide() { "store/color_half" } else { "store/color_rgba8" })
    }
}

/// The constant by which `store/packed_depth.wgsl` tells the quantizations apart.
pub fn packed_depth(depth: DepthQuantization) -> &'static str {
    match depth {
        DepthQuantization::Linear => "0u",
        DepthQuantization::ZOverW => "1u",
        DepthQuantization::Reversed => "2u",
    }
}
