//! Thousands of damaged files: any outcome is fine but a panic.

use super::*;
use crate::import::{ImportOptions, Limits, load_bytes_with};

/// A small generator with a fixed sequence.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

/// Everything in one small file: textures, normal map, sparse data, colours, cameras, hierarchy.
pub(super) fn rich() -> Builder {
    let pixel = png(image::DynamicImage::new_rgb8(2, 2));
    let mut file = Builder::quad()
        .attribute("TEXCOORD_0", shorts(&[0, 0, 65535, 0, 65535, 65535, 0, 65535]), 5123, "VEC2", 4, true)
        .attribute("COLOR_0", vec![200; 16], 5121, "VEC4", 4, true)
        .attribute("NORMAL", floats(&[0., 0., 1.].repeat(4)), 5126, "VEC3", 4, false);
    let image = file.view(&pixel);
    let at = file.view(&[1]);
    let values = file.view(&floats(&[2.0, 0.0, 0.1]));
    file.json["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": {"bufferView": at, "componentType": 5121},
        "values": {"bufferView": values},
    });
    file.json["images"] = json!([{"bufferView": image, "mimeType": "image/png"}]);
    file.json["samplers"] = json!([{"wrapS": 33071, "magFilter": 9728, "minFilter": 9987}]);
    file.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    file.json["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 0.5, 0.25, 1]},
        "normalTexture": {"index": 0, "scale": 0.5},
        "alphaMode": "MASK",
        "extensions": {"KHR_materials_unlit": {}},
    }]);
    file.primitive()["material"] = 0.into();
    file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]);
    file.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2]},
        {"mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, -1, 2]},
        {"camera": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
    ]);
    file.json["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    file
}

pub(super) fn options() -> ImportOptions {
    let limits = Limits {
        bytes: 1 << 20,
        vertices: 1 << 14,
        triangles: 1 << 14,
        image_side: 64,
        image_pixels: 1 << 12,
        node_depth: 32,
        instances: 64,
        ..Limits::default()
    };
    ImportOptions { limits, ..ImportOptions::default() }
}

/// All that a finished scene promises.
pub(super) fn check(scene: &Scene) {
    for primitive in scene.meshes.iter().flat_map(|m| &m.primitives) {
        let count = primitive.positions.len();
        assert!(primitive.triangles.as_flattened().iter().all(|&v| (v as usize) < count));
        assert!(primitive.positions.iter().chain(&primitive.normals).flatten().all(|c| c.is_finite()));
        assert!(primitive.tangents.iter().flatten().all(|c| c.is_finite()));
        assert!(primitive.material < scene.materials.len());
        let [a, b] = [primitive.uvs[0].len(), primitive.uvs[1].len()];
        for length in [primitive.tangents.len(), a, b, primitive.colors.len()] {
            assert!(length == 0 || length == count);
        }
        assert_eq!(primitive.normals.len(), count);
    }
    for reference in scene.materials.iter().flat_map(|m| m.texture_refs()) {
        assert!(scene.textures[reference.texture].image < scene.images.len() && reference.uv_set < 2);
    }
    assert!(scene.parts.iter().all(|p| p.world_from_part.is_finite()));
}

#[test]
fn damaged_bytes_never_panic() {
    let good = rich().bytes();
    check(&load_bytes_with(&good, "test", None, &options()).unwrap());
    let mut random = Random(7);
    let mut loaded = 0;
    for _ in 0..3000 {
        let mut bytes = good.clone();
        for _ in 0..=random.below(3) {
            let at = random.below(bytes.len());
            match random.below(6) {
                0 => bytes[at] ^= 1 << random.below(8),
                1 => bytes[at] = [0, 0xFF, b'9', b'-', b'"', b'e'][random.below(6)],
                2 => bytes.truncate(at),
                3 => bytes.insert(at, random.below(256) as u8),
                4 => {
                    bytes.remove(at);
                }
                _ => bytes[at] = random.below(256) as u8,
            }
            if bytes.is_empty() {
                break;
            }
        }
        // Half of them with a length that fits again, or nothing but the header would be tested.
        if random.below(2) == 0 && bytes.len() > 12 {
            let length = bytes.len() as u32;
            bytes[8..12].copy_from_slice(&length.to_le_bytes());
        }
        if let Ok(scene) = load_bytes_with(&bytes, "test", None, &options()) {
            check(&scene);
            loaded += 1;
        }
    }
    assert!(loaded > 100, "{loaded} were harmless enough to load");
}

/// The paths of all values below `value`.
fn paths(value: &Value, path: &str, out: &mut Vec<String>) {
    out.push(path.to_owned());
    match value {
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, v)| paths(v, &format!("{path}/{i}"), out));
        }
        Value::Object(members) => members.iter().for_each(|(k, v)| paths(v, &format!("{path}/{k}"), out)),
        _ => {}
    }
}

#[test]
fn damaged_json_never_panics() {
    let good = rich();
    let mut json = good.json.clone();
    json["buffers"] = json!([{"byteLength": good.binary.len()}]);
    let mut all = Vec::new();
    paths(&json, "", &mut all);
    let replacements = [
        json!(null),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(3),
        json!(4),
        json!(5),
        json!(6),
        json!(255),
        json!(5121),
        json!(5125),
        json!(5126),
        json!(65535),
        json!(u32::MAX),
        json!(u64::MAX),
        json!(1e39),
        json!(-0.5),
        json!(1e-45),
        json!(""),
        json!("VEC2"),
        json!("MAT3"),
        json!("BLEND"),
        json!(true),
        json!([]),
        json!({}),
        json!([0]),
        json!([1, 0]),
        json!([3e38, 3e38, 3e38]),
        json!([0, 0, 0, 0]),
    ];
    let mut random = Random(11);
    let mut loaded = 0;
    for _ in 0..3000 {
        let mut json = json.clone();
        for _ in 0..=random.below(2) {
            if let Some(value) = json.pointer_mut(&all[1 + random.below(all.len() - 1)]) {
                *value = replacements[random.below(replacements.len())].clone();
            }
        }
        if let Ok(scene) = load_bytes_with(&glb(&json, &good.binary), "test", None, &options()) {
            check(&scene);
            loaded += 1;
        }
    }
    assert!(loaded > 300, "{loaded} were harmless enough to load");
}
