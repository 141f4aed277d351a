//! Columns to a primitive.

use std::collections::HashMap;

use glam::DVec3;
use rustc_hash::FxBuildHasher;

use super::elements::Raw;
use crate::import::polygon::Polygons;
use crate::import::triangles::{clean, compact, given_normals, linear_color, origin_of, relative};
use crate::import::{Fallible, Fault, ImportOptions, Notices};
use crate::scene::{NoticeKind, Primitive};

/// The file's mesh, and where its coordinates begin.
pub(super) fn build(mut raw: Raw, options: &ImportOptions, notices: &mut Notices) -> Fallible<(Primitive, DVec3)> {
    let origin = origin_of(&raw.positions);
    let mut triangles = triangles(&raw, options, notices)?;
    options.cancel.go_on()?;
    if !raw.colors.is_empty() && !raw.face_colors.is_empty() {
        // Some programs always write both, and white where there is nothing to say.
        let plain = raw.colors.iter().all(|c| *c == raw.colors[0]);
        let (left_out, shown) = if plain { ("vertices", "faces") } else { ("faces", "vertices") };
        if plain {
            raw.colors.clear();
        } else {
            raw.face_colors.clear();
        }
        notices.ignored(format!("colours of {left_out} are not shown, because those of {shown} say more"));
    }
    let face_colors = raw.face_colors.len() == raw.ends.len() && !raw.face_colors.is_empty();
    if face_colors {
        color_faces(&mut raw, &mut triangles);
    }
    let mut triangles: Vec<[u32; 3]> = triangles.into_iter().map(|(t, _)| t).collect();
    let positions: Vec<[f32; 3]> = raw.positions.iter().map(|&p| relative(p, origin)).collect();
    clean(&mut triangles, &positions, "file", notices);
    let kept = compact(&mut triangles, positions.len() as u64);
    let mut bad_uvs = 0;
    let mut bad_colors = 0;
    let mut p = Primitive {
        positions: kept.iter().map(|&v| positions[v as usize]).collect(),
        triangles,
        ..Primitive::default()
    };
    if !raw.uvs.is_empty() {
        let uv = |&v: &u32| {
            let [u, v] = raw.uvs[v as usize];
            let finite = u.is_finite() && v.is_finite();
            bad_uvs += u64::from(!finite);
            if finite { [u, 1.0 - v] } else { [0.0; 2] }
        };
        p.uvs[0] = kept.iter().map(uv).collect();
    }
    if !raw.colors.is_empty() {
        let color = |&v: &u32| {
            let color = raw.colors[v as usize];
            bad_colors += u64::from(!color.iter().all(|c| (0.0..=1.0).contains(c)));
            linear_color(color.map(|c| if c.is_nan() { 1.0 } else { c }))
        };
        p.colors = kept.iter().map(color).collect();
    }
    notices.count(NoticeKind::Repaired, "texture coordinates were not finite and became 0", bad_uvs, "file");
    notices.count(NoticeKind::Repaired, "vertex colours were outside 0 to 1 and were clamped", bad_colors, "file");
    if p.triangles.is_empty() {
        return Ok((p, origin));
    }
    let stored = (!raw.normals.is_empty()).then(|| kept.iter().map(|&v| raw.normals[v as usize]).collect());
    given_normals(&mut p, stored, options, "file", notices);
    Ok((p, origin))
}

/// All triangles, each with the polygon that it belongs to (those of strips belong to none).
fn triangles(raw: &Raw, options: &ImportOptions, notices: &mut Notices) -> Fallible<Vec<([u32; 3], usize)>> {
    let count = raw.positions.len() as i64;
    let check = |what: &str, n: usize, corner: i64| -> Fallible<u32> {
        if (0..count).contains(&corner) {
            // Checked: less than the number of vertices, which is in u32.
            return Ok(corner as u32);
        }
        let said = if corner == i64::MIN { "a vertex that is no whole number".to_owned() } else { corner.to_string() };
        Err(Fault::invalid(format!("{what} {n}"), format!("names vertex {said}, and there are {count}")))
    };
    let mut all: Vec<([u32; 3], usize)> = Vec::new();
    let mut polygons = Polygons::default();
    let mut small = 0_u64;
    let mut start = 0;
    let mut face: Vec<u32> = Vec::new();
    let room = |all: &Vec<_>, what: &str, n: usize| {
        let (needed, allowed) = (all.len() as u64, options.limits.most_triangles());
        if needed > allowed { Err(Fault::limit(format!("{what} {n}"), "triangles", needed, allowed)) } else { Ok(()) }
    };
    for (n, &end) in raw.ends.iter().enumerate() {
        face.clear();
        for &corner in &raw.corners[start..end] {
            face.push(check("face", n, corner)?);
        }
        start = end;
        small += u64::from(face.len() < 3);
        let position = |i: usize| DVec3::from(raw.positions[face[i] as usize]);
        polygons.triangulate(face.len(), position, |t| all.push((t.map(|i| face[i]), n)));
        room(&all, "face", n)?;
    }
    let mut start = 0;
    for (n, &end) in raw.strip_ends.iter().enumerate() {
        for strip in raw.strips[start..end].split(|&corner| corner == -1) {
            let strip = strip.iter().map(|&c| check("tristrips", n, c)).collect::<Fallible<Vec<u32>>>()?;
            let wound = strip.windows(3).enumerate().map(|(i, w)| match i % 2 {
                0 => [w[0], w[1], w[2]],
                _ => [w[0], w[2], w[1]],
            });
            // A vertex twice only joins two pieces.
            let proper = wound.filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
            all.extend(proper.map(|t| (t, usize::MAX)));
            room(&all, "tristrips", n)?;
        }
        start = end;
    }
    notices.count(NoticeKind::Repaired, "faces with fewer than three corners were dropped", small, "file");
    let what = "faces have so many corners that they may be filled wrongly";
    notices.count(NoticeKind::Approximated, what, polygons.unfinished, "file");
    Ok(all)
}

/// Gives vertices the colours of their faces; a vertex between faces of several colours becomes several.
fn color_faces(raw: &mut Raw, triangles: &mut [([u32; 3], usize)]) {
    let mut made: HashMap<(u32, [u32; 4]), u32, FxBuildHasher> = HashMap::default();
    let mut used = vec![false; raw.positions.len()];
    raw.colors = vec![[1.0; 4]; raw.positions.len()];
    for (triangle, face) in triangles {
        // Strips have no colours.
        let color = raw.face_colors.get(*face).copied().unwrap_or([1.0; 4]);
        for v in triangle {
            let old = *v as usize;
            *v = *made.entry((*v, color.map(f32::to_bits))).or_insert_with(|| {
                if !std::mem::replace(&mut used[old], true) {
                    raw.colors[old] = color;
                    return old as u32;
                }
                raw.positions.push(raw.positions[old]);
                if let Some(&normal) = raw.normals.get(old) {
                    raw.normals.push(normal);
                }
                if let Some(&uv) = raw.uvs.get(old) {
                    raw.uvs.push(uv);
                }
                raw.colors.push(color);
                raw.positions.len() as u32 - 1
            });
        }
    }
}
