//! How much memory hostile files take: a few hundred bytes that stand for gigabytes, read under small limits.
//!
//! The peak is measured by an allocator that counts, so these tests have a binary of their own and run one after another.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use pellucid::import::{ImportError, ImportOptions, Limits, load_bytes_with};
use serde_json::{Value, json};

struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn grow(bytes: usize) {
    let now = NOW.fetch_add(bytes, Ordering::Relaxed) + bytes;
    PEAK.fetch_max(now, Ordering::Relaxed);
}

// SAFETY: every request goes to the system's allocator as it is; counting touches nothing of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: the caller keeps `alloc`'s contract, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A GLB of a JSON and a binary chunk.
fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut file = b"glTF".to_vec();
    for word in [2, 28 + text.len() + binary.len(), text.len()] {
        file.extend((word as u32).to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(text);
    file.extend((binary.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}

fn document(mut more: Value) -> Value {
    let mut document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    });
    for (name, value) in more.as_object_mut().into_iter().flatten() {
        document[name] = value.take();
    }
    document
}

const MEGABYTE: usize = 1 << 20;

fn limits() -> Limits {
    Limits {
        bytes: 4 << 20,
        vertices: 1 << 16,
        triangles: 1 << 16,
        image_side: 1024,
        image_pixels: 1 << 20,
        node_depth: 64,
        instances: 1 << 10,
        ..Limits::default()
    }
}

/// Reads the file and gives the peak of what it took, in bytes.
fn peak(bytes: &[u8]) -> (usize, Result<(), ImportError>) {
    let options = ImportOptions { limits: limits(), ..ImportOptions::default() };
    let before = NOW.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    let outcome = load_bytes_with(bytes, "bomb", None, &options).map(|_| ());
    (PEAK.load(Ordering::Relaxed).saturating_sub(before), outcome)
}

/// A PNG of one colour, which packs to almost nothing.
fn picture(side: u32) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image::DynamicImage::new_luma8(side, side).write_to(&mut out, image::ImageFormat::Png).expect("a PNG");
    out.into_inner()
}

fn ktx2(side: u32, unpacked: u64) -> Vec<u8> {
    let mut file = vec![0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, b'\r', b'\n', 0x1A, b'\n'];
    for word in [0, 1, side, side, 0, 0, 1, 1, 2, 104, 44, 0, 0, 0, 0, 0, 0] {
        file.extend(u32::to_le_bytes(word));
    }
    for word in [148, 20, unpacked] {
        file.extend(word.to_le_bytes());
    }
    file.resize(168, 0);
    file
}

fn meshopt(count: u64, stride: u64, mode: &str) -> Vec<u8> {
    let length = count * stride;
    let stream = json!({"buffer": 0, "byteLength": 200, "byteStride": stride, "count": count, "mode": mode});
    let json = document(json!({
        "extensionsUsed": ["EXT_meshopt_compression"],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
        "bufferViews": [{"buffer": 1, "byteLength": length, "extensions": {"EXT_meshopt_compression": stream}}],
        "buffers": [
            {"byteLength": 200},
            {"byteLength": length, "extensions": {"EXT_meshopt_compression": {"fallback": true}}},
        ],
    }));
    glb(&json, &[0xA0; 200])
}

fn shown(image: &[u8], kind: &str) -> Vec<u8> {
    let json = document(json!({
        "accessors": [{"componentType": 5126, "type": "VEC3", "count": 3}],
        "images": [{"bufferView": 0, "mimeType": kind}],
        "bufferViews": [{"buffer": 0, "byteLength": image.len()}],
        "buffers": [{"byteLength": image.len()}],
    }));
    glb(&json, image)
}

/// A Draco stream of a grid, its triangles and vertices far more than its accessors say.
fn draco(side: u32, count: u64) -> Vec<u8> {
    use draco_core::{DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, PointIndex};
    let mut mesh = draco_core::Mesh::new();
    let points = (side + 1) * (side + 1);
    mesh.set_num_points(points as usize);
    let mut position = draco_core::PointAttribute::new();
    position.init(GeometryAttributeType::Position, 3, DataType::Float32, false, points as usize);
    let at = |i: u32| [(i % (side + 1)) as f32, (i / (side + 1)) as f32, 0.0];
    let bytes: Vec<u8> = (0..points).flat_map(at).flat_map(f32::to_le_bytes).collect();
    position.buffer_mut().write(0, &bytes);
    let position = mesh.add_attribute(position);
    mesh.set_num_faces(2 * (side * side) as usize);
    for square in 0..side * side {
        let a = square / side * (side + 1) + square % side;
        let (b, c) = (a + 1, a + side + 1);
        mesh.set_face(FaceIndex(2 * square), [a, b, c].map(PointIndex));
        mesh.set_face(FaceIndex(2 * square + 1), [b, c + 1, c].map(PointIndex));
    }
    let mut options = EncoderOptions::new();
    options.set_attribute_quantization(position, 11);
    let mut out = EncoderBuffer::new();
    let mut encoder = draco_core::MeshEncoder::new();
    encoder.set_mesh(mesh);
    encoder.encode(&options, &mut out).expect("a stream");
    let inside = json!({"bufferView": 0, "attributes": {"POSITION": position}});
    let json = document(json!({
        "extensionsUsed": ["KHR_draco_mesh_compression"],
        "accessors": [
            {"componentType": 5126, "type": "VEC3", "count": count},
            {"componentType": 5125, "type": "SCALAR", "count": 3},
        ],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0}, "indices": 1, "extensions": {"KHR_draco_mesh_compression": inside},
        }]}],
        "bufferViews": [{"buffer": 0, "byteLength": out.data().len()}],
        "buffers": [{"byteLength": out.data().len()}],
    }));
    glb(&json, out.data())
}

#[test]
fn hostile_files_stay_within_a_few_times_their_limits() {
    let empty = |more: Value| glb(&document(more), &[0; 4]);
    let zeros = |count: u64| json!([{"componentType": 5126, "type": "VEC3", "count": count}]);
    let nested = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
    let shared: Vec<Value> = vec![json!({"attributes": {"POSITION": 0}}); 10_000];
    let chain: Vec<Value> = (1..5000).map(|i| json!({"children": [i]})).chain([json!({})]).collect();
    let instances = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}});
    let bombs: [(&str, Vec<u8>); 16] = [
        ("a stream of 16 GiB of vertices", meshopt(1 << 26, 256, "ATTRIBUTES")),
        ("a stream of 2^40 indices", meshopt(3 << 40, 4, "TRIANGLES")),
        ("a stream of vertices that is cut off", meshopt(10_000, 256, "ATTRIBUTES")),
        ("a stream of indices that is cut off", meshopt(900_000, 4, "INDICES")),
        ("a Draco stream of more than it says", draco(250, 3)),
        ("a Draco stream over the limit", draco(300, 90_601)),
        ("an accessor of 2^40 elements", empty(json!({"accessors": zeros(1 << 40)}))),
        ("an accessor of zeros at the limit", empty(json!({"accessors": zeros(1 << 16)}))),
        (
            "one accessor in 10 000 primitives",
            empty(json!({"accessors": zeros(60_000), "meshes": [{"primitives": shared}]})),
        ),
        ("a picture of 12 000 pixels a side", shown(&picture(12_000), "image/png")),
        ("a picture at the limit", shown(&picture(1024), "image/png")),
        ("a KTX2 file of 2^31 pixels a side", shown(&ktx2(1 << 31, 1 << 60), "image/ktx2")),
        ("a KTX2 file that unpacks to 2^60 bytes", shown(&ktx2(64, 1 << 60), "image/ktx2")),
        (
            "a million instances",
            empty(json!({
                "accessors": zeros(1_000_000), "nodes": [{"mesh": 0, "extensions": instances}],
                "extensionsUsed": ["EXT_mesh_gpu_instancing"],
            })),
        ),
        ("nodes 5000 deep", empty(json!({"accessors": zeros(3), "nodes": chain}))),
        ("lists 100 000 deep", format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":{nested}}}").into_bytes()),
    ];
    // The threads and tables that everything needs are there before anything is measured.
    let _ = peak(&shown(&picture(4), "image/png"));
    let mut wrong = Vec::new();
    for (name, bytes) in &bombs {
        let (peak, outcome) = peak(bytes);
        // Twice what the limits add up to: 4 MiB of buffers, 2^16 vertices of 100 bytes, 2^20 pixels of 16 bytes.
        let most = 2 * (4 + 7 + 16) * MEGABYTE;
        println!("{name}: {:.1} MiB of a file of {:.1}, {outcome:?}", mib(peak), mib(bytes.len()));
        if peak > most {
            wrong.push(format!("{name}: {:.1} MiB", mib(peak)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn mib(bytes: usize) -> f64 {
    bytes as f64 / MEGABYTE as f64
}
