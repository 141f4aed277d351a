//@ use passes/operators/layer
//@ use passes/operators/gathered
// Equal shares: how many pixels have how many layers.

fn gather(at: Layer) {
    if at.index + 1u == at.count {
        atomicAdd(&gathered[min(at.count, GATHERED - 1u)], 1u);
    }
}
