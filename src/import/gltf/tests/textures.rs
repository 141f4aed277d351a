//! Images of other kinds than glTF's own, and what stands for them.

use image::{DynamicImage, ImageFormat, RgbaImage};
use serde_json::json;

use super::*;
use crate::import::{ImportOptions, Limits, load_bytes_with};

/// KTX2 files of one picture of 20 × 12 pixels, written by Basis Universal's encoder 2 (`alktx2` 0.1.7), and what its own
/// transcoder makes of them.
const ETC1S: (&[u8], &[u8]) = (include_bytes!("ktx2/etc1s.ktx2"), include_bytes!("ktx2/etc1s.png"));
const UASTC: (&[u8], &[u8]) = (include_bytes!("ktx2/uastc.ktx2"), include_bytes!("ktx2/uastc.png"));
const UASTC_ZSTD: (&[u8], &[u8]) = (include_bytes!("ktx2/uastc_zstd.ktx2"), include_bytes!("ktx2/uastc.png"));

/// A quad with a texture: its core image and the one that an extension offers.
pub(super) fn textured(core: Option<&[u8]>, offered: &[u8], extension: &str) -> Builder {
    let mut file = Builder::quad()
        .attribute("TEXCOORD_0", floats(&[0., 0., 1., 0., 1., 1., 0., 1.]), 5126, "VEC2", 4, false)
        .attribute("NORMAL", floats(&[0., 0., 1.].repeat(4)), 5126, "VEC3", 4, false);
    let kind = if extension.contains("webp") { "image/webp" } else { "image/ktx2" };
    let view = file.view(offered);
    let mut images = vec![json!({"bufferView": view, "mimeType": kind})];
    let mut texture = json!({"extensions": {extension: {"source": 0}}});
    if let Some(core) = core {
        let view = file.view(core);
        images.push(json!({"bufferView": view, "mimeType": "image/png"}));
        texture["source"] = 1.into();
    } else {
        file.json["extensionsRequired"] = json!([extension]);
    }
    file.json["extensionsUsed"] = json!([extension]);
    file.json["images"] = images.into();
    file.json["textures"] = json!([texture]);
    file.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    file.primitive()["material"] = 0.into();
    file
}

fn pixel(rgba: [u8; 4]) -> DynamicImage {
    RgbaImage::from_pixel(1, 1, image::Rgba(rgba)).into()
}

pub(super) fn webp(image: &DynamicImage) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image.write_to(&mut out, ImageFormat::WebP).unwrap();
    out.into_inner()
}

#[test]
fn webp_images_are_read() {
    let offered = webp(&pixel([10, 200, 30, 128]));
    let scene = textured(None, &offered, "EXT_texture_webp").scene();
    assert_eq!((scene.images.len(), scene.images[0].rgba.as_slice()), (1, &[10, 200, 30, 128][..]));
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    // Where both are there, the extension's is shown and the other not decoded.
    let both = textured(Some(b"no image at all"), &offered, "EXT_texture_webp").scene();
    assert_eq!((both.images.len(), both.images[0].rgba[0]), (1, 10));
    assert_tells(&both, NoticeKind::Ignored, "1 images are the file's substitutes");
}

#[test]
fn substitutes_stand_for_what_cannot_be_read() {
    let core = png(pixel([1, 2, 3, 255]));
    for extension in ["EXT_texture_webp", "KHR_texture_basisu"] {
        let scene = textured(Some(&core), b"no image at all", extension).scene();
        assert_eq!(scene.images[0].rgba, [1, 2, 3, 255]);
        assert_tells(&scene, NoticeKind::Approximated, "images[0]: it cannot be read");
        textured(None, b"no image at all", extension).refused("images[0]: is of an unknown kind");
    }
    let avif = textured(Some(&core), b"no image at all", "EXT_texture_avif").scene();
    assert_eq!((avif.images.len(), avif.textures.len()), (1, 1));
    assert_tells(&avif, NoticeKind::Ignored, "EXT_texture_avif");
    textured(None, b"no image at all", "EXT_texture_avif").refused("EXT_texture_avif is not supported");
    let missing = textured(Some(&core), &core, "KHR_texture_basisu");
    missing.set("/textures/0/extensions/KHR_texture_basisu/source", json!(9)).refused("KHR_texture_basisu.source");
}

#[test]
fn basis_universal_is_read_as_its_own_transcoder_reads_it() {
    for (name, (ktx2, reference)) in [("etc1s", ETC1S), ("uastc", UASTC), ("uastc with zstd", UASTC_ZSTD)] {
        let scene = textured(None, ktx2, "KHR_texture_basisu").scene();
        let expected = image::load_from_memory(reference).unwrap().into_rgba8();
        let image = &scene.images[0];
        assert_eq!((image.width, image.height), (20, 12), "{name}");
        assert_eq!(image.rgba, expected.into_raw(), "{name}");
        assert!(scene.notices.is_empty(), "{name}: {:?}", scene.notices);
    }
}

#[test]
fn ktx2_headers_are_checked_before_anything_is_allocated() {
    let patched = |at: usize, value: u32| {
        let mut bytes = UASTC_ZSTD.0.to_vec();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        textured(None, &bytes, "KHR_texture_basisu")
    };
    for (at, value, part) in [
        (12, 37, "Vulkan's format 37"),
        (20, 0, "no pixels"),
        (20, 1 << 30, "width or height"),
        (24, u32::MAX, "width or height"),
        (28, 4, "more than one image"),
        (32, 9, "more than one image"),
        (36, 6, "more than one image"),
        (40, 99, "99 levels"),
        (44, 77, "cannot be decoded"),
        (48, u32::MAX, "data format"),
        (68, u32::MAX, "global data"),
        (80, u32::MAX, "lie outside"),
        (96, u32::MAX, "is to become"),
        (20, 400, "is to become"),
    ] {
        let error = patched(at, value).refused("images[0]");
        assert!(error.contains(part), "{at}: {error} names {part}");
    }
    textured(None, &UASTC.0[..60], "KHR_texture_basisu").refused("cut off");
    let limits = Limits { image_pixels: 239, ..Limits::default() };
    let options = ImportOptions { limits, ..ImportOptions::default() };
    let bytes = textured(None, ETC1S.0, "KHR_texture_basisu").bytes();
    let error = load_bytes_with(&bytes, "test", None, &options).unwrap_err();
    assert!(matches!(error, ImportError::Limit { .. }), "{error}");
}

#[test]
fn damaged_ktx2_files_never_panic() {
    for (ktx2, _) in [ETC1S, UASTC, UASTC_ZSTD] {
        for at in 80..ktx2.len() {
            for flip in [1, 0x80, 0xFF] {
                let mut bytes = ktx2.to_vec();
                bytes[at] ^= flip;
                // Either is fine.
                let _ = textured(None, &bytes, "KHR_texture_basisu").load();
            }
        }
    }
}

/// Found by changed structures: ones where the lengths of repeats are make the decoder's sums overflow, which an unoptimized
/// build notices by a panic.
#[test]
fn ones_in_place_of_etc1s_repeats_become_errors_or_pictures() {
    for at in 80..ETC1S.0.len() {
        let mut bytes = ETC1S.0.to_vec();
        bytes.iter_mut().skip(at).take(8).for_each(|byte| *byte = 0xFF);
        match textured(None, &bytes, "KHR_texture_basisu").load() {
            Ok(scene) => assert_eq!(scene.images[0].rgba.len(), 4 * 20 * 12),
            Err(e) => assert!(e.to_string().contains("images[0]"), "{at}: {e}"),
        }
    }
}
