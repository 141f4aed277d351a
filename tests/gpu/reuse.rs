//! Frames that begin with the layers of the one before are those that are drawn from nothing, bit for bit.

use pellucid::math::Camera;
use pellucid::plan::Pass;
use pellucid::render::{Frame, Kept, Renderer};
use pellucid::scene::{Arrangement, PartLook, Presence, Scene, Section, builtin};
use pellucid::settings::Settings;
use pellucid::transfer::TransferFunction;

use crate::common::*;

const SIZE: [u32; 2] = [64, 48];

/// One state of what is seen.
#[derive(Clone)]
struct Seen {
    pairs: String,
    transfer: TransferFunction,
    arrangement: Arrangement,
    camera: Camera,
    size: [u32; 2],
}

fn draw_seen(r: &mut Renderer, scene: &Scene, loaded: &mut pellucid::render::GpuScene, seen: &Seen) -> Frame {
    r.arrange(loaded, scene, &seen.arrangement).expect("an arrangement");
    let settings: Settings = with_transfer(settings(&seen.pairs), seen.transfer.clone());
    r.render_with(loaded, &seen.camera, &settings, &seen.transfer, seen.size).expect("a frame")
}

#[test]
fn what_is_kept_changes_no_bit() {
    let Some(mut plain) = renderer() else { return };
    let mut keeping = Renderer::new(plain.gpu().clone()).expect("a renderer");
    keeping.keeps_layers = true;
    let scene = builtin::build("hard/assembly?seed=3").expect("a scene");
    let bounds = scene.bounds();
    for capture in [
        "kind=bkb k=12",
        "kind=bkb k=6 capture.bucketed_k_buffer.slot_search=bucket",
        "kind=compacted",
        "kind=linked_list",
    ] {
        let mut loaded = [plain.load(&scene).expect("a scene"), keeping.load(&scene).expect("a scene")];
        let first = Seen {
            pairs: format!("{capture} radius=0.02"),
            transfer: lively(),
            arrangement: Arrangement::default(),
            camera: camera(&scene, false),
            size: SIZE,
        };
        let other = transfer(
            "[color]\nmode = \"tint\"\npoints = [{ kappa = -1.0, color = 0.2 }, { kappa = 1.0, color = [0.9, 0.2, 0.3] }]\n\
             [opacity]\ncurves = [{ depth = 0.0, points = [[0.0, 0.8], [0.5, 0.2], [1.0, 0.7]] }]\n",
        );
        let with_parts = |look: PartLook, base: &Seen| {
            let mut seen = base.clone();
            seen.arrangement.parts.insert(1, look);
            seen
        };
        let add = |pairs: &str, base: &Seen| Seen { pairs: format!("{} {pairs}", base.pairs), ..base.clone() };
        let mut selected = first.clone();
        selected.arrangement.selected.insert(0);
        let hidden = with_parts(PartLook { presence: Presence::Hidden, ..PartLook::default() }, &first);
        let ghosted = with_parts(PartLook { presence: Presence::Ghosted, ..PartLook::default() }, &first);
        let fainter = with_parts(PartLook { opacity: 0.3, ..PartLook::default() }, &ghosted);
        let red = with_parts(PartLook { color: Some([1.0, 0.0, 0.0]), ..PartLook::default() }, &first);
        let mut cut = first.clone();
        cut.arrangement.sections.push(Section {
            normal: glam::DVec3::X,
            offset: bounds.center().x + scene.origin.x,
            enabled: true,
            caps: true,
        });
        let mut exploded = first.clone();
        exploded.arrangement.explode = 0.4;
        let steps: Vec<(&str, Seen, Kept)> = vec![
            ("from nothing", first.clone(), Kept::Nothing),
            ("again", first.clone(), Kept::Features),
            ("another transfer function", Seen { transfer: other, ..first.clone() }, Kept::Features),
            ("more opaque", add("gain=1.7", &first), Kept::Features),
            ("other light", add("light.exposure=0.6", &first), Kept::Features),
            ("selected", selected, Kept::Features),
            ("another curvature", add("curvature=view_centred", &first), Kept::Layers),
            ("a wider regression", add("radius=0.05", &first), Kept::Layers),
            ("back", first.clone(), Kept::Layers),
            ("turned", Seen { camera: first.camera.azimuth(7.0), ..first.clone() }, Kept::Nothing),
            ("larger", Seen { size: [70, 48], ..first.clone() }, Kept::Nothing),
            ("hidden", hidden, Kept::Nothing),
            ("ghosted", ghosted, Kept::Nothing),
            ("fainter", fainter, Kept::Features),
            ("red", red, Kept::Nothing),
            ("cut", cut, Kept::Nothing),
            ("exploded", exploded, Kept::Nothing),
            ("constant", add("model=constant", &first), Kept::Nothing),
            ("illustrative", add("model=illustrative", &first), Kept::Nothing),
            ("narrower halos", add("model=illustrative opacity.illustrative.iterations=5", &first), Kept::Features),
            ("two samples", add("image.samples=2", &first), Kept::Nothing),
            ("one again", first.clone(), Kept::Nothing),
        ];
        for (what, seen, kept) in steps {
            let [a, b] = &mut loaded;
            let expected = draw_seen(&mut plain, &scene, a, &seen);
            let frame = draw_seen(&mut keeping, &scene, b, &seen);
            assert_eq!(frame.report.kept, kept, "{capture}, {what}");
            assert_eq!(frame.image.pixels, expected.image.pixels, "{capture}, {what}");
            assert_eq!(frame.report.layers, expected.report.layers, "{capture}, {what}");
            assert_eq!(expected.report.kept, Kept::Nothing);
            let drawn = frame.report.passes.iter().filter(|p| kept.spares(p.pass)).count();
            assert_eq!(drawn, 0, "{capture}, {what}: passes that were to be spared");
        }
        // Another scene with the same view, and other shaders.
        let again = keeping.load(&scene).expect("a scene");
        let settings = with_transfer(settings(&first.pairs), lively());
        let kept = |r: &mut Renderer, scene| {
            r.render_with(scene, &first.camera, &settings, &lively(), SIZE).expect("a frame").report.kept
        };
        assert_eq!(kept(&mut keeping, &again), Kept::Nothing, "another upload");
        assert_eq!(kept(&mut keeping, &again), Kept::Features);
        keeping.replace_shader("features/nothing", None);
        assert_eq!(kept(&mut keeping, &again), Kept::Nothing, "shaders that may be others");
    }
}

/// An averaged tail weighs layers by their opacity, so it cannot be kept; bands leave no whole store.
#[test]
fn what_leaves_no_whole_store_is_drawn_anew() {
    let Some(small) = small_renderer() else { return };
    let mut keeping = Renderer::new(small.gpu().clone()).expect("a renderer");
    keeping.keeps_layers = true;
    let scene = builtin::build("hard/assembly?seed=3").expect("a scene");
    let loaded = keeping.load(&scene).expect("a scene");
    let camera = camera(&scene, false);
    for (pairs, size) in [("kind=bkb k=4 tail=average", [24, 16]), ("kind=compacted", [128, 96])] {
        let settings = with_transfer(settings(pairs), lively());
        for _ in 0..2 {
            let frame = keeping.render_with(&loaded, &camera, &settings, &lively(), size).expect("a frame");
            assert_eq!(frame.report.kept, Kept::Nothing, "{pairs}");
            assert!(pairs.contains("tail") || frame.report.bands > 1, "{pairs}: {} bands", frame.report.bands);
            assert!(frame.report.plan.runs(Pass::Shade));
        }
    }
}
