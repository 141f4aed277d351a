//@ use store/part_column
// The part of a layer, where the column is there.

fn part_of_layer(slot: u32) -> u32 {
    return parts[slot];
}
