//! Materials, textures and extensions.

use serde_json::json;

use super::*;
use crate::scene::{AlphaMode, Material, Mip, TextureRef, Wrap};

/// A quad with one material and two textures of one image.
fn with(material: Value) -> Builder {
    let mut file = Builder::quad().attribute("TEXCOORD_0", floats(&[0.; 8]), 5126, "VEC2", 4, false).attribute(
        "TEXCOORD_1",
        floats(&[0.; 8]),
        5126,
        "VEC2",
        4,
        false,
    );
    let view = file.view(&png(image::DynamicImage::new_rgb8(1, 1)));
    file.json["images"] = json!([{"bufferView": view}]);
    file.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9985}]);
    file.json["textures"] = json!([{"source": 0}, {"source": 0, "sampler": 0}]);
    file.json["materials"] = json!([material]);
    file.primitive()["material"] = 0.into();
    file
}

fn identity(texture: usize, uv_set: u32) -> Option<TextureRef> {
    Some(TextureRef { texture, uv_set, uv_transform: TextureRef::IDENTITY })
}

#[test]
fn all_members_are_read() {
    let scene = with(json!({
        "name": "paint",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.25, 1, 0.75], "metallicFactor": 0.5, "roughnessFactor": 0.25,
            "baseColorTexture": {"index": 1}, "metallicRoughnessTexture": {"index": 0, "texCoord": 1},
        },
        "normalTexture": {"index": 0, "scale": -2},
        "occlusionTexture": {"index": 1, "strength": 0.5},
        "emissiveTexture": {"index": 0},
        "emissiveFactor": [1, 0.5, 0],
        "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
        "extensions": {"KHR_materials_unlit": {}, "KHR_materials_emissive_strength": {"emissiveStrength": 4}},
    }))
    .set("/extensionsUsed", json!(["KHR_materials_unlit", "KHR_materials_emissive_strength"]))
    .scene();
    let expected = Material {
        name: "paint".into(),
        base_color: [0.5, 0.25, 1.0, 0.75],
        base_color_texture: identity(1, 0),
        metallic: 0.5,
        roughness: 0.25,
        metallic_roughness_texture: identity(0, 1),
        normal_texture: identity(0, 0),
        normal_scale: -2.0,
        occlusion_texture: identity(1, 0),
        occlusion_strength: 0.5,
        emissive: [4.0, 2.0, 0.0],
        emissive_texture: identity(0, 0),
        alpha_mode: AlphaMode::Mask { cutoff: 0.25 },
        double_sided: true,
        unlit: true,
    };
    assert_eq!(scene.materials, [expected]);
    assert_eq!(
        (scene.textures[1].wrap, scene.textures[1].mip),
        ([Wrap::ClampToEdge, Wrap::MirroredRepeat], Mip::Nearest)
    );
    assert!(!scene.textures[1].mag_linear && scene.textures[1].min_linear);
    assert_eq!((scene.textures[0].wrap, scene.textures[0].mip), ([Wrap::Repeat; 2], Mip::Linear));
    assert_eq!(with(json!({"alphaMode": "BLEND"})).scene().materials[0].alpha_mode, AlphaMode::Blend);
    assert_eq!(with(json!({})).scene().materials[0], Material::default());
}

#[test]
fn a_primitive_without_a_material_gets_the_default() {
    let mut file = with(json!({"name": "other"}));
    file.primitive().as_object_mut().unwrap().remove("material");
    let scene = file.scene();
    assert_eq!(scene.meshes[0].primitives[0].material, 1);
    assert_eq!(scene.materials[1], Material::default());
    file.primitive()["material"] = 5.into();
    file.refused("primitives[0].material: refers to material 5");
}

#[test]
fn texture_transforms() {
    let transform = json!({"index": 0, "extensions": {"KHR_texture_transform":
        {"offset": [0.5, 0.25], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2, 3], "texCoord": 1}}});
    let scene = with(json!({
        "pbrMetallicRoughness": {"baseColorTexture": transform},
        "normalTexture": transform, "occlusionTexture": transform,
    }))
    .scene();
    let material = &scene.materials[0];
    for slot in [material.base_color_texture, material.normal_texture, material.occlusion_texture] {
        let slot = slot.unwrap();
        assert_eq!(slot.uv_set, 1);
        // Scaled, turned counter-clockwise as seen in an image with v down (u to −v, v to u), moved.
        let expected = [[0.0, 3.0, 0.5], [-2.0, 0.0, 0.25]];
        for (row, expected) in slot.uv_transform.iter().flatten().zip(expected.iter().flatten()) {
            assert!((row - expected).abs() < 1e-6, "{:?}", slot.uv_transform);
        }
    }
    let bad = json!({"normalTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": 3}}}});
    with(bad).refused("materials[0].normalTexture.extensions.KHR_texture_transform");
}

#[test]
fn bad_references_and_values() {
    with(json!({"normalTexture": {"index": 9}})).refused("materials[0].normalTexture.index: refers to texture 9");
    with(json!({})).set("/textures/0/source", json!(3)).refused("textures[0].source");
    with(json!({})).set("/textures/0/sampler", json!(3)).refused("textures[0].sampler");
    let scene = with(json!({"emissiveTexture": {"index": 0, "texCoord": 2}})).scene();
    assert_eq!(scene.materials[0].emissive_texture, None);
    assert_tells(&scene, NoticeKind::Ignored, "materials[0].emissiveTexture");
    let scene = with(json!({"alphaMode": "GLASS", "pbrMetallicRoughness": {"roughnessFactor": 7}})).scene();
    assert_tells(&scene, NoticeKind::Repaired, "materials[0].alphaMode");
    assert_tells(&scene, NoticeKind::Repaired, "roughnessFactor: 7 is out of range");
    assert_eq!(scene.materials[0].roughness, 1.0);
    let scene = with(json!({})).set("/samplers/0/wrapS", json!(1)).scene();
    assert_tells(&scene, NoticeKind::Repaired, "textures[1].sampler");
    // A texture whose image only an extension names: dropped, and the other keeps its meaning.
    let scene = with(json!({"emissiveTexture": {"index": 1}, "normalTexture": {"index": 0}}))
        .set("/textures/0", json!({"extensions": {"MSFT_texture_dds": {"source": 0}}}))
        .scene();
    assert_eq!((scene.textures.len(), scene.materials[0].emissive_texture), (1, identity(0, 0)));
    assert_eq!(scene.materials[0].normal_texture, None);
    assert_tells(&scene, NoticeKind::Ignored, "textures[0]");
    assert_tells(&scene, NoticeKind::Ignored, "MSFT_texture_dds");
}

#[test]
fn extensions_are_told_or_refused() {
    let used = |name: &str| Builder::quad().set("/extensionsUsed", json!([name])).scene();
    assert_tells(&used("KHR_materials_transmission"), NoticeKind::Approximated, "KHR_materials_transmission");
    assert_tells(&used("KHR_lights_punctual"), NoticeKind::Ignored, "KHR_lights_punctual");
    assert_tells(&used("VENDOR_thing"), NoticeKind::Ignored, "VENDOR_thing: the extension is not known");
    assert_tells(&used("EXT_texture_avif"), NoticeKind::Ignored, "substitute");
    let required = |name: &str| Builder::quad().set("/extensionsRequired", json!([name]));
    for name in ["EXT_texture_avif", "MSFT_texture_dds", "X_y"] {
        let error = required(name).load().unwrap_err();
        assert!(matches!(&error, ImportError::Unsupported { extension, .. } if extension == name), "{error}");
        assert!(error.to_string().contains("extensionsRequired[0]") && error.to_string().contains(name));
    }
    let visual = required("KHR_materials_clearcoat").scene();
    assert_tells(&visual, NoticeKind::Approximated, "KHR_materials_clearcoat");
    assert_tells(&required("NEW_materials_glitter").scene(), NoticeKind::Ignored, "NEW_materials_glitter");
    // Undeclared, and with nonsense inside: still told, never in the way.
    let inside = with(json!({"extensions": {"KHR_materials_sheen": {"sheenRoughnessFactor": "x"}}})).scene();
    assert_tells(&inside, NoticeKind::Approximated, "KHR_materials_sheen");
    let volume = with(json!({"extensions": {"KHR_materials_volume": {"attenuationColor": [-0.5, 1, 1]}}})).scene();
    assert_tells(&volume, NoticeKind::Repaired, "attenuationColor: -0.5 is out of range");
    let old = with(json!({"extensions": {"KHR_materials_pbrSpecularGlossiness":
        {"diffuseFactor": [1, 0, 0, 1], "glossinessFactor": 0.75}}}));
    assert_eq!(old.scene().materials[0].base_color, [1.0, 0.0, 0.0, 1.0]);
    assert_eq!((old.scene().materials[0].metallic, old.scene().materials[0].roughness), (0.0, 0.25));
}

#[test]
fn a_flood_of_notices_is_counted() {
    let bad = json!({"pbrMetallicRoughness": {"roughnessFactor": -1}});
    let scene = Builder::quad().set("/materials", vec![bad; 1000].into()).scene();
    assert!(scene.notices.len() < 250);
    assert_tells(&scene, NoticeKind::Ignored, "800 more notices");
}
