//! KHR_materials_variants: one model in several finishes.
//!
//! The file lists names, and each primitive which material it has under which of them. Without a choice
//! ([`ImportOptions::variant`]) every primitive has its own material, which is the file's default; with one, primitives
//! that say nothing about it keep theirs, as the extension asks.

use std::collections::HashSet;

use gltf_json::Root;
use serde_json::Value;

use super::accessor::missing;
use super::{Fallible, Fault, ImportOptions, Notices};
use crate::math::spelling::nearest;
use crate::scene::NoticeKind;

/// The extension's name.
pub(super) const NAME: &str = "KHR_materials_variants";

/// So many names are listed where one is not found.
const MOST_LISTED: usize = 40;

/// The names in the file's own order, from the content of its top-level extension.
pub(super) fn names(object: Option<&Value>) -> Fallible<Vec<String>> {
    let place = format!("extensions.{NAME}.variants");
    let Some(object) = object else { return Ok(Vec::new()) };
    let Some(list) = object.get("variants").and_then(Value::as_array) else {
        return Err(Fault::invalid(place, "is not a list"));
    };
    let name = |(i, variant): (usize, &Value)| {
        let name = variant.get("name").and_then(Value::as_str);
        name.map(str::to_owned).ok_or_else(|| Fault::invalid(format!("{place}[{i}]"), "has no name"))
    };
    list.iter().enumerate().map(name).collect()
}

/// That there is no variant of the name `wanted`, with the names that there are, and the nearest.
pub(in crate::import) fn unknown(wanted: &str, names: &[String]) -> Fault {
    if names.is_empty() {
        return Fault::invalid("variant", format!("'{wanted}' does not exist: the file has no variants"));
    }
    let listed = names.iter().take(MOST_LISTED).map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
    let more = match names.len().saturating_sub(MOST_LISTED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let hint = nearest(wanted, names.iter().map(String::as_str)).map(|name| format!("; did you mean '{name}'?"));
    let hint = hint.unwrap_or_default();
    Fault::invalid("variant", format!("'{wanted}' does not exist: the file has {listed}{more}{hint}"))
}

/// Checks all mappings and gives primitives the material of the chosen variant.
pub(super) fn choose(
    root: &mut Root,
    names: &[String],
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<()> {
    let chosen = match &options.variant {
        None => None,
        Some(wanted) => Some(names.iter().position(|name| name == wanted).ok_or_else(|| unknown(wanted, names))?),
    };
    let materials = root.materials.len();
    for (m, mesh) in root.meshes.iter_mut().enumerate() {
        for (p, primitive) in mesh.primitives.iter_mut().enumerate() {
            let Some(mapped) = primitive.extensions.as_ref().and_then(|e| e.khr_materials_variants.as_ref()) else {
                continue;
            };
            let place = format!("meshes[{m}].primitives[{p}].extensions.{NAME}");
            let mut seen = HashSet::new();
            let mut twice = 0;
            let mut material = None;
            for (k, mapping) in mapped.mappings.iter().enumerate() {
                if mapping.material as usize >= materials {
                    let place = format!("{place}.mappings[{k}].material");
                    return Err(missing(place, "material", mapping.material as usize, materials));
                }
                for &variant in &mapping.variants {
                    if variant as usize >= names.len() {
                        let place = format!("{place}.mappings[{k}].variants");
                        return Err(missing(place, "variant", variant as usize, names.len()));
                    }
                    if !seen.insert(variant) {
                        twice += 1;
                    } else if Some(variant as usize) == chosen {
                        material = Some(mapping.material);
                    }
                }
            }
            let what = "variants are mapped twice in a primitive; the first mapping counts";
            notices.count(NoticeKind::Repaired, what, twice, &place);
            if let Some(material) = material {
                primitive.material = Some(gltf_json::Index::new(material));
            }
        }
    }
    Ok(())
}
