//! What is known of glTF's extensions: which are shown, which are left out and what that costs, and without which a
//! file cannot be read.

use serde_json::Value;

use super::document::Document;
use super::{Fallible, Fault, Notices};
use crate::import::features::{Feature, Treatment};

/// What happens to a file that uses an extension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Support {
    /// It is shown; the text says what it is.
    Full(&'static str),
    /// Something like it is shown; the text says what.
    Approximate(&'static str),
    /// It is left out; the text says what is not shown.
    Without(&'static str),
    /// A file that requires it cannot be read (why); one that only uses it brings a substitute.
    Unreadable(&'static str),
}

use Support::{Approximate, Full, Unreadable, Without};

/// The extensions that are known by name.
pub(super) const KNOWN: &[(&str, Support)] = &[
    ("KHR_mesh_quantization", Full("attributes of small integers")),
    ("EXT_meshopt_compression", Full("compressed buffer views")),
    ("KHR_meshopt_compression", Full("compressed buffer views, with version 1 of the vertex codec and colours")),
    ("KHR_draco_mesh_compression", Full("primitives as Draco streams")),
    ("EXT_mesh_gpu_instancing", Full("a mesh shown many times; every instance is a part")),
    ("KHR_materials_variants", Full("one finish of several, by name")),
    ("KHR_texture_basisu", Full("KTX2 images in ETC1S and UASTC")),
    ("EXT_texture_webp", Full("WebP images")),
    ("KHR_texture_transform", Full("texture coordinates that are moved, turned and scaled")),
    ("KHR_materials_unlit", Full("base colour as it is")),
    ("KHR_materials_emissive_strength", Full("emission above 1")),
    ("KHR_node_visibility", Approximate("nodes that the file hides are left out, not hidden parts")),
    (
        "KHR_materials_pbrSpecularGlossiness",
        Approximate("shown as a non-metallic material of the same diffuse colour and smoothness"),
    ),
    ("KHR_materials_transmission", Approximate("light that passes through a surface is not shown")),
    ("KHR_materials_diffuse_transmission", Approximate("light that passes through a surface is not shown")),
    ("KHR_materials_volume", Approximate("absorption and refraction inside a body are not shown")),
    ("KHR_materials_ior", Approximate("every surface reflects as one with an index of refraction of 1.5")),
    ("KHR_materials_dispersion", Approximate("dispersion is not shown")),
    ("KHR_materials_specular", Approximate("strength and colour of the specular reflection are not shown")),
    ("KHR_materials_clearcoat", Approximate("clear coats are not shown")),
    ("KHR_materials_sheen", Approximate("the sheen of cloth is not shown")),
    ("KHR_materials_anisotropy", Approximate("highlights are round where they should be stretched")),
    ("KHR_materials_iridescence", Approximate("iridescence is not shown")),
    ("KHR_lights_punctual", Without("the file's lights are not used")),
    ("EXT_lights_image_based", Without("the file's lights are not used")),
    ("KHR_animation_pointer", Without("animations are not shown")),
    ("KHR_xmp_json_ld", Without("metadata is not kept")),
    ("KHR_xmp", Without("metadata is not kept")),
    ("MSFT_lod", Without("the finest level of detail is shown")),
    ("MSFT_packing_normalRoughnessMetallic", Without("the core textures are used")),
    ("MSFT_packing_occlusionRoughnessMetallic", Without("the core textures are used")),
    ("CESIUM_primitive_outline", Without("outlines are not shown")),
    ("EXT_texture_avif", Unreadable("its images are AVIF files")),
    ("MSFT_texture_dds", Unreadable("its images are DDS files")),
];

fn known(name: &str) -> Option<&'static Support> {
    KNOWN.iter().find(|(known, _)| *known == name).map(|(_, support)| support)
}

/// What of glTF's core is read, then what of each extension.
pub(in crate::import) fn features() -> Vec<Feature> {
    use Treatment::{Approximated, Ignored, Read, Refused};
    let row = |feature, treatment, note| Feature { format: "glTF 2.0", feature, treatment, note };
    let mut rows = vec![
        row("`.glb` and `.gltf`", Read, "told apart by content"),
        row("buffers", Read, "in the GLB, in data URIs, in files in the model's folder or below"),
        row("triangles, strips, fans", Read, "indexed or not"),
        row("points and lines", Ignored, "only surfaces are shown"),
        row("interleaved and sparse accessors", Read, ""),
        row("normals", Read, "computed where missing, with a crease angle"),
        row("tangents", Read, "made by MikkTSpace where a normal map needs them"),
        row("texture coordinates 0 and 1", Read, "higher sets are ignored"),
        row("vertex colours", Read, "the first set"),
        row("morph targets", Ignored, "the undeformed mesh is shown"),
        row("skins", Ignored, "the bind pose is shown"),
        row("animations", Ignored, "the model is shown as it stands without them"),
        row("metallic-roughness materials", Read, "with alpha modes, emission, occlusion and normal maps"),
        row("samplers", Read, "filters and wrap modes"),
        row("PNG and JPEG", Read, "8 bits a channel; 16 are reduced, colour profiles not applied"),
        row("nodes", Read, "every node with a mesh is a part"),
        row("scenes", Read, "the default one, or the first"),
        row("cameras", Read, "the near and far planes are not used"),
        row("references out of the model's folder", Refused, "and schemes, absolute paths, links, devices"),
        row("other extensions that are required", Refused, "but for ones about materials, lights and animation"),
        row("other extensions that are used", Ignored, ""),
    ];
    rows.extend(KNOWN.iter().map(|&(name, support)| match support {
        Full(note) => row(name, Read, note),
        Approximate(note) => row(name, Approximated, note),
        Without(note) => row(name, Ignored, note),
        Unreadable(note) => row(name, Refused, note),
    }));
    rows
}

/// Whether the content of the extension is read. Of textures' images of kinds that are not, the index is.
pub(super) fn is_supported(name: &str) -> bool {
    match known(name) {
        Some(Full(_) | Unreadable(_)) => true,
        _ => matches!(name, "KHR_materials_pbrSpecularGlossiness" | "KHR_node_visibility"),
    }
}

/// One notice for each extension that is not shown in full.
///
/// # Errors
/// A required extension without which the file cannot be read.
pub(super) fn report(document: &Document, notices: &mut Notices) -> Fallible<()> {
    for (i, name) in document.root.extensions_required.iter().enumerate() {
        let cause = match known(name) {
            Some(Unreadable(cause)) => cause,
            Some(_) => continue,
            // Materials, lights and animations change how a thing looks, not which things there are.
            None if ["_materials_", "_lights_", "_animation_"].iter().any(|part| name.contains(part)) => continue,
            None => "the file says that it cannot be shown without it",
        };
        return Err(Fault::Unsupported {
            place: format!("extensionsRequired[{i}]"),
            extension: name.clone(),
            cause: cause.to_owned(),
        });
    }
    let required = |name: &String| document.root.extensions_required.contains(name);
    for (name, place) in &document.extensions {
        // The first place where it was found is the list of those used, if it is there.
        if place.starts_with("extensionsRequired[") {
            notices.repaired(format!("{name}: the file requires it but does not list it in extensionsUsed"));
        } else if !place.starts_with("extensionsUsed[") {
            notices.repaired(format!("{name}: the file does not list it in extensionsUsed (first at {place})"));
        } else if name == "KHR_mesh_quantization" && !required(name) {
            notices.repaired(format!("{name}: the file uses it but does not list it in extensionsRequired"));
        }
        match known(name) {
            Some(Full(_)) => {}
            // Told where it happens, with how many.
            Some(Approximate(_)) if name == "KHR_node_visibility" => {}
            Some(Approximate(what)) => notices.approximated(format!("{name}: {what}")),
            Some(Without(what)) => notices.ignored(format!("{name}: {what}")),
            Some(Unreadable(what)) => {
                notices.ignored(format!("{name}: {what}, so the file's substitute without the extension is shown"));
            }
            None => notices.ignored(format!("{name}: the extension is not known (first at {place})")),
        }
    }
    Ok(())
}

/// Members of unsupported extensions with their ranges: what lies outside is told, since it says that the file is bad.
const RANGES: &[(&str, &str, f64, f64)] = &[
    ("KHR_materials_volume", "thicknessFactor", 0.0, f64::MAX),
    ("KHR_materials_volume", "attenuationDistance", f64::MIN_POSITIVE, f64::MAX),
    ("KHR_materials_volume", "attenuationColor", 0.0, 1.0),
    ("KHR_materials_transmission", "transmissionFactor", 0.0, 1.0),
    ("KHR_materials_clearcoat", "clearcoatFactor", 0.0, 1.0),
    ("KHR_materials_specular", "specularFactor", 0.0, 1.0),
];

/// Tells values that are out of range.
pub(super) fn note_values(name: &str, content: &Value, place: &str, notices: &mut Notices) {
    for (_, member, low, high) in RANGES.iter().filter(|r| r.0 == name) {
        let numbers: Vec<f64> = match content.get(member) {
            Some(Value::Array(list)) => list.iter().filter_map(Value::as_f64).collect(),
            Some(value) => value.as_f64().into_iter().collect(),
            None => continue,
        };
        if let Some(bad) = numbers.into_iter().find(|n| n < low || n > high) {
            notices.repaired(format!("{place}.{member}: {bad} is out of range; the extension is left out"));
        }
    }
}
