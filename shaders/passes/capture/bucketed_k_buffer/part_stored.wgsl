//@ use store/part_column
// The part column is written with the surface: the fragment knows its part.

fn store_part(slot: u32, part: u32) {
    parts[slot] = part;
}
