//@ use common/packing
//@ use scene/material
//@ use store/shape_column
// Material column (metalness, roughness, occlusion, flags; emitted light) and how a captured surface is stored.

@group(1) @binding(5) var<storage, read_write> materials: array<vec2<u32>>;

fn store_surface(slot: u32, depth_word: u32, s: Captured) {
    shapes[slot] = shape_words(depth_word, pack_normal(s.normal));
    store_color(slot, s.color);
    materials[slot] = vec2<u32>(
        pack_material(MaterialWord(s.metallic, s.roughness, s.occlusion, s.unlit, s.back_side)),
        pack_rgb9e5(s.emissive),
    );
}
