//! A picture in linear light.

/// A picture: premultiplied colour in linear light, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width · height` pixels: red, green and blue already multiplied by the alpha that comes last.
    pub pixels: Vec<[f32; 4]>,
}
