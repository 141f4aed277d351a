//! One layer of a picture, as planes of numbers.

/// What the layer with one index is in every pixel of a rectangle of the picture, rows from the top. Index 0 is the nearest
/// layer of each pixel, so one layer is seldom one surface. Where a pixel has no such layer, everything is 0 but the depth,
/// which is infinite, and the part, which is [`LayerImage::NO_PART`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerImage {
    /// Column and row of the rectangle's first pixel in the picture.
    pub corner: [u32; 2],
    /// Its width and height, pixels.
    pub size: [u32; 2],
    /// Distance along the view, in the units of the file.
    pub depth: Vec<f32>,
    /// The part, by its number in the scene.
    pub part: Vec<u32>,
    /// Unit normal on the viewer's side, in the directions of the file.
    pub normal: Vec<[f32; 3]>,
    /// κ, −1 to 1.
    pub kappa: Vec<f32>,
    /// Linear red, green and blue, lit and stylized, already multiplied by the opacity that comes last.
    pub color: Vec<[f32; 4]>,
}

impl LayerImage {
    /// The part of a pixel without such a layer.
    pub const NO_PART: u32 = u32::MAX;

    /// A rectangle in which no pixel has the layer.
    pub fn empty(corner: [u32; 2], size: [u32; 2]) -> LayerImage {
        let count = size[0] as usize * size[1] as usize;
        LayerImage {
            corner,
            size,
            depth: vec![f32::INFINITY; count],
            part: vec![LayerImage::NO_PART; count],
            normal: vec![[0.0; 3]; count],
            kappa: vec![0.0; count],
            color: vec![[0.0; 4]; count],
        }
    }
}
