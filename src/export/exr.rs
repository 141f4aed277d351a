//! OpenEXR: a picture in linear light, and the layers that it is made of.
//!
//! What is stored is what the renderer computed: linear light with Rec. 709 primaries, premultiplied, as floats of 16 or 32
//! bits, neither encoded as sRGB nor clamped, and without the background, which stands in the attribute
//! `pellucid:background`. Rows are stored as scan lines. The first part of a file is the picture (channels `R`, `G`, `B`, `A`). With layers, a part follows
//! for each index, `layer.0` the nearest of every pixel, and holds the smallest rectangle that has such layers as its data
//! window:
//!
//! | channel | what it is |
//! |---|---|
//! | `R`, `G`, `B` | colour after light and stylization, multiplied by `A` |
//! | `A` | opacity with which the layer is blended |
//! | `Z` | distance along the view, in the units of the file; infinite where there is no such layer (32 bits) |
//! | `id` | number of the part, as `pellucid inspect` counts them; 4294967295 where there is none (whole numbers) |
//! | `N.X`, `N.Y`, `N.Z` | unit normal on the viewer's side, in the directions of the file |
//! | `kappa` | κ, −1 convex, 1 concave |
//!
//! Laid over each other front to back, `over` by `over`, the layers are the picture with one sample a pixel. Compression is
//! ZIP, which loses nothing.
//!
//! Read back are pictures of any program: the first part that has `R`, `G` and `B`, or a luminance `Y`, placed by its data
//! window into the display window.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image, ImageAttributes,
    IntegerBounds, Layer, LayerAttributes, LineOrder, ReadChannels, ReadLayers, Text, Vec2, WritableImage, read,
};
use half::f16;

use crate::math::{LayerImage, LinearImage};

/// First bytes of every EXR file.
pub const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Most pixels of a picture that is read.
const MOST_PIXELS: u64 = 1 << 28;

/// Why a picture could not be written or read as EXR.
#[derive(Debug, thiserror::Error)]
pub enum ExrError {
    /// The picture has no pixels or not as many as its size says.
    #[error("a picture of {width}×{height} with {pixels} pixels cannot be written")]
    Size {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Pixels that are there.
        pixels: usize,
    },
    /// Neither 16 nor 32 bits.
    #[error("{0} bits a channel: expected 16 or 32")]
    Bits(u8),
    /// A file is larger than what is read.
    #[error("{width}×{height} pixels: at most {MOST_PIXELS} pixels are read")]
    TooLarge {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
    },
    /// A file without a picture.
    #[error("no part has channels R, G and B, or Y")]
    NoPicture,
    /// The encoder or decoder refused.
    #[error("{0}")]
    Codec(#[from] exr::error::Error),
}

/// What stands beside the pixels. Each text is the only attribute of its own in its header: the crate keeps them in no order,
/// and the same picture is to be the same file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facts {
    /// The background: attribute `pellucid:background` of every part.
    pub background: String,
    /// A session that draws the picture again: `pellucid:session` of the picture.
    pub session: Option<String>,
    /// Numbers and names of the parts that are seen, a line each: `pellucid:parts` of the first layer.
    pub parts: String,
    /// From the file's coordinates to the camera's: standard attribute `worldToCamera`, columns one after the other.
    pub world_to_camera: Option<[f32; 16]>,
}

/// Encodes a picture, and its layers if there are any, with `bits` (16 or 32) of a float.
///
/// # Errors
/// [`ExrError`] for an empty picture and bits other than 16 and 32.
pub fn write_exr(picture: &LinearImage, layers: &[LayerImage], bits: u8, facts: &Facts) -> Result<Vec<u8>, ExrError> {
    let (width, height, pixels) = (picture.width, picture.height, picture.pixels.len());
    if width == 0 || height == 0 || pixels as u64 != u64::from(width) * u64::from(height) {
        return Err(ExrError::Size { width, height, pixels });
    }
    if bits != 16 && bits != 32 {
        return Err(ExrError::Bits(bits));
    }
    let floats = |values: &mut dyn Iterator<Item = f32>| match bits {
        16 => FlatSamples::F16(values.map(f16::from_f32).collect()),
        _ => FlatSamples::F32(values.collect()),
    };
    let colors = |pixels: &[[f32; 4]]| {
        ["R", "G", "B", "A"]
            .into_iter()
            .enumerate()
            .map(|(c, name)| AnyChannel::new(name, floats(&mut pixels.iter().map(|p| p[c]))))
            .collect::<Vec<_>>()
    };
    let part = |name: &str, corner: [u32; 2], size: [u32; 2], channels: Vec<AnyChannel<FlatSamples>>| {
        let mut attributes = LayerAttributes::named(name);
        attributes.layer_position = Vec2(corner[0] as i32, corner[1] as i32);
        attributes.software_name = Text::new_or_none(concat!("pellucid ", env!("CARGO_PKG_VERSION")));
        attributes.world_to_camera = facts.world_to_camera;
        let compression = Compression::ZIP16;
        let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let size = (size[0] as usize, size[1] as usize);
        Layer::new(size, attributes, encoding, AnyChannels::sort(channels.into()))
    };
    let mut parts = vec![part("picture", [0, 0], [width, height], colors(&picture.pixels))];
    if let Some(session) = &facts.session {
        parts[0].attributes.other.insert("pellucid:session".into(), text(session));
    }
    for (i, layer) in layers.iter().enumerate() {
        let mut channels = colors(&layer.color);
        channels.push(AnyChannel::new("Z", FlatSamples::F32(layer.depth.clone())));
        channels.push(AnyChannel::new("id", FlatSamples::U32(layer.part.clone())));
        for (c, name) in ["N.X", "N.Y", "N.Z"].into_iter().enumerate() {
            channels.push(AnyChannel::new(name, floats(&mut layer.normal.iter().map(|n| n[c]))));
        }
        channels.push(AnyChannel::new("kappa", floats(&mut layer.kappa.iter().copied())));
        parts.push(part(&format!("layer.{i}"), layer.corner, layer.size, channels));
    }
    if let Some(first) = parts.get_mut(1) {
        first.attributes.other.insert("pellucid:parts".into(), text(&facts.parts));
    }
    let window = IntegerBounds::new((0, 0), (width as usize, height as usize));
    let mut attributes = ImageAttributes::new(window);
    attributes.other.insert("pellucid:background".into(), text(&facts.background));
    let image = Image::from_layers(attributes, parts);
    let mut out = Cursor::new(Vec::new());
    image.write().to_buffered(&mut out)?;
    Ok(out.into_inner())
}

/// Text of an attribute. It is UTF-8 by the format; the crate's own conversion takes Latin 1 only.
fn text(value: &str) -> AttributeValue {
    AttributeValue::Text(Text::from_slice_unchecked(value.as_bytes()))
}

/// Decodes the picture of an EXR file: premultiplied linear light. Without `A` it is opaque; outside its data window it is
/// clear.
///
/// # Errors
/// [`ExrError`] if the bytes are no EXR, hold no picture, or too large a one.
pub fn read_exr(bytes: &[u8]) -> Result<LinearImage, ExrError> {
    // The header says how much will be decoded.
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false)?;
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        if width as u64 * height as u64 > MOST_PIXELS {
            return Err(ExrError::TooLarge { width, height });
        }
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))?;
    let window = image.attributes.display_window;
    let Vec2(width, height) = window.size;
    if width as u64 * height as u64 > MOST_PIXELS {
        return Err(ExrError::TooLarge { width, height });
    }
    for layer in &image.layer_data {
        let channel = |name: &str| layer.channel_data.list.iter().find(|c| c.name == *name).map(|c| &c.sample_data);
        let (rgb, alpha) = match (channel("R"), channel("G"), channel("B"), channel("Y")) {
            (Some(r), Some(g), Some(b), _) => ([r, g, b], channel("A")),
            (_, _, _, Some(y)) => ([y, y, y], channel("A")),
            _ => continue,
        };
        let mut picture =
            LinearImage { width: width as u32, height: height as u32, pixels: vec![[0.0; 4]; width * height] };
        let from = layer.attributes.layer_position - window.position;
        let Vec2(columns, rows) = layer.size;
        for y in 0..rows {
            for x in 0..columns {
                let to = (i64::from(from.0) + x as i64, i64::from(from.1) + y as i64);
                let (Ok(to_x), Ok(to_y)) = (usize::try_from(to.0), usize::try_from(to.1)) else { continue };
                if to_x < width && to_y < height {
                    let at = y * columns + x;
                    let [r, g, b] = rgb.map(|samples| samples.value_by_flat_index(at).to_f32());
                    let a = alpha.map_or(1.0, |samples| samples.value_by_flat_index(at).to_f32());
                    picture.pixels[to_y * width + to_x] = [r, g, b, a];
                }
            }
        }
        return Ok(picture);
    }
    Err(ExrError::NoPicture)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> LinearImage {
        let pixels = (0..12).map(|i| {
            let v = i as f32;
            [v / 3.0, 0.1 * v, 4.0 - v, if i % 3 == 0 { 0.25 } else { 1.0 }]
        });
        LinearImage { width: 4, height: 3, pixels: pixels.collect() }
    }

    #[test]
    fn floats_come_back_as_they_were_unclamped() {
        let image = picture();
        let bytes = write_exr(&image, &[], 32, &Facts::default()).unwrap();
        assert!(bytes.starts_with(&MAGIC));
        assert_eq!(read_exr(&bytes).unwrap(), image);
        let half = read_exr(&write_exr(&image, &[], 16, &Facts::default()).unwrap()).unwrap();
        for (a, b) in half.pixels.iter().flatten().zip(image.pixels.iter().flatten()) {
            assert_eq!(*a, f16::from_f32(*b).to_f32());
        }
    }

    #[test]
    fn layers_are_parts_of_their_own_with_every_channel() {
        let mut layer = LayerImage::empty([1, 2], [2, 1]);
        (layer.depth[1], layer.part[1], layer.normal[1]) = (2.5, 7, [0.0, 0.6, 0.8]);
        (layer.kappa[1], layer.color[1]) = (-0.5, [0.1, 0.2, 0.3, 0.4]);
        let facts = Facts {
            background: "#102030".to_owned(),
            session: Some("file = 'Zahnräder.glb'".to_owned()),
            parts: "7 gear\n".to_owned(),
            world_to_camera: Some(std::array::from_fn(|i| i as f32)),
        };
        let bytes = write_exr(&picture(), std::slice::from_ref(&layer), 32, &facts).unwrap();
        assert_eq!(read_exr(&bytes).unwrap(), picture(), "the picture comes first");
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_buffered(Cursor::new(&bytes))
            .unwrap();
        let parts: Vec<_> = image.layer_data.iter().collect();
        assert_eq!(parts.len(), 2);
        assert_eq!(parts[0].attributes.world_to_camera, facts.world_to_camera);
        for (part, name, value) in [
            (0, "pellucid:background", &facts.background),
            (1, "pellucid:background", &facts.background),
            (0, "pellucid:session", facts.session.as_ref().unwrap()),
            (1, "pellucid:parts", &facts.parts),
        ] {
            assert_eq!(parts[part].attributes.other[&Text::from(name)], text(value), "{name}");
        }
        let again = write_exr(&picture(), std::slice::from_ref(&layer), 32, &facts).unwrap();
        assert!(again == bytes, "the same picture is the same file");
        assert_eq!(parts[1].attributes.layer_name, Some("layer.0".into()));
        assert_eq!((parts[1].attributes.layer_position, parts[1].size), (Vec2(1, 2), Vec2(2, 1)));
        let value = |name: &str, at: usize| {
            let found = parts[1].channel_data.list.iter().find(|c| c.name == *name);
            found.unwrap_or_else(|| panic!("{name}")).sample_data.value_by_flat_index(at).to_f32()
        };
        let names = ["R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z", "kappa"];
        let values = [0.1, 0.2, 0.3, 0.4, 2.5, 0.0, 0.6, 0.8, -0.5];
        assert_eq!(names.map(|n| value(n, 1)), values);
        assert_eq!((value("Z", 0), value("A", 0)), (f32::INFINITY, 0.0));
        let id = parts[1].channel_data.list.iter().find(|c| c.name == *"id").unwrap();
        assert_eq!(id.sample_data, FlatSamples::U32(vec![LayerImage::NO_PART, 7]));
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        assert!(matches!(write_exr(&picture(), &[], 8, &Facts::default()), Err(ExrError::Bits(8))));
        let nothing = LinearImage { width: 0, height: 4, pixels: Vec::new() };
        assert!(matches!(write_exr(&nothing, &[], 16, &Facts::default()), Err(ExrError::Size { .. })));
        let whole = write_exr(&picture(), &[], 32, &Facts::default()).unwrap();
        assert!(read_exr(&whole[..whole.len() / 2]).is_err());
        assert!(read_exr(b"no picture").is_err());
    }
}
