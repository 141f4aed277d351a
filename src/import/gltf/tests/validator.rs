//! Every fault of the Khronos validator's list that touches what is read, each in a file of its own.
//!
//! Where `PELLUCID_VALIDATOR_FILES` names a folder, the files are written there, so that the validator itself can be asked
//! whether they have the faults.

use serde_json::json;

use super::instances::variants;
use super::textures::{textured, webp};
use super::*;
use crate::import::gltf::validator::{Handling, ISSUES};

/// The file, and what of it must be named in the error or a notice.
type Provoked = (Vec<u8>, &'static str);

/// A GLB of chunks as they come, `length` bytes long by its own account.
fn raw(length: u32, rest: &[u8]) -> Vec<u8> {
    [b"glTF".as_slice(), &2_u32.to_le_bytes(), &length.to_le_bytes(), rest].concat()
}

fn chunk(kind: &[u8; 4], length: u32, content: &[u8]) -> Vec<u8> {
    [length.to_le_bytes().as_slice(), kind, content].concat()
}

const EMPTY: &[u8] = br#"{"asset":{"version":"2.0"}}     "#;

/// A quad with everything that a normal map needs.
fn mapped() -> Builder {
    let mut file = Builder::quad()
        .attribute("NORMAL", floats(&[0., 0., 1.].repeat(4)), 5126, "VEC3", 4, false)
        .attribute("TANGENT", floats(&[1., 0., 0., 1.].repeat(4)), 5126, "VEC4", 4, false)
        .attribute("TEXCOORD_0", floats(&[0., 0., 1., 0., 1., 1., 0., 1.]), 5126, "VEC2", 4, false);
    let view = file.view(&png(image::DynamicImage::new_rgb8(1, 1)));
    file.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    file.json["textures"] = json!([{"source": 0}]);
    file.json["materials"] = json!([{"normalTexture": {"index": 0}}]);
    file.primitive()["material"] = 0.into();
    file
}

/// Overwrites floats of an accessor's view.
fn patch(mut file: Builder, accessor: usize, at: usize, values: &[f32]) -> Builder {
    let view = file.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
    let start = file.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize + 4 * at;
    file.binary[start..start + 4 * values.len()].copy_from_slice(&floats(values));
    file
}

fn sparse(indices: &[u8]) -> Builder {
    let mut file = Builder::quad();
    let at = file.view(indices);
    let values = file.view(&floats(&[0.0, 0.0, 0.1].repeat(indices.len())));
    file.json["accessors"][0]["sparse"] = json!({
        "count": indices.len(),
        "indices": {"bufferView": at, "componentType": 5121},
        "values": {"bufferView": values},
    });
    file
}

fn camera(camera: Value) -> Builder {
    Builder::quad()
        .set("/cameras", json!([camera]))
        .set("/nodes", json!([{"mesh": 0}, {"camera": 0}]))
        .set("/scenes/0/nodes", json!([0, 1]))
}

fn nodes(nodes: Value, roots: Value) -> Builder {
    Builder::quad().set("/nodes", nodes).set("/scenes/0/nodes", roots)
}

fn image(source: Value) -> Builder {
    Builder::quad().set("/images", json!([source]))
}

fn image_of(bytes: &[u8], kind: &str) -> Builder {
    let mut file = Builder::quad();
    let view = file.view(bytes);
    file.set("/images", json!([{"bufferView": view, "mimeType": kind}]))
}

/// A PNG with a colour profile, which no decoder looks into.
fn with_profile() -> Vec<u8> {
    use ::image::ImageEncoder;
    let mut out = Vec::new();
    let mut encoder = ::image::codecs::png::PngEncoder::new(&mut out);
    encoder.set_icc_profile(vec![7; 200]).unwrap();
    encoder.write_image(&[1, 2, 3], 1, 1, ::image::ExtendedColorType::Rgb8).unwrap();
    out
}

fn in_json(code: &str) -> Option<(Builder, &'static str)> {
    let quad = Builder::quad;
    Some(match code {
        "IO_ERROR" => (quad().set("/buffers", json!([{"byteLength": 60, "uri": "absent.bin"}])), "buffers[0].uri"),
        "ARRAY_LENGTH_NOT_IN_LIST" => (nodes(json!([{"mesh": 0, "scale": [1, 1]}]), json!([0])), "nodes[0]"),
        "ARRAY_TYPE_MISMATCH" => (nodes(json!([{"mesh": 0, "scale": [1, "1", 1]}]), json!([0])), "nodes[0]"),
        "DUPLICATE_ELEMENTS" => (quad().set("/scenes/0/nodes", json!([0, 0])), "named twice"),
        "EMPTY_ENTITY" => (quad().set("/materials", json!([])), "lists are empty"),
        "INVALID_INDEX" => (nodes(json!([{"mesh": -1}]), json!([0])), "nodes[0].mesh"),
        "INVALID_URI" => (image(json!({"uri": "http://[x"})), "images[0].uri"),
        "ONE_OF_MISMATCH" => (image(json!({"uri": "x.png", "bufferView": 0, "mimeType": "image/png"})), "has both"),
        "PATTERN_MISMATCH" => (quad().set("/asset/version", json!("two")), "asset.version"),
        "TYPE_MISMATCH" => (nodes(json!([{"mesh": 0, "name": 3}]), json!([0])), "nodes[0]"),
        "UNDEFINED_PROPERTY" => (quad().set("/buffers", json!([{}])), "buffers[0].byteLength: is missing"),
        "UNEXPECTED_PROPERTY" => (nodes(json!([{"mesh": 0, "roatation": 3}]), json!([0])), "nodes[0].roatation"),
        "UNSATISFIED_DEPENDENCY" => {
            let mut file = quad();
            file.json["accessors"]
                .as_array_mut()
                .unwrap()
                .push(json!({"byteOffset": 4, "componentType": 5126, "type": "SCALAR", "count": 1}));
            (file, "the offset does nothing")
        }
        "VALUE_MULTIPLE_OF" => {
            let mut file = quad().set("/accessors/0/count", json!(3)).set("/accessors/1/count", json!(3));
            file.json["bufferViews"][0]["byteStride"] = 13.into();
            (file, "not a multiple of 4")
        }
        "VALUE_NOT_IN_LIST" => (mapped().set("/materials/0/alphaMode", json!("GLASS")), "glTF has no such mode"),
        "VALUE_NOT_IN_RANGE" => {
            let metal = json!({"metallicFactor": 2});
            (mapped().set("/materials/0/pbrMetallicRoughness", metal), "2 is out of range")
        }
        "ACCESSOR_NORMALIZED_INVALID" => (quad().set("/accessors/0/normalized", json!(true)), "are normalized but"),
        "ACCESSOR_OFFSET_ALIGNMENT" => {
            let file = quad().set("/accessors/0/byteOffset", json!(2)).set("/accessors/0/count", json!(3));
            (file.set("/accessors/1/count", json!(3)), "read where they begin")
        }
        "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE" => (sparse(&[0, 1, 2, 3, 3]), "5 of 4 elements are replaced"),
        "ASSET_MIN_VERSION_GREATER_THAN_VERSION" => (quad().set("/asset/minVersion", json!("2.1")), "asset.minVersion"),
        "BUFFER_DATA_URI_MIME_TYPE_INVALID" => {
            let file = quad();
            let uri = format!("data:text/plain;base64,{}", base64(&file.binary));
            let length = file.binary.len();
            (file.set("/buffers", json!([{"byteLength": length, "uri": uri}])), "say that they are something else")
        }
        "BUFFER_VIEW_INVALID_BYTE_STRIDE" => {
            let file = quad().set("/bufferViews/1/target", json!(34963)).set("/bufferViews/1/byteStride", json!(4));
            (file.set("/accessors/1/count", json!(3)), "which glTF does not allow")
        }
        "BUFFER_VIEW_TOO_BIG_BYTE_STRIDE" => {
            let file = quad().set("/bufferViews/0/byteStride", json!(252)).set("/accessors/0/count", json!(1));
            (
                file.set("/accessors/1/count", json!(1)).set("/bufferViews/1/byteLength", json!(2)),
                "longer than their buffer view",
            )
        }
        "CAMERA_XMAG_YMAG_NEGATIVE" | "CAMERA_XMAG_YMAG_ZERO" => {
            let ymag = if code.ends_with("ZERO") { 0.0 } else { -1.0 };
            let orthographic = json!({"xmag": 1, "ymag": ymag, "znear": 0, "zfar": 1});
            (camera(json!({"type": "orthographic", "orthographic": orthographic})), "cameras[0]: it has no usable")
        }
        "CAMERA_YFOV_GEQUAL_PI" => (
            camera(json!({"type": "perspective", "perspective": {"yfov": 4, "znear": 1}})),
            "cameras[0]: it has no usable",
        ),
        "INVALID_EXTENSION_NAME_FORMAT" => {
            (quad().set("/extensionsUsed", json!(["glitter"])), "glitter: the extension is not known")
        }
        "MATERIAL_ALPHA_CUTOFF_INVALID_MODE" => (mapped().set("/materials/0/alphaCutoff", json!(0.3)), "alphaCutoff"),
        "MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY" => {
            (quad().attribute("TEXCOORD_1", floats(&[0.0; 8]), 5126, "VEC2", 4, false), "not numbered from 0")
        }
        "MESH_PRIMITIVE_INVALID_ATTRIBUTE" => (
            quad().attribute("HEAT", floats(&[0.0; 4]), 5126, "SCALAR", 4, false),
            "attributes that glTF does not know",
        ),
        "MESH_PRIMITIVE_NO_POSITION" => {
            (Builder::new().attribute("NORMAL", floats(&[0., 0., 1.]), 5126, "VEC3", 1, false), "have no positions")
        }
        "MESH_PRIMITIVE_TANGENT_WITHOUT_NORMAL" => {
            let mut file = mapped();
            file.primitive()["attributes"].as_object_mut().unwrap().remove("NORMAL");
            (file, "tangents but no normals")
        }
        "NODE_MATRIX_NON_TRS" => {
            let skewed = json!([1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
            (nodes(json!([{"mesh": 0, "matrix": skewed}]), json!([0])), "not products of translation")
        }
        "NODE_MATRIX_TRS" => {
            let matrix = json!([2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
            let node = json!([{"mesh": 0, "matrix": matrix, "translation": [1, 0, 0]}]);
            (nodes(node, json!([0])), "the matrix is used")
        }
        "NON_RELATIVE_URI" => (image(json!({"uri": "https://example.com/x.png"})), "has a scheme"),
        "NON_REQUIRED_EXTENSION" => {
            let file = Builder::new()
                .attribute("POSITION", shorts(&[0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0]), 5123, "VEC3", 3, false)
                .set("/bufferViews/0/byteStride", json!(8));
            (file.set("/extensionsUsed", json!(["KHR_mesh_quantization"])), "extensionsRequired")
        }
        "ROTATION_NON_UNIT" => (nodes(json!([{"mesh": 0, "rotation": [0, 0, 0, 0.5]}]), json!([0])), "was normalized"),
        "UNKNOWN_ASSET_MAJOR_VERSION" => (quad().set("/asset/version", json!("3.0")), "glTF 3.0"),
        "UNKNOWN_ASSET_MINOR_VERSION" => (quad().set("/asset/version", json!("2.1")), "glTF 2.1"),
        "UNUSED_EXTENSION_REQUIRED" => {
            (quad().set("/extensionsRequired", json!(["KHR_materials_unlit"])), "does not list it in extensionsUsed")
        }
        "ACCESSOR_SMALL_BYTESTRIDE" => (quad().set("/bufferViews/0/byteStride", json!(8)), "byteStride 8"),
        "ACCESSOR_TOO_LONG" => (quad().set("/accessors/0/count", json!(5)), "accessors[0]"),
        "ACCESSOR_TOTAL_OFFSET_ALIGNMENT" => {
            let file = quad().set("/bufferViews/0/byteOffset", json!(2)).set("/accessors/0/count", json!(3));
            (file.set("/accessors/1/count", json!(3)), "read where they begin")
        }
        "ACCESSOR_USAGE_OVERRIDE" => {
            let mut file = Builder::new().attribute(
                "POSITION",
                floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]),
                5126,
                "VEC3",
                3,
                false,
            );
            let both = file.accessor(&[0, 1, 2], 5121, "SCALAR", 3, false);
            file.primitive()["indices"] = both.into();
            file.primitive()["attributes"]["_WHICH"] = both.into();
            (file, "for vertices and for indices")
        }
        "BUFFER_MISSING_GLB_DATA" => {
            (Builder::new().set("/buffers", json!([{"byteLength": 4}])), "no binary chunk for it")
        }
        "BUFFER_VIEW_TARGET_OVERRIDE" => {
            (quad().set("/bufferViews/1/target", json!(34962)), "another use than they say")
        }
        "BUFFER_VIEW_TOO_LONG" => (quad().set("/bufferViews/0/byteLength", json!(4000)), "bufferViews[0]"),
        "IMAGE_BUFFER_VIEW_WITH_BYTESTRIDE" => {
            let mut file = mapped();
            let view = file.json["images"][0]["bufferView"].as_u64().unwrap() as usize;
            file.json["bufferViews"][view]["byteStride"] = 4.into();
            (file, "buffer views of images have a stride")
        }
        "KHR_MATERIALS_VARIANTS_NON_UNIQUE_VARIANT" => {
            let mapping = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings/1/variants";
            (variants().set(mapping, json!([0, 1])), "mapped twice")
        }
        "MESH_PRIMITIVE_ACCESSOR_UNALIGNED" => {
            let file = Builder::new().attribute("POSITION", vec![0, 0, 0, 9, 0, 0, 0, 9, 0], 5120, "VEC3", 3, false);
            let names = json!(["KHR_mesh_quantization"]);
            (
                file.set("/extensionsUsed", names.clone()).set("/extensionsRequired", names),
                "do not begin at multiples of 4",
            )
        }
        "MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE" => {
            let mut file = quad();
            let mut second = file.json["accessors"][0].clone();
            second["byteOffset"] = 0.into();
            file.json["accessors"].as_array_mut().unwrap().push(second);
            file.primitive()["attributes"]["_OTHER"] = 2.into();
            (file, "several vertex attributes but no stride")
        }
        "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT" => {
            (quad().set("/accessors/0/type", json!("VEC2")), "POSITION: cannot be")
        }
        "MESH_PRIMITIVE_GENERATED_TANGENT_SPACE" => {
            let mut file = mapped();
            file.primitive()["attributes"].as_object_mut().unwrap().remove("TANGENT");
            (file, "were given tangents")
        }
        "MESH_PRIMITIVE_INCOMPATIBLE_MODE" => (quad().set("/accessors/1/count", json!(5)), "do not make a triangle"),
        "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT" => {
            let file = quad().set("/accessors/1/type", json!("VEC2")).set("/accessors/1/count", json!(3));
            (file, "indices: cannot be")
        }
        "MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE" => {
            let file = quad().set("/bufferViews/1/byteStride", json!(4));
            (file.set("/accessors/1/count", json!(3)), "indices are in buffer views with a stride")
        }
        "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS" => {
            let mut file = mapped();
            file.primitive()["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
            (file, "sampled at (0, 0)")
        }
        "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT" => {
            (quad().attribute("NORMAL", floats(&[0., 0., 1.].repeat(3)), 5126, "VEC3", 3, false), "has 3 elements")
        }
        "NODE_LOOP" => (nodes(json!([{"children": [1]}, {"children": [0]}]), json!([])), "loop"),
        "NODE_PARENT_OVERRIDE" => {
            (nodes(json!([{"children": [2]}, {"children": [2]}, {}]), json!([0, 1])), "also a child")
        }
        "SCENE_NON_ROOT_NODE" => (nodes(json!([{"children": [1]}, {"mesh": 0}]), json!([0, 1])), "is not a root"),
        "TEXTURE_INVALID_IMAGE_MIME_TYPE" | "IMAGE_NON_ENABLED_MIME_TYPE" => {
            let mut file = mapped();
            let view = file.view(&webp(&::image::DynamicImage::new_rgb8(1, 1)));
            file.json["images"] = json!([{"bufferView": view, "mimeType": "image/webp"}]);
            (file, "needs an extension which their texture does not name")
        }
        "UNDECLARED_EXTENSION" => (
            mapped().set("/materials/0/extensions", json!({"KHR_materials_unlit": {}})),
            "does not list it in extensionsUsed",
        ),
        "UNEXPECTED_EXTENSION_OBJECT" => {
            let file = quad().set("/extensionsUsed", json!(["KHR_materials_unlit"]));
            (file.set("/nodes/0/extensions", json!({"KHR_materials_unlit": {}})), "mean nothing")
        }
        "UNRESOLVED_REFERENCE" => (quad().set("/nodes/0/mesh", json!(7)), "refers to mesh 7"),
        "UNSUPPORTED_EXTENSION" => {
            (quad().set("/extensionsUsed", json!(["VENDOR_x"])), "VENDOR_x: the extension is not known")
        }
        "ACCESSOR_INDEX_OOB" => {
            let positions = floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0.]);
            let file = Builder::new().attribute("POSITION", positions, 5126, "VEC3", 3, false);
            (file.indices(vec![0, 1, 9], 5121, 3), "is 9, the primitive has 3 vertices")
        }
        "ACCESSOR_INDEX_PRIMITIVE_RESTART" => {
            let positions: Vec<f32> = (0..256).flat_map(|i| [(i % 16) as f32, (i / 16) as f32, 0.0]).collect();
            let file = Builder::new().attribute("POSITION", floats(&positions), 5126, "VEC3", 256, false);
            (file.indices(vec![0, 1, 255], 5121, 3), "largest value of their type")
        }
        "ACCESSOR_INDEX_TRIANGLE_DEGENERATE" => {
            let positions = floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0.]);
            let file = Builder::new().attribute("POSITION", positions, 5126, "VEC3", 3, false);
            (file.indices(vec![0, 1, 2, 0, 1, 1], 5121, 6), "triangles without area")
        }
        "ACCESSOR_INVALID_FLOAT" => (patch(quad(), 0, 0, &[f32::NAN]), "positions that are not finite"),
        "ACCESSOR_INVALID_SIGN" => (patch(mapped(), 3, 3, &[0.5]), "another handedness"),
        "ACCESSOR_NON_CLAMPED" => {
            (quad().attribute("COLOR_0", floats(&[2.0; 12]), 5126, "VEC3", 4, false), "vertex colours were outside")
        }
        "ACCESSOR_SPARSE_INDEX_OOB" => (sparse(&[9]), "element 9 is to be replaced"),
        "ACCESSOR_SPARSE_INDICES_NON_INCREASING" => (sparse(&[2, 1]), "do not rise"),
        "ACCESSOR_VECTOR3_NON_UNIT" => (patch(mapped(), 2, 2, &[3.0]), "not of unit length"),
        "BUFFER_BYTE_LENGTH_MISMATCH" => {
            (quad().set("/buffers", json!([{"byteLength": 4000}])), "buffers[0].byteLength")
        }
        "BUFFER_GLB_CHUNK_TOO_BIG" => {
            let mut file = quad().set("/buffers", json!([{"byteLength": 60}]));
            file.binary.extend([0; 16]);
            (file, "bytes longer than byteLength")
        }
        "IMAGE_DATA_INVALID" => {
            // A PNG whose header is a byte too short.
            let bytes = [b"\x89PNG\r\n\x1a\n\0\0\0\x0cIHDR".as_slice(), &[0; 40]].concat();
            (image_of(&bytes, "image/png"), "images[0]: cannot be decoded")
        }
        "IMAGE_FEATURES_UNSUPPORTED" => (image_of(&with_profile(), "image/png"), "colour profile"),
        "IMAGE_MIME_TYPE_INVALID" => {
            (image_of(&png(image::DynamicImage::new_rgb8(1, 1)), "image/jpeg"), "of another kind than their mimeType")
        }
        "IMAGE_UNEXPECTED_EOS" => {
            (image_of(&png(image::DynamicImage::new_rgb8(1, 1))[..20], "image/png"), "images[0]: cannot be decoded")
        }
        "IMAGE_UNRECOGNIZED_FORMAT" => (image_of(b"not an image", "image/png"), "images[0]: is of an unknown kind"),
        _ => return None,
    })
}

fn in_container(code: &str) -> Option<Provoked> {
    let json = chunk(b"JSON", EMPTY.len() as u32, EMPTY);
    let whole = |rest: Vec<u8>| raw(12 + rest.len() as u32, &rest);
    let twice = |a: &[u8], b: &[u8]| whole([a, b].concat());
    Some(match code {
        "INVALID_JSON" => (b"{]".to_vec(), "JSON"),
        "GLB_CHUNK_LENGTH_UNALIGNED" => (whole(chunk(b"JSON", 27, &EMPTY[..27])), "is not a multiple of 4"),
        "GLB_CHUNK_TOO_BIG" => (whole(chunk(b"JSON", 400, EMPTY)), "has 400 bytes"),
        "GLB_DUPLICATE_CHUNK" => (twice(&json, &json), "a second JSON chunk"),
        "GLB_EMPTY_CHUNK" => (whole(chunk(b"JSON", 0, b"")), "JSON"),
        "GLB_EXTRA_DATA" => (raw(12 + json.len() as u32, &[json.as_slice(), b"more"].concat()), "the file has"),
        "GLB_INVALID_MAGIC" => (b"glTX\x02\0\0\0\x0c\0\0\0".to_vec(), "neither a GLB"),
        "GLB_INVALID_VERSION" => (b"glTF\x07\0\0\0\x0c\0\0\0".to_vec(), "version 7"),
        "GLB_LENGTH_MISMATCH" => (raw(1000, &json), "says 1000 bytes"),
        "GLB_LENGTH_TOO_SMALL" => (raw(8, &json), "says 8 bytes"),
        "GLB_UNEXPECTED_BIN_CHUNK" => {
            let other = chunk(b"ABCD", 4, b"1234");
            (whole([json.as_slice(), &other, &chunk(b"BIN\0", 4, b"1234")].concat()), "out of place")
        }
        "GLB_UNEXPECTED_END_OF_CHUNK_DATA" => (raw(12 + json.len() as u32, &json[..20]), "the file has"),
        "GLB_UNEXPECTED_END_OF_CHUNK_HEADER" => (whole(json[..6].to_vec()), "cut off"),
        "GLB_UNEXPECTED_END_OF_HEADER" => (b"glTF\x02\0\0\0".to_vec(), "ends after 8"),
        "GLB_UNEXPECTED_FIRST_CHUNK" => (whole(chunk(b"BIN\0", 4, b"1234")), "must be JSON"),
        "GLB_UNKNOWN_CHUNK_TYPE" => (twice(&json, &chunk(b"ABCD", 4, b"1234")), "are not known"),
        _ => return None,
    })
}

#[test]
fn every_fault_is_refused_or_told() {
    let folder = std::env::var_os("PELLUCID_VALIDATOR_FILES").map(std::path::PathBuf::from);
    let mut wrong = Vec::new();
    for issue in ISSUES {
        let provoked =
            in_json(issue.code).map(|(file, part)| (file.bytes(), part)).or_else(|| in_container(issue.code));
        let Some((bytes, part)) = provoked else {
            if matches!(issue.handling, Handling::Refused | Handling::Told) {
                wrong.push(format!("{}: no file provokes it", issue.code));
            }
            continue;
        };
        if let Some(folder) = &folder {
            let ending = if bytes.starts_with(b"glT") { "glb" } else { "gltf" };
            std::fs::write(folder.join(format!("{}.{ending}", issue.code)), &bytes).unwrap();
        }
        match (issue.handling, load_bytes(&bytes, "test.gltf", Some(std::path::Path::new(".")))) {
            (Handling::Refused, Err(e)) if e.to_string().contains(part) => {}
            (Handling::Told, Ok(scene)) if scene.notices.iter().any(|n| n.message.contains(part)) => {}
            (handling, Err(e)) => wrong.push(format!("{}: {handling:?}, but {e}", issue.code)),
            (handling, Ok(scene)) => {
                wrong.push(format!("{}: {handling:?} about {part:?}, but {:?}", issue.code, scene.notices));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let refused = ISSUES.iter().filter(|i| i.handling == Handling::Refused).count();
    let told = ISSUES.iter().filter(|i| i.handling == Handling::Told).count();
    println!("{} codes: {refused} refused, {told} told", ISSUES.len());
}

#[test]
fn the_list_is_whole_and_has_no_code_twice() {
    let mut codes: Vec<&str> = ISSUES.iter().map(|i| i.code).collect();
    codes.sort_unstable();
    codes.dedup();
    assert_eq!(codes.len(), ISSUES.len());
    assert!(ISSUES.iter().all(|i| !i.what.is_empty()));
}

#[test]
fn a_better_image_hides_a_bad_one() {
    let offered = webp(&image::DynamicImage::new_rgb8(1, 1));
    let scene = textured(Some(b"not an image"), &offered, "EXT_texture_webp").scene();
    assert_eq!(scene.images.len(), 1);
}
