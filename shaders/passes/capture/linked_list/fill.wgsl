//@ use common/frame
//@ use common/packing
//@ use scene/material
// Fill (Carnecky 2013, Algorithm 1): every fragment takes a free place and becomes the head of its pixel's list. Fragments
// are counted whether there is room for them or not, so that the next try has enough.

@group(1) @binding(0) var<storage, read_write> pixel_counts: array<atomic<u32>>;
@group(1) @binding(1) var<uniform> store_layout: StoreLayout;
struct StoreLayout {
    k: u32,
    // Fragments that there is room for.
    capacity: u32,
    chunk: u32,
    _pad: u32,
}
// Fragments written so far.
@group(1) @binding(18) var<storage, read_write> list_count: array<atomic<u32>>;
// Places, counted from 1; 0 ends a list.
@group(1) @binding(19) var<storage, read_write> list_heads: array<atomic<u32>>;
@group(1) @binding(24) var<storage, read_write> list_next: array<u32>;
@group(1) @binding(20) var<storage, read_write> arrival_keys: array<vec2<u32>>;
@group(1) @binding(21) var<storage, read_write> arrival_colors: array<vec2<u32>>;
// Material word, normal.
@group(1) @binding(23) var<storage, read_write> arrival_surfaces: array<ShapeWords>;
@group(1) @binding(22) var<storage, read_write> arrival_emissive: array<u32>;

@fragment
fn fragment_main(v: Varyings, @builtin(front_facing) front_facing: bool) -> @location(0) vec4<f32> {
    let clipped = is_clipped(v.position, v.part);
    var s = captured_surface(v, front_facing);
    s.color = recolored(v.part, s.color);
    if clipped || is_cut_out(v) {
        discard;
    }
    let pixel = pixel_of_position(v.position);
    atomicAdd(&pixel_counts[pixel], 1u);
    let place = atomicAdd(&list_count[0], 1u);
    if place < store_layout.capacity {
        list_next[place] = atomicExchange(&list_heads[pixel], place + 1u);
        arrival_keys[place] = vec2<u32>(v.triangle, depth_key_of(v.position));
        let word = pack_material(MaterialWord(s.metallic, s.roughness, s.occlusion, s.unlit, s.back_side));
        arrival_colors[place] = pack_half4(s.color);
        arrival_surfaces[place] = shape_words(word, pack_normal(s.normal));
        arrival_emissive[place] = pack_rgb9e5(s.emissive);
    }
    return vec4<f32>(0.0);
}
