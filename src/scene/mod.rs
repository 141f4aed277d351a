//! The scene: what a file or a generator gives, before any GPU.
//!
//! A [`Scene`] holds shared [`Mesh`]es, a [`Node`] hierarchy and [`Part`]s. A **part** is a node's mesh: the unit that a
//! user names, hides and colours, the *shape* of the Bucketed k-Buffer paper and the component of the illustration
//! buffer. Two nodes that share a mesh are two parts (instances) of it.
//!
//! Every triangle of every part has an **instanced-triangle number**, counted part by part in the order of
//! [`Scene::parts`] and, inside a part, primitive by primitive in file order. It is fixed when the scene is finished,
//! travels with the triangle as data and never depends on draw order: it is the tie-break of the 64-bit fragment key
//! (T1, T27).
//!
//! Coordinates: right-handed, y up, as in glTF. Vertices are `f32` in the mesh's own space; transforms are `f64`.
//! A scene far from its origin is re-based ([`Scene::origin`]), so that positions relative to the camera stay exact (T29).

pub mod arrangement;
pub mod builtin;
pub mod cut;
mod digest;
pub mod hard_case;
mod normals;
mod parametrization;
mod statistics;
mod weld;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::{DMat4, DVec3};
use rayon::prelude::*;

use crate::math::{Bounds, Projection};

pub use arrangement::{Arrangement, ArrangementError, PartLook, PartStyle, Presence, Section};
pub use cut::{Cap, Cut, CutPlane, Solids};
pub use normals::{compute_normals, interpolated_normals, mended_normals, reweighted_normals};
pub use parametrization::Parametrization;
pub use statistics::SceneStats;
pub use weld::{Welded, weld, weld_positions};

/// A whole scene. Build it, then call [`Scene::finish`], which numbers the triangles and computes what is derived.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// What to call it: the file's stem or the built-in's name.
    pub name: String,
    /// The hierarchy, parents before children not guaranteed; `Node::parent` and `Node::children` agree.
    pub nodes: Vec<Node>,
    /// Shared geometry.
    pub meshes: Vec<Mesh>,
    /// Materials; a scene with primitives has at least one.
    pub materials: Vec<Material>,
    /// Textures: an image and how it is sampled.
    pub textures: Vec<Texture>,
    /// Decoded images, shared by textures.
    pub images: Vec<Arc<Image>>,
    /// What is drawn, in scene order. Filled by [`Scene::finish`] from the nodes that have a mesh.
    pub parts: Vec<Part>,
    /// Cameras that the file brings.
    pub cameras: Vec<SceneCamera>,
    /// Names of the finishes that the file offers (KHR_materials_variants); which one is shown is chosen on import.
    pub variants: Vec<String>,
    /// Added to a scene position, gives the position in the file's own coordinates. Zero unless re-based.
    pub origin: DVec3,
    /// Everything that the file asked for and was approximated, ignored or repaired, one sentence each.
    pub notices: Vec<Notice>,
    /// What became a part and why, in one sentence; empty for scenes that no file brought.
    pub partition: String,
}

/// A node of the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name from the file; empty if it has none.
    pub name: String,
    /// Index of the parent; `None` for a root.
    pub parent: Option<usize>,
    /// Indices of the children.
    pub children: Vec<usize>,
    /// Parent space from node space.
    pub parent_from_node: DMat4,
    /// Index of the mesh that the node shows.
    pub mesh: Option<usize>,
}

/// Geometry that one or more parts show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name from the file; empty if it has none.
    pub name: String,
    /// One piece per material.
    pub primitives: Vec<Primitive>,
}

/// Triangles of one material. All attribute arrays that are present have as many elements as `positions`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// Positions in mesh space, finite.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals in mesh space. Never empty in a finished scene.
    pub normals: Vec<[f32; 3]>,
    /// Unit tangents and handedness (w = ±1); empty unless the material has a normal map.
    pub tangents: Vec<[f32; 4]>,
    /// Texture coordinate sets 0 and 1; empty where missing.
    pub uvs: [Vec<[f32; 2]>; 2],
    /// Vertex colours: linear, straight alpha; empty where missing.
    pub colors: Vec<[f32; 4]>,
    /// Vertex indices, three a triangle, each smaller than `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: usize,
}

/// What is drawn: one node's mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name to show: the node's, or the mesh's, or a number.
    pub name: String,
    /// The node it belongs to.
    pub node: usize,
    /// The mesh it shows.
    pub mesh: usize,
    /// Scene space from mesh space.
    pub world_from_part: DMat4,
    /// Number of its first instanced triangle.
    pub first_triangle: u32,
    /// How many triangles it has.
    pub triangle_count: u32,
    /// Bounding box in scene space.
    pub bounds: Bounds,
}

/// glTF's metallic-roughness material, with factors linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name from the file; empty if it has none.
    pub name: String,
    /// Base colour factor: linear rgb, straight alpha.
    pub base_color: [f32; 4],
    /// Base colour texture, sRGB.
    pub base_color_texture: Option<TextureRef>,
    /// Metalness factor, 0 to 1.
    pub metallic: f32,
    /// Perceptual roughness factor, 0 to 1.
    pub roughness: f32,
    /// Roughness in G, metalness in B; linear.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normal map; linear.
    pub normal_texture: Option<TextureRef>,
    /// Scale of the normal map's x and y.
    pub normal_scale: f32,
    /// Ambient occlusion in R; linear.
    pub occlusion_texture: Option<TextureRef>,
    /// How strongly the occlusion texture acts, 0 to 1.
    pub occlusion_strength: f32,
    /// Emitted light, linear, may exceed 1.
    pub emissive: [f32; 3],
    /// Emissive texture, sRGB.
    pub emissive_texture: Option<TextureRef>,
    /// What alpha means.
    pub alpha_mode: AlphaMode,
    /// Whether the file declares both sides visible. Both sides are always drawn; kept for reports and export.
    pub double_sided: bool,
    /// KHR_materials_unlit: base colour is shown as it is.
    pub unlit: bool,
}

impl Default for Material {
    fn default() -> Material {
        Material {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: [0.0; 3],
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

impl Material {
    /// All texture references of the material.
    pub fn texture_refs(&self) -> impl Iterator<Item = &TextureRef> {
        [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.normal_texture,
            &self.occlusion_texture,
            &self.emissive_texture,
        ]
        .into_iter()
        .flatten()
    }
}

/// glTF's alpha modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// A fragment exists where alpha reaches the cutoff, and is then opaque.
    Mask {
        /// Smallest alpha that counts as present.
        cutoff: f32,
    },
    /// Alpha is opacity.
    Blend,
}

/// A use of a texture: which, with which coordinates, transformed how (KHR_texture_transform).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into [`Scene::textures`].
    pub texture: usize,
    /// Texture coordinate set, 0 or 1.
    pub uv_set: u32,
    /// Rows of the 2×3 matrix that maps (u, v, 1) to the sampled coordinates.
    pub uv_transform: [[f32; 3]; 2],
}

impl TextureRef {
    /// The identity transform.
    pub const IDENTITY: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
}

/// An image and how it is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Index into [`Scene::images`].
    pub image: usize,
    /// Wrap modes for u and v.
    pub wrap: [Wrap; 2],
    /// Whether magnification interpolates.
    pub mag_linear: bool,
    /// Whether minification interpolates inside a level.
    pub min_linear: bool,
    /// Whether minification uses mip levels, and whether it interpolates between them.
    pub mip: Mip,
}

/// What a texture does outside [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// Starts anew.
    Repeat,
    /// Comes back.
    MirroredRepeat,
    /// Keeps its edge.
    ClampToEdge,
}

/// Mip filtering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mip {
    /// Only the full image.
    None,
    /// The nearest level.
    Nearest,
    /// Between two levels.
    Linear,
}

/// A decoded image: RGBA, 8 bits a channel, rows from the top, as stored (no colour conversion).
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Name from the file, or where it was found.
    pub name: String,
    /// Width in pixels, > 0.
    pub width: u32,
    /// Height in pixels, > 0.
    pub height: u32,
    /// `4 · width · height` bytes.
    pub rgba: Vec<u8>,
}

/// A camera that the file brings, in scene space.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// Name from the file; empty if it has none.
    pub name: String,
    /// Scene space from camera space (looking down −z, y up).
    pub world_from_camera: DMat4,
    /// How it projects.
    pub projection: Projection,
}

/// Something a user should know about how a file was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// What kind of thing happened.
    pub kind: NoticeKind,
    /// One sentence that names the place in the file.
    pub message: String,
}

/// What kind of thing a [`Notice`] tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NoticeKind {
    /// The file asks for something that is not supported and was left out.
    Ignored,
    /// Something is shown in a simpler way than the file asks for.
    Approximated,
    /// Bad data was mended or dropped.
    Repaired,
    /// Something was computed that the file leaves open.
    Computed,
}

impl NoticeKind {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            NoticeKind::Ignored => "ignored",
            NoticeKind::Approximated => "approximated",
            NoticeKind::Repaired => "repaired",
            NoticeKind::Computed => "computed",
        }
    }
}

/// Why a scene could not be finished.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum SceneError {
    /// The triangle number is 32 bits wide and its last value is reserved.
    #[error("{triangles} instanced triangles: the fragment key numbers at most 4 294 967 294")]
    TooManyTriangles {
        /// How many the scene has.
        triangles: u64,
    },
}

/// Re-base when the scene's center is farther from the origin than this many of its radii: beyond it an `f32` position
/// keeps fewer than 20 bits of the scene's own size.
const REBASE_RADII: f64 = 16.0;

/// Scenes that are larger or smaller cannot be drawn right: `f32` ends, products of a few coordinates long before.
const LARGEST_RADIUS: f64 = 1e12;
/// See [`LARGEST_RADIUS`].
const SMALLEST_RADIUS: f64 = 1e-12;

impl Scene {
    /// Scene space from the node's space: the product of the transforms up to the root, re-based.
    pub fn world_from_node(&self, node: usize) -> DMat4 {
        let mut world = self.nodes[node].parent_from_node;
        let mut at = self.nodes[node].parent;
        // A node has at most as many ancestors as there are nodes; a malformed cycle ends there.
        for _ in 0..self.nodes.len() {
            let Some(parent) = at else { break };
            world = self.nodes[parent].parent_from_node * world;
            at = self.nodes[parent].parent;
        }
        DMat4::from_translation(-self.origin) * world
    }

    /// Makes the parts from the nodes that have a mesh (roots first, then depth first in child order), numbers their
    /// triangles, and re-bases a scene that lies far from the origin, meshes whose own coordinates do so too.
    ///
    /// # Errors
    /// [`SceneError::TooManyTriangles`] if the numbers do not fit 32 bits.
    pub fn finish(mut self) -> Result<Scene, SceneError> {
        self.origin = DVec3::ZERO;
        self.collect_parts()?;
        let mut sphere = self.bounds().bounding_sphere();
        if self.center_far_meshes(REBASE_RADII * sphere.radius) {
            self.collect_parts()?;
            sphere = self.bounds().bounding_sphere();
        }
        if !sphere.radius.is_finite() || sphere.radius > LARGEST_RADIUS || sphere.radius < SMALLEST_RADIUS {
            let message = format!(
                "the scene has a radius of {:.1e}: pictures of scenes beyond {SMALLEST_RADIUS:e} to {LARGEST_RADIUS:e} are \
                 wrong or empty; change its unit",
                sphere.radius
            );
            if !self.parts.is_empty() && self.notices.iter().all(|n| n.message != message) {
                self.notices.push(Notice { kind: NoticeKind::Approximated, message });
            }
        }
        if sphere.center.length() > REBASE_RADII * sphere.radius && sphere.center != DVec3::ZERO {
            self.origin = sphere.center;
            self.collect_parts()?;
            self.notices.push(Notice {
                kind: NoticeKind::Computed,
                message: format!(
                    "the scene lies far from the origin and was re-based by ({}, {}, {})",
                    self.origin.x, self.origin.y, self.origin.z
                ),
            });
        }
        Ok(self)
    }

    /// Moves meshes of which a vertex lies farther than `far` from its node's origin into the middle of theirs, and their nodes
    /// back; says whether there was any. Shaders multiply such coordinates in `f32`, and what a transform takes away again
    /// would be lost (T29). The difference of numbers so close together is exact. A node with children keeps its place for
    /// them: its mesh goes to a child of its own.
    fn center_far_meshes(&mut self, far: f64) -> bool {
        let lies_far = |part: &&Part| {
            let vertex = self.meshes[part.mesh].primitives.iter().find_map(|p| p.positions.first());
            let Some(&vertex) = vertex else { return false };
            let linear = glam::DMat3::from_mat4(part.world_from_part);
            far > 0.0 && (linear * glam::Vec3::from(vertex).as_dvec3()).length() > far
        };
        let meshes: BTreeSet<usize> = self.parts.iter().filter(lies_far).map(|part| part.mesh).collect();
        let mut back: BTreeMap<usize, DMat4> = BTreeMap::new();
        for &mesh in &meshes {
            let center = self.meshes[mesh].bounds().center().as_vec3().as_dvec3();
            for position in self.meshes[mesh].primitives.iter_mut().flat_map(|p| &mut p.positions) {
                *position = (glam::Vec3::from(*position).as_dvec3() - center).as_vec3().to_array();
            }
            back.insert(mesh, DMat4::from_translation(center));
        }
        for node in 0..self.nodes.len() {
            let Some((mesh, &back)) = self.nodes[node].mesh.and_then(|mesh| Some((mesh, back.get(&mesh)?))) else {
                continue;
            };
            if self.nodes[node].children.is_empty() {
                self.nodes[node].parent_from_node *= back;
                continue;
            }
            let child = self.nodes.len();
            let name = self.nodes[node].name.clone();
            let parent = Some(node);
            self.nodes.push(Node { name, parent, children: Vec::new(), parent_from_node: back, mesh: Some(mesh) });
            self.nodes[node].mesh = None;
            self.nodes[node].children.insert(0, child);
        }
        !meshes.is_empty()
    }

    fn collect_parts(&mut self) -> Result<(), SceneError> {
        let mut order = Vec::with_capacity(self.nodes.len());
        let mut visited = vec![false; self.nodes.len()];
        let mut stack: Vec<usize> = (0..self.nodes.len()).rev().filter(|&n| self.nodes[n].parent.is_none()).collect();
        while let Some(node) = stack.pop() {
            if std::mem::replace(&mut visited[node], true) {
                continue;
            }
            order.push(node);
            stack.extend(self.nodes[node].children.iter().rev());
        }
        let mut first = 0_u64;
        let mut parts = Vec::new();
        for node in order {
            let Some(mesh) = self.nodes[node].mesh else {
                continue;
            };
            let count: u64 = self.meshes[mesh].triangle_count();
            if count == 0 {
                continue;
            }
            // The number 0xFFFF_FFFF is the empty slot's.
            if first + count > u64::from(u32::MAX) {
                let triangles = self.nodes.iter().filter_map(|n| n.mesh).map(|m| self.meshes[m].triangle_count()).sum();
                return Err(SceneError::TooManyTriangles { triangles });
            }
            let world_from_part = self.world_from_node(node);
            let names = [&self.nodes[node].name, &self.meshes[mesh].name];
            parts.push(Part {
                name: names
                    .into_iter()
                    .find(|n| !n.is_empty())
                    .cloned()
                    .unwrap_or_else(|| format!("part {}", parts.len())),
                node,
                mesh,
                world_from_part,
                first_triangle: first as u32,
                triangle_count: count as u32,
                bounds: Bounds::EMPTY,
            });
            first += count;
        }
        // From the vertices: the box around a turned box is too large.
        parts.par_iter_mut().for_each(|part| part.bounds = self.meshes[part.mesh].bounds_in(part.world_from_part));
        self.parts = parts;
        Ok(())
    }

    /// The box around all parts, in scene space.
    pub fn bounds(&self) -> Bounds {
        self.parts.iter().fold(Bounds::EMPTY, |b, p| b.union(p.bounds))
    }

    /// How many instanced triangles the scene has.
    pub fn triangle_count(&self) -> u64 {
        self.parts.iter().map(|p| u64::from(p.triangle_count)).sum()
    }
}

impl Mesh {
    /// The box around the mesh, in its own space.
    pub fn bounds(&self) -> Bounds {
        Bounds::of_points(self.primitives.iter().flat_map(|p| &p.positions).map(|&p| glam::Vec3::from(p).as_dvec3()))
    }

    /// The box around the mesh in another space.
    pub fn bounds_in(&self, space_from_mesh: DMat4) -> Bounds {
        let positions = self.primitives.iter().flat_map(|p| &p.positions);
        Bounds::of_points(positions.map(|&p| space_from_mesh.transform_point3(glam::Vec3::from(p).as_dvec3())))
    }

    /// How many triangles it has.
    pub fn triangle_count(&self) -> u64 {
        self.primitives.iter().map(|p| p.triangles.len() as u64).sum()
    }
}

impl Node {
    /// A root node that shows `mesh`.
    pub fn root(name: impl Into<String>, mesh: Option<usize>, parent_from_node: DMat4) -> Node {
        Node { name: name.into(), parent: None, children: Vec::new(), parent_from_node, mesh }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_far_from_their_nodes_are_centred_and_nothing_moves() {
        let corners = [[1e7_f32, 2e7, 0.0], [1e7 + 1.0, 2e7, 0.0], [1e7, 2e7 + 2.0, 1.0]];
        let primitive = Primitive { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Primitive::default() };
        let mesh = Mesh { name: String::new(), primitives: vec![primitive] };
        let mut parent = Node::root("housing", Some(0), DMat4::from_translation(DVec3::new(-1e7, -2e7, 0.0)));
        parent.children = vec![1];
        let mut child = Node::root("lid", Some(0), DMat4::from_translation(DVec3::Z));
        child.parent = Some(0);
        let scene = Scene { meshes: vec![mesh], nodes: vec![parent, child], ..Scene::default() }.finish().unwrap();
        assert_eq!(scene.parts.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["housing", "lid"]);
        let stored = &scene.meshes[0].primitives[0].positions;
        assert!(stored.iter().flatten().all(|c| c.abs() <= 2.0), "{stored:?}");
        for (part, lift) in scene.parts.iter().zip([0.0, 1.0]) {
            for (&small, [x, y, z]) in stored.iter().zip(corners.map(|c| c.map(f64::from))) {
                let place = part.world_from_part.transform_point3(glam::Vec3::from(small).as_dvec3()) + scene.origin;
                assert_eq!(place, DVec3::new(x - 1e7, y - 2e7, z + lift), "{}", part.name);
            }
        }
        let again = scene.clone().finish().unwrap();
        let what = |s: &Scene| (s.origin, s.nodes.len(), s.meshes[0].primitives[0].positions.clone());
        assert_eq!(what(&again), what(&scene), "there is nothing left to do");
    }

    #[test]
    fn scenes_beyond_what_can_be_drawn_say_so() {
        for (size, wrong) in [(1.0, false), (1e10, false), (1e16, true), (1e-20, true)] {
            let positions = vec![[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]];
            let primitive = Primitive { positions, triangles: vec![[0, 1, 2]], ..Primitive::default() };
            let mesh = Mesh { name: String::new(), primitives: vec![primitive] };
            let nodes = vec![Node::root("a", Some(0), DMat4::IDENTITY)];
            let scene = Scene { meshes: vec![mesh], nodes, ..Scene::default() }.finish().unwrap();
            assert_eq!(scene.notices.len(), usize::from(wrong), "{size}: {:?}", scene.notices);
        }
    }

    #[test]
    fn a_turned_part_is_bounded_by_its_vertices() {
        let diamond = Primitive {
            positions: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Primitive::default()
        };
        let turned = DMat4::from_rotation_z(std::f64::consts::FRAC_PI_4);
        let scene = Scene {
            materials: vec![Material::default()],
            meshes: vec![Mesh { name: "diamond".into(), primitives: vec![diamond] }],
            nodes: vec![Node::root("turned", Some(0), turned)],
            ..Scene::default()
        };
        let size = scene.finish().unwrap().bounds().size();
        assert!((size - DVec3::new(2.0_f64.sqrt(), 2.0_f64.sqrt(), 0.0)).length() < 1e-12, "{size}");
    }
}
