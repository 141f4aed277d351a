//! The document: a model and everything seen of it that can be undone.
//!
//! [`Seen`] is one plain value: settings, camera and the arrangement of parts. Undo keeps whole values, one for each gesture: whatever
//! changes between [`Document::begin_gesture`] and [`Document::end_gesture`], or in one call of [`Document::settle`] without a
//! gesture, is one step. Nothing has to describe its own inverse, so nothing can describe it wrongly.

use std::sync::Arc;

use crate::math::Camera;
use crate::scene::{Arrangement, Scene};
use crate::session::Importing;
use crate::settings::Settings;

/// Most steps that are remembered.
const MOST_STEPS: usize = 1000;

/// What is seen of a model, and all that undo covers.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// Everything that a user can choose about a picture.
    pub settings: Settings,
    /// From where.
    pub camera: Camera,
    /// Which parts, how, and cut where.
    pub arrangement: Arrangement,
}

/// Steps back and forth over whole values.
#[derive(Clone, Debug)]
pub struct History<T> {
    past: Vec<T>,
    future: Vec<T>,
    settled: T,
}

impl<T: Clone + PartialEq> History<T> {
    /// Begins with a value.
    pub fn new(value: T) -> History<T> {
        History { past: Vec::new(), future: Vec::new(), settled: value }
    }

    /// Makes a step of whatever is different from the last one. What was undone before is forgotten then.
    pub fn settle(&mut self, value: &T) -> bool {
        if *value == self.settled {
            return false;
        }
        if self.past.len() == MOST_STEPS {
            self.past.remove(0);
        }
        self.past.push(std::mem::replace(&mut self.settled, value.clone()));
        self.future.clear();
        true
    }

    /// One step back. What is not settled yet becomes a step of its own first, so it can be had again.
    pub fn undo(&mut self, value: &mut T) -> bool {
        self.settle(value);
        let Some(before) = self.past.pop() else {
            return false;
        };
        self.future.push(std::mem::replace(&mut self.settled, before));
        #[cfg(test)]
        if super::planted::is(super::planted::Fault::LostStep) {
            self.future.pop();
        }
        *value = self.settled.clone();
        true
    }

    /// One step forward again.
    pub fn redo(&mut self, value: &mut T) -> bool {
        self.settle(value);
        let Some(after) = self.future.pop() else {
            return false;
        };
        self.past.push(std::mem::replace(&mut self.settled, after));
        *value = self.settled.clone();
        true
    }

    /// Whether there is something to undo and to redo, given the present value.
    pub fn ways(&self, value: &T) -> (bool, bool) {
        let settled = *value == self.settled;
        (!settled || !self.past.is_empty(), settled && !self.future.is_empty())
    }
}

/// A model and what is seen of it.
#[derive(Clone, Debug)]
pub struct Document {
    /// The file, or `builtin:NAME`, as it was asked for.
    pub file: String,
    /// The model.
    pub scene: Arc<Scene>,
    /// How it was read.
    pub import: Importing,
    /// What is seen, to be changed at will.
    pub seen: Seen,
    history: History<Seen>,
    in_gesture: bool,
}

impl Document {
    /// A model as first seen, read as usual.
    pub fn new(file: String, scene: Arc<Scene>, seen: Seen) -> Document {
        Document {
            file,
            scene,
            import: Importing::default(),
            history: History::new(seen.clone()),
            seen,
            in_gesture: false,
        }
    }

    /// Until [`Document::end_gesture`], changes belong together.
    pub fn begin_gesture(&mut self) {
        if !self.in_gesture {
            self.history.settle(&self.seen);
            self.in_gesture = true;
        }
    }

    /// Whether a gesture is under way.
    pub fn in_gesture(&self) -> bool {
        self.in_gesture
    }

    /// Makes one step of what changed since [`Document::begin_gesture`].
    pub fn end_gesture(&mut self) {
        self.in_gesture = false;
        self.history.settle(&self.seen);
    }

    /// Ends a gesture as if it had not been: the settings are as before it.
    pub fn abandon_gesture(&mut self) {
        self.in_gesture = false;
        self.seen.settings.clone_from(&self.history.settled.settings);
    }

    /// Makes a step of what changed, unless a gesture is under way.
    pub fn settle(&mut self) {
        if !self.in_gesture {
            self.history.settle(&self.seen);
        }
    }

    /// Back to before the last gesture; ends one that is under way.
    pub fn undo(&mut self) -> bool {
        self.in_gesture = false;
        self.history.undo(&mut self.seen)
    }

    /// What was undone, again.
    pub fn redo(&mut self) -> bool {
        self.in_gesture = false;
        self.history.redo(&mut self.seen)
    }

    /// Whether there is something to undo and to redo.
    pub fn ways(&self) -> (bool, bool) {
        self.history.ways(&self.seen)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::app::camera;

    #[derive(Clone, Debug)]
    enum Act {
        Gesture(Vec<u8>),
        Undo,
        Redo,
    }

    fn acts() -> impl Strategy<Value = Vec<Act>> {
        let act = prop_oneof![
            3 => prop::collection::vec(any::<u8>(), 1..4).prop_map(Act::Gesture),
            2 => Just(Act::Undo),
            1 => Just(Act::Redo),
        ];
        prop::collection::vec(act, 0..60)
    }

    fn document() -> Document {
        let scene = Arc::new(Scene::default());
        let camera = camera::first(&scene.bounds(), 1.0);
        Document::new(
            String::new(),
            scene,
            Seen { settings: Settings::default(), camera, arrangement: Arrangement::default() },
        )
    }

    /// One change of what is seen, whichever the number says.
    fn change(seen: &mut Seen, n: u8) {
        match n % 4 {
            3 => seen.arrangement.explode = f64::from(n) / 128.0,
            0 => seen.settings.light.key = f64::from(n) / 8.0,
            1 => seen.settings.opacity.gain = f64::from(n) / 64.0,
            _ => seen.camera = seen.camera.azimuth(f64::from(n)),
        }
    }

    proptest! {
        /// Against the obvious model: a list of values and a place in it.
        #[test]
        fn undo_and_redo_walk_over_whole_gestures(acts in acts()) {
            let mut document = document();
            let mut values = vec![document.seen.clone()];
            let mut at = 0;
            for act in acts {
                match act {
                    Act::Gesture(changes) => {
                        document.begin_gesture();
                        for n in changes {
                            change(&mut document.seen, n);
                            document.settle();
                        }
                        document.end_gesture();
                        if document.seen != values[at] {
                            values.truncate(at + 1);
                            values.push(document.seen.clone());
                            at += 1;
                        }
                    }
                    Act::Undo => {
                        prop_assert_eq!(document.undo(), at > 0);
                        at = at.saturating_sub(1);
                    }
                    Act::Redo => {
                        let more = at + 1 < values.len();
                        prop_assert_eq!(document.redo(), more);
                        at += usize::from(more);
                    }
                }
                prop_assert_eq!(&document.seen, &values[at]);
                prop_assert_eq!(document.ways(), (at > 0, at + 1 < values.len()));
            }
        }
    }

    #[test]
    fn undo_in_the_middle_of_a_gesture_goes_back_to_before_it() {
        let mut document = document();
        let before = document.seen.clone();
        document.begin_gesture();
        document.seen.settings.light.key = 9.0;
        document.settle();
        assert!(document.undo());
        assert_eq!(document.seen, before);
        assert!(document.redo());
        assert_eq!(document.seen.settings.light.key, 9.0);
    }

    #[test]
    fn memory_is_bounded() {
        let mut history = History::new(0);
        (1..=3000).for_each(|n| assert!(history.settle(&n)));
        let mut value = 3000;
        let steps = (0..).take_while(|_| history.undo(&mut value)).count();
        assert_eq!((steps, value), (MOST_STEPS, 3000 - MOST_STEPS as i32));
    }
}
