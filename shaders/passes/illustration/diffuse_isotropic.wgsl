//@ use passes/illustration/diffuse
// Everything flows everywhere alike: isotropic diffusion, as in the paper.

fn conductance_of(slot: u32) -> vec4<f32> {
    return vec4<f32>(1.0);
}
