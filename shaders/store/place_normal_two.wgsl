// Writes the normal of a layer whose depth word is there already.

fn place_normal(slot: u32, words: ShapeWords) {
    shapes[slot].y = words.y;
}
