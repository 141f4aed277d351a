//! Compressed geometry: streams written here and read back, and the shared models that are compressed against those that are not.

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh, MeshEncoder, PointAttribute,
    PointIndex,
};
use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{self, ExpMode, IndexEncoding, VertexEncoding};

use super::*;
use crate::import::{ImportOptions, Limits, load_bytes_with};

/// A grid of `n` × `n` squares on a hill, as positions and triangles.
pub(super) fn hill(n: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let height = |x: u32, y: u32| (f64::from(x) * 0.7).sin() as f32 * 0.3 + (f64::from(y) * 0.4).cos() as f32 * 0.2;
    let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| [x as f32, y as f32, height(x, y)])).collect();
    let at = |x, y| y * (n + 1) + x;
    let square = |(x, y)| [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]];
    (positions, (0..n).flat_map(|y| (0..n).map(move |x| (x, y))).flat_map(square).collect())
}

/// How a view is compressed.
pub(super) struct Packed {
    pub(super) bytes: Vec<u8>,
    pub(super) count: usize,
    pub(super) stride: usize,
    pub(super) mode: &'static str,
    pub(super) filter: &'static str,
}

/// Appends a view that is stored compressed, on a placeholder buffer, with an accessor on it.
pub(super) fn packed_accessor(
    file: &mut Builder,
    packed: &Packed,
    component: u32,
    shape: &str,
    extension: &str,
) -> usize {
    let Packed { bytes, count, stride, mode, filter } = packed;
    let at = file.binary.len().next_multiple_of(4);
    file.binary.resize(at, 0);
    file.binary.extend(bytes);
    let length = count * stride;
    let offset = file.json["buffers"][1]["byteLength"].as_u64().unwrap_or(0);
    let mut view = json!({
        "buffer": 1, "byteOffset": offset, "byteLength": length,
        "extensions": {extension: {
            "buffer": 0, "byteOffset": at, "byteLength": bytes.len(), "byteStride": stride, "count": count, "mode": mode,
            "filter": filter,
        }},
    });
    if *mode == "ATTRIBUTES" {
        view["byteStride"] = (*stride).into();
    }
    file.json["buffers"] = json!([
        {"byteLength": file.binary.len()},
        {"byteLength": offset + length as u64, "extensions": {extension: {"fallback": true}}},
    ]);
    file.json["bufferViews"].as_array_mut().unwrap().push(view);
    let view = file.json["bufferViews"].as_array().unwrap().len() - 1;
    let normalized = *filter != "NONE" && component != 5126;
    let accessor = json!({"bufferView": view, "componentType": component, "type": shape, "count": count, "normalized": normalized});
    let accessors = file.json["accessors"].as_array_mut().unwrap();
    accessors.push(accessor);
    accessors.len() - 1
}

pub(super) fn attributes(bytes: &[u8], count: usize, stride: usize, version: u8, filter: &'static str) -> Packed {
    let encoding = VertexEncoding::new(version, 2).unwrap();
    let bytes = codec::encode_vertex_buffer(bytes, count, stride, encoding, &mut Workspace::default()).unwrap();
    Packed { bytes, count, stride, mode: "ATTRIBUTES", filter }
}

/// The hill as a file whose views are compressed.
pub(super) fn packed_hill(n: u32, extension: &str, version: u8) -> Builder {
    let (positions, triangles) = hill(n);
    let mut file = Builder::new();
    file.json["extensionsUsed"] = json!([extension, "KHR_mesh_quantization"]);
    file.json["extensionsRequired"] = json!([extension, "KHR_mesh_quantization"]);
    let packed = attributes(&floats(positions.as_flattened()), positions.len(), 12, version, "NONE");
    let position = packed_accessor(&mut file, &packed, 5126, "VEC3", extension);
    let bytes = codec::encode_index_buffer(triangles.as_flattened(), IndexEncoding::DEFAULT, &mut Workspace::default())
        .unwrap();
    let packed = Packed { bytes, count: 3 * triangles.len(), stride: 4, mode: "TRIANGLES", filter: "NONE" };
    let indices = packed_accessor(&mut file, &packed, 5125, "SCALAR", extension);
    file.json["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": position}, "indices": indices});
    file
}

#[test]
fn compressed_views_are_what_was_compressed() {
    let (positions, triangles) = hill(24);
    for (extension, version) in
        [("EXT_meshopt_compression", 0), ("KHR_meshopt_compression", 0), ("KHR_meshopt_compression", 1)]
    {
        let scene = packed_hill(24, extension, version).scene();
        let primitive = &scene.meshes[0].primitives[0];
        assert_eq!(primitive.positions, positions, "{extension} {version}");
        // The codec may turn triangles, never reorder or flip them.
        assert_eq!(primitive.triangles.len(), triangles.len());
        let turned = |a: [u32; 3], b: [u32; 3]| (0..3).any(|k| [a[k], a[(k + 1) % 3], a[(k + 2) % 3]] == b);
        assert!(primitive.triangles.iter().zip(&triangles).all(|(&a, &b)| turned(a, b)));
        assert!(!tells(&scene, NoticeKind::Repaired, "meshopt"), "{:?}", scene.notices);
    }
    let mixed = packed_hill(4, "EXT_meshopt_compression", 1).scene();
    assert_tells(&mixed, NoticeKind::Repaired, "what only KHR_meshopt_compression has");
}

#[test]
fn filters_and_index_sequences_are_undone() {
    let (positions, triangles) = hill(8);
    let count = positions.len();
    let name = "KHR_meshopt_compression";
    let workspace = &mut Workspace::default();
    let mut file = packed_hill(8, name, 1);
    // Unit vectors on a spiral, as octahedral bytes and words; four components, the last of which is kept.
    let normal = |i: usize| {
        let (z, turn) = (1.0 - 2.0 * (i as f32 + 0.5) / count as f32, i as f32 * 2.4);
        let r = (1.0 - z * z).sqrt();
        [r * turn.cos(), r * turn.sin(), z, 1.0]
    };
    let normals: Vec<f32> = (0..count).flat_map(normal).collect();
    let oct = codec::encode_filter_oct(count, 8, 16, &normals, workspace).unwrap();
    let normal_words = packed_accessor(&mut file, &attributes(&oct, count, 8, 0, "OCTAHEDRAL"), 5122, "VEC3", name);
    let exp =
        codec::encode_filter_exp(count, 12, 23, positions.as_flattened(), ExpMode::SharedVector, workspace).unwrap();
    let position = packed_accessor(&mut file, &attributes(&exp, count, 12, 0, "EXPONENTIAL"), 5126, "VEC3", name);
    let colors: Vec<f32> = (0..count).flat_map(|i| [i as f32 / count as f32, 0.25, 0.75, 1.0]).collect();
    let color = codec::encode_filter_color(count, 4, 8, &colors, workspace).unwrap();
    let color = packed_accessor(&mut file, &attributes(&color, count, 4, 0, "COLOR"), 5121, "VEC4", name);
    let bytes = codec::encode_index_sequence(triangles.as_flattened(), IndexEncoding::DEFAULT, workspace).unwrap();
    let sequence = Packed { bytes, count: 3 * triangles.len(), stride: 4, mode: "INDICES", filter: "NONE" };
    let indices = packed_accessor(&mut file, &sequence, 5125, "SCALAR", name);
    file.json["meshes"][0]["primitives"][0] = json!({
        "attributes": {"POSITION": position, "NORMAL": normal_words, "COLOR_0": color}, "indices": indices,
    });
    let options = ImportOptions { reweight_normals: false, ..ImportOptions::default() };
    let scene = load_bytes_with(&file.bytes(), "test", None, &options).unwrap_or_else(|e| panic!("{e}"));
    let p = &scene.meshes[0].primitives[0];
    assert_eq!(p.triangles, triangles);
    for (i, (a, b)) in p.positions.iter().zip(&positions).enumerate() {
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-4), "position {i}: {a:?} and {b:?}");
        let [x, y, z, _] = normal(i);
        let dot = p.normals[i][0] * x + p.normals[i][1] * y + p.normals[i][2] * z;
        assert!(dot > 0.999_9, "normal {i}: {:?} and {:?}", p.normals[i], [x, y, z]);
        assert!((0..4).all(|k| (p.colors[i][k] - colors[4 * i + k]).abs() < 0.02), "colour {i}: {:?}", p.colors[i]);
    }
    // Quaternions are for instances.
    let turns: Vec<f32> = (0..5)
        .flat_map(|i| {
            let half = i as f32 * 0.3;
            [0.0, half.sin(), 0.0, half.cos()]
        })
        .collect();
    let quat = codec::encode_filter_quat(5, 8, 16, &turns, workspace).unwrap();
    let turn = packed_accessor(&mut file, &attributes(&quat, 5, 8, 0, "QUATERNION"), 5122, "VEC4", name);
    file.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": turn}}});
    file.json["extensionsUsed"].as_array_mut().unwrap().push("EXT_mesh_gpu_instancing".into());
    let scene = file.scene();
    assert_eq!(scene.parts.len(), 5);
    for (i, part) in scene.parts.iter().enumerate() {
        let expected = glam::DMat4::from_rotation_y(i as f64 * 0.6);
        assert!(part.world_from_part.abs_diff_eq(expected, 1e-3), "instance {i}: {}", part.world_from_part);
    }
}

#[test]
fn octahedral_zeros_point_somewhere() {
    let mut file = packed_hill(1, "KHR_meshopt_compression", 0);
    let packed = attributes(&[0; 16], 4, 4, 0, "OCTAHEDRAL");
    let normal = packed_accessor(&mut file, &packed, 5120, "VEC3", "KHR_meshopt_compression");
    file.primitive()["attributes"]["NORMAL"] = normal.into();
    let scene = file.scene();
    assert_eq!(scene.meshes[0].primitives[0].normals, [[0.0, 0.0, 1.0]; 4]);
    assert_tells(&scene, NoticeKind::Repaired, "unit vectors were zero");
}

#[test]
fn what_a_file_says_of_a_stream_is_checked() {
    let with = |member: &str, value: Value| {
        let pointer = format!("/bufferViews/0/extensions/EXT_meshopt_compression/{member}");
        packed_hill(4, "EXT_meshopt_compression", 0).set(&pointer, value)
    };
    for (member, value) in [
        ("mode", json!("SQUARES")),
        ("filter", json!("SEPIA")),
        ("filter", json!("QUATERNION")),
        ("buffer", json!(9)),
        ("byteOffset", json!(u64::MAX)),
        ("byteLength", json!(1_u64 << 40)),
        ("byteStride", json!(13)),
        ("byteStride", json!(0)),
        ("byteStride", json!(260)),
        ("count", json!(24)),
        ("count", json!(u64::MAX)),
        ("count", json!(-1)),
        ("mode", json!("TRIANGLES")),
    ] {
        with(member, value).refused("bufferViews[0].extensions.EXT_meshopt_compression");
    }
    // A stream that is not one, and one that ends early.
    with("byteOffset", json!(4)).refused("bufferViews[0].extensions.EXT_meshopt_compression");
    with("byteLength", json!(20)).refused("malformed or cut off");
    // The placeholder says how long it would be.
    packed_hill(4, "EXT_meshopt_compression", 0).set("/buffers/1/byteLength", json!(10)).refused("bufferViews[0]");
    // A view on it that is not compressed has no data.
    let mut bare = packed_hill(4, "EXT_meshopt_compression", 0);
    bare.json["bufferViews"][0].as_object_mut().unwrap().remove("extensions");
    bare.refused("bufferViews[0]");
}

#[test]
fn streams_are_charged_before_they_are_decoded() {
    let limits = Limits { bytes: 100_000, ..Limits::default() };
    let options = ImportOptions { limits, ..ImportOptions::default() };
    let file = packed_hill(100, "EXT_meshopt_compression", 0);
    assert!(file.binary.len() < 100_000, "the stream alone is within the limit");
    let error = load_bytes_with(&file.bytes(), "test", None, &options).unwrap_err();
    assert!(matches!(error, ImportError::Limit { .. }), "{error}");
    let file = draco_hill(100, None);
    assert!(file.binary.len() < 100_000, "the stream alone is within the limit");
    let error = load_bytes_with(&file.bytes(), "test", None, &options).unwrap_err();
    assert!(matches!(error, ImportError::Limit { .. }), "{error}");
}

/// The hill as one Draco stream, sequential or by edgebreaker.
pub(super) fn draco_hill(n: u32, method: Option<i32>) -> Builder {
    let (positions, triangles) = hill(n);
    let mut mesh = Mesh::new();
    mesh.set_num_points(positions.len());
    let mut add = |kind, components: u8, data: DataType, normalized, bytes: Vec<u8>| {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, components, data, normalized, positions.len());
        attribute.buffer_mut().write(0, &bytes);
        mesh.add_attribute(attribute)
    };
    let flat = positions.as_flattened();
    let position = add(GeometryAttributeType::Position, 3, DataType::Float32, false, floats(flat));
    let uvs: Vec<f32> = positions.iter().flat_map(|p| [p[0] / n as f32, p[1] / n as f32]).collect();
    let uv = add(GeometryAttributeType::TexCoord, 2, DataType::Float32, false, floats(&uvs));
    let colors: Vec<u8> = positions.iter().flat_map(|p| [p[0] as u8, p[1] as u8, 7, 255]).collect();
    let color = add(GeometryAttributeType::Color, 4, DataType::Uint8, true, colors);
    mesh.set_num_faces(triangles.len());
    for (i, t) in triangles.iter().enumerate() {
        mesh.set_face(FaceIndex(i as u32), t.map(PointIndex));
    }
    let mut options = EncoderOptions::new();
    options.set_attribute_quantization(position, 14);
    options.set_attribute_quantization(uv, 12);
    if let Some(method) = method {
        options.set_encoding_method(method);
    }
    let mut out = EncoderBuffer::new();
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    encoder.encode(&options, &mut out).unwrap();
    let mut file = Builder::new();
    let view = file.view(out.data());
    let count = positions.len();
    file.json["accessors"] = json!([
        {"componentType": 5126, "type": "VEC3", "count": count, "min": [0, 0, -1], "max": [n, n, 1]},
        {"componentType": 5126, "type": "VEC2", "count": count},
        {"componentType": 5121, "type": "VEC4", "count": count, "normalized": true},
        {"componentType": 5123, "type": "SCALAR", "count": 3 * triangles.len()},
    ]);
    file.json["meshes"][0]["primitives"][0] = json!({
        "attributes": {"POSITION": 0, "TEXCOORD_0": 1, "COLOR_0": 2},
        "indices": 3,
        "extensions": {"KHR_draco_mesh_compression": {
            "bufferView": view, "attributes": {"POSITION": position, "TEXCOORD_0": uv, "COLOR_0": color},
        }},
    });
    file.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    file
}

/// Corners of triangles with what belongs to them, rounded, in an order that does not depend on numbering.
fn corners(p: &crate::scene::Primitive) -> Vec<[[i64; 3]; 3]> {
    let place = |v: u32| p.positions[v as usize].map(|c| (f64::from(c) * 100.0).round() as i64);
    let mut all: Vec<[[i64; 3]; 3]> = p
        .triangles
        .iter()
        .map(|t| {
            let t = t.map(place);
            (0..3).map(|k| [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]).min().unwrap()
        })
        .collect();
    all.sort_unstable();
    all
}

#[test]
fn draco_streams_are_what_was_compressed() {
    let plain = packed_hill(12, "EXT_meshopt_compression", 0).scene();
    for method in [None, Some(0), Some(1)] {
        let scene = draco_hill(12, method).scene();
        let p = &scene.meshes[0].primitives[0];
        let exact: Vec<[[i64; 3]; 3]> = corners(&plain.meshes[0].primitives[0]);
        let got = corners(p);
        assert_eq!(got.len(), exact.len());
        let near = |a: &[[i64; 3]; 3], b: &[[i64; 3]; 3]| {
            a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() <= 1)
        };
        // Rounding may put a coordinate on either side, so each is looked for.
        assert!(exact.iter().all(|e| got.iter().any(|g| near(e, g))), "{method:?}");
        for (v, position) in p.positions.iter().enumerate() {
            assert!((p.uvs[0][v][0] - position[0] / 12.0).abs() < 1e-3, "{method:?}");
            let red = (position[0].round() / 255.0, p.colors[v][0]);
            assert!((red.0 - red.1).abs() < 1e-6, "{method:?}: {red:?}");
        }
        assert!(!tells(&scene, NoticeKind::Repaired, "Draco"), "{:?}", scene.notices);
    }
}

#[test]
fn damaged_draco_streams_are_refused() {
    let inside = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    draco_hill(4, None).set(&format!("{inside}/bufferView"), json!(7)).refused("KHR_draco_mesh_compression.bufferView");
    let attribute = format!("{inside}/attributes/POSITION");
    draco_hill(4, None).set(&attribute, json!(77)).refused("the stream has no attribute 77");
    draco_hill(4, None).set(&attribute, json!(1)).refused("has 2 components");
    draco_hill(4, None).set("/accessors/2/componentType", json!(5123)).refused("Uint8 in the stream");
    draco_hill(4, None).set("/meshes/0/primitives/0/mode", json!(0)).refused("triangles");
    draco_hill(4, None).set(inside, json!({})).refused("KHR_draco_mesh_compression");
    draco_hill(4, None).set("/bufferViews/0/byteLength", json!(30)).refused("cannot be decoded");
    let scene = draco_hill(4, None).set("/accessors/3/count", json!(90)).scene();
    assert_tells(&scene, NoticeKind::Repaired, "the streams count");
    assert_eq!(scene.triangle_count(), 32);
    // Many more than it says.
    let mut small = draco_hill(300, None);
    for i in 0..4 {
        small.json["accessors"][i]["count"] = 3.into();
    }
    small.refused("far more than its accessors say");
}
