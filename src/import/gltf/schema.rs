//! The shape of the JSON: members that glTF does not have, lists that must not be empty, values that are allowed to be few.
//!
//! `gltf-json` refuses what has a wrong type and passes over what it does not know. What it passes over is told here: a
//! member with a typing error does nothing, and whoever wrote it should hear so. Nothing that is found here changes what is read.

use serde_json::{Map, Value};

use super::{Fallible, Fault, Notices};
use crate::scene::NoticeKind::{Ignored, Repaired};

/// Kinds of objects with the members that glTF 2.0 gives them.
const OBJECTS: &[(&str, &str)] = &[
    (
        "glTF",
        "accessors animations asset buffers bufferViews cameras images materials meshes nodes samplers scene scenes skins \
         textures extensionsUsed extensionsRequired",
    ),
    ("asset", "copyright generator version minVersion"),
    ("accessors", "bufferView byteOffset componentType normalized count type max min sparse name"),
    ("sparse", "count indices values"),
    ("sparse.indices", "bufferView byteOffset componentType"),
    ("sparse.values", "bufferView byteOffset"),
    ("buffers", "uri byteLength name"),
    ("bufferViews", "buffer byteOffset byteLength byteStride target name"),
    ("cameras", "orthographic perspective type name"),
    ("orthographic", "xmag ymag zfar znear"),
    ("perspective", "aspectRatio yfov zfar znear"),
    ("images", "uri mimeType bufferView name"),
    (
        "materials",
        "name pbrMetallicRoughness normalTexture occlusionTexture emissiveTexture emissiveFactor alphaMode alphaCutoff \
         doubleSided",
    ),
    (
        "pbrMetallicRoughness",
        "baseColorFactor baseColorTexture metallicFactor roughnessFactor metallicRoughnessTexture",
    ),
    ("texture", "index texCoord"),
    ("normalTexture", "index texCoord scale"),
    ("occlusionTexture", "index texCoord strength"),
    ("meshes", "primitives weights name"),
    ("primitives", "attributes indices material mode targets"),
    ("nodes", "camera children skin matrix mesh rotation scale translation weights name"),
    ("samplers", "magFilter minFilter wrapS wrapT name"),
    ("scenes", "nodes name"),
    ("textures", "sampler source name"),
    ("skins", "inverseBindMatrices skeleton joints name"),
];

/// Where extensions that are read stand.
const PLACES: &[(&str, &str)] = &[
    ("EXT_meshopt_compression", "buffers bufferViews"),
    ("KHR_meshopt_compression", "buffers bufferViews"),
    ("KHR_draco_mesh_compression", "primitives"),
    ("EXT_mesh_gpu_instancing", "nodes"),
    ("KHR_node_visibility", "nodes"),
    ("KHR_materials_variants", "glTF primitives"),
    ("KHR_texture_basisu", "textures"),
    ("EXT_texture_webp", "textures"),
    ("KHR_texture_transform", "texture normalTexture occlusionTexture"),
    ("KHR_materials_unlit", "materials"),
    ("KHR_materials_emissive_strength", "materials"),
    ("KHR_materials_pbrSpecularGlossiness", "materials"),
];

fn holds(words: &str, word: &str) -> bool {
    words.split_ascii_whitespace().any(|w| w == word)
}

/// Looks at everything that is read.
///
/// # Errors
/// A buffer without a length: `gltf-json` would take it for an empty one.
pub(super) fn check(top: &Map<String, Value>, notices: &mut Notices) -> Fallible<()> {
    object(top, "glTF", "glTF", notices);
    for (i, buffer) in elements(top, "buffers") {
        if buffer.get("byteLength").is_none() {
            return Err(Fault::invalid(format!("buffers[{i}].byteLength"), "is missing"));
        }
    }
    let whole = |value: Option<&Value>| value.and_then(Value::as_u64);
    let empty = |what: &str, member: &str, notices: &mut Notices| {
        for (i, element) in elements(top, what) {
            let said =
                "accessors, buffers or buffer views are empty, which glTF does not allow; they were read as such";
            let is_empty = whole(element.get(member)) == Some(0);
            notices.count(Repaired, said, is_empty.into(), &format!("{what}[{i}].{member}"));
        }
    };
    empty("accessors", "count", notices);
    empty("buffers", "byteLength", notices);
    empty("bufferViews", "byteLength", notices);
    for (i, view) in elements(top, "bufferViews") {
        let Some(stride) = whole(view.get("byteStride")) else { continue };
        let place = format!("bufferViews[{i}].byteStride");
        let odd = !stride.is_multiple_of(4) || !(4..=252).contains(&stride);
        let said = "strides are not a multiple of 4 from 4 to 252, as glTF asks; they were used as they are";
        notices.count(Repaired, said, odd.into(), &place);
        let long = whole(view.get("byteLength")).is_some_and(|length| stride > length);
        notices.count(
            Repaired,
            "strides are longer than their buffer view; they were used as they are",
            long.into(),
            &place,
        );
        let wrong = whole(view.get("target")) == Some(gltf_json::buffer::ELEMENT_ARRAY_BUFFER.into());
        let said = "buffer views of indices have a stride, which glTF does not allow; it was used as it is";
        notices.count(Repaired, said, wrong.into(), &place);
    }
    for (i, accessor) in elements(top, "accessors") {
        let alone = accessor.get("byteOffset").is_some() && accessor.get("bufferView").is_none();
        let said = "accessors have an offset but no buffer view; the offset does nothing";
        notices.count(Repaired, said, alone.into(), &format!("accessors[{i}].byteOffset"));
    }
    for (i, image) in elements(top, "images") {
        let untyped = image.get("bufferView").is_some() && image.get("mimeType").is_none();
        let said = "images in buffer views have no mimeType; their kind was told by their content";
        notices.count(Repaired, said, untyped.into(), &format!("images[{i}]"));
    }
    for (i, scene) in elements(top, "scenes") {
        let mut roots: Vec<u64> =
            scene.get("nodes").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_u64).collect();
        let named = roots.len();
        roots.sort_unstable();
        roots.dedup();
        let said = "nodes are named twice by a scene; they are shown once";
        notices.count(Repaired, said, (named - roots.len()) as u64, &format!("scenes[{i}].nodes"));
    }
    Ok(())
}

fn elements<'a>(top: &'a Map<String, Value>, list: &str) -> impl Iterator<Item = (usize, &'a Value)> {
    top.get(list).and_then(Value::as_array).into_iter().flatten().enumerate()
}

/// Looks at an object of a kind, and at what is in it.
fn object(members: &Map<String, Value>, kind: &str, place: &str, notices: &mut Notices) {
    let Some(&(_, known)) = OBJECTS.iter().find(|(name, _)| *name == kind) else { return };
    for (name, value) in members {
        let inside = if kind == "glTF" { name.clone() } else { format!("{place}.{name}") };
        match name.as_str() {
            "extras" | "animations" => continue,
            "extensions" => {
                for extension in value.as_object().into_iter().flat_map(Map::keys) {
                    let allowed = PLACES.iter().find(|(known, _)| known == extension);
                    let misplaced = allowed.is_some_and(|(_, places)| !holds(places, kind));
                    let said = "extensions stand where they mean nothing, and are ignored";
                    notices.count(Ignored, said, misplaced.into(), &format!("{inside}.{extension}"));
                }
            }
            _ if !holds(known, name) => {
                notices.count(Ignored, "members are not of glTF and are ignored", 1, &inside);
                continue;
            }
            _ => {}
        }
        let is_empty = match value {
            Value::Array(list) => list.is_empty(),
            Value::Object(members) => members.is_empty() && name == "attributes",
            _ => false,
        };
        let said = "lists are empty, which glTF does not allow; they were read as if they were not there";
        notices.count(Repaired, said, is_empty.into(), &inside);
        let kind = match (kind, name.as_str()) {
            ("sparse", "indices") => "sparse.indices",
            ("sparse", "values") => "sparse.values",
            (_, "baseColorTexture" | "metallicRoughnessTexture" | "emissiveTexture") => "texture",
            // Of names, numbers and dictionaries there is no kind, so that they are not looked into.
            (_, name) => name,
        };
        match value {
            Value::Object(members) => object(members, kind, &inside, notices),
            Value::Array(list) => {
                for (i, element) in list.iter().enumerate() {
                    if let Value::Object(members) = element {
                        object(members, kind, &format!("{inside}[{i}]"), notices);
                    }
                }
            }
            _ => {}
        }
    }
}
