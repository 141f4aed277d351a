//! Images: PNG and JPEG to RGBA, 8 bits a channel, as stored. Sizes are checked before anything is decoded.

use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use gltf_json::Root;
use image::{DynamicImage, ImageDecoder, ImageReader};
use rayon::prelude::*;

use super::accessor::Data;
use super::{Fallible, Fault, ImportOptions, Limits, Notices, uri};
use crate::scene::{Image, NoticeKind};

/// All images of the file, used or not.
pub(super) fn read(
    root: &Root,
    data: &Data,
    folder: Option<&Path>,
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<Vec<Arc<Image>>> {
    let limits = &options.limits;
    let mut encoded: Vec<(String, Cow<[u8]>)> = Vec::new();
    let mut pixels = 0_u64;
    for (i, image) in root.images.iter().enumerate() {
        let place = format!("images[{i}]");
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), None) => Cow::Owned(uri::resolve(uri, &format!("{place}.uri"), folder, limits.bytes)?),
            (None, Some(view)) => Cow::Borrowed(data.view(view, &format!("{place}.bufferView"))?),
            (Some(_), Some(_)) => return Err(Fault::invalid(place, "has both a uri and a bufferView")),
            (None, None) => return Err(Fault::invalid(place, "has neither a uri nor a bufferView")),
        };
        let (width, height) = decoder(&bytes, &place, limits)?.dimensions();
        pixels = pixels.saturating_add(u64::from(width) * u64::from(height));
        if pixels > limits.image_pixels {
            return Err(Fault::limit(place, "pixels of images", pixels, limits.image_pixels));
        }
        encoded.push((place, bytes));
    }
    let decoded: Vec<Fallible<(Image, bool)>> = encoded
        .into_par_iter()
        .enumerate()
        .map(|(i, (place, bytes))| {
            options.cancel.go_on()?;
            let (mut image, deep) = decode(&bytes, &place, limits)?;
            let source = &root.images[i];
            image.name = match (&source.name, &source.uri) {
                (Some(name), _) if !name.is_empty() => name.clone(),
                (_, Some(uri)) if !uri.starts_with("data:") => uri.clone(),
                _ => place,
            };
            Ok((image, deep))
        })
        .collect();
    let mut images = Vec::with_capacity(decoded.len());
    for (i, result) in decoded.into_iter().enumerate() {
        let (image, deep) = result?;
        let what = "images of 16 bits a channel were reduced to 8";
        notices.count(NoticeKind::Approximated, what, deep.into(), &format!("images[{i}]"));
        images.push(Arc::new(image));
    }
    Ok(images)
}

fn decoder<'a>(bytes: &'a [u8], place: &str, limits: &Limits) -> Fallible<impl ImageDecoder + 'a> {
    let fail = |e: image::ImageError| Fault::invalid(place, format!("cannot be decoded: {e}"));
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|source| Fault::Io { place: place.to_owned(), source })?;
    if reader.format().is_none() {
        return Err(Fault::invalid(place, "is of an unknown kind: PNG and JPEG are read"));
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

/// The image and whether it had more than 8 bits a channel.
fn decode(bytes: &[u8], place: &str, limits: &Limits) -> Fallible<(Image, bool)> {
    let image = DynamicImage::from_decoder(decoder(bytes, place, limits)?)
        .map_err(|e| Fault::invalid(place, format!("cannot be decoded: {e}")))?;
    let color = image.color();
    let deep = u16::from(color.bytes_per_pixel()) > u16::from(color.channel_count());
    let rgba = image.into_rgba8();
    let (width, height) = rgba.dimensions();
    if width == 0 || height == 0 {
        return Err(Fault::invalid(place, "has no pixels"));
    }
    Ok((Image { name: String::new(), width, height, rgba: rgba.into_raw() }, deep))
}
