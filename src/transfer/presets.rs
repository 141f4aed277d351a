//! The transfer functions inside the program: the files of `transfer_functions/`.
//!
//! `murray-6a.png` and `murray-7b.png` are made by `strip_6a` and `map_7b`; a test compares them, and writes them
//! anew when `PELLUCID_WRITE_PRESETS` is set.

use include_dir::{Dir, include_dir};

static FILES: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/transfer_functions");

/// An embedded transfer function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Its name: the file's stem.
    pub name: &'static str,
    /// What it shows: the comment at the head of the file.
    pub description: &'static str,
}

/// Names of the embedded transfer functions, in alphabetical order.
pub fn names() -> Vec<&'static str> {
    presets().iter().map(|p| p.name).collect()
}

/// The embedded transfer functions, in alphabetical order of their names.
pub fn presets() -> Vec<Preset> {
    let mut all: Vec<Preset> = FILES
        .files()
        .filter(|f| f.path().extension().is_some_and(|e| e == "toml"))
        .filter_map(|f| {
            let name = f.path().file_stem()?.to_str()?;
            let first = f.contents_utf8()?.lines().next().unwrap_or_default();
            Some(Preset { name, description: first.trim_start_matches('#').trim() })
        })
        .collect();
    all.sort_by_key(|p| p.name);
    all
}

/// The bytes of an embedded file.
pub(super) fn file(path: &str) -> Option<&'static [u8]> {
    FILES.get_file(path).map(include_dir::File::contents)
}

/// Figure 6(a) as a strip of grey bytes: bright convexities on the left, dark concavities on the right, steepest at
/// flat.
#[cfg(test)]
pub(super) fn strip_6a() -> image::GrayImage {
    image::GrayImage::from_fn(256, 1, |x, _| {
        let kappa = f64::from(x) / 127.5 - 1.0;
        image::Luma([byte(0.5 - 0.5 * kappa * (1.6 - 0.6 * kappa.abs()))])
    })
}

/// Figure 7(b) as an image: flat and near is clear, curved and far is opaque, and both grow slowly over the whole range.
#[cfg(test)]
pub(super) fn map_7b() -> image::GrayImage {
    image::GrayImage::from_fn(256, 256, |x, y| {
        let (depth, kappa) = (f64::from(x) / 255.0, 1.0 - f64::from(y) / 255.0);
        let flat = 0.04 + 0.36 * depth.powf(1.5);
        let curved = 0.55 + 0.4 * depth;
        let rise = kappa * kappa * (3.0 - 2.0 * kappa);
        image::Luma([byte(flat + (curved - flat) * rise)])
    })
}

#[cfg(test)]
fn byte(v: f64) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0).round() as u8
}
