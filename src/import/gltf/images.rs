//! The images of a glTF file: where each comes from, and how much all of them take. `import::images` decodes PNG, JPEG and
//! WebP, `ktx2` the rest.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use gltf_json::Root;
use rayon::prelude::*;

use super::accessor::Data;
use super::budget::Budget;
use super::sources::Sources;
use super::steps::{Steps, settle};
use super::{Fallible, Fault, ImportOptions, Limits, Notices, ktx2, uri};
use crate::import::Phase;
use crate::import::images::{self, Lost, dimensions};
use crate::scene::{Image, NoticeKind};

/// The images of a file.
pub(super) struct Images {
    /// Those that were decoded.
    pub(super) images: Vec<Arc<Image>>,
    /// Per image of the file: which of them it is, if it was needed.
    pub(super) numbers: Vec<Option<usize>>,
}

/// What an image is and what is to be told of it.
struct Encoded<'a> {
    index: usize,
    place: String,
    bytes: Cow<'a, [u8]>,
}

/// All images that `sources` want. One that cannot be read and that every texture has a substitute for is given up for
/// that one.
pub(super) fn read(
    root: &Root,
    data: &Data,
    sources: &mut Sources,
    folder: Option<&Path>,
    budget: &Budget,
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<Images> {
    let limits = &options.limits;
    let mut encoded: Vec<Encoded> = Vec::new();
    let wanted = sources.wanted();
    let mut waiting: Vec<usize> = (0..wanted.len()).rev().filter(|&i| wanted[i]).collect();
    let mut looked_at = vec![false; root.images.len()];
    let mut pixels = 0_u64;
    while let Some(index) = waiting.pop() {
        if std::mem::replace(&mut looked_at[index], true) {
            continue;
        }
        let place = format!("images[{index}]");
        options.cancel.go_on()?;
        match open(root, data, sources, index, &place, folder, options, notices) {
            Ok((bytes, [width, height])) => {
                pixels = pixels.saturating_add(u64::from(width) * u64::from(height));
                if pixels > limits.image_pixels {
                    return Err(Fault::limit(place, "pixels of images", pixels, limits.image_pixels));
                }
                if let Cow::Owned(bytes) = &bytes {
                    budget.take(bytes.len() as u64, &place)?;
                }
                encoded.push(Encoded { index, place, bytes });
            }
            Err(fault @ (Fault::Limit { .. } | Fault::Cancelled)) => return Err(fault),
            Err(fault) => {
                let Some(substitutes) = sources.give_up(index) else { return Err(fault) };
                notices.approximated(format!("{place}: it cannot be read, so the file's substitute for it is shown"));
                waiting.extend(substitutes);
            }
        }
    }
    encoded.sort_by_key(|e| e.index);
    let left_out = looked_at.iter().filter(|looked| !**looked).count();
    let what = "images are the file's substitutes for ones that were read, or of kinds that are not, and were left out";
    notices.count(NoticeKind::Ignored, what, left_out as u64, "images");
    let mut numbers = vec![None; root.images.len()];
    for (number, image) in encoded.iter().enumerate() {
        numbers[image.index] = Some(number);
    }
    let order: Vec<usize> = encoded.iter().map(|e| e.index).collect();
    let steps = Steps::new(options, Phase::Images, [0.0, 1.0], encoded.len());
    let decoded: Vec<Fallible<(Image, Lost)>> = encoded
        .into_par_iter()
        .map(|Encoded { index, place, bytes }| {
            let (mut image, lost) = steps.each(|| decode(&bytes, &place, limits))?;
            let source = &root.images[index];
            image.name = match (&source.name, &source.uri) {
                (Some(name), _) if !name.is_empty() => name.clone(),
                (_, Some(uri)) if !uri.starts_with("data:") => uri.clone(),
                _ => place,
            };
            Ok((image, lost))
        })
        .collect();
    let mut images = Vec::with_capacity(decoded.len());
    for (i, (image, lost)) in settle(decoded)?.into_iter().enumerate() {
        let place = format!("images[{}]", order[i]);
        let what = "images of 16 bits a channel were reduced to 8";
        notices.count(NoticeKind::Approximated, what, lost.deep.into(), &place);
        let what = "images bring a colour profile, which is not applied";
        notices.count(NoticeKind::Ignored, what, lost.profile.into(), &place);
        images.push(Arc::new(image));
    }
    Ok(Images { images, numbers })
}

/// An image's bytes, and its size in pixels, which is within the limits.
#[expect(
    clippy::too_many_arguments,
    reason = "they are what the file and its reader know; a struct would name them once more"
)]
fn open<'a>(
    root: &Root,
    data: &Data<'a>,
    sources: &Sources,
    index: usize,
    place: &str,
    folder: Option<&Path>,
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<(Cow<'a, [u8]>, [u32; 2])> {
    let limits = &options.limits;
    let image = &root.images[index];
    let bytes = match (&image.uri, image.buffer_view) {
        (Some(uri), None) => {
            Cow::Owned(uri::resolve(uri, &format!("{place}.uri"), folder, limits.bytes, &|_| options.cancel.go_on())?)
        }
        (None, Some(view)) => Cow::Borrowed(data.view(view, &format!("{place}.bufferView"))?),
        (Some(_), Some(_)) => return Err(Fault::invalid(place, "has both a uri and a bufferView")),
        (None, None) => return Err(Fault::invalid(place, "has neither a uri nor a bufferView")),
    };
    let (width, height) =
        if ktx2::is_ktx2(&bytes) { ktx2::check(&bytes, place, limits)? } else { dimensions(&bytes, place, limits)? };
    let kind = kind(&bytes);
    if let Some(said) = &image.mime_type
        && kind.is_some_and(|kind| kind != said.0)
    {
        let what = "images are of another kind than their mimeType says; they were read as what they are";
        notices.count(NoticeKind::Repaired, what, 1, place);
    }
    let misplaced = kind.is_some_and(|kind| !sources.allow(index, kind));
    let what =
        "images are of a kind that needs an extension which their texture does not name; they were read all the same";
    notices.count(NoticeKind::Repaired, what, misplaced.into(), place);
    Ok((bytes, [width, height]))
}

/// The media type of an image by its first bytes.
fn kind(bytes: &[u8]) -> Option<&'static str> {
    if ktx2::is_ktx2(bytes) {
        return Some("image/ktx2");
    }
    image::guess_format(bytes).ok().map(|format| format.to_mime_type())
}

/// The image, and what of it is lost.
fn decode(bytes: &[u8], place: &str, limits: &Limits) -> Fallible<(Image, Lost)> {
    if ktx2::is_ktx2(bytes) {
        let (width, height, rgba) = ktx2::decode(bytes, place, limits)?;
        return Ok((Image { name: String::new(), width, height, rgba }, Lost::default()));
    }
    images::decode(bytes, place, limits)
}
