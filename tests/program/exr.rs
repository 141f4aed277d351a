//! EXR through the real binary: what is stored, and that the layers are the picture.

use exr::prelude::{AnyChannels, FlatSamples, Layer, ReadChannels, ReadLayers, Vec2, read};
use pellucid::export::exr::read_exr;
use pellucid::export::image::{LinearImage, parse_background};
use pellucid::export::png::rgba8;
use pellucid::math::color::Premultiplied;

use super::place::Place;
use super::support::gpu;

type Part = Layer<AnyChannels<FlatSamples>>;

fn parts(bytes: &[u8]) -> Vec<Part> {
    let all = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    all.from_buffered(std::io::Cursor::new(bytes)).unwrap().layer_data.into_iter().collect()
}

fn text(part: &Part, name: &str) -> String {
    let found = part.attributes.other.iter().find(|(key, _)| **key == *name);
    let (_, value) = found.unwrap_or_else(|| panic!("no attribute {name}"));
    match value {
        exr::prelude::AttributeValue::Text(text) => String::from_utf8(text.as_slice().to_vec()).unwrap(),
        other => panic!("{name}: {other:?}"),
    }
}

fn samples<'a>(part: &'a Part, name: &str) -> &'a FlatSamples {
    let names: Vec<String> = part.channel_data.list.iter().map(|c| c.name.to_string()).collect();
    let at = names.iter().position(|n| n == name).unwrap_or_else(|| panic!("{name} is not in {names:?}"));
    &part.channel_data.list[at].sample_data
}

/// The layers of a file over each other, front to back.
fn recomposited(parts: &[Part], size: [u32; 2]) -> LinearImage {
    let mut image =
        LinearImage { width: size[0], height: size[1], pixels: vec![[0.0; 4]; (size[0] * size[1]) as usize] };
    for part in parts {
        let channels = ["R", "G", "B", "A"].map(|c| samples(part, c));
        let Vec2(left, top) = part.attributes.layer_position;
        for y in 0..part.size.y() {
            for x in 0..part.size.x() {
                let layer = channels.map(|c| c.value_by_flat_index(y * part.size.x() + x).to_f32());
                let at = (top as usize + y) * size[0] as usize + left as usize + x;
                image.pixels[at] = Premultiplied(image.pixels[at]).over(Premultiplied(layer)).0;
            }
        }
    }
    image
}

#[test]
fn an_exr_is_the_picture_before_it_is_encoded() {
    if gpu("EXR").is_none() {
        return;
    }
    let place = Place::new();
    let look = "--size 32x24 --background #ff8000";
    place.done(&format!("render boxes.glb -o a.png {look}"));
    let run = place.done(&format!("render boxes.glb -o a.exr {look}"));
    assert!(run.out.is_empty() && run.err.contains("32×24") && !run.err.contains("layers are written"), "{}", run.err);
    let bytes = std::fs::read(place.path("a.exr")).unwrap();
    let image = read_exr(&bytes).unwrap();
    assert_eq!((image.width, image.height), (32, 24));
    // Over its background, encoded and rounded, it is the PNG to the last bit.
    let png = image::open(place.path("a.png")).unwrap().into_rgba8().into_raw();
    assert_eq!(rgba8(&image, parse_background("#ff8000").unwrap()), png);
    // Clear where nothing is.
    assert_eq!(image.pixels[0], [0.0; 4]);
    let all = parts(&bytes);
    assert_eq!((all.len(), text(&all[0], "pellucid:background")), (1, "#ff8000".to_owned()));
    assert!(all[0].attributes.world_to_camera.is_some());
    // The session in it draws the same picture.
    place.write("again.toml", text(&all[0], "pellucid:session").as_bytes());
    place.done("render --session again.toml -o again.exr");
    assert_eq!(read_exr(&std::fs::read(place.path("again.exr")).unwrap()).unwrap(), image);
    // Standard output, and half floats.
    assert!(place.done(&format!("render boxes.glb -o - --format exr {look}")).out == bytes);
    let half = place.done(&format!("render boxes.glb -o - --format exr --bits 16 {look}")).out;
    assert!(matches!(samples(&parts(&half)[0], "R"), FlatSamples::F16(_)));
    for (a, b) in read_exr(&half).unwrap().pixels.iter().flatten().zip(image.pixels.iter().flatten()) {
        assert!((a - b).abs() <= b.abs() / 1024.0 + 1e-7, "{a} {b}");
    }
}

#[test]
fn layers_over_each_other_are_the_png() {
    if gpu("EXR layers").is_none() {
        return;
    }
    let place = Place::new();
    let looks = [
        "boxes.glb --size 40x30",
        "boxes.glb --size 40x30 --preset plain --background none",
        "boxes.glb --size 33x32 --preset opaque --background #ffffff",
        "boxes.glb --size 40x30 --opacity curvature --isolate box~1 --explode 0.5",
        "boxes.glb --size 32x32 --preset paper --background #808080",
        "boxes.glb --size 40x30 --capture linked_list --part box~0:opacity=0.5",
        "builtin:gearbox --size 48x48 --section x=50%",
        "builtin:stack --size 32x40 --opacity equal_share",
    ];
    for look in looks {
        // The parts of the model have blanks in their names.
        let words = |rest: &str| -> Vec<String> {
            format!("render {look} {rest}").split_whitespace().map(|w| w.replace('~', " ")).collect()
        };
        place.done_words(&words("-o a.png"));
        let run = place.done_words(&words("-o a.exr --layers"));
        assert!(run.err.contains("layers are written, of "), "{look}: {}", run.err);
        let all = parts(&std::fs::read(place.path("a.exr")).unwrap());
        let names: Vec<String> = all.iter().map(|p| p.attributes.layer_name.as_ref().unwrap().to_string()).collect();
        assert_eq!(names[..2], ["picture", "layer.0"], "{look}");
        assert_eq!(names.last(), Some(&format!("layer.{}", names.len() - 2)));
        let Vec2(width, height) = all[0].size;
        let image = recomposited(&all[1..], [width as u32, height as u32]);
        let background = parse_background(&text(&all[0], "pellucid:background")).unwrap();
        let png = image::open(place.path("a.png")).unwrap().into_rgba8().into_raw();
        let worst = rgba8(&image, background).iter().zip(&png).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(worst <= Some(1), "{look}: {worst:?} steps");
        facts_hold(look, &all[1..]);
    }
}

/// What can be said of the other channels of any picture.
fn facts_hold(look: &str, layers: &[Part]) {
    let mut kappas = std::collections::BTreeSet::new();
    let mut before: Option<Vec<f32>> = None;
    for part in layers {
        let FlatSamples::U32(ids) = samples(part, "id") else { panic!("ids are whole numbers") };
        let value = |name: &str, at: usize| samples(part, name).value_by_flat_index(at).to_f32();
        let mut all = Vec::new();
        for (at, &id) in ids.iter().enumerate() {
            let (depth, there) = (value("Z", at), id != u32::MAX);
            assert_eq!(depth.is_finite(), there, "{look}");
            let normal = ["N.X", "N.Y", "N.Z"].map(|n| value(n, at));
            let length = normal.iter().map(|v| v * v).sum::<f32>().sqrt();
            assert!((length - f32::from(u8::from(there))).abs() < 1e-3, "{look}: {normal:?}");
            assert!((-1.0..=1.0).contains(&value("kappa", at)) && (0.0..=1.0).contains(&value("A", at)));
            if there {
                kappas.insert(value("kappa", at).to_bits());
            }
            all.push(depth);
        }
        // The same rectangle as the layer before can be compared pixel by pixel.
        if let Some(before) = before.replace(all.clone()).filter(|b| b.len() == all.len()) {
            assert!(before.iter().zip(&all).all(|(a, b)| a <= b), "{look}: layers are in the order of depth");
        }
    }
    assert!(kappas.len() > 1 || look.contains("stack"), "{look}: curvature is computed whatever the look needs");
}

#[test]
fn bands_are_collected_and_limits_are_counted() {
    if gpu("EXR: bands").is_none() {
        return;
    }
    let place = Place::new();
    place.done("render boxes.glb -o whole.exr --layers --size 24x24");
    // A list that holds little makes many bands.
    let memory = "--capture linked_list --set capture.linked_list.memory=1";
    let run = place.done(&format!(
        "render boxes.glb -o banded.exr --layers --size 200x200 --opacity curvature {memory} --stats s.json"
    ));
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(place.path("s.json")).unwrap()).unwrap();
    assert!(stats["pictures"][0]["bands"].as_u64() > Some(1), "{}", run.err);
    place.done("render boxes.glb -o one.exr --layers --size 200x200 --opacity curvature");
    let [banded, one] = ["banded.exr", "one.exr"].map(|f| parts(&std::fs::read(place.path(f)).unwrap()));
    assert_eq!(banded.len(), one.len());
    for (a, b) in banded.iter().zip(&one).skip(1) {
        assert_eq!((a.size, a.attributes.layer_position), (b.size, b.attributes.layer_position));
        assert!(a.channel_data == b.channel_data, "{:?}", a.attributes.layer_name);
    }
    let line = "render boxes.glb -o few.exr --layers=2 --size 32x32 --samples 3 --select";
    let run = place.done_words(&line.split(' ').chain(["box 1"]).map(str::to_owned).collect::<Vec<_>>());
    let line_around = "the line around what is selected";
    for words in
        ["2 layers are written, of 6 in the deepest pixel", "are left out", "average of 3 samples", line_around]
    {
        assert!(run.err.contains(words), "{words}: {}", run.err);
    }
    assert_eq!(parts(&std::fs::read(place.path("few.exr")).unwrap()).len(), 3);
    let run = place.done("render boxes.glb -o k.exr --layers --size 32x32 --k 2");
    assert!(run.err.contains("behind the k nearest are in no image"), "{}", run.err);
    // Nothing in view: the picture alone.
    place.done("render boxes.glb -o none.exr --layers --size 8x8 --camera-position 0,0,50 --camera-focal-point 0,0,99");
}
