// Second half of a global operator: `settle()` makes a table of what was gathered from the whole image.

@compute @workgroup_size(1)
fn main() {
    settle();
}
