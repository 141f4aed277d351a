//! Caps on the GPU: parts after the scene's own, drawn as any other, and the section planes as shaders see them.
//!
//! All caps of an arrangement share three buffers; each is a mesh of one primitive with its own run of indices. They are
//! made anew whenever the arrangement changes, while their materials are kept.

use glam::{DVec3, Vec3};

use super::{GpuPart, GpuPrimitive, GpuScene, upload};
use crate::gpu::{Gpu, GpuError, SharedLayouts};
use crate::math::Camera;
use crate::passes::Sections;
use crate::scene::cut::cap_material;
use crate::scene::{Arrangement, Cut, Scene};

/// How much of the lists of a [`GpuScene`] is the scene itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Own {
    primitives: usize,
    meshes: usize,
    parts: usize,
}

impl Own {
    pub(super) fn new(primitives: usize, meshes: usize, parts: usize) -> Own {
        Own { primitives, meshes, parts }
    }
}

impl GpuScene {
    /// Replaces the caps by those of a cut.
    pub(super) fn close(
        &mut self,
        gpu: &Gpu,
        layouts: &SharedLayouts,
        scene: &Scene,
        arrangement: &Arrangement,
        cut: Cut,
    ) -> Result<(), GpuError> {
        self.primitives.truncate(self.own.primitives);
        self.primitives_of_mesh.truncate(self.own.meshes);
        self.parts_by_mesh.truncate(self.own.meshes);
        self.parts.truncate(self.own.parts);
        self.cut = cut;
        if self.cut.caps.is_empty() {
            return Ok(());
        }
        let mut places = Vec::new();
        let mut indices: Vec<[u32; 3]> = Vec::new();
        let mut runs = Vec::with_capacity(self.cut.caps.len());
        for cap in &self.cut.caps {
            let (vertex, first) = (places.len() as u32, indices.len() as u32);
            let numbered = upload::number_triangles(&cap.triangles, cap.positions.len());
            let position = |source: u32| {
                let [x, y] = cap.positions[source as usize];
                [x, y, 0.0]
            };
            places.extend(numbered.sources.iter().zip(&numbered.numbers).map(|(&s, &n)| upload::place(position(s), n)));
            indices.extend(numbered.triangles.iter().map(|t| t.map(|v| v + vertex)));
            runs.push(3 * first..3 * indices.len() as u32);
        }
        let vertex = wgpu::BufferUsages::VERTEX;
        let place = gpu.buffer_of("cap places", bytemuck::cast_slice(&places), vertex)?;
        let normals = vec![[0.0_f32, 0.0, 1.0]; places.len()];
        let normals = gpu.buffer_of("cap normals", bytemuck::cast_slice(&normals), vertex)?;
        let indices = gpu.buffer_of("cap indices", bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX)?;
        for (i, run) in runs.into_iter().enumerate() {
            let (owner, sphere, first_triangle, world_from_part) = {
                let cap = &self.cut.caps[i];
                (cap.part, cap.bounds.bounding_sphere(), cap.first_triangle, cap.world_from_cap)
            };
            let material = self.cap_material(gpu, layouts, scene, scene.parts[owner as usize].mesh)?;
            let mesh = self.primitives_of_mesh.len();
            self.primitives_of_mesh.push(self.primitives.len()..self.primitives.len() + 1);
            self.parts_by_mesh.push(vec![self.parts.len() as u32]);
            self.primitives.push(GpuPrimitive {
                material,
                place: place.clone(),
                normals: normals.clone(),
                extras: None,
                parameters: None,
                indices: indices.clone(),
                run,
            });
            self.parts.push(GpuPart {
                mesh,
                first_triangle,
                world_from_part,
                sphere,
                is_drawn: true,
                is_selected: arrangement.selected.contains(&owner),
            });
        }
        Ok(())
    }

    /// The material of the caps of a mesh's parts.
    fn cap_material(
        &mut self,
        gpu: &Gpu,
        layouts: &SharedLayouts,
        scene: &Scene,
        mesh: usize,
    ) -> Result<usize, GpuError> {
        if let Some(&material) = self.cap_materials.get(&mesh) {
            return Ok(material);
        }
        let made = upload::upload_plain_material(gpu, layouts, &cap_material(scene, mesh), &self.materials[0])?;
        self.materials.push(made);
        self.cap_materials.insert(mesh, self.materials.len() - 1);
        Ok(self.materials.len() - 1)
    }

    /// The section planes as a camera sees them; computed in 64 bits, so that a plane far from the origin stays exact.
    pub fn sections(&self, camera: &Camera) -> Sections {
        let view_from_world = camera.view_from_world();
        let world_from_view = view_from_world.inverse();
        let eye = world_from_view.transform_point3(DVec3::ZERO);
        let mut sections: Sections = bytemuck::Zeroable::zeroed();
        for (i, plane) in self.cut.planes.iter().enumerate().take(sections.planes.len()) {
            let normal: Vec3 = view_from_world.transform_vector3(plane.normal).as_vec3();
            let height = plane.normal.dot(eye) - plane.offset;
            sections.planes[i] = normal.extend(height as f32).to_array();
            sections.caps[i] = [plane.caps.start, plane.caps.end, 0, 0];
            sections.count += 1;
        }
        sections
    }
}
