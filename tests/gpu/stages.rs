//! Every stage on the GPU against the `f64` oracle, each fed with the GPU's read-back of the stage before.

use std::collections::HashMap;

use glam::DVec2;
use pellucid::math::Camera;
use pellucid::oracle::buckets::{Bucket, quantize_depth};
use pellucid::oracle::compare::{self, AMBIGUOUS, Comparison, rig};
use pellucid::oracle::stylize::Tables;
use pellucid::oracle::{PackedKey, StoreData, WideKey, bucket_k_buffer, composite, rasterize, shade, stylize};
use pellucid::plan::{Capture, Pass};
use pellucid::render::{Renderer, StoreReadback};
use pellucid::scene::Scene;
use pellucid::settings::{DepthQuantization, OpacityModel, Settings};
use pellucid::transfer;

use crate::common::*;
use crate::meshes;
use crate::raster::check_capture;

/// What a comparison found must be no fault, and at most 2 % ambiguous.
pub fn report(what: &str, found: &Comparison) {
    if let Some(fault) = found.faults.first() {
        panic!(
            "{what}: {} of {} wrong, first in pixel {}: {}",
            found.faults.len(),
            found.samples,
            fault.pixel,
            fault.what
        );
    }
    report_share(what, found.ambiguous, found.samples);
}

pub fn report_share(what: &str, ambiguous: usize, of: usize) {
    let share = ambiguous as f64 / of.max(1) as f64;
    println!("{what}: {ambiguous} of {of} ambiguous ({:.2} %)", 100.0 * share);
    assert!(share <= AMBIGUOUS, "{what}: more than 2 % ambiguous");
}

/// Z rows, reordering and bucket tables, exactly. `all` are the fragments of every pixel.
fn check_buckets(what: &str, all: &StoreData, store: &StoreReadback, capture: Capture) {
    let s = &store.layers;
    for pixel in 0..s.counts.len() {
        let range = s.range(pixel);
        let keys: Vec<WideKey> = all
            .range(pixel)
            .map(|i| WideKey { depth: all.depth_key[i], triangle: all.triangle[i], part: all.part[i] })
            .collect();
        let k = match capture {
            Capture::BucketedKBuffer { k, .. } => k as usize,
            _ => keys.len(),
        };
        let expected = bucket_k_buffer(&keys, k);
        let row: Vec<WideKey> =
            range.map(|i| WideKey { depth: s.depth_key[i], triangle: s.triangle[i], part: s.part[i] }).collect();
        assert_eq!(row, expected.nearest, "{what}: row of pixel {pixel}");
        assert_eq!(s.overflowed[pixel], expected.overflowed, "{what}: pixel {pixel}");
        if let Some(found) = store.buckets.get(pixel) {
            compare_buckets(what, pixel, found, &expected, &row);
        }
    }
}

fn compare_buckets<K: PartialEq + std::fmt::Debug + Copy>(
    what: &str,
    pixel: usize,
    found: &pellucid::render::PixelBuckets,
    expected: &pellucid::oracle::BucketedPixel<K>,
    row: &[K],
) {
    let reordered: Vec<K> = found.by_part.iter().map(|&layer| row[layer as usize]).collect();
    assert_eq!(reordered, expected.reordered, "{what}: by part, pixel {pixel}");
    if row.is_empty() {
        return;
    }
    let table: Vec<Option<Bucket>> = found
        .table
        .iter()
        .map(|slot| slot.map(|(shape, first, end)| Bucket { shape, first: first as usize, last: end as usize - 1 }))
        .collect();
    assert_eq!(table, expected.table, "{what}: bucket table, pixel {pixel}");
}

/// The same for packed keys: `all` is a frame with k = 64. Ties are one key from Z insertion on (T1).
fn check_packed_buckets(what: &str, all: &StoreData, store: &StoreReadback, k: usize) {
    let s = &store.layers;
    let keys = |s: &StoreData, pixel| -> Vec<PackedKey> {
        s.range(pixel).map(|i| PackedKey::new(s.depth_key[i] as u16, s.part[i] as u16)).collect()
    };
    for pixel in 0..s.counts.len() {
        assert!(!all.overflowed[pixel], "{what}: 64 layers are not enough for this test");
        let expected = bucket_k_buffer(&keys(all, pixel), k);
        let row = keys(s, pixel);
        assert_eq!(row, expected.nearest, "{what}: row of pixel {pixel}");
        assert_eq!(s.overflowed[pixel], expected.overflowed, "{what}: pixel {pixel}");
        if let Some(found) = store.buckets.get(pixel) {
            compare_buckets(what, pixel, found, &expected, &row);
        }
    }
}

fn as_f64(colors: &[[f32; 4]]) -> Vec<[f64; 4]> {
    colors.iter().map(|c| c.map(f64::from)).collect()
}

fn check_colors(what: &str, found: &[[f32; 4]], expected: &[[f64; 4]]) {
    let found = compare::colors(found, expected);
    println!("{what}: differs by at most {:.3}/255", found.worst);
    report(what, &found);
}

/// All stages after the capture, and the picture.
fn check_frame(
    r: &mut Renderer,
    what: &str,
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    size: [u32; 2],
    all: &StoreData,
) {
    let transfer = settings.opacity.transfer.resolve(None).expect("transfer function");
    let shot = draw(r, scene, camera, settings, size);
    let plan = &shot.frame.report.plan;
    let store = &shot.store;
    assert_eq!(plan.runs(Pass::Curvature), plan.features.is_some());
    let packed = !plan.capture.is_wide();
    assert!(shot.frame.report.layers.balanced(), "{what}: {:?}", shot.frame.report.layers);
    match plan.capture {
        Capture::BucketedKBuffer { k, .. } if packed => check_packed_buckets(what, all, store, k as usize),
        capture => check_buckets(what, all, store, capture),
    }
    // Light alone: the same frame without stylization.
    let mut plain_settings = settings.clone();
    plain_settings.opacity.model = OpacityModel::Constant;
    plain_settings.opacity.constant = 0.5;
    let plain = draw(r, scene, camera, &plain_settings, size);
    if !packed {
        assert_first(&plain.store.words, &store.words, &format!("{what}: plain and stylized store"));
    }
    let view = view_of(camera, size);
    let extents = extents_of(scene, camera);
    let layers = &plain.store.layers;
    let lit = shade::shade(layers, &view, &rig(&settings.light));
    let lit_with_alpha: Vec<[f64; 4]> =
        lit.iter().zip(&layers.base_color).map(|(c, b)| [c[0], c[1], c[2], f64::from(b[3])]).collect();
    check_colors(&format!("{what}, light"), &plain.store.lit, &lit_with_alpha);
    let half: Vec<[f64; 4]> = plain
        .store
        .lit
        .iter()
        .map(|c| {
            let c = c.map(f64::from);
            [c[0], c[1], c[2], 0.5 * c[3]]
        })
        .collect();
    // The tail counts as flat.
    let tail = |settings: &Settings| {
        let lit = shade::shade(all, &view, &rig(&settings.light));
        stylize::stylize(all, &lit, &vec![0.0; all.len()], &extents, &settings.opacity, &Tables::of(&transfer))
    };
    check_image(&format!("{what}, constant"), layers, &half, &plain, all, &|| tail(&plain_settings));

    if plan.features.is_some() {
        let how = (settings.features.depth_term, settings.features.reverse_check);
        report(&format!("{what}, links"), &compare::links(scene, camera, &store.layers, &store.links, how));
        let features = (store.links.as_slice(), store.kappa.as_slice());
        let bent = compare::kappa(scene, camera, &store.layers, features, &settings.features.curvature);
        println!("{what}: kappa differs by at most {:.1e}", bent.worst);
        report(&format!("{what}, curvature"), &bent);
    }
    if plan.runs(Pass::Stylize) {
        let kappa: Vec<f64> = if store.kappa.is_empty() {
            vec![0.0; store.layers.len()]
        } else {
            store.kappa.iter().map(|&k| f64::from(k)).collect()
        };
        // Which of two tied packed fragments is stored is a race, so light is computed from this frame's own store.
        let lit: Vec<[f64; 3]> = if packed {
            shade::shade(&store.layers, &view, &rig(&settings.light))
        } else {
            plain.store.lit.iter().map(|c| [f64::from(c[0]), f64::from(c[1]), f64::from(c[2])]).collect()
        };
        let styled = stylize::stylize(&store.layers, &lit, &kappa, &extents, &settings.opacity, &Tables::of(&transfer));
        check_colors(&format!("{what}, stylize"), &store.lit, &styled);
        check_image(what, &store.layers, &as_f64(&store.lit), &shot, all, &|| tail(settings));
    }
}

/// The picture of layers whose colours are given. Behind full pixels lies the tail, made of `all` fragments.
fn check_image(
    what: &str,
    layers: &StoreData,
    colors: &[[f64; 4]],
    shot: &Shot,
    all: &StoreData,
    tail: &dyn Fn() -> Vec<[f64; 4]>,
) {
    let mut front = composite::front_to_back(layers, colors, None);
    let back = composite::back_to_front(layers, colors, None);
    assert!(front.iter().flatten().zip(back.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-12), "{what}: both ways");
    if matches!(shot.frame.report.plan.capture, Capture::BucketedKBuffer { tail: true, .. }) {
        let styled = tail();
        for (pixel, color) in front.iter_mut().enumerate() {
            let behind = &styled[all.range(pixel)][layers.counts[pixel] as usize..];
            let weight: f64 = behind.iter().map(|c| c[3]).sum();
            if weight > 0.0 {
                let opacity = 1.0 - behind.iter().map(|c| 1.0 - c[3]).product::<f64>();
                let share = (1.0 - color[3]) * opacity;
                for (i, c) in color.iter_mut().enumerate().take(3) {
                    *c += share * behind.iter().map(|b| b[3] * b[i]).sum::<f64>() / weight;
                }
                color[3] += share;
            }
        }
    }
    check_colors(&format!("{what}, composite"), &shot.frame.image.pixels, &front);
}

/// One part of the matrix: scene and camera once, settings many.
pub fn check_all(r: &mut Renderer, name: &str, scene: &Scene, camera: &Camera, size: [u32; 2], rows: &[&str]) {
    let layers = rasterize(scene, camera, size, DVec2::ZERO);
    let mut everything: HashMap<String, StoreData> = HashMap::new();
    for row in rows {
        let what = format!("{name} [{row}]");
        let mut s = settings(row);
        if !row.contains("opacity.transfer") {
            s = with_transfer(s, lively());
        }
        let bkb = &s.capture.bucketed_k_buffer;
        let packed = row.contains("packed32");
        // All fragments of the pixels: what the k-buffer's rows are cut from.
        let source = if packed {
            format!("kind=bkb k=64 key=packed32 depth={} model=constant", s.get_depth(bkb.depth))
        } else {
            "kind=compacted model=constant".to_owned()
        };
        let all = everything
            .entry(source.clone())
            .or_insert_with(|| draw(r, scene, camera, &settings(&source), size).store.layers);
        let all = all.clone();
        check_frame(r, &what, scene, camera, &s, size, &all);
        if !packed {
            let shot = draw(r, scene, camera, &s, size);
            check_capture(&what, scene, camera, &layers, &shot.store, &s);
        }
    }
}

trait DepthName {
    fn get_depth(&self, depth: DepthQuantization) -> &'static str;
}

impl DepthName for Settings {
    fn get_depth(&self, depth: DepthQuantization) -> &'static str {
        match depth {
            DepthQuantization::Linear => "linear",
            DepthQuantization::ZOverW => "z_over_w",
            DepthQuantization::Reversed => "reversed",
        }
    }
}

fn matrix() -> Vec<String> {
    let mut rows = Vec::new();
    let captures = [
        "kind=compacted",
        "kind=bkb k=4",
        "kind=bkb k=7 tail=average",
        "kind=bkb k=16",
        "kind=bkb k=32 tail=average",
        "kind=bkb k=5 key=packed32",
        "kind=bkb k=16 key=packed32 depth=z_over_w",
        "kind=bkb k=16 key=packed32 depth=reversed",
    ];
    for capture in captures {
        for normals in ["octahedral", "xy15", "full"] {
            for curvature in ["surface", "view_centred"] {
                for unit in ["view", "part", "scene", "world"] {
                    for search in ["buckets reverse=true", "buckets reverse=false", "brute_force reverse=true"] {
                        for shape in ["radius=0 line=0 crease=180", "radius=0.04 line=0.02 crease=25", ""] {
                            rows.push(format!(
                                "{capture} normals={normals} curvature={curvature} unit={unit} search={search} {shape}"
                            ));
                        }
                    }
                }
            }
        }
    }
    if full() { rows } else { rows.into_iter().step_by(53).collect() }
}

#[test]
fn every_stage_equals_the_oracle() {
    let Some(mut r) = renderer() else { return };
    let rows = matrix();
    println!("{} rows of settings", rows.len());
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    for (seed, orthographic) in [(1, false), (2, true)] {
        let scene = meshes::assembly(seed);
        let camera = camera(&scene, orthographic);
        check_all(&mut r, &format!("assembly {seed}"), &scene, &camera, [112, 96], &rows);
    }
}

#[test]
fn loose_triangles_equal_the_oracle() {
    let Some(mut r) = renderer() else { return };
    for (seed, orthographic) in [(5, true), (6, false)] {
        let scene = meshes::soups(seed, 7, 12);
        let camera = camera(&scene, orthographic);
        let rows =
            ["kind=compacted", "kind=bkb k=16 curvature=view_centred", "kind=bkb k=8 unit=part search=brute_force"];
        check_all(&mut r, &format!("soup {seed}"), &scene, &camera, [64, 33], &rows);
    }
}

#[test]
fn transfer_functions_of_every_kind_equal_the_oracle() {
    let Some(mut r) = renderer() else { return };
    let scene = meshes::assembly(3);
    let camera = camera(&scene, false);
    let names: Vec<String> = transfer::names().iter().map(|n| format!("opacity.transfer={n} gain=2.5")).collect();
    let mut rows: Vec<&str> = names.iter().map(String::as_str).collect();
    rows.extend(["gain=8 light.exposure=3 light.ambient=0.2", "gain=0.1 light.key=0 light.fill=9"]);
    check_all(&mut r, "transfer", &scene, &camera, [72, 72], &rows);
    // Depends on depth alone: stylization without curvature.
    let depth_only = crate::common::transfer(
        "[color]\nmode = \"multiply\"\ninterpolation = \"linear\"\npoints = [{ kappa = 0.0, color = [0.7, 0.5, 0.2] }]\n\
         [opacity]\ninterpolation = \"linear\"\ndepth_interpolation = \"linear\"\n\
         curves = [{ depth = 0.0, points = [[0.0, 0.9]] }, { depth = 1.0, points = [[0.0, 0.1]] }]\n",
    );
    let s = with_transfer(settings("gain=3"), depth_only);
    let all = draw(&mut r, &scene, &camera, &settings("model=constant"), [40, 40]).store.layers;
    check_frame(&mut r, "depth only", &scene, &camera, &s, [40, 40], &all);
}

/// The 16 bits of a packed depth against `f64`, from the 32 bits of the wide key.
#[test]
fn packed_depths_are_the_quantized_ones() {
    let Some(mut r) = renderer() else { return };
    let scene = meshes::soups(11, 60, 4);
    for orthographic in [false, true] {
        let camera = camera(&scene, orthographic);
        let extents = extents_of(&scene, &camera);
        let frustum = camera.frustum(&scene.bounds());
        let wide = draw(&mut r, &scene, &camera, &settings("model=constant"), [64, 64]).store.layers;
        for (name, quantization) in [
            ("linear", DepthQuantization::Linear),
            ("z_over_w", DepthQuantization::ZOverW),
            ("reversed", DepthQuantization::Reversed),
        ] {
            let row = format!("model=constant kind=bkb k=64 key=packed32 depth={name}");
            let packed = draw(&mut r, &scene, &camera, &settings(&row), [64, 64]).store.layers;
            let (mut off_by_one, mut total) = (0, 0);
            for pixel in 0..wide.counts.len() {
                // By part, in order of depth.
                let of_part = |s: &StoreData, part: u32| -> Vec<usize> {
                    s.range(pixel).filter(|&i| s.part[i] == part).collect()
                };
                for part in 0..scene.parts.len() as u32 {
                    let (exact, found) = (of_part(&wide, part), of_part(&packed, part));
                    // Ties merged: which of them is stored cannot be said here.
                    if exact.len() != found.len() {
                        continue;
                    }
                    for (i, j) in exact.into_iter().zip(found) {
                        let [near, far] = match quantization {
                            DepthQuantization::Linear => extents.depth_range,
                            _ => [frustum.near, frustum.far],
                        };
                        // A parallel depth is linear between near and far under either of the others.
                        let kind = if orthographic { DepthQuantization::Linear } else { quantization };
                        let expected = quantize_depth(kind, wide.depth[i], near, far);
                        let difference = packed.depth_key[j].abs_diff(u32::from(expected));
                        assert!(difference <= 1, "{name}: {} and {expected}", packed.depth_key[j]);
                        off_by_one += difference as usize;
                        total += 1;
                    }
                }
            }
            assert!(total > 5000);
            report_share(&format!("packed depth {name}, orthographic {orthographic}: last bit"), off_by_one, total);
        }
    }
}
