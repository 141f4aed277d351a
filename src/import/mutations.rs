//! Thousands of damaged OBJ, STL, PLY and MTL files: any outcome is fine but a panic or a long wait. `fuzz/` does the same
//! guided by coverage; this is the part of it that every run of the tests can afford.

use std::time::{Duration, Instant};

use crate::import::{ImportOptions, Limits, PartsBy, load_bytes_with, load_with};
use crate::scene::Scene;

/// A small generator with a fixed sequence.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

/// How many damaged files of a format are tried.
fn rounds() -> usize {
    let full = std::env::var_os("PELLUCID_TEST_FULL").is_some_and(|v| !v.is_empty() && v != "0");
    if full { 100_000 } else { 4000 }
}

const OBJ: &str = "mtllib m.mtl\no a\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0.5\nv 0.2 0.5 0\nvt 0 0\nvt 1 1\n\
                   vn 0 0 1\nvn 0 1 0\ng x y\nusemtl red\ns 1\nf 1/1/1 2/2/1 3/1/2 4/2/2 5//1\ns off\nf -1 -2 \\\n-3\n\
                   o b\nusemtl blue\nf 1 2 3 4\nl 1 2\np 1\n";
const MTL: &str = "newmtl red\nKd 1 0 0\nKs 0.5 0.5 0.5\nNs 100\nd 0.5\nKe 0 0 2\nmap_Kd -s 1 2 -o 0.5 0 -clamp on c.png\n\
                   map_d c.png\nmap_Bump -bm 0.5 c.png\nmap_Pr c.png\nnewmtl blue\nTr 0.25\nPm 1\nnorm c.png\n";
const STL: &str = "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 1e-3\nendloop\nendfacet\n\
                   facet normal 0 0 1\nouter loop\nvertex 5 0 0\nvertex 6 0 0\nvertex 5 1 0\nendloop\nendfacet\nendsolid\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment TextureFile c.png\nelement vertex 4\nproperty double x\nproperty float y\n\
                   property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\n\
                   property float t\nelement face 2\nproperty list uchar int vertex_indices\nproperty uchar red\n\
                   element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0 1 2 3 0 0\n\
                   1 0 0 1 2 3 0 0\n1 1 0 1 2 3 0 0\n0 1 0 1 2 3 0 0\n4 0 1 2 3 5\n3 0 1 2 5\n5 0 1 2 -1 3\n";

/// Words that mean something, or too much.
const WORDS: &[&str] = &[
    "0",
    "-1",
    "1",
    "3",
    "4294967295",
    "-9223372036854775808",
    "18446744073709551616",
    "1e308",
    "1e-320",
    "nan",
    "-inf",
    "1.#QNAN",
    "f",
    "v",
    "vt",
    "vn",
    "usemtl",
    "o",
    "g",
    "s",
    "\\",
    "#",
    "//",
    "1/1/1",
    "facet",
    "endfacet",
    "vertex",
    "solid",
    "endsolid",
    "list",
    "element vertex 3",
    "element face 9",
    "property float x",
    "property list double double q",
    "uchar",
    "end_header",
    "format binary_little_endian 1.0",
    "newmtl",
    "map_Kd",
    "-s",
    "-imfchan",
    "\r",
    "\n",
    "\0",
    "\u{ff}",
];

fn binary_stl() -> Vec<u8> {
    let mut out = vec![b' '; 80];
    out.extend(8_u32.to_le_bytes());
    for i in 0..8_u8 {
        let floats: [f32; 12] =
            std::array::from_fn(|k| f32::from(i / 4) * 9.0 + ((usize::from(i) * 7 + k * 5) % 11) as f32);
        out.extend(floats.iter().flat_map(|c| c.to_le_bytes()));
        out.extend([0, i]);
    }
    out
}

fn binary_ply(big: bool) -> Vec<u8> {
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let (header, _) = PLY.split_once("end_header\n").expect("a header");
    let mut out = (header.replace("ascii", format) + "end_header\n").into_bytes();
    let mut put = |mut value: Vec<u8>| {
        if big {
            value.reverse();
        }
        out.extend(value);
    };
    for (x, y) in [(0.0_f64, 0.0_f32), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        put(x.to_le_bytes().into());
        [y, 0.0].iter().for_each(|c| put(c.to_le_bytes().into()));
        (0..3).for_each(|c| put(vec![100 + c]));
        [0.5_f32, 0.25].iter().for_each(|c| put(c.to_le_bytes().into()));
    }
    for face in [&[0_i32, 1, 2, 3][..], &[0, 1, 2]] {
        put(vec![face.len() as u8]);
        face.iter().for_each(|v| put(v.to_le_bytes().into()));
        put(vec![5]);
    }
    put(5_i32.to_le_bytes().into());
    [0_i32, 1, 2, -1, 3].iter().for_each(|v| put(v.to_le_bytes().into()));
    out
}

fn damage(random: &mut Random, bytes: &mut Vec<u8>) {
    for _ in 0..=random.below(4) {
        if bytes.is_empty() {
            return;
        }
        let at = random.below(bytes.len());
        match random.below(9) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.below(256) as u8,
            2 => bytes.truncate(at),
            3 => {
                bytes.remove(at);
            }
            // A word over whatever stands there, or between.
            4 | 5 => {
                let word = WORDS[random.below(WORDS.len())].as_bytes();
                let end = (at + random.below(2) * word.len()).min(bytes.len());
                bytes.splice(at..end, word.iter().copied());
            }
            // A word for a word.
            6 => {
                let start = bytes[..at].iter().rposition(u8::is_ascii_whitespace).map_or(0, |i| i + 1);
                let end = bytes[at..].iter().position(u8::is_ascii_whitespace).map_or(bytes.len(), |i| at + i);
                bytes.splice(start..end.max(start), WORDS[random.below(WORDS.len())].bytes());
            }
            // A piece again, somewhere else.
            7 => {
                let end = (at + 1 + random.below(60)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            // A number of four bytes.
            _ if at + 4 <= bytes.len() => {
                let value = [0, 1, 5, 255, 65_536, u32::MAX, 1 << 31][random.below(7)];
                bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            }
            _ => {}
        }
    }
}

fn options(random: &mut Random) -> ImportOptions {
    let limits = Limits {
        bytes: 1 << 20,
        vertices: 1 << 12,
        triangles: 1 << 12,
        image_side: 64,
        image_pixels: 1 << 12,
        parts: 8,
        ..Limits::default()
    };
    let parts = [None, Some(PartsBy::Node), Some(PartsBy::Material), Some(PartsBy::Component), Some(PartsBy::File)];
    ImportOptions { limits, parts: parts[random.below(5)], ..ImportOptions::default() }
}

/// All that a finished scene promises.
fn check(scene: &Scene) {
    for primitive in scene.meshes.iter().flat_map(|m| &m.primitives) {
        let count = primitive.positions.len();
        assert!(!primitive.triangles.is_empty());
        assert!(primitive.triangles.as_flattened().iter().all(|&v| (v as usize) < count));
        assert!(primitive.positions.iter().chain(&primitive.normals).flatten().all(|c| c.is_finite()));
        assert!(primitive.tangents.iter().flatten().all(|c| c.is_finite()));
        assert!(primitive.colors.iter().flatten().all(|c| (0.0..=1.0).contains(c)));
        assert!(primitive.uvs.iter().flatten().flatten().all(|c| c.is_finite()));
        assert!(primitive.material < scene.materials.len());
        let [a, b] = [primitive.uvs[0].len(), primitive.uvs[1].len()];
        for length in [primitive.tangents.len(), a, b, primitive.colors.len()] {
            assert!(length == 0 || length == count);
        }
        assert_eq!(primitive.normals.len(), count);
    }
    for material in &scene.materials {
        assert!(material.base_color.iter().chain(&material.emissive).all(|c| c.is_finite()), "{material:?}");
        assert!(material.metallic.is_finite() && material.roughness.is_finite() && material.normal_scale.is_finite());
        for reference in material.texture_refs() {
            assert!(scene.textures[reference.texture].image < scene.images.len() && reference.uv_set == 0);
            assert!(reference.uv_transform.iter().flatten().all(|c| c.is_finite()), "{reference:?}");
        }
    }
    assert!(scene.parts.iter().all(|p| p.world_from_part.is_finite()));
    assert!(!scene.partition.is_empty());
}

fn torture(seed: u64, good: &[Vec<u8>], extension: &str) {
    let mut random = Random(seed);
    let (mut loaded, mut longest) = (0, Duration::ZERO);
    for bytes in good {
        check(&load_bytes_with(bytes, &format!("a.{extension}"), None, &ImportOptions::default()).expect("a scene"));
    }
    let rounds = rounds();
    for _ in 0..rounds {
        let mut bytes = good[random.below(good.len())].clone();
        damage(&mut random, &mut bytes);
        let name = if random.below(4) == 0 { "a".to_owned() } else { format!("a.{extension}") };
        let begin = Instant::now();
        if let Ok(scene) = load_bytes_with(&bytes, &name, None, &options(&mut random)) {
            check(&scene);
            loaded += 1;
        }
        longest = longest.max(begin.elapsed());
    }
    println!("{extension}: {loaded} of {rounds} were harmless enough to load, the slowest took {longest:?}");
    assert!(loaded > rounds / 20, "{loaded} of {rounds}");
    assert!(longest < Duration::from_secs(10), "{longest:?}");
}

#[test]
fn damaged_obj_files_never_panic() {
    torture(1, &[OBJ.into()], "obj");
}

#[test]
fn damaged_stl_files_never_panic() {
    torture(2, &[STL.into(), binary_stl()], "stl");
}

#[test]
fn damaged_ply_files_never_panic() {
    torture(3, &[PLY.into(), binary_ply(false), binary_ply(true)], "ply");
}

#[test]
fn damaged_material_files_never_panic() {
    let folder = tempfile::tempdir().expect("a folder");
    let pixels = (0..16).flat_map(|i| [i * 9, 100, 200, 255 - i]).collect();
    let image = image::RgbaImage::from_raw(4, 4, pixels).expect("an image");
    image.save(folder.path().join("c.png")).expect("written");
    let model = folder.path().join("a.obj");
    std::fs::write(&model, OBJ).expect("written");
    let mut random = Random(4);
    let mut textured = 0;
    let rounds = rounds() / 4;
    for _ in 0..rounds {
        let mut bytes = MTL.as_bytes().to_vec();
        damage(&mut random, &mut bytes);
        std::fs::write(folder.path().join("m.mtl"), &bytes).expect("written");
        // Only size and number of images can be over a limit.
        if let Ok(scene) = load_with(&model, &options(&mut random)) {
            check(&scene);
            textured += usize::from(!scene.images.is_empty());
        }
    }
    assert!(textured > rounds / 2, "{textured} of {rounds}");
}
