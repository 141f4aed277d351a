//! PLY files built here, one per point of the format.

use crate::import::{ImportError, ImportOptions, Limits, load_bytes, load_bytes_with};
use crate::scene::Scene;

const HEADER: &str = "ply\nformat ascii 1.0\n";
const SQUARE: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const FACES: &str = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const CORNERS: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

fn read(bytes: impl AsRef<[u8]>) -> Scene {
    load_bytes(bytes.as_ref(), "model.ply", None).expect("a scene")
}

fn refused(bytes: impl AsRef<[u8]>, part: &str) {
    let error = load_bytes(bytes.as_ref(), "model.ply", None).expect_err(part).to_string();
    assert!(error.starts_with("model.ply: ") && error.contains(part), "{error}");
}

fn told(scene: &Scene, part: &str) -> bool {
    scene.notices.iter().any(|n| n.message.contains(part))
}

#[test]
fn every_type_in_every_encoding_says_the_same() {
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment c\nobj_info o\nelement camera 1\nproperty list int8 float64 matrix\n\
             property uint16 id\nelement vertex 4\nproperty double x\nproperty float32 y\nproperty short z\n\
             property uchar red\nproperty ushort green\nproperty float blue\nproperty int32 extra\n\
             property float s\nproperty float t\nelement face 2\nproperty list uint8 uint16 vertex_index\n\
             property list char double quality\nelement nothing 3\nend_header\n"
        )
    };
    let ascii = header("ascii")
        + "2 0.5 -1 7\n0 0 0 255 0 1 -9 0 0\n1 0 0 255 0 1 -9 1 0\n1 1 0 255 0 1 -9 1 1\n0 1 0 255 65535 1 -9 0 1\n\
           4 0 1 2 3 1 0.5\n3 0 1 2 0\n";
    let mut files = vec![ascii.into_bytes()];
    for big in [false, true] {
        let mut bytes = header(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
        let mut put = |value: &[u8]| {
            let mut value = value.to_vec();
            if big {
                value.reverse();
            }
            bytes.extend(value);
        };
        put(&2_i8.to_le_bytes());
        [0.5_f64, -1.0].iter().for_each(|v| put(&v.to_le_bytes()));
        put(&7_u16.to_le_bytes());
        for (x, y, green) in [(0.0_f64, 0.0_f32, 0_u16), (1.0, 0.0, 0), (1.0, 1.0, 0), (0.0, 1.0, 65535)] {
            put(&x.to_le_bytes());
            put(&y.to_le_bytes());
            put(&0_i16.to_le_bytes());
            put(&[255]);
            put(&green.to_le_bytes());
            put(&1_f32.to_le_bytes());
            put(&(-9_i32).to_le_bytes());
            put(&(x as f32).to_le_bytes());
            put(&y.to_le_bytes());
        }
        put(&[4]);
        [0_u16, 1, 2, 3].iter().for_each(|v| put(&v.to_le_bytes()));
        put(&[1]);
        put(&0.5_f64.to_le_bytes());
        put(&[3]);
        [0_u16, 1, 2].iter().for_each(|v| put(&v.to_le_bytes()));
        put(&[0]);
        files.push(bytes);
    }
    let scenes: Vec<Scene> = files.iter().map(read).collect();
    assert!(scenes.iter().all(|s| s.meshes == scenes[0].meshes && s.notices == scenes[0].notices));
    let p = &scenes[0].meshes[0].primitives[0];
    assert_eq!(p.triangles.len(), 3);
    assert_eq!(p.colors[0], [1.0, 0.0, 1.0, 1.0]);
    assert_eq!(p.colors[3], [1.0; 4]);
    assert_eq!(p.uvs[0], [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    for what in ["elements 'camera' are not shown", "'vertex' are not shown: extra", "'face' are not shown: quality"] {
        assert!(told(&scenes[0], what), "{what}: {:?}", scenes[0].notices);
    }
    assert!(scenes[0].partition.starts_with("connected components"));
}

#[test]
fn normals_strips_and_colours_of_faces() {
    let normals = "property float nx\nproperty float ny\nproperty float nz\n";
    let corners = "0 0 0 0 0 2\n1 0 0 0 0 1\n1 1 0 0 1 0\n0 1 0 0 0 1\n";
    let scene = read(format!("{HEADER}{SQUARE}{normals}{FACES}{corners}4 0 1 2 3"));
    let p = &scene.meshes[0].primitives[0];
    assert_eq!((p.normals[0], p.normals[2]), ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]));
    let strips = "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let scene = read(format!("{HEADER}{SQUARE}{strips}{CORNERS}8 0 1 3 2 -1 0 1 3"));
    assert_eq!(scene.meshes[0].primitives[0].triangles, [[0, 1, 3], [1, 2, 3], [0, 1, 3]]);
    let faces = "element face 2\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n\
                 property uchar blue\nend_header\n";
    let scene = read(format!("{HEADER}{SQUARE}{faces}{CORNERS}3 0 1 2 255 0 0\n3 0 2 3 0 0 255"));
    let p = &scene.meshes[0].primitives[0];
    assert_eq!(p.positions.len(), 6);
    for (t, color) in [(0, [1.0, 0.0, 0.0, 1.0]), (1, [0.0, 0.0, 1.0, 1.0])] {
        assert!(p.triangles[t].iter().all(|&v| p.colors[v as usize] == color));
    }
    // Both: the ones that are not all the same.
    let channels = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let with = |first: &str| {
        let corners: Vec<String> = CORNERS.lines().map(|c| format!("{c} 255 255 255")).collect();
        let corners = corners.join("\n").replacen("255 255 255", first, 1);
        let scene = read(format!("{HEADER}{SQUARE}{channels}{faces}{corners}\n3 0 1 2 255 0 0\n3 0 2 3 0 0 255"));
        scene.meshes[0].primitives[0].colors[0]
    };
    assert_eq!((with("255 255 255"), with("0 255 0")), ([1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]));
}

#[test]
fn headers_that_make_no_sense_are_refused() {
    refused("plx", "begins with");
    refused("ply\nformat ascii 1.0\n", "before \"end_header\"");
    refused("ply\nend_header\n", "line 2: no format");
    refused("ply\nformat pdp_endian 1.0\nend_header\n", "line 2: a format that PLY does not have");
    refused("ply\nformat ascii 1.0\nproperty float x\nend_header\n", "line 3: a property before any element");
    refused("ply\nformat ascii 1.0\nelement vertex many\nend_header\n", "line 3: the count");
    refused("ply\nformat ascii 1.0\nelement vertex 1\nproperty complex x\nend_header\n", "line 4: a property");
    refused("ply\nformat ascii 1.0\nhello\nend_header\n", "line 3: a word");
    refused(format!("{HEADER}element vertex 1\nproperty float x\nend_header\n0\n"), "has no x, y and z");
    refused(format!("{HEADER}{SQUARE}element face 1\nproperty int a\nend_header\n{CORNERS}1"), "vertex_indices");
    refused(format!("{HEADER}{SQUARE}end_header\n{CORNERS}"), "4 points and no faces");
    refused(format!("{HEADER}end_header\n"), "without vertices or faces");
    refused("", "is empty");
}

#[test]
fn bodies_that_contradict_the_header_are_refused() {
    let body = |body: &str| format!("{HEADER}{SQUARE}{FACES}{body}");
    refused(body("0 0 0\n1 0"), "element vertex: the header says 4, and there are 9 bytes left");
    refused(body(&format!("{CORNERS}4 0 1 2 ")), "face 0: the file ends");
    refused(body(&format!("{CORNERS}4 0 1 2 4")), "face 0: names vertex 4, and there are 4");
    refused(body(&format!("{CORNERS}3 0 1 -1")), "names vertex -1");
    refused(body(&format!("{CORNERS}3 0 1 1.5")), "no whole number");
    refused(body(&format!("{CORNERS}-3 0 1 2")), "face 0: -3 is no length");
    refused(body(&format!("{CORNERS}4000000000 0 1 2")), "a list of 4000000000, and there are");
    refused(body("0 0 0 1 x 0 1 1 0 0 1 0 3 0 1 2"), "vertex 1: 'x' is no number");
    let huge = format!("{HEADER}{}{FACES}", SQUARE.replace("vertex 4", "vertex 18446744073709551615"));
    refused(huge, "the header says 18446744073709551615");
    let binary = format!("ply\nformat binary_little_endian 1.0\n{SQUARE}{FACES}");
    let mut bytes = binary.into_bytes();
    bytes.extend([0; 48]);
    bytes.push(200);
    refused(&bytes, "a list of 200, and there are 0 bytes");
    let mut longer = body(&format!("{CORNERS}3 0 1 2\n")).into_bytes();
    longer.extend(b"more\n");
    assert!(told(&read(&longer), "4 bytes after the last element"));
}

#[test]
fn ends_of_lines_of_all_kinds() {
    for end in ["\n", "\r\n", "\r"] {
        let text = format!("{HEADER}{SQUARE}{FACES}{CORNERS}4 0 1 2 3").replace('\n', end);
        assert_eq!(read(&text).triangle_count(), 2, "{end:?}");
    }
    // Binary data that begins with what ends a line.
    let header =
        format!("ply\rformat binary_big_endian 1.0\r{}{}", SQUARE.replace('\n', "\r"), FACES.replace('\n', "\r"));
    let mut bytes = header.into_bytes();
    let first = f32::from_be_bytes([b'\n', 0, 0, 0]);
    for v in [[first, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
        bytes.extend(v.iter().flat_map(|c| c.to_be_bytes()));
    }
    bytes.push(3);
    bytes.extend([0_i32, 1, 2].iter().flat_map(|c| c.to_be_bytes()));
    assert_eq!(read(&bytes).triangle_count(), 1);
}

#[test]
fn bad_numbers_are_mended() {
    let scene = read(format!("{HEADER}{SQUARE}{FACES}nan 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3"));
    assert!(told(&scene, "not finite were dropped"), "{:?}", scene.notices);
    let scene = read(format!("{HEADER}{SQUARE}{FACES}0 0 0\n0 0 0\n0 0 0\n0 0 0\n4 0 1 2 3"));
    assert!(scene.parts.is_empty() && told(&scene, "no triangles"), "{:?}", scene.notices);
    let far = SQUARE.replace("float", "double");
    let scene =
        read(format!("{HEADER}{far}{FACES}1e7 0 0\n10000000.001 0 0\n10000000.001 0.001 0\n1e7 0.001 0\n4 0 1 2 3"));
    let p = &scene.meshes[0].primitives[0].positions;
    assert!((p[1][0] - p[0][0] - 0.001).abs() < 1e-7, "{p:?}");
}

#[test]
fn limits_and_calling_off_hold() {
    let text = format!("{HEADER}{SQUARE}{FACES}{CORNERS}4 0 1 2 3");
    for limits in [
        Limits { triangles: 1, ..Limits::default() },
        Limits { triangles: 0, ..Limits::default() },
        Limits { vertices: 3, ..Limits::default() },
    ] {
        let options = ImportOptions { limits, ..ImportOptions::default() };
        let error = load_bytes_with(text.as_bytes(), "x", None, &options).expect_err("a limit");
        assert!(matches!(error, ImportError::Limit { .. }), "{error}");
    }
    let options = ImportOptions::default();
    options.cancel.cancel();
    let error = load_bytes_with(text.as_bytes(), "x", None, &options).expect_err("called off");
    assert!(matches!(error, ImportError::Cancelled { .. }), "{error}");
}
