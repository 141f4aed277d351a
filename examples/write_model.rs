//! Writes a built-in scene, or a file that can be read, in the format that the name of the second file says: for comparing
//! readers, and a small example of the library.
//!
//! ```text
//! cargo run --release --example write_model -- 'builtin:torus?segments=1600' torus.stl
//! ```

use std::error::Error;
use std::path::Path;

use pellucid::export::glb::write_glb;
use pellucid::export::mesh_files::{PlyEncoding, write_mtl, write_obj, write_ply, write_stl_binary};
use pellucid::import;
use pellucid::scene::builtin;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [from, to] = arguments.as_slice() else {
        return Err("usage: write_model builtin:NAME|FILE OUT.glb|OUT.obj|OUT.ply|OUT.stl".into());
    };
    let scene = if from.starts_with("builtin:") { builtin::build(from)? } else { import::load(Path::new(from))? };
    let to = Path::new(to);
    let bytes = match to.extension().and_then(|e| e.to_str()) {
        Some("glb") => write_glb(&scene)?,
        Some("stl") => write_stl_binary(&scene),
        Some("ply") => write_ply(&scene, PlyEncoding::LittleEndian),
        Some("obj") => {
            let library = to.with_extension("mtl");
            std::fs::write(&library, write_mtl(&scene))?;
            write_obj(&scene, &library.file_name().unwrap_or_default().to_string_lossy())
        }
        _ => return Err(format!("{}: glb, obj, ply and stl are written", to.display()).into()),
    };
    std::fs::write(to, bytes)?;
    Ok(())
}
