//@ use store/layout_compacted
// Gather: brings what was appended into the order that the sort found.

@group(1) @binding(3) var<storage, read_write> shapes: array<ShapeWords>;
@group(1) @binding(4) var<storage, read_write> colors: array<vec2<u32>>;
@group(1) @binding(5) var<storage, read_write> materials: array<vec2<u32>>;
@group(1) @binding(21) var<storage, read_write> arrival_colors: array<vec2<u32>>;
@group(1) @binding(23) var<storage, read_write> arrival_surfaces: array<ShapeWords>;
@group(1) @binding(22) var<storage, read_write> arrival_emissive: array<u32>;
@group(1) @binding(24) var<storage, read_write> sources: array<u32>;

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    for (var i = 0u; i < count; i++) {
        let source = source_of(base, sources[base + i]);
        let surface = arrival_surfaces[source];
        colors[base + i] = arrival_colors[source];
        place_normal(base + i, surface);
        materials[base + i] = vec2<u32>(surface.x, arrival_emissive[source]);
    }
}
