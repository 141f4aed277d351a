// The part column is not needed, or there already.

fn store_part(slot: u32, part: u32) {
}
