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
use crate::scene::NoticeKind;

/// The extension's name.
pub(super) const NAME: &str = "KHR_materials_variants";

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

/// Checks all mappings and gives primitives the material of the chosen variant.
pub(super) fn choose(
    root: &mut Root,
    names: &[String],
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<()> {
    let chosen = match &options.variant {
        None => None,
        Some(wanted) => Some(names.iter().position(|name| name == wanted).ok_or_else(|| {
            let offered = match names {
                [] => "the file has no variants".to_owned(),
                names => format!("the file has {}", names.join(", ")),
            };
            Fault::invalid("variant", format!("{wanted:?} does not exist: {offered}"))
        })?),
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
