//! Instances, material variants and hidden nodes.

use glam::DVec3;
use serde_json::json;

use super::*;
use crate::import::{ImportOptions, Limits, load_bytes_with};

/// A quad shown three times.
pub(super) fn instanced() -> Builder {
    let mut file = Builder::quad();
    let moves = file.accessor(&floats(&[0., 0., 0., 5., 0., 0., 0., 7., 0.]), 5126, "VEC3", 3, false);
    // A quarter turn about z, in normalized bytes: 90 of 127 twice.
    let turns = file.accessor(&[0, 0, 0, 127, 0, 0, 90, 90, 0, 0, 0, 127], 5120, "VEC4", 3, true);
    let sizes = file.accessor(&floats(&[1., 1., 1., 2., 2., 2., 1., 3., 1.]), 5126, "VEC3", 3, false);
    let attributes = json!({"TRANSLATION": moves, "ROTATION": turns, "SCALE": sizes});
    file.json["nodes"] = json!([{
        "mesh": 0, "name": "bolt", "translation": [1, 0, 0],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}},
    }]);
    file.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    file
}

const INSIDE: &str = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes";

#[test]
fn instances_are_parts_that_share_a_mesh() {
    let scene = instanced().scene();
    assert_eq!((scene.meshes.len(), scene.parts.len(), scene.nodes.len()), (1, 3, 4));
    let names: Vec<&str> = scene.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["bolt #1", "bolt #2", "bolt #3"]);
    assert!(scene.parts.iter().all(|p| p.mesh == 0));
    let corner = |i: usize| scene.parts[i].world_from_part.transform_point3(DVec3::new(1.0, 0.0, 0.0)) + scene.origin;
    for (i, expected) in
        [DVec3::new(2.0, 0.0, 0.0), DVec3::new(6.0, 2.0, 0.0), DVec3::new(2.0, 7.0, 0.0)].iter().enumerate()
    {
        assert!(corner(i).distance(*expected) < 1e-6, "{}", corner(i));
    }
    assert_eq!(scene.nodes[0].children, [1, 2, 3]);
    assert_eq!(scene.triangle_count(), 6);
    // Nothing to say but that normals were made.
    assert_eq!(scene.notices.len(), 1, "{:?}", scene.notices);
}

#[test]
fn instances_are_checked() {
    instanced().set(&format!("{INSIDE}/ROTATION"), json!(0)).refused("ROTATION: cannot be");
    instanced().set(&format!("{INSIDE}/SCALE"), json!(99)).refused("SCALE: refers to accessor 99");
    instanced().set("/accessors/2/count", json!(2)).refused("elements");
    instanced().set(INSIDE, json!({"_ID": 0})).refused("none of TRANSLATION");
    instanced().set("/nodes/0/extensions/EXT_mesh_gpu_instancing", json!({})).refused("EXT_mesh_gpu_instancing");
    let mut broken = instanced();
    let at = broken.json["bufferViews"][2]["byteOffset"].as_u64().unwrap() as usize;
    broken.binary[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let scene = broken.scene();
    assert_eq!(scene.parts.len(), 2);
    assert_tells(&scene, NoticeKind::Repaired, "instances whose place is not finite");
    let mut without = instanced();
    without.json["nodes"][0].as_object_mut().unwrap().remove("mesh");
    assert_tells(&without.scene(), NoticeKind::Repaired, "have no mesh");
    let limits = Limits { instances: 2, ..Limits::default() };
    let options = ImportOptions { limits, ..ImportOptions::default() };
    let error = load_bytes_with(&instanced().bytes(), "test", None, &options).unwrap_err();
    assert!(matches!(error, ImportError::Limit { .. }) && error.to_string().contains("instances"), "{error}");
}

/// A quad that is grey by default, red as "rubber" and blue as "steel".
pub(super) fn variants() -> Builder {
    let material = |name: &str| json!({"name": name});
    Builder::quad()
        .set("/materials", json!([material("grey"), material("red"), material("blue")]))
        .set("/meshes/0/primitives/0/material", json!(0))
        .set("/extensionsUsed", json!(["KHR_materials_variants"]))
        .set(
            "/extensions",
            json!({"KHR_materials_variants": {"variants": [{"name": "rubber"}, {"name": "steel"}, {"name": "bare"}]}}),
        )
        .set(
            "/meshes/0/primitives/0/extensions",
            json!({"KHR_materials_variants": {"mappings": [
                {"material": 1, "variants": [0]}, {"material": 2, "variants": [1]},
            ]}}),
        )
}

#[test]
fn variants_are_chosen_by_name() {
    let shown = |variant: Option<&str>| {
        let options = ImportOptions { variant: variant.map(str::to_owned), ..ImportOptions::default() };
        let scene = load_bytes_with(&variants().bytes(), "test", None, &options).map_err(|e| e.to_string())?;
        assert_eq!(scene.variants, ["rubber", "steel", "bare"]);
        Ok::<String, String>(scene.materials[scene.meshes[0].primitives[0].material].name.clone())
    };
    assert_eq!(shown(None).unwrap(), "grey");
    assert_eq!(shown(Some("rubber")).unwrap(), "red");
    assert_eq!(shown(Some("steel")).unwrap(), "blue");
    // A primitive that says nothing about a variant keeps its own material.
    assert_eq!(shown(Some("bare")).unwrap(), "grey");
    let error = shown(Some("chrome")).unwrap_err();
    assert!(error.ends_with("'chrome' does not exist: the file has 'rubber', 'steel', 'bare'"), "{error}");
    let error = shown(Some("Steel")).unwrap_err();
    assert!(error.ends_with("the file has 'rubber', 'steel', 'bare'; did you mean 'steel'?"), "{error}");
    // Nor has a file of a format without variants any.
    let options = ImportOptions { variant: Some("x".to_owned()), ..ImportOptions::default() };
    for bytes in [&Builder::quad().bytes()[..], b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"] {
        let error = load_bytes_with(bytes, "test", None, &options).unwrap_err().to_string();
        assert_eq!(error, "test: variant: 'x' does not exist: the file has no variants");
    }
    // A long list is cut.
    let many: Vec<String> = (0..50).map(|i| format!("finish {i}")).collect();
    let error = super::super::unknown_variant("none", &many).in_file("test").to_string();
    assert!(error.ends_with("'finish 39' and 10 more"), "{error}");
}

#[test]
fn variants_are_checked() {
    let mapping = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings/0";
    variants().set(&format!("{mapping}/material"), json!(9)).refused("mappings[0].material: refers to material 9");
    variants().set(&format!("{mapping}/variants"), json!([9])).refused("mappings[0].variants: refers to variant 9");
    variants().set("/extensions/KHR_materials_variants", json!({})).refused("is not a list");
    variants().set("/extensions/KHR_materials_variants/variants/1", json!({})).refused("variants[1]: has no name");
    let twice = variants().set(&format!("{mapping}/variants"), json!([0, 1]));
    assert_tells(&twice.scene(), NoticeKind::Repaired, "mapped twice");
}

#[test]
fn hidden_nodes_are_left_out_with_all_below() {
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    let nodes = json!([
        {"children": [1, 2], "extensions": {"KHR_node_visibility": {"visible": true}}},
        {"mesh": 0, "name": "lid"},
        {"children": [3], "extensions": hidden},
        {"mesh": 0, "name": "inside", "extensions": {"KHR_node_visibility": {"visible": true}}},
    ]);
    let file = Builder::quad().set("/nodes", nodes).set("/extensionsUsed", json!(["KHR_node_visibility"]));
    let scene = file.scene();
    assert_eq!((scene.parts.len(), scene.parts[0].name.as_str(), scene.nodes.len()), (1, "lid", 4));
    assert_tells(&scene, NoticeKind::Ignored, "2 nodes are hidden by the file");
    file.set("/nodes/2/extensions/KHR_node_visibility/visible", json!(3))
        .refused("nodes[2].extensions.KHR_node_visibility");
    let mut instances = instanced();
    instances.json["nodes"][0]["extensions"]["KHR_node_visibility"] = json!({"visible": false});
    assert!(instances.scene().parts.is_empty());
}
