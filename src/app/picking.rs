//! What becomes of layers that were found under a pixel: selected, shown beside the cursor, offered in a list, measured.

use super::measure::End;
use super::pictures::{Picked, Wish};
use super::workspace::{Gravity, Workspace};
use crate::math::Camera;
use crate::render::PickedLayer;

/// Clicks so near to each other are on the same place, pixels.
const SAME_PLACE: u32 = 2;

/// Whether a pixel is where layers were found before, from the same view.
fn is_same_place(picked: &Picked, pixel: [u32; 2], camera: &Camera) -> bool {
    picked.of == *camera && picked.pixel.iter().zip(pixel).all(|(a, b)| a.abs_diff(b) <= SAME_PLACE)
}

/// The first layer behind this one that is of another part; behind all of them follows the first.
fn next_part(layers: &[PickedLayer], at: usize) -> usize {
    let part = layers.get(at).map(|l| l.part);
    (at + 1..layers.len()).find(|&i| Some(layers[i].part) != part).unwrap_or(0)
}

impl Workspace {
    /// Takes what is under a pixel and does with it what it was wanted for. What is of another model is of no interest.
    pub fn take_picked(&mut self, picked: Picked) {
        let stale = picked.scene_number != self.scene_number;
        #[cfg(test)]
        let stale = stale && !super::planted::is(super::planted::Fault::LateAnswers);
        if stale {
            return;
        }
        let Some(document) = &self.document else {
            return;
        };
        tracing::debug!("{} layers found at {:?} for {:?}", picked.layers.len(), picked.pixel, picked.wish);
        match picked.wish {
            Wish::Select { more } => self.select_picked(picked, more),
            Wish::Hover => {
                // The view may have changed since.
                if picked.of == document.seen.camera {
                    self.hover = Some(picked);
                }
            }
            Wish::List => {
                self.hover = None;
                self.layout.stack = (!picked.layers.is_empty()).then_some(picked);
            }
            Wish::Measure if picked.layers.is_empty() => self.say(Gravity::Note, "There is nothing to measure there."),
            Wish::Measure => {
                let end = End::new(picked, &document.seen.arrangement, &document.scene);
                self.measure.take(end);
            }
        }
    }

    fn select_picked(&mut self, picked: Picked, more: bool) {
        if !picked.layers.is_empty() {
            self.picked = Some((picked, 0));
            self.choose_layer(0, more);
            return;
        }
        self.picked = None;
        self.pivot = None;
        if let Some(document) = &mut self.document
            && !more
        {
            document.settle();
            document.seen.arrangement.selected.clear();
            document.settle();
        }
    }

    /// Chooses the next part under this pixel, by its nearest layer of those that follow, if that is where was clicked before,
    /// from the same view.
    pub fn pick_next(&mut self, pixel: [u32; 2], more: bool) -> bool {
        let (Some((picked, at)), Some(document)) = (&self.picked, &self.document) else {
            return false;
        };
        if !is_same_place(picked, pixel, &document.seen.camera) {
            return false;
        }
        let next = next_part(&picked.layers, *at);
        #[cfg(test)]
        if super::planted::is(super::planted::Fault::PastTheEnd) {
            let _ = &picked.layers[at + 1];
        }
        self.choose_layer(next, more);
        true
    }

    /// Measures the next layer at the last end if this pixel is where it lies, from the same view.
    pub fn measure_next(&mut self, pixel: [u32; 2]) -> bool {
        let (Some(end), Some(document)) = (self.measure.ends.last_mut(), &self.document) else {
            return false;
        };
        let same = is_same_place(&end.picked, pixel, &document.seen.camera);
        if same {
            end.layer = (end.layer + 1) % end.picked.layers.len();
        }
        same
    }

    /// Selects the part of a layer under the last click, and turns about the place from then on.
    pub fn choose_layer(&mut self, layer: usize, more: bool) {
        let (Some((picked, at)), Some(document)) = (&mut self.picked, &mut self.document) else {
            return;
        };
        let Some(found) = picked.layers.get(layer) else {
            return;
        };
        *at = layer;
        self.pivot = Some(found.position);
        document.settle();
        let selected = &mut document.seen.arrangement.selected;
        if !more {
            selected.clear();
        }
        selected.insert(found.part);
        document.settle();
    }

    /// Chooses from the list that was asked for, and closes it.
    pub fn choose_from_stack(&mut self, layer: usize, more: bool) {
        if let Some(picked) = self.layout.stack.take() {
            self.picked = Some((picked, layer));
            self.choose_layer(layer, more);
        }
    }
}
