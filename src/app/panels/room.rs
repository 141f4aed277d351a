//! Which panels a window has room for, and how large each may be: the picture keeps some of any window.
//!
//! Panels give way before they are left out, and the list of parts is left out before what stands right of the picture. What
//! is left out comes back with the room for it; the preferences stay what they are. A panel that has to give way has a name
//! of its own for egui, which remembers sizes by name: the size that the user gave it is there again when there is room.

use egui::{Panel, Vec2};

use crate::app::config::Preferences;

/// Height of the status line, about, points.
const STATUS: f32 = 26.0;
/// What the picture keeps, points.
pub const LEAST_PICTURE: Vec2 = Vec2::new(260.0, 150.0);

/// How large a panel is, across its edge, points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// At first.
    default: f32,
    /// At least.
    least: f32,
    /// At most.
    most: f32,
    /// Whether that is less than it could be elsewhere.
    is_tight: bool,
}

const EDITORS: Size = Size { default: 232.0, least: 150.0, most: 520.0, is_tight: false };
const ACCURACY: Size = Size { default: 344.0, least: 300.0, most: 760.0, is_tight: false };
const STAGES: Size = Size { default: 316.0, least: 240.0, most: 520.0, is_tight: false };
const PARTS: Size = Size { default: 244.0, least: 140.0, most: 520.0, is_tight: false };

impl Size {
    /// Within so many points; `None` if that is too little.
    fn within(self, room: f32) -> Option<Size> {
        // As users have it is not known here; what a panel has at first is to fit.
        let is_tight = room < self.default;
        let most = if is_tight { room } else { self.most.min(room) };
        (room >= self.least).then_some(Size { most, default: self.default.min(room), is_tight, ..self })
    }

    /// What egui remembers it by.
    pub fn id(&self, name: &str) -> String {
        if self.is_tight { format!("{name}, tight") } else { name.to_owned() }
    }

    /// A panel that is so large.
    pub fn panel(&self, panel: Panel) -> Panel {
        panel.resizable(true).default_size(self.default).size_range(self.least..=self.most)
    }
}

/// The parts beside what is shown on the right, in so much of the width.
pub fn parts(available: f32) -> Option<Size> {
    PARTS.within(available - LEAST_PICTURE.x)
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
    pub fn of(available: Vec2, wanted: &Preferences) -> Room {
        let [width, height] = [available.x - LEAST_PICTURE.x, available.y - STATUS - LEAST_PICTURE.y];
        let editors = EDITORS.within(height).filter(|_| wanted.editors);
        // The parts need so much; where they do not fit, the right has it all.
        let parts_need = if wanted.parts { PARTS.least } else { 0.0 };
        let right = if wanted.accuracy { ACCURACY } else { STAGES };
        let is_right = wanted.accuracy || wanted.stages;
        let beside = if width - parts_need >= right.least { width - parts_need } else { width };
        let right = right.within(beside).filter(|_| is_right);
        let parts = parts(available.x - right.map_or(0.0, |r| r.default)).filter(|_| wanted.parts);
        let (accuracy, stages) = if wanted.accuracy { (right, None) } else { (None, right) };
        Room { editors, accuracy, stages, parts }
    }

    /// Names of what is wanted and left out.
    pub fn left_out(&self, wanted: &Preferences) -> Vec<&'static str> {
        let right = if wanted.accuracy { self.accuracy } else { self.stages };
        [
            ("parts", wanted.parts && self.parts.is_none()),
            (
                if wanted.accuracy { "accuracy" } else { "stages" },
                (wanted.accuracy || wanted.stages) && right.is_none(),
            ),
            ("editors", wanted.editors && self.editors.is_none()),
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

    fn wanted(accuracy: bool) -> Preferences {
        Preferences { accuracy, ..Preferences::default() }
    }

    #[test]
    fn a_usual_window_has_room_for_all_as_they_are() {
        let room = Room::of(vec2(1280.0, 750.0), &wanted(false));
        assert_eq!((room.editors.unwrap().default, room.stages.unwrap().default), (232.0, 316.0));
        assert_eq!((room.parts.unwrap().default, room.accuracy), (244.0, None));
        assert!(room.left_out(&wanted(false)).is_empty());
        assert_eq!(room.parts.unwrap().id("parts"), "parts");
        let accuracy = Room::of(vec2(1280.0, 750.0), &wanted(true));
        assert_eq!((accuracy.stages, accuracy.accuracy.unwrap().default), (None, 344.0));
    }

    #[test]
    fn the_picture_keeps_its_share_of_any_window() {
        for width in 0..1400 {
            for accuracy in [false, true] {
                let wanted = wanted(accuracy);
                let room = Room::of(vec2(width as f32, width as f32 * 0.6), &wanted);
                let size = |s: Option<Size>| s.map_or(0.0, |s| s.default);
                let sides = size(room.accuracy) + size(room.stages) + size(room.parts);
                assert!(sides == 0.0 || width as f32 - sides >= LEAST_PICTURE.x, "{width}: {room:?}");
                assert!(size(room.editors) == 0.0 || width as f32 * 0.6 - size(room.editors) >= LEAST_PICTURE.y);
                for part in [room.accuracy, room.stages, room.parts, room.editors].into_iter().flatten() {
                    assert!(part.least <= part.default && part.default <= part.most, "{part:?}");
                }
            }
        }
    }

    #[test]
    fn what_there_is_no_room_for_is_named() {
        assert_eq!(
            Room::of(vec2(200.0, 150.0), &wanted(false)).left_out(&wanted(false)),
            ["parts", "stages", "editors"]
        );
        let small = Room::of(vec2(640.0, 430.0), &wanted(true));
        assert_eq!(small.left_out(&wanted(true)), ["parts"]);
        assert_eq!(small.accuracy.unwrap().default, 344.0);
        let none = Preferences { parts: false, stages: false, editors: false, ..Preferences::default() };
        assert!(Room::of(vec2(200.0, 150.0), &none).left_out(&none).is_empty());
    }
}
