//! The traps that all papers share: T26 blending, T29 broken and extreme geometry, T30 small gaps in large scenes, T31
//! tessellation.

use std::f64::consts::TAU;

use glam::{DMat4, DVec2, DVec3, Vec3};
use pellucid::math::color::{linear_from_srgb, srgb_from_linear};
use pellucid::math::{Camera, Projection};
use pellucid::oracle::{Link, composite, rasterize};
use pellucid::render::Renderer;
use pellucid::scene::builtin::hard::bent::{banded_cylinder, unequal};
use pellucid::scene::{AlphaMode, Material, Mesh, Node, Primitive, Scene};

use crate::captures::scaled;
use crate::common::*;
use crate::meshes::{self, Random};

fn lively_draw(r: &mut Renderer, scene: &Scene, camera: &Camera, pairs: &str, size: [u32; 2]) -> Shot {
    draw(r, scene, camera, &with_transfer(settings(pairs), lively()), size)
}

#[test]
fn t26_faint_layers_do_not_vanish_and_both_directions_agree() {
    let Some(mut r) = renderer() else { return };
    // 32 layers of 1 % each: 8-bit intermediates lose them.
    let mut scene = meshes::stack(32, 0.03, |_| 0);
    scene.materials[0] = Material { unlit: true, ..meshes::material([0.02, 0.3, 0.9, 1.0], 0.0, 1.0) };
    let camera = front(&scene, true);
    for capture in ["kind=compacted", "kind=bkb k=32", "kind=bkb k=32 key=packed32"] {
        let shot =
            draw(&mut r, &scene, &camera, &settings(&format!("{capture} model=constant constant=0.01")), [16, 16]);
        let layers = &shot.store.layers;
        let colors: Vec<[f64; 4]> = shot
            .store
            .lit
            .iter()
            .map(|c| [f64::from(c[0]), f64::from(c[1]), f64::from(c[2]), 0.01 * f64::from(c[3])])
            .collect();
        let forth = composite::front_to_back(layers, &colors, None);
        let back = composite::back_to_front(layers, &colors, None);
        let covered = layers.counts.iter().position(|&c| c == 32).expect("a pixel with all layers");
        let mut worst = 0.0_f64;
        for ((f, a), b) in shot.frame.image.pixels.iter().zip(&forth).zip(&back) {
            for c in 0..4 {
                worst = worst.max((f64::from(f[c]) - a[c]).abs());
                assert!((a[c] - b[c]).abs() < 1e-14);
            }
        }
        // The same with sums rounded to 8 bits after every layer.
        let mut eight = [0.0_f64; 4];
        let mut through = 1.0;
        for i in layers.range(covered) {
            for c in 0..4 {
                let add = if c < 3 { colors[i][c] } else { 1.0 } * 0.01 * through;
                eight[c] = ((eight[c] + add) * 255.0).round() / 255.0;
            }
            through *= 0.99;
        }
        let lost = (eight[1] - forth[covered][1]).abs() / forth[covered][1];
        println!("{capture}: differs from f64 by {worst:.1e}; 8-bit sums lose {:.0} % of green", 100.0 * lost);
        assert!(worst < 2e-6 && (forth[covered][3] - (1.0 - 0.99_f64.powi(32))).abs() < 1e-5);
        assert!(lost > 0.3);
    }
    // The paper's RGBA8 holds sRGB: dark colours keep their steps, which linear 8 bits would not.
    let mut random = Random::new(26);
    let mut scene = meshes::parts(
        (0..24)
            .map(|i| meshes::moved(meshes::square(0.5, 0.0), DVec3::new(f64::from(i % 6), f64::from(i / 6), 0.0)))
            .collect(),
    );
    scene.materials = (0..24)
        .map(|_| {
            let c = [0; 3].map(|_| linear_from_srgb(random.unit() * 0.3) as f32);
            Material { unlit: true, ..meshes::material([c[0], c[1], c[2], 1.0], 0.0, 1.0) }
        })
        .collect();
    for (i, mesh) in scene.meshes.iter_mut().enumerate() {
        mesh.primitives[0].material = i;
    }
    let (mut stored, mut linear) = (0.0_f64, 0.0_f64);
    let store =
        draw(&mut r, &scene, &front(&scene, true), &settings("kind=bkb k=2 key=packed32 model=constant"), [32, 32])
            .store
            .layers;
    assert!(store.len() > 300);
    for i in 0..store.len() {
        for c in 0..3 {
            let exact = f64::from(scene.materials[store.part[i] as usize].base_color[c]);
            let off = |v: f64| 255.0 * (srgb_from_linear(v) - srgb_from_linear(exact)).abs();
            stored = stored.max(off(f64::from(store.base_color[i][c])));
            linear = linear.max(off((exact * 255.0).round() / 255.0));
        }
    }
    println!("RGBA8: off by at most {stored:.2}/255 as sRGB, linear would be by {linear:.1}/255");
    assert!(stored < 0.51 && linear > 4.0);
}

#[test]
fn t29_degenerate_triangles_and_broken_numbers() {
    let Some(mut r) = renderer() else { return };
    let ball = meshes::sphere(1.0, 24, 12);
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let mut broken = Primitive::default();
    let bad = [
        [nan; 3],
        [inf, 0.0, 0.0],
        [0.0, -inf, nan],
        [3e38, -3e38, 3e38],
        [0.1, 0.2, 0.3],
        [0.2, 0.2, 0.3],
        [0.3, 0.2, 0.3],
    ];
    let normals =
        [[nan; 3], [0.0; 3], [inf, 0.0, 0.0], [1e-30, 0.0, 0.0], [0.0, 0.0, 1.0], [3e38; 3], [-1.0, 0.0, 0.0]];
    for i in 0..bad.len() as u32 {
        for j in 0..bad.len() as u32 {
            for k in 0..bad.len() as u32 {
                broken.triangles.push([i, j, k]);
            }
        }
    }
    broken.positions.extend(bad);
    broken.normals.extend(normals);
    let mut odd = ball.clone();
    odd.normals.iter_mut().enumerate().for_each(|(i, n)| *n = normals[i % 7]);
    let scenes = [
        (
            "no area",
            meshes::parts(vec![
                ball.clone(),
                Primitive { triangles: vec![[0, 0, 1], [2, 2, 2], [0, 1, 0]], ..ball.clone() },
            ]),
        ),
        ("broken normals", meshes::parts(vec![odd, ball.clone()])),
        ("broken positions", meshes::parts(vec![broken, ball.clone()])),
        ("nothing", Scene::default().finish().expect("an empty scene")),
        (
            "one point",
            meshes::parts(vec![Primitive {
                positions: vec![[1.0; 3]; 3],
                normals: vec![[0.0, 0.0, 1.0]; 3],
                triangles: vec![[0, 1, 2]],
                ..Primitive::default()
            }]),
        ),
        (
            "flattened",
            meshes::scene(
                meshes::grey(),
                vec![meshes::mesh("", ball.clone())],
                vec![(0, DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0))), (0, DMat4::from_scale(DVec3::ZERO))],
            ),
        ),
    ];
    for (name, scene) in &scenes {
        for orthographic in [false, true] {
            for row in [
                "unit=part",
                "kind=bkb k=4 tail=average unit=part",
                "kind=bkb k=4 key=packed32 curvature=view_centred",
                "model=opaque",
            ] {
                for size in [[33, 20], [1, 1], [1, 40]] {
                    let shot = lively_draw(&mut r, scene, &camera(scene, orthographic), row, size);
                    assert_finite(&shot, &format!("{name}, {row}"));
                }
            }
        }
    }
    // Triangles without area add nothing, and a broken normal is the triangle's own.
    let plain = lively_draw(
        &mut r,
        &meshes::parts(vec![ball.clone(), ball.clone()]),
        &camera(&scenes[0].1, false),
        "",
        [48, 48],
    );
    let alone = lively_draw(&mut r, &scenes[0].1, &camera(&scenes[0].1, false), "", [48, 48]);
    assert_eq!(plain.store.layers.len(), 2 * alone.store.layers.len());
    for orthographic in [false, true] {
        let mut degenerate = ball.clone();
        degenerate.normals.fill([0.0; 3]);
        let scene = meshes::parts(vec![degenerate]);
        let camera = front(&scene, orthographic);
        let store = draw(&mut r, &scene, &camera, &settings("model=constant"), [48, 48]).store.layers;
        let layers = rasterize(&scene, &camera, [48, 48], DVec2::ZERO);
        let mut worst = 0.0_f64;
        let mut compared = 0;
        for (pixel, expected) in layers.pixels.iter().enumerate().filter(|(_, p)| p.fragments.len() == 2) {
            for (i, f) in store.range(pixel).zip(&expected.fragments).filter(|(i, f)| store.triangle[*i] == f.triangle)
            {
                // Edge-on a plane is found less exactly from how depth changes over a pixel.
                if f.normal_in_view.dot(DVec3::Z) > 0.1 {
                    worst = worst.max((Vec3::from(store.normal[i]).as_dvec3() - f.normal_in_view).length());
                    compared += 1;
                }
            }
        }
        println!(
            "orthographic {orthographic}: without normals, off by {:.3}° from the triangle's own in {compared} fragments",
            worst.to_degrees()
        );
        assert!(compared > 800 && worst < 0.01);
    }
}

#[test]
fn t29_far_from_the_origin_and_extreme_sizes() {
    let Some(mut r) = renderer() else { return };
    let scene = meshes::assembly(29);
    let camera = camera(&scene, false);
    let size = [48, 48];
    let near = lively_draw(&mut r, &scene, &camera, "", size);
    let compare = |shot: &Shot, what: &str| {
        let beyond = near
            .frame
            .image
            .pixels
            .iter()
            .zip(&shot.frame.image.pixels)
            .filter(|(a, b)| (0..4).any(|c| (a[c] - b[c]).abs() > 1.0 / 255.0))
            .count();
        println!("{what}: {beyond} of {} pixels differ by more than 1/255", size[0] * size[1]);
        assert_finite(shot, what);
        assert!(beyond * 50 < near.frame.image.pixels.len(), "{what}: {beyond}");
    };
    let offset = DVec3::new(1e7, -2e7, 3e7);
    let mut far = scene.clone();
    for node in &mut far.nodes {
        node.parent_from_node = DMat4::from_translation(offset) * node.parent_from_node;
    }
    let far = far.finish().expect("the same scene");
    assert!((far.origin - offset).length() < 100.0, "re-based: {}", far.origin);
    let shift = offset - far.origin;
    let moved = Camera { position: camera.position + shift, focal_point: camera.focal_point + shift, ..camera };
    compare(&lively_draw(&mut r, &far, &moved, "", size), "offset by 1e7");
    for by in [1e-6, 1e6] {
        let (other, other_camera) = scaled(&scene, &camera, by);
        compare(&lively_draw(&mut r, &other, &other_camera, "", size), &format!("{by:e} times as large"));
        compare(
            &lively_draw(&mut r, &other, &other_camera, "kind=bkb k=30", size),
            &format!("{by:e} times as large, k-buffer"),
        );
    }
}

#[test]
fn t29_a_camera_inside_and_one_pixel() {
    let Some(mut r) = renderer() else { return };
    let scene = meshes::assembly(30);
    let size = [64, 48];
    let mut random = Random::new(3);
    for i in 0..if full() { 20 } else { 4 } {
        let position = random.point(1.0);
        let eye = Camera {
            position,
            focal_point: position + random.direction() * 0.7,
            view_up: DVec3::Y,
            projection: Projection::Perspective { fov_y: 1.2 },
        };
        let shot = lively_draw(&mut r, &scene, &eye, if i % 2 == 0 { "" } else { "kind=bkb k=20" }, size);
        assert_finite(&shot, "inside");
        let expected = rasterize(&scene, &eye, size, DVec2::ZERO);
        let (mut same, mut clear) = (0, 0);
        for (pixel, p) in expected.pixels.iter().enumerate().filter(|(_, p)| !p.ambiguous) {
            clear += 1;
            same += usize::from(shot.store.layers.counts[pixel] as usize == p.fragments.len());
        }
        println!(
            "camera inside: {same} of {clear} unambiguous pixels have the oracle's layers, near {:.4}",
            eye.frustum(&scene.bounds()).near
        );
        assert!(same == clear && clear > 1500);
        // One large triangle that reaches from behind the eye to far ahead.
        let floor = Primitive {
            positions: vec![[-50.0, -0.5, 60.0], [50.0, -0.5, 60.0], [0.0, -0.5, -90.0]],
            normals: vec![[0.0, 1.0, 0.0]; 3],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        let floor = meshes::parts(vec![floor]);
        let shot = lively_draw(&mut r, &floor, &eye, "", size);
        let expected = rasterize(&floor, &eye, size, DVec2::ZERO);
        let wrong = expected
            .pixels
            .iter()
            .enumerate()
            .filter(|(i, p)| !p.ambiguous && shot.store.layers.counts[*i] as usize != p.fragments.len())
            .count();
        assert_eq!(wrong, 0, "crossing the near plane");
        assert_finite(&shot, "crossing");
        let one = lively_draw(&mut r, &scene, &eye, "", [1, 1]);
        assert_finite(&one, "one pixel");
        assert!(one.store.links.iter().flatten().all(|l| *l == Link::Unknown));
    }
    let loaded = r.load(&scene).expect("upload");
    assert!(r.render(&loaded, &camera(&scene, false), &settings(""), [0, 4]).is_err(), "no pixels: refused");
}

#[test]
fn t30_gaps_of_a_millimetre_in_a_scene_of_a_kilometre() {
    let Some(mut r) = renderer() else { return };
    // Ten shells, 2 mm apart, each a part of its own, in a scene a kilometre across. Shells are numbered against depth,
    // so that a tie comes out in the wrong order.
    let shell = |z: f64| {
        meshes::grid(1, 1, |u, v| {
            let (x, y) = (8.0 * u - 4.0, 8.0 * v - 4.0);
            (DVec3::new(x, y, 0.3 * x + 0.2 * y + z), DVec3::Z)
        })
    };
    let mut primitives: Vec<Primitive> = (0..10).map(|_| shell(0.0)).collect();
    primitives.push(meshes::moved(meshes::square(1.0, 0.0), DVec3::new(300.0, 400.0, -500.0)));
    primitives.push(meshes::moved(meshes::square(1.0, 0.0), DVec3::new(-300.0, -400.0, 500.0)));
    let meshes_of =
        primitives.into_iter().map(|p| Mesh { name: String::new(), primitives: vec![p] }).collect::<Vec<_>>();
    let nodes = (0..12)
        .map(|i| {
            Node::root(
                "",
                Some(i),
                DMat4::from_translation(DVec3::Z * if i < 10 { -0.002 * (9.0 - i as f64) } else { 0.0 }),
            )
        })
        .collect();
    let scene =
        Scene { materials: meshes::grey(), meshes: meshes_of, nodes, ..Scene::default() }.finish().expect("small");
    let eye = Camera {
        position: DVec3::new(0.0, 0.0, 40.0),
        focal_point: DVec3::ZERO,
        view_up: DVec3::Y,
        projection: Projection::Perspective { fov_y: 0.25 },
    };
    let size = [64, 64];
    let expected = rasterize(&scene, &eye, size, DVec2::ZERO);
    let mut results = Vec::new();
    for row in [
        "kind=compacted",
        "kind=bkb k=12",
        "kind=bkb k=12 key=packed32 depth=linear",
        "kind=bkb k=12 key=packed32 depth=reversed",
    ] {
        let shot = draw(&mut r, &scene, &eye, &settings(&format!("model=constant {row}")), size);
        let store = &shot.store.layers;
        let (mut inversions, mut pairs) = (0, 0);
        for (pixel, p) in expected.pixels.iter().enumerate() {
            let rank = |part: u32| {
                p.fragments.iter().map(|f| (f.depth, f.part)).filter(|(_, other)| *other == part).map(|(d, _)| d).next()
            };
            let depths: Vec<f64> = store.range(pixel).filter_map(|i| rank(store.part[i])).collect();
            pairs += depths.len().saturating_sub(1);
            inversions += depths.windows(2).filter(|w| w[0] > w[1]).count();
        }
        let layers = shot.frame.report.layers;
        println!(
            "{row}: {inversions} of {pairs} neighbouring layers in the wrong order, {} of {} fragments merged",
            layers.merged, layers.rasterized
        );
        results.push((inversions as f64 / pairs as f64, layers));
    }
    assert!(results[0].0 == 0.0 && results[1].0 == 0.0, "32 bits keep the order");
    assert!(results[2].0 > 0.5, "16 linear bits of a kilometre are steps of 15 mm");
    assert!(results.iter().all(|(_, l)| l.balanced()));
}

#[test]
fn t31_tessellation_fades_with_the_radius_and_edges_stay() {
    let Some(mut r) = renderer() else { return };
    let size = [128, 128];
    let sums = |r: &mut Renderer, scene: &Scene, radius: f64| {
        let row = format!("radius={radius} unit=world scale=0.05 line=0");
        let shot = lively_draw(r, scene, &front(scene, true), &row, size);
        let layers = &shot.store.layers;
        let pixel_of = layers.pixel_of_fragment();
        let mut sums: Vec<f64> = (0..layers.len())
            .filter(|&i| layers.side[i] && layers.normal[i][2] > 0.5 && layers.xy(pixel_of[i]).1.abs_diff(64) < 20)
            .map(|i| -f64::from(shot.store.kappa[i]).atanh() / 0.05)
            .collect();
        assert!(sums.len() > 500);
        let median = percentile(&mut sums, 0.5);
        (percentile(&mut sums, 0.9) - percentile(&mut sums, 0.1), median)
    };
    let mut spreads = Vec::new();
    for facets in [24, 48, 96] {
        let scene = meshes::parts(vec![banded_cylinder(&unequal(facets))]);
        let found: Vec<(f64, f64)> = [0.0, 0.02, 0.05].map(|radius| sums(&mut r, &scene, radius)).to_vec();
        println!(
            "{facets} unequal facets: spread of the curvature (1 on the smooth one) {:.3} with radius 0, {:.3} with 0.02, {:.3} with 0.05; median {:.3}",
            found[0].0, found[1].0, found[2].0, found[2].1
        );
        // A radius smaller than a facet cannot average facets.
        assert!(found[2].0 < 0.75 * found[0].0, "{facets}: {found:?}");
        assert!((found[2].1 - 1.0).abs() < 0.15, "{facets}: {found:?}");
        spreads.push(found[2].0);
    }
    assert!(spreads[2] < 0.5 * spreads[0], "{spreads:?}");
    // A true edge stays as sharp whatever the radius: where the box's edge is drawn, in pixels.
    let cube = meshes::parts(vec![meshes::cuboid(DVec3::ONE)]);
    let eye = Camera::framing(&cube.bounds(), DVec3::new(-1.0, -0.2, -1.3), DVec3::Y, 1.0, 0.9, true, 0.6);
    for radius in [0.0, 0.02, 0.05] {
        let shot = lively_draw(&mut r, &cube, &eye, &format!("radius={radius} line=0.0"), size);
        let layers = &shot.store.layers;
        let row: Vec<f32> = (0..size[0] as usize)
            .filter_map(|x| layers.range(70 * 128 + x).next().map(|i| shot.store.kappa[i]))
            .collect();
        let inner = &row[3..row.len() - 3];
        let sharp = inner.iter().filter(|k| **k < -0.5).count();
        let flat = inner.iter().filter(|k| k.abs() < 0.02).count();
        println!("edge of a box, radius {radius}: {sharp} pixels of it, {flat} of {} flat", inner.len());
        assert!((1..=3).contains(&sharp) && sharp + flat >= inner.len() - 1, "{inner:?}");
    }
    // Flat-shaded facets that meet under the crease angle: no spikes.
    let mut flat = Primitive::default();
    for facet in 0..36 {
        let angle = |i: i32| TAU * f64::from(i) / 36.0;
        let n = DVec3::new(angle(facet).mul_add(1.0, TAU / 72.0).sin(), 0.0, (angle(facet) + TAU / 72.0).cos());
        let piece = meshes::cylinder_at(1.0, 1.5, &[angle(facet), angle(facet + 1)]);
        meshes::append(&mut flat, &Primitive { normals: vec![n.as_vec3().to_array(); 4], ..piece });
    }
    let flat = meshes::parts(vec![flat]);
    let largest = |r: &mut Renderer, row: &str| {
        let shot =
            lively_draw(r, &flat, &front(&flat, true), &format!("unit=world scale=0.05 line=0 {row}"), [224, 224]);
        let layers = &shot.store.layers;
        let mut sums: Vec<f64> = (0..layers.len())
            .filter(|&i| layers.side[i] && layers.normal[i][2] > 0.5 && !shot.store.links[i].contains(&Link::Missing))
            .map(|i| (f64::from(shot.store.kappa[i]).clamp(-0.999_999, 0.999_999)).atanh().abs() / 0.05)
            .collect();
        percentile(&mut sums, 1.0)
    };
    let (printed, crease, ours) =
        (largest(&mut r, "radius=0 crease=180"), largest(&mut r, "radius=0 crease=5"), largest(&mut r, "radius=0.05"));
    println!(
        "flat-shaded, 36 facets of 10°: largest curvature {printed:.1} as printed, {crease:.1} where each is a crease, {ours:.2} with a radius (1 on the smooth one)"
    );
    assert!(printed > 3.0 && crease > 3.0 && ours < 2.0 && ours < 0.4 * printed);
}

#[test]
fn materials_with_holes_have_no_fragments_there() {
    let Some(mut r) = renderer() else { return };
    let scene = meshes::assembly(1);
    let masked = scene.materials.iter().filter(|m| matches!(m.alpha_mode, AlphaMode::Mask { .. })).count();
    assert_eq!(masked, 1);
    let part = scene.parts.iter().position(|p| scene.meshes[p.mesh].name == "holes").expect("the part") as u32;
    let camera = camera(&scene, true);
    let mut solid = scene.clone();
    solid.materials.iter_mut().for_each(|m| m.alpha_mode = AlphaMode::Opaque);
    let count = |r: &mut Renderer, scene: &Scene, row: &str| {
        let store = draw(r, scene, &camera, &settings(&format!("model=constant constant=0.5 {row}")), [64, 64]).store;
        store.layers.part.iter().filter(|p| **p == part).count()
    };
    for row in ["kind=compacted", "kind=bkb k=30"] {
        let (with, without) = (count(&mut r, &scene, row), count(&mut r, &solid, row));
        assert!(with < without && with > without / 2, "{row}: {with} of {without}");
    }
}
