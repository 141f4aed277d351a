//! What is written in each format reads back as the same scene, within what the format can hold.

use glam::{DVec3, Vec3};

use super::*;
use crate::import::{ImportOptions, PartsBy, load_bytes_with, load_with};
use crate::scene::{Scene, builtin};

fn options(parts: Option<PartsBy>) -> ImportOptions {
    ImportOptions { parts, ..ImportOptions::default() }
}

/// Every triangle as its corners in the file's space, rounded to `step`, from its smallest corner on, and sorted.
fn triangles(scene: &Scene, step: f64) -> Vec<[[i64; 3]; 3]> {
    let mut all = Vec::new();
    for part in &scene.parts {
        for p in placed(scene, part) {
            for triangle in p.triangles() {
                let mut corners = triangle.map(|v| (p.position(v) / step).round().to_array().map(|c| c as i64));
                let smallest = (0..3).min_by_key(|&i| corners[i]).unwrap();
                corners.rotate_left(smallest);
                all.push(corners);
            }
        }
    }
    all.sort_unstable();
    all
}

/// That two scenes have the same triangles, to `step` of the file's unit.
fn same_triangles(read: &Scene, written: &Scene, step: f64, what: &str) {
    assert_eq!(read.triangle_count(), written.triangle_count(), "{what}: {:?}", read.notices);
    // Coordinates that lie between two steps may be rounded either way, so corners are compared in order of the finer grid.
    let (a, b) = (triangles(read, step), triangles(written, step));
    let near = |a: &[[i64; 3]; 3], b: &[[i64; 3]; 3]| {
        a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() <= 1)
    };
    let missing = a.iter().filter(|t| {
        // Sorted by the first coordinate of the first corner, which differs by one step at most.
        let from = b.partition_point(|o| o[0][0] < t[0][0] - 1);
        !b[from..].iter().take_while(|o| o[0][0] <= t[0][0] + 1).any(|o| {
            (0..3).any(|turn| {
                let mut turned = *o;
                turned.rotate_left(turn);
                near(t, &turned)
            })
        })
    });
    assert_eq!(missing.count(), 0, "{what}: triangles that were not written");
}

/// The built-in scenes and what is asked of them.
fn scenes() -> Vec<Scene> {
    ["stack", "touching", "torus?segments=24"].iter().map(|name| builtin::build(name).unwrap()).collect()
}

fn names_and_counts(scene: &Scene) -> Vec<(String, u32)> {
    scene.parts.iter().map(|p| (p.name.clone(), p.triangle_count)).collect()
}

#[test]
fn obj_reads_back_with_parts_materials_and_normals() {
    let folder = tempfile::tempdir().unwrap();
    for scene in scenes() {
        let path = folder.path().join("model.obj");
        std::fs::write(&path, write_obj(&scene, "the model.mtl")).unwrap();
        std::fs::write(folder.path().join("the model.mtl"), write_mtl(&scene)).unwrap();
        let read = load_with(&path, &options(Some(PartsBy::Node))).unwrap();
        same_triangles(&read, &scene, 1e-5, &scene.name);
        if scene.parts.len() > 1 {
            assert_eq!(names_and_counts(&read), names_and_counts(&scene));
        }
        for (a, b) in read.parts.iter().zip(&scene.parts) {
            let (a, b) = (&read.meshes[a.mesh].primitives[0], &scene.meshes[b.mesh].primitives[0]);
            let (ma, mb) = (&read.materials[a.material], &scene.materials[b.material]);
            for (x, y) in ma.base_color.iter().zip(mb.base_color) {
                assert!((x - y).abs() < 1e-5, "{:?} {:?}", ma.base_color, mb.base_color);
            }
            assert_eq!((ma.metallic, ma.roughness, ma.alpha_mode), (mb.metallic, mb.roughness, mb.alpha_mode));
            let normals = a.triangles.as_flattened().iter().zip(b.triangles.as_flattened());
            for (&va, &vb) in normals.take(1000) {
                let (na, nb) = (Vec3::from(a.normals[va as usize]), Vec3::from(b.normals[vb as usize]));
                assert!(na.distance(nb) < 2e-2, "{}: {na} {nb}", scene.name);
            }
        }
    }
}

#[test]
fn stl_reads_back_in_both_forms() {
    for scene in scenes() {
        let ascii = load_bytes_with(&write_stl_ascii(&scene), "x", None, &options(None)).unwrap();
        same_triangles(&ascii, &scene, 1e-5, &scene.name);
        if scene.parts.len() > 1 {
            assert_eq!(names_and_counts(&ascii), names_and_counts(&scene), "solids are parts");
        }
        let bytes = write_stl_binary(&scene);
        assert_eq!(bytes.len() as u64, 84 + 50 * scene.triangle_count());
        let binary = load_bytes_with(&bytes, "x", None, &options(None)).unwrap();
        same_triangles(&binary, &scene, 1e-5, &scene.name);
        // Nothing is split that belongs together: the components are the parts that do not touch.
        let expected = if scene.name == "touching" { 1 } else { scene.parts.len() };
        assert!(binary.parts.len() >= expected, "{}: {}", scene.name, binary.partition);
    }
}

#[test]
fn ply_reads_back_in_all_encodings_with_colours() {
    for scene in scenes() {
        let mut first = None;
        for encoding in [PlyEncoding::Ascii, PlyEncoding::LittleEndian, PlyEncoding::BigEndian] {
            let read = load_bytes_with(&write_ply(&scene, encoding), "x", None, &options(None)).unwrap();
            same_triangles(&read, &scene, 1e-5, &scene.name);
            let whole =
                load_bytes_with(&write_ply(&scene, encoding), "x", None, &options(Some(PartsBy::File))).unwrap();
            let p = &whole.meshes[whole.parts[0].mesh].primitives[0];
            let colors: Vec<[f32; 4]> = scene
                .parts
                .iter()
                .flat_map(|part| &scene.meshes[part.mesh].primitives)
                .flat_map(|q| {
                    let material = scene.materials[q.material].base_color;
                    (0..q.positions.len()).map(move |v| {
                        let own = q.colors.get(v).copied().unwrap_or([1.0; 4]);
                        std::array::from_fn(|c| own[c] * material[c])
                    })
                })
                .collect();
            assert_eq!(p.colors.len(), colors.len());
            for (a, b) in p.colors.iter().zip(&colors) {
                assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.006), "{a:?} {b:?}");
            }
            // All encodings hold the same numbers.
            let text = format!("{:?}", read.meshes);
            assert_eq!(*first.get_or_insert(text.clone()), text);
        }
    }
}

#[test]
fn a_scene_far_away_keeps_its_shape() {
    let mut scene = builtin::build("stack").unwrap();
    let offset = DVec3::new(1e7, -2e7, 3e6);
    for node in scene.nodes.iter_mut().filter(|n| n.parent.is_none()) {
        node.parent_from_node = DMat4::from_translation(offset) * node.parent_from_node;
    }
    let scene = scene.finish().unwrap();
    let ascii = write_stl_ascii(&scene);
    let obj = write_obj(&scene, "none.mtl");
    let ply = write_ply(&scene, PlyEncoding::LittleEndian);
    for (what, bytes) in [("stl", ascii), ("obj", obj), ("ply", ply)] {
        let read = load_bytes_with(&bytes, "x", None, &options(None)).unwrap();
        same_triangles(&read, &scene, 1e-5, what);
        assert!((read.origin - offset).length() < 10.0, "{what}: {}", read.origin);
    }
}
