//! `compare` and `render --reference` through the real binary, on pairs whose errors are worked out by hand.

use image::{Rgb, RgbImage, Rgba, RgbaImage};
use serde_json::Value;

use super::place::Place;
use super::support::gpu;

/// 4 by 4 pixels of grey 100, of which `changed` are others.
fn grey(place: &Place, name: &str, changed: &[(u32, u32, [u8; 3])]) {
    let mut image = RgbImage::from_pixel(4, 4, Rgb([100; 3]));
    for &(x, y, color) in changed {
        image.put_pixel(x, y, Rgb(color));
    }
    image.save(place.path(name)).unwrap();
}

fn number(json: &Value, name: &str) -> f64 {
    json[name].as_f64().unwrap_or_else(|| panic!("{name}: {json}"))
}

/// One pixel of 16 is 1 step off in one channel, one 8 in one, one 9 in all three: largest 9, mean (1 + 8 + 27) / 48 = 0.75
/// steps; over 1 are two pixels, over 8 one.
#[test]
fn figures_are_those_worked_out_by_hand() {
    let place = Place::new();
    grey(&place, "a.png", &[]);
    grey(&place, "b.png", &[(0, 0, [101, 100, 100]), (1, 0, [100, 92, 100]), (2, 0, [109; 3])]);
    let json = place.done("compare a.png b.png --json").json();
    assert!((number(&json, "maximum") * 255.0 - 9.0).abs() < 1e-3, "{json}");
    assert!((number(&json, "mean") * 255.0 - 0.75).abs() < 1e-3, "{json}");
    assert_eq!((number(&json, "over_1"), number(&json, "over_8")), (0.125, 0.0625));
    assert!(number(&json, "flip_mean") > 0.0 && json["size"] == serde_json::json!([4, 4]), "{json}");
    let text = place.done("compare a.png b.png").text();
    for words in ["a.png against b.png, 4×4", "9.00/255", "0.75/255", "12.5000 % of pixels", "6.2500 % of pixels"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let same = place.done("compare a.png a.png --json --threshold 0 --max-flip 0").json();
    for name in ["maximum", "mean", "over_1", "over_8", "flip_mean"] {
        assert_eq!(number(&same, name), 0.0, "{name}");
    }
    // The picture in 16 bits and as EXR is the same picture.
    let wide = image::DynamicImage::ImageRgb8(image::open(place.path("b.png")).unwrap().into_rgb8()).into_rgb16();
    wide.save(place.path("wide.png")).unwrap();
    assert!(number(&place.done("compare wide.png b.png --json").json(), "maximum") < 1e-6);
}

#[test]
fn black_and_white_are_as_far_as_can_be_and_thresholds_exit_with_5() {
    let place = Place::new();
    RgbImage::from_pixel(32, 32, Rgb([0; 3])).save(place.path("black.png")).unwrap();
    RgbImage::from_pixel(32, 32, Rgb([255; 3])).save(place.path("white.png")).unwrap();
    let json = place.done("compare black.png white.png --json").json();
    for name in ["maximum", "mean", "over_1", "over_8"] {
        assert!((number(&json, name) - 1.0).abs() < 1e-9, "{json}");
    }
    // As the reference implementation of FLIP has it.
    assert!((number(&json, "flip_mean") - 0.967).abs() < 1e-3, "{json}");
    for (line, word) in [("--threshold 0.9", "threshold 0.9"), ("--max-flip 0.9", "mean FLIP above 0.9")] {
        let run = place.run(&format!("compare black.png white.png {line}"));
        assert_eq!(run.code, Some(5), "{}", run.err);
        assert!(run.err.contains(word) && run.err.starts_with("pellucid: black.png: "), "{}", run.err);
        assert!(run.text().contains("mean FLIP"), "the figures are printed all the same");
    }
    place.done("compare black.png white.png --threshold 1 --max-flip 0.97");
}

#[test]
fn transparency_counts_over_a_background_that_is_said() {
    let place = Place::new();
    RgbaImage::from_pixel(2, 2, Rgba([255, 0, 0, 0])).save(place.path("clear.png")).unwrap();
    RgbImage::from_pixel(2, 2, Rgb([128; 3])).save(place.path("grey.png")).unwrap();
    RgbImage::from_pixel(2, 2, Rgb([255; 3])).save(place.path("white.png")).unwrap();
    let maximum = |line: &str| number(&place.done(&format!("compare {line} --json")).json(), "maximum");
    // What is clear has no colour: middle grey, sRGB 0.5, is half a step from 128.
    assert!((maximum("clear.png grey.png") * 255.0 - 0.5).abs() < 1e-3);
    assert_eq!(maximum("clear.png white.png --background #ffffff"), 0.0);
    place.fails(2, "compare clear.png grey.png --background none", &["#rrggbb"]);
}

#[test]
fn sizes_and_files_that_do_not_fit_have_their_codes() {
    let place = Place::new();
    grey(&place, "a.png", &[]);
    RgbImage::from_pixel(5, 4, Rgb([0; 3])).save(place.path("wide.png")).unwrap();
    place.write("broken.png", b"no picture");
    place.fails(5, "compare wide.png a.png", &["wide.png: 5×4 pixels, but a.png has 4×4"]);
    place.fails(6, "compare a.png missing.png", &["missing.png"]);
    place.fails(3, "compare missing.png a.png", &["missing.png"]);
    place.fails(3, "compare a.png broken.png", &["broken.png"]);
    place.fails(1, "compare a.png a.png --difference no/such/d.png", &["no/such/d.png"]);
}

#[test]
fn differences_are_pictures() {
    let place = Place::new();
    grey(&place, "a.png", &[]);
    grey(&place, "b.png", &[(3, 3, [110, 100, 90])]);
    let map = |line: &str| {
        place.done(&format!("compare a.png b.png --difference d.png {line}"));
        image::open(place.path("d.png")).unwrap().into_rgb8()
    };
    let absolute = map("--map absolute --amplify 5");
    assert_eq!((absolute.get_pixel(3, 3).0, absolute.get_pixel(0, 0).0), ([50, 0, 50], [0; 3]));
    let steps = map("--map steps");
    assert_eq!(steps.get_pixel(0, 0).0, [0; 3]);
    // 10 steps: between the colours of 8 and 16.
    let [r, g, b] = steps.get_pixel(3, 3).0;
    assert!((206..=240).contains(&r) && (72..=120).contains(&g) && (54..=98).contains(&b), "{r} {g} {b}");
    let flip = map("");
    assert!(flip.get_pixel(3, 3).0.iter().map(|v| u32::from(*v)).sum::<u32>() > 20, "{:?}", flip.get_pixel(3, 3));
    // To standard output the picture, and the figures beside it.
    let run = place.done("compare a.png b.png --difference - --map absolute");
    assert!(run.out.starts_with(b"\x89PNG") && run.err.contains("maximum error"), "{}", run.err);
}

#[test]
fn rendering_with_a_reference_says_the_same_as_comparing() {
    if gpu("render --reference and compare").is_none() {
        return;
    }
    let place = Place::new();
    place.done("render boxes.glb -o r.png --size 32x32");
    let run = place.run("render boxes.glb -o a.png --reference r.png --size 32x32 --opacity opaque --stats s.json");
    assert_eq!(run.code, Some(5));
    let stats: Value = serde_json::from_slice(&std::fs::read(place.path("s.json")).unwrap()).unwrap();
    let compared = place.done("compare a.png r.png --json --background #262b33").json();
    for name in ["maximum", "mean", "over_1", "over_8", "flip_mean"] {
        assert_eq!(number(&stats["difference"], name), number(&compared, name), "{name}");
    }
    let sentence = run.err.lines().last().unwrap().split("mean error ").nth(2).unwrap();
    let again = place.run("compare a.png r.png --threshold 0 --background #262b33").err;
    assert!(again.contains(sentence), "{sentence}: {again}");
    // A reference in floats: the picture before it was rounded.
    place.done("render boxes.glb -o r.exr --size 32x32");
    let run = place.done("render boxes.glb --reference r.exr --size 32x32 --threshold 0.001");
    assert!(run.err.contains("r.exr: mean error 0.00"), "{}", run.err);
    place.done("render boxes.glb -o b.exr --reference r.exr --size 32x32 --threshold 0");
    place.done("compare b.exr a.png --background #262b33 --max-flip 1");
    place.fails(6, "render boxes.glb --reference none.exr --size 32x32", &["none.exr"]);
}
