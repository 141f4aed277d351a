// Fragments lie in the run of their pixel.

fn source_of(base: u32, source: u32) -> u32 {
    return base + source;
}
