//! Containers, JSON, buffers, URIs and images.

use serde_json::json;

use super::*;
use crate::import::{ImportOptions, Limits, load, load_bytes_with};

fn text(json: &Value) -> Result<Scene, String> {
    load_bytes(json.to_string().as_bytes(), "test", None).map_err(|e| e.to_string())
}

#[track_caller]
fn bad_bytes(bytes: &[u8], part: &str) {
    let error = load_bytes(bytes, "test.glb", None).expect_err("is refused").to_string();
    assert!(error.contains(part), "{error}");
}

#[test]
fn broken_containers_are_refused() {
    let good = Builder::quad().bytes();
    assert!(load_bytes(&good, "test", None).is_ok());
    bad_bytes(b"", "empty");
    bad_bytes(b"\0\0\0\0\0\0\0\0", "neither a GLB");
    bad_bytes(b"{]", "JSON");
    bad_bytes(b"[1]", "neither");
    bad_bytes(b"glTF\x02\0\0\0", "header");
    bad_bytes(b"glTF\x01\0\0\0\x0c\0\0\0", "version 1");
    bad_bytes(b"glTF\x02\0\0\0\x0c\0\0\0", "no JSON chunk");
    bad_bytes(&good[..good.len() - 1], "the file has");
    let mut long = good.clone();
    long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    bad_bytes(&long, "chunk 0");
    let mut order = good.clone();
    order[16..20].copy_from_slice(b"BIN\0");
    bad_bytes(&order, "must be JSON");
}

#[test]
fn versions() {
    assert!(text(&json!({"asset": {"version": "1.0"}})).unwrap_err().contains("glTF 1.0"));
    assert!(text(&json!({"asset": {"version": "2.1", "minVersion": "2.1"}})).unwrap_err().contains("minVersion"));
    assert!(text(&json!({"asset": {"version": "two"}})).unwrap_err().contains("asset.version"));
    assert!(text(&json!({})).unwrap_err().contains("asset"));
    assert_tells(&text(&json!({"asset": {"version": "2.1"}})).unwrap(), NoticeKind::Approximated, "2.1");
    let empty = text(&json!({"asset": {"version": "2.0"}})).unwrap();
    assert_tells(&empty, NoticeKind::Ignored, "no triangles");
    assert!(empty.parts.is_empty());
}

#[test]
fn bad_json_names_its_place() {
    for (json, part) in [
        (json!({"asset": {"version": "2.0"}, "accessors": [{}]}), "accessors[0]"),
        (json!({"asset": {"version": "2.0"}, "nodes": [{}, {"mesh": -1}]}), "nodes[1].mesh"),
        (json!({"asset": {"version": "2.0"}, "nodes": [{"mesh": 4_294_967_296_u64}]}), "nodes[0].mesh"),
        (json!({"asset": {"version": "2.0"}, "nodes": 3}), "nodes"),
        (json!({"asset": {"version": "2.0"}, "scene": 1}), "scene"),
        (json!({"asset": {"version": "2.0"}, "extensionsUsed": [3]}), "extensionsUsed"),
    ] {
        let error = text(&json).unwrap_err();
        assert!(error.starts_with(&format!("test: {part}")), "{error}");
    }
}

#[test]
fn extras_and_foreign_extensions_may_hold_anything() {
    let nonsense = json!({"index": 0.5, "bufferView": "x", "children": [-1], "extensions": 3});
    let file = Builder::quad()
        .set("/extras", nonsense.clone())
        .set("/extensions", json!({"VENDOR_x": nonsense}))
        .set("/nodes/0/extras", nonsense.clone())
        .set("/nodes/0/extensions", json!({"VENDOR_y": nonsense}));
    let scene = file.scene();
    assert_eq!(scene.triangle_count(), 2);
    assert_tells(&scene, NoticeKind::Ignored, "VENDOR_x");
    assert_tells(&scene, NoticeKind::Ignored, "VENDOR_y: the extension is not known (first at nodes[0].extensions");
}

#[test]
fn data_uris_and_padding() {
    let quad = Builder::quad();
    let mut json = quad.json.clone();
    let encoded = base64(&quad.binary);
    for uri in [
        format!("data:application/octet-stream;base64,{encoded}"),
        format!("data:;base64,{}", encoded.trim_end_matches('=')),
        format!("DATA:application/gltf-buffer;base64,{}", encoded.replace('+', "%2B")),
    ] {
        json["buffers"] = json!([{"byteLength": quad.binary.len(), "uri": uri}]);
        assert_eq!(text(&json).unwrap().triangle_count(), 2);
    }
    json["buffers"][0]["uri"] = "data:;base64,@@@".into();
    assert!(text(&json).unwrap_err().contains("buffers[0].uri: base64"));
    json["buffers"][0]["uri"] = "data:nothing".into();
    assert!(text(&json).unwrap_err().contains("comma"));
}

#[test]
fn buffer_lengths() {
    let short = Builder::quad().set("/buffers", json!([{"byteLength": 1000}]));
    short.refused("buffers[0].byteLength: is 1000");
    let none = Builder::quad().set("/buffers", json!([{"byteLength": 60}, {"byteLength": 1}]));
    none.refused("buffers[1]: has no uri");
    let huge = Builder::quad().set("/buffers", json!([{"byteLength": u64::MAX}]));
    huge.refused("limit");
    let mut long = Builder::quad();
    long.json["buffers"] = json!([{"byteLength": 60}]);
    long.binary.extend([0; 16]);
    assert_tells(&long.scene(), NoticeKind::Repaired, "16 bytes longer");
}

#[test]
fn files_beside_the_model_and_nowhere_else() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("model");
    std::fs::create_dir_all(inside.join("a b")).unwrap();
    let quad = Builder::quad();
    for path in ["model/a b/data%.bin", "secret.bin"] {
        std::fs::write(folder.path().join(path), &quad.binary).unwrap();
    }
    let mut json = quad.json.clone();
    let model = inside.join("m.GLTF");
    let mut with = |uri: &str| {
        json["buffers"] = json!([{"byteLength": quad.binary.len(), "uri": uri}]);
        std::fs::write(&model, json.to_string()).unwrap();
        load(&model).map_err(|e| e.to_string())
    };
    for uri in ["a%20b/data%25.bin", "./a b/data%25.bin", "a%20b\\data%25.bin"] {
        let scene = with(uri).unwrap();
        assert_eq!((scene.name.as_str(), scene.triangle_count()), ("m", 2));
    }
    let absolute = folder.path().join("secret.bin").display().to_string();
    for (uri, cause) in [
        ("../secret.bin", "leads out"),
        ("a%20b/%2E%2E/../../secret.bin", "leads out"),
        (absolute.as_str(), "leads out"),
        ("file:///etc/hostname", "scheme"),
        ("https://example.com/x.bin", "scheme"),
        ("C:\\x.bin", "scheme"),
        ("/dev/zero", "leads out"),
        ("%FF.bin", "UTF-8"),
        ("a%00b", "not a path"),
        ("", "not a path"),
        ("a%20b", "not a plain file"),
        ("absent.bin", "buffers[0].uri"),
    ] {
        let error = with(uri).unwrap_err();
        assert!(error.contains(cause) && error.contains("buffers[0].uri"), "{uri}: {error}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path().join("secret.bin"), inside.join("link.bin")).unwrap();
        assert!(with("link.bin").unwrap_err().contains("link"));
        std::os::unix::fs::symlink("/dev/zero", inside.join("zero.bin")).unwrap();
        assert!(with("zero.bin").unwrap_err().contains("link"));
    }
    let error = load_bytes(json.to_string().as_bytes(), "test", None).unwrap_err().to_string();
    assert!(error.contains("not read from a folder"), "{error}");
}

#[test]
fn unknown_kinds_and_missing_files() {
    let error = load_bytes(b"no model", "model.txt", None).unwrap_err().to_string();
    assert!(error.contains("glTF, GLB, OBJ, STL and PLY are read"), "{error}");
    let error = load(std::path::Path::new("absent.glb")).unwrap_err();
    assert!(matches!(error, ImportError::Io { .. }), "{error}");
}

#[test]
fn images_are_decoded_and_bounded() {
    let with = |bytes: &[u8]| {
        let mut file = Builder::quad();
        let view = file.view(bytes);
        file.set("/images", json!([{"bufferView": view, "name": "paint"}]))
    };
    let pixel = png(image::DynamicImage::ImageRgb8(image::RgbImage::from_raw(1, 1, vec![10, 20, 30]).unwrap()));
    let scene = with(&pixel).scene();
    assert_eq!(scene.images[0].rgba, [10, 20, 30, 255]);
    assert_eq!((scene.images[0].name.as_str(), scene.notices.len()), ("paint", 2));
    let deep = image::ImageBuffer::from_raw(1, 1, vec![0xFFFF_u16, 0, 0x8080]).unwrap();
    let scene = with(&png(image::DynamicImage::ImageRgb16(deep))).scene();
    assert_eq!(scene.images[0].rgba, [255, 0, 128, 255]);
    assert_tells(&scene, NoticeKind::Approximated, "16 bits");
    with(b"not an image").refused("images[0]: is of an unknown kind");
    with(&pixel[..pixel.len() - 20]).refused("images[0]: cannot be decoded");
    Builder::quad().set("/images", json!([{"uri": "x.png", "bufferView": 0}])).refused("images[0]: has both");
    Builder::quad().set("/images", json!([{}])).refused("images[0]: has neither");
    Builder::quad().set("/images", json!([{"bufferView": 77}])).refused("images[0].bufferView");

    let wide = png(image::DynamicImage::new_rgb8(40, 2));
    for limits in [Limits { image_side: 39, ..Limits::default() }, Limits { image_pixels: 79, ..Limits::default() }] {
        let options = ImportOptions { limits, ..ImportOptions::default() };
        assert!(load_bytes_with(&with(&wide).bytes(), "test", None, &options).is_err());
    }
    let uri = format!("data:image/png;base64,{}", base64(&pixel));
    let scene = Builder::quad().set("/images", json!([{"uri": uri}])).scene();
    assert_eq!(scene.images[0].name, "images[0]");
}
