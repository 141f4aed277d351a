//@ use common/frame
//@ use common/packing
//@ use scene/material
//@ use passes/capture/statistics
// Append: every fragment goes to the next free slot of its pixel, in whatever order fragments come.

@group(1) @binding(1) var<uniform> store_layout: StoreLayout;
struct StoreLayout {
    k: u32,
    capacity: u32,
    chunk: u32,
    _pad: u32,
}
@group(1) @binding(19) var<storage, read_write> cursors: array<atomic<u32>>;
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
    let slot = atomicAdd(&cursors[pixel_of_position(v.position)], 1u);
    if slot >= store_layout.capacity {
        atomicAdd(&statistics[STAT_LOST], 1u);
        return vec4<f32>(0.0);
    }
    arrival_keys[slot] = vec2<u32>(v.triangle, depth_key_of(v.position));
    let word = pack_material(MaterialWord(s.metallic, s.roughness, s.occlusion, s.unlit, s.back_side));
    arrival_colors[slot] = pack_half4(s.color);
    arrival_surfaces[slot] = shape_words(word, pack_normal(s.normal));
    arrival_emissive[slot] = pack_rgb9e5(s.emissive);
    return vec4<f32>(0.0);
}
