//@ use passes/illustration/diffuse
//@ use passes/illustration/parameters
//@ use passes/illustration/chords_column
// Anisotropic diffusion: what is narrow along a link's axis conducts less, in proportion.

fn conductance_of(slot: u32) -> vec4<f32> {
    let chord = vec4<f32>(unpack4xU8(chords[slot]));
    return chord / f32(illustration.feature_size);
}
