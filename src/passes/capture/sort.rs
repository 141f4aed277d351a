//! Sorting the layers of a pixel: unrolled networks for short lists, heap sort in storage for long ones.
//!
//! A list is loaded into registers, put in order by Batcher's odd-even merge network, and stored; the network for lists of
//! up to n elements is generated here as straight-line WGSL. On a CPU rasterizer that is 25 times faster than insertion in
//! storage (design notes); on a GPU it keeps the lanes of a wave together. Lists fall into classes 1, 2, 3–4, 5–8, … 33–64;
//! longer ones are sorted in place.

use std::fmt::Write;

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::Context;
use crate::passes::store::StoreModules;
use crate::plan::Pass;

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

/// Workgroups in a row of a sort's dispatch; more are put into further rows.
const SORT_ROW: u32 = 32_768;

/// The entry points of [`classify_spec`].
pub const CLASSIFY_ENTRIES: [&str; 3] = ["count_classes", "place_classes", "list_pixels"];

/// The shader of [`classify`].
pub fn classify_spec(modules: &StoreModules) -> ShaderSpec {
    modules
        .layout(ShaderSpec::new("passes/sort/classify"))
        .constant("LARGEST_CLASS", format!("{LARGEST_CLASS}u"))
        .constant("SORT_ROW", format!("{SORT_ROW}u"))
}

/// Lists the pixels of each class of list length, and how many there are, for [`sort`].
///
/// # Errors
/// [`GpuError`] of the device.
pub fn classify(context: &mut Context<'_>, pass: Pass) -> Result<(), GpuError> {
    let spec = classify_spec(&StoreModules::of(context.plan));
    let classes = context.resources.require(pass.name(), "classes")?;
    context.recorder.encoder.clear_buffer(classes, 0, None);
    let [count_classes, place_classes, list_pixels] = CLASSIFY_ENTRIES;
    context.per_pixel(pass, &spec, count_classes)?;
    context.compute(pass, &spec, place_classes, [1, 1, 1])?;
    context.per_pixel(pass, &spec, list_pixels)
}

/// Sorts the lists of all pixels, class by class. `elements` is the shader module that says what is sorted: it declares
/// `Element`, `is_less`, and how elements are loaded and stored. `longest` bounds the length of any list.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn sort(context: &mut Context<'_>, pass: Pass, elements: &'static str, longest: u32) -> Result<(), GpuError> {
    let arguments = context.resources.require(pass.name(), "sort_arguments")?.clone();
    for (class, spec) in (0_u64..).zip(sort_specs(&StoreModules::of(context.plan), elements, longest)) {
        let kernel = context.shaders.kernel(&spec, "main")?;
        let at = (&arguments, class * 12);
        context.recorder.compute_indirect(pass, &kernel, &context.frame, context.resources, at)?;
    }
    Ok(())
}

/// The shaders of [`sort`], one for each class of lists that are not longer than `longest`.
pub fn sort_specs(modules: &StoreModules, elements: &'static str, longest: u32) -> Vec<ShaderSpec> {
    (0..=class_of(longest)).map(|class| sort_spec(modules, elements, class)).collect()
}

/// The class of a list length.
fn class_of(length: u32) -> u32 {
    length.max(1).next_power_of_two().trailing_zeros().min(LARGEST_CLASS)
}

/// The shader that sorts the lists of one class.
fn sort_spec(modules: &StoreModules, elements: &'static str, class: u32) -> ShaderSpec {
    let mut spec = modules
        .layout(ShaderSpec::new(elements).with("passes/sort/listed_pixel"))
        .constant("SORT_CLASS", format!("{class}u"))
        .constant("SORT_ROW", format!("{SORT_ROW}u"));
    if class == LARGEST_CLASS {
        return spec.with("passes/sort/long_lists");
    }
    let n = 1 << class;
    let mut body = String::new();
    for i in 0..n {
        // A clamped load and a select, because a branch costs more than a load.
        let _ = writeln!(
            body,
            "    var e{i} = select(padding_element(), load_element(base, min({i}u, count - 1u)), {i}u < count);"
        );
    }
    for (a, b) in network(n) {
        let _ = writeln!(
            body,
            "    {{ let swap = is_less(e{b}, e{a}); let low = select(e{a}, e{b}, swap); \
             e{b} = select(e{b}, e{a}, swap); e{a} = low; }}"
        );
    }
    for i in 0..n {
        let _ = writeln!(body, "    if {i}u < count {{ store_element(base, {i}u, e{i}); }}");
    }
    spec.generated = format!(
        "@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {{
    let pixel = listed_pixel(group, local);
    if pixel == EMPTY {{ return; }}
    let count = layer_count(pixel);
    let base = layer_base(pixel);
{body}}}
"
    );
    spec
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
