//! Which panels a window has room for, and how large each may be: the picture keeps some of any window.
//!
//! Panels give way before they are left out, and the list of parts is left out before what stands right of the picture. What
//! is left out comes back with the room for it; the preferences stay what they are. A panel that gives way has a name of its
//! own for egui, which remembers sizes by name: so the size that the user gave it is there again when there is room.

use egui::{Panel, Vec2};

use crate::app::config::Preferences;

/// Height of the status line, about, points.
const STATUS: f32 = 26.0;
/// What the picture keeps, points.
pub const LEAST_PICTURE: Vec2 = Vec2::new(260.0, 150.0);

/// How large a kind of panel may be, across its edge, points.
#[derive(Clone, Copy, Debug)]
struct Limits {
    default: f32,
    least: f32,
    most: f32,
}

const EDITORS: Limits = Limits { default: 232.0, least: 150.0, most: 520.0 };
const ACCURACY: Limits = Limits { default: 344.0, least: 300.0, most: 760.0 };
const STAGES: Limits = Limits { default: 316.0, least: 240.0, most: 520.0 };
const PARTS: Limits = Limits { default: 244.0, least: 236.0, most: 520.0 };

/// The sizes that the user gave the panels, points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Height of the transfer-function editors.
    pub editors: f32,
    /// Width of the accuracy panel.
    pub accuracy: f32,
    /// Width of the stages.
    pub stages: f32,
    /// Width of the parts.
    pub parts: f32,
}

impl Default for Sizes {
    fn default() -> Sizes {
        Sizes { editors: EDITORS.default, accuracy: ACCURACY.default, stages: STAGES.default, parts: PARTS.default }
    }
}

/// How large a panel is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Across its edge, points.
    pub size: f32,
    least: f32,
    most: f32,
    /// Whether that is less than the user wants.
    is_tight: bool,
}

impl Limits {
    /// A panel that is to be so large, within so many points; `None` if they are too few.
    fn within(self, wanted: f32, room: f32) -> Option<Size> {
        let size = wanted.clamp(self.least, self.most).min(room);
        let is_tight = room < wanted;
        (room >= self.least).then_some(Size { size, least: self.least, most: self.most.min(room), is_tight })
    }
}

impl Size {
    /// What egui remembers it by.
    pub fn id(&self, name: &str) -> String {
        if self.is_tight { format!("{name}, tight") } else { name.to_owned() }
    }

    /// A panel that is so large.
    pub fn panel(&self, panel: Panel) -> Panel {
        match self.is_tight {
            true => panel.resizable(false).exact_size(self.size),
            false => panel.resizable(true).default_size(self.size).size_range(self.least..=self.most),
        }
    }

    /// Takes over the size that the user has drawn it to.
    pub fn remember(&self, shown: f32, size: &mut f32) {
        if !self.is_tight {
            *size = shown;
        }
    }
}

/// The panels that are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Room {
    /// The transfer-function editors, below.
    pub editors: Option<Size>,
    /// The accuracy panel, right.
    pub accuracy: Option<Size>,
    /// The stages, right.
    pub stages: Option<Size>,
    /// The parts, left.
    pub parts: Option<Size>,
}

impl Room {
    /// In what is left of a window below the menu.
    pub fn of(available: Vec2, shown: &Preferences, sizes: &Sizes) -> Room {
        let [width, height] = [available.x - LEAST_PICTURE.x, available.y - STATUS - LEAST_PICTURE.y];
        let editors = EDITORS.within(sizes.editors, height).filter(|_| shown.editors);
        // The parts need so much; where they do not fit, the right has it all.
        let parts_need = if shown.parts { PARTS.least } else { 0.0 };
        let (limits, wanted) = if shown.accuracy { (ACCURACY, sizes.accuracy) } else { (STAGES, sizes.stages) };
        let beside = if width - parts_need >= limits.least { width - parts_need } else { width };
        let right = limits.within(wanted, beside).filter(|_| shown.accuracy || shown.stages);
        let left = width - right.map_or(0.0, |r| r.size);
        let parts = PARTS.within(sizes.parts, left).filter(|_| shown.parts);
        let (accuracy, stages) = if shown.accuracy { (right, None) } else { (None, right) };
        Room { editors, accuracy, stages, parts }
    }

    /// Names of what should be shown and is left out.
    pub fn left_out(&self, shown: &Preferences) -> Vec<&'static str> {
        let right = if shown.accuracy { self.accuracy } else { self.stages };
        [
            ("parts", shown.parts && self.parts.is_none()),
            (if shown.accuracy { "accuracy" } else { "stages" }, (shown.accuracy || shown.stages) && right.is_none()),
            ("editors", shown.editors && self.editors.is_none()),
        ]
        .into_iter()
        .filter_map(|(name, is_out)| is_out.then_some(name))
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::vec2;

    fn shown(accuracy: bool) -> Preferences {
        Preferences { accuracy, ..Preferences::default() }
    }

    #[test]
    fn a_usual_window_has_room_for_all_as_they_are() {
        let usual = Sizes::default();
        let room = Room::of(vec2(1280.0, 750.0), &shown(false), &usual);
        assert_eq!((room.editors.unwrap().size, room.stages.unwrap().size), (232.0, 316.0));
        assert_eq!((room.parts.unwrap().size, room.accuracy), (244.0, None));
        assert!(room.left_out(&shown(false)).is_empty());
        assert_eq!(room.parts.unwrap().id("parts"), "parts");
        let accuracy = Room::of(vec2(1280.0, 750.0), &shown(true), &usual);
        assert_eq!((accuracy.stages, accuracy.accuracy.unwrap().size), (None, 344.0));
    }

    #[test]
    fn the_picture_keeps_its_share_of_any_window() {
        for width in 0..1400 {
            for (accuracy, scale) in [(false, 1.0), (true, 1.0), (false, 2.0), (true, 0.5)] {
                let usual = Sizes::default();
                let sizes = Sizes {
                    editors: usual.editors * scale,
                    accuracy: usual.accuracy * scale,
                    stages: usual.stages * scale,
                    parts: usual.parts * scale,
                };
                let available = vec2(width as f32, width as f32 * 0.6);
                let room = Room::of(available, &shown(accuracy), &sizes);
                let size = |s: Option<Size>| s.map_or(0.0, |s| s.size);
                let sides = size(room.accuracy) + size(room.stages) + size(room.parts);
                assert!(sides == 0.0 || available.x - sides >= LEAST_PICTURE.x, "{width}: {room:?}");
                let below = size(room.editors);
                assert!(below == 0.0 || available.y - STATUS - below >= LEAST_PICTURE.y, "{width}: {room:?}");
                for part in [room.accuracy, room.stages, room.parts, room.editors].into_iter().flatten() {
                    assert!(part.least <= part.size && part.size <= part.most, "{part:?}");
                }
            }
        }
    }

    #[test]
    fn what_the_user_gave_a_panel_outlasts_a_small_window() {
        let mut sizes = Sizes { stages: 500.0, ..Sizes::default() };
        for (width, expected) in [(1280.0, 500.0), (1000.0, 500.0), (800.0, 304.0), (760.0, 264.0), (1280.0, 500.0)] {
            let size = Room::of(vec2(width, 750.0), &shown(false), &sizes).stages.unwrap();
            assert_eq!(size.size, expected, "{width}");
            size.remember(size.size, &mut sizes.stages);
        }
    }

    #[test]
    fn what_there_is_no_room_for_is_named() {
        let usual = Sizes::default();
        let tiny = Room::of(vec2(200.0, 150.0), &shown(false), &usual);
        assert_eq!(tiny.left_out(&shown(false)), ["parts", "stages", "editors"]);
        let small = Room::of(vec2(640.0, 430.0), &shown(true), &usual);
        assert_eq!(small.left_out(&shown(true)), ["parts"]);
        assert_eq!(small.accuracy.unwrap().size, 344.0);
        let none = Preferences { parts: false, stages: false, editors: false, ..Preferences::default() };
        assert!(Room::of(vec2(200.0, 150.0), &none, &usual).left_out(&none).is_empty());
    }
}
