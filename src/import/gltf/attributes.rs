//! The attributes and indices of a primitive: which accessors they are, whether their types fit, and reading them.

use gltf_json::accessor::{ComponentType, Type};
use gltf_json::mesh::{Mode, Primitive as Source, Semantic};
use gltf_json::validation::Checked;
use rayon::prelude::*;

use super::accessor::{Accessor, Data};
use super::{Fallible, Fault, Notices};
use crate::scene::NoticeKind;

/// The accessors of a primitive that are read. All have as many elements as `positions`.
pub(super) struct Attributes<'a> {
    pub(super) positions: &'a Accessor<'a>,
    pub(super) normals: Option<&'a Accessor<'a>>,
    pub(super) tangents: Option<&'a Accessor<'a>>,
    pub(super) uvs: [Option<&'a Accessor<'a>>; 2],
    pub(super) colors: Option<&'a Accessor<'a>>,
}

/// Finds and checks the attributes. `None` if there are no positions.
pub(super) fn find<'a>(
    source: &Source,
    data: &'a Data<'a>,
    place: &str,
    quantized: bool,
    notices: &mut Notices,
) -> Fallible<Option<Attributes<'a>>> {
    let mut find = |semantic: Semantic, shapes: &[Type]| -> Fallible<Option<&'a Accessor<'a>>> {
        let place = format!("{place}.attributes.{}", semantic.to_string());
        let Some(&index) = source.attributes.get(&Checked::Valid(semantic.clone())) else { return Ok(None) };
        let accessor = data.accessor(index, &place)?;
        if !shapes.contains(&accessor.shape) || accessor.component == ComponentType::U32 {
            return Err(Fault::invalid(place, format!("cannot be {}", accessor.describe())));
        }
        use ComponentType::{F32, U8, U16};
        let core = match semantic {
            _ if accessor.component == F32 => true,
            Semantic::TexCoords(_) => accessor.normalized && matches!(accessor.component, U8 | U16),
            // Colours are always fractions; what is not said to be one is told where they are read.
            Semantic::Colors(_) => matches!(accessor.component, U8 | U16),
            _ => false,
        };
        if !core && !quantized {
            let what = "attributes have integer types that need KHR_mesh_quantization, which the file does not name; they \
                        were read as they are";
            notices.count(NoticeKind::Repaired, what, 1, &place);
        }
        Ok(Some(accessor))
    };
    let positions = find(Semantic::Positions, &[Type::Vec3])?;
    let found = Attributes {
        positions: match positions {
            Some(positions) => positions,
            None => return Ok(None),
        },
        normals: find(Semantic::Normals, &[Type::Vec3])?,
        tangents: find(Semantic::Tangents, &[Type::Vec4])?,
        uvs: [find(Semantic::TexCoords(0), &[Type::Vec2])?, find(Semantic::TexCoords(1), &[Type::Vec2])?],
        colors: find(Semantic::Colors(0), &[Type::Vec3, Type::Vec4])?,
    };
    let count = found.positions.count;
    for (semantic, &index) in &source.attributes {
        let place = format!("{place}.attributes.{}", semantic.to_string());
        let accessor = data.accessor(index, &place)?;
        if accessor.count != count {
            return Err(Fault::invalid(place, format!("has {} elements, POSITION has {count}", accessor.count)));
        }
        match semantic {
            Checked::Valid(Semantic::Colors(set @ 1..)) => {
                notices.ignored(format!("COLOR_{set}: only the first set of vertex colours is shown"));
            }
            Checked::Invalid => {
                notices.count(NoticeKind::Ignored, "primitives have attributes that glTF does not know", 1, &place);
            }
            Checked::Valid(_) => {}
        }
    }
    Ok(Some(found))
}

/// The accessor of the indices, checked for its type.
pub(super) fn indices<'a>(source: &Source, data: &'a Data<'a>, place: &str) -> Fallible<Option<&'a Accessor<'a>>> {
    let place = format!("{place}.indices");
    let Some(index) = source.indices else { return Ok(None) };
    let accessor = data.accessor(index, &place)?;
    use ComponentType::{U8, U16, U32};
    if accessor.shape != Type::Scalar || !matches!(accessor.component, U8 | U16 | U32) || accessor.normalized {
        return Err(Fault::invalid(place, format!("cannot be {}", accessor.describe())));
    }
    Ok(Some(accessor))
}

/// The corners of a primitive in file order: its indices, or every vertex once.
pub(super) fn corners(
    indices: Option<&Accessor>,
    vertices: u64,
    place: &str,
    notices: &mut Notices,
) -> Fallible<Vec<u32>> {
    // Checked when the accessors were: at most `Limits::vertices`.
    let count = |n: u64| u32::try_from(n).map_err(|_| Fault::limit(place, "vertices", n, u32::MAX.into()));
    let Some(indices) = indices else {
        return Ok((0..count(vertices)?).into_par_iter().collect());
    };
    let corners: Vec<u32> = (0..count(indices.count)?).into_par_iter().map(|i| indices.index(i)).collect();
    if let Some(i) = corners.par_iter().position_first(|&index| u64::from(index) >= vertices) {
        let cause = format!("number {i} is {}, the primitive has {vertices} vertices ({})", corners[i], indices.place);
        return Err(Fault::invalid(format!("{place}.indices"), cause));
    }
    // The largest value of its type starts strips anew on GPUs, so that glTF forbids it.
    let restart = u32::MAX >> (32 - 8 * indices.component.size().clamp(1, 4) as u32);
    let restarts = corners.par_iter().filter(|&&index| index == restart).count() as u64;
    let what = "indices have the largest value of their type, which glTF does not allow; they were read as vertices";
    notices.count(NoticeKind::Repaired, what, restarts, place);
    Ok(corners)
}

/// Triangles from corners, in order, all wound as the first (glTF 2.0, 3.7.2.1), and how many corners are left over.
/// In strips and fans triangles that use a vertex twice only join pieces; they are left out.
pub(super) fn triangles(corners: &[u32], mode: Mode) -> (Vec<[u32; 3]>, usize) {
    let proper = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    match mode {
        Mode::TriangleStrip => {
            let triangles = corners
                .windows(3)
                .enumerate()
                .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] });
            (triangles.filter(proper).collect(), if corners.len() < 3 { corners.len() } else { 0 })
        }
        Mode::TriangleFan => {
            let rest = corners.get(1..).unwrap_or_default();
            let triangles = rest.windows(2).map(|w| [w[0], w[1], corners[0]]);
            (triangles.filter(proper).collect(), if corners.len() < 3 { corners.len() } else { 0 })
        }
        Mode::Triangles => {
            let whole = corners.par_chunks_exact(3);
            (whole.map(|c| [c[0], c[1], c[2]]).collect(), corners.len() % 3)
        }
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => (Vec::new(), 0),
    }
}
