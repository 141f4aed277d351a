//@ use passes/lit_color
// Tail: what lies behind the k nearest is averaged, weighted by opacity, and blended behind them (T5). Whether a fragment
// belongs to it is known only now that the k nearest are final, so those evicted late are in it too. Sums are fixed-point
// integers: their order does not matter, and the picture does not depend on it.

struct ShadeParameters {
    lights: Lights,
}

@group(1) @binding(13) var<uniform> lights: ShadeParameters;
// Six words a pixel: sums of opacity times colour (3), of opacity, of -log2(1 - opacity), and the number of fragments.
@group(1) @binding(25) var<storage, read_write> tail: array<atomic<u32>>;

const TAIL_UNIT: f32 = 4096.0;

fn store_tail(pixel: u32, v: Varyings, surface: Captured, dropped: bool) {
    if !dropped {
        return;
    }
    let depth = view_depth_of_key(depth_key_of(v.position));
    let eye = to_eye(position_in_view(u32(v.position.x), u32(v.position.y), depth));
    let word = pack_material(
        MaterialWord(surface.metallic, surface.roughness, surface.occlusion, surface.unlit, surface.back_side),
    );
    let color = lit_color(surface.color, surface.normal, vec2<u32>(word, pack_rgb9e5(surface.emissive)), eye);
    let styled = tail_style(color, depth);
    let alpha = part_alpha(v.part, clamp(styled.a, 0.0, 1.0), transfer.ghost);
    let weighted = vec3<u32>(clamp(styled.rgb, vec3<f32>(0.0), vec3<f32>(4.0)) * (alpha * TAIL_UNIT) + 0.5);
    atomicAdd(&tail[6u * pixel], weighted.x);
    atomicAdd(&tail[6u * pixel + 1u], weighted.y);
    atomicAdd(&tail[6u * pixel + 2u], weighted.z);
    atomicAdd(&tail[6u * pixel + 3u], u32(alpha * TAIL_UNIT + 0.5));
    atomicAdd(&tail[6u * pixel + 4u], u32(min(-log2(max(1.0 - alpha, 1.6e-5)), 16.0) * TAIL_UNIT + 0.5));
    atomicAdd(&tail[6u * pixel + 5u], 1u);
}
