//! Rust twins of the structs in the shaders. A test compares every name, offset and size through naga's reflection.

use bytemuck::{Pod, Zeroable};

/// `Frame` in `common/frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FrameUniform {
    /// Clip space from view space, column-major.
    pub clip_from_view: [[f32; 4]; 4],
    /// Scale (xy) and offset (zw) that give view-space xy of a pixel, per unit of depth under perspective.
    pub unproject: [f32; 4],
    /// Width and height of the image.
    pub size: [u32; 2],
    /// First captured row.
    pub first_row: u32,
    /// One past the last captured row.
    pub end_row: u32,
    /// First row written to the image.
    pub first_output_row: u32,
    /// One past the last row written to the image.
    pub end_output_row: u32,
    /// 1 for parallel projection.
    pub orthographic: u32,
    /// Unused.
    pub _pad: u32,
    /// Depth of the near plane, scene units.
    pub near: f32,
    /// Depth of the far plane, scene units.
    pub far: f32,
    /// Least depth of the scene's bounding sphere.
    pub depth_min: f32,
    /// One over the sphere's diameter.
    pub depth_scale: f32,
}

/// `StoreLayout` in `store/layout_*.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct StoreLayout {
    /// Slots a pixel, for rows.
    pub k: u32,
    /// Slots in the whole store.
    pub capacity: u32,
    /// Layers of a pixel that one invocation takes in passes that read other pixels' lists for each of them.
    pub chunk: u32,
    /// Unused.
    pub _pad: u32,
}

/// `Instance` in `scene/instance.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct InstanceUniform {
    /// First row of view_from_part.
    pub view_x: [f32; 4],
    /// Second row.
    pub view_y: [f32; 4],
    /// Third row.
    pub view_z: [f32; 4],
    /// First row of the normal matrix.
    pub normal_x: [f32; 4],
    /// Second row.
    pub normal_y: [f32; 4],
    /// Third row.
    pub normal_z: [f32; 4],
    /// First triangle, part, whether the transform mirrors, unused.
    pub ids: [u32; 4],
}

/// `Material` in `scene/material.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct MaterialUniform {
    /// Base colour factor, linear.
    pub base_color: [f32; 4],
    /// Emitted light; w: scale of the normal map.
    pub emissive: [f32; 4],
    /// Metalness, roughness, occlusion strength, alpha cutoff.
    pub factors: [f32; 4],
    /// Alpha mode, unlit, bits of textures present, bits of those on uv set 1.
    pub modes: [u32; 4],
    /// Two rows a texture.
    pub uv_rows: [[f32; 4]; 10],
}

/// `PartFacts` in `store/part_table.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct PartFacts {
    /// Number of the part's first triangle.
    pub first_triangle: u32,
    /// One over the radius of its bounding sphere; 1 for a point, so that nothing is divided by zero.
    pub inverse_radius: f32,
    /// That radius, scene units.
    pub radius: f32,
    /// Opacity factor as the bits of a float from 0 to 1, whose two highest bits are free: bit 31 solid, bit 30 ghosted.
    pub look: u32,
    /// Linear base colour of the user's; w: 1 if there is one.
    pub color: [f32; 4],
}

/// `Sections` in `scene/sections.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Sections {
    /// View space: xyz · point + w > 0 is cut away.
    pub planes: [[f32; 4]; 6],
    /// For each plane the run of parts that close its cut: first, end, unused.
    pub caps: [[u32; 4]; 6],
    /// How many planes there are.
    pub count: u32,
    /// Unused.
    pub _pad: [u32; 3],
}

/// `CurvatureParameters` in `passes/features/curvature.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct CurvatureParameters {
    /// Sensitivity times unit of length.
    pub scale: f32,
    /// Sensitivity, where the unit is the part's radius.
    pub part_scale: f32,
    /// Steps of the estimate.
    pub radius: u32,
    /// Steps of the walk.
    pub reach: u32,
    /// Width of lines, pixels.
    pub line: f32,
    /// Cosine of the crease angle.
    pub crease_cosine: f32,
    /// 0 surface, 1 view-centred.
    pub kind: u32,
    /// Unused.
    pub _pad: u32,
}

/// `ShadeParameters` in `passes/shade.wgsl`: the six vectors of the light rig.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ShadeParameters {
    /// Key, fill, rim, sky, ground, up.
    pub lights: [[f32; 4]; 6],
}

/// `TransferParameters` in `passes/opacity/transfer.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct TransferParameters {
    /// 0 tint, 1 multiply.
    pub color_mode: u32,
    /// Multiplies opacity.
    pub gain: f32,
    /// Opacity of every layer under the constant model.
    pub constant: f32,
    /// Multiplies the opacity of ghosted parts.
    pub ghost: f32,
}

/// `ModelParameters` in `passes/opacity/model_parameters.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ModelParameters {
    /// Opacity of all layers of a pixel together.
    pub share: f32,
    /// Opacity at the lower end of what the model follows.
    pub low: f32,
    /// Opacity at the upper end.
    pub high: f32,
    /// Sensitivity, times the image's shorter side in pixels.
    pub scale: f32,
}

/// `IllustrationParameters` in `passes/illustration/parameters.wgsl`: vectors hold what is α's, β's and γ's.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct IllustrationParameters {
    /// λ.
    pub lambda: [f32; 4],
    /// 0 nothing, 1 heat, 2 max.
    pub diffusion: [u32; 4],
    /// 0 none, 1 bell, 2 power.
    pub profile: [u32; 4],
    /// The profiles' parameters.
    pub p: [f32; 4],
    /// What is multiplied after the profiles.
    pub strength: [f32; 4],
    /// What the base is multiplied with.
    pub constant: f32,
    /// Steps of heat.
    pub heat_steps: u32,
    /// Which of the paper's forms is followed.
    pub printed: u32,
    /// Pixels below which a surface is small; 0 for isotropic diffusion.
    pub feature_size: u32,
}

/// `Sweep` in `passes/illustration/runs.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct SweepParameters {
    /// The first pixel of each line.
    pub first: u32,
    /// One past the last.
    pub end: u32,
    /// Unused.
    pub _pad: [u32; 2],
}

/// `StepParameters` in `passes/operators/next_step.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct StepParameters {
    /// Steps that are always taken.
    pub always: u32,
    /// 0 for never stopping early.
    pub early_stop: u32,
    /// Unused.
    pub _pad: [u32; 2],
}

/// `BlendParameters` in `passes/composite/blend.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct BlendParameters {
    /// Multiplies the opacity of every layer.
    pub opacity: f32,
    /// Multiplies the opacity of ghosted parts.
    pub ghost: f32,
    /// Unused.
    pub _pad: [u32; 2],
}

/// `OutlineParameters` in `passes/composite/outline.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct OutlineParameters {
    /// Linear colour, opaque.
    pub color: [f32; 4],
    /// Width of the line, pixels.
    pub width: f32,
    /// Unused.
    pub _pad: [u32; 3],
}
