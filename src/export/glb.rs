//! A [`Scene`] as a binary glTF 2.0 file.
//!
//! Written: the node hierarchy with shared meshes, positions (with bounds), normals, tangents, both texture coordinate
//! sets, vertex colours, indices in 16 bits where they fit, materials with their textures (PNG), samplers, and cameras.
//! Two things become an extension: `KHR_texture_transform`, `KHR_materials_unlit`; a third where light exceeds 1,
//! `KHR_materials_emissive_strength`. The file's coordinates are the ones before re-basing, as [`Scene::nodes`] has them.

use glam::{DMat4, DQuat, DVec3, Vec3};
use serde_json::{Map, Value, json};

use crate::math::Projection;
use crate::scene::{AlphaMode, Material, Mip, Node, Primitive, Scene, Texture, TextureRef, Wrap};

/// Why a scene could not be written.
#[derive(Debug, thiserror::Error)]
pub enum GlbError {
    /// A GLB counts its bytes in 32 bits.
    #[error("the file would have {bytes} bytes; a GLB holds at most 4 294 967 295")]
    TooLarge {
        /// Size that it would have.
        bytes: u64,
    },
    /// An image could not be encoded.
    #[error("image {index} ({name:?}) cannot be encoded as PNG: {source}")]
    Image {
        /// Index into [`Scene::images`].
        index: usize,
        /// Its name.
        name: String,
        /// What the encoder says.
        source: image::ImageError,
    },
    /// A number is not finite.
    #[error("{place} has a number that is not finite")]
    NotFinite {
        /// Where.
        place: String,
    },
}

const FLOAT: u32 = 5126;
const U16: u32 = 5123;
const U32: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Writes `scene` as a GLB.
///
/// # Errors
/// [`GlbError`] if the file would be too large, an image has a wrong size, or a number is not finite.
pub fn write_glb(scene: &Scene) -> Result<Vec<u8>, GlbError> {
    let mut w = Writer::default();
    let meshes = scene.meshes.iter().enumerate().map(|(i, m)| {
        let primitives: Result<Vec<Value>, GlbError> =
            m.primitives.iter().filter(|p| !p.triangles.is_empty()).map(|p| w.primitive(p, i)).collect();
        Ok(named(&m.name, json!({ "primitives": primitives? })))
    });
    // A mesh without triangles would be invalid: it is left out, and the indices move up.
    let meshes: Vec<Value> = meshes.collect::<Result<_, GlbError>>()?;
    let has_triangles = |v: &Value| v["primitives"].as_array().is_some_and(|p| !p.is_empty());
    let moved: Vec<Option<usize>> = (0..meshes.len())
        .map(|i| has_triangles(&meshes[i]).then(|| meshes[..i].iter().filter(|m| has_triangles(m)).count()))
        .collect();
    let meshes: Vec<Value> = meshes.into_iter().filter(has_triangles).collect();

    let materials: Vec<Value> = scene.materials.iter().map(|m| w.material(m)).collect();
    let mut images = Vec::new();
    for (index, image) in scene.images.iter().enumerate() {
        let failed = |source| GlbError::Image { index, name: image.name.clone(), source };
        let png = encode_png(image).map_err(failed)?;
        let view = w.view(&png, None);
        images.push(named(&image.name, json!({ "bufferView": view, "mimeType": "image/png" })));
    }
    let samplers: Vec<Value> = scene.textures.iter().map(sampler).collect();
    let textures: Vec<Value> =
        scene.textures.iter().enumerate().map(|(i, t)| json!({ "sampler": i, "source": t.image })).collect();

    let mut nodes = Vec::new();
    for (i, node) in scene.nodes.iter().enumerate() {
        nodes.push(node_json(node, node.mesh.and_then(|m| moved.get(m).copied().flatten()), i)?);
    }
    let mut roots: Vec<usize> = (0..scene.nodes.len()).filter(|&n| scene.nodes[n].parent.is_none()).collect();
    let mut cameras = Vec::new();
    for camera in &scene.cameras {
        let place = DMat4::from_translation(scene.origin) * camera.world_from_camera;
        let mut value = node_json(&Node::root(&camera.name, None, place), None, nodes.len())?;
        value["camera"] = json!(cameras.len());
        roots.push(nodes.len());
        nodes.push(value);
        cameras.push(named(&camera.name, camera_json(camera.projection, scene)));
    }
    let mut root = json!({
        "asset": { "version": "2.0", "generator": concat!("pellucid ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [named(&scene.name, json!({ "nodes": roots }))],
    });
    if roots.is_empty() {
        root["scenes"][0] = named(&scene.name, json!({}));
    }
    let (views, accessors) = (std::mem::take(&mut w.views), std::mem::take(&mut w.accessors));
    let lists = [
        ("nodes", nodes),
        ("meshes", meshes),
        ("materials", materials),
        ("textures", textures),
        ("samplers", samplers),
        ("images", images),
        ("cameras", cameras),
        ("accessors", accessors),
        ("bufferViews", views),
        ("extensionsUsed", w.extensions.iter().map(|e| json!(e)).collect()),
    ];
    for (key, list) in lists {
        // glTF forbids empty arrays.
        if !list.is_empty() {
            root[key] = Value::Array(list);
        }
    }
    if !w.bytes.is_empty() {
        root["buffers"] = json!([{ "byteLength": w.bytes.len() }]);
    }
    container(root.to_string().into_bytes(), w.bytes)
}

fn container(mut json: Vec<u8>, mut binary: Vec<u8>) -> Result<Vec<u8>, GlbError> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let with_binary = !binary.is_empty();
    let total = 12 + 8 + json.len() as u64 + if with_binary { 8 + binary.len() as u64 } else { 0 };
    let length = u32::try_from(total).map_err(|_| GlbError::TooLarge { bytes: total })?;
    let mut out = Vec::with_capacity(total as usize);
    out.extend(b"glTF");
    out.extend(2_u32.to_le_bytes());
    out.extend(length.to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(json);
    if with_binary {
        out.extend((binary.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(binary);
    }
    Ok(out)
}

fn named(name: &str, mut value: Value) -> Value {
    if !name.is_empty() {
        value["name"] = json!(name);
    }
    value
}

fn finite(values: &[f64], place: impl FnOnce() -> String) -> Result<(), GlbError> {
    if values.iter().all(|v| v.is_finite()) { Ok(()) } else { Err(GlbError::NotFinite { place: place() }) }
}

fn node_json(node: &Node, mesh: Option<usize>, index: usize) -> Result<Value, GlbError> {
    let matrix = node.parent_from_node;
    finite(&matrix.to_cols_array(), || format!("the transform of node {index} ({:?})", node.name))?;
    let mut value = named(&node.name, json!({}));
    let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
    let again = DMat4::from_scale_rotation_translation(scale, rotation, translation);
    if again.abs_diff_eq(matrix, 1e-12 * matrix.to_cols_array().iter().fold(1.0, |m: f64, v| m.max(v.abs()))) {
        if translation != DVec3::ZERO {
            value["translation"] = json!(translation.to_array());
        }
        // A unit scale that a product of rotations leaves a last bit off is a unit scale.
        if !scale.abs_diff_eq(DVec3::ONE, 1e-14) {
            value["scale"] = json!(scale.to_array());
        }
        if !rotation.abs_diff_eq(DQuat::IDENTITY, 1e-14) {
            value["rotation"] = json!(rotation.to_array());
        }
    } else {
        value["matrix"] = json!(matrix.to_cols_array());
    }
    if let Some(mesh) = mesh {
        value["mesh"] = json!(mesh);
    }
    if !node.children.is_empty() {
        value["children"] = json!(node.children);
    }
    Ok(value)
}

fn camera_json(projection: Projection, scene: &Scene) -> Value {
    // The far plane is only a hint to other readers; ours derives its own.
    let reach = (scene.bounds().size().length() * 8.0).max(1.0);
    match projection {
        Projection::Perspective { fov_y } => {
            json!({ "type": "perspective", "perspective": { "yfov": fov_y, "znear": reach * 1e-4 } })
        }
        Projection::Orthographic { height } => {
            let mag = height / 2.0;
            json!({ "type": "orthographic", "orthographic": { "xmag": mag, "ymag": mag, "znear": 0.0, "zfar": reach } })
        }
    }
}

fn sampler(texture: &Texture) -> Value {
    let wrap = texture.wrap.map(|w| match w {
        Wrap::Repeat => 10497,
        Wrap::MirroredRepeat => 33648,
        Wrap::ClampToEdge => 33071,
    });
    let min = match (texture.mip, texture.min_linear) {
        (Mip::None, false) => 9728,
        (Mip::None, true) => 9729,
        (Mip::Nearest, false) => 9984,
        (Mip::Nearest, true) => 9985,
        (Mip::Linear, false) => 9986,
        (Mip::Linear, true) => 9987,
    };
    let mag = if texture.mag_linear { 9729 } else { 9728 };
    json!({ "wrapS": wrap[0], "wrapT": wrap[1], "minFilter": min, "magFilter": mag })
}

fn encode_png(image: &crate::scene::Image) -> Result<Vec<u8>, image::ImageError> {
    let buffer = image::RgbaImage::from_raw(image.width, image.height, image.rgba.clone()).ok_or_else(|| {
        let kind = image::error::ParameterErrorKind::DimensionMismatch;
        image::ImageError::Parameter(image::error::ParameterError::from_kind(kind))
    })?;
    let mut png = std::io::Cursor::new(Vec::new());
    buffer.write_to(&mut png, image::ImageFormat::Png)?;
    Ok(png.into_inner())
}

/// The binary chunk and what points into it.
#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    extensions: std::collections::BTreeSet<&'static str>,
}

impl Writer {
    fn view(&mut self, data: &[u8], target: Option<u32>) -> usize {
        // Every view starts at a multiple of four, which suits all component types used here.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": data.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(data);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, data: &[u8], target: u32, component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(data, Some(target));
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }));
        self.accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, rows: &[[f32; N]], kind: &str, place: &str) -> Result<usize, GlbError> {
        if rows.iter().flatten().any(|v| !v.is_finite()) {
            return Err(GlbError::NotFinite { place: place.to_owned() });
        }
        let data: Vec<u8> = rows.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        Ok(self.accessor(&data, VERTICES, FLOAT, kind, rows.len()))
    }

    fn primitive(&mut self, p: &Primitive, mesh: usize) -> Result<Value, GlbError> {
        let place = |what: &str| format!("{what} of mesh {mesh}");
        let mut attributes = Map::new();
        let positions = self.floats(&p.positions, "VEC3", &place("a position"))?;
        let all = || p.positions.iter().map(|&v| Vec3::from(v));
        let (low, high) = (all().fold(Vec3::INFINITY, Vec3::min), all().fold(Vec3::NEG_INFINITY, Vec3::max));
        self.accessors[positions]["min"] = json!(low.to_array());
        self.accessors[positions]["max"] = json!(high.to_array());
        attributes.insert("POSITION".to_owned(), json!(positions));
        if !p.normals.is_empty() {
            attributes.insert("NORMAL".to_owned(), json!(self.floats(&p.normals, "VEC3", &place("a normal"))?));
        }
        if !p.tangents.is_empty() {
            attributes.insert("TANGENT".to_owned(), json!(self.floats(&p.tangents, "VEC4", &place("a tangent"))?));
        }
        for (set, uvs) in p.uvs.iter().enumerate().filter(|(_, uvs)| !uvs.is_empty()) {
            let accessor = self.floats(uvs, "VEC2", &place("a texture coordinate"))?;
            attributes.insert(format!("TEXCOORD_{set}"), json!(accessor));
        }
        if !p.colors.is_empty() {
            attributes.insert("COLOR_0".to_owned(), json!(self.floats(&p.colors, "VEC4", &place("a colour"))?));
        }
        let indices = p.triangles.iter().flatten();
        // The largest value of a type restarts primitives and may not be used.
        let (component, data): (u32, Vec<u8>) = if p.positions.len() < usize::from(u16::MAX) {
            (U16, indices.flat_map(|&i| (i as u16).to_le_bytes()).collect())
        } else {
            (U32, indices.flat_map(|&i| i.to_le_bytes()).collect())
        };
        let indices = self.accessor(&data, INDICES, component, "SCALAR", p.triangles.len() * 3);
        Ok(json!({ "attributes": attributes, "indices": indices, "material": p.material }))
    }

    fn texture(&mut self, texture: &Option<TextureRef>) -> Option<Value> {
        let texture = texture.as_ref()?;
        let mut value = json!({ "index": texture.texture });
        if texture.uv_set != 0 {
            value["texCoord"] = json!(texture.uv_set);
        }
        let [[a, b, x], [c, d, y]] = texture.uv_transform;
        if texture.uv_transform != TextureRef::IDENTITY {
            // The extension's matrix is T · R · S with R = [cos sin; −sin cos]; its columns give scale and angle.
            self.extensions.insert("KHR_texture_transform");
            let (sx, sy) = (a.hypot(c), b.hypot(d) * if a * d - b * c < 0.0 { -1.0 } else { 1.0 });
            let rotation = (-c).atan2(a);
            value["extensions"] =
                json!({ "KHR_texture_transform": { "offset": [x, y], "rotation": rotation, "scale": [sx, sy] } });
        }
        Some(value)
    }

    fn material(&mut self, m: &Material) -> Value {
        let mut pbr =
            json!({ "baseColorFactor": m.base_color, "metallicFactor": m.metallic, "roughnessFactor": m.roughness });
        if let Some(texture) = self.texture(&m.base_color_texture) {
            pbr["baseColorTexture"] = texture;
        }
        if let Some(texture) = self.texture(&m.metallic_roughness_texture) {
            pbr["metallicRoughnessTexture"] = texture;
        }
        let mut value = named(&m.name, json!({ "pbrMetallicRoughness": pbr }));
        if let Some(mut texture) = self.texture(&m.normal_texture) {
            texture["scale"] = json!(m.normal_scale);
            value["normalTexture"] = texture;
        }
        if let Some(mut texture) = self.texture(&m.occlusion_texture) {
            texture["strength"] = json!(m.occlusion_strength);
            value["occlusionTexture"] = texture;
        }
        if let Some(texture) = self.texture(&m.emissive_texture) {
            value["emissiveTexture"] = texture;
        }
        let strength = m.emissive.iter().copied().fold(0.0, f32::max);
        let mut extensions = Map::new();
        if strength > 0.0 {
            value["emissiveFactor"] = json!(m.emissive.map(|e| e / strength.max(1.0)));
        }
        if strength > 1.0 {
            self.extensions.insert("KHR_materials_emissive_strength");
            extensions.insert("KHR_materials_emissive_strength".to_owned(), json!({ "emissiveStrength": strength }));
        }
        if m.unlit {
            self.extensions.insert("KHR_materials_unlit");
            extensions.insert("KHR_materials_unlit".to_owned(), json!({}));
        }
        if !extensions.is_empty() {
            value["extensions"] = Value::Object(extensions);
        }
        match m.alpha_mode {
            AlphaMode::Opaque => {}
            AlphaMode::Mask { cutoff } => {
                value["alphaMode"] = json!("MASK");
                value["alphaCutoff"] = json!(cutoff);
            }
            AlphaMode::Blend => value["alphaMode"] = json!("BLEND"),
        }
        if m.double_sided {
            value["doubleSided"] = json!(true);
        }
        value
    }
}

#[cfg(test)]
#[path = "glb_tests.rs"]
mod tests;
