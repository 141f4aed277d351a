//! What cannot be drawn as asked, and what would fit.

/// Why a frame cannot be drawn as asked: what was asked, what the limit is, and what would fit.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum Refusal {
    /// The image is larger than the adapter's textures.
    #[error("an image of {width}x{height} pixels was asked for; this adapter's largest is {limit}x{limit}")]
    ImageTooLarge {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Largest edge.
        limit: u32,
    },
    /// An image without pixels.
    #[error("an image of {width}x{height} pixels has no pixels; both sides must be at least 1")]
    EmptyImage {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
    },
    /// The packed key's shape id has 16 bits (T4).
    #[error(
        "{parts} parts were asked for with the packed 32-bit key, whose shape id numbers at most 65535; \
         capture.bucketed_k_buffer.key = wide64 has no such limit"
    )]
    TooManyParts {
        /// Parts of the scene.
        parts: u64,
    },
    /// The wide key needs 64-bit atomics.
    #[error(
        "the Bucketed k-Buffer with the wide key was asked for; this adapter has no atomic minimum on 64-bit integers \
         that returns the old value. capture.kind = compacted gives the same picture; \
         capture.bucketed_k_buffer.key = packed32 also runs"
    )]
    NoAtomics64,
    /// Not even one row of pixels fits a binding.
    #[error(
        "k = {k} at a width of {width} needs {bytes} bytes for the {rows} rows of the smallest band; a binding holds \
         {limit}. {}", fits.map(|k| format!("k = {k} fits")).unwrap_or_else(|| "a smaller image or curvature radius is needed".to_owned())
    )]
    RowTooLarge {
        /// Slots asked for.
        k: u32,
        /// Width of the image.
        width: u32,
        /// Rows of the smallest band.
        rows: u64,
        /// Bytes needed.
        bytes: u64,
        /// Bytes that a binding holds.
        limit: u64,
        /// The largest k that fits.
        fits: Option<u32>,
    },
    /// Not even the pixel table of one row of pixels, with the rows that it needs around it, fits a binding.
    #[error(
        "a width of {width} needs {bytes} bytes for the pixel table of the {rows} rows of the smallest band; a binding \
         holds {limit}. A width of {fits} fits"
    )]
    TableTooLarge {
        /// Width of the image.
        width: u32,
        /// Rows of the smallest band.
        rows: u64,
        /// Bytes needed.
        bytes: u64,
        /// Bytes that a binding holds.
        limit: u64,
        /// The largest width that fits.
        fits: u32,
    },
    /// The image cannot be read back in one piece.
    #[error(
        "an image of {width}x{height} pixels needs a buffer of {bytes} bytes to be read back; this adapter's largest \
         has {limit}. {width}x{fits} fits"
    )]
    ReadBackTooLarge {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Bytes needed.
        bytes: u64,
        /// Bytes of the largest buffer.
        limit: u64,
        /// The largest height that fits.
        fits: u64,
    },
    /// The adapter binds fewer storage buffers than a pass declares.
    #[error(
        "a pass binds {needed} storage buffers; this adapter allows {limit} in one stage{}",
        without_tail.map(|n| format!(". capture.bucketed_k_buffer.tail = none needs {n}")).unwrap_or_default()
    )]
    TooFewBindings {
        /// Storage buffers needed.
        needed: u32,
        /// Storage buffers allowed.
        limit: u32,
        /// How many are needed without a tail, if that fits.
        without_tail: Option<u32>,
    },
    /// The transfer functions could not be read.
    #[error("{0}")]
    Transfer(String),
}
