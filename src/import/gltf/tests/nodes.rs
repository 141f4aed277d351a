//! Hierarchy, transforms, scenes and cameras.

use glam::DVec3;
use serde_json::json;

use super::*;
use crate::math::Projection;

fn with_nodes(nodes: Value, roots: Value) -> Builder {
    Builder::quad().set("/nodes", nodes).set("/scenes/0/nodes", roots)
}

#[test]
fn shared_meshes_stay_shared_and_names_are_kept() {
    let nodes = json!([
        {"children": [1, 2], "name": "assembly", "translation": [10, 0, 0]},
        {"mesh": 0, "name": "left", "scale": [-1, 2, 3]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1]},
        {"mesh": 0, "name": "not in the scene"},
    ]);
    let scene = with_nodes(nodes, json!([0])).scene();
    assert_eq!((scene.meshes.len(), scene.nodes.len(), scene.parts.len()), (1, 3, 2));
    assert_eq!((scene.parts[0].name.as_str(), scene.parts[1].name.as_str()), ("left", "mesh"));
    let corner = |part: usize| scene.parts[part].world_from_part.transform_point3(DVec3::ONE) + scene.origin;
    assert_eq!(corner(0), DVec3::new(9.0, 2.0, 3.0));
    assert_eq!(corner(1), DVec3::new(11.0, 6.0, 1.0));
    assert!(scene.parts[0].world_from_part.determinant() < 0.0);
    assert_eq!(scene.nodes[0].children, [1, 2]);
    assert_eq!(scene.nodes[2].parent, Some(0));
}

#[test]
fn rotation_is_applied_between_scale_and_translation() {
    let turn = std::f32::consts::FRAC_1_SQRT_2;
    let nodes = json!([{"mesh": 0, "translation": [1, 0, 0], "rotation": [0, 0, turn, turn], "scale": [2, 1, 1]}]);
    let scene = with_nodes(nodes, json!([0])).scene();
    let x = scene.parts[0].world_from_part.transform_point3(DVec3::X) + scene.origin;
    assert!(x.distance(DVec3::new(1.0, 2.0, 0.0)) < 1e-6, "{x}");
}

#[test]
fn a_hierarchy_that_is_no_tree_is_refused() {
    with_nodes(json!([{"children": [1]}, {"children": [2]}, {"children": [0]}]), json!([])).refused("loop");
    with_nodes(json!([{"children": [0]}]), json!([])).refused("loop");
    with_nodes(json!([{"children": [2]}, {"children": [2]}, {}]), json!([0, 1])).refused("nodes[1].children[0]");
    with_nodes(json!([{"children": [1, 1]}, {}]), json!([0])).refused("nodes[0].children[1]");
    with_nodes(json!([{"children": [1]}, {"mesh": 0}]), json!([0, 1])).refused("scenes[0].nodes[1]");
    with_nodes(json!([{"children": [7]}]), json!([0])).refused("nodes[0].children[0]: refers to node 7");
    with_nodes(json!([{"mesh": 0}]), json!([3])).refused("scenes[0].nodes[0]");
    with_nodes(json!([{"mesh": 1}]), json!([0])).refused("nodes[0].mesh");
    with_nodes(json!([{"camera": 0}]), json!([0])).refused("nodes[0].camera");
    let chain: Vec<Value> = (1..=3000).map(|i| json!({"children": [i]})).chain([json!({"mesh": 0})]).collect();
    with_nodes(chain.into(), json!([0])).refused("levels of nodes");
}

#[test]
fn bad_transforms() {
    with_nodes(json!([{"mesh": 0, "translation": [0, 1e39, 0]}]), json!([0])).refused("nodes[0].translation");
    let far = json!([{"children": [1], "scale": [1e38, 1, 1]}, {"children": [2], "scale": [1e38, 1, 1]},
        {"mesh": 0, "scale": [1e38, 1, 1]}]);
    with_nodes(far, json!([0])).refused("too large");
    let odd = json!([{"mesh": 0, "rotation": [0, 0, 0, 3], "scale": [1, 1, 1]}]);
    let scene = with_nodes(odd, json!([0])).scene();
    assert_tells(&scene, NoticeKind::Repaired, "nodes[0].rotation");
    assert_eq!(scene.parts[0].world_from_part, glam::DMat4::IDENTITY);
    let projective = json!([{"mesh": 0, "matrix": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}]);
    assert_tells(&with_nodes(projective, json!([0])).scene(), NoticeKind::Repaired, "last row");
}

#[test]
fn the_default_scene_is_shown_or_the_first_or_everything() {
    let two = Builder::quad()
        .set("/nodes", json!([{"mesh": 0, "name": "a"}, {"mesh": 0, "name": "b"}]))
        .set("/scenes", json!([{"nodes": [0]}, {"nodes": [1]}]));
    let chosen = two.set("/scene", json!(1));
    assert_eq!(chosen.scene().parts[0].name, "b");
    assert_tells(&chosen.scene(), NoticeKind::Ignored, "2 scenes: only scenes[1]");
    let mut first = chosen;
    first.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(first.scene().parts[0].name, "a");
    first.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(first.scene().parts.len(), 2);
    assert_tells(&first.scene(), NoticeKind::Approximated, "no scene");
    // glTF allows a scene without nodes.
    assert_tells(&Builder::quad().set("/scenes", json!([{}])).scene(), NoticeKind::Ignored, "empty");
}

#[test]
fn cameras_come_with_their_place() {
    let file = with_nodes(
        json!([{"mesh": 0, "translation": [1000, 0, 0]}, {"camera": 0, "translation": [1000, 0, 4]}, {"camera": 1}]),
        json!([0, 1, 2]),
    )
    .set(
        "/cameras",
        json!([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 1}, "name": "eye"},
               {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 3, "znear": 0, "zfar": 1}}]),
    );
    let scene = file.scene();
    assert!(scene.origin.length() > 900.0, "the scene is re-based");
    assert_eq!(scene.cameras.len(), 2);
    assert_eq!(scene.cameras[0].name, "eye");
    assert_eq!(scene.cameras[0].projection, Projection::Perspective { fov_y: 0.5 });
    let eye = scene.cameras[0].world_from_camera.transform_point3(DVec3::ZERO);
    assert_eq!(eye + scene.origin, DVec3::new(1000.0, 0.0, 4.0));
    assert_eq!(scene.cameras[1].projection, Projection::Orthographic { height: 6.0 });
    let bad = file.set("/cameras/0/perspective/yfov", json!(-1));
    assert_eq!(bad.scene().cameras.len(), 1);
    assert_tells(&bad.scene(), NoticeKind::Ignored, "cameras[0]");
    bad.set("/cameras/1/type", json!("fisheye")).refused("cameras[1].type");
}
