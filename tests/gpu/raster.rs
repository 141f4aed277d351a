//! The capture against the oracle's rasterizer: which fragments each pixel has, in which order, and what they carry.

use pellucid::math::Camera;
use pellucid::oracle::{Layers, compare};
use pellucid::render::StoreReadback;
use pellucid::scene::Scene;
use pellucid::settings::{CaptureKind, Settings};

use crate::stages::report;

/// Radians that a smooth normal of these tests' scenes turns over a pixel, at most.
const TURN: f64 = 0.5;

/// Raster: the fragments of every pixel.
pub fn check_capture(
    what: &str,
    scene: &Scene,
    camera: &Camera,
    layers: &Layers,
    store: &StoreReadback,
    settings: &Settings,
) {
    let bkb = settings.capture.kind == CaptureKind::BucketedKBuffer;
    let k = if bkb { settings.capture.bucketed_k_buffer.k as usize } else { usize::MAX };
    let found = compare::capture(scene, camera, layers, &store.layers, k, (settings.capture.normals, TURN));
    println!("{what}: worst normal off by {:.4}°", found.worst.to_degrees());
    report(&format!("{what}, capture"), &found);
}
