//! Opacity models and illustrative transparency on the GPU against the `f64` oracle, over every capture.

use pellucid::math::Camera;
use pellucid::oracle::{Link, compare, composite, continuity, illustration, models};
use pellucid::render::Renderer;
use pellucid::scene::Scene;
use pellucid::settings::Settings;

use crate::common::*;
use crate::meshes;
use crate::stages::report;

const SIZE: [u32; 2] = [56, 52];

fn lively_settings(pairs: &str) -> Settings {
    let pairs = pairs.replace("ill.", "opacity.illustrative.");
    with_transfer(settings(&pairs), lively())
}

fn views() -> Vec<(String, Scene, Camera)> {
    (31..if full() { 37 } else { 33 })
        .map(|seed| {
            let scene = if seed % 3 == 0 { meshes::soups(seed, 9, 14) } else { meshes::assembly(seed) };
            let camera = camera(&scene, seed % 2 == 0);
            (format!("scene {seed}"), scene, camera)
        })
        .collect()
}

const MODELS: [&str; 8] = [
    "model=constant constant=0.37",
    "model=adaptive",
    "model=angle_based",
    "model=normal_variation",
    "model=curvature",
    "model=illustrative",
    "model=illustrative ill.base=curvature ill.iterations=5",
    "model=illustrative ill.base=constant ill.beta.profile=bell ill.gamma.profile=power ill.gamma.p=0.5",
];

#[test]
fn t28_all_models_are_the_same_bits_over_all_captures() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        let k = draw(&mut r, &scene, &camera, &settings("model=constant"), SIZE).frame.report.layers.deepest;
        for model in MODELS {
            let exact = draw(&mut r, &scene, &camera, &lively_settings(model), SIZE);
            for capture in ["kind=lists".to_owned(), format!("kind=bkb k={k}")] {
                let other = draw(&mut r, &scene, &camera, &lively_settings(&format!("{model} {capture}")), SIZE);
                exact.assert_same(&other, &format!("{name}, {model}, {capture}"));
                let bits = |s: &Shot| s.store.fields.iter().map(|f| f.map(f32::to_bits)).collect::<Vec<_>>();
                assert_first(&bits(&exact), &bits(&other), &format!("{name}, {model}, {capture}: fields"));
            }
        }
    }
}

#[test]
fn models_equal_the_oracle() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        let view = view_of(&camera, SIZE);
        for model in [
            "model=adaptive opacity.adaptive=0.8",
            "model=angle_based",
            "model=normal_variation",
            "model=adaptive opacity.adaptive=1",
            "model=equal_share",
            "model=equal_share opacity.equal_share.share=1 opacity.equal_share.least=0",
        ] {
            for capture in ["", "kind=lists", "kind=bkb k=5", "kind=bkb k=5 key=packed32", "search=brute_force"] {
                let what = format!("{name}, {model} {capture}");
                let s = lively_settings(&format!("{model} {capture}"));
                let shot = draw(&mut r, &scene, &camera, &s, SIZE);
                let store = &shot.store;
                let expected = models::opacities(&store.layers, &store.links, &view, &s.opacity);
                let mut worst = 0.0_f64;
                for (i, opacity) in expected.into_iter().enumerate() {
                    let expected = opacity * f64::from(store.layers.base_color[i][3]);
                    worst = worst.max((f64::from(store.lit[i][3]) - expected).abs());
                }
                println!("{what}: {} layers, off by {worst:.1e}", store.layers.len());
                // Half floats hold opacity to 2^-12.
                assert!(worst < 4e-4 && store.layers.len() > 1000, "{what}: {worst}");
                let picture = composite::front_to_back(&store.layers, &shot.colors(), None);
                report(&what, &compare::colors(&shot.frame.image.pixels, &picture));
            }
        }
    }
}

/// The base opacity of every layer: that of the same frame without silhouettes.
fn base_of(r: &mut Renderer, scene: &Scene, camera: &Camera, s: &Settings, size: [u32; 2]) -> Vec<f64> {
    let mut plain = s.clone();
    plain.opacity.model = s.opacity.illustrative.base.model();
    let shot = draw(r, scene, camera, &plain, size);
    shot.colors().iter().map(|c| c[3].clamp(0.0, 1.0)).collect()
}

fn worst_of(found: &[[f32; 4]], expected: &illustration::Fields) -> f64 {
    assert_eq!(found.len(), expected.values.len());
    let off = |(f, e): (&[f32; 4], &[f64; 3])| {
        (0..3).map(|c| (f64::from(f[c]) - e[c]).abs()).fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) })
    };
    found
        .iter()
        .zip(&expected.values)
        .map(off)
        .fold(0.0, |a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) })
}

fn fixed_of(field: &[f32; 4]) -> [bool; 2] {
    let bits = field[3] as u32;
    [bits & 1 != 0, bits & 2 != 0]
}

#[test]
fn fields_equal_the_oracle() {
    let Some(mut r) = renderer() else { return };
    // How often surfaces go on beyond a seam, meet another part's, end openly, and lie behind what does.
    let mut kinds = [0_usize; 4];
    let still = "ill.alpha.diffusion=none ill.beta.diffusion=none ill.gamma.diffusion=none ill.base_gain=1";
    for (name, scene, camera) in views() {
        for row in [
            still,
            "",
            "ill.iterations=1",
            "ill.iterations=0 ill.beta.lambda=0.3",
            "ill.iterations=7 ill.beta.lambda=0.9 ill.gamma.lambda=0.9",
            "ill.iterations=50 ill.alpha.lambda=0.25",
            "ill.beta.diffusion=heat ill.gamma.diffusion=heat ill.beta.lambda=0.9 ill.gamma.lambda=0.5",
            "ill.alpha.diffusion=max ill.alpha.lambda=0.1 ill.gamma.diffusion=none",
            "ill.base=curvature kind=lists",
            "ill.base=angle_based ill.beta.profile=bell ill.beta.p=0 ill.gamma.profile=bell ill.gamma.p=0.00000001",
            "ill.base=normal_variation ill.beta.profile=bell ill.beta.p=50 ill.gamma.profile=power ill.gamma.p=0 ill.feature_size=0",
            "ill.base=constant kind=bkb k=4",
            "features.depth_term=continuity ill.early_stop=false",
            "ill.feature_size=12 ill.iterations=30",
            "ill.feature_size=40 kind=lists ill.gamma.diffusion=heat",
            "ill.feature_size=1 kind=bkb k=4",
            "kind=bkb k=9 key=packed32",
            "kind=lists search=brute_force ill.iterations=2",
            "capture.normals=xy15 ill.iterations=2",
            "capture.normals=full ill.iterations=2",
            "features.depth_term=printed ill.iterations=2",
        ] {
            let what = format!("{name} [{row}]");
            let s = lively_settings(&format!("model=illustrative {row}"));
            let base = base_of(&mut r, &scene, &camera, &s, SIZE);
            let shot = draw(&mut r, &scene, &camera, &s, SIZE);
            let store = &shot.store;
            assert_finite(&shot, &what);
            for (i, links) in store.links.iter().enumerate() {
                for d in (0..4).filter(|&d| links[d] == Link::Missing) {
                    kinds[usize::from(store.ends.surface[i][d]) + usize::from(store.ends.open[i][d])] += 1;
                    kinds[3] += usize::from(store.ends.behind[i][d]);
                }
            }
            report(&format!("{what}: ends"), &compare::ends(&camera, &store.layers, &store.links, &store.ends));
            let (fields, opacities) = compare::illustrated(&store.surfaces(), &base, &s.opacity.illustrative);
            let worst = worst_of(&store.fields, &fields);
            let fixed: Vec<[bool; 2]> = store.fields.iter().map(fixed_of).collect();
            assert_first(&fixed, &fields.fixed, &format!("{what}: what is fixed"));
            let off = opacities.iter().zip(&store.lit).map(|(e, l)| (e - f64::from(l[3])).abs()).fold(0.0, f64::max);
            let halos = fields.values.iter().filter(|v| v[2] > 0.0).count();
            let (of, steps) = (store.layers.len(), s.opacity.illustrative.steps().most);
            println!(
                "{what}: {halos} of {of} in halos, {steps} steps, fields off by {worst:.1e}, opacity by {off:.1e}"
            );
            assert!(worst < if row == still { 1e-12 } else { 1e-5 }, "{what}: {worst}");
            assert!(off < 4e-4, "{what}: opacity {off}");
            assert!(halos > 50 || !row.is_empty());
            let picture = composite::front_to_back(&store.layers, &shot.colors(), None);
            report(&what, &compare::colors(&shot.frame.image.pixels, &picture));
        }
    }
    println!("seams within parts, seams between parts, open ends, behind those: {kinds:?}");
    assert!(kinds.iter().all(|&n| n > 20), "{kinds:?}");
}

#[test]
fn t16_the_gpu_stops_when_nothing_changes_and_the_picture_is_the_same() {
    let Some(mut r) = renderer() else { return };
    let (_, scene, camera) = views().swap_remove(0);
    for row in [
        "",
        "ill.alpha.diffusion=none",
        "ill.iterations=3 ill.beta.lambda=0.01",
        "ill.iterations=4 ill.beta.lambda=0.01",
    ] {
        let row = format!("model=illustrative {row}");
        let stopped = draw(&mut r, &scene, &camera, &lively_settings(&row), SIZE);
        let taken = r.read_words("steps").expect("steps")[2];
        let most = stopped.frame.report.plan.illustration.unwrap().most_steps;
        let whole = draw(&mut r, &scene, &camera, &lively_settings(&format!("{row} ill.early_stop=false")), SIZE);
        assert_eq!(r.read_words("steps").expect("steps")[2], most);
        println!("{row}: {taken} of {most} steps");
        stopped.assert_same(&whole, &row);
        let bits = |s: &Shot| s.store.fields.iter().map(|f| f.map(f32::to_bits)).collect::<Vec<_>>();
        assert_first(&bits(&stopped), &bits(&whole), &row);
        assert!(taken <= most && (most < 50 || taken < most), "{row}: nothing was saved");
    }
}

#[test]
fn bands_change_no_bit_of_illustrative_pictures() {
    let (Some(mut r), Some(mut small)) = (renderer(), small_renderer()) else { return };
    let (_, scene, camera) = views().swap_remove(0);
    for row in [
        "model=illustrative ill.iterations=6 ill.beta.lambda=0.2 ill.feature_size=0",
        "model=illustrative ill.iterations=4 ill.beta.lambda=0.3 ill.base=curvature ill.feature_size=0 radius=0.02 kind=lists",
        "model=illustrative ill.iterations=4 ill.beta.lambda=0.3 ill.base=normal_variation ill.feature_size=0 kind=bkb k=6",
        "model=illustrative ill.iterations=2 ill.beta.lambda=0.5 ill.gamma.lambda=0.5 ill.feature_size=4",
        "model=normal_variation",
        "model=equal_share",
        "model=equal_share kind=lists",
        "model=equal_share kind=bkb k=6",
        "model=illustrative ill.iterations=4 ill.beta.lambda=0.3 ill.feature_size=0 ill.base=equal_share",
        "model=angle_based kind=bkb k=6 tail=average",
    ] {
        let s = lively_settings(row);
        let whole = draw(&mut r, &scene, &camera, &s, [56, 120]);
        let banded = draw(&mut small, &scene, &camera, &s, [56, 120]);
        println!("{row}: {} bands", banded.frame.report.bands);
        assert!(whole.frame.report.bands == 1 && banded.frame.report.bands > 1, "{row}");
        assert_first(&whole.bits(), &banded.bits(), row);
    }
}

#[test]
fn a_picked_pixel_has_the_opacity_of_the_frame() {
    let Some(mut r) = renderer() else { return };
    let (_, scene, camera) = views().swap_remove(0);
    for row in [
        "kind=lists",
        "kind=lists ill.feature_size=15",
        "ill.base=curvature ill.beta.lambda=0.1",
        "kind=bkb k=5 ill.base=constant",
    ] {
        let s = lively_settings(&format!("model=illustrative {row}"));
        let loaded = r.load(&scene).expect("upload");
        let frame = r.render(&loaded, &camera, &s, SIZE).expect("a frame");
        let store = r.read_store(&frame.report, &loaded, &camera).expect("read-back");
        for pixel in [[20, 20], [3, 40], [55, 51], [30, 27]] {
            let picked = r.pick(&loaded, &camera, &s, SIZE, pixel).expect("picked");
            let range = store.layers.range((pixel[1] * SIZE[0] + pixel[0]) as usize);
            let opacities: Vec<u32> = range.map(|i| store.lit[i][3].to_bits()).collect();
            assert_eq!(picked.iter().map(|l| l.opacity.to_bits()).collect::<Vec<_>>(), opacities, "{row}, {pixel:?}");
        }
    }
}

#[test]
fn t13_links_by_continuity_are_those_of_the_oracle_and_mutual() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, camera) in views() {
        for capture in ["", "kind=lists", "kind=bkb k=5"] {
            let row = format!("model=illustrative {capture} features.depth_term=continuity");
            let buckets = draw(&mut r, &scene, &camera, &lively_settings(&row), SIZE);
            let s = lively_settings(&format!("{row} search=brute_force"));
            let brute = draw(&mut r, &scene, &camera, &s, SIZE);
            buckets.assert_same(&brute, &row);
            let how = (s.features.depth_term, true);
            report(
                &format!("{name}, {row}"),
                &compare::links(&scene, &camera, &brute.store.layers, &brute.store.links, how),
            );
            assert_eq!(continuity::one_way(&brute.store.layers, &brute.store.links), 0);
        }
        let s = lively_settings("model=illustrative features.depth_term=continuity_printed");
        let printed = draw(&mut r, &scene, &camera, &s, SIZE);
        let (layers, links) = (&printed.store.layers, &printed.store.links);
        report(&name, &compare::links(&scene, &camera, layers, links, (s.features.depth_term, true)));
        let one_way = continuity::one_way(layers, links);
        let of = links.iter().flatten().filter(|l| matches!(l, Link::To(_))).count();
        println!("{name}: as printed {one_way} of {of} links go one way");
        assert!(100 * one_way > of, "{name}");
    }
}

/// The paper's forms through the same shaders: each fails, and by how much.
#[test]
fn printed_forms_fail() {
    let Some(mut r) = renderer() else { return };
    let (_, scene, camera) = views().swap_remove(0);
    let fields = |r: &mut Renderer, row: &str| -> (Shot, f64) {
        let s = lively_settings(&format!("model=illustrative {row}"));
        let base = base_of(r, &scene, &camera, &s, SIZE);
        let shot = draw(r, &scene, &camera, &s, SIZE);
        let (expected, _) = compare::illustrated(&shot.store.surfaces(), &base, &s.opacity.illustrative);
        let worst = worst_of(&shot.store.fields, &expected);
        (shot, worst)
    };
    let exploded = fields(&mut r, "ill.printed=laplacian ill.base=angle_based").1;
    println!("T12, λ = 1: α is off by {exploded:e}");
    assert!(exploded.is_nan() || exploded > 1e3);
    let overwritten = fields(&mut r, "ill.printed=propagation").1;
    println!("T16, without its flag: fields are off by {overwritten}");
    assert!(overwritten > 0.5);
    let (shot, same) = fields(&mut r, "ill.printed=transmittance");
    assert!(same < 1e-5, "the fields are ours");
    let ours = composite::front_to_back(&shot.store.layers, &shot.colors(), None);
    let off = compare::colors(&shot.frame.image.pixels, &ours);
    println!("T14, line 6: {} of {} pixels off, by up to {:.0}/255", off.faults.len(), off.samples, off.worst);
    assert!(off.worst > 20.0);
}
