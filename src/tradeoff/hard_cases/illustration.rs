//! Measurements of the illustration buffer.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec3};

use super::measure::{Stand, share};
use super::{CaseError, Figure};
use crate::math::{Camera, Projection};
use crate::oracle::{Link, compare, continuity, illustration};
use crate::scene::Scene;

impl Stand<'_> {
    /// Links whose neighbour is linked elsewhere.
    pub(super) fn links_one_way(&mut self) -> Result<Figure, CaseError> {
        let store = self.shot()?.store;
        let links = store.links.iter().flatten().filter(|l| matches!(l, Link::To(_))).count();
        Ok(share(continuity::one_way(&store.layers, &store.links), links))
    }

    /// Fields against the oracle's over the same links and base opacity.
    pub(super) fn field_error(&mut self) -> Result<Figure, CaseError> {
        let mut plain = self.settings.clone();
        plain.opacity.model = plain.opacity.base_model();
        let scene = self.scene.clone();
        let base = self.unchanged(&scene, &plain)?;
        let base: Vec<f64> = base.colors().iter().map(|c| c[3]).collect();
        let store = self.shot()?.store;
        let settings = &self.settings.opacity.illustrative;
        let (exact, _) = compare::illustrated(&store.surfaces(), &base, settings);
        let off = |(f, e): (&[f32; 4], &[f64; 3])| (0..3).map(|c| (f64::from(f[c]) - e[c]).abs()).fold(0.0, worse);
        let value = store.fields.iter().zip(&exact.values).map(off).fold(0.0, worse);
        Ok(Figure { value, samples: store.fields.len(), ambiguous: 0 })
    }

    /// Opacity against what the oracle makes of the same fields.
    pub(super) fn field_opacity_error(&mut self) -> Result<Figure, CaseError> {
        let store = self.shot()?.store;
        let values = store.fields.iter().map(|f| [0, 1, 2].map(|c| f64::from(f[c]))).collect();
        let fields = illustration::Fields { values, fixed: vec![[false; 2]; store.fields.len()] };
        let exact = illustration::opacities(&fields, &self.settings.opacity.illustrative);
        let value = store.lit.iter().zip(&exact).map(|(l, e)| (f64::from(l[3]) - e).abs()).fold(0.0, worse);
        Ok(Figure { value: 255.0 * value, samples: exact.len(), ambiguous: 0 })
    }

    /// Layers at which a halo begins or a highlight is stopped, though they do not end themselves.
    pub(super) fn halos(&mut self) -> Result<Figure, CaseError> {
        let store = self.shot()?.store;
        let pairs = store.fields.iter().zip(&store.links);
        let is_one = |(f, links): &(&[f32; 4], &[Link; 4])| f[3] != 0.0 && !links.contains(&Link::Missing);
        Ok(share(pairs.filter(is_one).count(), store.fields.len()))
    }

    /// The same in a picture with contours, which the geometry knows: far from all of them nothing ends.
    pub(super) fn halos_off_contours(&mut self) -> Result<Figure, CaseError> {
        let store = self.shot()?.store;
        let contours = contour_pixels(&self.scene, &self.camera(&self.scene), self.case.size);
        let pixels = store.layers.pixel_of_fragment();
        let far = || pixels.iter().zip(&store.fields).filter(|(pixel, _)| !contours[**pixel]);
        Ok(share(far().filter(|(_, f)| f[3] != 0.0).count(), far().count()))
    }
}

/// Pixels within two pixels of a contour of a part: of an edge between a face that looks at the eye and one that does not, or
/// of a face alone.
fn contour_pixels(scene: &Scene, camera: &Camera, size: [u32; 2]) -> Vec<bool> {
    const NEAR: f64 = 2.0;
    let [width, height] = size.map(|s| s as usize);
    let clip = camera.clip_from_view(camera.frustum(&scene.bounds()), size, DVec2::ZERO);
    let scale = DVec2::new(width as f64, height as f64);
    let in_image = |p: DVec3| {
        let ndc = clip.project_point3(p);
        (DVec2::new(ndc.x, -ndc.y) * 0.5 + 0.5) * scale
    };
    let mut marked = vec![false; width * height];
    let mut mark = |at: DVec2| {
        for y in (at.y - NEAR).floor().max(0.0) as usize..((at.y + NEAR).ceil().max(0.0) as usize).min(height) {
            for x in (at.x - NEAR).floor().max(0.0) as usize..((at.x + NEAR).ceil().max(0.0) as usize).min(width) {
                marked[y * width + x] |= at.distance(DVec2::new(x as f64 + 0.5, y as f64 + 0.5)) <= NEAR;
            }
        }
    };
    for part in &scene.parts {
        let view_from_part = camera.view_from_world() * part.world_from_part;
        // Edges by where they are, since sharp ones have vertices of their own on each side: how each face looks.
        type Edge = (Vec<bool>, [DVec3; 2]);
        let mut edges: HashMap<[[u32; 3]; 2], Edge> = HashMap::new();
        for primitive in &scene.meshes[part.mesh].primitives {
            for t in &primitive.triangles {
                let corner = |i: u32| primitive.positions[i as usize];
                let points = t.map(|i| view_from_part.transform_point3(Vec3::from(corner(i)).as_dvec3()));
                let normal = (points[1] - points[0]).cross(points[2] - points[0]);
                let to_eye = match camera.projection {
                    Projection::Perspective { .. } => -points[0],
                    Projection::Orthographic { .. } => DVec3::Z,
                };
                for e in 0..3 {
                    let bits = [t[e], t[(e + 1) % 3]].map(|i| corner(i).map(|c| (c + 0.0).to_bits()));
                    let key = if bits[0] < bits[1] { bits } else { [bits[1], bits[0]] };
                    let entry = edges.entry(key).or_insert((Vec::new(), [points[e], points[(e + 1) % 3]]));
                    entry.0.push(normal.dot(to_eye) > 0.0);
                }
            }
        }
        for (looks, [a, b]) in edges.values() {
            if looks.len() > 1 && looks.iter().all(|l| *l == looks[0]) {
                continue;
            }
            let (a, b) = (in_image(*a), in_image(*b));
            let steps = (4.0 * a.distance(b)).ceil().max(1.0) as usize;
            (0..=steps).for_each(|i| mark(a.lerp(b, i as f64 / steps as f64)));
        }
    }
    marked
}

/// The greater, or NaN.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}
