//! Colours as newtypes, so that linear and encoded, straight and premultiplied, cannot be confused (T26).
//!
//! Everything between file and image is linear light with Rec. 709 primaries; composition is premultiplied.

/// Premultiplied colour in linear light: `rgb` is already multiplied by `a`.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Premultiplied(pub [f32; 4]);

impl Premultiplied {
    /// `self` in front of `behind` (the over operator).
    #[must_use]
    pub fn over(self, behind: Premultiplied) -> Premultiplied {
        let transmitted = 1.0 - self.0[3];
        Premultiplied(std::array::from_fn(|i| self.0[i] + transmitted * behind.0[i]))
    }

    /// Straight alpha: the colour divided by its coverage, black where there is none.
    pub fn straight(self) -> [f32; 4] {
        let [r, g, b, a] = self.0;
        if a <= 0.0 {
            return [0.0; 4];
        }
        [r / a, g / a, b / a, a]
    }
}

/// The sRGB transfer curve: linear light to encoded value. Input outside [0, 1] is clamped; NaN becomes 0.
pub fn srgb_from_linear(linear: f64) -> f64 {
    let c = if linear.is_nan() { 0.0 } else { linear.clamp(0.0, 1.0) };
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse sRGB transfer curve: encoded value in [0, 1] to linear light.
pub fn linear_from_srgb(encoded: f64) -> f64 {
    let c = encoded.clamp(0.0, 1.0);
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}
