//@ use common/packing

fn as_stored(color: vec4<f32>) -> vec4<f32> {
    return unpack_half4(pack_half4(color));
}
