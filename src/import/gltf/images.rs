//! The images of a glTF file: where each comes from, and how much all of them take. `import::images` decodes.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use gltf_json::Root;
use rayon::prelude::*;

use super::accessor::Data;
use super::{Fallible, Fault, ImportOptions, Notices, uri};
use crate::import::images::{decode, dimensions};
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
        let (width, height) = dimensions(&bytes, &place, limits)?;
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
