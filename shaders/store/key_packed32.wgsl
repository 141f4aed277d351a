//@ use common/frame
//@ use store/packed_depth
// Key column, the paper's: 16-bit depth over 16-bit shape id (Murray 2016, section 4.2).

@group(1) @binding(2) var<storage, read_write> keys: array<u32>;

fn depth_word(key: u32) -> u32 {
    return key >> 16u;
}

fn view_depth_of_word(word: u32) -> f32 {
    return view_depth_of_packed(word);
}
