//! The illustration buffer: linked lists against the other captures.

use std::collections::HashSet;

use pellucid::math::Camera;
use pellucid::oracle::Lists;
use pellucid::plan::{Capture, FramePlan};
use pellucid::render::{DrawOrder, RenderError, Renderer};
use pellucid::scene::Scene;
use pellucid::settings::Settings;

use crate::common::*;
use crate::meshes;

const SIZE: [u32; 2] = [64, 56];

fn lively_settings(pairs: &str) -> Settings {
    with_transfer(settings(pairs), lively())
}

fn views() -> Vec<(String, Scene, Camera)> {
    let scene = |seed: u64| if seed.is_multiple_of(3) { meshes::soups(seed, 9, 14) } else { meshes::assembly(seed) };
    (21..if full() { 27 } else { 24 })
        .map(|seed| {
            let scene = scene(seed);
            let camera = camera(&scene, seed % 2 == 0);
            (format!("scene {seed}"), scene, camera)
        })
        .collect()
}

/// A renderer that has no buffers of an earlier frame, on the shared device.
fn fresh(r: &Renderer) -> Renderer {
    Renderer::new(r.gpu().clone()).expect("a renderer")
}

#[test]
fn t28_linked_lists_equal_the_compacted_ones() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        for model in ["", "model=constant constant=0.37", "normals=full search=brute_force", "curvature=view_centred"] {
            let exact = draw(&mut r, &scene, &camera, &lively_settings(model), SIZE);
            assert!(exact.store.layers.len() > 2000);
            for sort in ["by_length", "selection"] {
                let row = format!("{model} kind=lists sort={sort}");
                let lists = draw(&mut r, &scene, &camera, &lively_settings(&row), SIZE);
                assert!(matches!(lists.frame.report.plan.capture, Capture::LinkedList { .. }));
                exact.assert_same(&lists, &format!("{name}, {row}"));
                assert_eq!(lists.frame.report.layers, exact.frame.report.layers, "{name}: the books");
            }
        }
    }
}

/// What lies in the buffers are lists in the oracle's sense: every fragment in one list, in the list of its pixel.
#[test]
fn the_lists_are_those_of_the_oracle() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        let shot = draw(&mut r, &scene, &camera, &settings("kind=lists model=constant"), SIZE);
        let store = &shot.store;
        let words = |name: &str| r.read_words(name).expect(name);
        let keys: Vec<(u32, u32)> = words("arrival_keys").chunks_exact(2).map(|k| (k[1], k[0])).collect();
        let lists = Lists {
            heads: words("list_heads"),
            counts: store.layers.counts.clone(),
            next: words("list_next"),
            keys,
            counted: u64::from(words("list_count")[0]),
        };
        assert_eq!(lists.counted as usize, store.layers.len());
        let mut met = HashSet::new();
        for pixel in 0..store.layers.counts.len() {
            let count = store.layers.counts[pixel] as usize;
            let (places, ends) = lists.walk(pixel, count);
            assert!(ends && places.len() == count, "{name}: pixel {pixel}");
            assert!(places.iter().all(|&p| p < store.layers.len() && met.insert(p)), "{name}: pixel {pixel}");
            let stored: Vec<(u32, u32)> =
                store.layers.range(pixel).map(|i| (store.words[i][0], store.words[i][1])).collect();
            assert_eq!(lists.selection_sort(pixel), stored, "{name}: pixel {pixel}");
        }
        assert_eq!(met.len(), store.layers.len());
    }
}

#[test]
fn t17_lists_grow_to_the_need_and_lose_nothing() {
    let Some(r) = renderer() else { return };
    let (_, scene, camera) = views().swap_remove(0);
    let mut other = fresh(&r);
    let exact = draw(&mut other, &scene, &camera, &lively_settings(""), SIZE);
    let need = exact.store.layers.len();
    for (capacity, refilled) in [(need, 0), (need - 1, 1), (1, 1), (need + 1, 0), (0, 0)] {
        let mut r = fresh(&r);
        let s = lively_settings(&format!("kind=lists capture.linked_list.capacity={capacity}"));
        let lists = draw(&mut r, &scene, &camera, &s, SIZE);
        assert_eq!(lists.frame.report.refilled, refilled, "room for {capacity} of {need}");
        assert!(lists.frame.report.layers.balanced());
        exact.assert_same(&lists, &format!("room for {capacity} of {need}"));
        // What was once needed stays.
        let again = draw(&mut r, &scene, &camera, &s, SIZE);
        assert_eq!(again.frame.report.refilled, 0);
        exact.assert_same(&again, &format!("room for {capacity} of {need}, again"));
    }
}

/// One renderer through an orbit in which the need for memory jumps (the camera comes nearer) in the very frame in which the picture
/// becomes larger, or smaller, or stays as it is: each frame as from a renderer that has drawn nothing before.
#[test]
fn t17_an_overflow_in_an_orbit_and_a_resize_during_it_show_no_difference() {
    let Some(r) = renderer() else { return };
    let (_, scene, _) = views().swap_remove(1);
    // Zoom, size of the picture, and whether there is too little room.
    let orbit = [
        (0.3, [48, 40], true),
        (0.3, [48, 40], false),
        (0.3, [40, 48], false),
        (1.6, [40, 48], true),
        (1.7, [40, 30], false),
        (0.4, [33, 70], false),
        (1.9, [72, 64], true),
        (1.6, [72, 64], false),
        (2.6, [80, 90], true),
        (0.5, [48, 40], false),
    ];
    let models = ["", "model=illustrative", "model=illustrative opacity.illustrative.base=curvature sort=selection"];
    for model in models.into_iter().take(if full() { 3 } else { 2 }) {
        let mut lists = fresh(&r);
        for (step, (zoom, size, lacks)) in orbit.into_iter().enumerate() {
            let angle = 0.3 * step as f64;
            let direction = glam::DVec3::new(angle.sin(), -0.3, angle.cos());
            let aspect = f64::from(size[0]) / f64::from(size[1]);
            let camera = Camera::framing(&scene.bounds(), direction, glam::DVec3::Y, aspect, zoom, false, 0.6);
            let what = format!("{model} step {step}");
            let s = lively_settings(&format!("{model} kind=lists capture.linked_list.capacity=50"));
            let shot = draw(&mut lists, &scene, &camera, &s, size);
            let report = &shot.frame.report;
            println!("{what}: {} fragments, filled again {}", report.layers.stored, report.refilled);
            assert_eq!(report.refilled, u32::from(lacks), "{what}");
            assert!(report.layers.lost == 0 && report.layers.balanced(), "{what}: {:?}", report.layers);
            let alone = draw(&mut fresh(&r), &scene, &camera, &s, size);
            alone.assert_same(&shot, &what);
            assert_eq!(alone.frame.report.layers, report.layers, "{what}: the books");
            let exact = lively_settings(&format!("{model} kind=compacted"));
            draw(&mut fresh(&r), &scene, &camera, &exact, size).assert_same(&shot, &format!("{what}, compacted"));
        }
    }
}

/// Room left by an earlier frame for exactly what is needed, and for less: it is grown only where it has to be. Where memory may
/// not grow to the need there are bands, and the picture is the same.
#[test]
fn t17_room_left_by_an_earlier_frame_is_grown_where_it_is_too_small() {
    let Some(r) = renderer() else { return };
    let (_, scene, camera) = views().swap_remove(0);
    let size = [96, 80];
    let draw_with = |r: &mut Renderer, row: &str| draw(r, &scene, &camera, &lively_settings(row), size);
    let exact = draw_with(&mut fresh(&r), "kind=compacted model=constant");
    let need = exact.store.layers.len();
    let far = camera_at(&scene, 0.2);
    // Buffers are multiples of 16 bytes, four links: what an earlier frame left may hold three more than was asked for.
    for (less, refilled) in [(0, 0), (4, 1)] {
        let mut lists = fresh(&r);
        let row = format!("kind=lists model=constant capture.linked_list.capacity={}", need - less);
        draw(&mut lists, &scene, &far, &lively_settings(&row), size);
        let shot = draw_with(&mut lists, &row);
        assert_eq!((shot.frame.report.refilled, shot.frame.report.bands), (refilled, 1), "{less} less");
        exact.assert_same(&shot, &format!("room for {less} less"));
    }
    // Bytes of all columns of a fragment, as the limit counts them.
    let plan = exact_plan(&r, &scene, &camera, size);
    let bytes: u64 = plan.columns().into_iter().map(|(_, bytes)| bytes).sum();
    let whole = (need as u64 * bytes).div_ceil(1 << 20);
    let (enough, short) = (format!("{whole}"), format!("{}", whole - 1));
    for (memory, bands) in [(enough, 1), (short, 2)] {
        let row = format!("kind=lists model=constant capture.linked_list.memory={memory}");
        let shot = draw_with(&mut fresh(&r), &row);
        let report = &shot.frame.report;
        println!("{need} fragments of {bytes} bytes, {memory} MiB: {} bands", report.bands);
        assert_eq!(report.bands.min(2), bands, "{memory} MiB");
        assert!(report.layers.lost == 0 && report.layers.balanced());
        assert_first(&exact.bits(), &shot.bits(), &format!("{memory} MiB"));
    }
}

fn camera_at(scene: &Scene, zoom: f64) -> Camera {
    let direction = glam::DVec3::new(0.3, -0.3, -0.9);
    Camera::framing(&scene.bounds(), direction, glam::DVec3::Y, 1.2, zoom, false, 0.6)
}

/// The plan of linked lists.
fn exact_plan(r: &Renderer, scene: &Scene, camera: &Camera, size: [u32; 2]) -> FramePlan {
    let mut r = fresh(r);
    let loaded = r.load(scene).expect("upload");
    r.plan(&loaded, camera, &settings("kind=lists model=constant"), size).expect("a plan")
}

#[test]
fn t17_memory_above_the_limit_makes_bands_and_then_a_refusal() {
    let Some(r) = renderer() else { return };
    let (_, scene, camera) = views().swap_remove(0);
    let size = [640, 600];
    let mut exact = fresh(&r);
    let whole = draw(&mut exact, &scene, &camera, &settings("model=constant"), size);
    let mut r = fresh(&r);
    let s = settings("model=constant kind=lists capture.linked_list.memory=8");
    let banded = draw(&mut r, &scene, &camera, &s, size);
    let fragments = whole.frame.report.layers.stored;
    println!("{fragments} fragments in {} bands", banded.frame.report.bands);
    assert!(banded.frame.report.bands > 1);
    assert_first(&whole.bits(), &banded.bits(), "bands of 8 MiB");
    assert_eq!(whole.frame.report.layers, banded.frame.report.layers);

    // A row of 4096 pixels with 16 layers each does not fit a MiB.
    let stack = meshes::stack(16, 0.05, |i| (i % 5) as usize);
    let loaded = r.load(&stack).expect("upload");
    let near = Camera::framing(&stack.bounds(), glam::DVec3::NEG_Z, glam::DVec3::Y, 512.0, 400.0, true, 0.6);
    let s = settings("model=constant kind=lists capture.linked_list.memory=1");
    let refused = r.render(&loaded, &near, &s, [4096, 8]);
    let Err(RenderError::ListsTooLarge { memory: 1, fragments, limit, .. }) = refused else {
        panic!("{:?}", refused.map(|f| f.report.layers));
    };
    assert!(fragments > limit && limit > 10_000, "{fragments} {limit}");
}

#[test]
fn t17_a_corrupt_list_ends_and_is_counted() {
    let Some(r) = renderer() else { return };
    let (_, scene, camera) = views().swap_remove(0);
    let module = "passes/capture/linked_list/fill";
    let link = "list_next[place] = atomicExchange(&list_heads[pixel], place + 1u);";
    for (what, fault) in [
        ("a cycle", "list_next[place] = select(place + 1u, 0u, atomicExchange(&list_heads[pixel], place + 1u) == 0u);"),
        ("a wild link", "list_next[place] = atomicExchange(&list_heads[pixel], place + 1u) * 100000u;"),
        (
            "the list of another pixel",
            "list_next[place] = select(1u, 0u, atomicExchange(&list_heads[pixel], place + 1u) == 0u);",
        ),
        ("a list cut short", "list_next[place] = min(atomicExchange(&list_heads[pixel], place + 1u), 0u);"),
    ] {
        let mut r = fresh(&r);
        r.replace_shader(module, Some(changed(module, link, fault)));
        for sort in ["by_length", "selection"] {
            let s = lively_settings(&format!("kind=lists sort={sort} model=illustrative"));
            let loaded = r.load(&scene).expect("upload");
            let frame = r.render(&loaded, &camera, &s, SIZE).expect("a frame");
            let layers = frame.report.layers;
            println!("{what}, {sort}: {layers:?}");
            assert!(layers.lost > 100 && !layers.balanced(), "{what}, {sort}: {layers:?}");
            assert!(frame.image.pixels.iter().flatten().all(|c| c.is_finite()), "{what}, {sort}");
        }
    }
}

#[test]
fn long_lists_and_equal_depths_have_one_order() {
    let Some(mut r) = renderer() else { return };
    // 300 layers, sixty of them in one place.
    let deep = meshes::stack(300, 0.02, |i| (i % 7) as usize);
    let flat = meshes::stack(60, 0.0, |i| (i % 3) as usize);
    for scene in [deep, flat] {
        let camera = front(&scene, true);
        let exact = draw(&mut r, &scene, &camera, &lively_settings("kind=compacted"), [24, 20]);
        for sort in ["by_length", "selection"] {
            let s = lively_settings(&format!("kind=lists sort={sort}"));
            let lists = draw(&mut r, &scene, &camera, &s, [24, 20]);
            exact.assert_same(&lists, sort);
            for seed in 1..3 {
                r.draw_order = DrawOrder::Shuffled(seed);
                let loaded = r.load_shuffled(&scene, seed).expect("upload");
                let frame = r.render(&loaded, &camera, &s, [24, 20]).expect("a frame");
                let store = r.read_store(&frame.report, &loaded, &camera).expect("read-back");
                r.draw_order = DrawOrder::default();
                exact.assert_same(&Shot { frame, store }, &format!("{sort}, order {seed}"));
            }
        }
    }
}
