//! Our own format; the room's essay describes it.

use super::Imported;
use crate::transfer::{TransferError, TransferFunction};

/// Reads it; images that it names are not loaded.
pub(super) fn read(text: &str, path: &str) -> Result<Imported, TransferError> {
    Ok(Imported { function: TransferFunction::from_toml(text, path)?, notices: Vec::new() })
}

/// Writes it. Images become points, so that the file stands alone.
pub(super) fn write(function: &TransferFunction, notices: &mut Vec<String>) -> Result<String, TransferError> {
    let (alone, error) = function.without_images();
    if alone != *function {
        notices.push(format!("approximated: images as control points; largest error {error:.5}"));
    }
    alone.to_toml()
}
