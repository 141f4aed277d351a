//! Bytes as the material file of an OBJ with a texture beside it.

#![no_main]

mod shared;

use std::path::PathBuf;
use std::sync::OnceLock;

use pellucid::import::load_with;

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
/// A picture of one texel.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\x06\0\0\0\x1f\x15\xc4\x89\0\0\0\rIDATx\x9cc\xf8\xcf\xc0\xf0\x1f\0\x05\0\x01\xff\x89\x99=\x1d\0\0\0\0IEND\xaeB`\x82";

/// A folder of this process, with the model and its texture.
fn folder() -> &'static PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder").keep();
        std::fs::write(folder.join("a.obj"), OBJ).expect("written");
        std::fs::write(folder.join("c.png"), PNG).expect("written");
        folder
    })
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let folder = folder();
    std::fs::write(folder.join("m.mtl"), bytes).expect("written");
    // Only an image over the limits is refused.
    if let Ok(scene) = load_with(&folder.join("a.obj"), &shared::options()) {
        shared::check(&scene);
    }
});
