//! STL files built here, one per point of the format.

use crate::import::{ImportError, ImportOptions, Limits, load_bytes, load_bytes_with};
use crate::scene::Scene;

const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// A tetrahedron, outwards.
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn binary(header: &str, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut out = header.as_bytes().to_vec();
    out.resize(80, 0);
    out.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        out.extend([0; 12]);
        out.extend(triangle.iter().flatten().flat_map(|c| c.to_le_bytes()));
        out.extend([0, 0]);
    }
    out
}

fn tetrahedron(offset: f32) -> Vec<[[f32; 3]; 3]> {
    FACES.iter().map(|f| f.map(|v| CORNERS[v].map(|c| c + offset))).collect()
}

fn ascii(triangles: &[[[f32; 3]; 3]], name: &str) -> String {
    let mut out = format!("solid {name}\n");
    for t in triangles {
        out += "facet normal 0 0 0\nouter loop\n";
        t.iter().for_each(|[x, y, z]| out += &format!("vertex {x} {y} {z}\n"));
        out += "endloop\nendfacet\n";
    }
    out + &format!("endsolid {name}\n")
}

fn read(bytes: &[u8]) -> Scene {
    load_bytes(bytes, "model.stl", None).expect("a scene")
}

fn refused(bytes: &[u8], part: &str) {
    let error = load_bytes(bytes, "model.stl", None).expect_err(part).to_string();
    assert!(error.starts_with("model.stl: ") && error.contains(part), "{error}");
}

fn told(scene: &Scene, part: &str) -> bool {
    scene.notices.iter().any(|n| n.message.contains(part))
}

#[test]
fn both_forms_give_the_same_scene_and_solid_says_nothing() {
    let triangles = tetrahedron(0.0);
    let a = read(ascii(&triangles, "thing").as_bytes());
    let b = read(&binary("solid but binary facet", &triangles));
    assert_eq!(a.meshes, b.meshes);
    assert_eq!(a.triangle_count(), 4);
    // All edges are sharp: three corners at each of the four points.
    assert_eq!(a.meshes[0].primitives[0].positions.len(), 12);
    assert_eq!(a.parts[0].name, "model.stl");
    assert!(a.partition.starts_with("connected components"), "{}", a.partition);
}

#[test]
fn lengths_that_do_not_fit_are_repaired_or_refused() {
    let whole = binary("x", &tetrahedron(0.0));
    let mut longer = whole.clone();
    longer.extend([1, 2, 3]);
    assert!(told(&read(&longer), "3 bytes after the last triangle"));
    refused(&whole[..whole.len() - 1], "says 4 triangles, and there are bytes for 3");
    let mut huge = whole.clone();
    huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    refused(&huge, "says 4294967295 triangles");
    refused(&binary("x", &[]), "without triangles");
    refused(b"", "is empty");
    refused(b"solid Empty\nendsolid Empty", "without triangles");
    refused(&whole[..83], "without triangles");
}

#[test]
fn attribute_bytes_and_broken_triangles_are_told() {
    let mut triangles = tetrahedron(0.0);
    triangles.push([[f32::NAN, 0.0, 0.0], [1.0; 3], [2.0, 0.0, 0.0]]);
    triangles.push([[f32::INFINITY, 0.0, 0.0], [1.0; 3], [2.0, 0.0, 0.0]]);
    triangles.push([[1.0; 3]; 3]);
    let mut bytes = binary("COLOR=", &triangles);
    bytes[84 + 48] = 7;
    let scene = read(&bytes);
    assert_eq!(scene.triangle_count(), 4);
    for what in
        ["1 triangles have attribute bytes", "2 triangles with positions that are not finite", "1 triangles without"]
    {
        assert!(told(&scene, what), "{what}: {:?}", scene.notices);
    }
    refused(&binary("x", &[[[f32::NAN; 3]; 3]]), "without triangles");
}

#[test]
fn solids_are_parts_and_one_solid_is_divided() {
    let text = ascii(&tetrahedron(0.0), "left part") + &ascii(&tetrahedron(5.0), "");
    let scene = read(text.as_bytes());
    let names: Vec<&str> = scene.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["left part", "solid 2"]);
    assert!(scene.partition.contains("several solids"), "{}", scene.partition);
    let both: Vec<_> = tetrahedron(0.0).into_iter().chain(tetrahedron(5.0)).collect();
    let scene = read(&binary("x", &both));
    let names: Vec<&str> = scene.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["component 1", "component 2"]);
}

#[test]
fn ascii_is_taken_as_people_write_it() {
    let strange = "\u{feff}  SOLID a\r\nFacet Normal 0 0 1 Outer Loop Vertex 0 0 0 vertex 1e0 0 0\r\n\
                   vertex 0 +1.0 -0.0 EndLoop EndFacet\r\nendsolid";
    assert_eq!(read(strange.as_bytes()).triangle_count(), 1);
    let scene =
        read(b"solid\nfacet normal nan nan nan\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendfacet");
    assert_eq!(scene.triangle_count(), 2);
    assert!(told(&scene, "more than three") && told(&scene, "without 'endsolid'"), "{:?}", scene.notices);
    refused(b"solid\nfacet normal 0 0 1\nvertex 0 0\nendfacet", "line 3: a vertex has three coordinates");
    refused(b"solid\nfacet normal 0 0 1\nvertex 0 0 x\nendfacet", "line 3: 'x' is no number");
    refused(b"solid\nfacet normal 0 0 1\nvertex 0 0 0\n", "line 3: the file ends inside a facet");
    refused(b"solid\nvertex 0 0 0\nfacet", "line 2: a vertex outside a facet");
    refused(b"solid\nfacet\nfacet", "line 3: a facet begins inside another");
}

#[test]
fn far_coordinates_keep_their_shape() {
    let text = "solid\nfacet normal 0 0 1\nvertex 10000000.001 0 0\nvertex 10000001.001 0 0\nvertex 10000000.001 1 0\n\
                endfacet\nendsolid";
    let scene = read(text.as_bytes());
    let p = &scene.meshes[0].primitives[0].positions;
    assert!((f64::from(p[1][0] - p[0][0]) - 1.0).abs() < 1e-6, "{p:?}");
    let bounds = scene.bounds();
    assert!((bounds.min.x + scene.origin.x - 10_000_000.001).abs() < 1e-6);
}

#[test]
fn limits_and_calling_off_hold() {
    let bytes = binary("x", &tetrahedron(0.0));
    let text = ascii(&tetrahedron(0.0), "x");
    for bytes in [bytes.as_slice(), text.as_bytes()] {
        for limits in [Limits { triangles: 3, ..Limits::default() }, Limits { vertices: 3, ..Limits::default() }] {
            let options = ImportOptions { limits, ..ImportOptions::default() };
            let error = load_bytes_with(bytes, "x", None, &options).expect_err("a limit");
            assert!(matches!(error, ImportError::Limit { .. }), "{error}");
        }
        let options = ImportOptions::default();
        options.cancel.cancel();
        let error = load_bytes_with(bytes, "x", None, &options).expect_err("called off");
        assert!(matches!(error, ImportError::Cancelled { .. }), "{error}");
    }
}

#[test]
fn a_round_surface_of_loose_triangles_is_smooth() {
    // A cylinder of 64 facets: normals within the crease are the true ones, and ends are flat.
    let tau = std::f32::consts::TAU;
    let at = |i: usize, z: f32| [(tau * i as f32 / 64.0).cos(), (tau * i as f32 / 64.0).sin(), z];
    let mut triangles = Vec::new();
    for i in 0..64 {
        let (a, b, c, d) = (at(i, 0.0), at((i + 1) % 64, 0.0), at((i + 1) % 64, 1.0), at(i, 1.0));
        triangles.extend([[a, b, c], [a, c, d], [[0.0, 0.0, 1.0], d, c], [[0.0; 3], b, a]]);
    }
    let scene = read(&binary("x", &triangles));
    let p = &scene.meshes[0].primitives[0];
    assert_eq!(p.positions.len(), 4 * 64 + 2);
    for (position, normal) in p.positions.iter().zip(&p.normals) {
        let flat = normal[2].abs() > 0.999;
        let radial = (normal[0] - position[0]).abs() + (normal[1] - position[1]).abs() < 1e-3;
        assert!(flat || radial, "{position:?} {normal:?}");
    }
}
