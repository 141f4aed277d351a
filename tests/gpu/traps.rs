//! The traps of the Bucketed k-Buffer paper, T1 to T11. Where the paper's own format or formula must fail, the test shows
//! that it does, through the same shaders, with the figure; and that ours does not.

use std::collections::HashSet;

use glam::{DMat4, DVec2, DVec3, Vec3};
use pellucid::gpu::shader_files;
use pellucid::math::{Camera, Projection};
use pellucid::oracle::buckets::Bucket;
use pellucid::oracle::{Link, WideKey, bucket_k_buffer, rasterize};
use pellucid::plan::Refusal;
use pellucid::render::{DrawOrder, RenderError, Renderer};
use pellucid::scene::builtin::hard::bent::loose_saddle;
use pellucid::scene::builtin::hard::deep::tilted_pair;
use pellucid::scene::{Primitive, Scene};

use crate::captures::{scaled, with_far_part};
use crate::common::*;
use crate::meshes::{self, Random};

/// Draws with a changed shader module.
fn draw_changed(
    r: &mut Renderer,
    change: (&'static str, &'static str, &'static str),
    scene: &Scene,
    camera: &Camera,
    pairs: &str,
    size: [u32; 2],
) -> Shot {
    r.replace_shader(change.0, Some(changed(change.0, change.1, change.2)));
    let shot = draw(r, scene, camera, &with_transfer(settings(pairs), lively()), size);
    r.replace_shader(change.0, None);
    shot
}

fn ours(r: &mut Renderer, scene: &Scene, camera: &Camera, pairs: &str, size: [u32; 2]) -> Shot {
    draw(r, scene, camera, &with_transfer(settings(pairs), lively()), size)
}

#[test]
fn t01_equal_keys_lose_a_fragment_and_wide_keys_have_none() {
    let Some(mut r) = renderer() else { return };
    // Two faces of one part in one place.
    let scene = meshes::stack(2, 0.0, |_| 0);
    let camera = front(&scene, false);
    let packed = draw(&mut r, &scene, &camera, &settings("kind=bkb k=8 key=packed32 model=constant"), [32, 32])
        .frame
        .report
        .layers;
    println!("packed: {} of {} fragments lost to an equal key", packed.merged, packed.rasterized);
    assert_eq!(packed.merged * 2, packed.rasterized);
    assert_eq!(packed.stored * 2, packed.rasterized);
    let mut images = HashSet::new();
    for order in [DrawOrder::FrontToBack, DrawOrder::Shuffled(1), DrawOrder::Shuffled(2)] {
        r.draw_order = order;
        let wide = draw(&mut r, &scene, &camera, &settings("kind=bkb k=8 model=constant"), [32, 32]);
        let layers = wide.frame.report.layers;
        assert_eq!((layers.merged, layers.dropped, layers.stored), (0, 0, layers.rasterized));
        for pixel in 0..wide.store.layers.counts.len() {
            let range = wide.store.layers.range(pixel);
            assert!(range.len() == 2 || range.is_empty(), "both faces are there");
            assert!(wide.store.layers.triangle[range].is_sorted(), "by triangle where depth is equal");
        }
        images.insert(wide.bits());
    }
    r.draw_order = DrawOrder::default();
    assert_eq!(images.len(), 1);
}

#[test]
fn t02_sixteen_bits_of_depth_are_not_enough() {
    let Some(mut r) = renderer() else { return };
    let size = [96, 96];
    // Both squares and a marker that sets the scene's depth range.
    for (share, expected) in [(1e-5, 0.34), (1e-6, 0.93)] {
        let scene_of = |gap: f64| meshes::parts(vec![tilted_pair(gap, 1.0, DVec3::ZERO), meshes::sphere(0.1, 8, 4)]);
        let range = 2.0 * scene_of(0.0).bounds().bounding_sphere().radius;
        let scene = scene_of(share * range);
        let camera = front(&scene, true);
        let packed = draw(&mut r, &scene, &camera, &settings("kind=bkb k=8 key=packed32 model=constant"), size)
            .frame
            .report
            .layers;
        let shot = draw(&mut r, &scene, &camera, &settings("kind=bkb k=8 model=constant"), size);
        let pairs = (0..shot.store.layers.counts.len())
            .filter(|&p| shot.store.layers.range(p).filter(|&i| shot.store.layers.part[i] == 0).count() == 2)
            .count();
        let merged = packed.merged as f64 / pairs as f64;
        println!(
            "{share:e} of the range apart: {:.1} % share a packed key (by calculation {:.0} %)",
            100.0 * merged,
            100.0 * expected
        );
        assert!((merged - expected).abs() < 0.04);
        assert_eq!(shot.frame.report.layers.merged, 0);
        assert_eq!(shot.frame.report.layers.stored, shot.frame.report.layers.rasterized);
    }
    // Near 0.1, far 1000: which depth the 16 bits hold decides.
    let scene = meshes::parts(vec![
        tilted_pair(1.0, 12.0, DVec3::new(0.0, 0.0, -900.0)),
        meshes::moved(meshes::square(0.01, 0.0), DVec3::new(0.0, 0.2, -0.5)),
        meshes::moved(meshes::square(1.0, 0.0), DVec3::new(0.0, 200.0, -1000.0)),
    ]);
    let camera = Camera {
        position: DVec3::ZERO,
        focal_point: DVec3::new(0.0, 0.0, -900.0),
        view_up: DVec3::Y,
        projection: Projection::Perspective { fov_y: 0.025 },
    };
    let mut shares = Vec::new();
    for row in ["key=packed32 depth=linear", "key=packed32 depth=z_over_w", "key=packed32 depth=reversed", "key=wide64"]
    {
        let layers = draw(&mut r, &scene, &camera, &settings(&format!("kind=bkb k=4 model=constant {row}")), size)
            .frame
            .report
            .layers;
        let share = 2.0 * layers.merged as f64 / layers.rasterized as f64;
        println!("1 apart at depth 900 of 1000, {row}: {:.1} % of the pairs are one", 100.0 * share);
        shares.push(share);
    }
    assert!(shares[0] < 0.01 && shares[1] > 0.9 && shares[2] > 0.9 && shares[3] == 0.0);
}

#[test]
fn t03_a_fragment_without_a_slot_is_counted_as_lost() {
    let Some(mut r) = renderer() else { return };
    let scene = meshes::assembly(31);
    let camera = camera(&scene, false);
    for (row, module, from, to) in [
        // The data pass sees other depths than the insertion did: the last bit of some.
        (
            "k=24",
            "passes/capture/bucketed_k_buffer/search_key_wide64",
            "depth_key_of(v.position))",
            "depth_key_of(v.position) ^ u32(v.position.x < 20.0))",
        ),
        (
            "k=24 key=packed32",
            "passes/capture/bucketed_k_buffer/search_key_packed32",
            "packed_depth_of(v.position) << 16u",
            "(packed_depth_of(v.position) ^ u32(v.position.x < 20.0)) << 16u",
        ),
    ] {
        for rest in ["", "model=constant", "search=brute_force"] {
            let row = format!("kind=bkb {row} {rest}");
            let right = ours(&mut r, &scene, &camera, &row, [40, 40]).frame.report.layers;
            assert!(right.lost == 0 && right.balanced(), "{row}: {right:?}");
            let wrong = draw_changed(&mut r, (module, from, to), &scene, &camera, &row, [40, 40]).frame.report.layers;
            println!("{row}: {} of {} lost with a planted mismatch", wrong.lost, wrong.rasterized);
            assert!(wrong.lost > wrong.rasterized / 10 && !wrong.balanced());
        }
    }
    let vertices = shader_files().into_iter().filter(|(name, _)| name.starts_with("scene/vertex_"));
    for (name, text) in vertices {
        assert!(text.contains("@builtin(position) @invariant"), "{name}");
    }
}

#[test]
fn t04_shape_ids_and_k_beyond_the_format_are_refused() {
    let Some(mut r) = renderer() else { return };
    let triangle = meshes::soup(&mut Random::new(4), 1, 0.01, 0.03);
    let many = |n: u32| {
        let mut random = Random::new(9);
        let nodes = (0..n).map(|_| (0, DMat4::from_translation(random.point(1.0)))).collect();
        meshes::scene(meshes::grey(), vec![meshes::mesh("one", triangle.clone())], nodes)
    };
    let beyond = many(70_000);
    let camera = front(&beyond, false);
    let packed = settings("kind=bkb k=64 key=packed32");
    let loaded = r.load(&beyond).expect("upload");
    match r.render(&loaded, &camera, &packed, [16, 16]) {
        Err(RenderError::Refused(Refusal::TooManyParts { parts: 70_000 })) => {}
        other => panic!("{:?}", other.map(|f| f.report.layers)),
    }
    // The wide key numbers them all.
    let wide = draw(&mut r, &beyond, &camera, &settings("kind=compacted"), [48, 48]);
    assert!(wide.frame.report.layers.balanced());
    assert!(wide.store.layers.part.iter().any(|&p| p > 65_535), "parts beyond 16 bits");
    assert!(wide.store.layers.part.iter().zip(&wide.store.layers.triangle).all(|(p, t)| p == t), "one triangle a part");
    // The largest number of shapes still works, its last id included.
    let most = many(65_535);
    let shot = draw(&mut r, &most, &front(&most, false), &packed, [48, 48]);
    let layers = shot.frame.report.layers;
    println!("65 535 parts, packed: {layers:?}");
    assert!(layers.balanced() && layers.lost == 0 && layers.stored > 0);
    assert!(shot.store.layers.part.iter().all(|&p| p < 65_535));
    assert!(pellucid::settings::Settings::default().set("capture.bucketed_k_buffer.k", "256").is_err());
}

#[test]
fn t05_overflow_is_counted_and_the_tail_does_not_depend_on_order() {
    let Some(mut r) = renderer() else { return };
    let mut scene = meshes::stack(20, 0.1, |i| (i % 4) as usize);
    for (i, part) in scene.meshes.iter_mut().enumerate() {
        part.primitives[0].material = i;
    }
    scene.materials =
        (0..4).map(|i| meshes::material([0.2 + 0.2 * i as f32, 0.9 - 0.2 * i as f32, 0.5, 1.0], 0.0, 0.6)).collect();
    let camera = front(&scene, true);
    let size = [32, 32];
    for model in ["model=constant constant=0.1", ""] {
        let exact = ours(&mut r, &scene, &camera, &format!("{model} kind=compacted"), size);
        let cut = ours(&mut r, &scene, &camera, &format!("{model} kind=bkb k=4"), size);
        let tail = ours(&mut r, &scene, &camera, &format!("{model} kind=bkb k=4 tail=average"), size);
        for shot in [&cut, &tail] {
            let layers = shot.frame.report.layers;
            assert!(layers.balanced() && layers.dropped * 5 == layers.rasterized * 4, "{layers:?}");
        }
        let error = |shot: &Shot| {
            let differences = shot.frame.image.pixels.iter().zip(&exact.frame.image.pixels);
            let sum: f64 = differences.flat_map(|(a, b)| (0..4).map(|c| f64::from((a[c] - b[c]).abs()))).sum();
            sum / exact.frame.image.pixels.len() as f64 / 4.0
        };
        println!("{model}: mean error {:.4} without the tail, {:.4} with it", error(&cut), error(&tail));
        assert!(error(&tail) < 0.35 * error(&cut));
        for seed in 1..6 {
            r.draw_order = DrawOrder::Shuffled(seed);
            let loaded = r.load_shuffled(&scene, seed).expect("upload");
            let s = with_transfer(settings(&format!("{model} kind=bkb k=4 tail=average")), lively());
            let frame = r.render(&loaded, &camera, &s, size).expect("a frame");
            r.draw_order = DrawOrder::default();
            let bits: Vec<_> = frame.image.pixels.iter().map(|p| p.map(f32::to_bits)).collect();
            assert_first(&tail.bits(), &bits, &format!("{model}, order {seed}"));
            assert_eq!(frame.report.layers, tail.frame.report.layers);
        }
        // With enough layers there is no tail.
        let enough = ours(&mut r, &scene, &camera, &format!("{model} kind=bkb k=20 tail=average"), size);
        assert_first(&enough.bits(), &exact.bits(), "no tail");
    }
}

#[test]
fn t06_a_full_bucket_table_is_searched_to_its_end_and_no_further() {
    let Some(mut r) = renderer() else { return };
    // Eight parts whose home is the last of eight slots, so that every probe wraps around; and a ninth, which looks for
    // itself in full tables that do not have it.
    let k = 8;
    let mut scene = meshes::stack(8, 0.1, |i| (7 + 8 * i) as usize);
    scene.meshes[0].primitives[0] = meshes::moved(meshes::square(0.4, 0.0), DVec3::new(1.4, 0.0, 0.0));
    let scene = scene.finish().expect("a small scene");
    let camera =
        Camera { focal_point: DVec3::new(0.2, 0.0, 0.0), position: DVec3::new(0.2, 0.0, 6.0), ..front(&scene, false) };
    let shot = ours(&mut r, &scene, &camera, &format!("kind=bkb k={k}"), [40, 40]);
    let store = &shot.store;
    let mut full = 0;
    for pixel in 0..store.layers.counts.len() {
        let keys: Vec<WideKey> = store
            .layers
            .range(pixel)
            .map(|i| WideKey {
                depth: store.layers.depth_key[i],
                triangle: store.layers.triangle[i],
                part: store.layers.part[i],
            })
            .collect();
        if keys.is_empty() {
            continue;
        }
        let expected = bucket_k_buffer(&keys, k).table;
        let found: Vec<_> = store.buckets[pixel]
            .table
            .iter()
            .map(|s| s.map(|(shape, a, b)| Bucket { shape, first: a as usize, last: b as usize - 1 }))
            .collect();
        assert_eq!(found, expected);
        full += usize::from(found.iter().all(Option::is_some));
    }
    assert!(full > 100, "{full} pixels with k buckets");
    let absent = store.layers.part.iter().zip(&store.links).filter(|(p, l)| **p == 0 && l[1] == Link::Missing).count();
    assert!(absent > 3, "the ninth part ends beside full tables");
    println!("{full} full tables; {absent} searches in one for what it does not have");
    let brute = ours(&mut r, &scene, &camera, &format!("kind=bkb k={k} search=brute_force"), [40, 40]);
    shot.assert_same(&brute, "full tables");
}

/// Where sheets of a part begin in front of others, a layer's neighbour has another rank in its bucket: searches that hold
/// layers of the same rank against each other must go on beyond them.
#[test]
fn t04_neighbours_of_another_rank_are_found() {
    let Some(mut r) = renderer() else { return };
    let size = [8, 8];
    // Three sheets in front only on one side, three in the middle only on the other.
    let scene_of = |side: f64| {
        let mut sheets = Primitive::default();
        for i in 0..13_u32 {
            let shift = if i >= 10 { side } else { -side * f64::from(u8::from((4..7).contains(&i))) };
            let sheet = meshes::square(1.0, -0.5 + 0.07 * f64::from(i));
            meshes::append(&mut sheets, &meshes::moved(sheet, DVec3::X * shift));
        }
        meshes::parts(vec![sheets, meshes::square(1.0, 0.9)])
    };
    let camera = Camera { projection: Projection::Orthographic { height: 0.5 }, ..front(&scene_of(1.0), true) };
    let [a, b] = [-1.0, 1.0].map(|side| {
        let scene = scene_of(side);
        let shot = ours(&mut r, &scene, &camera, "", size);
        shot.assert_same(&ours(&mut r, &scene, &camera, "search=brute_force", size), "by rank and by brute force");
        (scene, shot)
    });
    let to = |pixel: usize, direction: usize| {
        let range = a.1.store.layers.range(pixel);
        a.1.store.links[range].iter().map(|l| l[direction]).collect::<Vec<_>>()
    };
    // Left of the middle, from the front: the other part, 12 to 10, 9 to 7, 3 to 0; right: the other part, 9 to 0.
    use Link::{Missing, To};
    let right: Vec<Link> = [To(0)].into_iter().chain([Missing; 3]).chain([1, 2, 3, 7, 8, 9, 10].map(To)).collect();
    let left: Vec<Link> = [0, 4, 5, 6].map(To).into_iter().chain([Missing; 3]).chain([7, 8, 9, 10].map(To)).collect();
    assert_eq!((to(8 * 4 + 3, 0), to(8 * 4 + 4, 1)), (right, left));
    let (pairs, left_open) = ("passes/features/links_by_buckets", "passes/features/links_left_open");
    for (module, from, into) in [
        (pairs, "let nothing_before = others.begin == others.bucket.first;", "let nothing_before = true;"),
        (pairs, "let nothing_after = others.begin + others.count == others.bucket.end;", "let nothing_after = true;"),
        (left_open, "insertBits(link, found,", "insertBits(link, UNKNOWN,"),
    ] {
        let change = (module, from, into);
        let seen = [&a, &b].map(|(scene, shot)| {
            draw_changed(&mut r, change, scene, &camera, "", size).store.links != shot.store.links
        });
        assert!(seen.contains(&true), "'{from}' became '{into}' and nothing changed");
    }
}

/// Long lists are sorted and searched whole up to the adapter's limit, and refused beyond: lavapipe ends all loops of an
/// invocation after 65 535 rounds together, without a word.
#[test]
fn t04_lists_are_whole_up_to_their_limit_and_refused_beyond() {
    let Some(mut r) = renderer() else { return };
    let size = [2, 2];
    let most = r.gpu().capabilities().most_layers;
    // Sheets of two parts in turn.
    let stack = |layers: u32| {
        let mut sheets = [Primitive::default(), Primitive::default()];
        for i in 0..layers {
            let z = -0.5 + f64::from(i) / f64::from(layers);
            meshes::append(&mut sheets[i as usize % 2], &meshes::square(1.0, z));
        }
        meshes::parts(sheets.into())
    };
    for layers in [100, 700, most.min(2048)] {
        let deep = stack(layers);
        let camera = Camera { projection: Projection::Orthographic { height: 1.0 }, ..front(&deep, true) };
        let shot = draw(&mut r, &deep, &camera, &settings("radius=0.05"), size);
        let store = &shot.store.layers;
        assert_eq!(store.counts, [layers; 4]);
        for pixel in 0..4 {
            let keys: HashSet<u32> = store.triangle[store.range(pixel)].iter().copied().collect();
            assert_eq!(keys.len(), layers as usize, "a layer is there twice");
            assert!(store.depth_key[store.range(pixel)].is_sorted());
            let links = &shot.store.links[store.range(pixel)];
            let (right, down) = (pixel % 2 == 0, pixel < 2);
            for (layer, links) in links.iter().enumerate() {
                let to = Link::To(layer as u32);
                let expected = [right, !right, down, !down].map(|inside| if inside { to } else { Link::Unknown });
                assert_eq!(*links, expected, "layer {layer} of {layers}, pixel {pixel}");
            }
        }
        let brute = draw(&mut r, &deep, &camera, &settings("radius=0.05 search=brute_force"), size);
        shot.assert_same(&brute, "buckets and brute force");
    }
    if most > 2048 {
        return;
    }
    let deeper = stack(most + 1);
    let camera = Camera { projection: Projection::Orthographic { height: 1.0 }, ..front(&deeper, true) };
    let scene = r.load(&deeper).unwrap();
    let refusal = r.render(&scene, &camera, &settings("model=constant"), size).unwrap_err();
    assert!(
        matches!(refusal, RenderError::PixelTooDeep { layers, limit } if (layers, limit) == (most + 1, most)),
        "{refusal}"
    );
    let keep = settings("model=constant kind=bkb k=16");
    let kept = r.render(&scene, &camera, &keep, size).unwrap().report.layers;
    assert_eq!((kept.stored, kept.dropped), (4 * 16, 4 * (u64::from(most) + 1 - 16)));
}

#[test]
fn t07_neighbours_do_not_depend_on_the_unit_of_length() {
    let Some(mut r) = renderer() else { return };
    let scene = meshes::soups(71, 3, 30);
    let camera = camera(&scene, false);
    let (large, large_camera) = scaled(&scene, &camera, 1000.0);
    let size = [64, 64];
    let links = |a: &Shot, b: &Shot| a.store.links.iter().zip(&b.store.links).filter(|(a, b)| a != b).count();
    let (a, b) = (ours(&mut r, &scene, &camera, "", size), ours(&mut r, &large, &large_camera, "", size));
    assert_eq!(a.store.layers.counts, b.store.layers.counts);
    let differing = links(&a, &b);
    let kappa = a.store.kappa.iter().zip(&b.store.kappa).zip(a.store.links.iter().zip(&b.store.links));
    let worst = kappa.filter(|(_, (a, b))| a == b).map(|((a, b), _)| (a - b).abs()).fold(0.0, f32::max);
    println!("times 1000: {differing} of {} links differ, kappa by {worst:e}", a.store.links.len());
    assert!(differing * 1000 <= a.store.links.len() && worst < 1e-3);
    // As printed, |Δz|² is not divided by the part's radius.
    let printed = ("passes/features/neighbour_epsilon", " * inverse_unit;", ";");
    let row = "features.depth_term=printed search=brute_force";
    let a = draw_changed(&mut r, printed, &scene, &camera, row, size);
    let b = draw_changed(&mut r, printed, &large, &large_camera, row, size);
    println!("times 1000, as printed: {} of {} links differ", links(&a, &b), a.store.links.len());
    assert!(links(&a, &b) * 50 > a.store.links.len());
    // Nor on a far part, which a division by the scene's radius would bring in.
    let far = with_far_part(&scene, DVec3::new(500.0, 300.0, -900.0));
    let (a, b) = (ours(&mut r, &scene, &camera, "", size), ours(&mut r, &far, &camera, "", size));
    assert_first(&a.store.links, &b.store.links, "far part");
}

#[test]
fn t08_curvature_stays_finite_at_grazing_angles() {
    let Some(mut r) = renderer() else { return };
    let scene = meshes::parts(vec![meshes::sphere(1.0, 160, 80)]);
    let camera = front(&scene, true);
    let size = [128, 128];
    let sums = |r: &mut Renderer, kind: &str| {
        let shot = ours(
            r,
            &scene,
            &camera,
            &format!("curvature={kind} unit=world scale=0.004 radius=0 line=0 crease=180"),
            size,
        );
        assert_finite(&shot, kind);
        let layers = &shot.store.layers;
        let mut sums: Vec<f64> = (0..layers.len())
            .filter(|&i| {
                layers.side[i]
                    && (f64::from(layers.normal[i][2]) - 0.3).abs() < 0.02
                    && !shot.store.links[i].contains(&Link::Missing)
            })
            .map(|i| -f64::from(shot.store.kappa[i]).atanh() / 0.004)
            .collect();
        assert!(sums.len() > 50);
        percentile(&mut sums, 0.5)
    };
    let (surface, view_centred) = (sums(&mut r, "surface"), sums(&mut r, "view_centred"));
    println!(
        "sphere of radius 1 at n·v = 0.3: surface {surface:.3} (2 by calculation), view-centred {view_centred:.2}, {:.1} times",
        view_centred / surface
    );
    assert!((surface - 2.0).abs() < 0.04 && view_centred > 12.0 * surface);
    // The largest sensitivity, on surfaces seen edge-on and on loose triangles.
    for scene in [scene.clone(), meshes::soups(81, 4, 40), meshes::assembly(8)] {
        for kind in ["surface", "view_centred"] {
            let shot =
                ours(&mut r, &scene, &camera, &format!("curvature={kind} unit=scene scale=1000 radius=0.05"), [48, 48]);
            assert_finite(&shot, kind);
        }
    }
}

#[test]
fn t09_octahedral_normals_are_far_more_exact_than_the_printed_ones() {
    let Some(mut r) = renderer() else { return };
    // Squares that face the viewer, each with one normal anywhere on the viewer's side: interpolation adds no error.
    let mut random = Random::new(90);
    let mut all = Primitive::default();
    for i in 0..1600 {
        let (x, y) = (f64::from(i % 40), f64::from(i / 40));
        let mut normal = random.direction();
        // Half of them at grazing angles.
        normal.z = normal.z.abs() * if i % 2 == 0 { 1.0 } else { 0.02 } + 0.002;
        let normal = normal.normalize();
        meshes::append(&mut all, &meshes::grid(1, 1, |u, v| (DVec3::new(x + 0.9 * u, y + 0.9 * v, 0.0), normal)));
    }
    let scene = meshes::parts(vec![all]);
    let camera = front(&scene, true);
    let size = [128, 128];
    let layers = rasterize(&scene, &camera, size, DVec2::ZERO);
    let mut worst = |row: &str| {
        let store = draw(&mut r, &scene, &camera, &settings(&format!("model=constant {row}")), size).store.layers;
        let mut worst = 0.0_f64;
        for (pixel, expected) in layers.pixels.iter().enumerate().filter(|(_, p)| !p.ambiguous) {
            for (i, f) in store.range(pixel).zip(&expected.fragments) {
                let n = Vec3::from(store.normal[i]).as_dvec3().normalize();
                worst = worst.max((n - f.normal_in_view).length().to_degrees());
            }
        }
        worst
    };
    let (printed, octahedral) = (worst("normals=xy15"), worst("normals=octahedral"));
    println!("worst normal: as printed {printed:.3}°, octahedral {octahedral:.4}°");
    assert!(printed > 0.25 && printed < 0.6 && octahedral < 0.006 && printed > 50.0 * octahedral);
}

#[test]
fn t10_unknown_neighbours_make_no_silhouette() {
    let Some(mut r) = renderer() else { return };
    let size = [48, 48];
    // A sphere that is larger than the image: no rim anywhere.
    let scene = meshes::parts(vec![meshes::sphere(1.0, 64, 32)]);
    let camera = Camera { projection: Projection::Orthographic { height: 0.5 }, ..front(&scene, true) };
    let row = "radius=0.02 line=0.02 scale=0.01";
    let shot = ours(&mut r, &scene, &camera, row, size);
    let rims = |shot: &Shot| shot.store.kappa.iter().filter(|k| **k < -0.9).count();
    assert!(shot.store.links.iter().flatten().all(|l| *l != Link::Missing));
    assert!(shot.store.links.iter().flatten().any(|l| *l == Link::Unknown));
    assert_eq!(rims(&shot), 0);
    let printed = ("passes/features/candidates_brute_force", "return UNKNOWN;", "return MISSING;");
    let brute = format!("{row} search=brute_force");
    let border = rims(&draw_changed(&mut r, printed, &scene, &camera, &brute, size));
    println!("a border of {border} fragments where beyond the image counts as missing, none where it is unknown");
    assert!(border > 100);
    // Where k ran out. Two steep sheets of one part cross: in the next pixel another one may be the nearest.
    let scene = meshes::soups(101, 2, 60);
    let camera = crate::common::camera(&scene, false);
    let exact = ours(&mut r, &scene, &camera, "line=0", size);
    let cut = ours(&mut r, &scene, &camera, "line=0 kind=bkb k=2", size);
    let missing = |shot: &Shot, pixel: usize, layer: usize, d: usize| {
        let range = shot.store.layers.range(pixel);
        shot.store.links[range.start + layer][d] == Link::Missing
    };
    let (mut false_rims, mut unknown) = (0, 0);
    for pixel in 0..cut.store.layers.counts.len() {
        for layer in 0..cut.store.layers.counts[pixel] as usize {
            for d in 0..4 {
                let i = cut.store.layers.range(pixel).start + layer;
                unknown += usize::from(cut.store.links[i][d] == Link::Unknown);
                // With the whole lists there is a neighbour: a rim here is one that k has made.
                false_rims += usize::from(missing(&cut, pixel, layer, d) && !missing(&exact, pixel, layer, d));
            }
        }
    }
    println!("k = 2: {unknown} unknown, {false_rims} false rims of {} links", 4 * cut.store.links.len());
    assert!(unknown > 500 && false_rims * 200 < 4 * cut.store.links.len());
    // A real silhouette is as convex as can be, in both captures.
    let scene = meshes::parts(vec![meshes::sphere(1.0, 64, 32)]);
    for row in ["kind=compacted", "kind=bkb k=2"] {
        let shot = ours(&mut r, &scene, &front(&scene, true), row, size);
        let rim = shot.store.links.iter().zip(&shot.store.kappa).filter(|(l, _)| l.contains(&Link::Missing));
        let kappas: Vec<f32> = rim.map(|(_, k)| *k).collect();
        assert!(kappas.len() > 100 && kappas.iter().all(|k| *k == -1.0), "{row}");
    }
}

#[test]
fn t11_inconsistent_winding_does_not_split_a_surface() {
    let Some(mut r) = renderer() else { return };
    let mut tidy = meshes::parts(vec![meshes::saddle(0.8, 1.0, 20)]);
    let random = |i: usize| {
        let mut r = Random::new(i as u64);
        (r.unit() < 0.5, r.unit() < 0.5)
    };
    tidy.meshes[0].primitives[0] = loose_saddle(|_| (false, false));
    let mut untidy = tidy.clone();
    untidy.meshes[0].primitives[0] = loose_saddle(random);
    let mut mirrored = tidy.clone();
    // The same surface from a mirrored node over mirrored geometry.
    let geometry = &mut mirrored.meshes[0].primitives[0];
    geometry.positions.iter_mut().chain(&mut geometry.normals).for_each(|p| p[0] = -p[0]);
    mirrored.nodes[0].parent_from_node = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let mirrored = mirrored.finish().expect("a small scene");
    let camera = camera(&tidy, false);
    let size = [64, 64];
    let expected = ours(&mut r, &tidy, &camera, "radius=0.03", size);
    for (name, scene) in [("turned triangles", untidy), ("mirrored node", mirrored)] {
        let found = ours(&mut r, &scene, &camera, "radius=0.03", size);
        assert_eq!(found.store.layers.counts, expected.store.layers.counts, "{name}");
        assert_first(&found.store.links, &expected.store.links, &format!("{name}: links"));
        let worst = found.store.kappa.iter().zip(&expected.store.kappa).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        println!("{name}: kappa differs by {worst:e}");
        assert!(worst < 1e-3);
        let sides = found.store.layers.side.iter().filter(|s| **s).count() as f64 / found.store.layers.len() as f64;
        println!("{name}: {:.0} % of the fragments show their outer side", 100.0 * sides);
        if name == "mirrored node" {
            assert_eq!(found.store.layers.side, expected.store.layers.side);
        } else {
            assert!(sides > 0.3 && sides < 0.7, "which side is kept for shading");
        }
    }
}
