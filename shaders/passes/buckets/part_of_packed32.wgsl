//@ use store/key_packed32

fn part_of_layer(slot: u32) -> u32 {
    return keys[slot] & 0xFFFFu;
}
