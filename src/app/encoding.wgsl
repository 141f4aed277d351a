// In front of every shader that draws into the window: what it writes is encoded in sRGB, and some surfaces encode once more.

// Whether the surface does.
override encodes: bool = false;

fn for_surface(color: vec3f) -> vec3f {
    if encodes {
        return select(pow((color + 0.055) / 1.055, vec3f(2.4)), color / 12.92, color <= vec3f(0.04045));
    }
    return color;
}

