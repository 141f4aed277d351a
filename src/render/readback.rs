//! The store of the last frame, read back: what tests and reports compare.

use super::{RenderError, Renderer};

/// Columns of the store as plain data, layers of each pixel in depth order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoreReadback {}

impl Renderer {
    /// Reads back a buffer of the last frame by the name of its shader variable.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] if there is no such buffer or the device failed.
    pub fn read_words(&self, name: &str) -> Result<Vec<u32>, RenderError> {
        let buffer = self.resources.require("read-back", name)?;
        let bytes = self.gpu.read_buffer(buffer, buffer.size())?;
        Ok(bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect())
    }
}
