//! Pipelines whose bindings are found by reflection: a pass names a shader, and the buffers that it binds are looked up by
//! the names of the shader's variables.

use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::shaders::Composed;
use super::{Gpu, GpuError, Resources};

/// A binding of group 1.
#[derive(Clone, Debug, PartialEq)]
struct Binding {
    name: String,
    index: u32,
    ty: wgpu::BindingType,
}

/// A compute pipeline and the bindings of its group 1.
pub struct Kernel {
    /// The pipeline.
    pub pipeline: wgpu::ComputePipeline,
    /// What to call it.
    pub name: String,
    layout: wgpu::BindGroupLayout,
    bindings: Vec<Binding>,
}

/// A render pipeline and the bindings of its group 1.
pub struct RasterKernel {
    /// The pipeline.
    pub pipeline: wgpu::RenderPipeline,
    /// What to call it.
    pub name: String,
    layout: wgpu::BindGroupLayout,
    bindings: Vec<Binding>,
}

/// Which vertex streams and targets a render pipeline has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RasterSpec {
    /// How many of the vertex streams are read: 1 position and number, 2 also normals, 3 also colour, uv, tangent.
    pub streams: u32,
    /// Whether material textures are bound (else only its constants, if it reads any).
    pub textured: bool,
    /// Format of the colour target.
    pub target: wgpu::TextureFormat,
    /// Whether the target is written; otherwise it only gives the size.
    pub writes_color: bool,
    /// Whether the nearest fragment wins by a depth buffer (reversed).
    pub depth_test: bool,
    /// Whether colours are added up, each weighted by its alpha: the unsorted blend of the benchmark.
    pub blend: bool,
}

/// Bind group layouts of groups 0, 2 and 3.
pub struct SharedLayouts {
    /// Group 0: the frame.
    pub frame: wgpu::BindGroupLayout,
    /// Group 2 of plain primitives: the material's constants.
    pub material: wgpu::BindGroupLayout,
    /// Group 2 of textured primitives: constants, five textures, five samplers.
    pub textured_material: wgpu::BindGroupLayout,
    /// Group 3: instances.
    pub instances: wgpu::BindGroupLayout,
}

fn buffer_entry(
    binding: u32,
    visibility: wgpu::ShaderStages,
    ty: wgpu::BufferBindingType,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}

impl SharedLayouts {
    /// Makes the layouts.
    pub fn new(gpu: &Gpu) -> SharedLayouts {
        use wgpu::{BufferBindingType, ShaderStages};
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let constants = buffer_entry(0, ShaderStages::FRAGMENT, BufferBindingType::Uniform);
        let mut textured = vec![constants];
        for i in 0..5 {
            textured.push(wgpu::BindGroupLayoutEntry {
                binding: 2 * i + 1,
                visibility: ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: true },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                count: None,
            });
            textured.push(wgpu::BindGroupLayoutEntry {
                binding: 2 * i + 2,
                visibility: ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                count: None,
            });
        }
        SharedLayouts {
            frame: layout(
                "frame",
                &[buffer_entry(0, ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE, BufferBindingType::Uniform)],
            ),
            material: layout("material", &[constants]),
            textured_material: layout("textured material", &textured),
            instances: layout(
                "instances",
                &[buffer_entry(0, ShaderStages::VERTEX, BufferBindingType::Storage { read_only: true })],
            ),
        }
    }
}

fn shader_error(composed: &Composed, location: Option<naga::SourceLocation>, reason: String) -> GpuError {
    let (file, line) = location.map_or(("<shader>", 0), |l| composed.origin(l.line_number));
    GpuError::Shader { file: file.to_owned(), line, reason }
}

/// Parses and validates.
fn parse(composed: &Composed) -> Result<(naga::Module, naga::valid::ModuleInfo), GpuError> {
    let module = naga::front::wgsl::parse_str(&composed.text)
        .map_err(|e| shader_error(composed, e.location(&composed.text), e.message().to_owned()))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|e| shader_error(composed, e.location(&composed.text), format!("{:?}", e.into_inner())))?;
    Ok((module, info))
}

/// Whether a shader is valid, without a device.
pub(super) fn check(composed: &Composed) -> Result<(), GpuError> {
    parse(composed).map(|_| ())
}

/// What the entry point binds in group 1.
fn reflect(
    composed: &Composed,
    entry: &str,
    stage: wgpu::ShaderStages,
) -> Result<(Vec<Binding>, wgpu::ShaderStages), GpuError> {
    let (module, info) = parse(composed)?;
    let index = module
        .entry_points
        .iter()
        .position(|e| e.name == entry)
        .ok_or_else(|| shader_error(composed, None, format!("there is no entry point '{entry}'")))?;
    let used = info.get_entry_point(index);
    let mut bindings = Vec::new();
    for (handle, variable) in module.global_variables.iter() {
        let Some(binding) = variable.binding else { continue };
        if binding.group != 1 || used[handle].is_empty() {
            continue;
        }
        let ty = binding_type(&module, variable)
            .ok_or_else(|| shader_error(composed, None, format!("binding '{:?}' has no known type", variable.name)))?;
        bindings.push(Binding { name: variable.name.clone().unwrap_or_default(), index: binding.binding, ty });
    }
    bindings.sort_by_key(|b| b.index);
    Ok((bindings, stage))
}

fn binding_type(module: &naga::Module, variable: &naga::GlobalVariable) -> Option<wgpu::BindingType> {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    match variable.space {
        naga::AddressSpace::Uniform => Some(buffer(wgpu::BufferBindingType::Uniform)),
        naga::AddressSpace::Storage { access } => {
            Some(buffer(wgpu::BufferBindingType::Storage { read_only: !access.contains(naga::StorageAccess::STORE) }))
        }
        _ => match module.types[variable.ty].inner {
            naga::TypeInner::Image { class: naga::ImageClass::Sampled { kind, .. }, .. } => {
                Some(wgpu::BindingType::Texture {
                    sample_type: match kind {
                        naga::ScalarKind::Uint => wgpu::TextureSampleType::Uint,
                        _ => wgpu::TextureSampleType::Float { filterable: false },
                    },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                })
            }
            naga::TypeInner::Image { class: naga::ImageClass::Storage { format, .. }, .. } => {
                let format = match format {
                    naga::StorageFormat::Rgba32Float => wgpu::TextureFormat::Rgba32Float,
                    _ => return None,
                };
                Some(wgpu::BindingType::StorageTexture {
                    access: wgpu::StorageTextureAccess::WriteOnly,
                    format,
                    view_dimension: wgpu::TextureViewDimension::D2,
                })
            }
            _ => None,
        },
    }
}

fn group_layout(gpu: &Gpu, name: &str, bindings: &[Binding], visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = bindings
        .iter()
        .map(|b| wgpu::BindGroupLayoutEntry { binding: b.index, visibility, ty: b.ty, count: None })
        .collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries })
}

fn module_of(gpu: &Gpu, name: &str, composed: &Composed) -> wgpu::ShaderModule {
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(composed.text.as_str().into()),
    })
}

/// Compiles a compute pipeline.
pub(super) fn compile_compute(
    gpu: &Gpu,
    shared: &SharedLayouts,
    name: &str,
    composed: &Composed,
    entry: &str,
) -> Result<Kernel, GpuError> {
    let (bindings, visibility) = reflect(composed, entry, wgpu::ShaderStages::COMPUTE)?;
    let layout = group_layout(gpu, name, &bindings, visibility);
    let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(&shared.frame), Some(&layout)],
        immediate_size: 0,
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(name),
        layout: Some(&pipeline_layout),
        module: &module_of(gpu, name, composed),
        entry_point: Some(entry),
        compilation_options: Default::default(),
        cache: None,
    });
    gpu.check()?;
    Ok(Kernel { pipeline, name: name.to_owned(), layout, bindings })
}

/// Compiles a render pipeline.
pub(super) fn compile_raster(
    gpu: &Gpu,
    shared: &SharedLayouts,
    name: &str,
    composed: &Composed,
    spec: &RasterSpec,
) -> Result<RasterKernel, GpuError> {
    let (bindings, visibility) = reflect(composed, "fragment_main", wgpu::ShaderStages::FRAGMENT)?;
    let layout = group_layout(gpu, name, &bindings, visibility);
    let material = match (spec.streams, spec.textured) {
        (1, _) => None,
        (_, false) => Some(&shared.material),
        (_, true) => Some(&shared.textured_material),
    };
    let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(&shared.frame), Some(&layout), material, Some(&shared.instances)],
        immediate_size: 0,
    });
    let module = module_of(gpu, name, composed);
    let streams = [
        wgpu::VertexBufferLayout {
            array_stride: 16,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Uint32],
        },
        wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![2 => Float32x3],
        },
        wgpu::VertexBufferLayout {
            array_stride: 48,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![3 => Float32x4, 4 => Float32x4, 5 => Float32x4],
        },
    ];
    let buffers: Vec<_> = streams.into_iter().take(spec.streams as usize).map(Some).collect();
    let add = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::SrcAlpha,
        dst_factor: wgpu::BlendFactor::OneMinusSrcAlpha,
        operation: wgpu::BlendOperation::Add,
    };
    let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(name),
        layout: Some(&pipeline_layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex_main"),
            compilation_options: Default::default(),
            buffers: &buffers,
        },
        // Both sides of every triangle are layers.
        primitive: wgpu::PrimitiveState { cull_mode: None, ..Default::default() },
        depth_stencil: spec.depth_test.then(|| wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment_main"),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: spec.target,
                blend: spec.blend.then_some(wgpu::BlendState { color: add, alpha: add }),
                write_mask: if spec.writes_color { wgpu::ColorWrites::ALL } else { wgpu::ColorWrites::empty() },
            })],
        }),
        multiview_mask: None,
        cache: None,
    });
    gpu.check()?;
    Ok(RasterKernel { pipeline, name: name.to_owned(), layout, bindings })
}

fn bind(
    gpu: &Gpu,
    name: &str,
    layout: &wgpu::BindGroupLayout,
    bindings: &[Binding],
    resources: &Resources,
) -> Result<wgpu::BindGroup, GpuError> {
    let entries = bindings
        .iter()
        .map(|b| Ok(wgpu::BindGroupEntry { binding: b.index, resource: resources.binding(name, &b.name)? }))
        .collect::<Result<Vec<_>, GpuError>>()?;
    Ok(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(name), layout, entries: &entries }))
}

impl Kernel {
    /// Group 1, with resources by the names of the shader's variables.
    ///
    /// # Errors
    /// [`GpuError::Unbound`] if a resource is missing.
    pub fn bind(&self, gpu: &Gpu, resources: &Resources) -> Result<wgpu::BindGroup, GpuError> {
        bind(gpu, &self.name, &self.layout, &self.bindings, resources)
    }
}

impl RasterKernel {
    /// Group 1, with resources by the names of the shader's variables.
    ///
    /// # Errors
    /// [`GpuError::Unbound`] if a resource is missing.
    pub fn bind(&self, gpu: &Gpu, resources: &Resources) -> Result<wgpu::BindGroup, GpuError> {
        bind(gpu, &self.name, &self.layout, &self.bindings, resources)
    }
}
