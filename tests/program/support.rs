//! What the tests of the program share: the adapter or the reason for going without, and small models.

use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

use pellucid::gpu::{Gpu, GpuOptions};
use serde_json::{Value, json};

/// The top of the project.
pub fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The program, out of reach of whoever runs the tests: without their configuration, and without what they log.
pub fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pellucid"));
    let nowhere = repository().join("target/no configuration is here");
    command.env("XDG_CONFIG_HOME", &nowhere).env("XDG_CONFIG_DIRS", &nowhere);
    command.env_remove("PELLUCID_CONFIG").env_remove("RUST_LOG");
    command
}

/// Whether the expensive matrices are wanted whole.
pub fn full() -> bool {
    std::env::var_os("PELLUCID_TEST_FULL").is_some_and(|v| !v.is_empty() && v != "0")
}

/// A device, or `None` with a line that says what is skipped. Where `CI` is set, a missing adapter is a failure.
pub fn gpu(test: &str) -> Option<Gpu> {
    static FOUND: OnceLock<Result<Gpu, String>> = OnceLock::new();
    match FOUND.get_or_init(|| Gpu::new(&GpuOptions::default()).map_err(|e| e.to_string())) {
        Ok(gpu) => Some(gpu.clone()),
        Err(reason) if std::env::var_os("CI").is_some() => panic!("{test}: {reason}"),
        Err(reason) => {
            println!("SKIPPED: {test}: {reason}");
            None
        }
    }
}

/// A GLB file out of its JSON and its binary chunk.
pub fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut file = b"glTF".to_vec();
    let length = 12 + 8 + text.len() + 8 + binary.len();
    for word in [2, length as u32, text.len() as u32] {
        file.extend(word.to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(&text);
    file.extend((binary.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(&binary);
    file
}

/// A model of boxes, one inside the other: `count` parts of 12 triangles that share a mesh, the largest 2 across.
pub fn boxes(count: usize) -> (Value, Vec<u8>) {
    let mut positions: Vec<[f32; 3]> = Vec::new();
    let mut normals: Vec<[f32; 3]> = Vec::new();
    let mut indices: Vec<u16> = Vec::new();
    for axis in 0..3 {
        for side in [-1.0_f32, 1.0] {
            let first = positions.len() as u16;
            for (u, v) in [(-1.0, -1.0), (side, -side), (1.0, 1.0), (-side, side)] {
                let mut point = [0.0; 3];
                (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (side, u, v);
                positions.push(point);
                let mut normal = [0.0; 3];
                normal[axis] = side;
                normals.push(normal);
            }
            indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        }
    }
    let mut binary: Vec<u8> = Vec::new();
    binary.extend(positions.iter().chain(&normals).flatten().flat_map(|v| v.to_le_bytes()));
    binary.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    let attribute = positions.len() * 12;
    let nodes: Vec<Value> = (0..count)
        .map(|i| {
            let scale = 0.7_f64.powi(i as i32);
            json!({ "name": format!("box {i}"), "mesh": 0, "scale": [scale, scale, scale] })
        })
        .collect();
    let json = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": (0..count).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": [{ "name": "box", "primitives": [
            { "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 }
        ] }],
        "materials": [{ "name": "steel", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.6, 1.0] } }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 24, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1] },
            { "bufferView": 1, "componentType": 5126, "count": 24, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5123, "count": 36, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": attribute },
            { "buffer": 0, "byteOffset": attribute, "byteLength": attribute },
            { "buffer": 0, "byteOffset": 2 * attribute, "byteLength": 72 }
        ],
        "buffers": [{ "byteLength": binary.len() }],
    });
    (json, binary)
}
