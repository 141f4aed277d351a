use std::sync::Arc;

use super::*;
use crate::scene::{Image, Mesh, SceneCamera, builtin};

/// Splits a GLB after checking its header, and checks every accessor against its view and buffer.
fn checked(bytes: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let json_length = word(12);
    assert_eq!((&bytes[16..20], json_length % 4), (&b"JSON"[..], 0));
    let json: Value = serde_json::from_slice(&bytes[20..20 + json_length]).unwrap();
    let at = 20 + json_length;
    assert_eq!((&bytes[at + 4..at + 8], word(at)), (&b"BIN\0"[..], bytes.len() - at - 8));
    let binary = bytes[at + 8..].to_vec();
    let number = |v: &Value| v.as_u64().unwrap() as usize;
    assert!(number(&json["buffers"][0]["byteLength"]) <= binary.len());
    for view in json["bufferViews"].as_array().unwrap() {
        assert_eq!(number(&view["byteOffset"]) % 4, 0);
        assert!(number(&view["byteOffset"]) + number(&view["byteLength"]) <= binary.len());
    }
    for mesh in json["meshes"].as_array().unwrap() {
        for primitive in mesh["primitives"].as_array().unwrap() {
            let accessor = |v: &Value| json["accessors"][number(v)].clone();
            let data = |a: &Value| {
                let view = &json["bufferViews"][number(&a["bufferView"])];
                let start = number(&view["byteOffset"]);
                binary[start..start + number(&view["byteLength"])].to_vec()
            };
            let position = accessor(&primitive["attributes"]["POSITION"]);
            let count = number(&position["count"]);
            let floats: Vec<f32> =
                data(&position).chunks(4).map(|c| f32::from_le_bytes(c.try_into().unwrap())).collect();
            assert_eq!(floats.len(), 3 * count);
            for axis in 0..3 {
                let values = || floats.iter().skip(axis).step_by(3).copied();
                assert_eq!(position["min"][axis].as_f64().unwrap() as f32, values().fold(f32::INFINITY, f32::min));
                assert_eq!(position["max"][axis].as_f64().unwrap() as f32, values().fold(f32::NEG_INFINITY, f32::max));
            }
            let normal = accessor(&primitive["attributes"]["NORMAL"]);
            assert_eq!((number(&normal["count"]), data(&normal).len()), (count, 12 * count));
            let indices = accessor(&primitive["indices"]);
            let wide = indices["componentType"] == U32;
            let data = data(&indices);
            let size = if wide { 4 } else { 2 };
            assert_eq!(data.len(), size * number(&indices["count"]));
            for c in data.chunks(size) {
                let index = c.iter().rev().fold(0_usize, |i, &b| i << 8 | usize::from(b));
                assert!(index < count);
            }
        }
    }
    (json, binary)
}

#[test]
fn small_scenes_are_valid_and_keep_names_sharing_and_cameras() {
    let scene = builtin::build("touching").unwrap();
    let (json, _) = checked(&write_glb(&scene).unwrap());
    assert_eq!(json["nodes"][1]["name"], "left");
    assert_eq!(json["nodes"][0]["children"], json!([1, 2]));
    assert_eq!(json["nodes"][2]["translation"], json!([1.0, 0.0, 0.0]));
    let (json, _) = checked(&write_glb(&builtin::build("quads?parts=3").unwrap()).unwrap());
    assert_eq!(json["cameras"][0]["orthographic"]["ymag"], 1.0);
    let (json, _) = checked(&write_glb(&builtin::build("stack").unwrap()).unwrap());
    assert_eq!(json["materials"][0]["alphaMode"], "BLEND");
}

#[test]
fn textures_transforms_and_shared_meshes_are_written() {
    let texture = TextureRef { texture: 0, uv_set: 1, uv_transform: [[0.0, 2.0, 0.5], [-3.0, 0.0, 0.25]] };
    let mesh = Mesh {
        primitives: vec![Primitive {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            uvs: [vec![[0.0; 2]; 3], vec![[0.5; 2]; 3]],
            colors: vec![[1.0; 4]; 3],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        }],
        ..Mesh::default()
    };
    let shear = DMat4::from_cols_array(&[1., 0., 0., 0., 0.5, 1., 0., 0., 0., 0., 1., 0., 1e7, 0., 0., 1.]);
    let scene = Scene {
        nodes: vec![Node::root("a", Some(1), shear), Node::root("b", Some(1), DMat4::IDENTITY)],
        meshes: vec![Mesh::default(), mesh],
        materials: vec![Material {
            base_color_texture: Some(texture),
            emissive: [4.0, 2.0, 0.0],
            unlit: true,
            ..Material::default()
        }],
        textures: vec![Texture {
            image: 0,
            wrap: [Wrap::Repeat; 2],
            mag_linear: true,
            min_linear: true,
            mip: Mip::Linear,
        }],
        images: vec![Arc::new(Image { name: "dot".to_owned(), width: 1, height: 1, rgba: vec![1, 2, 3, 4] })],
        cameras: vec![SceneCamera {
            name: "eye".to_owned(),
            world_from_camera: DMat4::IDENTITY,
            projection: Projection::Perspective { fov_y: 0.5 },
        }],
        ..Scene::default()
    };
    let (json, binary) = checked(&write_glb(&scene.clone().finish().unwrap()).unwrap());
    assert_eq!((&json["nodes"][0]["mesh"], &json["nodes"][1]["mesh"]), (&json!(0), &json!(0)), "empty mesh left out");
    assert!(json["nodes"][0]["matrix"].is_array(), "a shear is no translation, rotation and scale");
    let transform =
        &json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"];
    let (rotation, sx, sy) = (
        transform["rotation"].as_f64().unwrap(),
        transform["scale"][0].as_f64().unwrap(),
        transform["scale"][1].as_f64().unwrap(),
    );
    let (sin, cos) = rotation.sin_cos();
    for (found, wanted) in [(sx * cos, 0.0), (sy * sin, 2.0), (-sx * sin, -3.0), (sy * cos, 0.0)] {
        assert!((found - wanted).abs() < 1e-5, "{transform}");
    }
    let view = &json["bufferViews"][json["images"][0]["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    let png = image::load_from_memory(&binary[start..start + view["byteLength"].as_u64().unwrap() as usize]).unwrap();
    assert_eq!(png.to_rgba8().into_raw(), vec![1, 2, 3, 4]);
    assert_eq!(json["materials"][0]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], 4.0);
    assert_eq!(json["extensionsUsed"].as_array().unwrap().len(), 3);
}

#[test]
fn numbers_that_are_not_finite_and_wrong_images_are_refused() {
    let mut scene = builtin::build("touching").unwrap();
    scene.meshes[0].primitives[0].positions[0][1] = f32::NAN;
    assert!(matches!(write_glb(&scene), Err(GlbError::NotFinite { .. })));
    let mut scene = builtin::build("touching").unwrap();
    scene.images.push(Arc::new(Image { name: "short".to_owned(), width: 2, height: 2, rgba: vec![0; 3] }));
    assert!(matches!(write_glb(&scene), Err(GlbError::Image { index: 0, .. })));
}

#[test]
fn the_assets_are_valid_share_their_meshes_and_are_small_enough_to_commit() {
    let folder = tempfile::tempdir().unwrap();
    let files = crate::export::assets::write_assets(&folder.path().join("assets")).unwrap();
    assert_eq!(files.len(), 2);
    for (file, name) in files.iter().zip(["gearbox", "engine"]) {
        assert!(file.ends_with(format!("{name}.glb")));
        let bytes = std::fs::read(file).unwrap();
        assert!(bytes.len() < 6_000_000, "{name}: {} bytes", bytes.len());
        let (json, _) = checked(&bytes);
        let count = |key: &str| json[key].as_array().unwrap().len();
        let scene = builtin::build(name).unwrap();
        assert_eq!((count("nodes"), count("meshes")), (scene.nodes.len(), scene.meshes.len()));
    }
    assert!(matches!(
        crate::export::assets::write_assets(&files[0]),
        Err(crate::export::assets::AssetError::Write { .. })
    ));
}
