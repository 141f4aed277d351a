//! Whole pictures against the `f64` oracle, from the scene to the colour; and the proof that the comparisons of the stages
//! can fail.

use glam::DVec2;
use pellucid::math::color::srgb_from_linear;
use pellucid::oracle::compare::{self, AMBIGUOUS};

use crate::common::*;
use crate::meshes;
use crate::stages::check_all;

/// Offsets of the samples of a pixel: the R2 sequence.
fn jitter(sample: u32, samples: u32) -> DVec2 {
    let at = |a: f64| (0.5 + a * f64::from(sample)).fract() - 0.5;
    if samples == 1 { DVec2::ZERO } else { DVec2::new(at(0.754_877_666_246_692_7), at(0.569_840_290_998_053_3)) }
}

/// The whole way in f64, from the scene alone: what a user sees.
#[test]
fn the_picture_equals_the_oracle_from_scene_to_colour() {
    let Some(mut r) = renderer() else { return };
    for (orthographic, samples) in [(false, 1), (true, 1), (false, 4), (true, 3)] {
        let scene = meshes::assembly(4);
        let camera = camera(&scene, orthographic);
        let size = [64, 64];
        let s = with_transfer(settings(&format!("light.rim=0.5 image.samples={samples}")), lively());
        let shot = draw(&mut r, &scene, &camera, &s, size);
        let mut image = vec![[0.0_f64; 4]; 64 * 64];
        for sample in 0..samples {
            let picture = compare::picture(&scene, &camera, &s, &lively(), size, jitter(sample, samples));
            for (sum, c) in image.iter_mut().zip(picture) {
                *sum = std::array::from_fn(|i| sum[i] + c[i] / f64::from(samples));
            }
        }
        let over_white = |c: f64, a: f64| srgb_from_linear(c + 1.0 - a);
        let mut off: Vec<f64> = image
            .iter()
            .zip(&shot.frame.image.pixels)
            .map(|(e, f)| {
                let f = f.map(f64::from);
                (0..3).map(|c| (over_white(e[c], e[3]) - over_white(f[c], f[3])).abs()).fold(0.0, f64::max)
            })
            .collect();
        let beyond = off.iter().filter(|&&o| o > 1.0 / 255.0).count() as f64 / off.len() as f64;
        let (median, p99) = (255.0 * percentile(&mut off, 0.5), 255.0 * percentile(&mut off, 0.99));
        println!(
            "orthographic {orthographic}, {samples} samples: {:.2} % of pixels beyond 1/255, median {median:.3}/255, p99 {p99:.2}/255",
            100.0 * beyond
        );
        assert!(beyond <= AMBIGUOUS, "{beyond}");
    }
}

/// Lets the panics of this thread pass without a message.
fn quietly<T>(what: impl FnOnce() -> T) -> std::thread::Result<T> {
    thread_local!(static QUIET: std::cell::Cell<bool> = const { std::cell::Cell::new(false) });
    static HOOK: std::sync::Once = std::sync::Once::new();
    HOOK.call_once(|| {
        let loud = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if !QUIET.get() {
                loud(info);
            }
        }));
    });
    QUIET.set(true);
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(what));
    QUIET.set(false);
    result
}

/// These tests can fail: an error planted in any stage is found by comparing that stage.
#[test]
fn planted_errors_are_found() {
    let Some(mut r) = renderer() else { return };
    let scene = meshes::assembly(1);
    let camera = camera(&scene, false);
    let rows =
        ["kind=bkb k=5 radius=0.04 line=0.02", "kind=compacted search=brute_force curvature=view_centred radius=0.04"];
    let size = [80, 64];
    for (module, from, to) in [
        ("scene/material", "return front_facing != ", "return front_facing == "),
        ("scene/instance", "dot(instance.normal_x.xyz, normal)", "dot(instance.view_x.xyz, normal)"),
        ("common/packing", "(u32(m.unlit) << 24u)", "0u"),
        ("store/normal_octahedral", "let p = n.xy /", "let p = n.yx /"),
        ("passes/capture/bucketed_k_buffer/z_insertion", "i < k; i++", "i + 1u < k; i++"),
        (
            "passes/capture/compacted/gather",
            "let source = source_of(base, sources[base + i]);",
            "let source = source_of(base, i);",
        ),
        (
            "passes/sort/elements_by_part",
            "return vec2<u32>(parts[base + i], i);",
            "return vec2<u32>(parts[base + i], 7u - i);",
        ),
        (
            "passes/buckets/bucket_creation",
            "var index = hash_of(part, slots);",
            "var index = hash_of(part + 1u, slots);",
        ),
        ("passes/features/neighbour_epsilon", "let epsilon_z = depth_measure(dz, back);", "let epsilon_z = abs(dz);"),
        ("passes/features/links_by_buckets", "+ depth_measures(dz, dz_back)", "+ abs(dz)"),
        ("passes/features/links_by_buckets", "let mutual = decided & ", "let mutual = decided | "),
        ("store/links", "select(MISSING, UNKNOWN, overflowed(other))", "MISSING"),
        ("passes/features/reverse_check", "pixel + 1u, 1u, layer)", "pixel + 1u, 0u, layer)"),
        ("passes/features/curvature", "- mean * axis.normal)", "- 0.9 * mean * axis.normal)"),
        ("passes/features/curvature", "0.5 * curvature_parameters.line + 0.5", "0.5 * curvature_parameters.line + 0.6"),
        ("passes/features/curvature", "max(normal.z, 0.05)", "max(normal.z, 0.3)"),
        ("passes/features/curvature", "select(angle, -angle, lines.convex)", "angle"),
        ("common/lighting", "SHOULDER_START: f32 = 0.75", "SHOULDER_START: f32 = 0.6"),
        ("passes/opacity/transfer", "max(2.0 * value - 1.0,", "max(2.0 * value - 0.95,"),
        ("passes/opacity/transfer", "vec2<f32>(depth01, abs(kappa))", "vec2<f32>(abs(kappa), depth01)"),
        ("passes/composite/transmits_rest", "1.0 - alpha", "1.0 - 0.97 * alpha"),
    ] {
        r.replace_shader(module, Some(changed(module, from, to)));
        let found = quietly(|| check_all(&mut r, "planted", &scene, &camera, size, &rows)).is_err();
        r.replace_shader(module, None);
        assert!(found, "{module}: '{from}' became '{to}' and no comparison saw it");
    }
    check_all(&mut r, "nothing planted", &scene, &camera, size, &rows);
}
