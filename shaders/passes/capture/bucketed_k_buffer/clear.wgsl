//@ use store/layout_rows
//@ use passes/capture/bucketed_k_buffer/tally
// Empties the rows: every slot gets the key that no fragment has.

@group(1) @binding(2) var<storage, read_write> key_words: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = group.y * frame.size.x + group.x * 64u + local;
    if group.x * 64u + local >= frame.size.x {
        return;
    }
    atomicStore(&tally[2u * pixel], 0u);
    atomicStore(&tally[2u * pixel + 1u], 0u);
    let begin = pixel * store_layout.k * KEY_WORDS;
    for (var i = 0u; i < store_layout.k * KEY_WORDS; i++) {
        key_words[begin + i] = EMPTY;
    }
}
