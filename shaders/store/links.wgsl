// Neighbours of a layer: four 16-bit layer indices in the adjacent pixels, right, left, down, up; with two values for
// none (T10): missing is an edge of the part, unknown is where nothing can be said.

const MISSING: u32 = 0xFFFFu;
const UNKNOWN: u32 = 0xFFFEu;
const LARGEST_LINK: u32 = 0xFFFDu;

fn link_in(words: vec2<u32>, direction: u32) -> u32 {
    let word = select(words.x, words.y, direction >= 2u);
    return (word >> ((direction & 1u) * 16u)) & 0xFFFFu;
}
