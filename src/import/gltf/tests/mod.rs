//! Tests of the importer on tiny files built here, one per point of the format, and on the shared models.

mod compression;
mod container;
mod geometry;
mod instances;
mod materials;
mod mutation;
mod nodes;
mod pairs;
mod progress;
mod structured;
mod textures;
mod validator;

use base64::Engine;
use serde_json::{Value, json};

use crate::import::{ImportError, load_bytes};
use crate::scene::{NoticeKind, Scene};

/// A GLB of a JSON chunk and a binary chunk.
fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut body = Vec::new();
    let mut chunk = |kind: &[u8; 4], content: &[u8]| {
        body.extend((content.len() as u32).to_le_bytes());
        body.extend(kind);
        body.extend(content);
    };
    chunk(b"JSON", &text);
    if !binary.is_empty() {
        let mut binary = binary.to_vec();
        binary.resize(binary.len().next_multiple_of(4), 0);
        chunk(b"BIN\0", &binary);
    }
    let mut out = b"glTF".to_vec();
    out.extend(2_u32.to_le_bytes());
    out.extend((12 + body.len() as u32).to_le_bytes());
    out.extend(body);
    out
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn shorts(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A file in the making: accessors, each on a buffer view of its own, on one binary chunk.
struct Builder {
    json: Value,
    binary: Vec<u8>,
}

impl Builder {
    /// One node with one mesh of one primitive, still without attributes.
    fn new() -> Builder {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "node"}],
            "meshes": [{"name": "mesh", "primitives": [{"attributes": {}}]}],
            "accessors": [], "bufferViews": [], "buffers": [],
        });
        Builder { json, binary: Vec::new() }
    }

    /// A unit quad in z = 0, indexed as two triangles.
    fn quad() -> Builder {
        Builder::new()
            .attribute("POSITION", floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]), 5126, "VEC3", 4, false)
            .indices(shorts(&[0, 1, 2, 0, 2, 3]), 5123, 6)
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()});
        self.binary.extend(bytes);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(view);
        views.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, shape: &str, count: usize, normalized: bool) -> usize {
        let view = self.view(bytes);
        let accessor = json!({
            "bufferView": view, "componentType": component, "type": shape, "count": count, "normalized": normalized,
        });
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        accessors.len() - 1
    }

    fn attribute(
        mut self,
        name: &str,
        bytes: Vec<u8>,
        component: u32,
        shape: &str,
        count: usize,
        normalized: bool,
    ) -> Builder {
        let index = self.accessor(&bytes, component, shape, count, normalized);
        self.primitive()["attributes"][name] = index.into();
        self
    }

    fn indices(mut self, bytes: Vec<u8>, component: u32, count: usize) -> Builder {
        let index = self.accessor(&bytes, component, "SCALAR", count, false);
        self.primitive()["indices"] = index.into();
        self
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Sets a value by JSON pointer, creating the last member.
    fn set(mut self, pointer: &str, value: Value) -> Builder {
        let (parent, member) = pointer.rsplit_once('/').unwrap();
        let parent = self.json.pointer_mut(parent).unwrap_or_else(|| panic!("{parent} is in the file"));
        match parent {
            Value::Array(list) => list[member.parse::<usize>().unwrap()] = value,
            object => object[member] = value,
        }
        self
    }

    fn bytes(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.binary.is_empty() && json["buffers"].as_array().is_some_and(Vec::is_empty) {
            json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        }
        glb(&json, &self.binary)
    }

    fn load(&self) -> Result<Scene, ImportError> {
        load_bytes(&self.bytes(), "test", None)
    }

    fn scene(&self) -> Scene {
        self.load().unwrap_or_else(|e| panic!("{e}"))
    }

    /// The error's text, which must be one line and name `part`.
    fn refused(&self, part: &str) -> String {
        let text = self.load().expect_err("is refused").to_string();
        assert!(text.contains(part) && text.starts_with("test: ") && !text.contains('\n'), "{text:?} names {part:?}");
        text
    }
}

/// Whether the scene tells something of this kind that contains `part`.
fn tells(scene: &Scene, kind: NoticeKind, part: &str) -> bool {
    scene.notices.iter().any(|n| n.kind == kind && n.message.contains(part))
}

#[track_caller]
fn assert_tells(scene: &Scene, kind: NoticeKind, part: &str) {
    assert!(tells(scene, kind, part), "{part:?} is not among {:#?}", scene.notices);
}

fn base64(bytes: &[u8]) -> String {
    base64::engine::general_purpose::STANDARD.encode(bytes)
}

/// A PNG of one pixel.
fn png(pixel: image::DynamicImage) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    pixel.write_to(&mut out, image::ImageFormat::Png).unwrap();
    out.into_inner()
}
