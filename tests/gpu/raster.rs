//! The capture against the oracle's rasterizer: which fragments each pixel has, in which order, and what they carry.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec3};
use pellucid::math::Camera;
use pellucid::oracle::{Fragment, Layers, StoreData};
use pellucid::render::StoreReadback;
use pellucid::scene::Scene;
use pellucid::settings::{NormalEncoding, Settings};

use crate::common::*;
use crate::stages::{encoded, report};

/// Change of depth per pixel along x and y, of the plane of every triangle.
struct Slopes(HashMap<u32, (DVec3, f64)>);

impl Slopes {
    fn new(scene: &Scene, camera: &Camera) -> Slopes {
        let mut planes = HashMap::new();
        for part in &scene.parts {
            let view_from_part = camera.view_from_world() * part.world_from_part;
            let mut number = part.first_triangle;
            for primitive in &scene.meshes[part.mesh].primitives {
                for t in &primitive.triangles {
                    let [a, b, c] = t.map(|i| {
                        view_from_part.transform_point3(Vec3::from(primitive.positions[i as usize]).as_dvec3())
                    });
                    let n = (b - a).cross(c - a).normalize_or_zero();
                    planes.insert(number, (n, n.dot(a)));
                    number += 1;
                }
            }
        }
        Slopes(planes)
    }

    /// How far depth may be off where vertices snap to 1/256 pixel, and a few steps of an f32 (of a depth of that
    /// size: a parallel depth is as precise as the whole range).
    fn tolerance(&self, triangle: u32, point: DVec3, pixel: DVec2, perspective: bool) -> f64 {
        let (n, _) = self.0[&triangle];
        let sight = if perspective { point / -point.z } else { DVec3::NEG_Z };
        let facing = n.dot(sight).abs().max(1e-9);
        let slope = (n.x.abs() * pixel.x + n.y.abs() * pixel.y) / facing;
        slope / 256.0 + 1e-6 * -point.z
    }
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * ((a - b).length() * 0.5).min(1.0).asin()
}

/// One stored surface against the oracle's.
fn check_surface(at: &str, s: &StoreData, i: usize, f: &Fragment, depth_by: f64, normal_by: f64, worst: &mut f64) {
    assert_eq!((s.part[i], s.side[i]), (f.part, f.side), "{at}: triangle {}", f.triangle);
    let depths = [s.depth[i], f.depth];
    assert!((depths[0] - depths[1]).abs() <= depth_by, "{at}: depths {depths:?} may differ by {depth_by}");
    let off = angle(Vec3::from(s.normal[i]).as_dvec3().normalize(), f.normal_in_view);
    *worst = worst.max(off);
    // A smooth normal turns as the sample moves on its facet: by less than half a radian a pixel here.
    assert!(off < normal_by + 0.5 / 256.0, "{at}: normal off by {off}");
    let near = |a: f32, b: f64, by: f64| (f64::from(a) - b).abs() <= by;
    let c = f.surface.base_color;
    for j in 0..3 {
        let (found, expected) = (encoded(f64::from(s.base_color[i][j])), encoded(c[j]));
        assert!((found - expected).abs() <= 1.0 / 255.0, "{at}: {:?} {c:?}", s.base_color[i]);
        assert!(near(s.emissive[i][j], f.surface.emissive[j], 2e-3), "{at}: emissive");
    }
    assert!(near(s.base_color[i][3], c[3], 1.0 / 255.0), "{at}: alpha");
    let eight = 0.51 / 255.0;
    assert!(near(s.metallic[i], f.surface.metallic, eight) && near(s.roughness[i], f.surface.roughness, eight), "{at}");
    assert!(near(s.occlusion[i], f.surface.occlusion, eight) && s.unlit[i] == f.surface.unlit, "{at}");
}

/// Raster: the fragments of every pixel.
pub fn check_capture(
    what: &str,
    scene: &Scene,
    camera: &Camera,
    layers: &Layers,
    store: &StoreReadback,
    settings: &Settings,
) {
    let s = &store.layers;
    let view = view_of(camera, [s.width, s.height]);
    let slopes = Slopes::new(scene, camera);
    let bkb = settings.capture.kind == pellucid::settings::CaptureKind::BucketedKBuffer;
    let k = if bkb { settings.capture.bucketed_k_buffer.k as usize } else { usize::MAX };
    let encoding = match settings.capture.normals {
        NormalEncoding::Octahedral => 0.0001,
        NormalEncoding::Xy15 => 0.0095,
    };
    let (mut ambiguous, mut fragments, mut worst_normal) = (0, 0, 0.0_f64);
    for (pixel, expected) in layers.pixels.iter().enumerate() {
        fragments += expected.fragments.len();
        let tolerance =
            |f: &Fragment| slopes.tolerance(f.triangle, f.position_in_view, view.pixel_size(f.depth), view.perspective);
        let at = || format!("{what}, pixel {:?}", s.xy(pixel));
        let range = s.range(pixel);
        let mut last: Option<&Fragment> = None;
        for i in range.clone() {
            let Some(f) = expected.fragments.iter().find(|f| f.triangle == s.triangle[i]) else {
                assert!(expected.ambiguous, "{}: triangle {} is not there", at(), s.triangle[i]);
                ambiguous += 1;
                continue;
            };
            // Snapping may swap two surfaces that are as close as the depth of either may be off.
            if let Some(nearer) = last.replace(f)
                && (nearer.depth_key, nearer.triangle) > (f.depth_key, f.triangle)
            {
                assert!(nearer.depth - f.depth <= tolerance(nearer) + tolerance(f), "{}: order", at());
                ambiguous += 1;
            }
            if f.ambiguous {
                continue;
            }
            check_surface(&at(), s, i, f, tolerance(f), encoding, &mut worst_normal);
        }
        ambiguous += expected.fragments.iter().filter(|f| f.ambiguous).count();
        let there = |f: &Fragment| s.triangle[range.clone()].contains(&f.triangle);
        for (layer, f) in expected.fragments.iter().enumerate() {
            let cut = layer >= k || (s.overflowed[pixel] && s.counts[pixel] as usize == k);
            assert!(f.ambiguous || cut || there(f), "{}: triangle {} is missing", at(), f.triangle);
        }
        if !expected.ambiguous {
            assert_eq!(s.overflowed[pixel], expected.fragments.len() > k, "{}", at());
        }
    }
    println!("{what}: worst normal off by {:.4}°", worst_normal.to_degrees());
    report(&format!("{what}, capture"), ambiguous, fragments);
}
