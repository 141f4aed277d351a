//! Section planes and caps against the `f64` oracle, and what they must not change.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use pellucid::math::Camera;
use pellucid::oracle::arranged::arranged;
use pellucid::oracle::{Link, compare, rasterize_cut};
use pellucid::plan::Pass;
use pellucid::render::{GpuScene, Renderer};
use pellucid::scene::{Arrangement, PartLook, Scene, Section, builtin};
use pellucid::settings::Settings;

use crate::common::*;
use crate::raster::check_capture;
use crate::stages::report;

const SIZE: [u32; 2] = [72, 56];

fn section(normal: DVec3, offset: f64, caps: bool) -> Section {
    Section { normal: normal.normalize(), offset, enabled: true, caps }
}

/// A plane through a place in the middle of the box around a scene.
fn through_the_middle(scene: &Scene, normal: DVec3, by: f64, caps: bool) -> Section {
    let (bounds, normal) = (scene.bounds(), normal.normalize());
    let at = bounds.center() + scene.origin + normal * (by * bounds.size().length());
    section(normal, normal.dot(at), caps)
}

fn load(r: &mut Renderer, scene: &Scene, arrangement: &Arrangement) -> GpuScene {
    let mut loaded = r.load(scene).expect("a scene");
    r.arrange(&mut loaded, scene, arrangement).expect("an arrangement");
    loaded
}

fn take(r: &mut Renderer, scene: &GpuScene, camera: &Camera, settings: &Settings) -> Shot {
    Shot::of(r, scene, camera, settings, SIZE).expect("a frame")
}

#[test]
fn every_stage_of_a_cut_scene_is_the_oracles() {
    let Some(mut r) = renderer() else { return };
    for (name, far) in
        [("hard/assembly?seed=3", false), ("hard/assembly?seed=5&offset=1e5", true), ("torus?segments=24", false)]
    {
        let scene = builtin::build(name).expect("a scene");
        let mut arrangement = Arrangement { explode: if far { 0.0 } else { 0.2 }, ..Arrangement::default() };
        arrangement.sections = vec![
            through_the_middle(&scene, DVec3::new(0.3, 0.5, 0.8), 0.05, true),
            through_the_middle(&scene, DVec3::new(-1.0, 0.2, 0.1), 0.1, true),
            through_the_middle(&scene, DVec3::NEG_Y, 0.3, false),
        ];
        if scene.parts.len() > 2 {
            let red = PartLook { color: Some([0.9, 0.1, 0.1]), ..PartLook::default() };
            arrangement.parts.insert(1, red);
        }
        let (loaded, moved) = (load(&mut r, &scene, &arrangement), arranged(&scene, &arrangement));
        let planes = &loaded.cut.planes;
        assert!(planes.len() == 3 && !loaded.cut.caps.is_empty(), "{name}: no caps");
        assert_eq!(loaded.stats.parts as usize, moved.parts.len());
        for (pairs, orthographic) in [
            ("", false),
            ("", true),
            ("kind=bkb k=5", false),
            ("search=brute_force kind=bkb k=9", true),
            ("search=brute_force reverse=false", false),
            ("features.depth_term=printed search=brute_force unit=part", false),
        ] {
            let what = format!("{name} {pairs}, orthographic {orthographic}");
            let (camera, settings) = (camera(&scene, orthographic), settings(pairs));
            let layers = rasterize_cut(&moved, &camera, planes, SIZE, DVec2::ZERO);
            let shot = take(&mut r, &loaded, &camera, &settings);
            assert_finite(&shot, &what);
            let store = &shot.store;
            check_capture(&what, &moved, &camera, &layers, store, &settings);
            let how = (settings.features.depth_term, settings.features.reverse_check);
            let found = compare::links_cut(&moved, &camera, planes, &store.layers, &store.links, how);
            report(&format!("{what}, links"), &found);
            let features = (store.links.as_slice(), store.kappa.as_slice());
            let found = compare::kappa(&moved, &camera, &store.layers, features, &settings.features.curvature);
            report(&format!("{what}, curvature"), &found);
            assert!(store.layers.part.iter().any(|p| *p as usize >= scene.parts.len()), "{what}: no cap is seen");
            // The opaque pass covers the same pixels.
            let mut opaque = settings.clone();
            opaque.set("opacity.model", "opaque").expect("a setting");
            let direct = take(&mut r, &loaded, &camera, &opaque);
            let covered: Vec<bool> = direct.frame.image.pixels.iter().map(|p| p[3] > 0.0).collect();
            let there: Vec<bool> = store.layers.counts.iter().map(|n| *n > 0).collect();
            assert_first(&covered, &there, &format!("{what}: pixels of the opaque picture"));
        }
    }
}

#[test]
fn planes_that_cut_nothing_change_no_bit() {
    let Some(mut r) = renderer() else { return };
    let scene = builtin::build("hard/assembly?seed=3").expect("a scene");
    let camera = camera(&scene, false);
    let mut disabled = through_the_middle(&scene, DVec3::X, 0.0, true);
    disabled.enabled = false;
    for pairs in ["", "kind=bkb k=3 tail=average", "model=opaque", "model=constant"] {
        let settings = settings(pairs);
        let never = draw(&mut r, &scene, &camera, &settings, SIZE);
        assert_eq!(never.frame.report.plan.section_planes, 0);
        let off = Arrangement { sections: vec![disabled], ..Arrangement::default() };
        let loaded = load(&mut r, &scene, &off);
        let plain = take(&mut r, &loaded, &camera, &settings);
        assert_eq!(never.frame.report.plan, plain.frame.report.plan);
        never.assert_same(&plain, pairs);
        // A plane beside the scene goes through other shaders to the same picture.
        let beside = through_the_middle(&scene, DVec3::X, 2.0, true);
        let mut loaded = load(&mut r, &scene, &Arrangement { sections: vec![beside], ..Arrangement::default() });
        let cut = take(&mut r, &loaded, &camera, &settings);
        assert_eq!(cut.frame.report.plan.section_planes, 1);
        never.assert_same(&cut, &format!("{pairs}, a plane beside"));
        // And back again, from a cut with caps.
        let middle = through_the_middle(&scene, DVec3::X, 0.0, true);
        let arrangement = Arrangement { sections: vec![middle; 6], ..Arrangement::default() };
        r.arrange(&mut loaded, &scene, &arrangement).expect("an arrangement");
        assert_ne!(never.bits(), take(&mut r, &loaded, &camera, &settings).bits());
        r.arrange(&mut loaded, &scene, &Arrangement::default()).expect("an arrangement");
        never.assert_same(&take(&mut r, &loaded, &camera, &settings), &format!("{pairs}, back again"));
    }
}

#[test]
fn a_cap_belongs_to_the_part_that_it_closes() {
    let Some(mut r) = renderer() else { return };
    let scene = builtin::build("stack").expect("a scene");
    let camera = front(&scene, true);
    let middle = scene.bounds().center();
    let sections = vec![section(DVec3::Z, middle.z + scene.origin.z, true)];
    let mut arrangement = Arrangement { sections, ..Arrangement::default() };
    let loaded = load(&mut r, &scene, &arrangement);
    let mut twin = r.load(&scene).expect("a scene");
    let told = r.arrange(&mut twin, &scene, &arrangement).expect("a report");
    assert_eq!((told.caps, told.notices.len()), (loaded.cut.caps.len(), 0));
    let settings = Settings::default();
    let layers = r.pick(&loaded, &camera, &settings, SIZE, [36, 28]).expect("layers");
    let parts = scene.parts.len() as u32;
    assert!(!layers.is_empty() && layers.iter().all(|l| l.part < parts), "{layers:?}");
    let caps: Vec<_> = layers.iter().filter(|l| (l.position.z - middle.z).abs() < 1e-5).collect();
    let owners: BTreeSet<u32> = caps.iter().map(|l| l.part).collect();
    assert!(owners.len() == caps.len() && !caps.is_empty(), "{caps:?}");
    assert!(caps.iter().all(|l| l.normal.distance(DVec3::Z) < 1e-3));
    // Its looks are its owner's.
    let ghosted = pellucid::scene::Presence::Ghosted;
    for part in 0..parts {
        arrangement.parts.insert(part, PartLook { presence: ghosted, ..PartLook::default() });
    }
    let faded = load(&mut r, &scene, &arrangement);
    let again = r.pick(&faded, &camera, &settings, SIZE, [36, 28]).expect("layers");
    let ghost = settings.opacity.ghost as f32;
    assert!(layers.iter().zip(&again).all(|(a, b)| b.opacity == a.opacity * ghost && a.part == b.part));
    // The outline goes around what is left.
    arrangement.selected = BTreeSet::from([caps[0].part]);
    let selected = load(&mut r, &scene, &arrangement);
    assert!(take(&mut r, &selected, &camera, &settings).frame.report.plan.runs(Pass::Outline));
}

#[test]
fn a_cut_has_no_rims_but_the_border_of_its_cap() {
    let Some(mut r) = renderer() else { return };
    let scene = builtin::build("sphere").expect("a scene");
    let camera = front(&scene, false);
    let cut =
        |caps| Arrangement { sections: vec![section(DVec3::new(0.3, 0.8, 0.2), 0.1, caps)], ..Arrangement::default() };
    let rims = |r: &mut Renderer, arrangement: &Arrangement, of: &dyn Fn(u32) -> bool| {
        let loaded = load(r, &scene, arrangement);
        let shot = take(r, &loaded, &camera, &Settings::default());
        let s = &shot.store;
        (0..s.links.len()).filter(|&i| of(s.layers.part[i]) && s.links[i].contains(&Link::Missing)).count()
    };
    let whole = rims(&mut r, &Arrangement::default(), &|_| true);
    let open = rims(&mut r, &cut(false), &|_| true);
    let (surface, cap) = (rims(&mut r, &cut(true), &|p| p == 0), rims(&mut r, &cut(true), &|p| p == 1));
    assert!(open < whole && open > whole / 4, "{open} of {whole}");
    assert_eq!(open, surface);
    assert!(cap > 40, "the cap has {cap} rims");
}

#[test]
fn the_windows_plan_is_the_renderers() {
    use pellucid::app::config::Preferences;
    use pellucid::app::document::{Document, Seen};
    use pellucid::app::workspace::Workspace;
    use std::sync::Arc;

    let Some(mut r) = renderer() else { return };
    let scene = Arc::new(builtin::build("hard/assembly?seed=3").expect("a scene"));
    let middle = through_the_middle(&scene, DVec3::X, 0.0, true);
    let off = Section { enabled: false, ..through_the_middle(&scene, DVec3::Y, 0.0, true) };
    let hidden = PartLook { presence: pellucid::scene::Presence::Hidden, ..PartLook::default() };
    let mut workspace = Workspace::new(Preferences::default());
    workspace.capabilities = Some(r.gpu().capabilities().clone());
    workspace.viewport.size = SIZE;
    for (what, sections, hides) in [
        ("none", vec![], false),
        ("one plane twice, and one that is off", vec![middle, middle, off], false),
        ("open", vec![Section { caps: false, ..middle }], false),
        ("beside the scene", vec![through_the_middle(&scene, DVec3::X, 2.0, true)], false),
        ("with a hidden part", vec![middle, through_the_middle(&scene, DVec3::Z, 0.1, true)], true),
    ] {
        let mut arrangement = Arrangement { sections, ..Arrangement::default() };
        if hides {
            arrangement.parts.insert(0, hidden);
        }
        for pairs in ["", "kind=bkb k=5", "model=opaque"] {
            let (camera, settings) = (camera(&scene, false), settings(pairs));
            let loaded = load(&mut r, &scene, &arrangement);
            let expected = r.plan(&loaded, &camera, &settings, SIZE).expect("a plan");
            let seen = Seen { settings, camera, arrangement: arrangement.clone() };
            workspace.document = Some(Document::new(String::new(), Arc::clone(&scene), seen));
            workspace.replan();
            assert_eq!(workspace.plan, Some(Ok(expected)), "{what}, {pairs}");
        }
    }
}
