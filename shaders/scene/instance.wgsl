// Instances: one a part. All vertex shaders place a vertex through `place`, so that every geometry pass gives the same
// depth bit for bit (T3).

struct Instance {
    // Rows of view_from_part.
    view_x: vec4<f32>,
    view_y: vec4<f32>,
    view_z: vec4<f32>,
    // Rows of the inverse transpose of its linear part, up to a positive factor.
    normal_x: vec4<f32>,
    normal_y: vec4<f32>,
    normal_z: vec4<f32>,
    // Number of the first triangle, part, whether the transform mirrors, unused.
    ids: vec4<u32>,
}

@group(3) @binding(0) var<storage, read> instances: array<Instance>;

// Bit of the vertex attribute `triangle` that says: the vertex normals oppose the winding. The rest is the triangle's
// number in its mesh; the first vertex of a triangle carries it.
const OPPOSED: u32 = 0x80000000u;

fn place(instance: Instance, position: vec3<f32>) -> vec3<f32> {
    let p = vec4<f32>(position, 1.0);
    return vec3<f32>(dot(instance.view_x, p), dot(instance.view_y, p), dot(instance.view_z, p));
}

fn turn_normal(instance: Instance, normal: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(instance.normal_x.xyz, normal),
        dot(instance.normal_y.xyz, normal),
        dot(instance.normal_z.xyz, normal),
    );
}

fn turn_vector(instance: Instance, vector: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(instance.view_x.xyz, vector),
        dot(instance.view_y.xyz, vector),
        dot(instance.view_z.xyz, vector),
    );
}
