//! T28 over everything there is: linked lists, compacted lists and a k-buffer, to its first 64 layers, are three structures for one
//! set of fragments. Their stores are equal bit for bit, and so are the pictures of every opacity model over them, on the built-in
//! scenes and on the models of the folder that `PELLUCID_MODELS` names, or `../shared/models`.

use std::path::{Path, PathBuf};

use glam::DVec3;
use pellucid::math::Camera;
use pellucid::render::{GpuScene, RenderError, Renderer};
use pellucid::scene::{Scene, builtin};
use pellucid::settings::{BaseOpacity, OpacityModel};

use crate::common::*;

const SIZE: [u32; 2] = [64, 64];

/// Most layers that the k-buffer holds.
const MOST: usize = 64;

/// What a sampled run looks at.
const SAMPLED: [&str; 5] =
    ["stack", "touching", "hard/contact", "assemblies/RodBearing.glb", "conformance/BoxTextured.glb"];

fn is_wanted(name: &str) -> bool {
    full() || SAMPLED.contains(&name)
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap().map(Result::unwrap) {
            let path = entry.path();
            let ending = path.extension().map(|e| e.to_ascii_lowercase().to_string_lossy().into_owned());
            match ending.as_deref() {
                _ if path.is_dir() => folders.push(path),
                Some("glb" | "gltf" | "obj" | "stl" | "ply") => all.push(path),
                _ => {}
            }
        }
    }
    all.sort();
    all
}

/// Every scene by its name, or why there is none.
fn scenes() -> Vec<(String, Result<Scene, String>)> {
    let mut all: Vec<(String, Result<Scene, String>)> = builtin::names()
        .iter()
        .filter(|b| is_wanted(b.name))
        .map(|b| (b.name.to_owned(), builtin::build(b.name).map_err(|e| e.to_string())))
        .collect();
    let named = std::env::var_os("PELLUCID_MODELS").filter(|v| !v.is_empty()).map(PathBuf::from);
    let folder = named.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models"));
    if !folder.is_dir() {
        println!("SKIPPED: captures on real models: there is no folder {}", folder.display());
        return all;
    }
    for path in files(&folder) {
        let name = path.strip_prefix(&folder).unwrap().display().to_string();
        if is_wanted(&name) {
            all.push((name, pellucid::import::load(&path).map_err(|e| e.to_string())));
        }
    }
    all
}

/// Every opacity model, with what it can begin with.
fn models() -> Vec<String> {
    let mut all: Vec<String> = OpacityModel::ALL.iter().map(|m| format!("model={}", m.name())).collect();
    if full() {
        let base = |b: &BaseOpacity| format!("model=illustrative opacity.illustrative.base={}", b.name());
        all.extend(BaseOpacity::ALL.iter().map(base));
    }
    all
}

/// The first thing in which two shots differ, if any.
fn difference(a: &Shot, b: &Shot) -> Option<String> {
    fn first<T: PartialEq>(
        what: &str,
        a: impl IntoIterator<Item = T>,
        b: impl IntoIterator<Item = T>,
    ) -> Option<String> {
        let (a, b): (Vec<T>, Vec<T>) = (a.into_iter().collect(), b.into_iter().collect());
        let differing = a.iter().zip(&b).filter(|(a, b)| a != b).count() + a.len().abs_diff(b.len());
        (differing > 0).then(|| format!("{what}: {differing} of {}", a.len()))
    }
    let (s, t) = (&a.store, &b.store);
    let bits = |values: &[[f32; 4]]| values.iter().map(|v| v.map(f32::to_bits)).collect::<Vec<_>>();
    first("counts", &s.layers.counts, &t.layers.counts)
        .or_else(|| first("stored words", &s.words, &t.words))
        .or_else(|| first("parts", &s.layers.part, &t.layers.part))
        .or_else(|| first("links", &s.links, &t.links))
        .or_else(|| first("kappa", a.kappa_bits(), b.kappa_bits()))
        .or_else(|| first("fields", bits(&s.fields), bits(&t.fields)))
        .or_else(|| first("lit colours", bits(&s.lit), bits(&t.lit)))
        .or_else(|| first("pixels", a.bits(), b.bits()))
}

/// Where a k-buffer is too small for some pixels: the first layers that it keeps of each.
fn first_layers_differ(exact: &Shot, rows: &Shot) -> Option<String> {
    let pixels = 0..exact.store.layers.counts.len();
    let wrong = pixels.filter(|&pixel| {
        let (a, b) = (exact.store.layers.range(pixel), rows.store.layers.range(pixel));
        b.len() != a.len().min(MOST)
            || exact.store.words[a.start..a.start + b.len()] != rows.store.words[b]
            || rows.store.layers.overflowed[pixel] != (a.len() > MOST)
    });
    let wrong = wrong.count();
    (wrong > 0).then(|| format!("the first {MOST} layers of {wrong} pixels"))
}

/// What came of a scene.
struct Judged {
    layers: usize,
    deepest: usize,
    /// Pictures that were compared.
    compared: usize,
    faults: Vec<String>,
}

/// Compares all captures of a scene through all models.
fn judge(r: &mut Renderer, loaded: &GpuScene, camera: &Camera) -> Result<Judged, RenderError> {
    let mut faults = Vec::new();
    let mut compared = 0;
    let take = |r: &mut Renderer, row: &str| Shot::of(r, loaded, camera, &with_transfer(settings(row), lively()), SIZE);
    let counted = take(r, "model=constant")?;
    let deepest = counted.frame.report.layers.deepest as usize;
    let k = deepest.clamp(1, MOST);
    let rows = take(r, &format!("model=constant kind=bkb k={k}"))?;
    faults.extend(first_layers_differ(&counted, &rows).filter(|_| deepest > MOST));
    for model in models() {
        let exact = take(r, &model)?;
        let mut captures = vec!["kind=lists".to_owned()];
        if model == "model=constant" {
            captures.push("kind=lists sort=selection".to_owned());
        }
        if deepest <= MOST {
            captures.push(format!("kind=bkb k={k}"));
        }
        for capture in captures {
            let other = take(r, &format!("{model} {capture}"))?;
            faults.extend(difference(&exact, &other).map(|what| format!("{model} {capture}: {what}")));
            compared += 1;
        }
    }
    Ok(Judged { layers: counted.store.layers.len(), deepest, compared, faults })
}

#[test]
fn t28_captures_agree_through_every_model_on_every_scene() {
    let Some(mut r) = renderer() else { return };
    let (mut faults, mut drawn, mut deeper, mut compared) = (Vec::new(), 0, 0, 0);
    for (name, scene) in scenes() {
        let scene = match scene {
            Ok(scene) => scene,
            // What is malformed has to be refused.
            Err(e) if name.starts_with("malformed/") => {
                println!("{name}: {e}");
                continue;
            }
            Err(e) => {
                println!("SKIPPED: captures on {name}: {e}");
                continue;
            }
        };
        let direction = DVec3::new(-0.52, -0.42, -0.74);
        let camera = Camera::framing(&scene.bounds(), direction, DVec3::Y, 1.0, 0.9, false, 30_f64.to_radians());
        let judged = r.load(&scene).and_then(|loaded| judge(&mut r, &loaded, &camera));
        match judged {
            Ok(judged) => {
                let Judged { layers, deepest, compared: pictures, .. } = judged;
                let differ = judged.faults.len();
                println!("{name}: {layers} layers, {deepest} deep, {pictures} pictures compared, {differ} differ");
                drawn += 1;
                deeper += usize::from(deepest > MOST);
                compared += pictures;
                faults.extend(judged.faults.into_iter().map(|fault| format!("{name}: {fault}")));
            }
            Err(e) => println!("SKIPPED: captures on {name}: {e}"),
        }
    }
    println!("{drawn} scenes, {deeper} of them deeper than {MOST}, {compared} pictures compared");
    if !full() {
        println!("SKIPPED: captures on all scenes and models (PELLUCID_TEST_FULL compares them)");
    }
    assert!(drawn >= 3, "only {drawn} scenes");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
