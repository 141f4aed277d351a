//@ use common/frame
// Count: how many fragments each pixel has.

@group(1) @binding(0) var<storage, read_write> pixel_counts: array<atomic<u32>>;

@fragment
fn fragment_main(v: Varyings) -> @location(0) vec4<f32> {
    let clipped = is_clipped(v.position, v.part);
    if clipped || is_cut_out(v) {
        discard;
    }
    atomicAdd(&pixel_counts[pixel_of_position(v.position)], 1u);
    return vec4<f32>(0.0);
}
