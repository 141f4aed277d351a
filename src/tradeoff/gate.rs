//! Measuring beside somebody who works: frames are drawn only while a gate is open.
//!
//! Whoever needs the machine closes the gate ([`Gate::close`]); a frame at work is then given up, where it is drawn pass by pass,
//! or finished and thrown away, and drawn again when the gate opens. So a time is of a frame that had the machine from its
//! beginning to its end, and waiting is counted as nobody's ([`Workbench::idle`]).

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::workbench::{Drawn, Lane, Wanted, Workbench};
use crate::render::RenderError;
use crate::settings::Settings;

#[derive(Default)]
struct State {
    closed: bool,
    stopped: bool,
    /// How often it was closed.
    closings: u64,
}

/// What lets frames pass or not.
#[derive(Default)]
pub struct Gate {
    state: Mutex<State>,
    changed: Condvar,
    /// Raised while no frame is wanted.
    raised: Arc<AtomicBool>,
}

impl Gate {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// No frame passes until [`Gate::open`]; the one at work does not count.
    pub fn close(&self) {
        let mut state = self.lock();
        if !state.closed {
            state.closed = true;
            state.closings += 1;
            self.raised.store(true, Ordering::Relaxed);
        }
    }

    /// Frames pass again.
    pub fn open(&self) {
        let mut state = self.lock();
        state.closed = false;
        self.changed.notify_all();
    }

    /// Ends whatever is measured: every further frame is [`RenderError::Cancelled`].
    pub fn stop(&self) {
        let mut state = self.lock();
        state.stopped = true;
        self.raised.store(true, Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// Whether it is closed.
    pub fn is_closed(&self) -> bool {
        self.lock().closed
    }

    /// What renderers look at between passes ([`crate::render::Renderer::cancel`]).
    pub fn raised(&self) -> &Arc<AtomicBool> {
        &self.raised
    }

    /// Waits until a frame may pass; gives how often it has been closed, or `None` if it is stopped.
    fn pass(&self) -> Option<u64> {
        let mut state = self.lock();
        while state.closed && !state.stopped {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.stopped {
            return None;
        }
        self.raised.store(false, Ordering::Relaxed);
        Some(state.closings)
    }
}

/// A workbench behind a gate.
pub struct Gated<'a, B> {
    bench: B,
    gate: &'a Gate,
    idle: Duration,
}

impl<'a, B: Workbench> Gated<'a, B> {
    /// Puts `bench` behind `gate`. For frames to be given up early, its renderers look at [`Gate::raised`].
    pub fn new(bench: B, gate: &'a Gate) -> Gated<'a, B> {
        Gated { bench, gate, idle: Duration::ZERO }
    }
}

impl<B: Workbench> Workbench for Gated<'_, B> {
    fn draw(&mut self, lane: Lane, settings: &Settings, size: [u32; 2], wanted: Wanted) -> Result<Drawn, RenderError> {
        loop {
            let begin = Instant::now();
            let closings = self.gate.pass().ok_or(RenderError::Cancelled)?;
            self.idle += begin.elapsed();
            let begin = Instant::now();
            let result = self.bench.draw(lane, settings, size, wanted);
            let state = self.gate.lock();
            if state.stopped {
                return Err(RenderError::Cancelled);
            }
            if state.closings == closings {
                return result;
            }
            drop(state);
            self.idle += begin.elapsed();
        }
    }

    fn idle(&self) -> Duration {
        self.idle + self.bench.idle()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::LinearImage;
    use crate::passes::capture::LayerCounts;
    use crate::tradeoff::axis::{configurations, named};
    use crate::tradeoff::sweep::{self, Options};

    /// Draws in 5 ms; counts frames, and does something before one of them ends.
    struct StandIn<'a> {
        drawn: u32,
        during: &'a (dyn Fn(u32) + Sync),
    }

    impl Workbench for StandIn<'_> {
        fn draw(&mut self, _: Lane, _: &Settings, size: [u32; 2], _: Wanted) -> Result<Drawn, RenderError> {
            self.drawn += 1;
            std::thread::sleep(Duration::from_millis(5));
            (self.during)(self.drawn);
            let pixels = vec![[0.2, 0.2, 0.2, 1.0]; (size[0] * size[1]) as usize];
            Ok(Drawn {
                image: LinearImage { width: size[0], height: size[1], pixels },
                milliseconds: 5.0,
                passes: Vec::new(),
                counts: LayerCounts::default(),
                buffer_bytes: 0,
                layers: None,
            })
        }
    }

    fn draw(bench: &mut dyn Workbench) -> Result<Drawn, RenderError> {
        bench.draw(Lane::Candidate, &Settings::default(), [4, 4], Wanted::default())
    }

    #[test]
    fn nothing_is_drawn_while_the_gate_is_closed_and_waiting_is_idle() {
        let gate = Gate::default();
        gate.close();
        assert!(gate.is_closed());
        let mut bench = Gated::new(StandIn { drawn: 0, during: &|_| {} }, &gate);
        std::thread::scope(|scope| {
            let frame = scope.spawn(|| {
                draw(&mut bench).unwrap();
                (bench.idle(), bench.bench.drawn)
            });
            std::thread::sleep(Duration::from_millis(80));
            assert!(!frame.is_finished());
            gate.open();
            let (idle, drawn) = frame.join().unwrap();
            assert!(idle >= Duration::from_millis(60) && drawn == 1, "{idle:?}, {drawn}");
        });
        assert!(!gate.is_closed() && !gate.raised().load(Ordering::Relaxed));
    }

    #[test]
    fn a_frame_during_which_the_gate_was_closed_is_drawn_again() {
        let gate = Gate::default();
        let during = |n| {
            if n == 1 {
                gate.close();
                assert!(gate.raised().load(Ordering::Relaxed));
                gate.open();
            }
        };
        let mut bench = Gated::new(StandIn { drawn: 0, during: &during }, &gate);
        draw(&mut bench).unwrap();
        assert_eq!(bench.bench.drawn, 2);
        assert!(bench.idle() >= Duration::from_millis(5), "the first was in vain");
    }

    #[test]
    fn a_sweep_that_is_called_off_keeps_what_it_has_and_waiting_is_not_its_time() {
        let gate = Gate::default();
        let base = Settings::default();
        let all = configurations(&base, &named(&["radius".to_owned(), "reverse-check".to_owned()]).unwrap()).unwrap();
        assert!(all.len() >= 3);
        let options = Options { size: [8, 8], thumbnail: 0, most_frames: 2, ..Options::default() };
        let mut bench = Gated::new(StandIn { drawn: 0, during: &|_| {} }, &gate);
        let mut finished = Vec::new();
        let swept = sweep::run(&mut bench, &all, [&base, &base], &options, &mut |step| {
            finished.extend(step.finished.map(|r| r.configuration.name.clone()));
            if step.done == 1 {
                gate.close();
                std::thread::scope(|scope| {
                    scope.spawn(|| {
                        std::thread::sleep(Duration::from_millis(300));
                        gate.open();
                    });
                });
            }
            if step.done == 2 {
                gate.stop();
            }
        })
        .unwrap();
        assert_eq!(finished.len(), all.len() - 1, "the last one is in the result");
        let outcomes: Vec<_> = swept.rows.iter().map(|r| r.outcome.as_ref().map_err(String::as_str)).collect();
        assert!(outcomes[0].is_ok() && outcomes[1].is_ok(), "{outcomes:?}");
        assert!(outcomes[2..].iter().all(|o| o.is_err_and(|e| e.contains("called off"))), "{outcomes:?}");
        assert_eq!(swept.rows.len(), all.len());
    }
}
