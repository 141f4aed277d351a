//! Every shader that any plan can ask for, without a GPU.
//!
//! The planner itself is asked, over all choices that the settings offer, and each of its passes names its shaders through
//! the functions that it is drawn with. A variant that is added to a setting or a pass is therefore here without being
//! written down a second time, and the match over [`Pass`] does not compile while a pass is left out.

use std::collections::HashSet;

use super::capture::{bucketed_k_buffer, buckets, compacted, linked_list, sort};
use super::composite::outline;
use super::features::{curvature, neighbours, parameters};
use super::geometry::{CLIP, Vertices, vertex_stages};
use super::store::StoreModules;
use super::{composite, illustration, opacity, opaque, operators, shade};
use crate::gpu::ShaderSpec;
use crate::plan::{self, Capabilities, Capture, FramePlan, Opacity, Pass, ViewStats};
use crate::scene::{Scene, SceneStats};
use crate::settings::{
    CaptureKind, CurvatureUnit, DepthQuantization, DepthTerm, Diffusion, KeyFormat, ListSort, NeighbourSearch,
    NormalEncoding, OpacityModel, PrintedForm, Settings, SlotSearch, Tail,
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
    /// Whether parts have looks of their own, which then may bind one more.
    pub looks: bool,
    /// Whether the plan asks the adapter for 64-bit atomics.
    pub atomics_64: bool,
}

/// A shader and the entry points that are used.
pub type Used = (ShaderSpec, &'static [&'static str]);

fn drawn(vertices: Vertices, fragment: &dyn Fn(ShaderSpec) -> ShaderSpec) -> Vec<Used> {
    vertex_stages(vertices).into_iter().map(|vertex| (fragment(vertex), RASTER)).collect()
}

fn sorted(plan: &FramePlan, elements: &'static str, classified: bool) -> Vec<Used> {
    let modules = StoreModules::of(plan);
    let longest = match plan.capture {
        Capture::BucketedKBuffer { k, .. } => k,
        Capture::Compacted | Capture::LinkedList { .. } | Capture::None => u32::MAX / 2,
    };
    let classes = classified.then(|| (sort::classify_spec(&modules), sort::CLASSIFY_ENTRIES.as_slice()));
    let sorts = sort::sort_specs(&modules, elements, longest).into_iter().map(|spec| (spec, MAIN));
    classes.into_iter().chain(sorts).collect()
}

/// The shaders that sort the lists of a plan, however long: a frame compiles those for the lengths that it meets.
pub fn sorts(plan: &FramePlan) -> Vec<Used> {
    if plan.runs(Pass::Sort) { shaders_of(plan, Pass::Sort) } else { Vec::new() }
}

/// Whether lists are sorted without being classified by their length.
fn by_selection(plan: &FramePlan) -> bool {
    matches!(plan.capture, Capture::LinkedList { sort: ListSort::Selection, .. })
}

/// The shaders of a pass in a plan.
fn shaders_of(plan: &FramePlan, pass: Pass) -> Vec<Used> {
    let one = |spec| vec![(spec, MAIN)];
    match pass {
        Pass::Opaque => drawn(Vertices::Surface, &|v| opaque::spec(plan, v)),
        Pass::ShowOpaque => one(composite::show_opaque_spec()),
        Pass::Clear => one(bucketed_k_buffer::clear_spec(plan)),
        Pass::ZInsertion => drawn(Vertices::Depth, &|v| bucketed_k_buffer::z_insertion_spec(plan, v)),
        Pass::CountLayers => one(bucketed_k_buffer::count_layers_spec()),
        Pass::Count => drawn(Vertices::Depth, &|v| compacted::count_spec(plan, v)),
        Pass::PrefixSum => vec![(compacted::prefix_sum_spec(), &compacted::PREFIX_SUM_ENTRIES)],
        Pass::Append => drawn(Vertices::Surface, &|v| compacted::append_spec(plan, v)),
        Pass::Fill => drawn(Vertices::Surface, &|v| linked_list::fill_spec(plan, v)),
        Pass::Sort => match plan.capture {
            Capture::LinkedList { sort: sort @ ListSort::Selection, .. } => one(linked_list::walk_spec(plan, sort)),
            Capture::LinkedList { sort, .. } => {
                let mut all = sorted(plan, linked_list::SORTED, true);
                all.push((linked_list::walk_spec(plan, sort), MAIN));
                all
            }
            _ => sorted(plan, compacted::SORTED, true),
        },
        Pass::Gather => one(compacted::gather_spec(plan)),
        Pass::PartLookup => one(buckets::part_lookup_spec(plan)),
        Pass::ZReordering => sorted(plan, buckets::SORTED, !plan.runs(Pass::Sort) || by_selection(plan)),
        Pass::BucketCreation => one(buckets::bucket_creation_spec(plan)),
        Pass::DataStorage => drawn(Vertices::Surface, &|v| bucketed_k_buffer::data_storage_spec(plan, v)),
        // One vertex stage serves textured primitives too.
        Pass::Parametrize => drawn(Vertices::Parameters, &|v| parameters::spec(plan, v)).into_iter().take(1).collect(),
        Pass::NeighbourCandidates => {
            plan.features.iter().map(|f| (neighbours::candidates_spec(plan, f), MAIN)).collect()
        }
        Pass::NeighbourLinks => {
            let links = plan.features.iter();
            let open = links.clone().filter_map(|f| neighbours::open_spec(plan, f));
            let open = open.flat_map(|spec| [(neighbours::arrange_spec(), MAIN), (spec, MAIN)]);
            links.map(|f| (neighbours::links_spec(plan, f), neighbours::links_entries(f))).chain(open).collect()
        }
        Pass::CutLinks => one(neighbours::cut_spec(plan)),
        Pass::Curvature => plan.features.iter().map(|f| (curvature::spec(plan, f), MAIN)).collect(),
        Pass::Shade => one(shade::spec(plan)),
        Pass::LayerHistogram => {
            vec![(opacity::SHARES.gather_spec(plan), MAIN), (opacity::SHARES.settle_spec(), MAIN)]
        }
        Pass::Stylize => opacity::operator(plan.opacity).iter().flat_map(|o| one(o.spec(plan))).collect(),
        Pass::Boundary => {
            let ends = illustration::ends::spec(plan);
            let seams = illustration::ends::seams_spec(plan);
            vec![
                (ends, illustration::ends::ENTRIES.as_slice()),
                (neighbours::arrange_spec(), MAIN),
                (seams, MAIN),
                (illustration::ends::behind_spec(plan), MAIN),
                (illustration::BOUNDARY.spec(plan), MAIN),
            ]
        }
        Pass::FeatureSize => {
            let sizes = illustration::feature_size::runs_spec(plan);
            vec![(sizes, MAIN), (illustration::feature_size::chords_spec(plan), MAIN)]
        }
        Pass::Diffuse => vec![(operators::next_step_spec(plan), MAIN), (illustration::diffuse(plan).spec(plan), MAIN)],
        Pass::Illustrate => one(illustration::ILLUSTRATE.spec(plan)),
        Pass::Blend => one(composite::blend_spec(plan)),
        Pass::OutlineMask => drawn(Vertices::Depth, &|v| outline::mask_spec(plan, v)),
        Pass::Outline => one(outline::outline_spec()),
        Pass::Accumulate => one(composite::accumulate_spec()),
    }
}

/// One plan for every combination of choices that a shader can depend on, duplicates left out.
pub fn all_plans() -> Vec<FramePlan> {
    let capabilities = Capabilities { max_storage_buffers: 32, atomic_min_64: true, ..Capabilities::default() };
    let empty = SceneStats::of(&Scene::default());
    let plain = SceneStats { parts: 9, parametrized_parts: 1, ..empty.clone() };
    let scenes = [
        SceneStats { parts: 1, blended_materials: 1, ..empty },
        SceneStats { recolored_parts: 1, selected_parts: 1, ..plain.clone() },
        SceneStats { faded_parts: 1, recolored_parts: 1, ..plain.clone() },
        SceneStats { section_planes: 2, selected_parts: 1, ..plain.clone() },
        SceneStats { section_planes: 1, faded_parts: 1, recolored_parts: 1, ..plain.clone() },
        plain,
    ];
    let opacities = all_opacities();
    let mut plans: Vec<FramePlan> = Vec::new();
    let mut seen = HashSet::new();
    let usual = Settings::default().features;
    for settings in all_settings() {
        // How features are computed concerns no shader of the stages after them: one opacity for each set of features is enough,
        // and the scenes that have something to say about neighbours.
        let features_alone = settings.features != usual;
        for opacity in opacities.iter().filter(|o| !features_alone || FEATURES_FOR.contains(o)) {
            for scene in scenes.iter().filter(|s| !features_alone || s.recolored_parts + s.blended_materials == 0) {
                let view = ViewStats::default();
                let Ok(plan) = plan::plan_with(&settings, *opacity, scene, &view, &capabilities, [64, 64]) else {
                    continue;
                };
                let passes: Vec<Pass> = plan.passes.iter().map(|p| p.pass).collect();
                let looks = (plan.faded, plan.recolored, plan.section_planes > 0);
                let key = format!(
                    "{:?}",
                    (plan.capture, plan.normals, plan.features, plan.opacity, plan.illustration, looks, passes)
                );
                if seen.insert(key) {
                    plans.push(plan);
                }
            }
        }
    }
    plans
}

/// Opacities that need neighbours with curvature, and without.
const FEATURES_FOR: [Opacity; 2] = [Opacity::Curvature, Opacity::NormalVariation];

/// What every opacity model makes of transfer functions that vary with curvature, with depth, with nothing.
fn all_opacities() -> Vec<Opacity> {
    let constant = TransferFunction::uniform(0.5);
    let mut colored = constant.clone();
    colored.color = ColorFunction::uniform([0.9, 0.5, 0.1]);
    let usual = TransferSource::default().resolve(None).unwrap_or_else(|_| constant.clone());
    let mut all = Vec::new();
    for &model in OpacityModel::ALL {
        let mut settings = Settings::default();
        settings.opacity.model = model;
        for transfer in [&usual, &colored, &constant] {
            let opacity = plan::choose_opacity(&settings, transfer);
            if !all.contains(&opacity) {
                all.push(opacity);
            }
        }
    }
    all
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
    all[0].opacity.model = OpacityModel::Curvature;
    all[0].image.samples = 2;
    // What is another capture's changes nothing.
    let mut captures = Vec::new();
    for &kind in CaptureKind::ALL {
        let mut some = all.clone();
        some[0].capture.kind = kind;
        match kind {
            CaptureKind::Compacted => {}
            CaptureKind::LinkedList => vary(&mut some, ListSort::ALL, |s, v| s.capture.linked_list.sort = v),
            CaptureKind::BucketedKBuffer => {
                vary(&mut some, KeyFormat::ALL, |s, v| s.capture.bucketed_k_buffer.key = v);
                vary(&mut some, DepthQuantization::ALL, |s, v| s.capture.bucketed_k_buffer.depth = v);
                vary(&mut some, SlotSearch::ALL, |s, v| s.capture.bucketed_k_buffer.slot_search = v);
                vary(&mut some, Tail::ALL, |s, v| s.capture.bucketed_k_buffer.tail = v);
            }
        }
        captures.extend(some);
    }
    all = captures;
    vary(&mut all, NormalEncoding::ALL, |s, v| s.capture.normals = v);
    vary(&mut all, NeighbourSearch::ALL, |s, v| s.features.neighbours = v);
    vary(&mut all, DepthTerm::ALL, |s, v| s.features.depth_term = v);
    vary(&mut all, CurvatureUnit::ALL, |s, v| s.features.curvature.unit = v);
    vary(&mut all, &[true, false], |s, v| s.features.reverse_check = v);
    // Illustrative transparency looks at links alone, however they were found.
    let usual = Settings::default().features;
    let (plain, other): (Vec<Settings>, Vec<Settings>) = all.into_iter().partition(|s| s.features == usual);
    let mut all = plain.clone();
    all.extend(other);
    for (printed, feature_size) in [(PrintedForm::None, 0), (PrintedForm::None, 20), (PrintedForm::Transmittance, 0)] {
        all.extend(plain.iter().cloned().map(|mut s| {
            s.opacity.model = OpacityModel::Illustrative;
            s.opacity.illustrative.printed = printed;
            s.opacity.illustrative.feature_size = feature_size;
            s
        }));
    }
    // Fields that do not spread.
    all.extend(plain.iter().cloned().map(|mut s| {
        let fields = &mut s.opacity.illustrative;
        s.opacity.model = OpacityModel::Illustrative;
        fields.alpha.diffusion = Diffusion::None;
        fields.beta.diffusion = Diffusion::None;
        fields.gamma.diffusion = Diffusion::None;
        s
    }));
    all
}

/// Every shader of every plan, each once, and those of measurements.
pub fn all_shaders() -> Vec<PassShader> {
    let unsorted = CLIP.into_iter().flat_map(|clip| drawn(Vertices::Surface, &|v| opaque::unsorted_spec(v, clip)));
    let measured = |(spec, entries)| PassShader {
        pass: Pass::Opaque,
        spec,
        entries,
        tail: false,
        looks: false,
        atomics_64: false,
    };
    let mut all: Vec<PassShader> = unsorted.map(measured).collect();
    let mut seen = HashSet::new();
    for plan in all_plans() {
        let tail = matches!(plan.capture, Capture::BucketedKBuffer { tail: true, .. });
        let atomics_64 = matches!(plan.capture, Capture::BucketedKBuffer { key: KeyFormat::Wide64, .. });
        for planned in &plan.passes {
            for (spec, entries) in shaders_of(&plan, planned.pass) {
                let looks = plan.faded || plan.recolored;
                let shader = PassShader { pass: planned.pass, spec, entries, tail, looks, atomics_64 };
                if seen.insert(shader.clone()) {
                    all.push(shader);
                }
            }
        }
    }
    all
}
