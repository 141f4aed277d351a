//! Files with every feature, changed by their structure: indices swapped, counts and offsets moved, types exchanged, members taken
//! out and put in twice, cycles made, and their data damaged where it lies. Any outcome is fine but a panic, a scene that breaks its
//! promises, or taking long.
//!
//! Memory is bounded by argument: limits are small, and what would exceed one is refused where it is charged, before it is
//! made. Every outcome over a limit is counted, so that a mutation which nothing charges would show as a long run.
//! A hundred thousand inputs with `PELLUCID_TEST_FULL`, a few thousand else.

use std::time::{Duration, Instant};

use serde_json::json;

use super::compression::{attributes, draco_hill, hill, packed_accessor, packed_hill};
use super::instances::{instanced, variants};
use super::mutation::{Random, check, options, rich};
use super::textures::{textured, webp};
use super::*;
use crate::import::{ImportOptions, load_bytes_with};

/// No input may take longer, on a busy machine and unoptimized.
const LONGEST: Duration = Duration::from_secs(10);

/// A file's JSON with its buffers' lengths, and its binary chunk.
pub(super) fn parts(file: &Builder) -> (Value, Vec<u8>) {
    let mut json = file.json.clone();
    if json["buffers"].as_array().is_some_and(Vec::is_empty) {
        json["buffers"] = json!([{"byteLength": file.binary.len()}]);
    }
    (json, file.binary.clone())
}

/// Strips, fans, morph targets, skins, animations, cameras.
fn motley() -> Builder {
    let mut file = rich();
    let ibm: Vec<f32> = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.].repeat(2);
    let ibm = file.accessor(&floats(&ibm), 5126, "MAT4", 2, false);
    let joints = file.accessor(&[0, 1, 0, 0].repeat(4), 5121, "VEC4", 4, false);
    let weights = file.accessor(&floats(&[0.5, 0.5, 0.0, 0.0].repeat(4)), 5126, "VEC4", 4, false);
    let moved = file.accessor(&floats(&[0.0, 0.1, 0.0].repeat(4)), 5126, "VEC3", 4, false);
    let times = file.accessor(&floats(&[0.0, 1.0]), 5126, "SCALAR", 2, false);
    let strip = file.accessor(&[0, 1, 3, 2], 5121, "SCALAR", 4, false);
    let positions = file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].clone();
    let primitives = file.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives[0]["attributes"]["JOINTS_0"] = joints.into();
    primitives[0]["attributes"]["WEIGHTS_0"] = weights.into();
    primitives[0]["targets"] = json!([{"POSITION": moved}]);
    for mode in [5, 6, 1, 0] {
        primitives.push(json!({"attributes": {"POSITION": positions}, "indices": strip, "mode": mode, "material": 0}));
    }
    file.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": ibm, "skeleton": 0}]);
    file.json["nodes"][0]["skin"] = 0.into();
    file.json["animations"] = json!([{
        "samplers": [{"input": times, "output": moved}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
    }]);
    file
}

/// Compressed views with filters, interleaved and shared.
fn packed() -> Builder {
    let name = "KHR_meshopt_compression";
    let mut file = packed_hill(6, name, 1);
    let (positions, _) = hill(6);
    let count = positions.len();
    let normals: Vec<u8> = (0..count).flat_map(|i| [(i * 5 % 120) as u8, 10, 127, 0]).collect();
    let normal = packed_accessor(&mut file, &attributes(&normals, count, 4, 0, "OCTAHEDRAL"), 5120, "VEC3", name);
    let colors: Vec<u8> = (0..count).flat_map(|i| [i as u8, 3, 250, 255]).collect();
    let color = packed_accessor(&mut file, &attributes(&colors, count, 4, 1, "COLOR"), 5121, "VEC4", name);
    let primitive = file.primitive();
    primitive["attributes"]["NORMAL"] = normal.into();
    primitive["attributes"]["COLOR_0"] = color.into();
    file
}

/// The files that are changed.
pub(super) fn seeds() -> Vec<(Value, Vec<u8>)> {
    let picture = webp(&image::DynamicImage::new_rgb8(3, 2));
    let core = png(image::DynamicImage::new_rgb8(2, 2));
    let basis = textured(Some(&core), include_bytes!("ktx2/etc1s.ktx2"), "KHR_texture_basisu");
    let files = [
        motley(),
        packed(),
        draco_hill(6, None),
        draco_hill(5, Some(0)),
        instanced(),
        variants(),
        textured(None, &picture, "EXT_texture_webp"),
        basis,
        textured(None, include_bytes!("ktx2/uastc_zstd.ktx2"), "KHR_texture_basisu"),
    ];
    files.iter().map(parts).collect()
}

/// The pointers of all values, and of those that are numbers.
fn pointers(value: &Value, path: &str, all: &mut Vec<String>, numbers: &mut Vec<String>) {
    if !path.is_empty() {
        all.push(path.to_owned());
    }
    match value {
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, v)| pointers(v, &format!("{path}/{i}"), all, numbers));
        }
        Value::Object(members) => {
            members.iter().for_each(|(k, v)| pointers(v, &format!("{path}/{k}"), all, numbers));
        }
        Value::Number(_) => numbers.push(path.to_owned()),
        _ => {}
    }
}

fn strange(random: &mut Random) -> Value {
    let values = [
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(3),
        json!(7),
        json!(255),
        json!(256),
        json!(65535),
        json!(65536),
        json!(1_u64 << 24),
        json!(1_u64 << 31),
        json!(u32::MAX),
        json!(u32::MAX - 1),
        json!(1_u64 << 32),
        json!(1_u64 << 53),
        json!(u64::MAX),
        json!(i64::MIN),
        json!(1e308),
        json!(-1e308),
        json!(5e-324),
        json!(0.5),
        json!(1.0),
        json!(-0.0),
        json!("NaN"),
        json!("Infinity"),
        json!("0"),
        json!(null),
        json!(true),
        json!([]),
        json!({}),
        json!([[[]]]),
        json!(5120),
        json!(5121),
        json!(5122),
        json!(5123),
        json!(5125),
        json!(5126),
        json!("SCALAR"),
        json!("VEC2"),
        json!("VEC3"),
        json!("VEC4"),
        json!("MAT2"),
        json!("MAT3"),
        json!("MAT4"),
        json!("TRIANGLES"),
        json!("ATTRIBUTES"),
        json!("INDICES"),
        json!("QUATERNION"),
        json!("EXPONENTIAL"),
        json!("COLOR"),
        json!("OCTAHEDRAL"),
        json!(34962),
        json!(34963),
    ];
    values[random.below(values.len())].clone()
}

/// Changes one thing in the JSON.
fn change(json: &mut Value, random: &mut Random) {
    let (mut all, mut numbers) = (Vec::new(), Vec::new());
    pointers(json, "", &mut all, &mut numbers);
    if all.is_empty() || numbers.is_empty() {
        return;
    }
    let any = all[random.below(all.len())].clone();
    let number = numbers[random.below(numbers.len())].clone();
    let (parent, member) = any.rsplit_once('/').map(|(p, m)| (p.to_owned(), m.to_owned())).unwrap_or_default();
    match random.below(10) {
        // Two numbers of the same name change places.
        0 | 1 => {
            let name = number.rsplit('/').next().unwrap_or_default();
            let same: Vec<&String> = numbers.iter().filter(|p| p.rsplit('/').next() == Some(name)).collect();
            let other = same[random.below(same.len())].clone();
            let (a, b) = (json.pointer(&number).cloned(), json.pointer(&other).cloned());
            if let (Some(a), Some(b)) = (a, b) {
                json.pointer_mut(&number).into_iter().for_each(|v| *v = b.clone());
                json.pointer_mut(&other).into_iter().for_each(|v| *v = a.clone());
            }
        }
        // A number moves a little, doubles, or turns round.
        2 | 3 => {
            let moves = [1, -1, 2, 4, -4, 12, 100];
            let by = moves[random.below(moves.len())];
            let double = random.below(3) == 0;
            if let Some(value) = json.pointer_mut(&number)
                && let Some(old) = value.as_i64()
            {
                *value = if double { json!(old.saturating_mul(2)) } else { json!(old.saturating_add(by)) };
            }
        }
        4 => json.pointer_mut(&number).into_iter().for_each(|v| *v = strange(random)),
        5 => json.pointer_mut(&any).into_iter().for_each(|v| *v = strange(random)),
        // A member or element is taken out.
        6 => match json.pointer_mut(&parent) {
            Some(Value::Object(members)) => {
                members.remove(&member);
            }
            Some(Value::Array(list)) => {
                let at = random.below(list.len());
                if at < list.len() {
                    list.remove(at);
                }
            }
            _ => {}
        },
        // An element is there twice, or many times.
        7 => {
            let times = [1, 1, 2, 50][random.below(4)];
            if let Some(Value::Array(list)) = json.pointer_mut(&parent)
                && let Some(element) = member.parse::<usize>().ok().and_then(|i| list.get(i).cloned())
            {
                list.extend(std::iter::repeat_n(element, times));
            }
        }
        // Something stands where something else did.
        8 => {
            let from = all[random.below(all.len())].clone();
            if let Some(value) = json.pointer(&from).cloned() {
                json.pointer_mut(&any).into_iter().for_each(|v| *v = value.clone());
            }
        }
        // Nodes in a circle, or a long chain.
        _ => {
            let count = json["nodes"].as_array().map_or(0, Vec::len);
            if count > 0 {
                let (a, b) = (random.below(count), random.below(count));
                let back = random.below(2) == 0;
                for (parent, child) in [(a, b), (b, a)].into_iter().take(1 + usize::from(back)) {
                    if let Some(Value::Object(node)) = json.pointer_mut(&format!("/nodes/{parent}")) {
                        node.insert("children".to_owned(), json!([child]));
                    }
                }
            }
        }
    }
}

/// Damages data where a buffer view says it lies.
fn damage(json: &Value, binary: &mut [u8], random: &mut Random) {
    if binary.is_empty() {
        return;
    }
    for _ in 0..=random.below(4) {
        let at = random.below(binary.len());
        let views = json["bufferViews"].as_array().map_or(0, Vec::len);
        let view = &json["bufferViews"][random.below(views.max(1))];
        // Into a view's first bytes, where headers and counts are, or anywhere.
        let start = (view["byteOffset"].as_u64().unwrap_or(0) as usize).wrapping_add(random.below(40));
        let at = if random.below(2) == 0 { start % binary.len() } else { at };
        match random.below(4) {
            0 => binary[at] ^= 1 << random.below(8),
            1 => binary[at] = [0, 0xFF, 0x7F, 0x80][random.below(4)],
            2 => {
                let value = [f32::NAN, f32::INFINITY, f32::MAX, -0.0][random.below(4)].to_le_bytes();
                binary.iter_mut().skip(at & !3).zip(value).for_each(|(byte, new)| *byte = new);
            }
            _ => binary.iter_mut().skip(at).take(8).for_each(|byte| *byte = 0xFF),
        }
    }
}

#[test]
fn changed_structures_never_panic_or_take_long() {
    let seeds = seeds();
    for (i, (json, binary)) in seeds.iter().enumerate() {
        let scene = load_bytes_with(&glb(json, binary), "seed", None, &options());
        check(&scene.unwrap_or_else(|e| panic!("seed {i}: {e}")));
    }
    let inputs = if std::env::var_os("PELLUCID_TEST_FULL").is_some() { 100_000 } else { 4_000 };
    let mut random = Random(2026);
    let (mut loaded, mut over, mut slowest) = (0, 0, Duration::ZERO);
    for _ in 0..inputs {
        let (json, binary) = &seeds[random.below(seeds.len())];
        let (mut json, mut binary) = (json.clone(), binary.clone());
        for _ in 0..=random.below(3) {
            change(&mut json, &mut random);
        }
        if random.below(3) == 0 {
            damage(&json, &mut binary, &mut random);
        }
        let variant = (random.below(4) == 0).then(|| "steel".to_owned());
        let options = ImportOptions { variant, ..options() };
        let bytes = glb(&json, &binary);
        let began = Instant::now();
        let outcome = load_bytes_with(&bytes, "test", None, &options);
        let took = began.elapsed();
        slowest = slowest.max(took);
        assert!(took < LONGEST, "{took:?} for {json}");
        match outcome {
            Ok(scene) => {
                check(&scene);
                loaded += 1;
            }
            Err(ImportError::Limit { .. }) => over += 1,
            Err(e) => assert!(!e.to_string().contains('\n'), "{e:?}"),
        }
    }
    println!("{inputs} inputs: {loaded} loaded, {over} over a limit, the slowest took {slowest:?}");
    assert!(loaded > inputs / 20 && over > 0, "{loaded} loaded, {over} over a limit");
}
