//! Distances between two points on layers.
//!
//! A point belongs to its part: it is kept where the file has it, so that the exploded view moves the line on the screen and
//! does not change what is measured.

use glam::DVec3;

use super::pictures::Picked;
use crate::scene::{Arrangement, Scene};

/// One end: where was clicked, and which of the layers there is meant.
#[derive(Clone, Debug, PartialEq)]
pub struct End {
    /// The layers; at least one.
    pub picked: Picked,
    /// Which of them.
    pub layer: usize,
    /// Each layer's point where the file has it, scene space.
    homes: Vec<DVec3>,
}

impl End {
    /// The nearest of these layers, found while parts were arranged so.
    pub fn new(picked: Picked, arrangement: &Arrangement, scene: &Scene) -> End {
        let offsets = arrangement.offsets(scene);
        let offset = |part: u32| offsets.get(part as usize).copied().unwrap_or_default();
        let homes = picked.layers.iter().map(|l| l.position - offset(l.part)).collect();
        End { picked, layer: 0, homes }
    }

    /// The point where the file has it, scene space.
    pub fn home(&self) -> DVec3 {
        self.homes.get(self.layer).copied().unwrap_or_default()
    }

    /// The part that it lies on.
    pub fn part(&self) -> u32 {
        self.picked.layers.get(self.layer).map_or(0, |l| l.part)
    }
}

/// What is measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measure {
    /// Whether clicks measure.
    pub on: bool,
    /// None, one or both.
    pub ends: Vec<End>,
}

/// A distance in the file's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// From the first point to the second.
    pub difference: DVec3,
    /// Its length.
    pub length: f64,
}

impl Measure {
    /// Takes an end: a third begins anew.
    pub fn take(&mut self, end: End) {
        if self.ends.len() > 1 {
            self.ends.clear();
        }
        self.ends.push(end);
    }

    /// The distance, once there are two ends.
    pub fn distance(&self) -> Option<Distance> {
        let [from, to] = self.ends.as_slice() else {
            return None;
        };
        let difference = to.home() - from.home();
        Some(Distance { difference, length: difference.length() })
    }
}

/// What follows a length of this file: glTF's are metres, the other formats do not say.
pub fn unit(file: &str) -> &'static str {
    let ending = file.rsplit('.').next().unwrap_or_default();
    if ["glb", "gltf"].iter().any(|e| ending.eq_ignore_ascii_case(e)) { "\u{202f}m" } else { "" }
}

/// A number for people: six significant digits, without zeros that say nothing.
pub fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { value.to_string() };
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-5..=9).contains(&magnitude) {
        return format!("{value:.5e}");
    }
    let text = format!("{value:.*}", usize::try_from(5 - magnitude).unwrap_or(0));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::camera;
    use crate::app::pictures::Wish;
    use crate::render::PickedLayer;
    use crate::scene::builtin;

    fn picked(scene: &Scene, layers: &[(u32, DVec3)]) -> Picked {
        let layers = layers.iter().map(|&(part, position)| PickedLayer {
            part,
            depth: 1.0,
            position,
            normal: DVec3::Z,
            kappa: 0.0,
            opacity: 1.0,
        });
        let of = camera::first(&scene.bounds(), 1.0);
        Picked { scene_number: 1, wish: Wish::Measure, pixel: [3, 4], of, layers: layers.collect() }
    }

    #[test]
    fn what_is_measured_is_the_file_not_the_exploded_view() {
        let scene = builtin::build("touching").unwrap();
        let exploded = Arrangement { explode: 1.5, ..Arrangement::default() };
        let offsets = exploded.offsets(&scene);
        assert!(offsets.iter().all(|o| o.length() > 0.0));
        let (a, b) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 6.0, 3.0));
        let last = scene.parts.len() as u32 - 1;
        let mut measure = Measure::default();
        let end = |part: u32, home: DVec3| picked(&scene, &[(part, home + offsets[part as usize])]);
        measure.take(End::new(end(0, a), &exploded, &scene));
        assert_eq!(measure.distance(), None);
        measure.take(End::new(end(last, b), &exploded, &scene));
        let distance = measure.distance().unwrap();
        assert!((distance.length - 5.0).abs() < 1e-12 && (distance.difference - (b - a)).length() < 1e-12);
        // Another layer of the second end.
        let two = picked(&scene, &[(0, a), (last, a + DVec3::Z)]);
        measure.take(End::new(two.clone(), &Arrangement::default(), &scene));
        assert_eq!(measure.ends.len(), 1, "a third end begins anew");
        measure.take(End { layer: 1, ..End::new(two, &Arrangement::default(), &scene) });
        assert_eq!(measure.distance().map(|d| d.length), Some(1.0));
        assert_eq!(measure.ends[1].part(), last);
    }

    #[test]
    fn lengths_have_a_unit_where_the_format_has_one() {
        assert_eq!(
            ["a.glb", "b.GLTF", "c.stl", "builtin:stack"].map(unit).map(|u| !u.is_empty()),
            [true, true, false, false]
        );
    }

    #[test]
    fn numbers_keep_what_counts() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.012_345_678, "0.0123457"),
            (-1234.5, "-1234.5"),
            (1_234_567.0, "1234567"),
            (1e-9, "1.00000e-9"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
