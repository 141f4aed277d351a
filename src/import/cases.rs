//! The hard cases of import: what a file can bring.

use serde_json::json;

use crate::scene::builtin;
use crate::scene::hard_case::Contrast::Printed;
use crate::scene::hard_case::Source::{Builtin, Bytes, ThroughFile};
use crate::scene::hard_case::{CaseCamera, HardCase, Measure, Method};

const PLAIN: Method = Method::of("imported", "");

/// Cases of import.
pub const CASES: &[HardCase] = &[
    HardCase {
        name: "t29-far-from-the-origin",
        trap: "T29",
        why: "A model whose top node lies 1e7 units from the origin. In f32 such a position has steps of 1 to 4 units. \
              Transforms are multiplied in f64 and the scene is re-based on import; a file that has the offset in its f32 \
              vertices has lost them already.",
        scene: ThroughFile("builtin:hard/assembly?seed=29&offset=1e7"),
        camera: CaseCamera::CORNER,
        size: [48, 48],
        ours: PLAIN,
        contrast: Some(Printed(
            Method::of("offset in the vertices", "")
                .over(ThroughFile("builtin:hard/assembly?seed=29&offset=1e7&baked=1")),
        )),
        measure: Measure::PictureUnlike(Builtin("builtin:hard/assembly?seed=29")),
        bound: 2.0,
    },
    HardCase {
        name: "t29-broken-numbers",
        trap: "T29",
        why: "A sphere in a file that also has triangles without area, with corners that are not numbers and with corners \
              at infinity, and normals that are zero or not numbers. What has no surface is dropped, normals are computed, \
              and the picture is that of the sphere alone.",
        scene: Bytes(broken_numbers),
        camera: CaseCamera::FRONT,
        size: [64, 64],
        ours: PLAIN,
        contrast: Some(Printed(Method::of("taken as they are", "").over(Builtin("builtin:hard/broken")))),
        measure: Measure::PictureUnlike(Builtin("builtin:hard/ball?columns=48")),
        bound: 1.0,
    },
];

/// A GLB that holds the geometry of `builtin:hard/broken` as it is.
fn broken_numbers() -> Vec<u8> {
    let scene = builtin::build("hard/broken").unwrap_or_default();
    let Some(p) = scene.meshes.first().and_then(|m| m.primitives.first()) else { return Vec::new() };
    let floats = |v: &[[f32; 3]]| -> Vec<u8> { v.iter().flatten().flat_map(|c| c.to_le_bytes()).collect() };
    let columns = [floats(&p.positions), floats(&p.normals)];
    let indices: Vec<u8> = p.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
    let [positions, normals, triangles] = [columns[0].len(), columns[1].len(), indices.len()];
    let vertices = p.positions.len();
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": {
            "baseColorFactor": scene.materials[0].base_color,
            "metallicFactor": scene.materials[0].metallic,
            "roughnessFactor": scene.materials[0].roughness,
        } }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1] },
            { "bufferView": 1, "componentType": 5126, "count": vertices, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5125, "count": 3 * p.triangles.len(), "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": positions },
            { "buffer": 0, "byteOffset": positions, "byteLength": normals },
            { "buffer": 0, "byteOffset": positions + normals, "byteLength": triangles }
        ],
        "buffers": [{ "byteLength": positions + normals + triangles }],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let binary = [columns.concat(), indices].concat();
    let mut file = b"glTF".to_vec();
    for word in [2, 12 + 8 + text.len() + 8 + binary.len(), text.len()] {
        file.extend((word as u32).to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(&text);
    file.extend((binary.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(&binary);
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_broken_file_is_read_and_what_is_broken_is_told() {
        let scene = crate::import::load_bytes(&broken_numbers(), "broken", None).expect("a scene");
        let notices: String = scene.notices.iter().map(|n| format!("{}\n", n.message)).collect();
        for what in ["not finite were dropped", "without area", "normals were zero or not finite"] {
            assert!(notices.contains(what), "{what}: {notices}");
        }
        let ball = builtin::build("hard/ball?columns=48").expect("a ball");
        assert_eq!(scene.triangle_count(), ball.triangle_count());
    }
}
