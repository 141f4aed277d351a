//! OBJ files built here, one per point of the format.

use std::path::Path;

use super::mtl::Map;
use crate::import::{ImportError, ImportOptions, Limits, PartsBy, load_bytes, load_bytes_with, load_with};
use crate::scene::{AlphaMode, Material, Scene, TextureRef};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn read(text: impl AsRef<[u8]>) -> Scene {
    load_bytes(text.as_ref(), "model.obj", None).expect("a scene")
}

fn refused(text: impl AsRef<[u8]>, part: &str) {
    let error = load_bytes(text.as_ref(), "model.obj", None).expect_err(part).to_string();
    assert!(error.starts_with("model.obj: ") && error.contains(part), "{error}");
}

fn told(scene: &Scene, part: &str) -> bool {
    scene.notices.iter().any(|n| n.message.contains(part))
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.parts.iter().map(|p| p.name.as_str()).collect()
}

/// A model with a material file and textures, read from a folder.
fn in_folder(obj: &str, files: &[(&str, &[u8])]) -> Scene {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).expect("written");
    }
    let path = folder.path().join("model.obj");
    std::fs::write(&path, obj).expect("written");
    load_with(&path, &ImportOptions::default()).expect("a scene")
}

fn png(width: u32, pixels: &[[u8; 4]]) -> Vec<u8> {
    let height = pixels.len() as u32 / width;
    let image = image::RgbaImage::from_raw(width, height, pixels.concat()).expect("an image");
    let mut out = std::io::Cursor::new(Vec::new());
    image.write_to(&mut out, image::ImageFormat::Png).expect("a PNG");
    out.into_inner()
}

fn material(mtl: &str) -> Material {
    let obj = format!("mtllib m.mtl\n{SQUARE}usemtl m\nf 1 2 3 4");
    in_folder(&obj, &[("m.mtl", format!("newmtl m\n{mtl}").as_bytes())]).materials[0].clone()
}

#[test]
fn polygons_negative_indices_and_all_corners() {
    let scene = read(format!("{SQUARE}vt 0.25 0.75\nvn 0 0 1\nf -4 -3 -2 -1\nf 1/1 2/1/ 3/1/1\nf 1//1 2//1 3//-1"));
    assert_eq!(scene.triangle_count(), 4);
    let all: Vec<_> = scene.meshes.iter().flat_map(|m| &m.primitives).collect();
    assert_eq!(all.len(), 1, "one primitive a material");
    // v goes down here.
    assert!(all[0].uvs[0].contains(&[0.25, 0.25]));
    assert_eq!(all[0].uvs[0].len(), all[0].positions.len());
    // A concave polygon is filled inside only.
    let scene = read("v 1 0 0\nv 0 1 0\nv 0.3 0 0\nv 0 -1 0\nf 1 2 3 4");
    let p = &scene.meshes[0].primitives[0];
    let at = |v: u32| glam::Vec3::from(p.positions[v as usize]);
    let area: f32 = p.triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)).length() / 2.0).sum();
    assert!((area - 0.7).abs() < 1e-6, "{area}");
}

#[test]
fn what_points_nowhere_is_refused_by_its_line() {
    refused("v 0 0 0\nf 1 2 3", "line 2: vertex 2 does not exist: 1 come before this line");
    refused(format!("{SQUARE}f 1 2 0"), "line 5: vertex 0: they are counted from 1");
    refused(format!("{SQUARE}f 1 2 -5"), "line 5: vertex -5 does not exist");
    refused(format!("{SQUARE}\\\n\nf 1/1 2 3"), "line 7: texture coordinate 1 does not exist: 0 come before");
    refused(format!("{SQUARE}f 1//9 2 3"), "line 5: normal 9");
    refused(format!("{SQUARE}f 1 2 x"), "line 5: 'x' is no corner of a face");
    refused(format!("{SQUARE}f 1///4 2 3"), "no corner of a face");
    refused(format!("{SQUARE}f 1 2 99999999999999999999"), "no corner of a face");
    refused("v 0 0 zero", "line 1: 'zero' is no number");
    refused("v 0 0", "line 1: a vertex with 2 of 3 coordinates");
    refused("v 0 0 0\nvn 1 0", "line 2: 2 of 3 numbers");
    refused("", "is empty");
    refused("# nothing", "without vertices or faces");
    refused(SQUARE, "with 4 vertices and no faces");
}

#[test]
fn odd_text_is_read() {
    // Latin-1, a continued line in the middle of a face, Mac's ends of lines, comments behind statements.
    let mut bytes = b"# caf\xE9 C:\\\no T\xFCr\r".to_vec();
    bytes.extend(SQUARE.replace('\n', "\r").bytes());
    bytes.extend(b"f 1 2 \\\r\n 3 4 # end\r\nf 1 2 3");
    let scene = read(&bytes);
    assert_eq!(scene.triangle_count(), 3);
    assert_eq!(scene.nodes[0].name, "Tür");
    let scene = read(format!("{SQUARE}p 1\nl 1 2\ncstype bezier\nmagic 1\nf 1 2\nf 1 2 3"));
    for what in
        ["2 statements of points or lines", "1 statements of free-form", "1 statements are none", "1 faces with fewer"]
    {
        assert!(told(&scene, what), "{what}: {:?}", scene.notices);
    }
}

#[test]
fn objects_and_groups_are_parts() {
    let text = format!(
        "{SQUARE}o body\nf 1 2 3\ng left arm\nf 1 2 4\ng right\nf 2 3 4\no wheel\ng round\nf 1 3 4\no body\nf 1 4 3\ng\nf 4 1 2"
    );
    let scene = read(text);
    assert_eq!(names(&scene), ["default", "left arm", "right", "wheel"]);
    assert_eq!(scene.nodes[scene.nodes[1].parent.expect("a parent")].name, "body");
    assert_eq!(scene.parts[0].triangle_count, 3, "what is named again goes on");
    assert!(scene.partition.contains("names objects or groups"), "{}", scene.partition);
    // Only one: the components of the file.
    let two = format!("g all\n{SQUARE}v 5 0 0\nv 6 0 0\nv 6 1 0\nf 1 2 3 4\nf 5 6 7");
    let scene = read(&two);
    assert_eq!(names(&scene), ["all component 1", "all component 2"]);
    let options = ImportOptions { parts: Some(PartsBy::Node), ..ImportOptions::default() };
    assert_eq!(names(&load_bytes_with(two.as_bytes(), "x", None, &options).expect("a scene")), ["all"]);
}

#[test]
fn colours_behind_vertices_are_linear() {
    let scene = read("v 0 0 0 1 0.5 0\nv 1 0 0 1 0.5 0\nv 0 1 0\nf 1 2 3\n");
    let colors = &scene.meshes[0].primitives[0].colors;
    assert!((colors[0][1] - 0.214).abs() < 1e-3 && colors[2] == [1.0; 4], "{colors:?}");
    assert!(told(&read("v 0 0 0 2 0 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 0\nf 1 2 3"), "1 vertex colours were outside"));
    assert!(told(&read("v 0 0 0 2\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3"), "1 vertices have a weight"));
}

#[test]
fn far_coordinates_keep_their_shape() {
    let scene = read("v 1e7 5e6 100.25\nv 10000000.001 5e6 100.25\nv 1e7 5000000.002 100.25\nf 1 2 3");
    let p = &scene.meshes[0].primitives[0].positions;
    assert!((p[1][0] - p[0][0] - 0.001).abs() < 1e-6 && (p[2][1] - p[0][1] - 0.002).abs() < 1e-6, "{p:?}");
    assert!((scene.origin.x - 1e7).abs() < 1.0);
}

#[test]
fn normals_are_the_files_or_go_by_smoothing_groups_or_creases() {
    // A roof of 90°: one group smooths it, two groups or none leave the ridge.
    let roof = "v 0 0 0\nv 0 1 0\nv 1 0 1\nv 1 1 1\nv 2 0 0\nv 2 1 0\n";
    let vertices = |faces: &str| read(format!("{roof}{faces}")).meshes[0].primitives[0].positions.len();
    assert_eq!(vertices("s 1\nf 1 3 4 2\nf 3 5 6 4"), 6);
    assert_eq!(vertices("s 1\nf 1 3 4 2\ns 2\nf 3 5 6 4"), 8);
    assert_eq!(vertices("s off\nf 1 3 4 2\nf 3 5 6 4"), 8);
    assert_eq!(vertices("f 1 3 4 2\nf 3 5 6 4"), 8);
    let scene = read(format!("{SQUARE}vn 0 0 2\nvn 0 0 0\nf 1//1 2//1 3//2"));
    let p = &scene.meshes[0].primitives[0];
    assert!(p.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]), "{:?}", p.normals);
    assert!(told(&scene, "1 normals were zero"));
}

#[test]
fn materials_are_converted_as_the_table_says() {
    let m = material("Kd 0.5 0 1\nNs 98\nKs 0.5 0.5 0.5\nd 0.25\nKe 0 2 0\nKa 1 1 1");
    assert!((m.base_color[0] - 0.214).abs() < 1e-3 && m.base_color[3] == 0.25, "{:?}", m.base_color);
    assert!((m.roughness - 0.02_f32.powf(0.25)).abs() < 1e-6 && m.metallic == 0.0);
    assert_eq!((m.emissive, m.alpha_mode, m.name.as_str()), ([0.0, 2.0, 0.0], AlphaMode::Blend, "m"));
    let m = material("Kd 0 0 0\nKs 1 0.5 0.2");
    assert_eq!((m.metallic, m.roughness, m.base_color[0]), (1.0, 0.5, 1.0));
    let m = material("Kd 1 1 1\nPm 0.75\nPr 0.25\nTr 0.5");
    assert_eq!((m.metallic, m.roughness, m.base_color[3]), (0.75, 0.25, 0.5));
    assert_eq!(material("d 0").alpha_mode, AlphaMode::Opaque);
    assert_eq!(material("d 1\nTr 1").alpha_mode, AlphaMode::Opaque, "d counts more");
    assert_eq!(material("Kd x\nNs inf\nd -halo 0.5").base_color[3], 0.5);
}

#[test]
fn a_missing_material_or_texture_costs_only_colour() {
    let obj = format!("mtllib none.mtl\n{SQUARE}usemtl m\nf 1 2 3 4");
    let scene = read(&obj);
    assert!(told(&scene, "mtllib") && told(&scene, "no material file defines 'm'"), "{:?}", scene.notices);
    assert_eq!(scene.materials[0].name, "m");
    let scene = in_folder(&obj, &[("none.mtl", b"newmtl m\nmap_Kd none.png\nmap_d ../x.png\nnorm /dev/zero")]);
    assert!(scene.images.is_empty() && scene.materials[0].base_color_texture.is_none());
    for what in ["none.png", "leads out of the model's folder", "/dev/zero"] {
        assert!(told(&scene, what), "{what}: {:?}", scene.notices);
    }
    let scene = in_folder(&obj, &[("none.mtl", b"newmtl m\nmap_Kd x.png"), ("x.png", b"no image")]);
    assert!(told(&scene, "x.png") && scene.images.is_empty(), "{:?}", scene.notices);
}

#[test]
fn textures_are_found_read_and_joined() {
    let obj = format!("mtllib a b.mtl\n{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3 4/4");
    let red = png(1, &[[255, 0, 0, 255]]);
    let mask = png(2, &[[0, 0, 0, 255], [255, 255, 255, 255]]);
    let mtl = b"newmtl m\nmap_Kd -s 2 3 1 -o 0.5 0.25 -clamp on C:\\old machine\\RED.PNG\nmap_d mask.png\n\
                map_Pr mask.png\nmap_Bump -bm 0.5 mask.png";
    let scene = in_folder(&obj, &[("a b.mtl", mtl), ("red.png", &red), ("mask.png", &mask)]);
    let m = &scene.materials[0];
    let image = |t: Option<TextureRef>| &scene.images[scene.textures[t.expect("a texture").texture].image];
    let color = image(m.base_color_texture);
    assert_eq!((color.width, color.rgba.as_slice()), (2, &[255, 0, 0, 0, 255, 0, 0, 255][..]));
    assert_eq!(m.alpha_mode, AlphaMode::Blend);
    assert_eq!(m.base_color_texture.expect("a texture").uv_transform, [[2.0, 0.0, 0.5], [0.0, 3.0, -2.25]]);
    assert_eq!(image(m.metallic_roughness_texture).rgba, [255, 0, 255, 255, 255, 255, 255, 255]);
    assert_eq!((m.roughness, m.normal_scale), (1.0, 0.5));
    assert_eq!(image(m.normal_texture).name, "normals of mask.png");
    assert!(told(&scene, "was found as \"red.png\"") && told(&scene, "heights became"), "{:?}", scene.notices);
    assert_eq!(scene.meshes[0].primitives[0].tangents.len(), 4);
    // Only what is used is kept.
    assert_eq!(scene.images.len(), 3);
}

#[test]
fn options_of_maps() {
    let parse = |text: &str| Map::parse(text.as_bytes());
    let map = parse("-blendu on -mm 0 1 -s 1 2 3 -imfchan m -bm 1.5 my file.png").expect("a map");
    assert_eq!((map.file.as_str(), map.scale, map.strength, map.channel), ("my file.png", [1.0, 2.0], 1.5, Some(b'm')));
    // A name that begins with a digit, or is a number.
    assert_eq!(parse("-s 2 3d.png").expect("a map").file, "3d.png");
    assert_eq!(parse("-o 1 2").expect("a map").file, "2");
    assert_eq!(parse("\"a b.png\"").expect("a map").file, "a b.png");
    for bad in ["", "-s 1 2", "-clamp", "-nosuch 1 x.png"] {
        assert!(parse(bad).is_none_or(|m| m.file == "2"), "{bad}");
    }
}

#[test]
fn limits_and_calling_off_hold() {
    let text = format!("{SQUARE}f 1 2 3 4\n");
    for limits in [Limits { triangles: 1, ..Limits::default() }, Limits { vertices: 3, ..Limits::default() }] {
        let options = ImportOptions { limits, ..ImportOptions::default() };
        let error = load_bytes_with(text.as_bytes(), "x", None, &options).expect_err("a limit");
        assert!(matches!(error, ImportError::Limit { .. }), "{error}");
    }
    let options = ImportOptions { limits: Limits { parts: 2, ..Limits::default() }, ..ImportOptions::default() };
    let many = format!("{SQUARE}g a\nf 1 2 3\ng b\nf 1 2 4\ng c\nf 1 3 4");
    let scene = load_bytes_with(many.as_bytes(), "x", None, &options).expect("a scene");
    assert_eq!(scene.parts.len(), 1);
    assert!(
        told(&scene, "3 objects and groups") && scene.partition.starts_with("the whole file"),
        "{}",
        scene.partition
    );
    let options = ImportOptions::default();
    options.cancel.cancel();
    let error = load_bytes_with(text.as_bytes(), "x", None, &options).expect_err("called off");
    assert!(matches!(error, ImportError::Cancelled { .. }), "{error}");
    let missing = load_with(Path::new("/nonexistent/model.obj"), &ImportOptions::default()).expect_err("no file");
    assert!(matches!(missing, ImportError::Io { .. }));
}
