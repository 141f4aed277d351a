// Illustrative transparency: what its three fields are set by. x is alpha (base), y beta (silhouettes), z gamma (halos).

struct IllustrationParameters {
    lambda: vec4<f32>,
    // 0 nothing, 1 heat, 2 max.
    diffusion: vec4<u32>,
    // Of the profiles: 0 none, 1 bell, 2 power.
    profile: vec4<u32>,
    p: vec4<f32>,
    // What silhouettes and halos are multiplied with after their profiles.
    strength: vec4<f32>,
    // What the base is multiplied with: the opacity of every layer where it is constant.
    constant: f32,
    // Steps of heat.
    heat_steps: u32,
    // Which of the paper's forms is followed: 1 Laplacian, 2 propagation, 3 index steps.
    printed: u32,
    // Pixels below which a surface is small; 0 for isotropic diffusion.
    feature_size: u32,
}
@group(1) @binding(24) var<uniform> illustration: IllustrationParameters;

// Fields of a layer: alpha, beta, gamma, and which of them are fixed: 1 beta, 2 gamma.
const FIXED_BETA: u32 = 1u;
const FIXED_GAMMA: u32 = 2u;

const PRINTED_LAPLACIAN: u32 = 1u;
const PRINTED_PROPAGATION: u32 = 2u;
const PRINTED_INDEX_STEPS: u32 = 3u;
