//! The hard cases of the captures.

use glam::DVec3;

use crate::math::{Camera, Projection};
use crate::scene::hard_case::Contrast::{Planted, Printed};
use crate::scene::hard_case::Source::Builtin;
use crate::scene::hard_case::{CaseCamera, HardCase, Measure, Method};

const WIDE8: Method =
    Method::of("64-bit key", "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=8 opacity.model=constant");
const PACKED8: Method = Method::of(
    "32-bit key",
    "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=8 capture.bucketed_k_buffer.key=packed32 \
     opacity.model=constant",
);
const EXACT: Method = Method::of("compacted", "opacity.model=constant");
/// The last slot is never tried.
const INSERTION: [&str; 3] = ["passes/capture/bucketed_k_buffer/z_insertion", "i < k; i++", "i + 1u < k; i++"];

const fn one_slot_short(method: Method) -> Method {
    method.changed(INSERTION[0], INSERTION[1], INSERTION[2])
}

/// Far away and narrow, to look at the sheets 900 away.
const TELESCOPE: CaseCamera = CaseCamera::Placed(Camera {
    position: DVec3::ZERO,
    focal_point: DVec3::new(0.0, 0.0, -900.0),
    view_up: DVec3::Y,
    projection: Projection::Perspective { fov_y: 0.025 },
});
const AT_THE_SHELLS: CaseCamera = CaseCamera::Placed(Camera {
    position: DVec3::new(0.0, 0.0, 40.0),
    focal_point: DVec3::ZERO,
    view_up: DVec3::Y,
    projection: Projection::Perspective { fov_y: 0.25 },
});

const LISTS: Method = Method::of("linked lists", "capture.kind=linked_list opacity.model=constant");
const FILL: &str = "passes/capture/linked_list/fill";

/// Cases of the captures.
pub const CASES: &[HardCase] = &[
    HardCase {
        name: "t01-equal-keys",
        trap: "T1",
        why: "Two faces of one part lie in one place. As printed their keys are equal: both get a slot, but the data pass \
              finds the same one for both, so one face is lost and which one is a race. A tie-break by the instanced \
              triangle's number makes every key of a pixel distinct.",
        scene: Builtin("builtin:hard/equal-keys"),
        camera: CaseCamera::INTO,
        size: [32, 31],
        ours: WIDE8,
        contrast: Some(Printed(PACKED8)),
        measure: Measure::FragmentsLost,
        bound: 0.0,
    },
    HardCase {
        name: "t02-close-sheets",
        trap: "T2",
        why: "Two tilted sheets of one part are 1e-5 of the scene's depth range apart. With 16 bits of depth they share a \
              key in a third of the pixels, and one of the two fragments is lost there.",
        scene: Builtin("builtin:hard/close-sheets?gap=1e-5"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [96, 96],
        ours: WIDE8,
        contrast: Some(Printed(PACKED8)),
        measure: Measure::FragmentsLost,
        bound: 0.0,
    },
    HardCase {
        name: "t02-closer-sheets",
        trap: "T2",
        why: "The same sheets 1e-6 of the depth range apart, which 32 bits of depth still tell apart: sixteen share a key \
              in nine pixels of ten.",
        scene: Builtin("builtin:hard/close-sheets?gap=1e-6"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [96, 96],
        ours: WIDE8,
        contrast: Some(Printed(PACKED8)),
        measure: Measure::FragmentsLost,
        bound: 0.0,
    },
    HardCase {
        name: "t02-far-sheets",
        trap: "T2",
        why: "Near 0.1, far 1000, two sheets 1 apart at depth 900. The classic z/w spends nearly all of 16 bits near the \
              eye: a step is 101 long there. Reversed depth in a 32-bit float keeps its relative precision everywhere.",
        scene: Builtin("builtin:hard/far-sheets"),
        camera: TELESCOPE,
        size: [96, 96],
        ours: WIDE8,
        contrast: Some(Printed(Method::of(
            "16 bits of z/w",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=8 capture.bucketed_k_buffer.key=packed32 \
             capture.bucketed_k_buffer.depth=z_over_w opacity.model=constant",
        ))),
        measure: Measure::FragmentsLost,
        bound: 0.0,
    },
    HardCase {
        name: "t03-two-geometry-passes",
        trap: "T3",
        why: "Data storage draws the scene a second time and finds each fragment's slot by its depth. If the two passes \
              differ in the last bit of a depth, fragments find no slot and vanish without a sign. Positions are \
              invariant, one function makes the key, and what finds no slot is counted.",
        scene: Builtin("builtin:hard/assembly?seed=31"),
        camera: CaseCamera::CORNER,
        size: [40, 40],
        ours: Method::of(
            "64-bit key",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=24 opacity.model=constant",
        ),
        contrast: Some(Planted(
            Method::of(
                "last bit of depth differs",
                "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=24 opacity.model=constant",
            )
            .changed(
                "passes/capture/bucketed_k_buffer/search_key_wide64",
                "depth_key_of(v.position))",
                "depth_key_of(v.position) ^ u32(v.position.x < 20.0))",
            ),
        )),
        measure: Measure::Unaccounted,
        bound: 0.0,
    },
    HardCase {
        name: "t04-70000-parts",
        trap: "T4",
        why: "A shape id of 16 bits numbers 65 535 parts; the next one would be taken for the first. The packed key is \
              refused here, never wrapped around, and the wide key carries the triangle's number, from which the part \
              follows.",
        scene: Builtin("builtin:hard/many-parts?parts=70000"),
        camera: CaseCamera::Framed { direction: DVec3::NEG_Z, zoom: 8.0, orthographic: false },
        size: [48, 48],
        ours: EXACT,
        contrast: Some(Printed(PACKED8)),
        measure: Measure::LayersWrong,
        bound: 0.0,
    },
    HardCase {
        name: "t05-overflow",
        trap: "T5",
        why: "Twenty layers in a pixel where four are kept: the rest vanish and the picture changes its brightness without \
              a sign. They are counted, and averaged behind the stored layers, those included that nearer fragments \
              evicted later.",
        scene: Builtin("builtin:hard/stack?layers=20&parts=4"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [32, 32],
        ours: Method::of(
            "k = 4, averaged tail",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=4 capture.bucketed_k_buffer.tail=average \
             opacity.model=constant opacity.constant=0.1",
        ),
        contrast: Some(Printed(Method::of(
            "k = 4",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=4 opacity.model=constant opacity.constant=0.1",
        ))),
        measure: Measure::PictureError,
        bound: 3.0,
    },
    HardCase {
        name: "t05-order-of-the-tail",
        trap: "T5",
        why: "Which fragments reach the tail first depends on the order of drawing. Sums of floats would depend on it too; \
              the tail adds fixed-point integers, so that the picture does not. Without that, and with keys that tie, it \
              does.",
        scene: Builtin("builtin:hard/equal-keys?layers=6&colors=1"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [32, 32],
        ours: Method::of(
            "k = 2, averaged tail",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=2 capture.bucketed_k_buffer.tail=average \
             opacity.model=constant",
        ),
        contrast: Some(Printed(Method::of(
            "32-bit key",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=2 capture.bucketed_k_buffer.key=packed32 \
             opacity.model=constant",
        ))),
        measure: Measure::OrderDependence(5),
        bound: 0.0,
    },
    HardCase {
        name: "t06-full-bucket-table",
        trap: "T6",
        why: "Eight parts whose home is the last of eight slots fill a pixel's hash table, and every probe wraps around. A \
              ninth part beside them looks for itself in tables that are full and do not have it: the search must end.",
        scene: Builtin("builtin:hard/full-buckets"),
        camera: CaseCamera::Placed(Camera {
            position: DVec3::new(0.2, 0.0, 6.0),
            focal_point: DVec3::new(0.2, 0.0, 0.0),
            view_up: DVec3::Y,
            projection: Projection::Perspective { fov_y: 0.6 },
        }),
        size: [40, 40],
        ours: Method::of("k = 8", "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=8"),
        contrast: Some(Planted(
            Method::of("probing does not wrap", "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=8")
                .changed(
                    "store/buckets",
                    "        if slot == table.slots {\n            slot = 0u;\n        }",
                    "        if slot == table.slots {\n            break;\n        }",
                ),
        )),
        measure: Measure::LinksWrong,
        bound: 0.0,
    },
    HardCase {
        name: "t27-order-of-drawing",
        trap: "T27",
        why: "The same scene with parts and triangles in another order must give the same picture bit for bit: faces in \
              one place, overflow and tail included. Keys that can tie make the last fragment win.",
        scene: Builtin("builtin:hard/equal-keys?colors=1"),
        camera: CaseCamera::FRONT,
        size: [32, 32],
        ours: WIDE8,
        contrast: Some(Printed(PACKED8)),
        measure: Measure::OrderDependence(6),
        bound: 0.0,
    },
    HardCase {
        name: "t27-order-of-parts",
        trap: "T27",
        why: "An assembly with a bit of everything, parts and triangles shuffled, in rows of four slots with an averaged \
              tail: which fragment evicts which, and when, is another story in every order, and the picture must be the \
              same. It is not if what leaves a slot is not carried on to the next.",
        scene: Builtin("builtin:hard/assembly?seed=22"),
        camera: CaseCamera::CORNER,
        size: [64, 56],
        ours: Method::of(
            "k = 4, averaged tail",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=4 capture.bucketed_k_buffer.tail=average",
        ),
        contrast: Some(Planted(
            Method::of(
                "evicted fragments are forgotten",
                "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=4 capture.bucketed_k_buffer.tail=average",
            )
            .changed("passes/capture/bucketed_k_buffer/z_insertion", "key = max(old, key);", "break;"),
        )),
        measure: Measure::OrderDependence(4),
        bound: 0.0,
    },
    HardCase {
        name: "t28-captures-agree",
        trap: "T28",
        why: "A k-buffer that is deep enough and lists of every layer are two structures for one set of fragments: each is \
              the other's oracle. All bits of the picture must agree, on smooth and flat, mirrored and touching, masked \
              and blended parts.",
        scene: Builtin("builtin:hard/assembly?seed=22"),
        camera: CaseCamera::CORNER,
        size: [64, 56],
        ours: Method::of("k = 32", "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=32"),
        contrast: Some(Printed(Method::of(
            "k = 4, 32-bit key",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=4 capture.bucketed_k_buffer.key=packed32",
        ))),
        measure: Measure::UnlikeExact,
        bound: 0.0,
    },
    HardCase {
        name: "t30-millimetres-in-a-kilometre",
        trap: "T30",
        why: "Ten shells 2 mm apart, each a part of its own, in a scene a kilometre across: one step of a linear 16-bit \
              depth is 15 mm. Shells are numbered against depth, so that every tie comes out in the wrong order.",
        scene: Builtin("builtin:hard/gaps"),
        camera: AT_THE_SHELLS,
        size: [64, 64],
        ours: Method::of(
            "64-bit key",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=12 opacity.model=constant",
        ),
        contrast: Some(Printed(Method::of(
            "32-bit key",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=12 capture.bucketed_k_buffer.key=packed32 \
             opacity.model=constant",
        ))),
        measure: Measure::OutOfOrder,
        bound: 0.0,
    },
    HardCase {
        name: "200-layers",
        trap: "",
        why: "Two hundred layers in a pixel: more than any row of slots holds, and longer lists than one sorting network. \
              Each must be there once and in its place.",
        scene: Builtin("builtin:hard/stack?layers=200&parts=5&gap=0.01&alike=1"),
        camera: CaseCamera::INTO,
        size: [24, 23],
        ours: EXACT,
        contrast: Some(Printed(Method::of(
            "k = 16",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=16 opacity.model=constant",
        ))),
        measure: Measure::FragmentsLost,
        bound: 0.0,
    },
    HardCase {
        name: "k-of-1",
        trap: "",
        why: "The smallest k: one slot, which every nearer fragment takes from the one before. What is left must be the \
              nearest layer, with the surface that belongs to it, and every other fragment counted as dropped.",
        scene: Builtin("builtin:hard/assembly?seed=24"),
        camera: CaseCamera::CORNER,
        size: [48, 48],
        ours: Method::of(
            "k = 1",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=1 opacity.model=constant",
        ),
        contrast: Some(Planted(one_slot_short(Method::of(
            "no slot",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=1 opacity.model=constant",
        )))),
        measure: Measure::LayersWrong,
        bound: 0.0,
    },
    HardCase {
        name: "k-of-64",
        trap: "",
        why: "The largest k, on pixels of seventy layers: the binary search and the chain of minima at their longest, and \
              six fragments that fall off the end.",
        scene: Builtin("builtin:hard/stack?layers=70&parts=5&gap=0.02&alike=1"),
        camera: CaseCamera::INTO,
        size: [24, 23],
        ours: Method::of(
            "k = 64",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=64 opacity.model=constant",
        ),
        contrast: Some(Planted(one_slot_short(Method::of(
            "63 slots",
            "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=64 opacity.model=constant",
        )))),
        measure: Measure::LayersWrong,
        bound: 0.0,
    },
    HardCase {
        name: "random-scenes",
        trap: "",
        why: "What nobody thought of: random scenes of one to twelve triangles of up to three parts, slivers and shared \
              edges among them, side by side in one picture. Fragments, neighbours, κ and colours must all be the \
              oracle's, but for samples that rounding may decide either way, which are counted.",
        scene: Builtin("builtin:hard/tiles"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [128, 128],
        ours: Method::of("compacted", ""),
        contrast: Some(Planted(Method::of("surfaces not gathered", "").changed(
            "passes/capture/compacted/gather",
            "let source = source_of(base, sources[base + i]);",
            "let source = base + i;",
        ))),
        measure: Measure::RandomScenes,
        bound: 0.0,
    },
    HardCase {
        name: "random-scenes-in-a-k-buffer",
        trap: "",
        why: "The same random scenes in rows of twelve slots, as many as a random scene has triangles: insertion, hashing, \
              the second geometry pass and the links over rows that are never full but often nearly.",
        scene: Builtin("builtin:hard/tiles"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [128, 128],
        ours: Method::of("k = 12", "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=12"),
        contrast: Some(Planted(
            Method::of("nothing hashed home", "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=12").changed(
                "passes/buckets/bucket_creation",
                "var index = hash_of(part, slots);",
                "var index = hash_of(part + 1u, slots);",
            ),
        )),
        measure: Measure::RandomScenes,
        bound: 0.0,
    },
    HardCase {
        name: "t17-list-overflow",
        trap: "T17",
        why: "Linked lists with room for a hundred fragments, where there are thousands. The buffer must grow to what was \
              counted and be filled again before anything is shown; a frame drawn with what found room lacks nearly all.",
        scene: Builtin("builtin:hard/stack?layers=20&gap=0.1"),
        camera: CaseCamera::INTO,
        size: [32, 31],
        ours: Method::of("grown", "capture.kind=linked_list opacity.model=constant capture.linked_list.capacity=100"),
        contrast: Some(Planted(
            Method::of("what found room", "capture.kind=linked_list opacity.model=constant").changed(
                FILL,
                "place < store_layout.capacity",
                "place < 100u",
            ),
        )),
        measure: Measure::FragmentsLost,
        bound: 0.0,
    },
    HardCase {
        name: "t17-list-with-a-cycle",
        trap: "T17",
        why: "A list whose end leads back into it must not hold up the device: whoever walks it takes as many steps as the \
              pixel has fragments, and what is then not at its end is counted as lost.",
        scene: Builtin("builtin:hard/stack?layers=20&gap=0.1"),
        camera: CaseCamera::INTO,
        size: [32, 31],
        ours: LISTS,
        contrast: Some(Planted(LISTS.changed(
            FILL,
            "list_next[place] = atomicExchange(&list_heads[pixel], place + 1u);",
            "list_next[place] = max(atomicExchange(&list_heads[pixel], place + 1u), place + 1u);",
        ))),
        measure: Measure::Unaccounted,
        bound: 0.0,
    },
    HardCase {
        name: "t17-long-lists",
        trap: "T17",
        why: "Lists of 300 fragments, far longer than any sorting network, must come out in the same order as in every other \
              capture, or surfaces change places in deep assemblies.",
        scene: Builtin("builtin:hard/stack?layers=300&gap=0.01"),
        camera: CaseCamera::INTO,
        size: [24, 23],
        ours: LISTS,
        contrast: Some(Planted(LISTS.changed("passes/sort/long_lists", "end > 0u; end--", "end > 1u; end--"))),
        measure: Measure::UnlikeExact,
        bound: 0.0,
    },
    HardCase {
        name: "t19-equal-depths",
        trap: "T19",
        why: "Sixteen faces of different colours in one place, in linked lists: fragments arrive in any order, so equal depths \
              need one of their own, the triangle's number, or the picture depends on the order of drawing.",
        scene: Builtin("builtin:hard/equal-keys?colors=1&layers=16"),
        camera: CaseCamera::INTO,
        size: [32, 31],
        ours: LISTS,
        contrast: Some(Planted(LISTS.changed(
            "passes/sort/elements_collected",
            "a.x < b.x || (a.x == b.x && a.y < b.y)",
            "a.x < b.x",
        ))),
        measure: Measure::OrderDependence(3),
        bound: 0.0,
    },
];
