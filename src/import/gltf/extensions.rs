//! What is known of glTF's extensions: which are shown, which are left out and what that costs, and without which a
//! file cannot be read.

use serde_json::Value;

use super::document::Document;
use super::{Fallible, Fault, Notices};

/// What happens to a file that uses an extension.
enum Support {
    /// It is shown.
    Full,
    /// Something like it is shown; the text says what.
    Approximate(&'static str),
    /// It is left out; the text says what is not shown.
    Without(&'static str),
    /// A file that requires it cannot be read (why); one that only uses it brings a substitute.
    Unreadable(&'static str),
}

/// The extensions that are known by name.
const KNOWN: &[(&str, Support)] = &[
    ("KHR_texture_transform", Support::Full),
    ("KHR_materials_unlit", Support::Full),
    ("KHR_materials_emissive_strength", Support::Full),
    ("KHR_mesh_quantization", Support::Full),
    (
        "KHR_materials_pbrSpecularGlossiness",
        Support::Approximate("shown as a non-metallic material of the same diffuse colour and smoothness"),
    ),
    ("KHR_materials_transmission", Support::Approximate("light that passes through a surface is not shown")),
    ("KHR_materials_diffuse_transmission", Support::Approximate("light that passes through a surface is not shown")),
    ("KHR_materials_volume", Support::Approximate("absorption and refraction inside a body are not shown")),
    ("KHR_materials_ior", Support::Approximate("every surface reflects as one with an index of refraction of 1.5")),
    ("KHR_materials_dispersion", Support::Approximate("dispersion is not shown")),
    ("KHR_materials_specular", Support::Approximate("strength and colour of the specular reflection are not shown")),
    ("KHR_materials_clearcoat", Support::Approximate("clear coats are not shown")),
    ("KHR_materials_sheen", Support::Approximate("the sheen of cloth is not shown")),
    ("KHR_materials_anisotropy", Support::Approximate("highlights are round where they should be stretched")),
    ("KHR_materials_iridescence", Support::Approximate("iridescence is not shown")),
    ("KHR_materials_variants", Support::Without("the file's default materials are shown")),
    ("KHR_lights_punctual", Support::Without("the file's lights are not used")),
    ("EXT_lights_image_based", Support::Without("the file's lights are not used")),
    ("KHR_animation_pointer", Support::Without("animations are not shown")),
    ("KHR_node_visibility", Support::Without("nodes that the file hides are shown")),
    ("KHR_xmp_json_ld", Support::Without("metadata is not kept")),
    ("KHR_xmp", Support::Without("metadata is not kept")),
    ("MSFT_lod", Support::Without("the finest level of detail is shown")),
    ("MSFT_packing_normalRoughnessMetallic", Support::Without("the core textures are used")),
    ("MSFT_packing_occlusionRoughnessMetallic", Support::Without("the core textures are used")),
    ("CESIUM_primitive_outline", Support::Without("outlines are not shown")),
    ("KHR_draco_mesh_compression", Support::Unreadable("its geometry is compressed")),
    ("EXT_meshopt_compression", Support::Unreadable("its buffers are compressed")),
    ("KHR_meshopt_compression", Support::Unreadable("its buffers are compressed")),
    ("KHR_texture_basisu", Support::Unreadable("its images are KTX2 files")),
    ("EXT_texture_webp", Support::Unreadable("its images are WebP files")),
    ("EXT_texture_avif", Support::Unreadable("its images are AVIF files")),
    ("MSFT_texture_dds", Support::Unreadable("its images are DDS files")),
    ("EXT_mesh_gpu_instancing", Support::Unreadable("copies of a mesh would be missing")),
];

fn known(name: &str) -> Option<&'static Support> {
    KNOWN.iter().find(|(known, _)| *known == name).map(|(_, support)| support)
}

/// Whether the content of the extension is read.
pub(super) fn is_supported(name: &str) -> bool {
    matches!(known(name), Some(Support::Full)) || name == "KHR_materials_pbrSpecularGlossiness"
}

/// One notice for each extension that is not shown in full.
///
/// # Errors
/// A required extension without which the file cannot be read.
pub(super) fn report(document: &Document, notices: &mut Notices) -> Fallible<()> {
    for (i, name) in document.root.extensions_required.iter().enumerate() {
        let cause = match known(name) {
            Some(Support::Unreadable(cause)) => cause,
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
    for (name, place) in &document.extensions {
        match known(name) {
            Some(Support::Full) => {}
            Some(Support::Approximate(what)) => notices.approximated(format!("{name}: {what}")),
            Some(Support::Without(what)) => notices.ignored(format!("{name}: {what}")),
            Some(Support::Unreadable(what)) => {
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
