//! Who draws: an exact picture that may take its time, and previews that may not.
//!
//! Two threads, each with a device of its own, so that neither waits in the other's queue, nor the window's frames in theirs.
//! Each has room for one order; the newest replaces the one before, so no queue builds up. While things move, previews are
//! drawn one after the other, each of what is newest when it begins, as coarse as [`pace`] finds needed to stay within
//! the target; on a software rasterizer of fewer triangles too ([`simplify`]), except where only opacity and light change and
//! the layers of the model itself could be captured while nothing moved. The exact picture is the very one of
//! `pellucid render`. It begins when nothing has moved for [`STILL`], or at once for an outline alone, and is abandoned, between passes, as soon as something
//! does. Where exact pictures are as fast as previews have to be, there are no previews.
//!
//! Previews and the window's frames take turns. An input that comes just after a preview has begun waits for that one to be
//! drawn and shown and for the next one, so what counts is twice the time of a preview and a frame; both at once, where the
//! same processor draws them, would make either late and the next preview one of an older input. So a preview begins when the
//! window has shown the one before ([`Pictures::shown`]), with what is newest then.

mod lowered;
pub mod pace;
pub mod simplify;
mod worker;

use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::document::Seen;
use super::watch::ShaderTexts;
use crate::math::{Camera, LinearImage};
use crate::render::{FrameReport, Kept, LayerHistogram, PickedLayer};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::transfer::TransferFunction;
use pace::{Change, Paces};
use worker::Worker;

/// What a preview may take, milliseconds, where frames of the window take next to nothing.
pub const TARGET: f64 = 40.0;
/// What a preview and the frame that shows it may take together, milliseconds: an input waits for two of each at most.
const TURN: f64 = 45.0;
/// However long frames take, a preview may take so much.
const LEAST_TARGET: f64 = 15.0;
/// How long nothing moves before the exact picture is begun.
pub const STILL: Duration = Duration::from_millis(150);

/// Which picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// In time rather than right.
    Preview,
    /// As `pellucid render` draws it.
    Exact,
}

impl Kind {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Preview => "preview",
            Kind::Exact => "exact",
        }
    }
}

/// Settings that the present ones are compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Against {
    /// The settings.
    pub settings: Settings,
    /// Their transfer functions.
    pub transfer: Arc<TransferFunction>,
    /// Texts that stand in for shader modules, if they are other ones than for the present settings.
    pub shaders: Option<Arc<ShaderTexts>>,
}

/// What pictures depend on or bring along beside what is seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extras {
    /// The transfer functions of the settings; they are resolved by the renderer if they could not be before.
    pub transfer: Option<Arc<TransferFunction>>,
    /// After the exact picture, another one with these settings is drawn.
    pub against: Option<Against>,
    /// Layers are counted by depth and curvature.
    pub counts: bool,
    /// Texts that stand in for shader modules.
    pub shaders: Arc<ShaderTexts>,
}

/// What is to be drawn.
#[derive(Clone)]
pub struct Order {
    /// Counts up; equal orders are equal pictures.
    pub number: u64,
    /// The scene.
    pub scene: Arc<Scene>,
    /// Another one has another number.
    pub scene_number: u64,
    /// Settings and camera.
    pub seen: Seen,
    /// The rest.
    pub extras: Extras,
    /// Of the viewport, pixels.
    pub size: [u32; 2],
    /// In what it differs from the order before.
    change: Change,
    /// Whether settings and transfer functions are those of the order before.
    same_settings: bool,
    /// When to begin.
    not_before: Instant,
}

/// What layers are wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// To select the part of the nearest; `more` keeps what is selected.
    Select {
        /// Whether what is selected stays so.
        more: bool,
    },
    /// To show them beside the cursor, when nothing else is to be done.
    Hover,
    /// To offer them in a list.
    List,
    /// To measure from or to one of them.
    Measure,
}

/// Layers that are to be found.
#[derive(Clone)]
pub struct PickOrder {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Another one has another number.
    pub scene_number: u64,
    /// Settings, camera and arrangement.
    pub seen: Seen,
    /// Of the viewport, pixels.
    pub size: [u32; 2],
    /// Column and row.
    pub pixel: [u32; 2],
    /// What for.
    pub wish: Wish,
}

/// Layers under a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Picked {
    /// Of which scene.
    pub scene_number: u64,
    /// What they are wanted for.
    pub wish: Wish,
    /// Column and row in the viewport.
    pub pixel: [u32; 2],
    /// From where it was seen.
    pub of: Camera,
    /// Nearest first.
    pub layers: Vec<PickedLayer>,
}

/// A drawn picture.
pub struct Picture {
    /// Of which order.
    pub number: u64,
    /// Exact or not.
    pub kind: Kind,
    /// Of which scene.
    pub scene_number: u64,
    /// Size of the viewport that it is for.
    pub viewport: [u32; 2],
    /// Its own size; smaller in a preview.
    pub size: [u32; 2],
    /// 8-bit sRGB, straight alpha.
    pub rgba: Vec<u8>,
    /// The exact picture before it was rounded, linear light.
    pub linear: Option<Arc<LinearImage>>,
    /// What is behind the model, linear light; `None` is transparent.
    pub background: Option<[f32; 3]>,
    /// From order to pixels.
    pub milliseconds: f64,
    /// Whether it was drawn without a GPU.
    pub software: bool,
    /// What the renderer says.
    pub report: FrameReport,
    /// What it shows.
    pub seen: Seen,
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Of which order.
    pub number: u64,
    /// Which picture.
    pub kind: Kind,
    /// What to say.
    pub message: String,
}

/// Layers of a picture, by depth and curvature.
#[derive(Clone, Debug)]
pub struct Counted {
    /// Exact pictures have all layers.
    pub kind: Kind,
    /// Of which scene.
    pub scene_number: u64,
    /// What the picture shows.
    pub seen: Seen,
    /// How many there are.
    pub layers: Arc<LayerHistogram>,
}

impl Counted {
    /// Whether these are worth more than those of `other`: newer, unless an exact picture of the same layers was counted
    /// before. Transfer functions and light make no layers.
    pub fn supersedes(&self, other: &Counted) -> bool {
        let (now, then) = (&self.seen, &other.seen);
        let same = self.scene_number == other.scene_number
            && (now.camera, &now.arrangement) == (then.camera, &then.arrangement)
            && (&now.settings.capture, &now.settings.features) == (&then.settings.capture, &then.settings.features);
        !(same && other.kind == Kind::Exact && self.kind == Kind::Preview)
    }
}

/// What comes back from the threads.
pub enum Delivery {
    /// A picture.
    Picture(Box<Picture>),
    /// None.
    Fault(Fault),
    /// What is under a pixel.
    Picked(Picked),
    /// The exact picture of [`Against`].
    Compared(Box<Picture>),
    /// Its layers, counted.
    Counts(Box<Counted>),
    /// Something that a user should know.
    Said(String),
}

/// Both threads and what was asked of them.
pub struct Pictures {
    preview: Worker,
    exact: Worker,
    pace: Arc<Mutex<Paces>>,
    deliveries: Receiver<Delivery>,
    number: u64,
    asked: Option<Order>,
    /// Whether what is shown may be drawn ahead for previews of other light. Not beside measurements.
    pub draws_ahead: bool,
    /// Of the last whole exact picture of a scene.
    exact_time: Option<(u64, f64)>,
}

impl Pictures {
    /// Starts the threads. `wake` is called, from them, when there is something to [`Pictures::take`].
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> Pictures {
        let wake: Arc<dyn Fn() + Send + Sync> = Arc::new(wake);
        let (sender, deliveries) = channel();
        let pace = Arc::new(Mutex::new(Paces::new(TARGET)));
        let start = |kind| Worker::start(kind, Arc::clone(&pace), sender.clone(), Arc::clone(&wake));
        Pictures {
            preview: start(Kind::Preview),
            exact: start(Kind::Exact),
            pace,
            deliveries,
            number: 0,
            asked: None,
            draws_ahead: true,
            exact_time: None,
        }
    }

    /// Asks for pictures, unless the same was asked for last; gives the number that they will have.
    pub fn ask(&mut self, scene: &Arc<Scene>, scene_number: u64, seen: &Seen, extras: Extras, size: [u32; 2]) -> u64 {
        if let Some(asked) = &self.asked
            && (asked.scene_number, asked.size) == (scene_number, size)
            && asked.seen == *seen
            && asked.extras == extras
        {
            return self.number;
        }
        self.number += 1;
        let now = Instant::now();
        let change = change(self.asked.as_ref(), (scene_number, seen, &extras));
        let before = self.asked.as_ref().filter(|o| o.scene_number == scene_number);
        let same_settings =
            before.is_none_or(|o| o.seen.settings == seen.settings && o.extras.transfer == extras.transfer);
        let only_selected = before.is_some_and(|o| only_selected(o, seen, &extras, size));
        let fast = self.exact_time.is_some_and(|(of, ms)| of == scene_number && ms <= TARGET);
        let order = Order {
            number: self.number,
            scene: Arc::clone(scene),
            scene_number,
            seen: seen.clone(),
            extras,
            size,
            change,
            same_settings,
            not_before: now,
        };
        // For an outline alone the exact picture is worth waiting for: a preview would hide it.
        let at_once = fast || only_selected;
        self.exact.post(Order { not_before: if at_once { now } else { now + STILL }, ..order.clone() });
        if !at_once {
            self.preview.post(order.clone());
        }
        self.asked = Some(order);
        self.number
    }

    /// Asks for the layers under a pixel, of the model itself and not of a simpler one.
    pub fn pick(&self, order: PickOrder) {
        self.exact.pick(order);
    }

    /// Asks for no layers to be shown beside the cursor any more.
    pub fn stop_hovering(&self) {
        self.exact.stop_hovering();
    }

    /// Asks again for what was asked for last, as after a fault.
    pub fn again(&mut self) {
        self.asked = None;
    }

    /// Asks for nothing: no model is open.
    pub fn clear(&mut self) {
        self.asked = None;
        self.preview.clear();
        self.exact.clear();
    }

    /// Whether a preview is being drawn or waits to be.
    pub fn previewing(&self) -> bool {
        self.preview.is_busy()
    }

    /// The last preview is on the screen, or not worth it: the next one may begin.
    pub fn shown(&self) {
        self.preview.release();
    }

    /// A frame of the window that shows another picture takes so long, of which previews take account.
    pub fn frame_takes(&self, milliseconds: f64) {
        let target = (TURN - milliseconds).clamp(LEAST_TARGET, TARGET);
        self.pace.lock().unwrap_or_else(PoisonError::into_inner).aim(target);
    }

    /// What came back since the last call.
    pub fn take(&mut self) -> Vec<Delivery> {
        let all: Vec<Delivery> = self.deliveries.try_iter().collect();
        for delivery in &all {
            if let Delivery::Picture(p) = delivery
                && p.kind == Kind::Exact
            {
                // A part of a frame says nothing about how long the next whole one takes.
                if p.report.kept == Kept::Nothing {
                    self.exact_time = Some((p.scene_number, p.milliseconds));
                }
            }
        }
        // The picture that it is compared with comes last, and is not to be held up.
        let last = |d: &Delivery| match d {
            Delivery::Picture(p) if p.kind == Kind::Exact => Some((p.number, false)),
            Delivery::Compared(p) => Some((p.number, true)),
            _ => None,
        };
        let fast = |o: &Order| self.exact_time.is_some_and(|(of, ms)| of == o.scene_number && ms <= TARGET);
        if self.draws_ahead
            && let Some(order) = self.asked.as_ref().filter(|o| !fast(o))
            && all.iter().filter_map(last).any(|d| d == (order.number, order.extras.against.is_some()))
        {
            self.preview.draw_ahead(Order { change: Change::Light, ..order.clone() });
        }
        all
    }

    /// The number of the last order.
    pub fn number(&self) -> u64 {
        self.number
    }
}

/// In what an order differs from the one before.
fn change(old: Option<&Order>, (scene_number, seen, extras): (u64, &Seen, &Extras)) -> Change {
    let Some(old) = old.filter(|o| o.scene_number == scene_number) else {
        return Change::Whole;
    };
    let same_look = old.seen.settings == seen.settings && old.seen.arrangement == seen.arrangement;
    let (then, now) = (&old.seen.settings, &seen.settings);
    if same_look && old.extras == *extras {
        // Where the view is the same too, the size is another one.
        if old.seen.camera == seen.camera { Change::Whole } else { Change::View }
    } else if old.seen.camera == seen.camera
        && old.seen.arrangement == seen.arrangement
        && (&then.capture, &then.features, then.opacity.model, then.opacity.base_model())
            == (&now.capture, &now.features, now.opacity.model, now.opacity.base_model())
        && old.extras.shaders == extras.shaders
    {
        Change::Light
    } else {
        Change::Whole
    }
}

/// Whether an order differs from the one before in what is selected, and in nothing else.
fn only_selected(before: &Order, seen: &Seen, extras: &Extras, size: [u32; 2]) -> bool {
    let mut then = before.seen.clone();
    then.arrangement.selected.clone_from(&seen.arrangement.selected);
    before.size == size && then == *seen && before.extras == *extras
}

/// Whether a picture is worth showing after the one that is shown: of a newer order, or the exact one of the same.
pub fn supersedes(new: (u64, Kind), shown: Option<(u64, Kind)>) -> bool {
    shown.is_none_or(|(number, kind)| {
        new.0 > number || (new.0 == number && new.1 == Kind::Exact && kind == Kind::Preview)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preview_does_not_count_anew_what_was_counted_exactly() {
        use crate::app::camera;
        use crate::scene::Arrangement;
        let camera = camera::first(&Scene::default().bounds(), 1.0);
        let seen = Seen { settings: Settings::default(), camera, arrangement: Arrangement::default() };
        let exact = Counted { kind: Kind::Exact, scene_number: 1, seen, layers: Arc::new(LayerHistogram::empty()) };
        let mut preview = Counted { kind: Kind::Preview, ..exact.clone() };
        preview.seen.settings.opacity.gain = 3.0;
        assert!(!preview.supersedes(&exact) && exact.supersedes(&preview) && preview.supersedes(&preview));
        assert!(Counted { scene_number: 2, ..preview.clone() }.supersedes(&exact));
        preview.seen.camera = camera.azimuth(5.0);
        assert!(preview.supersedes(&exact));
    }

    #[test]
    fn pictures_never_go_back() {
        use Kind::{Exact, Preview};
        assert!(supersedes((1, Preview), None));
        assert!(supersedes((1, Exact), Some((1, Preview))));
        assert!(!supersedes((1, Preview), Some((1, Exact))), "a late preview");
        assert!(!supersedes((1, Exact), Some((2, Preview))), "an exact picture of what is no longer seen");
        assert!(supersedes((3, Preview), Some((2, Exact))));
    }
}
