//! What a plan's layers go through: capture, features, opacity, composition, each with its reason.

use super::{Capabilities, Capture, Features, Illustration, Opacity, Pass, PlannedPass, Refusal, Skipped, ViewStats};
use crate::scene::SceneStats;
use crate::settings::{
    CaptureKind, CurvatureUnit, DepthTerm, KeyFormat, ListSort, NeighbourSearch, OpacityModel, Settings, SlotSearch,
    Tail,
};

/// Section planes belong to the passes that draw geometry: the first of them says so.
pub(super) fn plan_sections(draft: &mut Draft, scene: &SceneStats) {
    let (planes, caps) = match (scene.section_planes, scene.caps) {
        (0, _) => return draft.skip("sections", "no plane cuts the scene"),
        (1, caps) => ("1 plane cuts the scene".to_owned(), caps),
        (n, caps) => (format!("{n} planes cut the scene"), caps),
    };
    let drawn = [Pass::Opaque, Pass::ZInsertion, Pass::Count, Pass::Fill];
    if let Some(first) = draft.passes.iter_mut().find(|p| drawn.contains(&p.pass)) {
        let closed = match caps {
            0 => String::new(),
            1 => ", 1 cap closes it".to_owned(),
            n => format!(", {n} caps close it"),
        };
        first.reason += &format!("; sections: {planes}{closed}");
    }
}

/// "1 part is", "3 parts are".
pub(super) fn counted(parts: u64, one: &str, more: &str) -> String {
    if parts == 1 { format!("1 part {one}") } else { format!("{parts} parts {more}") }
}

/// The passes of a plan so far.
#[derive(Default)]
pub(super) struct Draft {
    pub(super) passes: Vec<PlannedPass>,
    pub(super) skipped: Vec<Skipped>,
}

impl Draft {
    pub(super) fn run(&mut self, pass: Pass, reason: impl Into<String>) {
        self.passes.push(PlannedPass { pass, reason: reason.into() });
    }

    pub(super) fn skip(&mut self, what: &'static str, reason: impl Into<String>) {
        self.skipped.push(Skipped { what, reason: reason.into() });
    }
}

pub(super) fn choose_capture(
    settings: &Settings,
    scene: &SceneStats,
    capabilities: &Capabilities,
    picked: bool,
) -> Result<Capture, Refusal> {
    match settings.capture.kind {
        CaptureKind::Compacted => Ok(Capture::Compacted),
        // The same store, and one pixel needs no lists.
        CaptureKind::LinkedList if picked => Ok(Capture::Compacted),
        CaptureKind::LinkedList => {
            let s = &settings.capture.linked_list;
            Ok(Capture::LinkedList { sort: s.sort, capacity: s.capacity, memory: u64::from(s.memory) << 20 })
        }
        CaptureKind::BucketedKBuffer => {
            let s = &settings.capture.bucketed_k_buffer;
            match s.key {
                // Shape id 65535 with depth 65535 would be the empty slot; depth stops at 65534, so every id is legal.
                KeyFormat::Packed32 if scene.parts > 65_535 => Err(Refusal::TooManyParts { parts: scene.parts }),
                KeyFormat::Wide64 if !capabilities.atomic_min_64 => Err(Refusal::NoAtomics64),
                key => Ok(Capture::BucketedKBuffer {
                    k: s.k,
                    key,
                    depth: s.depth,
                    tail: s.tail == Tail::Average,
                    slot_search: s.slot_search,
                }),
            }
        }
    }
}

pub(super) fn choose_features(
    settings: &Settings,
    scene: &SceneStats,
    view: &ViewStats,
    size: [u32; 2],
    curvature: bool,
    draft: &mut Draft,
) -> Features {
    let c = &settings.features.curvature;
    let shorter = f64::from(size[0].min(size[1]));
    let radius = (c.radius * shorter).round().max(1.0) as u32;
    let line = (c.line_width * shorter).max(1.0);
    let by_buckets = settings.features.neighbours == NeighbourSearch::Buckets;
    let depth_term = match settings.features.depth_term {
        DepthTerm::Parameters if scene.parametrized_parts == 0 => {
            draft.skip("parametrize", "no part has a parametrization: neighbours are found by continuity");
            DepthTerm::Continuity
        }
        term => term,
    };
    let search = if by_buckets && depth_term == DepthTerm::Parameters {
        draft.skip("buckets", "depth bounds no distance in parameters: every layer has to be looked at");
        NeighbourSearch::BruteForce
    } else if by_buckets && depth_term == DepthTerm::ContinuityPrinted {
        draft.skip("buckets", "a signed difference of depth bounds nothing: every layer has to be looked at");
        NeighbourSearch::BruteForce
    } else if by_buckets && !settings.features.reverse_check {
        draft.skip("buckets", "features.reverse_check is off: the search by buckets includes it");
        NeighbourSearch::BruteForce
    } else {
        settings.features.neighbours
    };
    let (unit, scale_by_part) = match c.unit {
        CurvatureUnit::View => (view.visible_height, false),
        CurvatureUnit::Scene => (scene.radius(), false),
        CurvatureUnit::World => (1.0, false),
        CurvatureUnit::Part => (1.0, true),
    };
    Features {
        curvature,
        search,
        depth_term,
        reverse_check: settings.features.reverse_check,
        radius,
        reach: if curvature { radius.max(line.ceil() as u32) } else { 1 },
        line,
        scale: c.scale * unit,
        scale_by_part,
    }
}

pub(super) fn plan_layers(
    draft: &mut Draft,
    settings: &Settings,
    scene: &SceneStats,
    capture: Capture,
    (features, opacity, illustration): (Option<Features>, Opacity, Option<Illustration>),
) {
    let otherwise_opaque = opacity == (Opacity::Constant { alpha: 1.0 });
    let transparent = match (scene.blended_materials, scene.faded_parts) {
        (1, _) if otherwise_opaque => "1 material blends".to_owned(),
        (n @ 2.., _) if otherwise_opaque => format!("{n} materials blend"),
        (_, n @ 1..) if otherwise_opaque => format!("{} ghosted or translucent", counted(n, "is", "are")),
        _ if otherwise_opaque => "layers are read back".to_owned(),
        _ => "layers are transparent".to_owned(),
    };
    let buckets = features.is_some_and(|f| f.search == NeighbourSearch::Buckets);
    let bucket_passes = |draft: &mut Draft| {
        draft.run(Pass::ZReordering, "buckets group a pixel's layers by part");
        draft.run(Pass::BucketCreation, "searches read only the bucket of the same part");
    };
    match capture {
        Capture::None => {}
        Capture::BucketedKBuffer { k, slot_search, .. } => {
            draft.run(Pass::Clear, "the rows hold the last frame");
            draft.run(Pass::ZInsertion, format!("{transparent}: the {k} nearest of each pixel are kept"));
            draft.run(Pass::CountLayers, "what was stored, merged and dropped is reported");
            let by_bucket = slot_search == SlotSearch::Bucket;
            if !by_bucket {
                draft.run(Pass::DataStorage, "the surfaces of the stored keys, found by depth");
            }
            if by_bucket {
                draft.run(Pass::PartLookup, "buckets group layers by part");
            }
            if buckets || by_bucket {
                bucket_passes(draft);
            } else {
                draft.skip("z reordering, bucket creation", "nothing searches by part");
            }
            if by_bucket {
                draft.run(Pass::DataStorage, "the surfaces of the stored keys, found by bucket and depth");
            }
        }
        Capture::Compacted => {
            draft.run(Pass::Count, format!("{transparent}: every layer is kept"));
            draft.run(Pass::PrefixSum, "where each pixel's layers begin");
            draft.run(Pass::Append, "keys and surfaces as they come");
            draft.run(Pass::Sort, "by depth, then by triangle number");
            draft.run(Pass::Gather, "surfaces in the order of the sort");
        }
        Capture::LinkedList { sort, .. } => {
            draft.run(Pass::Fill, format!("{transparent}: every layer is kept, in a linked list a pixel"));
            draft.run(Pass::PrefixSum, "where each pixel's layers begin");
            draft.run(
                Pass::Sort,
                match sort {
                    ListSort::ByLength => "by depth, then by triangle number, by a network for the list's length",
                    ListSort::Selection => {
                        "by depth, then by triangle number, by selection (Carnecky 2013, section 4.3)"
                    }
                },
            );
            draft.run(Pass::Gather, "surfaces in the order of the sort");
        }
    }
    if capture.is_whole() {
        if features.is_some() {
            draft.run(Pass::PartLookup, "neighbours belong to the same part");
        }
        if buckets {
            bucket_passes(draft);
        } else {
            draft.skip("z reordering, bucket creation", "nothing searches by part");
        }
    }
    if features.is_some_and(|f| f.depth_term == DepthTerm::Parameters) {
        let without = match scene.parts - scene.parametrized_parts.min(scene.parts) {
            0 => String::new(),
            n => format!("; {} measured by continuity", counted(n, "without a parametrization is", "without one are")),
        };
        draft.run(Pass::Parametrize, format!("neighbours are near in the surface's parametrization{without}"));
    }
    let wants_neighbours = match opacity {
        _ if features.is_some_and(|f| f.curvature) => "curvature needs neighbours",
        Opacity::NormalVariation => "how fast normals turn is seen between neighbours",
        _ => "silhouettes are where neighbours are missing, and fields spread from neighbour to neighbour",
    };
    if let Some(f) = features {
        let check = match f.depth_term {
            DepthTerm::ContinuityPrinted => "no other layer may suit the neighbour better (Carnecky 2013, Algorithm 2)",
            _ => "a neighbour must see the layer as its own (Murray 2016, Figure 5)",
        };
        if f.search == NeighbourSearch::Buckets {
            draft.run(Pass::NeighbourLinks, format!("{wants_neighbours}; {check}"));
        } else {
            draft.run(Pass::NeighbourCandidates, wants_neighbours);
            if f.reverse_check {
                draft.run(Pass::NeighbourLinks, check);
            } else {
                draft.skip("neighbour links", "features.reverse_check is off");
            }
        }
        if scene.section_planes > 0 {
            draft.run(Pass::CutLinks, "a cut is unknown to features, not a silhouette (T10)");
        }
        if f.curvature {
            draft.run(Pass::Curvature, "a transfer function varies with curvature");
        } else {
            draft.skip("curvature", "opacity does not depend on curvature");
        }
    } else {
        draft.skip(
            "neighbours, curvature",
            match settings.opacity.model {
                OpacityModel::Curvature => "no transfer function varies with curvature",
                OpacityModel::Constant => "opacity is constant",
                OpacityModel::Adaptive => "opacity depends on the number of layers alone",
                OpacityModel::EqualShare => "opacity depends on the numbers of layers alone",
                OpacityModel::AngleBased => "opacity depends on each layer's own angle",
                OpacityModel::Opaque | OpacityModel::NormalVariation | OpacityModel::Illustrative => {
                    "opacity does not depend on curvature"
                }
            },
        );
    }
    draft.run(Pass::Shade, "every stored layer is lit once");
    match opacity {
        Opacity::Curvature => draft.run(Pass::Stylize, "colour and opacity follow curvature and depth"),
        Opacity::Depth => draft.run(Pass::Stylize, "opacity follows depth"),
        Opacity::Constant { .. } => draft.skip("stylize", "opacity is the same for all layers"),
        Opacity::Adaptive { .. } => draft.run(Pass::Stylize, "opacity follows the number of layers"),
        Opacity::AngleBased => draft.run(Pass::Stylize, "opacity follows the angle to the sight line"),
        Opacity::NormalVariation => draft.run(Pass::Stylize, "opacity follows how fast normals turn"),
        Opacity::EqualShare => {
            draft.run(Pass::LayerHistogram, "opacity depends on how many layers all pixels have");
            draft.run(Pass::Stylize, "opacity follows the layer index");
        }
    }
    match illustration {
        None => draft.skip("boundary, diffuse, illustrate", "opacity does not spread from silhouettes"),
        Some(i) => {
            draft.run(Pass::Boundary, "silhouettes are opaque, and clear behind");
            match i.feature_size {
                _ if i.most_steps == 0 => {}
                0 => draft.skip("feature size", "diffusion is isotropic"),
                n => draft
                    .run(Pass::FeatureSize, format!("silhouettes and halos narrow on what is smaller than {n} pixels")),
            }
            match (i.most_steps, i.heat_steps) {
                (0, _) => draft.skip("diffuse", "no field spreads"),
                (most, heat) if most > heat => {
                    draft.run(Pass::Diffuse, format!("{heat} steps, and up to {most} until nothing changes"));
                }
                (most, _) => draft.run(Pass::Diffuse, format!("{most} steps")),
            }
            draft.run(Pass::Illustrate, "opacity out of base, silhouettes and halos");
        }
    }
    let of_parts = match scene.faded_parts + scene.solid_parts {
        0 => "",
        _ => ", by the opacity of their parts",
    };
    draft.run(Pass::Blend, format!("the layers of each pixel over each other{of_parts}"));
}
