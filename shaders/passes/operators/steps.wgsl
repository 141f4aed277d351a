// How far an operator that is repeated has come: steps begun, whether the present one changed anything, steps taken.

@group(1) @binding(21) var<storage, read_write> steps: array<atomic<u32>>;

// The number of the present step, from 0.
fn present_step() -> u32 {
    return atomicLoad(&steps[0]) - 1u;
}

fn note_change() {
    if atomicLoad(&steps[1]) == 0u {
        atomicStore(&steps[1], 1u);
    }
}
