//! Rasterization by definition: a fragment is where the sight line through a pixel's centre meets a triangle, from
//! either side, no nearer than the near plane.
//!
//! Vertices are the scene's `f32` numbers; everything after is `f64`. Coverage is tested with homogeneous edge functions
//! (Olano and Greer 1997): with `c = (x w, y w, w)` in pixels, the triple product of two vertices and the sample is an
//! edge function that stays right when a vertex lies behind the eye, so nothing has to be clipped; the three values over
//! their sum are the perspective-correct barycentric coordinates. A shared edge gives exactly opposite values to its
//! two triangles, and the top-left rule decides a zero, so a closed surface has neither gaps nor doubles.
//!
//! A fragment is *ambiguous* when a GPU may see it otherwise: its sample lies within 1/256 pixel of an edge (or of the
//! line where the near plane cuts the triangle), its depth is within 4 steps of an `f32` of another fragment's or of the
//! near plane, or a mask's alpha is at its cutoff. A *pixel* is ambiguous if one of its fragments is, or if a fragment
//! is just missed.
//!
//! # Choices
//! - Vertex normals are transformed by the inverse transpose, scaled as a whole so that its longest column has length 1,
//!   and interpolated without being normalized before. An interpolated normal shorter than 1e-4 is degenerate.
//! - Normal maps are not applied.
//! - Layers are in the order of the contract, `(depth_key, triangle)`: two depths that round to the same `f32` are
//!   ordered by triangle, whichever is nearer in `f64`.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4, Vec3};

use super::cut::ViewCut;
use super::texture;
use super::view::View;
use crate::math::{Camera, Projection};
use crate::scene::{AlphaMode, CutPlane, Material, Parametrization, Part, Primitive, Scene};

/// What a surface is made of at one point, before light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceInputs {
    /// Linear rgb and straight alpha; alpha is 1 unless the material blends.
    pub base_color: [f64; 4],
    /// Metalness, 0 to 1.
    pub metallic: f64,
    /// Perceptual roughness, 0 to 1.
    pub roughness: f64,
    /// Ambient occlusion, 1 is open.
    pub occlusion: f64,
    /// Emitted light, linear rgb.
    pub emissive: [f64; 3],
    /// Whether base colour is shown as it is.
    pub unlit: bool,
}

/// One triangle seen in one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// Index of the part.
    pub part: u32,
    /// Instanced-triangle number.
    pub triangle: u32,
    /// Distance along the view, scene units.
    pub depth: f64,
    /// Clip-space z, 1 at the near plane.
    pub clip_z: f64,
    /// Depth half of the key.
    pub depth_key: u32,
    /// Where the sight line meets the triangle, view space.
    pub position_in_view: DVec3,
    /// Unit normal, view space.
    pub normal_in_view: DVec3,
    /// Whether the outer side of the surface faces the viewer.
    pub side: bool,
    /// Weights of the three vertices.
    pub barycentrics: [f64; 3],
    /// Material at this point.
    pub surface: SurfaceInputs,
    /// Place in the surface's parametrization, radii of the part, and how far it goes along the triangle over a pixel in x and
    /// in y.
    pub parameters: Option<[f64; 4]>,
    /// Whether a GPU may rightly see it otherwise.
    pub ambiguous: bool,
}

/// All fragments of a pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pixel {
    /// By (depth key, triangle), nearest first.
    pub fragments: Vec<Fragment>,
    /// Whether one of them is ambiguous or another was just missed.
    pub ambiguous: bool,
    /// Whether it is uncertain which fragments there are, whatever their order.
    pub uncertain_fragments: bool,
}

/// All fragments of an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width · height` pixels, in rows from the top.
    pub pixels: Vec<Pixel>,
}

/// The clip-space z of 1.
const KEY_OF_NEAR: u32 = 0x3F80_0000;
/// How close to an edge, in pixels, a sample may fall on either side.
const EDGE_TOLERANCE: f64 = 1.0 / 256.0;
/// How many `f32` steps apart two depths may swap.
const DEPTH_TOLERANCE: u32 = 4;
const DEGENERATE_NORMAL: f64 = 1e-4;

/// Depth half of the key of a clip-space z: distance from the near plane in steps of an `f32`.
pub fn depth_key(clip_z: f64) -> u32 {
    KEY_OF_NEAR - (clip_z.clamp(0.0, 1.0) as f32).to_bits()
}

/// Every fragment of every pixel of a picture of `scene` by `camera`, `size` = (width, height) pixels, the image shifted
/// by `jitter` pixels (x right, y down).
pub fn rasterize(scene: &Scene, camera: &Camera, size: [u32; 2], jitter: DVec2) -> Layers {
    rasterize_cut(scene, camera, &[], size, jitter)
}

/// The same of a scene that planes cut; caps are parts of the scene.
pub fn rasterize_cut(scene: &Scene, camera: &Camera, planes: &[CutPlane], size: [u32; 2], jitter: DVec2) -> Layers {
    let [width, height] = size;
    let mut layers = Layers { width, height, pixels: vec![Pixel::default(); width as usize * height as usize] };
    let frame = Frame {
        view_from_world: camera.view_from_world(),
        clip_from_view: camera.clip_from_view(camera.frustum(&scene.bounds()), size, jitter),
        perspective: matches!(camera.projection, Projection::Perspective { .. }),
        cut: ViewCut::new(planes, camera, View::new(camera, size, jitter)),
    };
    let parametrizations: Vec<_> = scene.meshes.iter().map(Parametrization::of).collect();
    for (index, part) in scene.parts.iter().enumerate() {
        let Some(mesh) = scene.meshes.get(part.mesh) else { continue };
        let placed =
            PlacedPart { parametrization: parametrizations[part.mesh], ..PlacedPart::new(&frame, part, index as u32) };
        let mut number = part.first_triangle;
        for primitive in &mesh.primitives {
            for &corners in &primitive.triangles {
                if let Some(triangle) = Triangle::new(scene, &frame, &placed, primitive, corners, number) {
                    triangle.draw(&frame.cut, &mut layers);
                }
                number += 1;
            }
        }
    }
    for pixel in &mut layers.pixels {
        finish(pixel);
    }
    layers
}

/// Sorts a pixel's fragments and marks those whose order is uncertain.
fn finish(pixel: &mut Pixel) {
    pixel.uncertain_fragments = pixel.ambiguous || pixel.fragments.iter().any(|f| f.ambiguous);
    pixel.fragments.sort_by_key(|f| (f.depth_key, f.triangle));
    for i in 1..pixel.fragments.len() {
        if pixel.fragments[i].depth_key - pixel.fragments[i - 1].depth_key <= DEPTH_TOLERANCE {
            pixel.fragments[i - 1].ambiguous = true;
            pixel.fragments[i].ambiguous = true;
        }
    }
    pixel.ambiguous |= pixel.fragments.iter().any(|f| f.ambiguous);
}

struct Frame {
    view_from_world: DMat4,
    clip_from_view: DMat4,
    perspective: bool,
    cut: ViewCut,
}

/// A part as this frame sees it.
struct PlacedPart {
    index: u32,
    view_from_part: DMat4,
    /// Inverse transpose up to a positive factor.
    normal_from_part: DMat3,
    mirrored: bool,
    parametrization: Option<Parametrization>,
}

impl PlacedPart {
    fn new(frame: &Frame, part: &Part, index: u32) -> PlacedPart {
        let view_from_part = frame.view_from_world * part.world_from_part;
        let m = DMat3::from_mat4(view_from_part);
        // The cofactor matrix is the inverse transpose times the determinant, and exists for flattened parts too.
        let cofactor = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let longest = cofactor.x_axis.length().max(cofactor.y_axis.length()).max(cofactor.z_axis.length());
        let mirrored = m.determinant() < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        let normal_from_part = if longest > 0.0 { cofactor * (sign / longest) } else { DMat3::ZERO };
        PlacedPart { index, view_from_part, normal_from_part, mirrored, parametrization: None }
    }
}

/// A line in the image: positive on the inner side.
#[derive(Clone, Copy)]
struct Edge(DVec3);

impl Edge {
    fn at(self, sample: DVec2) -> f64 {
        self.0.dot(sample.extend(1.0))
    }

    /// Signed distance of a sample in pixels; infinite for an edge that is a point.
    fn distance(self, sample: DVec2) -> f64 {
        let length = self.0.truncate().length();
        if length > 0.0 { self.at(sample) / length } else { f64::INFINITY }
    }

    /// Whether a sample belongs to the inner side: the top-left rule decides on the line itself.
    fn covers(self, sample: DVec2) -> bool {
        let value = self.at(sample);
        value > 0.0 || (value == 0.0 && (self.0.x > 0.0 || (self.0.x == 0.0 && self.0.y > 0.0)))
    }
}

struct Triangle<'a> {
    scene: &'a Scene,
    primitive: &'a Primitive,
    material: &'a Material,
    corners: [usize; 3],
    number: u32,
    part: u32,
    positions_in_view: [DVec3; 3],
    normals_in_view: [DVec3; 3],
    geometric_normal: DVec3,
    side: bool,
    /// Scaled parameters of the vertices.
    parameters: Option<[DVec2; 3]>,
    clip: [DVec4; 3],
    /// The facing of the normal hangs on a rounding error.
    uncertain_side: bool,
}

impl<'a> Triangle<'a> {
    fn new(
        scene: &'a Scene,
        frame: &Frame,
        part: &PlacedPart,
        primitive: &'a Primitive,
        corners: [u32; 3],
        number: u32,
    ) -> Option<Triangle<'a>> {
        let corners = corners.map(|c| c as usize);
        let material = scene.materials.get(primitive.material)?;
        let vertex = |values: &[[f32; 3]], i: usize| values.get(i).map(|&v| Vec3::from(v).as_dvec3());
        let mut positions = [DVec3::ZERO; 3];
        let mut normals = [DVec3::ZERO; 3];
        for i in 0..3 {
            positions[i] = vertex(&primitive.positions, corners[i])?;
            normals[i] = vertex(&primitive.normals, corners[i]).unwrap_or(DVec3::ZERO);
        }
        let winding = (positions[1] - positions[0]).cross(positions[2] - positions[0]);
        let sum: DVec3 = normals.iter().sum();
        let agreement = winding.dot(sum);
        let opposed = agreement < 0.0;

        let positions_in_view = positions.map(|p| part.view_from_part.transform_point3(p));
        let [p0, p1, p2] = positions_in_view;
        let winding_in_view = (p1 - p0).cross(p2 - p0);
        let towards_viewer = if frame.perspective { -winding_in_view.dot(p0) } else { winding_in_view.z };
        let front_facing = towards_viewer > 0.0;
        let geometric_normal =
            (if front_facing { winding_in_view } else { -winding_in_view }).try_normalize().unwrap_or(DVec3::Z);
        Some(Triangle {
            scene,
            primitive,
            material,
            corners,
            number,
            part: part.index,
            positions_in_view,
            normals_in_view: normals.map(|n| part.normal_from_part * n),
            geometric_normal,
            side: front_facing ^ part.mirrored ^ opposed,
            parameters: part
                .parametrization
                .filter(|_| Parametrization::covers(primitive))
                .map(|known| corners.map(|c| known.scaled(primitive.uvs[0][c]))),
            clip: positions_in_view.map(|p| frame.clip_from_view * p.extend(1.0)),
            uncertain_side: agreement.abs() < 1e-6 * winding.length() * sum.length(),
        })
    }

    /// Adds this triangle's fragments to the layers.
    fn draw(&self, cut: &ViewCut, layers: &mut Layers) {
        let size = DVec2::new(f64::from(layers.width), f64::from(layers.height));
        // Pixels, y down, times w.
        let c = self.clip.map(|c| DVec3::new((c.w + c.x) * 0.5 * size.x, (c.w - c.y) * 0.5 * size.y, c.w));
        let edges = [c[1].cross(c[2]), c[2].cross(c[0]), c[0].cross(c[1])];
        let volume = c[0].dot(edges[0]);
        if !volume.is_finite() || !edges.iter().all(|e| e.is_finite()) {
            return;
        }
        let sign = if volume < 0.0 { -1.0 } else { 1.0 };
        let edges = edges.map(|e| Edge(e * sign));
        let z_plane = if volume == 0.0 {
            None
        } else {
            let z: [f64; 3] = std::array::from_fn(|i| self.clip[i].z / volume.abs());
            Some(edges[0].0 * z[0] + edges[1].0 * z[1] + edges[2].0 * z[2])
        };
        let (mut low, mut high) = (DVec2::ZERO, size);
        if c.iter().all(|c| c.z > 0.0) {
            let corners = c.map(|c| c.truncate() / c.z);
            low = corners.iter().fold(size, |a, &b| a.min(b)).max(DVec2::ZERO);
            high = corners.iter().fold(DVec2::ZERO, |a, &b| a.max(b)).min(size);
        }
        let first = |v: f64| (v - 1.0).max(0.0).floor() as u32;
        let end = |v: f64, limit: u32| ((v + 1.0).max(0.0).ceil() as u32).min(limit);
        for y in first(low.y)..end(high.y, layers.height) {
            for x in first(low.x)..end(high.x, layers.width) {
                let pixel = &mut layers.pixels[y as usize * layers.width as usize + x as usize];
                self.sample(cut, &edges, z_plane, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), pixel);
            }
        }
    }

    /// Adds the fragment at `sample`, if there is one. `edges` are opposite each vertex and positive inside; `z_plane`
    /// gives clip z over w, which is affine in the image, and is missing for a triangle seen edge-on.
    fn sample(&self, cut: &ViewCut, edges: &[Edge; 3], z_plane: Option<DVec3>, sample: DVec2, pixel: &mut Pixel) {
        let mut margin = edges.iter().map(|e| e.distance(sample)).fold(f64::INFINITY, f64::min);
        if margin <= -EDGE_TOLERANCE {
            return;
        }
        let Some(z_plane) = z_plane else {
            // It covers nothing, but a rasterizer that snaps its vertices may find it here.
            pixel.ambiguous = true;
            return;
        };
        // The near plane cuts along the line where clip z is 1.
        let clip_z = z_plane.dot(sample.extend(1.0));
        margin = margin.min(Edge(DVec3::Z - z_plane).distance(sample));
        let near_depth = (1.0 - clip_z).abs() <= f64::from(DEPTH_TOLERANCE) * f64::from(f32::EPSILON) * 0.5;
        let uncertain = margin.abs() < EDGE_TOLERANCE || near_depth;
        if !edges.iter().all(|e| e.covers(sample)) || !(0.0..=1.0).contains(&clip_z) {
            pixel.ambiguous |= uncertain;
            return;
        }
        let values = edges.map(|e| e.at(sample));
        let sum: f64 = values.iter().sum();
        let barycentrics = values.map(|v| v / sum);
        let (surface, mask) = self.surface(barycentrics);
        pixel.ambiguous |= mask.uncertain;
        if !mask.present {
            return;
        }
        let blend = |v: &[DVec3; 3]| v[0] * barycentrics[0] + v[1] * barycentrics[1] + v[2] * barycentrics[2];
        let position_in_view = blend(&self.positions_in_view);
        let (is_cut, may_be_cut) = cut.cuts(self.part, position_in_view, self.geometric_normal);
        let uncertain = uncertain || may_be_cut;
        if is_cut {
            pixel.ambiguous |= uncertain;
            return;
        }
        let smooth = blend(&self.normals_in_view);
        let normal_in_view = if smooth.is_finite() && smooth.length() >= DEGENERATE_NORMAL {
            if self.side { smooth.normalize() } else { -smooth.normalize() }
        } else {
            self.geometric_normal
        };
        pixel.fragments.push(Fragment {
            part: self.part,
            triangle: self.number,
            depth: -position_in_view.z,
            clip_z,
            depth_key: depth_key(clip_z),
            position_in_view,
            normal_in_view,
            side: self.side,
            barycentrics,
            surface,
            parameters: self.parameters.map(|corners| {
                let at = |step: DVec2| {
                    let values = edges.map(|e| e.at(sample + step));
                    let sum: f64 = values.iter().sum();
                    (0..3).map(|i| corners[i] * (values[i] / sum)).sum::<DVec2>()
                };
                let here = at(DVec2::ZERO);
                [here.x, here.y, at(DVec2::X).distance(here), at(DVec2::Y).distance(here)]
            }),
            ambiguous: uncertain || mask.uncertain || self.uncertain_side,
        });
    }

    /// Material at a point, and whether a mask cuts it away.
    fn surface(&self, barycentrics: [f64; 3]) -> (SurfaceInputs, Mask) {
        let m = self.material;
        let uv = |set: u32| -> [f64; 2] {
            let uvs = self.primitive.uvs.get(set as usize);
            std::array::from_fn(|axis| {
                (0..3)
                    .map(|i| {
                        let uv = uvs.and_then(|uvs| uvs.get(self.corners[i])).map_or(0.0, |uv| f64::from(uv[axis]));
                        barycentrics[i] * uv
                    })
                    .sum()
            })
        };
        let textured = |reference: &Option<crate::scene::TextureRef>, srgb| {
            reference.as_ref().map_or([1.0; 4], |t| texture::sample(self.scene, t, uv(t.uv_set), srgb))
        };
        let vertex_color: [f64; 4] = std::array::from_fn(|channel| {
            (0..3)
                .map(|i| {
                    let c = self.primitive.colors.get(self.corners[i]).map_or(1.0, |c| f64::from(c[channel]));
                    barycentrics[i] * c
                })
                .sum()
        });
        let texel = textured(&m.base_color_texture, true);
        let mut base_color: [f64; 4] = std::array::from_fn(|i| f64::from(m.base_color[i]) * vertex_color[i] * texel[i]);
        let mask = match m.alpha_mode {
            AlphaMode::Mask { cutoff } => {
                let over = base_color[3] - f64::from(cutoff);
                // A GPU filters with 8 bits of weight.
                let tolerance = if m.base_color_texture.is_some() { 1.0 / 128.0 } else { 1e-6 };
                Mask { present: over >= 0.0, uncertain: over.abs() < tolerance }
            }
            AlphaMode::Opaque | AlphaMode::Blend => Mask { present: true, uncertain: false },
        };
        if m.alpha_mode != AlphaMode::Blend {
            base_color[3] = 1.0;
        }
        let metallic_roughness = textured(&m.metallic_roughness_texture, false);
        let occlusion = textured(&m.occlusion_texture, false);
        let emissive = textured(&m.emissive_texture, true);
        let surface = SurfaceInputs {
            base_color,
            metallic: f64::from(m.metallic) * metallic_roughness[2],
            roughness: f64::from(m.roughness) * metallic_roughness[1],
            occlusion: 1.0 + f64::from(m.occlusion_strength) * (occlusion[0] - 1.0),
            emissive: std::array::from_fn(|i| f64::from(m.emissive[i]) * emissive[i]),
            unlit: m.unlit,
        };
        (surface, mask)
    }
}

/// What a mask does to a fragment.
struct Mask {
    present: bool,
    uncertain: bool,
}

#[cfg(test)]
#[path = "raster_tests.rs"]
mod tests;
