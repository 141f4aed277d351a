//! Every shader that any plan can ask for, without a GPU.
//!
//! The planner itself is asked, over all choices that the settings offer, and each of its passes names its shaders through
//! the functions that it is drawn with. A variant that is added to a setting or a pass is therefore here without being
//! written down a second time, and the match over [`Pass`] does not compile while a pass is left out.

use std::collections::HashSet;

use super::capture::{bucketed_k_buffer, buckets, compacted};
use super::features::{curvature, neighbours};
use super::geometry::{Vertices, vertex_stages};
use super::{composite, opacity, opaque, shade};
use crate::gpu::ShaderSpec;
use crate::plan::{self, Capabilities, FramePlan, Pass, ViewStats};
use crate::scene::{Scene, SceneStats};
use crate::settings::{
    CaptureKind, CurvatureUnit, DepthQuantization, KeyFormat, NeighbourSearch, NormalEncoding, OpacityModel, Settings,
    Tail,
};
use crate::transfer::{ColorFunction, TransferFunction, TransferSource};

/// The entry point of compute shaders with one.
const MAIN: &[&str] = &["main"];
/// The entry points of geometry passes.
pub const RASTER: &[&str] = &["vertex_main", "fragment_main"];

/// A shader that a pass compiles.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct PassShader {
    /// The pass.
    pub pass: Pass,
    /// What it is composed of.
    pub spec: ShaderSpec,
    /// The entry points that are used.
    pub entries: &'static [&'static str],
    /// Whether the plan keeps a tail, which may bind one storage buffer more.
    pub tail: bool,
}

fn drawn(vertices: Vertices, fragment: &dyn Fn(ShaderSpec) -> ShaderSpec) -> Vec<ShaderSpec> {
    vertex_stages(vertices).into_iter().map(fragment).collect()
}

/// The shaders of a pass in a plan, and their entry points.
fn shaders_of(plan: &FramePlan, pass: Pass) -> (Vec<ShaderSpec>, &'static [&'static str]) {
    let one = |spec| (vec![spec], MAIN);
    match pass {
        Pass::Opaque => (drawn(Vertices::Surface, &|v| opaque::spec(plan, v)), RASTER),
        Pass::ShowOpaque => one(composite::show_opaque_spec()),
        Pass::Clear => one(bucketed_k_buffer::clear_spec(plan)),
        Pass::ZInsertion => (drawn(Vertices::Depth, &|v| bucketed_k_buffer::z_insertion_spec(plan, v)), RASTER),
        Pass::CountLayers => one(bucketed_k_buffer::count_layers_spec()),
        Pass::Count => (drawn(Vertices::Depth, &compacted::count_spec), RASTER),
        Pass::PrefixSum => (vec![compacted::prefix_sum_spec()], &compacted::PREFIX_SUM_ENTRIES),
        Pass::Append => (drawn(Vertices::Surface, &|v| compacted::append_spec(plan, v)), RASTER),
        Pass::Sort => (compacted::sort_specs(plan), MAIN),
        Pass::Gather => one(compacted::gather_spec()),
        Pass::PartLookup => one(buckets::part_lookup_spec(plan)),
        Pass::ZReordering => (buckets::z_reordering_specs(plan), MAIN),
        Pass::BucketCreation => one(buckets::bucket_creation_spec(plan)),
        Pass::DataStorage => (drawn(Vertices::Surface, &|v| bucketed_k_buffer::data_storage_spec(plan, v)), RASTER),
        Pass::NeighbourCandidates => {
            (plan.features.iter().map(|f| neighbours::candidates_spec(plan, f.search)).collect(), MAIN)
        }
        Pass::NeighbourLinks => one(neighbours::links_spec(plan)),
        Pass::Curvature => (plan.features.iter().map(|f| curvature::spec(plan, f)).collect(), MAIN),
        Pass::Shade => one(shade::spec(plan)),
        Pass::Stylize => one(opacity::spec(plan)),
        Pass::Blend => one(composite::blend_spec(plan)),
        Pass::Accumulate => one(composite::accumulate_spec()),
    }
}

/// One plan for every combination of choices that a shader can depend on, duplicates left out.
pub fn all_plans() -> Vec<FramePlan> {
    let capabilities = Capabilities { max_storage_buffers: 32, atomic_min_64: true, ..Capabilities::default() };
    let constant = TransferFunction::uniform(0.5);
    let mut by_depth = TransferFunction::uniform(0.5);
    by_depth.color = ColorFunction::uniform([0.9, 0.5, 0.1]);
    let transfers = [TransferSource::default().resolve(None).unwrap_or_else(|_| constant.clone()), constant, by_depth];
    let empty = SceneStats::of(&Scene::default());
    let scenes = [SceneStats { parts: 1, blended_materials: 1, ..empty.clone() }, SceneStats { parts: 9, ..empty }];
    let mut plans: Vec<FramePlan> = Vec::new();
    let mut seen = HashSet::new();
    for settings in all_settings() {
        for transfer in &transfers {
            for scene in &scenes {
                let view = ViewStats::default();
                let Ok(plan) = plan::plan(&settings, transfer, scene, &view, &capabilities, [64, 64]) else { continue };
                let passes: Vec<Pass> = plan.passes.iter().map(|p| p.pass).collect();
                let key = format!("{:?}", (plan.capture, plan.normals, plan.features, plan.opacity, passes));
                if seen.insert(key) {
                    plans.push(plan);
                }
            }
        }
    }
    plans
}

/// The settings of every combination of choices, with the largest k and several samples.
fn all_settings() -> Vec<Settings> {
    let mut all = vec![Settings::default()];
    fn vary<T: Copy>(all: &mut Vec<Settings>, choices: &[T], set: impl Fn(&mut Settings, T)) {
        let varied = all.iter().flat_map(|settings| {
            choices.iter().map(|&choice| {
                let mut settings = settings.clone();
                set(&mut settings, choice);
                settings
            })
        });
        *all = varied.collect();
    }
    all[0].capture.bucketed_k_buffer.k = 64;
    all[0].image.samples = 2;
    vary(&mut all, CaptureKind::ALL, |s, v| s.capture.kind = v);
    vary(&mut all, NormalEncoding::ALL, |s, v| s.capture.normals = v);
    vary(&mut all, KeyFormat::ALL, |s, v| s.capture.bucketed_k_buffer.key = v);
    vary(&mut all, DepthQuantization::ALL, |s, v| s.capture.bucketed_k_buffer.depth = v);
    vary(&mut all, Tail::ALL, |s, v| s.capture.bucketed_k_buffer.tail = v);
    vary(&mut all, NeighbourSearch::ALL, |s, v| s.features.neighbours = v);
    vary(&mut all, CurvatureUnit::ALL, |s, v| s.features.curvature.unit = v);
    vary(&mut all, OpacityModel::ALL, |s, v| s.opacity.model = v);
    vary(&mut all, &[true, false], |s, v| s.features.reverse_check = v);
    all
}

/// Every shader of every plan, each once.
pub fn all_shaders() -> Vec<PassShader> {
    let mut all = Vec::new();
    let mut seen = HashSet::new();
    for plan in all_plans() {
        let tail = matches!(plan.capture, plan::Capture::BucketedKBuffer { tail: true, .. });
        for planned in &plan.passes {
            let (specs, entries) = shaders_of(&plan, planned.pass);
            for spec in specs {
                let shader = PassShader { pass: planned.pass, spec, entries, tail };
                if seen.insert(shader.clone()) {
                    all.push(shader);
                }
            }
        }
    }
    all
}
