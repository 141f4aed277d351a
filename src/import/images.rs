//! Images: PNG, JPEG and WebP to RGBA, 8 bits a channel, as stored. Sizes are checked before anything is decoded.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::{Fallible, Fault, Limits};
use crate::scene::Image;

/// Width and height, which are within the limits; nothing is decoded.
pub(super) fn dimensions(bytes: &[u8], place: &str, limits: &Limits) -> Fallible<(u32, u32)> {
    Ok(decoder(bytes, place, limits)?.dimensions())
}

fn decoder<'a>(bytes: &'a [u8], place: &str, limits: &Limits) -> Fallible<impl ImageDecoder + 'a> {
    let fail = |e: image::ImageError| Fault::invalid(place, format!("cannot be decoded: {e}"));
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|source| Fault::Io { place: place.to_owned(), source })?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) {
        return Err(Fault::invalid(place, "is of an unknown kind: PNG, JPEG, WebP and, in glTF, KTX2 are read"));
    }
    let mut bounds = image::Limits::default();
    bounds.max_image_width = Some(limits.image_side);
    bounds.max_image_height = Some(limits.image_side);
    // 8 bytes a pixel at 16 bits a channel, and as much again for the decoder's own needs.
    bounds.max_alloc = Some(limits.image_pixels.saturating_mul(16));
    reader.limits(bounds.clone());
    let mut decoder = reader.into_decoder().map_err(fail)?;
    let (width, height) = decoder.dimensions();
    if width.max(height) > limits.image_side {
        return Err(Fault::limit(
            place,
            "pixels of width or height",
            width.max(height).into(),
            limits.image_side.into(),
        ));
    }
    decoder.set_limits(bounds).map_err(fail)?;
    Ok(decoder)
}

/// What of an image is lost.
#[derive(Default)]
pub(super) struct Lost {
    /// It has more than 8 bits a channel.
    pub(super) deep: bool,
    /// It brings a colour profile.
    pub(super) profile: bool,
}

/// The image, without a name, and what of it is lost.
pub(super) fn decode(bytes: &[u8], place: &str, limits: &Limits) -> Fallible<(Image, Lost)> {
    let mut decoder = decoder(bytes, place, limits)?;
    // A profile that cannot be read is as good as none: it is not applied anyway.
    let profile = decoder.icc_profile().is_ok_and(|profile| profile.is_some());
    let image =
        DynamicImage::from_decoder(decoder).map_err(|e| Fault::invalid(place, format!("cannot be decoded: {e}")))?;
    let color = image.color();
    let deep = u16::from(color.bytes_per_pixel()) > u16::from(color.channel_count());
    let rgba = image.into_rgba8();
    let (width, height) = rgba.dimensions();
    if width == 0 || height == 0 {
        return Err(Fault::invalid(place, "has no pixels"));
    }
    Ok((Image { name: String::new(), width, height, rgba: rgba.into_raw() }, Lost { deep, profile }))
}
