//! Real models: every file of a folder that has one of the formats that are read loads, or is refused with a reason, and is drawn with every fragment
//! accounted for.
//!
//! The folder is the one that `PELLUCID_MODELS` names, or `../shared/models` beside the project. Files below a folder
//! called `malformed` must be refused, or loaded with a notice.

use std::path::{Path, PathBuf};

use glam::DVec3;
use pellucid::import::{self, ImportError};
use pellucid::math::Camera;
use pellucid::render::Renderer;
use pellucid::scene::{Arrangement, Cut, Scene, Section, Solids};
use pellucid::settings::{CaptureKind, Settings};

use super::support::{full, gpu, repository};

const SIZE: [u32; 2] = [128, 128];

/// Extensions without which a file that requires them cannot be read.
const UNREADABLE: &[&str] = &["EXT_texture_avif", "MSFT_texture_dds"];

/// Where the real models are, if they are.
pub fn folder() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("PELLUCID_MODELS").filter(|v| !v.is_empty()) {
        let folder = PathBuf::from(named);
        assert!(folder.is_dir(), "PELLUCID_MODELS names {}, which is no folder", folder.display());
        return Some(folder);
    }
    Some(repository().join("../shared/models")).filter(|f| f.is_dir())
}

fn models(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap().map(Result::unwrap) {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
                if ["glb", "gltf", "obj", "stl", "ply"].contains(&extension.as_str()) {
                    all.push(path);
                }
            }
        }
    }
    all.sort();
    all
}

/// The extension that the file's text requires and nobody here can read, if any.
fn unreadable(path: &Path) -> Option<&'static str> {
    let bytes = std::fs::read(path).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let required = text.split("\"extensionsRequired\"").nth(1)?.split(']').next()?;
    UNREADABLE.iter().copied().find(|e| required.contains(e))
}

/// What loading must come to.
fn judge_load(path: &Path, name: &str, loaded: &Result<Scene, ImportError>) -> Result<(), String> {
    match (loaded, unreadable(path)) {
        (Ok(_), Some(extension)) => Err(format!("was read without its {extension}")),
        (Err(e), Some(extension)) if !e.to_string().contains(extension) => {
            Err(format!("the refusal does not name {extension}: {e}"))
        }
        (Err(_), Some(_)) => Ok(()),
        (Ok(scene), None) if name.contains("malformed") && scene.notices.is_empty() => {
            Err("is malformed, and nothing is said about it".to_owned())
        }
        (Err(e), None) if !name.contains("malformed") => Err(format!("was refused: {e}")),
        (Err(e), None) if !e.to_string().contains(&*path.file_name().unwrap_or_default().to_string_lossy()) => {
            Err(format!("the error does not name the file: {e}"))
        }
        _ => Ok(()),
    }
}

/// Draws the scene and checks the books and the pixels.
fn judge_picture(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Result<String, String> {
    let gpu_scene = renderer.load(scene).map_err(|e| format!("upload: {e}"))?;
    let direction = DVec3::new(-0.52, -0.42, -0.74);
    let camera = Camera::framing(&scene.bounds(), direction, DVec3::Y, 1.0, 0.9, false, 30_f64.to_radians());
    let frame = renderer.render(&gpu_scene, &camera, settings, SIZE).map_err(|e| format!("render: {e}"))?;
    renderer.gpu().wait().map_err(|e| format!("device: {e}"))?;
    let layers = &frame.report.layers;
    if !layers.balanced() {
        return Err(format!("the books do not balance: {layers:?}"));
    }
    if frame.report.plan.capture.is_whole() && layers.stored != layers.rasterized {
        return Err(format!("not every fragment is stored: {layers:?}"));
    }
    let wrong = |p: &[f32; 4]| !p.iter().all(|v| v.is_finite() && *v >= 0.0) || p[3] > 1.001;
    if let Some(at) = frame.image.pixels.iter().position(wrong) {
        return Err(format!("pixel {at} is {:?}", frame.image.pixels[at]));
    }
    let visible = frame.image.pixels.iter().filter(|p| p[3] > 0.0).count() as u64;
    if visible == 0 && layers.stored > 0 {
        return Err("the picture is empty".to_owned());
    }
    if scene.triangle_count() > 100 && layers.stored == 0 {
        return Err("nothing was captured".to_owned());
    }
    let deepest = layers.deepest;
    Ok(format!("{} fragments, {deepest} deep, {:.0} ms", layers.rasterized, frame.report.milliseconds))
}

#[test]
fn real_models_load_or_are_refused_and_render_without_losing_a_fragment() {
    let Some(folder) = folder() else {
        println!("SKIPPED: real models: there is no folder ../shared/models, and PELLUCID_MODELS names none");
        return;
    };
    let mut renderer = gpu("real models: rendering").map(|gpu| Renderer::new(gpu).unwrap());
    let compacted = Settings::default();
    let mut bucketed = Settings::default();
    bucketed.capture.kind = CaptureKind::BucketedKBuffer;
    bucketed.capture.bucketed_k_buffer.k = 64;
    let (mut ran, mut refused, mut pictures) = (0, 0, 0);
    let mut faults = Vec::new();
    for path in models(&folder) {
        let name = path.strip_prefix(&folder).unwrap().display().to_string();
        let loaded = import::load(&path);
        if let Err(fault) = judge_load(&path, &name, &loaded) {
            faults.push(format!("{name}: {fault}"));
        }
        let scene = match loaded {
            Ok(scene) => scene,
            Err(e) => {
                refused += 1;
                println!("{name}: refused: {e}");
                continue;
            }
        };
        ran += 1;
        let facts = format!(
            "{} parts, {} triangles, {} notices",
            scene.parts.len(),
            scene.triangle_count(),
            scene.notices.len()
        );
        let Some(renderer) = &mut renderer else {
            println!("{name}: {facts}");
            continue;
        };
        let both = full() && name.contains("assemblies");
        for settings in std::iter::once(&compacted).chain(both.then_some(&bucketed)) {
            match judge_picture(renderer, &scene, settings) {
                Ok(counts) => println!("{name}: {facts}; {}: {counts}", settings.capture.kind.name()),
                Err(fault) => faults.push(format!("{name}: {}: {fault}", settings.capture.kind.name())),
            }
            pictures += 1;
        }
    }
    println!("real models: {ran} loaded, {refused} refused, {pictures} pictures");
    if !full() {
        println!("SKIPPED: real models: the k-buffer's pictures of the assemblies (PELLUCID_TEST_FULL draws them)");
    }
    assert!(ran + refused > 0, "{} has no models", folder.display());
    assert!(faults.is_empty(), "{} of {} models:\n{}", faults.len(), ran + refused, faults.join("\n"));
}

/// The caps of a large assembly, as a plane is dragged through it: what a window has to do for every step of the hand.
#[test]
fn a_large_assembly_is_cut_and_closed() {
    let Some(path) = folder().map(|f| f.join("assemblies/CycloidalDrive.glb")).filter(|p| p.is_file()) else {
        println!("SKIPPED: there is no CycloidalDrive.glb");
        return;
    };
    let scene = import::load(&path).unwrap();
    let (bounds, solids) = (scene.bounds(), Solids::of(&scene));
    for (name, normal) in [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)] {
        let mut times = Vec::new();
        let mut caps = 0;
        for step in 1..10 {
            let at = bounds.min + bounds.size() * (f64::from(step) / 10.0) + scene.origin;
            let section = Section { normal, offset: normal.dot(at), enabled: true, caps: true };
            let arrangement = Arrangement { sections: vec![section], ..Arrangement::default() };
            let begin = std::time::Instant::now();
            let cut = Cut::new(&scene, &arrangement, &solids);
            times.push(begin.elapsed().as_secs_f64() * 1e3);
            assert!(cut.open.is_empty(), "{:?}", cut.notices(&scene));
            assert!(cut.caps.iter().all(|c| c.area() > 0.0));
            caps = caps.max(cut.caps.len());
        }
        let triangles = scene.triangle_count();
        println!("{triangles} triangles across {name}: up to {caps} caps, {times:.1?} ms, the first with welding");
        assert!(caps > 3);
    }
}
