// Fragments of a linked list lie anywhere.

fn source_of(base: u32, source: u32) -> u32 {
    return source;
}
