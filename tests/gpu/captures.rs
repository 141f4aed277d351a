//! Ways that must lead to the same bits: two captures, any draw order, two neighbour searches, any k that is enough, bands,
//! another unit of length, another part far away, effects left out or not (T28 and its kin).

use glam::{DMat4, DVec3};
use pellucid::math::{Camera, Projection};
use pellucid::plan::{Capture, Opacity, Pass};
use pellucid::render::{DrawOrder, Renderer};
use pellucid::scene::{AlphaMode, Mesh, Node, Scene};
use pellucid::settings::Settings;

use crate::common::*;
use crate::meshes;

const SIZE: [u32; 2] = [64, 56];

fn lively_settings(pairs: &str) -> Settings {
    with_transfer(settings(pairs), lively())
}

/// Scenes and cameras that the comparisons run over.
fn views() -> Vec<(String, Scene, Camera)> {
    let mut all = Vec::new();
    for seed in if full() { 21..27 } else { 21..23 } {
        let orthographic = seed % 2 == 0;
        let scene = if seed % 3 == 0 { meshes::soups(seed, 9, 14) } else { meshes::assembly(seed) };
        let camera = camera(&scene, orthographic);
        all.push((format!("scene {seed}"), scene, camera));
    }
    all
}

fn deepest(r: &mut Renderer, scene: &Scene, camera: &Camera, size: [u32; 2]) -> u64 {
    draw(r, scene, camera, &settings("model=constant"), size).frame.report.layers.deepest
}

#[test]
fn t28_the_k_buffer_with_enough_layers_equals_the_compacted_lists() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        let k = deepest(&mut r, &scene, &camera, SIZE);
        println!("{name}: {k} layers at most");
        let look = "curvature=view_centred radius=0.03 normals=xy15";
        for model in ["", "model=constant constant=0.37", look, "normals=full"] {
            let exact = draw(&mut r, &scene, &camera, &lively_settings(model), SIZE);
            assert!(exact.store.layers.len() > 2000);
            for k in [k, 2 * k] {
                let row = format!("{model} kind=bkb k={k}");
                let rows = draw(&mut r, &scene, &camera, &lively_settings(&row), SIZE);
                exact.assert_same(&rows, &format!("{name}, {row}"));
                assert_eq!(rows.frame.report.layers, exact.frame.report.layers, "{name}: the books");
            }
        }
    }
}

#[test]
fn where_a_pixel_is_deeper_than_k_the_first_k_are_equal() {
    let Some(mut r) = renderer() else { return };
    let check = |r: &mut Renderer, scene: &Scene, camera: &Camera, k: usize, size: [u32; 2]| {
        let all = draw(r, scene, camera, &settings("model=constant"), size).store;
        let some = draw(r, scene, camera, &settings(&format!("kind=bkb k={k} model=constant")), size);
        let mut deeper = 0;
        for pixel in 0..all.layers.counts.len() {
            let (a, b) = (all.layers.range(pixel), some.store.layers.range(pixel));
            assert_eq!(b.len(), a.len().min(k));
            assert_eq!(some.store.layers.overflowed[pixel], a.len() > k);
            deeper += usize::from(a.len() > k);
            assert_eq!(all.words[a.start..a.start + b.len()], some.store.words[b], "pixel {pixel}");
        }
        let layers = some.frame.report.layers;
        assert_eq!(layers.dropped as usize, all.layers.len() - some.store.layers.len());
        assert!(layers.balanced() && deeper > 0, "{layers:?}");
        println!("k = {k}: {deeper} pixels are deeper");
    };
    for (_, scene, camera) in views() {
        check(&mut r, &scene, &camera, 3, SIZE);
    }
    let scene = meshes::stack(70, 0.02, |i| (i % 5) as usize);
    let camera = front(&scene, false);
    check(&mut r, &scene, &camera, 64, [16, 16]);
}

#[test]
fn t27_the_order_of_drawing_changes_no_bit() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        for row in ["kind=compacted", "kind=bkb k=24", "kind=bkb k=4", "kind=bkb k=4 tail=average"] {
            let s = lively_settings(row);
            let expected = draw(&mut r, &scene, &camera, &s, SIZE);
            for seed in 1..if full() { 12 } else { 3 } {
                r.draw_order = DrawOrder::Shuffled(seed);
                let loaded = r.load_shuffled(&scene, seed).expect("upload");
                let frame = r.render(&loaded, &camera, &s, SIZE).expect("a frame");
                let store = r.read_store(&frame.report, &loaded, &camera).expect("read-back");
                r.draw_order = DrawOrder::default();
                assert_eq!(frame.report.layers, expected.frame.report.layers);
                expected.assert_same(&Shot { frame, store }, &format!("{name}, {row}, order {seed}"));
            }
        }
    }
}

#[test]
fn buckets_and_brute_force_find_the_same_neighbours() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        for row in ["kind=compacted", "kind=bkb k=24", "kind=bkb k=5", "kind=bkb k=5 features.depth_term=printed"] {
            let buckets = draw(&mut r, &scene, &camera, &lively_settings(&format!("{row} search=buckets")), SIZE);
            let brute = draw(&mut r, &scene, &camera, &lively_settings(&format!("{row} search=brute_force")), SIZE);
            assert!(buckets.frame.report.plan.runs(Pass::BucketCreation));
            assert!(!brute.frame.report.plan.runs(Pass::BucketCreation));
            buckets.assert_same(&brute, &format!("{name}, {row}"));
        }
    }
}

#[test]
fn an_earlier_frame_leaves_no_trace() {
    let Some(mut r) = renderer() else { return };
    // First layers everywhere, then a scene with many empty pixels in the same buffers.
    let full = meshes::stack(16, 0.05, |i| (i % 10) as usize);
    for (name, scene, _) in views() {
        let camera = front(&scene, false);
        for row in ["kind=bkb k=16", "kind=compacted"] {
            let s = lively_settings(row);
            let close = Camera { projection: Projection::Orthographic { height: 1.0 }, ..front(&full, true) };
            draw(&mut r, &full, &close, &s, SIZE);
            let after = draw(&mut r, &scene, &camera, &s, SIZE);
            assert!(after.store.layers.counts.iter().filter(|&&c| c == 0).count() > 500);
            let brute = draw(&mut r, &scene, &camera, &lively_settings(&format!("{row} search=brute_force")), SIZE);
            after.assert_same(&brute, &format!("{name}, {row}"));
        }
    }
}

#[test]
fn bands_change_no_bit() {
    let (Some(mut r), Some(mut small)) = (renderer(), small_renderer()) else { return };
    let size = [72, 80];
    for (name, scene, camera) in views() {
        for row in [
            "kind=compacted",
            "kind=compacted radius=0.03 line=0.02",
            "kind=compacted model=constant",
            "kind=bkb k=16",
            "kind=bkb k=8 radius=0.03 line=0.02 tail=average",
            "kind=bkb k=5 search=brute_force reverse=false",
            "kind=bkb k=9 model=constant tail=average",
        ] {
            let s = lively_settings(row);
            let whole = draw(&mut r, &scene, &camera, &s, size);
            let banded = draw(&mut small, &scene, &camera, &s, size);
            let bands = banded.frame.report.bands;
            println!("{name}, {row}: {bands} bands");
            assert!(whole.frame.report.bands == 1, "{}", whole.frame.report.bands);
            let must = !row.contains("k=5") && !row.contains("k=8") && !row.contains("k=9");
            assert!(bands > 1 || !must, "{name}, {row}: one band tests nothing");
            assert_first(&whole.bits(), &banded.bits(), &format!("{name}, {row}: image"));
            assert_eq!(whole.frame.report.layers, banded.frame.report.layers, "{name}, {row}: the books");
        }
    }
}

#[test]
fn samples_change_no_bit_between_captures() {
    let Some(mut r) = renderer() else { return };
    let (_, scene, camera) = views().swap_remove(0);
    let compacted = draw(&mut r, &scene, &camera, &lively_settings("image.samples=3"), SIZE);
    let rows = draw(&mut r, &scene, &camera, &lively_settings("image.samples=3 kind=bkb k=32"), SIZE);
    let single = draw(&mut r, &scene, &camera, &lively_settings(""), SIZE);
    assert_first(&compacted.bits(), &rows.bits(), "three samples");
    assert_ne!(compacted.bits(), single.bits());
}

/// The scene and the camera, larger by a factor.
pub fn scaled(scene: &Scene, camera: &Camera, by: f64) -> (Scene, Camera) {
    let mut scene = scene.clone();
    for node in scene.nodes.iter_mut().filter(|n| n.parent.is_none()) {
        node.parent_from_node = DMat4::from_scale(DVec3::splat(by)) * node.parent_from_node;
    }
    let mut camera = *camera;
    camera.position *= by;
    camera.focal_point *= by;
    if let Projection::Orthographic { height } = &mut camera.projection {
        *height *= by;
    }
    (scene.finish().expect("the same scene"), camera)
}

#[test]
fn t07_a_model_1024_times_as_large_gives_the_same_bits() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        for by in [1024.0, 1.0 / 1024.0] {
            let (large, large_camera) = scaled(&scene, &camera, by);
            for row in [
                "unit=view",
                "unit=part kind=bkb k=20",
                "unit=scene curvature=view_centred radius=0.02",
                "kind=bkb k=4 tail=average",
            ] {
                let s = lively_settings(row);
                let small = draw(&mut r, &scene, &camera, &s, SIZE);
                let large = draw(&mut r, &large, &large_camera, &s, SIZE);
                small.assert_same(&large, &format!("{name}, {row}, times {by}"));
            }
        }
    }
}

/// The scene with one more part, far away.
pub fn with_far_part(scene: &Scene, at: DVec3) -> Scene {
    let mut scene = scene.clone();
    scene.meshes.push(Mesh { name: "far".to_owned(), primitives: vec![meshes::cuboid(DVec3::splat(0.5))] });
    scene.nodes.push(Node::root("far", Some(scene.meshes.len() - 1), DMat4::from_translation(at)));
    scene.finish().expect("a small scene")
}

#[test]
fn t07_a_far_part_changes_no_link_and_no_kappa_of_the_others() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        let perspective = matches!(camera.projection, Projection::Perspective { .. });
        // A parallel depth is linear over the scene's depth, so there the other part is far to the side.
        let camera = if perspective { camera } else { front(&scene, true) };
        let (right, _, back) = camera.axes();
        let at = if perspective {
            camera.focal_point - back * 40.0 - right * 60.0
        } else {
            camera.focal_point + right * 60.0
        };
        let more = with_far_part(&scene, at);
        assert!(more.bounds().bounding_sphere().radius > 5.0 * scene.bounds().bounding_sphere().radius);
        assert_eq!(more.origin, scene.origin);
        for row in ["unit=view", "unit=part kind=bkb k=24 curvature=view_centred"] {
            let s = lively_settings(row);
            let alone = draw(&mut r, &scene, &camera, &s, SIZE);
            let both = draw(&mut r, &more, &camera, &s, SIZE);
            let far = scene.parts.len() as u32;
            assert!(!both.store.layers.part.contains(&far), "{name}: the far part is outside the image");
            assert_first(&alone.store.layers.part, &both.store.layers.part, &format!("{name}, {row}: parts"));
            assert_first(&alone.store.links, &both.store.links, &format!("{name}, {row}: links"));
            assert_first(&alone.kappa_bits(), &both.kappa_bits(), &format!("{name}, {row}: kappa"));
        }
    }
}

#[test]
fn the_opaque_pass_equals_a_capture_of_opaque_layers() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        let mut opaque = scene.clone();
        opaque
            .materials
            .iter_mut()
            .filter(|m| m.alpha_mode == AlphaMode::Blend)
            .for_each(|m| m.alpha_mode = AlphaMode::Opaque);
        let mut captured = scene.clone();
        // All of it blended, with an alpha of one: nothing shows through, but the planner cannot know.
        for m in captured.materials.iter_mut().filter(|m| !matches!(m.alpha_mode, AlphaMode::Mask { .. })) {
            m.alpha_mode = AlphaMode::Blend;
            m.base_color[3] = 1.0;
        }
        for row in ["", "normals=xy15"] {
            let direct = draw(&mut r, &opaque, &camera, &settings(&format!("{row} model=opaque")), SIZE);
            assert_eq!(direct.frame.report.plan.capture, Capture::None);
            for capture in ["kind=compacted", "kind=bkb k=8", "kind=bkb k=1"] {
                let s = settings(&format!("{row} {capture} model=constant constant=1"));
                let layered = draw(&mut r, &captured, &camera, &s, SIZE);
                assert_ne!(layered.frame.report.plan.capture, Capture::None);
                assert_first(&direct.bits(), &layered.bits(), &format!("{name}, {row} {capture}"));
            }
        }
    }
}

/// What the planner leaves out changes nothing: with a function that seems to vary with curvature, but not where κ is,
/// all of it runs. Opacities are exact in the half floats of the lit column.
#[test]
fn effects_that_are_left_out_change_no_bit() {
    let Some(mut r) = renderer() else { return };
    let neutral = |opacity: f64, last: f64| {
        transfer(&format!(
            "[color]\nmode = \"tint\"\ninterpolation = \"linear\"\npoints = [{{ kappa = 0.9, color = 0.5 }}, {{ kappa = 1.0, color = {last} }}]\n\
             [opacity]\ninterpolation = \"linear\"\ndepth_interpolation = \"linear\"\ncurves = [{{ depth = 0.0, points = [[0.0, {opacity}]] }}]\n"
        ))
    };
    for (name, scene, camera) in views() {
        for (opacity, gain) in [(0.25, 1.0), (0.125, 2.0), (0.5, 8.0)] {
            // With scale 0 no layer is concave: κ is 0, or −1 at rims.
            let base = settings(&format!("scale=0 gain={gain}"));
            let skipped = draw(&mut r, &scene, &camera, &with_transfer(base.clone(), neutral(opacity, 0.5)), SIZE);
            let forced = draw(&mut r, &scene, &camera, &with_transfer(base, neutral(opacity, 0.9)), SIZE);
            let (a, b) = (&skipped.frame.report.plan, &forced.frame.report.plan);
            assert_eq!(a.opacity, Opacity::Constant { alpha: opacity * gain });
            assert!(
                !a.runs(Pass::Stylize) && !a.runs(Pass::Curvature) && b.runs(Pass::Stylize) && b.runs(Pass::Curvature)
            );
            assert_first(&skipped.bits(), &forced.bits(), &format!("{name}, opacity {opacity}, gain {gain}"));
        }
    }
}
