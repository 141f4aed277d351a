//@ use store/key_wide64
//@ use store/part_table

fn part_of_layer(slot: u32) -> u32 {
    return part_of_triangle(keys[slot].x);
}
