//! What the planner needs to know of a scene, and no more.

use glam::DVec3;

use super::{AlphaMode, Parametrization, Scene};
use crate::math::Bounds;

/// Facts about a scene on which a plan depends.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneStats {
    /// Number of parts.
    pub parts: u64,
    /// Number of instanced triangles.
    pub triangles: u64,
    /// Vertices stored on the GPU (shared meshes once).
    pub vertices: u64,
    /// Materials whose alpha is opacity.
    pub blended_materials: u64,
    /// Materials whose alpha cuts holes.
    pub masked_materials: u64,
    /// Materials that emit light.
    pub emissive_materials: u64,
    /// Materials with at least one texture.
    pub textured_materials: u64,
    /// Parts whose mesh has a parametrization.
    pub parametrized_parts: u64,
    /// Box around everything that is drawn, scene units.
    pub bounds: Bounds,
    /// Drawn parts whose opacity is multiplied by less than 1.
    pub faded_parts: u64,
    /// Drawn parts that the opacity model leaves alone.
    pub solid_parts: u64,
    /// Drawn parts with a colour of the user's.
    pub recolored_parts: u64,
    /// Drawn parts that are outlined.
    pub selected_parts: u64,
    /// Section planes that cut.
    pub section_planes: u64,
    /// Caps that close what they cut; each counts as a part.
    pub caps: u64,
}

impl SceneStats {
    /// Counts a finished scene.
    pub fn of(scene: &Scene) -> SceneStats {
        SceneStats::of_parts(scene, |_| true)
    }

    /// Counts a finished scene of which only some parts are drawn: materials are theirs, everything else is the whole
    /// scene's.
    pub(super) fn of_parts(scene: &Scene, is_drawn: impl Fn(u32) -> bool) -> SceneStats {
        let used: Vec<_> = {
            let mut used = vec![false; scene.materials.len()];
            for (_, part) in scene.parts.iter().enumerate().filter(|(i, _)| is_drawn(*i as u32)) {
                for primitive in &scene.meshes[part.mesh].primitives {
                    used[primitive.material] = true;
                }
            }
            scene.materials.iter().zip(used).filter_map(|(m, used)| used.then_some(m)).collect()
        };
        let parametrized: Vec<bool> = scene.meshes.iter().map(|mesh| Parametrization::of(mesh).is_some()).collect();
        let count = |f: &dyn Fn(&&super::Material) -> bool| used.iter().filter(|m| f(m)).count() as u64;
        SceneStats {
            parts: scene.parts.len() as u64,
            triangles: scene.triangle_count(),
            vertices: scene.meshes.iter().flat_map(|m| &m.primitives).map(|p| p.positions.len() as u64).sum(),
            blended_materials: count(&|m| m.alpha_mode == AlphaMode::Blend),
            masked_materials: count(&|m| matches!(m.alpha_mode, AlphaMode::Mask { .. })),
            emissive_materials: count(&|m| m.emissive != [0.0; 3]),
            textured_materials: count(&|m| m.texture_refs().next().is_some()),
            parametrized_parts: scene.parts.iter().filter(|p| parametrized[p.mesh]).count() as u64,
            bounds: scene.bounds(),
            faded_parts: 0,
            solid_parts: 0,
            recolored_parts: 0,
            selected_parts: 0,
            section_planes: 0,
            caps: 0,
        }
    }

    /// Radius of the sphere around everything, scene units.
    pub fn radius(&self) -> f64 {
        self.bounds.bounding_sphere().radius
    }

    /// Center of the sphere around everything.
    pub fn center(&self) -> DVec3 {
        self.bounds.center()
    }
}
