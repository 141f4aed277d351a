// How far an operator that is repeated has come.

// Steps begun, whether the present one changed anything, steps taken, layers listed.
@group(1) @binding(21) var<storage, read_write> steps: array<atomic<u32>>;
// The number of the present step, from 0; whether anything depends on what it changes; how many layers it is for.
@group(1) @binding(26) var<storage, read_write> present: array<u32>;

fn note_change() {
    if atomicLoad(&steps[1]) == 0u {
        atomicStore(&steps[1], 1u);
    }
}
