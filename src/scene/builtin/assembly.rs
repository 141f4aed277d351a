//! Puts shells together into a [`Scene`] with names, sub-assemblies and shared meshes.

use glam::{DMat4, DVec3};

use super::kit::Shell;
use crate::math::color::linear_from_srgb;
use crate::scene::{Material, Mesh, Node, Primitive, Scene};

/// A scene under construction. Handles are indices into it.
#[derive(Clone, Debug, Default)]
pub struct Assembly {
    scene: Scene,
}

impl Assembly {
    /// An empty scene.
    pub fn new(name: &str) -> Assembly {
        Assembly { scene: Scene { name: name.to_owned(), ..Scene::default() } }
    }

    /// Adds a material with an sRGB colour 0xRRGGBB.
    pub fn material(&mut self, name: &str, srgb: u32, metallic: f32, roughness: f32) -> usize {
        let channel = |shift: u32| linear_from_srgb(f64::from(srgb >> shift & 0xFF) / 255.0) as f32;
        self.scene.materials.push(Material {
            name: name.to_owned(),
            base_color: [channel(16), channel(8), channel(0), 1.0],
            metallic,
            roughness,
            ..Material::default()
        });
        self.scene.materials.len() - 1
    }

    /// Adds a mesh of one material.
    pub fn mesh(&mut self, name: &str, shell: &Shell, material: usize) -> usize {
        self.mesh_of(name, shell.primitive(material))
    }

    /// Adds a mesh from a finished primitive.
    pub fn mesh_of(&mut self, name: &str, primitive: Primitive) -> usize {
        self.scene.meshes.push(Mesh { name: name.to_owned(), primitives: vec![primitive] });
        self.scene.meshes.len() - 1
    }

    /// Adds a sub-assembly; `None` puts it at the root.
    pub fn group(&mut self, parent: Option<usize>, name: &str, parent_from_node: DMat4) -> usize {
        self.node(parent, name, None, parent_from_node)
    }

    /// Adds a part that shows `mesh`.
    pub fn part(&mut self, parent: usize, name: &str, mesh: usize, parent_from_node: DMat4) -> usize {
        self.node(Some(parent), name, Some(mesh), parent_from_node)
    }

    /// Adds a mesh and the one part that shows it, in place.
    pub fn single(&mut self, parent: usize, name: &str, shell: &Shell, material: usize) -> usize {
        let mesh = self.mesh(name, shell, material);
        self.part(parent, name, mesh, DMat4::IDENTITY)
    }

    /// Adds `count` parts of one mesh, turned about z in equal steps from angle `start`.
    pub fn circle(&mut self, parent: usize, name: &str, mesh: usize, count: usize, start: f64, local: DMat4) {
        for i in 0..count {
            let turn = DMat4::from_rotation_z(start + std::f64::consts::TAU * i as f64 / count as f64);
            self.part(parent, &format!("{name} {}", i + 1), mesh, turn * local);
        }
    }

    fn node(&mut self, parent: Option<usize>, name: &str, mesh: Option<usize>, parent_from_node: DMat4) -> usize {
        let index = self.scene.nodes.len();
        self.scene.nodes.push(Node { parent, ..Node::root(name, mesh, parent_from_node) });
        if let Some(parent) = parent {
            self.scene.nodes[parent].children.push(index);
        }
        index
    }

    /// The scene, not yet finished.
    pub fn into_scene(self) -> Scene {
        self.scene
    }
}

/// A shift.
pub fn shift(x: f64, y: f64, z: f64) -> DMat4 {
    DMat4::from_translation(DVec3::new(x, y, z))
}

/// Half a turn about the x axis: what pointed to −z points to +z.
pub fn upside_down() -> DMat4 {
    DMat4::from_rotation_x(std::f64::consts::PI)
}
