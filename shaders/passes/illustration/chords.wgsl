//@ use passes/operators/around
//@ use passes/illustration/parameters
//@ use passes/illustration/chords_column
// Local feature size, second half: a layer's chord along an axis is itself and the runs to both sides; of a link it is the
// smaller one of both its layers', the same from either side.

@group(1) @binding(27) var<storage, read_write> runs: array<u32>;

// Along rows and along columns.
fn chords_of(slot: u32) -> vec2<u32> {
    let at = 4u * slot;
    let both = vec2<u32>(runs[at] + runs[at + 1u], runs[at + 2u] + runs[at + 3u]);
    return min(both + 1u, vec2<u32>(illustration.feature_size));
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
    let count = layer_count(pixel);
    let base = layer_base(pixel);
    let beside = beside(id.x, pixel);
    for (var index = 0u; index < count; index++) {
        let slot = base + index;
        let around = around(slot, beside);
        let own = chords_of(slot);
        let smaller = min(
            own.xxyy,
            vec4<u32>(
                chords_of(around.slots.x).x,
                chords_of(around.slots.y).x,
                chords_of(around.slots.z).y,
                chords_of(around.slots.w).y,
            ),
        );
        let chord = select(vec4<u32>(illustration.feature_size), smaller, around.there);
        chords[slot] = chord.x | (chord.y << 8u) | (chord.z << 16u) | (chord.w << 24u);
    }
}
