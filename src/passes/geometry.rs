//! The scene on the GPU, and drawing it: one instanced draw for every primitive of every mesh.
//!
//! Each triangle's first vertex carries the triangle's number in its mesh (the flat attribute of the first vertex reaches the
//! fragment shader), so the number travels with the triangle as data and no draw order, index order or instance order can
//! change it (T27). A vertex can carry one number: triangles are turned, without changing their winding, until each begins
//! with a vertex of its own, and where that fails a vertex is doubled.

mod caps;
pub mod cases;
mod upload;

use std::collections::HashMap;
use std::sync::Arc;

use glam::DMat4;

use super::{Context, InstanceUniform};
use crate::gpu::{Gpu, GpuError, RasterKernel, RasterSpec, ShaderSpec};
use crate::math::Sphere;
use crate::plan::{FramePlan, Pass};
use crate::scene::{Arrangement, Cut, SceneStats, Solids};

/// In which order parts are drawn. The picture does not depend on it, except through the ties of packed keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum DrawOrder {
    /// Nearest parts first: the k-buffer's chains stay short.
    #[default]
    FrontToBack,
    /// Shuffled, for tests.
    Shuffled(u64),
}

/// A scene in GPU memory.
pub struct GpuScene {
    /// What the planner needs to know of it.
    pub stats: SceneStats,
    /// Of the upload: no other one of this program has it.
    pub serial: u64,
    primitives: Vec<GpuPrimitive>,
    /// Run of each mesh in `primitives`.
    primitives_of_mesh: Vec<std::ops::Range<usize>>,
    materials: Vec<GpuMaterial>,
    parts: Vec<GpuPart>,
    /// Parts by mesh: parts of one mesh are one run.
    parts_by_mesh: Vec<Vec<u32>>,
    /// First triangle and radius of every part.
    pub part_table: wgpu::Buffer,
    /// How the parts are shown.
    pub arrangement: Arrangement,
    /// Section planes and caps.
    pub cut: Cut,
    solids: Solids,
    /// What belongs to the scene itself: caps come after it.
    own: caps::Own,
    /// The material of a mesh's caps, made when it is first cut.
    cap_materials: HashMap<usize, usize>,
}

struct GpuPrimitive {
    material: usize,
    /// Position, and the number of a triangle in the mesh.
    place: wgpu::Buffer,
    normals: wgpu::Buffer,
    /// Colour, uv sets, tangent; only where something reads them.
    extras: Option<wgpu::Buffer>,
    /// Scaled parameters, where the mesh has a parametrization.
    parameters: Option<wgpu::Buffer>,
    indices: wgpu::Buffer,
    /// Its run of `indices`.
    run: std::ops::Range<u32>,
}

struct GpuMaterial {
    masked: bool,
    plain: wgpu::BindGroup,
    textured: wgpu::BindGroup,
}

struct GpuPart {
    mesh: usize,
    first_triangle: u32,
    world_from_part: DMat4,
    sphere: Sphere,
    is_drawn: bool,
    is_selected: bool,
}

/// Which vertex data a geometry pass reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vertices {
    /// Depth and identity.
    Depth,
    /// Also the surface.
    Surface,
    /// Depth, identity and parameters, of primitives that have a parametrization.
    Parameters,
}

/// Instances of one frame, in draw order, and the run of each mesh.
pub struct Instances {
    /// Group 3.
    pub group: wgpu::BindGroup,
    /// For each mesh in draw order: its index and its run of instances.
    runs: Vec<(usize, std::ops::Range<u32>)>,
}

fn normal_rows(view_from_part: &DMat4) -> [[f32; 4]; 3] {
    let m = glam::DMat3::from_mat4(*view_from_part);
    // Cofactors: the inverse transpose up to the determinant, finite even where there is no inverse.
    let cofactors =
        glam::DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    let largest = cofactors.to_cols_array().into_iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let scale = if largest > 0.0 { sign / largest } else { 0.0 };
    let rows = cofactors.transpose();
    [rows.x_axis, rows.y_axis, rows.z_axis].map(|r| (r * scale).as_vec3().extend(0.0).to_array())
}

fn instance_of(part: &GpuPart, index: u32, view_from_world: &DMat4) -> InstanceUniform {
    let view_from_part = *view_from_world * part.world_from_part;
    let rows = view_from_part.transpose();
    let [normal_x, normal_y, normal_z] = normal_rows(&view_from_part);
    InstanceUniform {
        view_x: rows.x_axis.as_vec4().to_array(),
        view_y: rows.y_axis.as_vec4().to_array(),
        view_z: rows.z_axis.as_vec4().to_array(),
        normal_x,
        normal_y,
        normal_z,
        ids: [part.first_triangle, index, u32::from(view_from_part.determinant() < 0.0), 0],
    }
}

impl GpuScene {
    /// Instances of all parts that are drawn for a view, parts of one mesh together.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn instances(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        view_from_world: &DMat4,
        order: DrawOrder,
    ) -> Result<Instances, GpuError> {
        self.instances_where(gpu, layout, view_from_world, order, &|_| true)
    }

    /// [`GpuScene::instances`], but only of parts whose bounding spheres, in scene space, are wanted.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn instances_where(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        view_from_world: &DMat4,
        order: DrawOrder,
        is_wanted: &dyn Fn(&Sphere) -> bool,
    ) -> Result<Instances, GpuError> {
        let is_drawn = |part: &u32| {
            let part = &self.parts[*part as usize];
            part.is_drawn && is_wanted(&part.sphere)
        };
        let nearest = |part: u32| {
            let sphere = self.parts[part as usize].sphere;
            -view_from_world.transform_point3(sphere.center).z - sphere.radius
        };
        let mut meshes: Vec<(f64, usize, Vec<u32>)> = self
            .parts_by_mesh
            .iter()
            .enumerate()
            .map(|(mesh, parts)| (mesh, parts.iter().copied().filter(is_drawn).collect()))
            .filter(|(_, parts): &(usize, Vec<u32>)| !parts.is_empty())
            .map(|(mesh, mut parts)| {
                match order {
                    DrawOrder::FrontToBack => parts.sort_by(|&a, &b| nearest(a).total_cmp(&nearest(b))),
                    DrawOrder::Shuffled(seed) => upload::shuffle(&mut parts, seed ^ mesh as u64),
                }
                (nearest(parts[0]), mesh, parts)
            })
            .collect();
        match order {
            DrawOrder::FrontToBack => meshes.sort_by(|a, b| a.0.total_cmp(&b.0)),
            DrawOrder::Shuffled(seed) => upload::shuffle(&mut meshes, seed),
        }
        let mut instances = Vec::with_capacity(self.parts.len());
        let mut runs = Vec::with_capacity(meshes.len());
        for (_, mesh, parts) in meshes {
            let first = instances.len() as u32;
            instances.extend(parts.iter().map(|&p| instance_of(&self.parts[p as usize], p, view_from_world)));
            runs.push((mesh, first..instances.len() as u32));
        }
        self.upload_instances(gpu, layout, &instances, runs)
    }

    /// Instances in the order of the parts, one run a part: for the depth test, where the first of equal depths wins.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn instances_in_part_order(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        view_from_world: &DMat4,
    ) -> Result<Instances, GpuError> {
        self.instances_of(gpu, layout, view_from_world, |part| part.is_drawn)
    }

    /// Instances of the selected parts that are drawn, as [`GpuScene::instances_in_part_order`].
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn instances_selected(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        view_from_world: &DMat4,
    ) -> Result<Instances, GpuError> {
        self.instances_of(gpu, layout, view_from_world, |part| part.is_drawn && part.is_selected)
    }

    fn instances_of(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        view_from_world: &DMat4,
        is_wanted: impl Fn(&GpuPart) -> bool,
    ) -> Result<Instances, GpuError> {
        let wanted = || self.parts.iter().enumerate().filter(|(_, p)| is_wanted(p));
        let instances: Vec<_> = wanted().map(|(i, p)| instance_of(p, i as u32, view_from_world)).collect();
        let runs = wanted().enumerate().map(|(at, (_, p))| (p.mesh, at as u32..at as u32 + 1)).collect();
        self.upload_instances(gpu, layout, &instances, runs)
    }

    fn upload_instances(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        instances: &[InstanceUniform],
        runs: Vec<(usize, std::ops::Range<u32>)>,
    ) -> Result<Instances, GpuError> {
        // An empty scene still binds one instance that is never drawn.
        let empty = [bytemuck::Zeroable::zeroed()];
        let data: &[InstanceUniform] = if instances.is_empty() { &empty } else { instances };
        let buffer = gpu.buffer_of("instances", bytemuck::cast_slice(data), wgpu::BufferUsages::STORAGE)?;
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("instances"),
            layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
        });
        Ok(Instances { group, runs })
    }
}

/// Vertex module and streams for a primitive in a pass.
fn vertex_module(vertices: Vertices, textured: bool) -> (&'static str, u32) {
    match (vertices, textured) {
        (Vertices::Depth, false) => ("scene/vertex_depth", 1),
        (Vertices::Surface, false) => ("scene/vertex_plain", 2),
        // Parameters take the place of normals in the second stream. What a mask cuts out is not in the store: no texture is read.
        (Vertices::Parameters, _) => ("scene/vertex_parameters", 2),
        (_, true) => ("scene/vertex_textured", 3),
    }
}

/// Whether a pass reads the textures of a primitive of this material.
fn reads_textures(vertices: Vertices, material: &GpuMaterial) -> bool {
    match vertices {
        Vertices::Surface => true,
        Vertices::Depth => material.masked,
        Vertices::Parameters => false,
    }
}

/// The vertex stages of a geometry pass: for primitives without and with textures.
pub fn vertex_stages(vertices: Vertices) -> [ShaderSpec; 2] {
    [false, true].map(|textured| ShaderSpec::new(vertex_module(vertices, textured).0))
}

/// The module that gives parts the colours of the user's, where there are any.
pub fn recolor(plan: &FramePlan) -> &'static str {
    if plan.recolored { "scene/recolor_by_part" } else { "scene/recolor_none" }
}

/// The module that lets section planes cut fragments, where there are any.
pub fn clip(plan: &FramePlan) -> &'static str {
    CLIP[usize::from(plan.section_planes > 0)]
}

/// The modules that decide whether a fragment is cut away: without and with section planes.
pub const CLIP: [&str; 2] = ["scene/clip_none", "scene/clip_planes"];

/// A fragment stage: adds its modules to a shader whose root is the vertex module.
pub type FragmentStage<'a> = &'a dyn Fn(ShaderSpec) -> ShaderSpec;

struct Pipelines {
    plain: Arc<RasterKernel>,
    textured: Option<Arc<RasterKernel>>,
}

/// What a draw binds besides the material.
struct Groups {
    frame: wgpu::BindGroup,
    plain: wgpu::BindGroup,
    textured: Option<wgpu::BindGroup>,
}

fn draw_runs(
    pass: &mut wgpu::RenderPass<'_>,
    scene: &GpuScene,
    instances: &Instances,
    vertices: Vertices,
    pipelines: &Pipelines,
    groups: &Groups,
) {
    pass.set_bind_group(0, &groups.frame, &[]);
    pass.set_bind_group(3, &instances.group, &[]);
    let mut bound = None;
    for (mesh, run) in &instances.runs {
        for primitive in &scene.primitives[scene.primitives_of_mesh[*mesh].clone()] {
            let material = &scene.materials[primitive.material];
            let textured = primitive.extras.is_some() && reads_textures(vertices, material);
            let (kernel, group) = match (&pipelines.textured, &groups.textured) {
                (Some(kernel), Some(group)) if textured => (kernel, group),
                _ => (&pipelines.plain, &groups.plain),
            };
            let second = match vertices {
                Vertices::Parameters => primitive.parameters.as_ref(),
                Vertices::Depth | Vertices::Surface => Some(&primitive.normals),
            };
            let Some(second) = second else { continue };
            if bound != Some(textured) {
                pass.set_pipeline(&kernel.pipeline);
                pass.set_bind_group(1, group, &[]);
                bound = Some(textured);
            }
            pass.set_vertex_buffer(0, primitive.place.slice(..));
            if vertices != Vertices::Depth || textured {
                pass.set_vertex_buffer(1, second.slice(..));
                pass.set_bind_group(2, if textured { &material.textured } else { &material.plain }, &[]);
            }
            if textured && let Some(extras) = &primitive.extras {
                pass.set_vertex_buffer(2, extras.slice(..));
            }
            pass.set_index_buffer(primitive.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(primitive.run.clone(), 0, run.clone());
        }
    }
}

fn pipelines(
    context: &Context<'_>,
    scene: &GpuScene,
    vertices: Vertices,
    fragment: FragmentStage<'_>,
    base: RasterSpec,
) -> Result<Pipelines, GpuError> {
    let kernel = |textured| {
        let (module, streams) = vertex_module(vertices, textured);
        let spec = fragment(ShaderSpec::new(module));
        context.shaders.raster(&spec, &RasterSpec { streams, textured, ..base })
    };
    let needs_textured =
        scene.primitives.iter().any(|p| p.extras.is_some() && reads_textures(vertices, &scene.materials[p.material]));
    Ok(Pipelines { plain: kernel(false)?, textured: if needs_textured { Some(kernel(true)?) } else { None } })
}

/// A pass over the scene into a target of this format that nothing is written to yet; streams and textures follow from the
/// primitives.
fn target_spec(target: wgpu::TextureFormat) -> RasterSpec {
    RasterSpec { streams: 0, textured: false, target, writes_color: false, depth_test: false, blend: false }
}

/// A geometry pass that only writes storage: draws the band's part of the scene, no target is written.
///
/// # Errors
/// [`GpuError`] if a shader does not compile or a resource is missing.
pub fn draw(
    context: &mut Context<'_>,
    scene: &GpuScene,
    pass: Pass,
    vertices: Vertices,
    fragment: FragmentStage<'_>,
) -> Result<(), GpuError> {
    let base = target_spec(wgpu::TextureFormat::R8Unorm);
    let pipelines = pipelines(context, scene, vertices, fragment, base)?;
    let blank = context.blank;
    run_pass(context, scene, pass, vertices, &pipelines, blank, None)
}

/// The opaque pass: nearest fragment by the depth test, written to `target`.
///
/// # Errors
/// [`GpuError`] if a shader does not compile or a resource is missing.
pub fn draw_opaque(
    context: &mut Context<'_>,
    scene: &GpuScene,
    target: &wgpu::TextureView,
    depth: &wgpu::TextureView,
    fragment: FragmentStage<'_>,
) -> Result<(), GpuError> {
    let base = RasterSpec { writes_color: true, depth_test: true, ..target_spec(wgpu::TextureFormat::Rg32Uint) };
    let pipelines = pipelines(context, scene, Vertices::Surface, fragment, base)?;
    run_pass(context, scene, Pass::Opaque, Vertices::Surface, &pipelines, target, Some(depth))
}

/// The pixels that the drawn parts cover, written to `target` (R8Unorm) without any depth test.
///
/// # Errors
/// [`GpuError`] if a shader does not compile or a resource is missing.
pub fn draw_mask(
    context: &mut Context<'_>,
    scene: &GpuScene,
    target: &wgpu::TextureView,
    fragment: FragmentStage<'_>,
) -> Result<(), GpuError> {
    let base = RasterSpec { writes_color: true, ..target_spec(wgpu::TextureFormat::R8Unorm) };
    let pipelines = pipelines(context, scene, Vertices::Depth, fragment, base)?;
    run_pass(context, scene, Pass::OutlineMask, Vertices::Depth, &pipelines, target, None)
}

/// Unsorted blending of everything into `target` (Rgba16Float): the lower bound that benchmarks compare with.
///
/// # Errors
/// [`GpuError`] if a shader does not compile or a resource is missing.
pub fn draw_unsorted(
    context: &mut Context<'_>,
    scene: &GpuScene,
    target: &wgpu::TextureView,
    fragment: FragmentStage<'_>,
) -> Result<(), GpuError> {
    let base = RasterSpec { writes_color: true, blend: true, ..target_spec(wgpu::TextureFormat::Rgba16Float) };
    let pipelines = pipelines(context, scene, Vertices::Surface, fragment, base)?;
    run_pass(context, scene, Pass::Opaque, Vertices::Surface, &pipelines, target, None)
}

fn run_pass(
    context: &mut Context<'_>,
    scene: &GpuScene,
    pass: Pass,
    vertices: Vertices,
    pipelines: &Pipelines,
    target: &wgpu::TextureView,
    depth: Option<&wgpu::TextureView>,
) -> Result<(), GpuError> {
    let groups = Groups {
        frame: context.frame.clone(),
        plain: pipelines.plain.bind(context.gpu, context.resources)?,
        textured: match &pipelines.textured {
            Some(p) => Some(p.bind(context.gpu, context.resources)?),
            None => None,
        },
    };
    let (columns, rows, first_row) = (context.columns.clone(), context.rows(), context.band.first_row);
    let instances = Arc::clone(&context.instances);
    let clear = matches!(pass, Pass::Opaque | Pass::OutlineMask);
    let mut render_pass = context.recorder.raster(pass, target, clear, depth);
    render_pass.set_scissor_rect(columns.start, first_row, columns.end - columns.start, rows);
    draw_runs(&mut render_pass, scene, &instances, vertices, pipelines, &groups);
    drop(render_pass);
    context.recorder.end_pass(pass)
}
