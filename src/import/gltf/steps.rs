//! Progress and cancellation of what is done piece by piece, in parallel.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::{Fallible, ImportOptions};
use crate::import::Phase;

/// One phase's pieces, some of them done.
pub(super) struct Steps<'a> {
    options: &'a ImportOptions,
    phase: Phase,
    done: AtomicUsize,
    of: usize,
    /// Which part of the phase these pieces are.
    part: [f32; 2],
}

impl<'a> Steps<'a> {
    /// `of` pieces of the part of `phase` between two shares, none of them done.
    pub(super) fn new(options: &'a ImportOptions, phase: Phase, part: [f32; 2], of: usize) -> Steps<'a> {
        Steps { options, phase, done: AtomicUsize::new(0), of, part }
    }

    /// Does one piece, unless the import was called off, and tells that it is done.
    pub(super) fn each<T>(&self, piece: impl FnOnce() -> Fallible<T>) -> Fallible<T> {
        self.options.cancel.go_on()?;
        let made = piece()?;
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let [from, to] = self.part;
        self.options.progress.tell(self.phase, from + (to - from) * done as f32 / self.of.max(1) as f32);
        Ok(made)
    }
}
