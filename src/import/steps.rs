//! Progress and cancellation of what is done piece by piece, in parallel.
//!
//! Where one piece fails, those that have not begun are not done: a file of a hundred thousand streams, all of them too large,
//! must end with the first. [`settle`] gives the first fault in the file's order among those that were found.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::{Fallible, Fault, ImportOptions, Phase};

/// One phase's pieces, some of them done.
pub(super) struct Steps<'a> {
    options: &'a ImportOptions,
    phase: Phase,
    done: AtomicUsize,
    of: usize,
    /// Which part of the phase these pieces are.
    part: [f32; 2],
    /// One failed.
    failed: AtomicBool,
}

impl<'a> Steps<'a> {
    /// `of` pieces of the part of `phase` between two shares, none of them done.
    pub(super) fn new(options: &'a ImportOptions, phase: Phase, part: [f32; 2], of: usize) -> Steps<'a> {
        Steps { options, phase, done: AtomicUsize::new(0), of, part, failed: AtomicBool::new(false) }
    }

    /// Does one piece, unless the import was called off or another piece failed, and tells that it is done.
    pub(super) fn each<T>(&self, piece: impl FnOnce() -> Fallible<T>) -> Fallible<T> {
        self.options.cancel.go_on()?;
        if self.failed.load(Ordering::Relaxed) {
            return Err(Fault::Cancelled);
        }
        let made = piece().inspect_err(|_| self.failed.store(true, Ordering::Relaxed))?;
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let [from, to] = self.part;
        self.options.progress.tell(self.phase, from + (to - from) * done as f32 / self.of.max(1) as f32);
        Ok(made)
    }
}

/// What all pieces made, or the first fault; pieces that were not done because of it do not count.
pub(super) fn settle<T>(pieces: Vec<Fallible<T>>) -> Fallible<Vec<T>> {
    let mut made = Vec::with_capacity(pieces.len());
    let mut called_off = false;
    for piece in pieces {
        match piece {
            Ok(piece) => made.push(piece),
            Err(Fault::Cancelled) => called_off = true,
            Err(fault) => return Err(fault),
        }
    }
    if called_off { Err(Fault::Cancelled) } else { Ok(made) }
}
