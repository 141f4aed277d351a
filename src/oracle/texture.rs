//! Texture sampling at level 0: nearest or bilinear, three wrap modes. Minification is not modelled, so textured scenes
//! are compared with the GPU where a texel is at least a pixel wide.

use crate::math::color::linear_from_srgb;
use crate::scene::{Image, Scene, TextureRef, Wrap};

/// What a texture gives at interpolated coordinates; rgb decoded from sRGB if asked. White where the reference is broken.
pub(super) fn sample(scene: &Scene, reference: &TextureRef, uv: [f64; 2], srgb: bool) -> [f64; 4] {
    let Some(texture) = scene.textures.get(reference.texture) else { return [1.0; 4] };
    let Some(image) = scene.images.get(texture.image) else { return [1.0; 4] };
    if image.width == 0 || image.height == 0 {
        return [1.0; 4];
    }
    let [u, v] = reference.uv_transform.map(|r| {
        let [a, b, c] = r.map(f64::from);
        a * uv[0] + b * uv[1] + c
    });
    let (x, y) = (u * f64::from(image.width), v * f64::from(image.height));
    let at = |x: f64, y: f64| {
        texel(image, wrap(x, image.width, texture.wrap[0]), wrap(y, image.height, texture.wrap[1]), srgb)
    };
    if !texture.mag_linear {
        return at(x.floor(), y.floor());
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let (a, b, c, d) = (at(x0, y0), at(x0 + 1.0, y0), at(x0, y0 + 1.0), at(x0 + 1.0, y0 + 1.0));
    std::array::from_fn(|i| (a[i] * (1.0 - fx) + b[i] * fx) * (1.0 - fy) + (c[i] * (1.0 - fx) + d[i] * fx) * fy)
}

/// The texel index that stands for `index` outside the image. A coordinate that is not finite gives texel 0.
fn wrap(index: f64, size: u32, mode: Wrap) -> u32 {
    let n = f64::from(size);
    let wrapped = match mode {
        Wrap::ClampToEdge => index,
        Wrap::Repeat => index.rem_euclid(n),
        Wrap::MirroredRepeat => {
            let m = index.rem_euclid(2.0 * n);
            if m < n { m } else { 2.0 * n - 1.0 - m }
        }
    };
    if wrapped.is_finite() { wrapped.clamp(0.0, n - 1.0) as u32 } else { 0 }
}

fn texel(image: &Image, x: u32, y: u32, srgb: bool) -> [f64; 4] {
    let at = 4 * (y as usize * image.width as usize + x as usize);
    std::array::from_fn(|i| {
        let value = image.rgba.get(at + i).map_or(1.0, |&b| f64::from(b) / 255.0);
        if srgb && i < 3 { linear_from_srgb(value) } else { value }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Mip, Texture};
    use std::sync::Arc;

    fn two_texels(wrap: Wrap, linear: bool) -> Scene {
        let image = Image { name: String::new(), width: 2, height: 1, rgba: vec![0, 0, 0, 255, 255, 255, 255, 255] };
        let texture = Texture { image: 0, wrap: [wrap; 2], mag_linear: linear, min_linear: linear, mip: Mip::None };
        Scene { images: vec![Arc::new(image)], textures: vec![texture], ..Scene::default() }
    }

    #[test]
    fn wrap_modes_and_filters_by_hand() {
        let reference = TextureRef { texture: 0, uv_set: 0, uv_transform: TextureRef::IDENTITY };
        let red = |wrap, linear, u| sample(&two_texels(wrap, linear), &reference, [u, 0.5], false)[0];
        assert_eq!(red(Wrap::Repeat, false, 0.75), 1.0);
        assert_eq!(red(Wrap::Repeat, false, 1.25), 0.0);
        assert_eq!(red(Wrap::MirroredRepeat, false, 1.25), 1.0);
        assert_eq!(red(Wrap::ClampToEdge, false, 7.0), 1.0);
        assert_eq!(red(Wrap::ClampToEdge, false, f64::NAN), 0.0);
        assert_eq!(red(Wrap::ClampToEdge, true, 0.5), 0.5);
        assert_eq!(red(Wrap::Repeat, true, 0.0), 0.5);
        assert_eq!(red(Wrap::ClampToEdge, true, 0.0), 0.0);
        // sRGB is decoded before it is interpolated: half of white light, not the middle code.
        assert_eq!(sample(&two_texels(Wrap::ClampToEdge, true), &reference, [0.5, 0.5], true)[0], 0.5);
    }
}
