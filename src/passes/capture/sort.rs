//! Sorting the layers of a pixel: unrolled networks for short lists, heap sort in storage for long ones.
//!
//! A list is loaded into registers, put in order by Batcher's odd-even merge network, and stored; the network for lists of
//! up to n elements is generated here as straight-line WGSL. On a CPU rasterizer that is 25 times faster than insertion in
//! storage (design notes); on a GPU it keeps the lanes of a wave together. Lists fall into classes 1, 2, 3–4, 5–8, … 33–64;
//! longer ones are sorted in place.

use std::fmt::Write;

use crate::gpu::ShaderSpec;

/// Length of the longest list that a network sorts.
pub const LARGEST_NETWORK: u32 = 64;
/// Class of the longer lists; class c below it holds lists of 2^(c−1)+1 to 2^c elements.
pub const LARGEST_CLASS: u32 = 7;

/// The comparators of Batcher's odd-even merge sort for `n` elements, a power of two.
pub fn network(n: u32) -> Vec<(u32, u32)> {
    let mut comparators = Vec::new();
    let mut p = 1;
    while p < n {
        let mut k = p;
        while k >= 1 {
            for j in (k % p..n - k).step_by(2 * k as usize) {
                for i in 0..k.min(n - j - k) {
                    if (i + j) / (2 * p) == (i + j + k) / (2 * p) {
                        comparators.push((i + j, i + j + k));
                    }
                }
            }
            k /= 2;
        }
        p *= 2;
    }
    comparators
}

/// Adds to a shader that declares `Element`, `is_less`, `load_element` and `store_element` an entry point `main` that sorts
/// the lists of one class.
pub fn with_network(mut spec: ShaderSpec, class: u32) -> ShaderSpec {
    let n = 1 << class;
    let shortest = if class == 0 { 1 } else { n / 2 + 1 };
    let mut body = String::new();
    for i in 0..n {
        let _ = writeln!(body, "    var e{i} = padding_element();");
        let _ = writeln!(body, "    if {i}u < count {{ e{i} = load_element(base, {i}u); }}");
    }
    for (a, b) in network(n) {
        let _ = writeln!(
            body,
            "    {{ let swap = is_less(e{b}, e{a}); let low = select(e{a}, e{b}, swap); e{b} = select(e{b}, e{a}, swap); e{a} = low; }}"
        );
    }
    for i in 0..n {
        let _ = writeln!(body, "    if {i}u < count {{ store_element(base, {i}u, e{i}); }}");
    }
    spec.generated = format!(
        "@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {{ return; }}
    let pixel = id.y * frame.size.x + id.x;
    let count = layer_count(pixel);
    if count < {shortest}u || count > {n}u {{ return; }}
    let base = layer_base(pixel);
{body}}}
"
    );
    spec
}

/// A shader for every class, in order, over one that declares elements and has `layer_count`.
pub fn all_classes(elements: &ShaderSpec) -> Vec<ShaderSpec> {
    let networks = (0..LARGEST_CLASS).map(|class| with_network(elements.clone(), class));
    networks.chain([with_long_lists(elements.clone())]).collect()
}

/// Adds the entry point `main` that sorts the lists longer than any network.
pub fn with_long_lists(spec: ShaderSpec) -> ShaderSpec {
    spec.with("passes/sort/long_lists").constant("LARGEST_NETWORK", format!("{LARGEST_NETWORK}u"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The 0-1 principle: a network sorts everything if it sorts all sequences of zeros and ones.
    #[test]
    fn networks_sort_by_the_zero_one_principle() {
        for n in [1_u32, 2, 4, 8, 16] {
            let network = network(n);
            for bits in 0_u32..1 << n {
                let mut v: Vec<u32> = (0..n).map(|i| bits >> i & 1).collect();
                for &(a, b) in &network {
                    if v[b as usize] < v[a as usize] {
                        v.swap(a as usize, b as usize);
                    }
                }
                assert!(v.is_sorted(), "n = {n}, bits = {bits:b}");
            }
        }
    }

    #[test]
    fn larger_networks_sort_thresholds() {
        for n in [32_u32, 64] {
            let network = network(n);
            // Pseudo-random 0-1 sequences; exhaustive would be 2^64.
            let mut state = 1_u64;
            for _ in 0..20_000 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let bits = state ^ (state >> 29);
                let mut v: Vec<u64> = (0..n).map(|i| bits >> i & 1).collect();
                for &(a, b) in &network {
                    if v[b as usize] < v[a as usize] {
                        v.swap(a as usize, b as usize);
                    }
                }
                assert!(v.is_sorted());
            }
        }
        assert_eq!(network(32).len(), 191);
        assert_eq!(network(64).len(), 543);
    }
}
