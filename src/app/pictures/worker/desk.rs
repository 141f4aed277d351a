//! Where orders lie until the worker takes them, and what it may do next.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::app::pictures::{Kind, Order, PickOrder};

/// How long the next preview waits for the window to show the last one, at most.
const LONGEST_SHOWING: Duration = Duration::from_millis(80);

/// What is ordered, and what is under way.
#[derive(Default)]
pub(super) struct Slot {
    pub(super) order: Option<Order>,
    pub(super) pick: Option<PickOrder>,
    /// For when there is nothing else.
    pub(super) hover: Option<PickOrder>,
    /// The same, of what is shown.
    pub(super) ahead: Option<Order>,
    /// Something is being drawn that will be shown.
    pub(super) at_work: bool,
    /// Something is being drawn ahead.
    pub(super) ahead_at_work: bool,
    /// The window is showing the last preview: until then the next one waits.
    pub(super) shut_until: Option<Instant>,
    pub(super) closed: bool,
}

/// What the window's thread and the worker share.
pub(super) struct Desk {
    pub(super) slot: Mutex<Slot>,
    pub(super) posted: Condvar,
    /// Raised while the picture at work is no longer wanted.
    pub(super) cancel: Arc<AtomicBool>,
}

/// What a panic elsewhere has left is as good as any.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Desk {
    /// Waits for the newest order and for its time to come; `None` when the window closes.
    pub(super) fn next(&self) -> Option<Work> {
        let mut slot = lock(&self.slot);
        loop {
            if slot.closed {
                return None;
            }
            if let Some(pick) = slot.pick.take() {
                self.cancel.store(false, Ordering::Relaxed);
                return Some(Work::Pick(Box::new(pick)));
            }
            if slot.order.is_none()
                && let Some(hover) = slot.hover.take()
            {
                self.cancel.store(false, Ordering::Relaxed);
                return Some(Work::Pick(Box::new(hover)));
            }
            if slot.order.is_none()
                && let Some(ahead) = slot.ahead.take()
            {
                self.cancel.store(false, Ordering::Relaxed);
                slot.ahead_at_work = true;
                return Some(Work::Ahead(Box::new(ahead)));
            }
            let begin = slot.order.as_ref().map(|o| slot.shut_until.map_or(o.not_before, |at| at.max(o.not_before)));
            let wait = begin.map(|at| at.saturating_duration_since(Instant::now()));
            slot = match wait {
                None => self.posted.wait(slot).unwrap_or_else(PoisonError::into_inner),
                Some(left) if !left.is_zero() => {
                    self.posted.wait_timeout(slot, left).unwrap_or_else(PoisonError::into_inner).0
                }
                Some(_) => {
                    self.cancel.store(false, Ordering::Relaxed);
                    slot.shut_until = None;
                    slot.at_work = true;
                    return slot.order.take().map(|order| Work::Draw(Box::new(order)));
                }
            };
        }
    }

    /// A picture is drawn and will be delivered.
    pub(super) fn finished(&self, kind: Kind) {
        let mut slot = lock(&self.slot);
        slot.at_work = false;
        slot.shut_until = (kind == Kind::Preview).then(|| Instant::now() + LONGEST_SHOWING);
    }

    /// Nothing is being drawn.
    pub(super) fn rest(&self) {
        let mut slot = lock(&self.slot);
        (slot.at_work, slot.ahead_at_work) = (false, false);
    }

    /// Waits whether there is nothing newer to do for so long.
    pub(super) fn stays_idle(&self, duration: Duration) -> bool {
        let until = Instant::now() + duration;
        let mut slot = lock(&self.slot);
        loop {
            if slot.order.is_some() || slot.pick.is_some() || slot.closed {
                return false;
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return true;
            }
            slot = self.posted.wait_timeout(slot, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Whether there is nothing newer to do.
    pub(super) fn is_idle(&self) -> bool {
        let slot = lock(&self.slot);
        slot.order.is_none() && slot.pick.is_none() && !slot.closed
    }

    /// Puts back an order that was given up only for a pick.
    pub(super) fn take_back(&self, order: Order) {
        let mut slot = lock(&self.slot);
        if slot.pick.is_some() && slot.order.is_none() {
            slot.order = Some(order);
        }
    }
}

/// What the thread does next.
pub(super) enum Work {
    Draw(Box<Order>),
    Pick(Box<PickOrder>),
    Ahead(Box<Order>),
}
