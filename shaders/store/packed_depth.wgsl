//@ use common/frame
// Depth in 16 bits. PACKED_DEPTH: 0 linear over the scene's depth range, 1 classic z/w, 2 reversed z (T2). The value
// 0xFFFF is left free, so that no key equals the empty slot's.

fn packed_depth_of(position: vec4<f32>) -> u32 {
    let z = clamp(position.z, 0.0, 1.0);
    var t = 0.0;
    if PACKED_DEPTH == 0u {
        t = depth01_of(view_depth_of_z(z));
    } else if PACKED_DEPTH == 2u || frame.orthographic != 0u {
        t = 1.0 - z;
    } else {
        // z/w with a finite far plane, from the reversed infinite one: (1/near - 1/depth) / (1/near - 1/far).
        t = clamp((1.0 - z) / (1.0 - frame.near / frame.far), 0.0, 1.0);
    }
    return min(u32(t * 65534.0 + 0.5), 65534u);
}

fn view_depth_of_packed(bits: u32) -> f32 {
    let t = f32(bits) / 65534.0;
    if PACKED_DEPTH == 0u {
        return frame.depth_min + t / frame.depth_scale;
    }
    if PACKED_DEPTH == 2u || frame.orthographic != 0u {
        return view_depth_of_z(1.0 - t);
    }
    return view_depth_of_z(1.0 - t * (1.0 - frame.near / frame.far));
}
