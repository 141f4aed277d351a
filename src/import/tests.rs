//! The shared models: every model of a format that is read loads, or is refused as expected.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use crate::import::{ImportOptions, Phase, Progress, load, load_bytes_with, load_with};
use crate::scene::{NoticeKind, Scene};

/// What is refused, and what the error must name.
const REFUSED: &[(&str, &str)] = &[
    ("malformed/glb__chunk_too_big.glb", "GLB header"),
    ("malformed/glb__invalid_magic.glb", "neither a GLB"),
    ("malformed/glb__truncated_chunk_data.glb", "GLB header"),
    ("malformed/glb__length_mismatch.glb", "GLB header"),
    ("malformed/glb__empty_file.glb", "is empty"),
    ("malformed/glb__only_header.glb", "no JSON chunk"),
    ("malformed/json__invalid_syntax.gltf", "JSON"),
    ("malformed/mesh_data__index_buffer_oob.gltf", "buffers[0].uri"),
    ("malformed/node__node_loop.gltf", "nodes[0]"),
    ("malformed/buffer__wrong_bytelength.glb", "buffers[0].byteLength"),
    ("malformed/buffer__not_found.gltf", "buffers[0].uri"),
    ("malformed/image__invalid_image_data.gltf", "images[0].uri"),
    ("malformed/accessor__unresolved_bufferviews.gltf", "accessors[0].bufferView"),
    ("malformed/IndexOutOfRange.gltf", "meshes[0].primitives[0].indices"),
    ("malformed/malformed.obj", "line 23: vertex 12 does not exist: 8 come before this line"),
    ("malformed/empty.stl", "an STL file without triangles"),
];

/// What loads with a notice: its kind and a part of it.
const TOLD: &[(&str, NoticeKind, &str)] = &[
    ("malformed/KHR_materials_volume__material__out_of_range.gltf", NoticeKind::Repaired, "thicknessFactor"),
    ("malformed/asset__2_1_version.gltf", NoticeKind::Approximated, "2.1"),
    ("malformed/mesh__primitive_no_position.gltf", NoticeKind::Ignored, "no positions"),
    ("malformed/BoxWithInfinites.glb", NoticeKind::Repaired, "not finite"),
    ("conformance/primitive_modes/Mesh_PrimitiveMode_00.gltf", NoticeKind::Ignored, "points or lines"),
    ("conformance/RiggedSimple.glb", NoticeKind::Ignored, "skins"),
    ("conformance/AnimatedMorphCube.glb", NoticeKind::Ignored, "morph targets"),
    ("conformance/TriangleWithoutIndices.gltf", NoticeKind::Computed, "without normals"),
    ("materials/CompareTransmission.glb", NoticeKind::Approximated, "KHR_materials_transmission"),
];

/// Instanced triangles, as the manifest gives them.
const TRIANGLES: &[(&str, u64)] = &[
    ("assemblies/2CylinderEngine.glb", 121_496),
    ("conformance/2CylinderEngine_draco/2CylinderEngine.gltf", 110_336),
    ("conformance/Ingenuity.glb", 9_060),
    ("assemblies/CycloidalDrive.glb", 376_520),
    ("assemblies/FrankaPanda.glb", 134_912),
    ("assemblies/SO100Arm.glb", 60_682),
    ("assemblies/RodBearing.glb", 57_036),
    ("assemblies/CesiumMilkTruck.glb", 3624),
    ("conformance/CycloidalDrive_quantized.glb", 376_520),
    ("conformance/SimpleSparseAccessor.gltf", 12),
    ("conformance/primitive_modes/Mesh_PrimitiveMode_04.gltf", 2),
    ("conformance/primitive_modes/Mesh_PrimitiveMode_05.gltf", 2),
    ("conformance/primitive_modes/Mesh_PrimitiveMode_06.gltf", 2),
    ("materials/CompareAnisotropy.glb", 36_864),
    ("flow/StreamSurfaceA.glb", 29_782),
    ("obj/spot.obj", 5856),
    ("obj/spider/spider.obj", 1368),
    ("obj/teapot.obj", 25_200),
    ("stl_ply/ADIS16480.STL", 7436),
    ("stl_ply/featuretype.STL", 3476),
    ("stl_ply/cycloidal.ply", 43_368),
    ("stl_ply/Spider_ascii.stl", 1368),
];

/// Parts, and what the sentence about them says.
const PARTS: &[(&str, usize, &str)] = &[
    ("obj/spot.obj", 1, "connected components"),
    ("obj/spider/spider.obj", 19, "the file's nodes: the file names objects or groups"),
    ("stl_ply/featuretype.STL", 1, "connected components: an STL file is one mesh"),
    ("stl_ply/cycloidal.ply", 100, "connected components: a PLY file is one mesh"),
];

pub(super) fn models() -> Option<PathBuf> {
    let folder = std::env::var_os("PELLUCID_MODELS")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models"), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("SKIPPED: no models in {} (PELLUCID_MODELS names another folder)", folder.display());
    None
}

fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            walk(&path, found);
        } else {
            let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
            if ["glb", "gltf", "obj", "stl", "ply"].contains(&extension.as_str()) {
                found.push(path);
            }
        }
    }
}

#[test]
fn every_shared_model_loads_or_is_refused_as_expected() {
    let Some(folder) = models() else { return };
    let mut files = Vec::new();
    walk(&folder, &mut files);
    files.sort();
    let (mut loaded, mut refused, mut wrong) = (0, 0, Vec::new());
    for path in &files {
        let name = path.strip_prefix(&folder).unwrap_or(path).to_string_lossy().replace('\\', "/");
        let expected = REFUSED.iter().find(|(file, _)| *file == name).map(|(_, part)| *part);
        match (load(path), expected) {
            (Err(e), Some(part)) if e.to_string().contains(part) => refused += 1,
            (Err(e), _) => wrong.push(format!("{name}: {e}")),
            (Ok(_), Some(part)) => wrong.push(format!("{name} loads, and should name {part}")),
            (Ok(scene), None) => {
                loaded += 1;
                let told = |kind, part: &str| scene.notices.iter().any(|n| n.kind == kind && n.message.contains(part));
                for (_, kind, part) in TOLD.iter().filter(|t| t.0 == name && !told(t.1, t.2)) {
                    wrong.push(format!("{name}: no {kind:?} notice about {part:?} among {:?}", scene.notices));
                }
                // Triangles without area are dropped, so a file may lose a few.
                let dropped: u64 = scene
                    .notices
                    .iter()
                    .filter_map(|n| n.message.split_once(" triangles without area")?.0.parse::<u64>().ok())
                    .sum();
                let count = scene.triangle_count();
                for (_, n) in TRIANGLES.iter().filter(|t| t.0 == name) {
                    if count > *n || (count < *n && dropped == 0) {
                        wrong.push(format!("{name}: {count} triangles instead of {n}"));
                    }
                }
                for (_, n, part) in PARTS.iter().filter(|t| t.0 == name) {
                    if scene.parts.len() != *n || !scene.partition.contains(part) {
                        wrong.push(format!("{name}: {} parts instead of {n}: {}", scene.parts.len(), scene.partition));
                    }
                }
                if scene.bounds().is_empty() != scene.parts.is_empty() || !scene.bounds().size().is_finite() {
                    wrong.push(format!("{name}: bounds {:?}", scene.bounds()));
                }
                println!("{name}: {} parts, {count} triangles, {:?}", scene.parts.len(), scene.notices);
            }
        }
    }
    println!("{loaded} loaded, {refused} refused as expected");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(loaded + refused > 0, "no model in {}", folder.display());
}

const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const STL: &[u8] = b"solid\nfacet normal 0 0 1\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendfacet\nendsolid\n";
const PLY: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                     element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const GLTF: &[u8] = br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;

/// What a scene is, but for its name and what is told about it.
fn shape(scene: &Scene) -> (u64, u64) {
    (scene.digest(), scene.triangle_count())
}

#[test]
fn every_format_is_read_without_a_name_mapped_or_not_and_tells_its_phases_in_order() {
    let folder = tempfile::tempdir().expect("a folder");
    for (extension, bytes) in [("obj", OBJ), ("stl", STL), ("ply", PLY), ("gltf", GLTF)] {
        let nameless = load_bytes_with(bytes, "-", None, &ImportOptions::default()).expect(extension);
        assert_eq!(nameless.triangle_count(), 1, "{extension}");
        assert!(!nameless.partition.is_empty(), "{extension}");
        // A name that lies changes nothing.
        let path = folder.path().join(format!("{extension}.unknown"));
        std::fs::write(&path, bytes).expect("written");
        let phases: Arc<Mutex<Vec<Phase>>> = Arc::default();
        let told = phases.clone();
        let progress = Progress::to(move |phase, done| {
            assert!((0.0..=1.0).contains(&done));
            told.lock().expect("not poisoned").push(phase);
        });
        let options = ImportOptions { map_from: 1, progress, ..ImportOptions::default() };
        let mapped = load_with(&path, &options).expect(extension);
        assert_eq!(shape(&mapped), shape(&nameless), "{extension}");
        let phases = phases.lock().expect("not poisoned");
        assert!(phases.is_sorted(), "{extension}: {phases:?}");
        for phase in [Phase::Reading, Phase::Parsing, Phase::Geometry, Phase::Parts, Phase::Finishing] {
            assert!(phases.contains(&phase), "{extension}: {phase:?} is missing");
        }
    }
}
