//! The JSON: text to `gltf-json`'s types, object by object, so that an error can name its place.
//!
//! Three things are done to the raw values first. Extensions that are not supported are taken out (their names are
//! kept), so that their content can neither refuse nor confuse the file; `extras` go too. Indices and enumeration values
//! are checked to fit 32 bits, since `gltf-json` cuts them off. What glTF leaves optional but the types require is
//! filled in.

use std::collections::BTreeMap;

use gltf_json::Root;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::extensions::{is_supported, note_values};
use super::{Fallible, Fault, Notices, schema, variants};

/// A parsed file.
pub(super) struct Document {
    pub(super) root: Root,
    /// Every extension that the file names or contains, with the first place where it was found.
    pub(super) extensions: BTreeMap<String, String>,
    /// Names of material variants.
    pub(super) variants: Vec<String>,
}

/// Members whose numbers are indices or enumeration values.
const SMALL_NUMBERS: &[&str] = &[
    "bufferView",
    "buffer",
    "node",
    "mesh",
    "skin",
    "camera",
    "material",
    "indices",
    "source",
    "sampler",
    "index",
    "scene",
    "skeleton",
    "componentType",
    "mode",
    "target",
    "magFilter",
    "minFilter",
    "wrapS",
    "wrapT",
    "input",
    "output",
    "children",
    "nodes",
    "joints",
    "attributes",
    "targets",
    "texCoord",
    "inverseBindMatrices",
];

/// Parses the JSON of a file.
pub(super) fn parse(json: &[u8], notices: &mut Notices) -> Fallible<Document> {
    let value: Value = serde_json::from_slice(json).map_err(|e| Fault::invalid("JSON", e.to_string()))?;
    let Value::Object(mut top) = value else {
        return Err(Fault::invalid("JSON", "is not an object"));
    };
    version(&top, notices)?;
    schema::check(&top, notices)?;
    let mut extensions = BTreeMap::new();
    for list in ["extensionsUsed", "extensionsRequired"] {
        let names: Vec<String> = take(&mut top, list)?.unwrap_or_default();
        for (i, name) in names.iter().enumerate() {
            extensions.entry(name.clone()).or_insert_with(|| format!("{list}[{i}]"));
        }
        top.insert(list.to_owned(), names.into());
    }
    // Whatever is in these is none of glTF's business.
    top.remove("extras");
    let mut variants = Vec::new();
    if let Some(Value::Object(found)) = top.remove("extensions") {
        for name in found.keys() {
            extensions.entry(name.clone()).or_insert_with(|| format!("extensions.{name}"));
        }
        variants = variants::names(found.get(variants::NAME))?;
    }
    for (key, value) in &mut top {
        clean(value, key, key, &mut extensions, notices)?;
    }
    for scene in top.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Value::Object(scene) = scene {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    let root = Root {
        asset: take(&mut top, "asset")?.unwrap_or_default(),
        scene: take(&mut top, "scene")?,
        extensions_used: take(&mut top, "extensionsUsed")?.unwrap_or_default(),
        extensions_required: take(&mut top, "extensionsRequired")?.unwrap_or_default(),
        accessors: list(&mut top, "accessors")?,
        buffers: list(&mut top, "buffers")?,
        buffer_views: list(&mut top, "bufferViews")?,
        cameras: list(&mut top, "cameras")?,
        images: list(&mut top, "images")?,
        materials: list(&mut top, "materials")?,
        meshes: list(&mut top, "meshes")?,
        nodes: list(&mut top, "nodes")?,
        samplers: list(&mut top, "samplers")?,
        scenes: list(&mut top, "scenes")?,
        textures: list(&mut top, "textures")?,
        ..Root::default()
    };
    rest_pose(&top, &root, notices);
    Ok(Document { root, extensions, variants })
}

/// `asset.version` 2.x is read; a `minVersion` above 2.0 is not.
fn version(top: &Map<String, Value>, notices: &mut Notices) -> Fallible<()> {
    let asset = top.get("asset").ok_or_else(|| Fault::invalid("asset", "is missing"))?;
    let parse = |key: &str| -> Fallible<Option<(u32, u32)>> {
        let Some(value) = asset.get(key) else { return Ok(None) };
        let place = format!("asset.{key}");
        let text = value.as_str().ok_or_else(|| Fault::invalid(&place, "is not a string"))?;
        let numbers = text.split_once('.').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        numbers.map(Some).ok_or_else(|| Fault::invalid(place, format!("{text:?} is not a version like \"2.0\"")))
    };
    let Some((major, minor)) = parse("version")? else {
        return Err(Fault::invalid("asset.version", "is missing"));
    };
    if major != 2 {
        return Err(Fault::invalid("asset.version", format!("glTF {major}.{minor}: glTF 2 is read")));
    }
    if let Some((major, minor)) = parse("minVersion")?
        && (major, minor) > (2, 0)
    {
        return Err(Fault::invalid("asset.minVersion", format!("needs glTF {major}.{minor}: glTF 2.0 is read")));
    }
    if minor != 0 {
        notices.approximated(format!("asset.version: glTF 2.{minor} was read as glTF 2.0"));
    }
    Ok(())
}

/// Takes a member out of an object.
fn take<T: DeserializeOwned>(top: &mut Map<String, Value>, key: &str) -> Fallible<Option<T>> {
    match top.remove(key) {
        None => Ok(None),
        Some(value) => serde_json::from_value(value).map(Some).map_err(|e| Fault::invalid(key, e.to_string())),
    }
}

/// Takes an array out of the top object, element by element.
fn list<T: DeserializeOwned>(top: &mut Map<String, Value>, key: &str) -> Fallible<Vec<T>> {
    let values: Vec<Value> = take(top, key)?.unwrap_or_default();
    let element =
        |(i, value)| serde_json::from_value(value).map_err(|e| Fault::invalid(format!("{key}[{i}]"), e.to_string()));
    values.into_iter().enumerate().map(element).collect()
}

/// Walks the raw values; see the module. `key` is the member that `value` is, or is an element, of.
fn clean(
    value: &mut Value,
    key: &str,
    place: &str,
    found: &mut BTreeMap<String, String>,
    notices: &mut Notices,
) -> Fallible<()> {
    match value {
        Value::Number(number) => {
            let whole = number.as_u64();
            if SMALL_NUMBERS.contains(&key) && whole.is_none_or(|n| n > u64::from(u32::MAX - 1)) {
                return Err(Fault::invalid(place, format!("{number} is not an index or a value of the format")));
            }
        }
        Value::Array(elements) => {
            let small = SMALL_NUMBERS.contains(&key);
            for (i, element) in elements.iter_mut().enumerate() {
                if !small && !element.is_array() && !element.is_object() {
                    continue;
                }
                clean(element, key, &format!("{place}[{i}]"), found, notices)?;
            }
        }
        Value::Object(members) => {
            members.remove("extras");
            if let Some(Value::Object(extensions)) = members.get_mut("extensions") {
                extensions.retain(|name, content| {
                    let inside = format!("{place}.extensions.{name}");
                    note_values(name, content, &inside, notices);
                    found.entry(name.clone()).or_insert(inside);
                    is_supported(name)
                });
            }
            // In a dictionary of indices the values stand under names of the file's choice.
            let dictionary = matches!(key, "attributes" | "targets");
            for (name, member) in members.iter_mut() {
                let key = if dictionary { key } else { name.as_str() };
                clean(member, key, &format!("{place}.{name}"), found, notices)?;
            }
        }
        _ => {}
    }
    Ok(())
}

/// Says once for each kind of motion that the file is shown at rest.
fn rest_pose(top: &Map<String, Value>, root: &Root, notices: &mut Notices) {
    let count = |key: &str| top.get(key).and_then(Value::as_array).map_or(0, Vec::len);
    let told = [
        (count("animations"), "animations: the model is shown as it stands without them"),
        (count("skins"), "skins: skinned meshes are shown in their bind pose"),
        (
            root.meshes.iter().filter(|m| m.primitives.iter().any(|p| p.targets.is_some())).count(),
            "meshes with morph targets: they are shown without them",
        ),
    ];
    for (count, what) in told {
        if count > 0 {
            notices.ignored(format!("{count} {what}"));
        }
    }
}
