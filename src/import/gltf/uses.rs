//! What buffer views and accessors are used for, held against what glTF allows for that use.
//!
//! glTF lets a program hand buffer views to a GPU as they are, and so asks for strides, alignment and a single use of each. This
//! reader takes elements out one by one and needs none of it. Files that break these rules are read as they mean it, and
//! told, because other programs may not be able to.

use gltf_json::buffer::Target;
use gltf_json::mesh::Semantic;
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Root};

use super::Notices;
use crate::scene::NoticeKind::Repaired;

#[derive(Clone, Default)]
struct Use {
    vertices: bool,
    indices: bool,
    image: bool,
}

/// Tells every use that glTF does not allow. References into nothing are for others to refuse.
pub(super) fn report(root: &Root, notices: &mut Notices) {
    let mut accessors = vec![Use::default(); root.accessors.len()];
    let mut images = vec![false; root.buffer_views.len()];
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let mut sets = [0_u32; 2];
            let mut highest = [0_u32; 2];
            for (semantic, index) in &primitive.attributes {
                if let Some(accessor) = accessors.get_mut(index.value()) {
                    accessor.vertices = true;
                }
                let (kind, set) = match semantic {
                    Checked::Valid(Semantic::TexCoords(set)) => (0, *set),
                    Checked::Valid(Semantic::Colors(set)) => (1, *set),
                    _ => continue,
                };
                sets[kind] += 1;
                highest[kind] = highest[kind].max(set.saturating_add(1));
            }
            let gaps = sets != highest;
            let what = "primitives have sets of texture coordinates or colours that are not numbered from 0 on; their numbers count";
            notices.count(Repaired, what, gaps.into(), &format!("meshes[{m}].primitives[{p}].attributes"));
            if let Some(accessor) = primitive.indices.and_then(|i| accessors.get_mut(i.value())) {
                accessor.indices = true;
            }
        }
    }
    for view in root.images.iter().filter_map(|i| i.buffer_view) {
        if let Some(image) = images.get_mut(view.value()) {
            *image = true;
        }
    }
    let mut views = vec![(Use::default(), 0_u64); root.buffer_views.len()];
    for (i, (accessor, used)) in root.accessors.iter().zip(&accessors).enumerate() {
        let place = format!("accessors[{i}]");
        let both = used.vertices && used.indices;
        notices.count(
            Repaired,
            "accessors are used for vertices and for indices; they were read as both",
            both.into(),
            &place,
        );
        let Some(index) = accessor.buffer_view else { continue };
        let Some(view) = root.buffer_views.get(index.value()) else { continue };
        let stride = view.byte_stride.map(|s| s.0).filter(|&s| s != 0);
        if let Some((uses, attributes)) = views.get_mut(index.value()) {
            uses.vertices |= used.vertices;
            uses.indices |= used.indices;
            *attributes += u64::from(used.vertices);
        }
        let offset = accessor.byte_offset.map_or(0, |o| o.0);
        let unaligned = !offset.is_multiple_of(4) || (stride.is_none() && !size(accessor).is_multiple_of(4));
        let what = "vertex attributes do not begin at multiples of 4 bytes; they were read as they are";
        notices.count(Repaired, what, (used.vertices && unaligned).into(), &place);
        let what = "indices are in buffer views with a stride, which glTF does not allow; it was used as it is";
        notices.count(Repaired, what, (used.indices && stride.is_some()).into(), &place);
    }
    for (i, ((uses, attributes), view)) in views.iter_mut().zip(&root.buffer_views).enumerate() {
        let place = format!("bufferViews[{i}]");
        uses.image = images[i];
        let stride = view.byte_stride.map(|s| s.0).filter(|&s| s != 0);
        let what = "buffer views hold several vertex attributes but no stride; each was read as packed tightly";
        notices.count(Repaired, what, (*attributes > 1 && stride.is_none()).into(), &place);
        let what = "buffer views of images have a stride, which does nothing";
        notices.count(Repaired, what, (uses.image && stride.is_some()).into(), &place);
        let kinds = [uses.vertices, uses.indices, uses.image].into_iter().filter(|used| *used).count();
        let other = match view.target {
            Some(Checked::Valid(Target::ArrayBuffer)) => uses.indices || uses.image,
            Some(Checked::Valid(Target::ElementArrayBuffer)) => uses.vertices || uses.image,
            Some(Checked::Invalid) => true,
            None => false,
        };
        let what = "buffer views have another use than they say, or several; they were read for each";
        notices.count(Repaired, what, (kinds > 1 || other).into(), &place);
    }
}

/// Bytes of an element of vertex data, 4 for what is not a type.
fn size(accessor: &Accessor) -> usize {
    match (accessor.component_type, accessor.type_) {
        (Checked::Valid(component), Checked::Valid(shape)) => component.0.size() * shape.multiplicity(),
        _ => 4,
    }
}
