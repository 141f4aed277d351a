// No tail: what lies behind the k nearest is counted and left out.

fn store_tail(pixel: u32, v: Varyings, surface: Captured, dropped: bool) {
}
