//! Which image a texture shows, where extensions offer another one than glTF's own PNG or JPEG.
//!
//! KHR_texture_basisu names a KTX2 image, EXT_texture_webp a WebP one; a file that does not *require* the extension also
//! names an image for programs that cannot read it. The extension's image is taken where it can be read (it is what the
//! author made; the other is a copy for others), else the copy, which is told. Images that no texture shows in the end
//! because it has a better one are not decoded: AVIF and DDS images of other extensions must not refuse a file that has PNGs
//! as well.

use gltf_json::Root;

use super::accessor::missing;
use super::{Fallible, Fault};

/// Extensions that name an image of another kind, the best first, and which kind that is, if it can be read.
const OFFERS: [(&str, Option<&str>); 4] = [
    ("KHR_texture_basisu", Some("image/ktx2")),
    ("EXT_texture_webp", Some("image/webp")),
    ("EXT_texture_avif", None),
    ("MSFT_texture_dds", None),
];

/// The images of each texture.
pub(super) struct Sources {
    /// Per texture: the images that can be shown, the best first.
    pub(super) of_texture: Vec<Vec<usize>>,
    /// Per image: the textures that can show it.
    by_image: Vec<Vec<usize>>,
    /// Per image: whether a texture names it, in whatever way.
    named: Vec<bool>,
    /// Per image: the kinds that textures which name it take it for; an empty one is PNG or JPEG.
    kinds: Vec<Vec<&'static str>>,
}

/// Finds the images of all textures.
pub(super) fn find(root: &Root) -> Fallible<Sources> {
    let images = root.images.len();
    let mut sources = Sources {
        of_texture: Vec::new(),
        by_image: vec![Vec::new(); images],
        named: vec![false; images],
        kinds: vec![Vec::new(); images],
    };
    for (t, texture) in root.textures.iter().enumerate() {
        let mut offered = Vec::new();
        let mut name = |image: u64, place: String, kind: Option<&'static str>| {
            let image = usize::try_from(image).unwrap_or(usize::MAX);
            let (Some(named), Some(kinds)) = (sources.named.get_mut(image), sources.kinds.get_mut(image)) else {
                return Err(missing(place, "image", image, images));
            };
            *named = true;
            if let Some(kind) = kind {
                kinds.push(kind);
                offered.push(image);
            }
            Ok(())
        };
        for (extension, kind) in OFFERS {
            let object = texture.extensions.as_ref().and_then(|e| e.others.get(extension));
            let Some(source) = object.and_then(|o| o.get("source")) else { continue };
            let place = format!("textures[{t}].extensions.{extension}.source");
            let image = source.as_u64().ok_or_else(|| Fault::invalid(&place, "is not an index"))?;
            name(image, place, kind)?;
        }
        // `gltf-json` writes a texture without an image as this index.
        let core = texture.source.value();
        if core != u32::MAX as usize {
            name(core as u64, format!("textures[{t}].source"), Some(""))?;
        }
        for &image in &offered {
            sources.by_image[image].push(t);
        }
        sources.of_texture.push(offered);
    }
    Ok(sources)
}

impl Sources {
    /// The images to decode: those that textures show first, and those that no texture names, which nobody needs but
    /// which say that the file is bad if they are.
    pub(super) fn wanted(&self) -> Vec<bool> {
        let mut wanted: Vec<bool> = self.named.iter().map(|named| !named).collect();
        for &image in self.of_texture.iter().filter_map(|offered| offered.first()) {
            wanted[image] = true;
        }
        wanted
    }

    /// Whether an image of this kind may stand where textures name it.
    pub(super) fn allow(&self, image: usize, kind: &str) -> bool {
        let core = matches!(kind, "image/png" | "image/jpeg");
        self.kinds.get(image).is_none_or(|kinds| kinds.iter().all(|&k| if k.is_empty() { core } else { k == kind }))
    }

    /// Gives up an image that cannot be read, if each texture that shows it has another one; gives those.
    pub(super) fn give_up(&mut self, image: usize) -> Option<Vec<usize>> {
        let textures = self.by_image.get(image)?.clone();
        let mut substitutes = Vec::new();
        for &texture in &textures {
            let offered = &self.of_texture[texture];
            if offered.first() == Some(&image) {
                substitutes.push(*offered.iter().find(|&&other| other != image)?);
            }
        }
        if substitutes.is_empty() {
            return None;
        }
        for texture in textures {
            self.of_texture[texture].retain(|&other| other != image);
        }
        Some(substitutes)
    }
}
