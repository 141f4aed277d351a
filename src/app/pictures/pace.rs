//! How coarse a preview is: the controller that holds its time.
//!
//! A preview has 1/d of the viewport's width and height, d one of [`DIVISORS`]. After each picture the controller takes the
//! finest of them whose time is inside the target. When it refines, time is taken to go with the number of pixels, which is too
//! careful and keeps it from going back and forth; when it coarsens, a part of it is taken not to (vertices, what every pass
//! costs).

/// Steps of coarseness.
pub const DIVISORS: [f64; 10] = [1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];
/// What a preview may take in any case for which only light and opacity are computed, milliseconds.
const LEAST_LIGHT: f64 = 24.0;
/// How much longer a preview of another view may take.
const VIEW: f64 = 1.75;
/// How much of its target a finer preview may be expected to take. Where layers are kept, another size captures them anew: what
/// is gained has to be worth it, and must not be lost again at the next slow picture.
const MARGIN: f64 = 0.85;
/// The same where layers are kept.
const MARGIN_LIGHT: f64 = 0.55;
/// Previews in a row, where layers are kept, that have to have been so fast.
const PATIENCE_LIGHT: u32 = 12;
/// Share of a preview's time that is taken not to depend on its pixels when it is made coarser: too much is one step too coarse,
/// too little another capture.
const FIXED: f64 = 0.15;
/// How much longer a picture takes between frames of the window than alone.
const DISTURBED: f64 = 1.5;
/// Rests after a size that was too slow in which no finer one is tried.
const DISTRUST: u32 = 4;
/// Where an unknown model begins.
const FIRST: usize = 5;
/// No preview has a side of fewer pixels, unless the viewport has.
const SMALLEST: f64 = 64.0;

/// What a preview has to show that the picture before does not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Another view. The picture before is moved along until it is there, so this one may take longer and show more.
    View,
    /// Other opacity or light, for which layers are kept.
    Light,
    /// Anything else: all is drawn anew.
    Whole,
}

impl Change {
    /// This one and another one.
    pub fn and(self, other: Change) -> Change {
        if self == other { self } else { Change::Whole }
    }
}

/// A pace for each kind of change: what one of them has learnt says nothing about the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Paces {
    view: Pace,
    light: Pace,
    whole: Pace,
}

impl Paces {
    /// For previews that take no longer than `target` milliseconds.
    pub fn new(target: f64) -> Paces {
        let pace = Pace::new(target);
        Paces {
            view: Pace::new(VIEW * target),
            light: Pace { margin: MARGIN_LIGHT, patience: PATIENCE_LIGHT, ..pace.clone() },
            whole: pace,
        }
    }

    /// The one of a change.
    pub fn of(&mut self, change: Change) -> &mut Pace {
        match change {
            Change::View => &mut self.view,
            Change::Light => &mut self.light,
            Change::Whole => &mut self.whole,
        }
    }

    /// What an input waits for may take no longer than this from now on. Where layers are kept, another size costs a whole frame
    /// for what it saves, so that there is less haste.
    pub fn aim(&mut self, target: f64) {
        (self.light.target, self.whole.target) = (target.max(LEAST_LIGHT), target);
    }

    /// Forgets what was measured: another model.
    pub fn restart(&mut self) {
        for pace in [&mut self.view, &mut self.light, &mut self.whole] {
            pace.restart();
        }
    }
}

/// Holds the time of previews.
#[derive(Clone, Debug, PartialEq)]
pub struct Pace {
    /// What a preview may take, milliseconds.
    pub target: f64,
    /// Share of it that a finer one may be expected to take.
    margin: f64,
    /// Previews in a row that have to be fast enough for a finer one.
    patience: u32,
    /// How many in a row have been.
    fast: u32,
    step: usize,
    /// Rests in which rehearsals are not believed that find a finer one: what they found was too slow for a hand.
    distrust: u32,
    /// The time of the last measurements at this step, smoothed.
    milliseconds: Option<f64>,
}

impl Pace {
    /// For pictures that take no longer than `target` milliseconds.
    pub fn new(target: f64) -> Pace {
        Pace { target, margin: MARGIN, patience: 1, fast: 0, step: FIRST, distrust: 0, milliseconds: None }
    }

    /// By how much width and height are divided.
    pub fn divisor(&self) -> f64 {
        DIVISORS[self.step]
    }

    /// The size of the next preview.
    pub fn size(&self, viewport: [u32; 2]) -> [u32; 2] {
        viewport.map(|n| {
            let n = f64::from(n.max(1));
            (n / self.divisor()).round().max(SMALLEST.min(n)) as u32
        })
    }

    /// Takes the time of a preview into account.
    pub fn measured(&mut self, milliseconds: f64) {
        if !milliseconds.is_finite() {
            return;
        }
        // A single slow picture (a shader compiled, another program at work) counts half.
        let smoothed = self.milliseconds.map_or(milliseconds, |m| 0.5 * (m + milliseconds));
        self.milliseconds = Some(smoothed);
        let next = self.fitting(smoothed, self.margin);
        self.fast = if next < self.step { self.fast + 1 } else { 0 };
        if next > self.step || self.fast >= self.patience {
            *self = Pace { milliseconds: None, step: next, fast: 0, ..*self };
        }
    }

    /// The step that a picture fits that takes so long at this one; a finer one only if it takes no more than this share of the
    /// target.
    fn fitting(&self, milliseconds: f64, margin: f64) -> usize {
        let pixels = |step: usize| 1.0 / (DIVISORS[step] * DIVISORS[step]);
        let fits = (0..DIVISORS.len()).find(|&step| {
            let more = pixels(step) / pixels(self.step);
            if step < self.step {
                milliseconds * more <= self.target * margin
            } else {
                milliseconds * (FIXED + (1.0 - FIXED) * more) <= self.target
            }
        });
        // Finer by one step at a time: it is seen.
        fits.unwrap_or(DIVISORS.len() - 1).max(self.step.saturating_sub(1))
    }

    /// Takes the time of a preview into account whose size is not to become finer.
    pub fn held(&mut self, milliseconds: f64) {
        let step = self.step;
        self.measured(milliseconds);
        if self.step < step {
            *self = Pace { step, fast: 0, milliseconds: None, ..*self };
        } else if self.step > step {
            self.distrust = DISTRUST;
        }
    }

    /// Nothing moves, and there will be rehearsals.
    pub fn rests(&mut self) {
        self.distrust = self.distrust.saturating_sub(1);
    }

    /// Goes back to the step of previews of this size.
    pub fn settle(&mut self, viewport: [u32; 2], size: [u32; 2]) {
        let of = |step: usize| Pace { step, ..*self }.size(viewport);
        if of(self.step) != size
            && let Some(step) = (0..DIVISORS.len()).find(|&s| of(s) == size)
        {
            *self = Pace { step, fast: 0, milliseconds: None, ..*self };
        }
    }

    /// Takes the time of a picture into account that was drawn for no other reason, at once: nobody waits. Says whether the next
    /// one has another size; a finer one only where that is allowed.
    pub fn rehearsed(&mut self, milliseconds: f64, may_refine: bool) -> bool {
        if !milliseconds.is_finite() {
            return false;
        }
        // The window's own frames will be drawn in between.
        let expected = milliseconds * DISTURBED;
        let fitting = self.fitting(expected, 1.0);
        let next = if may_refine && self.distrust == 0 { fitting } else { fitting.max(self.step) };
        let changes = next != self.step;
        // What comes is held against this: one slow picture is not the rule.
        let milliseconds = (!changes).then_some(expected);
        *self = Pace { milliseconds, step: next, fast: 0, ..*self };
        changes
    }

    /// Forgets what was measured: another model.
    pub fn restart(&mut self) {
        *self = Pace { margin: self.margin, patience: self.patience, ..Pace::new(self.target) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs the controller against a machine that takes `fixed + per_pixel · pixels`.
    fn settled(fixed: f64, per_full_picture: f64) -> (Pace, Vec<f64>) {
        let mut pace = Pace::new(60.0);
        let time = |p: &Pace| fixed + per_full_picture / (p.divisor() * p.divisor());
        let mut divisors = Vec::new();
        for _ in 0..60 {
            pace.measured(time(&pace));
            divisors.push(pace.divisor());
        }
        (pace, divisors)
    }

    #[test]
    fn it_settles_inside_the_target_and_stays() {
        for (fixed, full) in [(0.0, 30.0), (0.0, 500.0), (10.0, 1000.0), (30.0, 700.0), (45.0, 300.0), (20.0, 60.0)] {
            let (pace, divisors) = settled(fixed, full);
            let d = pace.divisor();
            assert!(fixed + full / (d * d) <= 60.0, "{fixed} {full}: divisor {d}");
            assert!(divisors[30..].iter().all(|&x| x == d), "{fixed} {full}: {divisors:?}");
        }
        assert_eq!(settled(0.0, 30.0).0.divisor(), 1.0);
        assert_eq!(settled(200.0, 10.0).0.divisor(), 8.0, "nothing helps: as coarse as can be");
    }

    #[test]
    fn one_slow_picture_does_not_undo_everything() {
        let (mut pace, _) = settled(10.0, 1000.0);
        let before = pace.divisor();
        pace.measured(90.0);
        assert!(pace.divisor() <= before * 1.5);
        pace.measured(f64::NAN);
    }

    #[test]
    fn paces_learn_apart() {
        let mut paces = Paces::new(40.0);
        paces.aim(20.0);
        paces.of(Change::Light).measured(1.0);
        assert_eq!(paces.of(Change::Light).divisor(), DIVISORS[FIRST], "one fast one is luck");
        for _ in 0..80 {
            paces.of(Change::Whole).measured(30.0);
            paces.of(Change::Light).measured(1.0);
            paces.of(Change::View).measured(30.0);
        }
        let divisors = [Change::View, Change::Light, Change::Whole].map(|c| paces.of(c).divisor());
        assert!(divisors[0] < divisors[2] && divisors[1] < divisors[2], "{divisors:?}");
        paces.restart();
        assert_eq!(paces.of(Change::Whole).divisor(), DIVISORS[FIRST]);
        assert_eq!(paces.of(Change::Whole).target, 20.0);
    }

    #[test]
    fn what_is_held_becomes_coarser_only() {
        let mut pace = Pace { margin: MARGIN_LIGHT, ..Pace::new(24.0) };
        for _ in 0..50 {
            pace.held(0.1);
            assert_eq!(pace.divisor(), DIVISORS[FIRST]);
        }
        pace.held(500.0);
        pace.held(500.0);
        let coarse = pace.divisor();
        assert!(coarse > DIVISORS[FIRST]);
        for _ in 1..DISTRUST {
            pace.rests();
            assert!(!pace.rehearsed(0.1, true), "it was too slow in earnest");
        }
        pace.rests();
        assert!(pace.rehearsed(0.1, true), "but not for ever");
        pace.settle([1280, 800], Pace { step: 2, ..pace.clone() }.size([1280, 800]));
        assert_eq!(pace.divisor(), DIVISORS[2]);
        pace.settle([1280, 800], [7, 7]);
        assert_eq!(pace.divisor(), DIVISORS[2], "no step has that size");
    }

    #[test]
    fn a_rehearsal_ends_at_a_size_that_fits() {
        for (fixed, full) in [(0.0, 30.0), (10.0, 1000.0), (12.0, 4000.0), (200.0, 10.0)] {
            let mut pace = Pace { margin: MARGIN_LIGHT, patience: PATIENCE_LIGHT, ..Pace::new(24.0) };
            let time = |p: &Pace| fixed + full / (p.divisor() * p.divisor());
            let (mut refined, mut may_refine, mut times) = (false, true, 0);
            loop {
                let before = pace.divisor();
                if !pace.rehearsed(time(&pace), may_refine) {
                    break;
                }
                let is_finer = pace.divisor() < before;
                (refined, may_refine) = (refined || is_finer, may_refine && (is_finer || !refined));
                times += 1;
                assert!(times < 8, "{fixed} {full}");
            }
            let last = DIVISORS[DIVISORS.len() - 1];
            assert!(time(&pace) <= 24.0 || pace.divisor() == last, "{fixed} {full}: {}", pace.divisor());
            assert!(!pace.rehearsed(f64::NAN, true));
        }
    }

    #[test]
    fn sizes_are_never_empty() {
        let pace = Pace { step: DIVISORS.len() - 1, ..Pace::new(60.0) };
        assert_eq!(pace.size([1280, 800]), [160, 100]);
        assert_eq!(pace.size([3, 1]), [3, 1]);
        assert_eq!(pace.size([0, 0]), [1, 1]);
    }
}
