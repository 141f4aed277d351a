//! Accessors, primitives, normals and tangents.

use glam::{DVec3, Vec3};
use serde_json::json;

use super::*;
use crate::scene::Primitive;

fn only(scene: &Scene) -> &Primitive {
    &scene.meshes[0].primitives[0]
}

/// The triangles as positions.
fn soup(scene: &Scene) -> Vec<[[f32; 3]; 3]> {
    let p = only(scene);
    p.triangles.iter().map(|t| t.map(|v| p.positions[v as usize])).collect()
}

const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];

#[test]
fn lists_strips_and_fans_are_wound_alike() {
    let fan: Vec<f32> = [0, 1, 3, 2].iter().flat_map(|&i| SQUARE[3 * i..3 * i + 3].to_vec()).collect();
    for (mode, positions) in [(5, SQUARE.to_vec()), (6, fan)] {
        let scene =
            Builder::new().attribute("POSITION", floats(&positions), 5126, "VEC3", 4, false).set_mode(mode).scene();
        assert_eq!(soup(&scene).len(), 2, "mode {mode}");
        for [a, b, c] in soup(&scene).map_vec() {
            assert!((b - a).cross(c - a).z > 0.5, "mode {mode}: {a} {b} {c}");
        }
    }
    // A strip's stitches are not triangles.
    let strip = Builder::new()
        .attribute("POSITION", floats(&SQUARE), 5126, "VEC3", 4, false)
        .indices(vec![0, 1, 2, 2, 2, 3], 5121, 6)
        .set_mode(5)
        .scene();
    assert_eq!(soup(&strip).len(), 1);
    assert!(!tells(&strip, NoticeKind::Repaired, ""));
}

trait MapVec {
    fn map_vec(self) -> Vec<[Vec3; 3]>;
}

impl MapVec for Vec<[[f32; 3]; 3]> {
    fn map_vec(self) -> Vec<[Vec3; 3]> {
        self.into_iter().map(|t| t.map(Vec3::from)).collect()
    }
}

impl Builder {
    fn set_mode(mut self, mode: u32) -> Builder {
        self.primitive()["mode"] = mode.into();
        self
    }
}

#[test]
fn points_and_lines_are_told_and_bad_modes_refused() {
    for mode in 0..4 {
        let scene = Builder::quad().set_mode(mode).scene();
        assert_tells(&scene, NoticeKind::Ignored, "points or lines");
        assert!(scene.parts.is_empty());
    }
    Builder::quad().set_mode(9).refused("meshes[0].primitives[0].mode");
}

#[test]
fn index_types_and_ranges() {
    for (bytes, component) in [
        (vec![0, 1, 2, 0, 2, 3], 5121),
        (shorts(&[0, 1, 2, 0, 2, 3]), 5123),
        ([0_u32, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect(), 5125),
    ] {
        let scene = Builder::quad().indices(bytes, component, 6).scene();
        assert_eq!(only(&scene).triangles, [[0, 1, 2], [0, 2, 3]]);
    }
    let text = Builder::quad().indices(shorts(&[0, 1, 2, 0, 2, 4]), 5123, 6).refused("primitives[0].indices");
    assert!(text.contains("number 5 is 4, the primitive has 4 vertices"), "{text}");
    Builder::quad().indices(floats(&[0., 1., 2.]), 5126, 3).refused("cannot be Scalar of F32");
    let scene = Builder::quad().indices(vec![0, 1, 2, 3], 5121, 4).scene();
    assert_tells(&scene, NoticeKind::Repaired, "1 indices at the end");
}

#[test]
fn unused_vertices_are_left_out() {
    let scene = Builder::quad().indices(vec![1, 2, 3], 5121, 3).scene();
    assert_eq!(only(&scene).positions, [[1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]);
}

#[test]
fn interleaved_data_with_a_stride() {
    let mut file = Builder::quad();
    let mut bytes = Vec::new();
    for i in 0..4 {
        bytes.extend(floats(&[SQUARE[3 * i], SQUARE[3 * i + 1], 0.5, 0.0, 0.0, -1.0]));
    }
    let view = file.view(&bytes);
    file.json["bufferViews"][view]["byteStride"] = 24.into();
    file.json["accessors"][0] = json!({"bufferView": view, "componentType": 5126, "type": "VEC3", "count": 4});
    let normals = json!({"bufferView": view, "byteOffset": 12, "componentType": 5126, "type": "VEC3", "count": 4});
    file.json["accessors"].as_array_mut().unwrap().push(normals);
    file.primitive()["attributes"]["NORMAL"] = 2.into();
    let scene = file.scene();
    assert_eq!(only(&scene).positions[3], [1.0, 1.0, 0.5]);
    assert_eq!(only(&scene).normals, [[0.0, 0.0, -1.0]; 4]);
    file.json["bufferViews"][view]["byteStride"] = 8.into();
    file.refused("accessors[0]: elements of 12 bytes");
}

#[test]
fn sparse_accessors_with_and_without_a_view() {
    for base in [true, false] {
        let mut file = Builder::quad();
        let at = file.view(&shorts(&[0, 2]));
        let values = file.view(&floats(&[-1., -1., 0., 5., 5., 0.]));
        file.json["accessors"][0]["sparse"] = json!({
            "count": 2,
            "indices": {"bufferView": at, "componentType": 5123},
            "values": {"bufferView": values},
        });
        if !base {
            file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
            file = file.indices(vec![0, 1, 2], 5121, 3);
        }
        let expected = if base { [1., 0., 0.] } else { [0.; 3] };
        // Without a view the three points lie on a line: only the numbers matter here.
        if base {
            let scene = file.scene();
            assert_eq!(only(&scene).positions[..3], [[-1., -1., 0.], expected, [5., 5., 0.]]);
        } else {
            assert_tells(&file.scene(), NoticeKind::Repaired, "1 triangles without area");
        }
        let bad = file.set("/accessors/0/sparse/indices/bufferView", json!(99));
        bad.refused("accessors[0].sparse.indices.bufferView");
    }
    let mut file = Builder::quad();
    let at = file.view(&[9]);
    let values = file.view(&floats(&[0.; 3]));
    file.json["accessors"][0]["sparse"] =
        json!({"count": 1, "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": values}});
    file.refused("element 9 is to be replaced, there are 4");
}

#[test]
fn accessors_out_of_bounds_are_refused_even_unused() {
    let file = || Builder::quad();
    file().set("/accessors/0/count", json!(5)).refused("accessors[0]: 5 elements");
    file().set("/accessors/0/count", json!(u64::MAX)).refused("limit");
    file().set("/accessors/0/byteOffset", json!(u64::MAX)).refused("accessors[0]");
    file().set("/accessors/0/bufferView", json!(9)).refused("accessors[0].bufferView: refers to buffer view 9");
    file().set("/bufferViews/0/byteOffset", json!(u64::MAX)).refused("bufferViews[0]");
    file().set("/bufferViews/0/buffer", json!(1)).refused("bufferViews[0].buffer");
    file().set("/accessors/0/componentType", json!(5124)).refused("accessors[0].componentType");
    file().set("/accessors/0/type", json!("VEC5")).refused("accessors[0].type");
    file().set("/accessors/0/type", json!("VEC2")).refused("attributes.POSITION: cannot be Vec2");
    let mut unused = file();
    unused.accessor(&[0; 4], 5126, "MAT4", 1, false);
    unused.refused("accessors[2]: 1 elements from byte 0 need 64 bytes");
    let normals = file().attribute("NORMAL", floats(&[0., 0., 1.]), 5126, "VEC3", 1, false);
    normals.refused("attributes.NORMAL: has 1 elements, POSITION has 4");
    let mut view_less = file();
    view_less.json["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({"componentType": 5126, "type": "VEC3", "count": 4}));
    view_less.primitive()["attributes"]["NORMAL"] = 2.into();
    assert_tells(&view_less.scene(), NoticeKind::Repaired, "4 normals were zero");
    view_less.set("/accessors/2/count", json!(1 << 25)).refused("accessors[2].count");
}

#[test]
fn every_component_type_and_its_normalization() {
    let uvs = |bytes: Vec<u8>, component, normalized| {
        let scene = Builder::quad().attribute("TEXCOORD_0", bytes, component, "VEC2", 4, normalized).scene();
        (only(&scene).uvs[0].clone(), tells(&scene, NoticeKind::Repaired, "KHR_mesh_quantization"))
    };
    assert_eq!(uvs(vec![0, 255, 51, 0, 0, 0, 0, 0], 5121, true).0[..2], [[0.0, 1.0], [0.2, 0.0]]);
    assert_eq!(uvs(shorts(&[65535, 0, 13107, 0, 0, 0, 0, 0]), 5123, true).0[..2], [[1.0, 0.0], [0.2, 0.0]]);
    assert_eq!(uvs(floats(&[-3.5, 2.0, 0., 0., 0., 0., 0., 0.]), 5126, false).0[0], [-3.5, 2.0]);
    let (signed, told) = uvs(vec![0x80, 0x81, 127, 0, 0, 0, 0, 0], 5120, true);
    assert_eq!((signed[0], signed[1][0], told), ([-1.0, -1.0], 1.0, true));
    assert_eq!(uvs(shorts(&[0x8000, 5, 0, 0, 0, 0, 0, 0]), 5122, false).0[0], [-32768.0, 5.0]);
    let wrong = Builder::quad().attribute("TEXCOORD_0", vec![0; 32], 5125, "VEC2", 4, false);
    wrong.refused("attributes.TEXCOORD_0: cannot be Vec2 of U32");

    let colors = |bytes: Vec<u8>, component, shape, normalized| {
        only(&Builder::quad().attribute("COLOR_0", bytes, component, shape, 4, normalized).scene()).colors[0]
    };
    assert_eq!(colors(vec![255, 0, 51, 0, 0, 0, 0, 0, 0, 0, 0, 0], 5121, "VEC3", true), [1.0, 0.0, 0.2, 1.0]);
    assert_eq!(colors(vec![255; 16], 5121, "VEC4", false), [1.0; 4]);
    assert_eq!(colors(shorts(&[0, 0, 0, 13107].repeat(4)), 5123, "VEC4", true), [0.0, 0.0, 0.0, 0.2]);
    assert_eq!(colors(floats(&[7.0, f32::NAN, 0.5, -1.0].repeat(4)), 5126, "VEC4", false), [1.0, 1.0, 0.5, 0.0]);
}

#[test]
fn quantized_meshes() {
    let file = Builder::new()
        .attribute("POSITION", shorts(&[0, 0, 0, 0, 65535, 0, 0, 0, 0, 65535, 0, 0]), 5123, "VEC3", 3, true)
        .attribute("NORMAL", vec![0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0], 5120, "VEC3", 3, true)
        .set("/bufferViews/0/byteStride", json!(8))
        .set("/bufferViews/1/byteStride", json!(4))
        .set("/extensionsRequired", json!(["KHR_mesh_quantization"]))
        .set("/extensionsUsed", json!(["KHR_mesh_quantization"]));
    let scene = file.scene();
    assert_eq!(only(&scene).positions[1], [1.0, 0.0, 0.0]);
    assert_eq!(only(&scene).normals[0], [0.0, 0.0, 1.0]);
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
}

#[test]
fn non_finite_and_flat_triangles_are_dropped_and_the_bounds_survive() {
    let mut positions = SQUARE.to_vec();
    positions.extend([f32::INFINITY, 0., 0., 0., f32::NAN, 0., 1e9, 1e9, 1e9]);
    let scene = Builder::new()
        .attribute("POSITION", floats(&positions), 5126, "VEC3", 7, false)
        .indices(vec![0, 1, 2, 0, 1, 4, 5, 1, 2, 1, 1, 2, 6, 6, 6], 5121, 15)
        .scene();
    assert_eq!(scene.triangle_count(), 1);
    assert_tells(&scene, NoticeKind::Repaired, "2 triangles with positions that are not finite");
    assert_tells(&scene, NoticeKind::Repaired, "2 triangles without area");
    assert_eq!(only(&scene).positions.len(), 3);
    assert_eq!(scene.bounds().max, DVec3::new(1.0, 1.0, 0.0));
    let none = Builder::new().attribute("POSITION", floats(&[f32::NAN; 9]), 5126, "VEC3", 3, false).scene();
    assert!(none.parts.is_empty());
    let mut no_positions = Builder::quad();
    no_positions.primitive()["attributes"] = json!({"NORMAL": 0});
    assert_tells(&no_positions.scene(), NoticeKind::Ignored, "no positions");
}

#[test]
fn missing_and_broken_normals_are_computed() {
    let scene = Builder::quad().scene();
    assert_eq!(only(&scene).normals, [[0.0, 0.0, 1.0]; 4]);
    assert_tells(&scene, NoticeKind::Computed, "1 primitives without normals");
    let normals = [0., 0., 0., 0., f32::NAN, 0., 0., 0., 5., 0.6, 0., 0.8];
    let scene = Builder::quad().attribute("NORMAL", floats(&normals), 5126, "VEC3", 4, false).scene();
    assert_eq!(only(&scene).normals, [[0., 0., 1.], [0., 0., 1.], [0., 0., 1.], [0.6, 0., 0.8]]);
    assert_tells(&scene, NoticeKind::Repaired, "2 normals were zero");
}

#[test]
fn averaged_normals_are_re_weighted_unless_switched_off() {
    // A roof of a wide and a narrow slope; at the ridge the file has the plain average of the two.
    let slope = |x: f32| Vec3::new(x, 0.0, 1.0).normalize();
    let ridge = Vec3::Z;
    let [l, r] = [slope(-1.0), slope(1.0)];
    let positions = [-4., 0., -4., -4., 1., -4., 0., 0., 0., 0., 1., 0., 1., 0., -1., 1., 1., -1.];
    let normals: Vec<f32> = [l, l, ridge, ridge, r, r].iter().flat_map(|n| n.to_array()).collect();
    let file = Builder::new()
        .attribute("POSITION", floats(&positions), 5126, "VEC3", 6, false)
        .attribute("NORMAL", floats(&normals), 5126, "VEC3", 6, false)
        .indices(vec![0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5], 5121, 12);
    let scene = file.scene();
    assert_tells(&scene, NoticeKind::Computed, "re-weighted");
    // The narrow slope is the better witness of the ridge's direction.
    assert!(only(&scene).normals[2][0] > 0.3, "{:?}", only(&scene).normals);
    let options = crate::import::ImportOptions { reweight_normals: false, ..Default::default() };
    let as_is = crate::import::load_bytes_with(&file.bytes(), "test", None, &options).unwrap();
    assert_eq!(only(&as_is).normals[2], [0.0, 0.0, 1.0]);
    assert!(as_is.notices.is_empty());
}

#[test]
fn the_crease_angle_is_an_option() {
    let positions = [-1., 0., -1., -1., 1., -1., 0., 0., 0., 0., 1., 0., 1., 0., -1., 1., 1., -1.];
    let file = Builder::new().attribute("POSITION", floats(&positions), 5126, "VEC3", 6, false).indices(
        vec![0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5],
        5121,
        12,
    );
    for (crease_angle, vertices) in [(30.0, 8), (89.0, 8), (91.0, 6)] {
        let options = crate::import::ImportOptions { crease_angle, ..Default::default() };
        let scene = crate::import::load_bytes_with(&file.bytes(), "test", None, &options).unwrap();
        assert_eq!(only(&scene).positions.len(), vertices, "{crease_angle} degrees");
    }
}

#[test]
fn tangents_are_computed_where_there_is_a_normal_map() {
    let uvs = [0., 1., 1., 1., 1., 0., 0., 0.];
    let flipped = [1., 1., 0., 1., 0., 0., 1., 0.];
    let flat = [0.5; 8];
    let pixel = png(image::DynamicImage::new_rgb8(1, 1));
    let file = |uvs: &[f32]| {
        let mut file = Builder::quad().attribute("TEXCOORD_0", floats(uvs), 5126, "VEC2", 4, false);
        let view = file.view(&pixel);
        file.json["images"] = json!([{"bufferView": view}]);
        file.json["textures"] = json!([{"source": 0}]);
        file.json["materials"] = json!([{"normalTexture": {"index": 0}}]);
        file.primitive()["material"] = 0.into();
        file
    };
    // u to the right, v down as glTF has it: the bitangent is up, n × t = +y.
    assert_eq!(only(&file(&uvs).scene()).tangents, [[1., 0., 0., 1.]; 4]);
    assert_eq!(only(&file(&flipped).scene()).tangents, [[-1., 0., 0., -1.]; 4]);
    for scene in [file(&flat).scene(), file(&[f32::MAX, 0., 0., f32::NAN, -f32::MAX, 1e-40, 0., 0.]).scene()] {
        for (t, &n) in only(&scene).tangents.iter().zip(&only(&scene).normals) {
            let tangent = Vec3::new(t[0], t[1], t[2]);
            assert!((tangent.length() - 1.0).abs() < 1e-5 && tangent.dot(Vec3::from(n)).abs() < 1e-3, "{t:?}");
        }
    }
    // Two triangles whose textures mirror each other at the edge between them: its vertices are split.
    let positions = [0., 0., 0., 0., 1., 0., -1., 0., 0., 1., 0., 0.];
    let mut mirrored = file(&[0., 1., 0., 0., 1., 1., 1., 1.]);
    let at = mirrored.json["bufferViews"][0]["byteOffset"].as_u64().unwrap() as usize;
    mirrored.binary[at..at + 48].copy_from_slice(&floats(&positions));
    let scene = mirrored.indices(vec![0, 1, 2, 0, 3, 1], 5121, 6).scene();
    assert_eq!(only(&scene).positions.len(), 6);
    assert_eq!(only(&scene).uvs[0].len(), 6);
    // A file's own tangents are kept, with those that are broken replaced; without a normal map there are none.
    let own = [0., 1., 0., -1., 0., 0., 0., 1., 0., 2., 0., 0.3, 0., 1., 0., -1.];
    let with_normals = |f: Builder| {
        f.attribute("NORMAL", floats(&[0., 0., 1.].repeat(4)), 5126, "VEC3", 4, false).attribute(
            "TANGENT",
            floats(&own),
            5126,
            "VEC4",
            4,
            false,
        )
    };
    let scene = with_normals(file(&uvs)).scene();
    assert_eq!(only(&scene).tangents[0], [0., 1., 0., -1.]);
    assert_eq!(only(&scene).tangents[2], [0., 1., 0., 1.]);
    assert_tells(&scene, NoticeKind::Repaired, "1 tangents");
    assert!(only(&with_normals(Builder::quad()).scene()).tangents.is_empty());
}

#[test]
fn skins_morph_targets_and_animations_are_told() {
    let mut file = Builder::quad().set("/animations", json!([{"channels": [], "samplers": []}]));
    file.json["skins"] = json!([{"joints": [0]}]);
    file.primitive()["targets"] = json!([{"POSITION": 0}]);
    let scene = file.scene();
    for part in ["1 animations", "1 skins", "1 meshes with morph targets"] {
        assert_tells(&scene, NoticeKind::Ignored, part);
    }
    assert_eq!(scene.triangle_count(), 2);
}
