//! STL, both forms.

use std::fmt::Write;

use glam::DVec3;

use super::placed;
use crate::scene::{Part, Scene};

/// Writes `scene` as a binary STL. Parts are not told apart, and positions are `f32` in the file's coordinates.
pub fn write_stl_binary(scene: &Scene) -> Vec<u8> {
    let mut out = b"binary STL by pellucid".to_vec();
    out.resize(80, 0);
    let count: u64 = scene.triangle_count();
    // A scene numbers its triangles in 32 bits.
    out.extend((count as u32).to_le_bytes());
    out.reserve(50 * count as usize);
    for part in &scene.parts {
        each_triangle(scene, part, |corners, normal| {
            for v in std::iter::once(&normal).chain(&corners) {
                out.extend(v.as_vec3().to_array().iter().flat_map(|c| c.to_le_bytes()));
            }
            out.extend([0, 0]);
        });
    }
    out
}

/// Writes `scene` as an ASCII STL with a solid for each part.
pub fn write_stl_ascii(scene: &Scene) -> Vec<u8> {
    let mut out = String::new();
    for part in &scene.parts {
        let name = part.name.replace(|c: char| c.is_control(), " ");
        // Writing to a string cannot fail.
        let _ = writeln!(out, "solid {}", name.trim());
        each_triangle(scene, part, |corners, n| {
            let n = n.as_vec3();
            let _ = writeln!(out, "facet normal {} {} {}\n outer loop", n.x, n.y, n.z);
            for p in corners {
                let _ = writeln!(out, "  vertex {} {} {}", p.x, p.y, p.z);
            }
            let _ = writeln!(out, " endloop\nendfacet");
        });
        let _ = writeln!(out, "endsolid {}", name.trim());
    }
    out.into_bytes()
}

fn each_triangle(scene: &Scene, part: &Part, mut each: impl FnMut([DVec3; 3], DVec3)) {
    for p in placed(scene, part) {
        for triangle in p.triangles() {
            let [a, b, c] = triangle.map(|v| p.position(v));
            each([a, b, c], (b - a).cross(c - a).normalize_or_zero());
        }
    }
}
