//! Faults that tests plant, to show that what looks for faults finds them. A plant acts on its own thread only.

use std::cell::Cell;

/// A fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Answers of threads are taken for the present model's, whichever they are of.
    LateAnswers,
    /// The layer behind the last one under a pixel is looked at.
    PastTheEnd,
    /// What is undone cannot be had again.
    LostStep,
    /// A drag on the picture never ends.
    EndlessDrag,
    /// What panels change becomes no step of its own.
    Unsettled,
}

thread_local! {
    static PLANTED: Cell<Option<Fault>> = const { Cell::new(None) };
}

/// Whether this fault is planted.
pub fn is(fault: Fault) -> bool {
    PLANTED.get() == Some(fault)
}

/// Plants a fault for as long as something runs.
pub fn with<T>(fault: Fault, run: impl FnOnce() -> T) -> T {
    struct Weeded;
    impl Drop for Weeded {
        fn drop(&mut self) {
            PLANTED.set(None);
        }
    }
    PLANTED.set(Some(fault));
    let _weeded = Weeded;
    run()
}
