//! Arranged scenes against the `f64` oracle, picking against the frame's own store, and the outline.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use pellucid::math::Camera;
use pellucid::math::color::linear_from_srgb;
use pellucid::oracle::arranged::{arranged, fade};
use pellucid::oracle::stylize::Tables;
use pellucid::oracle::{compare, composite, rasterize, stylize};
use pellucid::plan::{Capture, Opacity, Pass};
use pellucid::render::{GpuScene, Renderer};
use pellucid::scene::{AlphaMode, Arrangement, PartLook, PartStyle, Presence, Scene, builtin};
use pellucid::settings::Settings;

use crate::common::*;
use crate::raster::check_capture;
use crate::stages::report;

const SIZE: [u32; 2] = [72, 56];

fn scene() -> Scene {
    builtin::build("hard/assembly?seed=3").expect("a scene")
}

fn look(presence: Presence) -> PartLook {
    PartLook { presence, ..PartLook::default() }
}

fn with(parts: impl IntoIterator<Item = (u32, PartLook)>) -> Arrangement {
    Arrangement { parts: parts.into_iter().collect(), ..Arrangement::default() }
}

fn load(r: &mut Renderer, scene: &Scene, arrangement: &Arrangement) -> GpuScene {
    let mut loaded = r.load(scene).expect("a scene");
    r.arrange(&mut loaded, scene, arrangement).expect("an arrangement");
    loaded
}

fn take(r: &mut Renderer, scene: &GpuScene, camera: &Camera, settings: &Settings, size: [u32; 2]) -> Shot {
    Shot::of(r, scene, camera, settings, size).expect("a frame")
}

/// Something of everything: parts moved, hidden, ghosted, coloured, half there, solid.
fn lively_arrangement(scene: &Scene) -> Arrangement {
    let looks = [
        look(Presence::Ghosted),
        look(Presence::Hidden),
        PartLook { color: Some([0.9, 0.2, 0.1]), ..PartLook::default() },
        PartLook { opacity: 0.4, ..PartLook::default() },
        PartLook { style: PartStyle::Solid, ..PartLook::default() },
        PartLook { style: PartStyle::Solid, opacity: 0.5, color: Some([0.0, 0.4, 1.0]), presence: Presence::Ghosted },
    ];
    let parts = (0..scene.parts.len() as u32).zip(looks.into_iter().cycle()).collect();
    Arrangement { parts, explode: 0.35, ..Arrangement::default() }
}

#[test]
fn every_stage_of_an_arranged_scene_is_the_oracles() {
    let Some(mut r) = renderer() else { return };
    // Textures, vertex colours and holes are in it too.
    let colored = |scene: &Scene| {
        let color = |p: u32| Some([0.1 * f64::from(p % 10), 0.5, 1.0 - 0.1 * f64::from(p % 10)]);
        with((0..scene.parts.len() as u32).map(|p| (p, PartLook { color: color(p), ..PartLook::default() })))
    };
    type Arrange<'a> = &'a dyn Fn(&Scene) -> Arrangement;
    let cases: [(&str, Arrange<'_>); 3] = [
        ("hard/assembly?seed=3", &lively_arrangement),
        ("hard/assembly?seed=11", &lively_arrangement),
        ("hard/assembly?seed=3", &colored),
    ];
    for (name, arrange) in cases {
        let scene = builtin::build(name).expect("a scene");
        let arrangement = arrange(&scene);
        let moved = arranged(&scene, &arrangement);
        let loaded = load(&mut r, &scene, &arrangement);
        assert_eq!(loaded.stats.bounds, moved.bounds());
        for (pairs, orthographic) in [("", false), ("", true), ("kind=bkb k=64", false), ("model=constant", false)] {
            let what = format!("{name} {pairs}, orthographic {orthographic}");
            let settings = with_transfer(settings(pairs), lively());
            let camera = camera(&moved, orthographic);
            let shot = take(&mut r, &loaded, &camera, &settings, SIZE);
            assert_finite(&shot, &what);
            let layers = rasterize(&moved, &camera, SIZE, DVec2::ZERO);
            check_capture(&what, &moved, &camera, &layers, &shot.store, &settings);
            let store = &shot.store;
            if shot.frame.report.plan.features.is_some() {
                let how = (settings.features.depth_term, settings.features.reverse_check);
                report(&what, &compare::links(&moved, &camera, &store.layers, &store.links, how));
                let features = (store.links.as_slice(), store.kappa.as_slice());
                report(&what, &compare::kappa(&moved, &camera, &store.layers, features, &settings.features.curvature));
                let transfer = settings.opacity.transfer.resolve(None).unwrap();
                let kappa: Vec<f64> = store.kappa.iter().map(|&k| f64::from(k)).collect();
                let lit = pellucid::oracle::shade::shade(
                    &store.layers,
                    &view_of(&camera, SIZE),
                    &compare::rig(&settings.light),
                );
                let extents = extents_of(&moved, &camera);
                let styled =
                    stylize::stylize(&store.layers, &lit, &kappa, &extents, &settings.opacity, &Tables::of(&transfer));
                report(&what, &compare::colors(&store.lit, &styled));
            }
            let mut colors = shot.colors();
            colors.iter_mut().for_each(|c| c[3] = c[3].clamp(0.0, 1.0));
            fade(&store.layers, &mut colors, &arrangement, settings.opacity.ghost);
            let image = composite::front_to_back(&store.layers, &colors, None);
            let pairs = image.iter().flatten().zip(shot.frame.image.pixels.iter().flatten());
            let worst = pairs.map(|(a, &b)| (a - f64::from(b)).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-5, "{what}: the picture is off by {worst}");
        }
    }
}

#[test]
fn no_arrangement_changes_nothing() {
    let Some(mut r) = renderer() else { return };
    let scene = scene();
    let camera = camera(&scene, false);
    for pairs in ["", "kind=bkb k=3 tail=average", "model=opaque", "model=constant"] {
        let settings = settings(pairs);
        let never = draw(&mut r, &scene, &camera, &settings, SIZE);
        let loaded = load(&mut r, &scene, &Arrangement::default());
        let plain = take(&mut r, &loaded, &camera, &settings, SIZE);
        assert_eq!(never.frame.report.plan, plain.frame.report.plan);
        never.assert_same(&plain, pairs);
        // And back again.
        let mut loaded = load(&mut r, &scene, &lively_arrangement(&scene));
        r.arrange(&mut loaded, &scene, &Arrangement::default()).expect("an arrangement");
        never.assert_same(&take(&mut r, &loaded, &camera, &settings, SIZE), &format!("{pairs}, back again"));
    }
}

#[test]
fn a_hidden_part_leaves_the_scene_without_it() {
    let Some(mut r) = renderer() else { return };
    let scene = scene();
    for hidden in [0, 1, scene.parts.len() as u32 - 1] {
        let mut without = scene.clone();
        without.nodes[scene.parts[hidden as usize].node].mesh = None;
        let without = without.finish().expect("a scene");
        assert_eq!(without.origin, scene.origin);
        let loaded = load(&mut r, &scene, &with([(hidden, look(Presence::Hidden))]));
        let (bounds, expected) = (loaded.stats.bounds, without.bounds());
        assert_eq!(bounds, expected);
        for pairs in ["", "kind=bkb k=4", "model=opaque"] {
            let (camera, settings) = (camera(&scene, false), settings(pairs));
            let found = take(&mut r, &loaded, &camera, &settings, SIZE);
            let expected = draw(&mut r, &without, &camera, &settings, SIZE);
            assert_first(&found.bits(), &expected.bits(), &format!("{pairs}, without part {hidden}"));
        }
    }
    let all = (0..scene.parts.len() as u32).map(|p| (p, look(Presence::Hidden)));
    let loaded = load(&mut r, &scene, &with(all));
    let empty = take(&mut r, &loaded, &camera(&scene, false), &Settings::default(), SIZE);
    assert!(empty.frame.image.pixels.iter().all(|p| *p == [0.0; 4]));
}

#[test]
fn ghosted_layers_have_exactly_their_share_of_the_opacity() {
    let Some(mut r) = renderer() else { return };
    let scene = scene();
    let camera = camera(&scene, false);
    let all = 0..scene.parts.len() as u32;
    for pairs in ["gain=8", "kind=bkb k=64", "kind=bkb k=64 key=packed32", "model=constant", "model=opaque"] {
        let settings = with_transfer(settings(pairs), lively());
        let ghost = settings.opacity.ghost as f32;
        let shown = r.load(&scene).expect("a scene");
        let ghosted = load(&mut r, &scene, &with(all.clone().map(|p| (p, look(Presence::Ghosted)))));
        let mut seen = 0;
        for pixel in [[20, 20], [36, 28], [50, 30], [30, 44]] {
            let a = r.pick(&shown, &camera, &settings, SIZE, pixel).expect("layers");
            let b = r.pick(&ghosted, &camera, &settings, SIZE, pixel).expect("layers");
            assert_eq!(a.len(), b.len());
            for (a, b) in a.iter().zip(&b) {
                assert_eq!((a.part, a.depth, b.opacity), (b.part, b.depth, a.opacity * ghost), "{pairs}");
                seen += usize::from(a.opacity == 1.0);
            }
        }
        assert!(seen > 0 || pairs != "gain=8", "no layer was clamped: the test shows nothing");
        // The picture is made of these opacities, the tail's too.
        let shot = take(&mut r, &ghosted, &camera, &settings, SIZE);
        let most = shot.store.layers.counts.iter().copied().max().unwrap_or(0);
        let alpha = shot.frame.image.pixels.iter().map(|p| p[3]).fold(0.0, f32::max);
        assert!(alpha > 0.0 && alpha <= 1.0 - (1.0 - ghost).powi(most as i32) + 1e-5, "{pairs}: {alpha}");
    }
    for factor in [0.0, 1.0] {
        let settings = settings("kind=bkb k=2 tail=average");
        let all =
            all.clone().map(|p| (p, PartLook { opacity: factor, presence: Presence::Ghosted, ..PartLook::default() }));
        let mut visible = settings.clone();
        visible.opacity.ghost = 1.0;
        let loaded = load(&mut r, &scene, &with(all));
        let found = take(&mut r, &loaded, &camera, &visible, SIZE);
        if factor == 0.0 {
            assert!(found.frame.image.pixels.iter().all(|p| p[3] == 0.0), "something is left, the tail perhaps");
        } else {
            assert_first(&found.bits(), &draw(&mut r, &scene, &camera, &settings, SIZE).bits(), "a factor of 1");
        }
    }
}

#[test]
fn the_plan_follows_the_looks() {
    let Some(mut r) = renderer() else { return };
    let scene = scene();
    let camera = camera(&scene, false);
    // Of opaque materials only.
    let glass = scene.materials.iter().position(|m| m.alpha_mode == AlphaMode::Blend);
    let of_glass = |mesh: usize| scene.meshes[mesh].primitives.iter().any(|p| Some(p.material) == glass);
    let blended = scene.parts.iter().enumerate().filter(|(_, p)| of_glass(p.mesh));
    let hidden: BTreeMap<u32, PartLook> = blended.map(|(i, _)| (i as u32, look(Presence::Hidden))).collect();
    let first = (0..scene.parts.len() as u32).find(|p| !hidden.contains_key(p)).expect("a part that is no glass");
    let opaque = settings("model=opaque");
    let plan = |r: &mut Renderer, look: PartLook| {
        let mut arrangement = with(hidden.clone());
        arrangement.parts.insert(first, look);
        let loaded = load(r, &scene, &arrangement);
        (r.plan(&loaded, &camera, &opaque, SIZE).expect("a plan"), loaded, arrangement)
    };
    let (shown, ..) = plan(&mut r, PartLook::default());
    assert_eq!((shown.capture, shown.faded, shown.recolored), (Capture::None, false, false));
    let (ghosted, ..) = plan(&mut r, look(Presence::Ghosted));
    assert_eq!((ghosted.capture, ghosted.faded), (Capture::Compacted, true));
    assert_eq!(ghosted.passes[0].reason, "1 part is ghosted or translucent: every layer is kept");
    assert!(ghosted.passes.iter().any(|p| p.pass == Pass::Blend && p.reason.contains("parts")));
    let red = PartLook { color: Some([0.8, 0.1, 0.1]), ..PartLook::default() };
    let (recolored, loaded, arrangement) = plan(&mut r, red);
    assert_eq!((recolored.capture, recolored.recolored), (Capture::None, true));
    // The opaque pass gives the colours that a capture gives.
    let direct = take(&mut r, &loaded, &camera, &opaque, SIZE);
    let moved = arranged(&scene, &arrangement);
    let transfer = opaque.opacity.transfer.resolve(None).unwrap();
    let exact = compare::picture(&moved, &camera, &opaque, &transfer, SIZE, DVec2::ZERO);
    let off = |(a, b): (&[f64; 4], &[f32; 4])| (0..4).map(|c| (a[c] - f64::from(b[c])).abs()).fold(0.0, f64::max);
    let wrong = exact.iter().zip(&direct.frame.image.pixels).map(off).filter(|d| *d > 4.0 / 255.0).count();
    assert!(wrong * 50 < exact.len(), "{wrong} pixels differ");
    let as_made = draw(&mut r, &scene, &camera, &opaque, SIZE);
    assert_ne!(as_made.bits(), direct.bits());
}

/// Corners, edges, and the middle.
fn pixels([width, height]: [u32; 2]) -> Vec<[u32; 2]> {
    let (xs, ys) = (
        [0, 1, width / 4, width / 3, width / 2, 2 * width / 3, width - 1],
        [0, 2, height / 3, height / 2, 2 * height / 3, height - 2, height - 1],
    );
    xs.into_iter().flat_map(|x| ys.into_iter().map(move |y| [x, y])).collect()
}

#[test]
fn picking_finds_what_the_frame_has_stored() {
    let Some(mut r) = renderer() else { return };
    for (name, explode) in [("hard/assembly?seed=3", 0.0), ("hard/assembly?seed=7", 0.5), ("hard/normals", 0.0)] {
        let scene = builtin::build(name).expect("a scene");
        let arrangement = Arrangement { explode, ..Arrangement::default() };
        let loaded = load(&mut r, &scene, &arrangement);
        for (pairs, orthographic) in [
            ("", false),
            ("", true),
            ("kind=bkb k=5", false),
            ("kind=bkb k=8 tail=average", true),
            ("search=brute_force radius=0.05", false),
        ] {
            let what = format!("{name} {pairs}, orthographic {orthographic}");
            let (camera, settings) = (camera(&scene, orthographic), settings(pairs));
            let shot = take(&mut r, &loaded, &camera, &settings, SIZE);
            let mut layers = 0;
            for pixel in pixels(SIZE) {
                let found = r.pick(&loaded, &camera, &settings, SIZE, pixel).expect("layers");
                let range = shot.store.layers.range((pixel[1] * SIZE[0] + pixel[0]) as usize);
                assert_eq!(found.len(), range.len(), "{what}: layers of {pixel:?}");
                layers += found.len();
                for (f, i) in found.iter().zip(range) {
                    let s = &shot.store;
                    assert_eq!((f.part, f.depth), (s.layers.part[i], s.layers.depth[i]), "{what}: {pixel:?}");
                    assert_eq!(f.kappa.to_bits(), s.kappa[i].to_bits(), "{what}: kappa of {pixel:?}");
                    assert_eq!(f.opacity, s.lit[i][3].clamp(0.0, 1.0), "{what}: opacity of {pixel:?}");
                    let inside = loaded.stats.bounds;
                    let (by, p) = (1e-3 * inside.size().length(), f.position);
                    assert!(p.cmpge(inside.min - by).all() && p.cmple(inside.max + by).all(), "{what}: {p}");
                    let back = camera.view_from_world().transform_point3(p);
                    assert!((back.z + f.depth).abs() < 1e-9 * (1.0 + f.depth));
                    assert!((f.normal.length() - 1.0).abs() < 1e-9);
                }
            }
            assert!(layers > 20, "{what}: only {layers} layers were compared");
            // The frame's own store is untouched.
            let again = r.read_store(&shot.frame.report, &loaded, &camera).expect("the store");
            assert_eq!(again.words, shot.store.words, "{what}");
            assert!(r.pick(&loaded, &camera, &settings, SIZE, [SIZE[0], 0]).expect("nothing").is_empty());
        }
    }
}

#[test]
fn picking_goes_through_opaque_pictures_and_samples() {
    let Some(mut r) = renderer() else { return };
    let scene = builtin::build("quads?layers=8&parts=3").expect("a scene");
    let loaded = r.load(&scene).expect("a scene");
    let camera = front(&scene, false);
    let settings = settings("model=opaque image.samples=3");
    let plan = r.plan(&loaded, &camera, &settings, SIZE).expect("a plan");
    assert_eq!(plan.capture, Capture::None);
    let found = r.pick(&loaded, &camera, &settings, SIZE, [36, 28]).expect("layers");
    assert_eq!(found.len(), 8);
    assert!(found.windows(2).all(|pair| pair[0].depth <= pair[1].depth));
    assert!(found.iter().all(|l| l.opacity == 1.0 && l.kappa.is_finite()));
}

#[test]
fn picking_is_the_same_where_pictures_take_bands() {
    let scene = builtin::build("gearbox").expect("a scene");
    let arrangement = lively_arrangement(&scene);
    let (camera, size) = (front(&scene, false), [200, 160]);
    let pixels = [[100, 80], [0, 0], [130, 60], [100, 159], [70, 100]];
    let mut picked = Vec::new();
    for (r, what) in [(renderer(), "whole"), (small_renderer(), "in bands")] {
        let Some(mut r) = r else { return };
        let loaded = load(&mut r, &scene, &arrangement);
        let settings = settings("");
        let bands = r.render(&loaded, &camera, &settings, size).expect("a frame").report.bands;
        assert_eq!(bands > 1, what == "in bands");
        let begin = std::time::Instant::now();
        let pick = |pixel| r.pick(&loaded, &camera, &settings, size, pixel).expect("layers");
        picked.push(pixels.map(pick));
        let each = begin.elapsed().as_secs_f64() * 1e3 / pixels.len() as f64;
        println!("{what}: {each:.1} ms for each of {} pixels", pixels.len());
    }
    assert!(picked[0].iter().any(|layers| layers.len() > 5));
    assert_eq!(picked[0], picked[1]);
}

/// By definition: outside, with a pixel of the mask at most `width` away.
fn outlined(mask: &[bool], size: [u32; 2], width: f64) -> Vec<bool> {
    let [w, h] = size.map(|s| s as i32);
    let at = |x: i32, y: i32| (0..w).contains(&x) && (0..h).contains(&y) && mask[(y * w + x) as usize];
    let reach = width.ceil() as i32;
    (0..h)
        .flat_map(|y| (0..w).map(move |x| (x, y)))
        .map(|(x, y)| {
            let near = |dx: i32, dy: i32| f64::from(dx * dx + dy * dy) <= width * width && at(x + dx, y + dy);
            !at(x, y) && (-reach..=reach).any(|dy| (-reach..=reach).any(|dx| near(dx, dy)))
        })
        .collect()
}

#[test]
fn the_outline_goes_around_what_is_selected_and_changes_nothing_else() {
    let Some(mut r) = renderer() else { return };
    let scene = scene();
    let camera = front(&scene, false);
    // One with holes among them.
    let has_holes = |mesh: usize| {
        let materials = scene.meshes[mesh].primitives.iter().map(|p| &scene.materials[p.material]);
        materials.into_iter().any(|m| matches!(m.alpha_mode, AlphaMode::Mask { .. }))
    };
    let masked = scene.parts.iter().position(|p| has_holes(p.mesh)).expect("a part with holes") as u32;
    let selected = BTreeSet::from([2, masked]);
    let selection = Arrangement { selected: selected.clone(), ..Arrangement::default() };
    let only = |p: u32| if selected.contains(&p) { Presence::Shown } else { Presence::Hidden };
    let alone = with((0..scene.parts.len() as u32).map(|p| (p, look(only(p)))));
    let color = [0xff, 0xb0, 0x00].map(|v: u32| linear_from_srgb(f64::from(v) / 255.0) as f32);
    for (pairs, width) in [("", 2.0), ("kind=bkb k=4 outline.width=3.5", 3.5), ("model=opaque", 2.0)] {
        let settings = settings(pairs);
        let plain = draw(&mut r, &scene, &camera, &settings, SIZE);
        let loaded = load(&mut r, &scene, &selection);
        let found = take(&mut r, &loaded, &camera, &settings, SIZE);
        let plan = &found.frame.report.plan;
        assert!(
            plan.runs(Pass::OutlineMask) && plan.runs(Pass::Outline) && !plain.frame.report.plan.runs(Pass::Outline)
        );
        // What is covered: pixels of the parts alone that have layers.
        let alone = load(&mut r, &scene, &alone);
        let covered = take(&mut r, &alone, &camera, &Settings::default(), SIZE);
        let mask: Vec<bool> = covered.store.layers.counts.iter().map(|&n| n > 0).collect();
        let expected = outlined(&mask, SIZE, width);
        let count = expected.iter().filter(|&&e| e).count();
        assert!(count > 50, "only {count} pixels of outline");
        for (i, &expected) in expected.iter().enumerate() {
            let pixel = found.frame.image.pixels[i];
            let wanted = if expected { [color[0], color[1], color[2], 1.0] } else { plain.frame.image.pixels[i] };
            let off = (0..4).map(|c| (pixel[c] - wanted[c]).abs()).fold(0.0, f32::max);
            assert!(if expected { off < 1e-6 } else { off == 0.0 }, "{pairs}: pixel {i}: {pixel:?}, {wanted:?}");
        }
    }
    // A wrong colour is an error, and only where it is used.
    let mut wrong = settings("");
    wrong.outline.color = "gold".to_owned();
    let loaded = load(&mut r, &scene, &selection);
    let error = r.render(&loaded, &camera, &wrong, SIZE).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("outline.color = 'gold'"), "{error}");
    draw(&mut r, &scene, &camera, &wrong, SIZE);
    // Several samples soften it; a hidden part has none.
    let softened = take(&mut r, &loaded, &camera, &settings("image.samples=4"), SIZE);
    assert_eq!(softened.frame.report.plan.opacity, Opacity::Curvature);
    let mut hidden = with(selected.iter().map(|&p| (p, look(Presence::Hidden))));
    hidden.selected = selected;
    let loaded = load(&mut r, &scene, &hidden);
    assert!(!r.plan(&loaded, &camera, &Settings::default(), SIZE).expect("a plan").runs(Pass::Outline));
}
