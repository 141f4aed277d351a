//! EXT_mesh_gpu_instancing: one node that shows its mesh many times.
//!
//! The extension gives translations, rotations and scales as accessors; what a node shows at its own place without it, it
//! shows at `node · T·R·S` for each element. Instances stay instances: every one becomes a child node that shares the mesh,
//! so that it is a part with a name (`NAME #1`, `NAME #2` …), can be hidden and picked, and costs no geometry. Source: the
//! extension's specification. Other attributes of instances, which the extension leaves to applications, are not read.

use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec3};
use gltf_json::Index;
use gltf_json::accessor::{ComponentType, Type};
use gltf_json::scene::Node as Source;
use serde::Deserialize;

use super::accessor::{Accessor, Data};
use super::{Fallible, Fault, Limits, Notices};
use crate::scene::NoticeKind;

const NAME: &str = "EXT_mesh_gpu_instancing";

/// The extension's object in a node.
#[derive(Deserialize)]
struct Stored {
    attributes: BTreeMap<String, u32>,
}

/// The places of a node's instances, in the node's space; `None` if it has none of the kind. `total` counts those of
/// the whole file.
pub(super) fn read(
    source: &Source,
    data: &Data,
    place: &str,
    limits: &Limits,
    total: &mut u64,
    notices: &mut Notices,
) -> Fallible<Option<Vec<DMat4>>> {
    let Some(object) = source.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(None) };
    let place = format!("{place}.extensions.{NAME}");
    if source.mesh.is_none() {
        notices.count(NoticeKind::Repaired, "nodes with instances have no mesh; they are ignored", 1, &place);
        return Ok(None);
    }
    let stored = Stored::deserialize(object).map_err(|e| Fault::invalid(&place, e.to_string()))?;
    let find = |name: &str, shape: Type| -> Fallible<Option<&Accessor>> {
        let Some(&index) = stored.attributes.get(name) else { return Ok(None) };
        let place = format!("{place}.attributes.{name}");
        let accessor = data.accessor(Index::<gltf_json::Accessor>::new(index), &place)?;
        use ComponentType::{F32, I8, I16};
        let integer = name == "ROTATION" && accessor.normalized && matches!(accessor.component, I8 | I16);
        if accessor.shape != shape || !(accessor.component == F32 || integer) {
            return Err(Fault::invalid(place, format!("cannot be {}", accessor.describe())));
        }
        Ok(Some(accessor))
    };
    let translation = find("TRANSLATION", Type::Vec3)?;
    let rotation = find("ROTATION", Type::Vec4)?;
    let scale = find("SCALE", Type::Vec3)?;
    let others = stored.attributes.len() - [translation, rotation, scale].iter().flatten().count();
    let what = "attributes of instances are not of the extension's and are not read";
    notices.count(NoticeKind::Ignored, what, others as u64, &place);
    let mut counts = [translation, rotation, scale].into_iter().flatten().map(|a| a.count);
    let Some(count) = counts.next() else {
        return Err(Fault::invalid(format!("{place}.attributes"), "has none of TRANSLATION, ROTATION and SCALE"));
    };
    if let Some(other) = counts.find(|&c| c != count) {
        let cause = format!("has accessors of {count} and of {other} elements");
        return Err(Fault::invalid(format!("{place}.attributes"), cause));
    }
    *total = total.saturating_add(count);
    if *total > limits.instances {
        return Err(Fault::limit(place, "instances of all nodes so far", *total, limits.instances));
    }
    let count = u32::try_from(count).map_err(|_| Fault::limit(&place, "instances", count, u32::MAX.into()))?;
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let (mut places, mut broken, mut odd) = (Vec::new(), 0, 0);
    for i in 0..count {
        let move_by = translation.map_or(DVec3::ZERO, |a| vector(a.numbers(i)));
        let size = scale.map_or(DVec3::ONE, |a| vector(a.numbers(i)));
        let turn = rotation.map_or(DQuat::IDENTITY, |a| DQuat::from_array(a.numbers::<4>(i).map(f64::from)));
        let length = turn.length();
        // Bytes are rounded to 1/127, which is all the length of a sum of four can be off.
        odd += u64::from((length - 1.0).abs() > 2e-2);
        let turn = if length > 1e-12 { turn / length } else { DQuat::IDENTITY };
        let place = DMat4::from_scale_rotation_translation(size, turn, move_by);
        if place.is_finite() {
            places.push(place);
        } else {
            broken += 1;
        }
    }
    notices.count(NoticeKind::Repaired, "instances whose place is not finite were dropped", broken, &place);
    notices.count(
        NoticeKind::Repaired,
        "rotations of instances were not unit quaternions and were normalized",
        odd,
        &place,
    );
    Ok(Some(places))
}
