//! Bytes that a file makes us hold: its buffers, and what compressed ones become.
//!
//! A few hundred compressed bytes may stand for millions of vertices, and several primitives may share one stream, so
//! what is decoded is charged before it is decoded, to the same account as the buffers. Decoders run in parallel;
//! the account is shared.

use std::sync::atomic::{AtomicU64, Ordering};

use super::{Fallible, Fault, Limits};

/// How many bytes are spoken for.
pub(super) struct Budget {
    taken: AtomicU64,
    limit: u64,
}

impl Budget {
    /// An empty account over [`Limits::bytes`].
    pub(super) fn new(limits: &Limits) -> Budget {
        Budget { taken: AtomicU64::new(0), limit: limits.bytes }
    }

    /// Charges `bytes` for what `place` is about to hold.
    pub(super) fn take(&self, bytes: u64, place: &str) -> Fallible<()> {
        // Never wraps: the sum stays at the largest number, which is over any limit.
        let before = self
            .taken
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |taken| Some(taken.saturating_add(bytes)))
            .unwrap_or(u64::MAX);
        let taken = before.saturating_add(bytes);
        if taken > self.limit {
            return Err(Fault::limit(place, "bytes of buffers, compressed ones decoded,", taken, self.limit));
        }
        Ok(())
    }
}
