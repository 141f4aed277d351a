//! Tests of the planner: no GPU is needed for any of them.

use proptest::prelude::*;

use super::*;
use crate::scene::Scene;
use crate::settings::{BaseOpacity, LengthUnit};
use crate::transfer::{ColorFunction, TransferSource};

const SIZE: [u32; 2] = [640, 480];

fn adapter() -> Capabilities {
    Capabilities { max_storage_buffers: 16, atomic_min_64: true, ..Capabilities::default() }
}

fn scene(parts: u64) -> SceneStats {
    SceneStats { parts, ..SceneStats::of(&Scene::default()) }
}

fn view() -> ViewStats {
    ViewStats { visible_height: 2.0, fragments: None }
}

fn usual() -> TransferFunction {
    TransferSource::default().resolve(None).unwrap()
}

fn planned(settings: &Settings, transfer: &TransferFunction) -> FramePlan {
    plan(settings, transfer, &scene(20), &view(), &adapter(), SIZE).unwrap()
}

/// Curvature alone.
fn stylized() -> Settings {
    Settings::from_pairs("opacity.model=curvature").unwrap()
}

fn bucketed(k: u32) -> Settings {
    let mut settings = stylized();
    settings.capture.kind = CaptureKind::BucketedKBuffer;
    settings.capture.bucketed_k_buffer.k = k;
    settings
}

fn names(plan: &FramePlan) -> Vec<&'static str> {
    plan.buffers.iter().map(|b| b.name).collect()
}

fn skipped<'a>(plan: &'a FramePlan, what: &str) -> &'a str {
    &plan.skipped.iter().find(|s| s.what.contains(what)).unwrap_or_else(|| panic!("'{what}' is not skipped")).reason
}

const FEATURES: [Pass; 4] = [Pass::ZReordering, Pass::BucketCreation, Pass::NeighbourLinks, Pass::Curvature];

#[test]
fn constant_functions_need_no_neighbours_and_no_curvature() {
    for settings in [stylized(), bucketed(8)] {
        let with = planned(&settings, &usual());
        assert!(FEATURES.iter().all(|p| with.runs(*p)), "{with}");
        assert!(with.features.is_some() && with.runs(Pass::Stylize) && with.apron > 0);

        let plain = planned(&settings, &TransferFunction::uniform(0.4));
        assert_eq!(plain.opacity, Opacity::Constant { alpha: f64::from(0.4_f32) });
        assert!(!FEATURES.iter().any(|p| plain.runs(*p)) && !plain.runs(Pass::Stylize), "{plain}");
        assert_eq!((plain.features, plain.apron), (None, 0));
        assert_eq!(skipped(&plain, "neighbours"), "no transfer function varies with curvature");
        let columns: Vec<_> = plain.columns().into_iter().map(|(name, _)| name).collect();
        for absent in ["parts", "by_part", "buckets", "candidates_ahead", "links_ahead", "kappas", "class_pixels"] {
            assert!(!columns.contains(&absent), "{absent}");
        }
        assert!(plain.total_bytes() < with.total_bytes());

        let mut constant = settings.clone();
        constant.opacity.model = OpacityModel::Constant;
        assert_eq!(skipped(&planned(&constant, &usual()), "neighbours"), "opacity is constant");
    }
}

#[test]
fn a_constant_colour_that_is_not_neutral_still_colours() {
    let mut tinted = TransferFunction::uniform(0.4);
    tinted.color = ColorFunction::uniform([0.9, 0.5, 0.5]);
    let plan = planned(&Settings::default(), &tinted);
    assert_eq!(plan.opacity, Opacity::Depth);
    assert!(plan.runs(Pass::Stylize) && !plan.runs(Pass::Curvature) && !plan.runs(Pass::NeighbourCandidates));
}

#[test]
fn opaque_surfaces_need_no_capture() {
    let mut settings = bucketed(8);
    settings.opacity.model = OpacityModel::Opaque;
    let plan = planned(&settings, &usual());
    assert_eq!(plan.capture, Capture::None);
    let passes: Vec<_> = plan.passes.iter().map(|p| p.pass).collect();
    assert_eq!(passes, [Pass::Opaque, Pass::ShowOpaque]);
    assert_eq!(names(&plan), ["image", "opaque_colors", "opaque_depth"]);
    assert_eq!(plan.columns(), []);
    assert!(skipped(&plan, "capture").contains("opaque"));
    assert_eq!(plan.bands.len(), 1);

    // One material that blends, and the layers behind it count.
    let glass = SceneStats { blended_materials: 1, ..scene(20) };
    let with_glass = super::plan(&settings, &usual(), &glass, &view(), &adapter(), SIZE).unwrap();
    assert_ne!(with_glass.capture, Capture::None);
    assert!(with_glass.passes.iter().any(|p| p.reason.contains("1 material blends")), "{with_glass}");

    // A constant opacity of 1 is as opaque.
    settings.opacity.model = OpacityModel::Constant;
    settings.opacity.constant = 1.0;
    assert_eq!(planned(&settings, &usual()).capture, Capture::None);
}

#[test]
fn brute_force_needs_no_buckets_and_buckets_no_candidates() {
    for mut settings in [Settings::default(), bucketed(8)] {
        assert!(!planned(&settings, &usual()).runs(Pass::NeighbourCandidates));
        settings.features.neighbours = NeighbourSearch::BruteForce;
        let plan = planned(&settings, &usual());
        assert!(plan.runs(Pass::NeighbourCandidates) && plan.runs(Pass::NeighbourLinks) && plan.runs(Pass::Curvature));
        assert!(!plan.runs(Pass::ZReordering) && !plan.runs(Pass::BucketCreation));
        assert!(!names(&plan).contains(&"buckets") && !names(&plan).contains(&"by_part"));
    }
    // The search by buckets includes the reverse check.
    let mut unchecked = Settings::default();
    unchecked.features.reverse_check = false;
    let plan = planned(&unchecked, &usual());
    assert_eq!(plan.features.unwrap().search, NeighbourSearch::BruteForce);
    assert!(skipped(&plan, "buckets").contains("reverse_check"));
}

#[test]
fn one_sample_needs_no_sums_and_no_reverse_check_no_links() {
    let one = planned(&Settings::default(), &usual());
    assert!(!one.runs(Pass::Accumulate) && !names(&one).contains(&"sums"));
    let mut settings = Settings::default();
    settings.image.samples = 4;
    settings.features.reverse_check = false;
    let plan = planned(&settings, &usual());
    assert!(plan.runs(Pass::Accumulate) && names(&plan).contains(&"sums"));
    assert!(!plan.runs(Pass::NeighbourLinks) && !names(&plan).contains(&"links_ahead"));
    assert_eq!(skipped(&plan, "neighbour links"), "features.reverse_check is off");
}

/// What only one pass uses is there if and only if the pass runs.
#[test]
fn an_unplanned_pass_allocates_nothing() {
    let mut tail = bucketed(8);
    tail.capture.bucketed_k_buffer.tail = Tail::Average;
    let opaque = Settings::from_pairs("opacity.model=opaque").unwrap();
    let mut by_bucket = bucketed(8);
    by_bucket.capture.bucketed_k_buffer.slot_search = SlotSearch::Bucket;
    let mut lists = Settings::default();
    lists.capture.kind = CaptureKind::LinkedList;
    let mut illustrative = lists.clone();
    illustrative.opacity.model = OpacityModel::Illustrative;
    for settings in [Settings::default(), bucketed(8), tail, by_bucket, opaque, lists, illustrative] {
        for transfer in [usual(), TransferFunction::uniform(0.5)] {
            for parts in [1, 20] {
                let plan = plan(&settings, &transfer, &scene(parts), &view(), &adapter(), SIZE).unwrap();
                // Data storage fills the part column too.
                let part_column = plan.features.is_some() || plan.runs(Pass::PartLookup);
                assert_eq!(names(&plan).contains(&"parts"), part_column, "{plan}");
                for (buffer, pass) in [
                    ("by_part", Pass::ZReordering),
                    ("buckets", Pass::BucketCreation),
                    ("candidates_ahead", Pass::NeighbourCandidates),
                    ("links_behind", Pass::NeighbourLinks),
                    ("kappas", Pass::Curvature),
                    ("lit", Pass::Shade),
                    ("tally", Pass::ZInsertion),
                    ("list_heads", Pass::Fill),
                    ("list_next", Pass::Fill),
                    ("ends", Pass::Boundary),
                    ("layer_ends", Pass::Boundary),
                    ("fields_even", Pass::Boundary),
                    ("fields_odd", Pass::Diffuse),
                    ("sources", Pass::Sort),
                    ("sums", Pass::Accumulate),
                    ("opaque_colors", Pass::Opaque),
                    ("keys", Pass::Blend),
                ] {
                    assert_eq!(names(&plan).contains(&buffer), plan.runs(pass), "{buffer} for {pass:?}\n{plan}");
                }
            }
        }
    }
}

#[test]
fn linked_lists_fill_where_compacted_ones_count_and_append() {
    let mut settings = Settings::default();
    settings.capture.kind = CaptureKind::LinkedList;
    settings.capture.linked_list.memory = 16;
    let lists = planned(&settings, &usual());
    assert!(lists.runs(Pass::Fill) && !lists.runs(Pass::Count) && !lists.runs(Pass::Append), "{lists}");
    assert!(lists.runs(Pass::PrefixSum) && lists.runs(Pass::Sort) && lists.runs(Pass::Gather));
    let bytes: u64 = lists.columns().iter().map(|(_, bytes)| bytes).sum();
    assert_eq!(lists.most_fragments(1 << 30), (16 << 20) / bytes, "what memory allows");
    assert_eq!(lists.most_fragments(1 << 10), (1 << 10) / lists.widest_column(), "what a binding allows");
    assert_eq!((lists.first_capacity(10), planned(&Settings::default(), &usual()).first_capacity(10)), (90, 90));
    settings.capture.linked_list.capacity = 7;
    assert_eq!(planned(&settings, &usual()).first_capacity(10), 7);
    // A picked pixel needs no lists.
    let picked = plan_pick(&settings, &usual(), &scene(20), &view(), &adapter(), SIZE, 3).unwrap();
    assert_eq!(picked.capture, Capture::Compacted);
}

#[test]
fn illustrative_transparency_needs_neighbours_and_an_apron_as_wide_as_its_steps() {
    let mut settings = Settings::default();
    settings.opacity.illustrative.base = BaseOpacity::Adaptive;
    settings.opacity.illustrative.unit = LengthUnit::Pixel;
    let plan = planned(&settings, &usual());
    for pass in
        [Pass::NeighbourLinks, Pass::Stylize, Pass::Boundary, Pass::FeatureSize, Pass::Diffuse, Pass::Illustrate]
    {
        assert!(plan.runs(pass), "{plan}");
    }
    assert!(!plan.runs(Pass::Curvature) && !names(&plan).contains(&"kappas"), "{plan}");
    assert_eq!(skipped(&plan, "curvature"), "opacity does not depend on curvature");
    assert_eq!((plan.lit_apron(), plan.apron), (20, 20 + 24 + 1));
    settings.opacity.illustrative.feature_size = 0;
    let isotropic = planned(&settings, &usual());
    assert_eq!((isotropic.apron, skipped(&isotropic, "feature size")), (21, "diffusion is isotropic"));
    settings.opacity.illustrative.beta.lambda = 0.01;
    settings.opacity.illustrative.base = BaseOpacity::Curvature;
    let wide = planned(&settings, &usual());
    assert_eq!(wide.illustration.map(|i| (i.heat_steps, i.most_steps)), Some((20, 100)));
    assert!(wide.runs(Pass::Curvature) && wide.apron == 100 + wide.features.unwrap().reach);
    // An opaque base is still transparent in its halos.
    settings.opacity.illustrative.base = BaseOpacity::Constant;
    settings.opacity.constant = 1.0;
    let opaque = planned(&settings, &usual());
    assert_ne!(opaque.capture, Capture::None);
    assert_eq!(opaque.blend_opacity(), 1.0);
    let none = planned(&stylized(), &usual());
    assert!(skipped(&none, "illustrate").contains("silhouettes") && none.illustration.is_none());
}

#[test]
fn models_without_transfer_functions_need_what_they_look_at() {
    for (model, links) in
        [(OpacityModel::Adaptive, false), (OpacityModel::AngleBased, false), (OpacityModel::NormalVariation, true)]
    {
        for mut settings in [Settings::default(), bucketed(8)] {
            settings.opacity.model = model;
            let plan = planned(&settings, &usual());
            assert_eq!(plan.runs(Pass::NeighbourLinks), links, "{plan}");
            assert!(plan.runs(Pass::Stylize) && !plan.runs(Pass::Curvature) && !plan.runs(Pass::Boundary), "{plan}");
        }
    }
}

#[test]
fn a_store_larger_than_a_binding_is_made_in_bands() {
    // The paper's case: 36 layers of 8 bytes in a megapixel are 275 MiB.
    let plan = plan(&bucketed(36), &usual(), &scene(20), &view(), &adapter(), [1000, 1000]).unwrap();
    assert_eq!(plan.bands.len(), 3, "{:?}", plan.bands);
    check_bands(&plan);
    assert!(plan.to_string().contains("3 bands"), "{plan}");
    let reach = plan.features.unwrap().reach;
    assert_eq!(plan.apron, reach);
    for b in &plan.bands {
        assert_eq!(b.first_row, b.first_output_row.saturating_sub(reach));
        assert_eq!(b.end_row, (b.end_output_row + reach).min(1000));
    }
    let without = planned(&bucketed(36), &TransferFunction::uniform(0.5));
    assert_eq!((without.bands.len(), without.apron), (1, 0));
}

#[test]
fn the_apron_reaches_as_far_as_lines_and_radius() {
    let mut settings = bucketed(8);
    settings.features.curvature.radius = 0.02;
    settings.features.curvature.line_width = 0.0;
    assert_eq!(planned(&settings, &usual()).apron, 10);
    settings.features.curvature.radius = 0.0;
    settings.features.curvature.line_width = 0.01;
    let plan = planned(&settings, &usual());
    assert_eq!((plan.features.unwrap().radius, plan.apron), (1, 5));
}

/// The refusal of a request that cannot be met.
fn refusal(settings: &Settings, parts: u64, capabilities: &Capabilities, size: [u32; 2]) -> Refusal {
    plan(settings, &usual(), &scene(parts), &view(), capabilities, size).unwrap_err()
}

fn fits(settings: &Settings, parts: u64, capabilities: &Capabilities, size: [u32; 2]) -> bool {
    plan(settings, &usual(), &scene(parts), &view(), capabilities, size).is_ok()
}

#[test]
fn images_too_large_or_empty_are_refused() {
    let (settings, adapter) = (Settings::default(), adapter());
    let e = refusal(&settings, 9, &adapter, [9000, 100]);
    assert_eq!(e, Refusal::ImageTooLarge { width: 9000, height: 100, limit: 8192 });
    assert!(e.to_string().contains("9000x100") && e.to_string().contains("8192x8192"), "{e}");
    assert!(fits(&settings, 9, &adapter, [4000, 1000]));
    for size in [[0, 5], [5, 0]] {
        let e = refusal(&settings, 9, &adapter, size);
        assert!(e.to_string().contains(&format!("{}x{}", size[0], size[1])) && e.to_string().contains("at least 1"));
    }
}

#[test]
fn what_cannot_be_read_back_is_refused_with_a_height_that_fits() {
    let (settings, adapter) = (Settings::default(), adapter());
    let e = refusal(&settings, 9, &adapter, [8192, 8192]);
    let Refusal::ReadBackTooLarge { width: 8192, height: 8192, bytes, limit, fits: height } = e else { panic!("{e}") };
    assert_eq!((bytes, limit), (1 << 30, 256 << 20));
    assert!(e.to_string().contains(&format!("8192x{height} fits")), "{e}");
    assert!(fits(&settings, 9, &adapter, [8192, height as u32]));
    assert!(!fits(&settings, 9, &adapter, [8192, height as u32 + 1]));
}

#[test]
fn more_parts_than_a_shape_id_numbers_are_refused() {
    let mut settings = bucketed(8);
    settings.capture.bucketed_k_buffer.key = KeyFormat::Packed32;
    let e = refusal(&settings, 65_536, &adapter(), SIZE);
    assert_eq!(e, Refusal::TooManyParts { parts: 65_536 });
    for word in ["65536", "65535", "capture.bucketed_k_buffer.key = wide64"] {
        assert!(e.to_string().contains(word), "{e}");
    }
    assert!(fits(&settings, 65_535, &adapter(), SIZE));
    settings.set("capture.bucketed_k_buffer.key", "wide64").unwrap();
    assert!(fits(&settings, 65_536, &adapter(), SIZE));
}

#[test]
fn wide_keys_without_64_bit_atomics_are_refused() {
    let lacking = Capabilities { atomic_min_64: false, ..adapter() };
    let e = refusal(&bucketed(8), 9, &lacking, SIZE);
    assert_eq!(e, Refusal::NoAtomics64);
    for (path, value) in [("capture.kind", "compacted"), ("capture.bucketed_k_buffer.key", "packed32")] {
        assert!(e.to_string().contains(&format!("{path} = {value}")), "{e}");
        let mut settings = bucketed(8);
        settings.set(path, value).unwrap();
        assert!(fits(&settings, 9, &lacking, SIZE));
    }
}

#[test]
fn a_row_that_exceeds_a_binding_is_refused_with_a_k_that_fits() {
    let small = Capabilities { max_binding: 1 << 20, ..adapter() };
    let e = refusal(&bucketed(64), 9, &small, [4000, 1000]);
    let Refusal::RowTooLarge { k: 64, width: 4000, limit: 0x0010_0000, fits: Some(k), .. } = e else { panic!("{e:?}") };
    assert!(e.to_string().contains("k = 64 at a width of 4000"), "{e}");
    assert!(e.to_string().contains(&format!("k = {k} fits")), "{e}");
    assert!(fits(&bucketed(k), 9, &small, [4000, 1000]));
    assert!(!fits(&bucketed(k + 1), 9, &small, [4000, 1000]));

    // A low image has fewer rows than the apron, and they are all that it needs.
    let e = refusal(&bucketed(64), 9, &small, [8000, 3]);
    let Refusal::RowTooLarge { rows: 3, fits: Some(k), .. } = e else { panic!("{e:?}") };
    assert!(fits(&bucketed(k), 9, &small, [8000, 3]) && !fits(&bucketed(k + 1), 9, &small, [8000, 3]));

    let tiny = Capabilities { max_binding: 1 << 12, ..adapter() };
    let e = refusal(&bucketed(64), 9, &tiny, [4000, 1000]);
    assert!(matches!(e, Refusal::RowTooLarge { fits: None, .. }), "{e:?}");
    assert!(e.to_string().contains("a smaller image or curvature radius is needed"), "{e}");
}

#[test]
fn a_pixel_table_that_exceeds_a_binding_is_refused_with_a_width_that_fits() {
    let small = Capabilities { max_binding: 1 << 15, ..adapter() };
    let e = refusal(&Settings::default(), 9, &small, [4000, 1000]);
    let Refusal::TableTooLarge { width: 4000, limit: 0x8000, fits: width, .. } = e else { panic!("{e:?}") };
    assert!(e.to_string().contains(&format!("A width of {width} fits")), "{e}");
    assert!(fits(&Settings::default(), 9, &small, [width, 1000]));
    let plan = plan(&Settings::default(), &usual(), &scene(9), &view(), &small, [width, 1000]).unwrap();
    assert!(plan.most_rows > 2 * plan.apron);
}

#[test]
fn too_few_bindings_are_refused() {
    let few = |n| Capabilities { max_storage_buffers: n, ..adapter() };
    let e = refusal(&bucketed(8), 9, &few(9), SIZE);
    assert_eq!(e.to_string(), "a pass binds 10 storage buffers; this adapter allows 9 in one stage");
    let mut tail = bucketed(8);
    tail.capture.bucketed_k_buffer.tail = Tail::Average;
    let e = refusal(&tail, 9, &few(10), SIZE);
    assert!(e.to_string().contains("binds 11") && e.to_string().contains("tail = none needs 10"), "{e}");
    tail.set("capture.bucketed_k_buffer.tail", "none").unwrap();
    assert!(fits(&tail, 9, &few(10), SIZE));
}

#[test]
fn looks_of_parts_are_planned_where_there_are_any() {
    let opaque = Settings::from_pairs("opacity.model=opaque").unwrap();
    let plan_of =
        |settings: &Settings, stats: &SceneStats| plan(settings, &usual(), stats, &view(), &adapter(), SIZE).unwrap();
    let plain = plan_of(&opaque, &scene(20));
    assert_eq!((plain.capture, plain.faded, plain.recolored), (Capture::None, false, false));
    assert_eq!(skipped(&plain, "outline"), "nothing is selected");
    // What is opaque all the same stays so.
    for stats in [SceneStats { recolored_parts: 1, ..scene(20) }, SceneStats { solid_parts: 2, ..scene(20) }] {
        let plan = plan_of(&opaque, &stats);
        assert_eq!((plan.capture, plan.faded), (Capture::None, false), "{plan}");
    }
    let faded = SceneStats { faded_parts: 3, ..scene(20) };
    let reason = |settings: &Settings, pass: Pass| {
        let plan = plan_of(settings, &faded);
        assert!(plan.faded, "{plan}");
        plan.passes.into_iter().find(|p| p.pass == pass).map(|p| p.reason).unwrap_or_default()
    };
    assert_eq!(reason(&opaque, Pass::Count), "3 parts are ghosted or translucent: every layer is kept");
    assert_eq!(reason(&Settings::default(), Pass::Count), "layers are transparent: every layer is kept");
    let by_part = "the layers of each pixel over each other, by the opacity of their parts";
    assert_eq!(reason(&bucketed(4), Pass::Blend), by_part);
    // No column is there only for that.
    assert_eq!(plan_of(&bucketed(4), &faded).columns(), plan_of(&bucketed(4), &scene(20)).columns());

    let selected = plan_of(&opaque, &SceneStats { selected_parts: 1, ..scene(20) });
    assert!(selected.to_string().contains("1 part is outlined through what is in front"), "{selected}");
    assert!(selected.runs(Pass::Outline) && names(&selected).contains(&"outline_mask"));

    let mut tail = bucketed(8);
    tail.capture.bucketed_k_buffer.tail = Tail::Average;
    let few = Capabilities { max_storage_buffers: 11, ..adapter() };
    assert!(fits(&tail, 9, &few, SIZE));
    let e = plan(&tail, &usual(), &faded, &view(), &few, SIZE).unwrap_err();
    assert_eq!(e, Refusal::TooFewBindings { needed: 12, limit: 11, without_tail: Some(10) });
}

#[test]
fn picking_plans_a_row_its_apron_and_no_picture() {
    for settings in ["", "opacity.model=opaque image.samples=9", "capture.kind=bucketed_k_buffer"] {
        let settings = Settings::from_pairs(settings).unwrap();
        for (row, first, end) in [(0, 0, 1), (240, 240, 241), (479, 479, 480)] {
            let stats = SceneStats { selected_parts: 1, ..scene(20) };
            let plan = plan_pick(&settings, &usual(), &stats, &view(), &adapter(), SIZE, row).unwrap();
            assert!(plan.runs(Pass::Curvature) && plan.runs(Pass::Shade) && plan.capture != Capture::None, "{plan}");
            assert!(![Pass::Blend, Pass::Outline, Pass::OutlineMask, Pass::Accumulate].iter().any(|&p| plan.runs(p)));
            let [band] = plan.bands[..] else { panic!("{plan}") };
            assert_eq!((band.first_output_row, band.end_output_row), (first, end));
            assert_eq!((band.first_row, band.end_row), (row.saturating_sub(plan.apron), (end + plan.apron).min(480)));
            let table = plan.buffers.iter().find(|b| b.name == "pixel_table").unwrap();
            assert!(table.bytes <= 4 * (640 * (1 + 2 * u64::from(plan.apron)) + 1), "{table:?}");
            assert!(!names(&plan).contains(&"image"));
        }
    }
}

#[test]
fn no_buffer_has_more_words_than_32_bits_number() {
    let endless = Capabilities { max_binding: u64::MAX, max_buffer: u64::MAX, max_texture: 1 << 15, ..adapter() };
    let plan = plan(&bucketed(64), &usual(), &scene(9), &view(), &endless, [1 << 15, 1 << 15]).unwrap();
    assert!(plan.bands.len() > 1);
    for buffer in plan.buffers.iter().filter(|b| b.name != "image") {
        assert!(buffer.bytes <= 4 << 32, "{buffer:?}");
    }
}

#[test]
fn the_report_names_passes_reasons_bytes_and_bands() {
    let plan = planned(&Settings::default(), &usual());
    let text = plan.to_string();
    for p in &plan.passes {
        assert!(text.contains(p.pass.name()) && text.contains(&p.reason), "{text}");
    }
    for s in &plan.skipped {
        assert!(text.contains(s.what) && text.contains(&s.reason), "{text}");
    }
    assert!(text.contains("640x480, 1 sample\n") && text.contains("estimate") && text.contains("total"));
    let json = serde_json::to_value(&plan).unwrap();
    assert_eq!(json["passes"].as_array().unwrap().len(), plan.passes.len());
}

/// Every row is written once, captured with its apron.
fn check_bands(plan: &FramePlan) {
    let height = plan.size[1];
    assert_eq!(plan.bands[0].first_output_row, 0);
    assert_eq!(plan.bands.last().unwrap().end_output_row, height);
    for pair in plan.bands.windows(2) {
        assert_eq!(pair[0].end_output_row, pair[1].first_output_row);
    }
    for b in &plan.bands {
        assert!(b.first_output_row < b.end_output_row, "{b:?}");
        let apron = if plan.bands.len() == 1 { 0 } else { plan.apron };
        assert_eq!(b.first_row, b.first_output_row.saturating_sub(apron));
        assert_eq!(b.end_row, (b.end_output_row + apron).min(height));
    }
}

/// Settings with every choice and number drawn from its declared range.
fn any_settings() -> impl Strategy<Value = Settings> {
    let strategies: Vec<BoxedStrategy<(String, toml::Value)>> = Settings::declarations()
        .into_iter()
        .filter_map(|d| {
            use crate::settings::Range;
            let value = match d.range {
                Range::Integer(a, b) => (a..=b).prop_map(toml::Value::Integer).boxed(),
                Range::Real(a, b) => (a..=b).prop_map(toml::Value::Float).boxed(),
                Range::Choice(names) => prop::sample::select(names).prop_map(|n| n.to_owned().into()).boxed(),
                Range::Switch => any::<bool>().prop_map(toml::Value::Boolean).boxed(),
                Range::Text | Range::Color { .. } => return None,
            };
            Some(value.prop_map(move |v| (d.path.clone(), v)).boxed())
        })
        .collect();
    strategies.prop_map(|values| {
        let mut table = toml::Table::new();
        for (path, value) in values {
            let (group, name) = path.rsplit_once('.').unwrap();
            let mut at = &mut table;
            for key in group.split('.') {
                at = at.entry(key).or_insert_with(|| toml::Table::new().into()).as_table_mut().unwrap();
            }
            at.insert(name.to_owned(), value);
        }
        let mut settings = Settings::default();
        settings.merge(&table).unwrap();
        settings
    })
}

fn any_adapter() -> impl Strategy<Value = Capabilities> {
    (16_u32..34, 24_u32..34, any::<bool>(), 10_u32..14).prop_map(
        |(binding, buffer, atomic_min_64, max_storage_buffers)| {
            let (max_binding, max_buffer) = (1_u64 << binding, 1_u64 << buffer);
            Capabilities {
                max_binding,
                max_buffer,
                max_texture: 8192,
                max_storage_buffers,
                atomic_min_64,
                most_layers: 65_533,
            }
        },
    )
}

fn order_of(pass: Pass) -> usize {
    Pass::ALL.iter().position(|p| *p == pass).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_plan_is_in_order_within_limits_and_covers_the_image(
        settings in any_settings(),
        capabilities in any_adapter(),
        parts in prop::sample::select(vec![0_u64, 1, 2, 300, 65_536]),
        blended_materials in 0_u64..2,
        width in 1_u32..5000,
        height in 1_u32..5000,
        fragments in prop::option::of(0_u64..1 << 32),
        varies in any::<bool>(),
        looks in prop::array::uniform4(0_u64..2),
    ) {
        let transfer = if varies { usual() } else { TransferFunction::uniform(0.5) };
        let [faded_parts, solid_parts, recolored_parts, selected_parts] = looks;
        let stats = SceneStats {
            blended_materials,
            faded_parts,
            solid_parts,
            recolored_parts,
            selected_parts,
            ..scene(parts)
        };
        let view = ViewStats { fragments, ..view() };
        let plan = match plan(&settings, &transfer, &stats, &view, &capabilities, [width, height]) {
            Ok(plan) => plan,
            // A refusal says what was asked; what would fit is tested one by one above.
            Err(refusal) => {
                prop_assert!(!refusal.to_string().is_empty());
                return Ok(());
            }
        };
        // Slots that are found by depth are filled before there are buckets.
        let by_depth = !plan.runs(Pass::PartLookup);
        let order = |pass: Pass| match pass {
            Pass::DataStorage if by_depth => order_of(Pass::CountLayers),
            _ => order_of(pass),
        };
        prop_assert!(plan.passes.windows(2).all(|p| order(p[0].pass) <= order(p[1].pass)), "{plan}");
        prop_assert!(Pass::ALL.iter().all(|pass| plan.passes.iter().filter(|p| p.pass == *pass).count() <= 1), "{plan}");
        prop_assert!(plan.passes.iter().all(|p| !p.reason.is_empty()));
        prop_assert!(plan.skipped.iter().all(|s| !s.reason.is_empty()));
        let mut unique = names(&plan);
        unique.sort_unstable();
        unique.dedup();
        prop_assert_eq!(unique.len(), plan.buffers.len(), "a buffer is planned twice");
        prop_assert_eq!(plan.features.is_some_and(|f| f.curvature), plan.runs(Pass::Curvature));
        prop_assert_eq!(plan.capture == Capture::None, plan.runs(Pass::Opaque));
        check_bands(&plan);
        // Textures are no bindings; everything else is. A compacted store's columns are cut to what was counted.
        for buffer in &plan.buffers {
            let texture = ["image", "sums", "opaque_colors", "opaque_depth", "outline_mask"].contains(&buffer.name);
            prop_assert!(texture || buffer.bytes <= capabilities.max_binding.min(capabilities.max_buffer), "{buffer:?}");
        }
        if plan.capture.is_whole() {
            prop_assert!(plan.most_rows >= (2 * plan.apron + 1).min(height));
        }
        for (column, bytes) in plan.columns() {
            prop_assert!(names(&plan).contains(&column) && (4..=16).contains(&bytes));
        }
    }
}
