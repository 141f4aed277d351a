//! How a scene's parts are shown, apart from camera and settings: hidden, ghosted, coloured, moved apart, cut, selected.
//!
//! Plain data over part indices; [`crate::session`] names parts where it is written to a file. What an arrangement does to
//! positions is a pure function here ([`Arrangement::offsets`]), so that the renderer, the oracle and the camera agree.
//!
//! **Exploded view.** Every node has a box, around all parts at or below it where the file puts them. A node's children
//! move away from the middle of its box by `explode` times the offset of their own box's middle from it, and take
//! everything below them along, so nested levels add up. Roots are the children of the scene. A mesh of a node moves with
//! its node. Hidden parts count, so that hiding one moves nothing.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat4, DVec3};
use serde::{Deserialize, Serialize};

use super::{Scene, SceneStats};
use crate::math::Bounds;

/// Most section planes.
pub const MOST_SECTIONS: usize = 6;
/// Largest factor of the exploded view.
pub const MOST_EXPLODED: f64 = 4.0;

/// How the parts of a scene are shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrangement {
    /// Looks by index in [`Scene::parts`]; a part without an entry has [`PartLook::default`].
    pub parts: BTreeMap<u32, PartLook>,
    /// How far parts move apart, 0 to [`MOST_EXPLODED`]; 0 leaves everything in place.
    pub explode: f64,
    /// Section planes, at most [`MOST_SECTIONS`].
    pub sections: Vec<Section>,
    /// Parts that are outlined through everything in front of them.
    pub selected: BTreeSet<u32>,
}

/// How one part is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartLook {
    /// Whether it is there at all.
    pub presence: Presence,
    /// Factor, 0 to 1, of what the opacity model gives.
    pub opacity: f64,
    /// Replaces base colour: sRGB, 0 to 1.
    pub color: Option<[f64; 3]>,
    /// Whether the opacity model acts.
    pub style: PartStyle,
}

impl Default for PartLook {
    fn default() -> PartLook {
        PartLook { presence: Presence::Shown, opacity: 1.0, color: None, style: PartStyle::AsSet }
    }
}

impl PartLook {
    /// Whether some light passes that the opacity model alone would stop.
    pub fn is_faded(&self) -> bool {
        self.presence == Presence::Ghosted || self.opacity < 1.0
    }
}

/// Whether a part is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Presence {
    /// As everything else.
    #[default]
    Shown,
    /// Its opacity, lines included, is multiplied by `opacity.ghost`.
    Ghosted,
    /// Not drawn.
    Hidden,
}

/// Whether the opacity model acts on a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PartStyle {
    /// It does.
    #[default]
    AsSet,
    /// Opacity is 1 whatever the model says; [`PartLook::opacity`] and ghosting still multiply it.
    Solid,
}

/// A plane that cuts away what lies on one side of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Unit vector; what lies on its side is cut away.
    pub normal: DVec3,
    /// `normal · x` of the plane's points, in the file's coordinates.
    pub offset: f64,
    /// Whether it cuts.
    pub enabled: bool,
    /// Whether the cut is closed.
    pub caps: bool,
}

/// Why an arrangement does not fit a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ArrangementError {
    /// A part that does not exist.
    #[error("part {part} does not exist: the scene has {parts}")]
    NoSuchPart {
        /// The index that was given.
        part: u32,
        /// How many parts there are.
        parts: usize,
    },
    /// A number out of its range.
    #[error("{what} = {value}: expected {expected}")]
    Value {
        /// What the number is.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// More section planes than can be drawn.
    #[error("{sections} section planes: at most {MOST_SECTIONS} can cut")]
    TooManySections {
        /// How many there are.
        sections: usize,
    },
}

fn inside(what: &'static str, value: f64, most: f64, expected: &'static str) -> Result<(), ArrangementError> {
    if (0.0..=most).contains(&value) { Ok(()) } else { Err(ArrangementError::Value { what, value, expected }) }
}

impl Arrangement {
    /// The look of a part.
    pub fn look(&self, part: u32) -> PartLook {
        self.parts.get(&part).copied().unwrap_or_default()
    }

    /// Whether a part is drawn.
    pub fn is_drawn(&self, part: u32) -> bool {
        self.look(part).presence != Presence::Hidden
    }

    /// Shows `parts` and ghosts everything else of a scene of `count` parts; colours and styles stay.
    pub fn isolate(&mut self, parts: &BTreeSet<u32>, count: u32) {
        for part in 0..count {
            let presence = if parts.contains(&part) { Presence::Shown } else { Presence::Ghosted };
            self.parts.entry(part).or_default().presence = presence;
        }
        self.parts.retain(|_, look| *look != PartLook::default());
    }

    /// Checks every number, whatever the scene.
    ///
    /// # Errors
    /// [`ArrangementError`] names what is out of range.
    pub fn check_values(&self) -> Result<(), ArrangementError> {
        inside("explode", self.explode, MOST_EXPLODED, "a number from 0 to 4")?;
        for look in self.parts.values() {
            inside("opacity of a part", look.opacity, 1.0, "a number from 0 to 1")?;
            for channel in look.color.into_iter().flatten() {
                inside("colour of a part", channel, 1.0, "numbers from 0 to 1")?;
            }
        }
        if self.sections.len() > MOST_SECTIONS {
            return Err(ArrangementError::TooManySections { sections: self.sections.len() });
        }
        for section in &self.sections {
            let value = section.normal.length();
            if value.is_nan() || (value - 1.0).abs() > 1e-6 {
                let (what, expected) = ("length of a section's normal", "1");
                return Err(ArrangementError::Value { what, value, expected });
            }
            if !section.offset.is_finite() {
                let (what, expected) = ("offset of a section", "a finite number");
                return Err(ArrangementError::Value { what, value: section.offset, expected });
            }
        }
        Ok(())
    }

    /// Checks that the arrangement fits a scene.
    ///
    /// # Errors
    /// [`ArrangementError`] names what does not.
    pub fn check(&self, scene: &Scene) -> Result<(), ArrangementError> {
        let parts = scene.parts.len();
        match self.parts.keys().chain(&self.selected).find(|&&part| part as usize >= parts) {
            Some(&part) => Err(ArrangementError::NoSuchPart { part, parts }),
            None => self.check_values(),
        }
    }

    /// How far each part moves, scene units, by part: see the [module's notes](self).
    pub fn offsets(&self, scene: &Scene) -> Vec<DVec3> {
        if self.explode == 0.0 {
            return vec![DVec3::ZERO; scene.parts.len()];
        }
        let order = parents_first(scene);
        let mut boxes = vec![Bounds::EMPTY; scene.nodes.len()];
        for part in &scene.parts {
            boxes[part.node] = boxes[part.node].union(part.bounds);
        }
        for &node in order.iter().rev() {
            if let Some(parent) = scene.nodes[node].parent {
                boxes[parent] = boxes[parent].union(boxes[node]);
            }
        }
        let whole = scene.bounds().center();
        let mut moved = vec![DVec3::ZERO; scene.nodes.len()];
        for &node in order.iter().filter(|&&node| !boxes[node].is_empty()) {
            let (base, middle) = match scene.nodes[node].parent {
                Some(parent) => (moved[parent], boxes[parent].center()),
                None => (DVec3::ZERO, whole),
            };
            moved[node] = base + self.explode * (boxes[node].center() - middle);
        }
        scene.parts.iter().map(|part| moved[part.node]).collect()
    }

    /// The scene with its parts where the arrangement puts them. Numbers of parts and triangles stay; a hidden part keeps
    /// its place in the list and has no extent.
    #[must_use]
    pub fn placed(&self, scene: &Scene) -> Placed {
        let offsets = self.offsets(scene);
        let parts = scene.parts.iter().zip(offsets).enumerate().map(|(i, (part, offset))| {
            let bounds = match (self.is_drawn(i as u32), part.bounds.is_empty()) {
                (true, false) => Bounds { min: part.bounds.min + offset, max: part.bounds.max + offset },
                _ => Bounds::EMPTY,
            };
            // No product where nothing moves: the transform stays as it is, bit for bit.
            let world_from_part = if offset == DVec3::ZERO {
                part.world_from_part
            } else {
                DMat4::from_translation(offset) * part.world_from_part
            };
            PlacedPart { world_from_part, bounds }
        });
        Placed { parts: parts.collect() }
    }

    /// The box around all parts where the arrangement puts them, hidden ones included: what a camera frames, so that hiding
    /// a part does not move the picture.
    pub fn framed_bounds(&self, scene: &Scene) -> Bounds {
        let boxes = scene.parts.iter().zip(self.offsets(scene)).filter(|(part, _)| !part.bounds.is_empty());
        boxes.fold(Bounds::EMPTY, |all, (part, offset)| {
            all.union(Bounds { min: part.bounds.min + offset, max: part.bounds.max + offset })
        })
    }

    /// What the planner needs to know of the arranged scene, but for the caps of section planes
    /// ([`super::Cut::count_into`]).
    pub fn stats(&self, scene: &Scene) -> SceneStats {
        let placed = self.placed(scene);
        let mut stats = SceneStats::of_parts(scene, |part| self.is_drawn(part));
        stats.bounds = placed.parts.iter().fold(Bounds::EMPTY, |all, part| all.union(part.bounds));
        let drawn = (0..scene.parts.len() as u32).filter(|&part| self.is_drawn(part));
        for look in drawn.clone().map(|part| self.look(part)) {
            stats.faded_parts += u64::from(look.is_faded());
            stats.solid_parts += u64::from(look.style == PartStyle::Solid);
            stats.recolored_parts += u64::from(look.color.is_some());
        }
        stats.section_planes = self.sections.iter().filter(|s| s.enabled).count() as u64;
        stats.selected_parts = drawn.filter(|part| self.selected.contains(part)).count() as u64;
        stats
    }
}

/// Where the parts of an arranged scene are, by part.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// One for each part of the scene.
    pub parts: Vec<PlacedPart>,
}

/// Where an arrangement puts a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedPart {
    /// Scene space from mesh space.
    pub world_from_part: DMat4,
    /// Bounding box in scene space; empty for a hidden part.
    pub bounds: Bounds,
}

/// All nodes, each after its parent.
fn parents_first(scene: &Scene) -> Vec<usize> {
    let mut order: Vec<usize> = (0..scene.nodes.len()).filter(|&n| scene.nodes[n].parent.is_none()).collect();
    let mut seen = vec![false; scene.nodes.len()];
    let mut next = 0;
    while let Some(&node) = order.get(next) {
        next += 1;
        // A malformed hierarchy may name a node twice.
        if !std::mem::replace(&mut seen[node], true) {
            order.extend(scene.nodes[node].children.iter().filter(|&&child| !seen[child]));
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Mesh, Node, Primitive};

    /// A unit cube's corners around the origin, as a flat mesh: boxes are all that matters here.
    fn mesh() -> Mesh {
        let primitive = Primitive {
            positions: vec![[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5], [0.5, -0.5, 0.5]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        Mesh { name: String::new(), primitives: vec![primitive] }
    }

    /// root → a at x = 0, group → (b at x = 4, c at x = 8).
    fn scene() -> Scene {
        let at = |x: f64| DMat4::from_translation(DVec3::X * x);
        let node = |name: &str, parent, children, mesh, x| Node {
            name: name.to_owned(),
            parent,
            children,
            parent_from_node: at(x),
            mesh,
        };
        Scene {
            nodes: vec![
                node("root", None, vec![1, 2], None, 0.0),
                node("a", Some(0), vec![], Some(0), 0.0),
                node("group", Some(0), vec![3, 4], None, 6.0),
                node("b", Some(2), vec![], Some(0), -2.0),
                node("c", Some(2), vec![], Some(0), 2.0),
            ],
            meshes: vec![mesh()],
            materials: vec![Material::default()],
            ..Scene::default()
        }
        .finish()
        .unwrap()
    }

    #[test]
    fn nested_levels_add_up() {
        // The scene reaches from −0.5 to 8.5, its middle is 4. The group reaches from 3.5 to 8.5, its middle is 6.
        // a: 0 − 4 = −4. Group: 6 − 4 = 2. b: 2 + (4 − 6) = 0. c: 2 + (8 − 6) = 4.
        let arrangement = Arrangement { explode: 1.0, ..Arrangement::default() };
        let x = |a: &Arrangement| a.offsets(&scene()).iter().map(|o| (o.x, o.y, o.z)).collect::<Vec<_>>();
        assert_eq!(x(&arrangement), [(-4.0, 0.0, 0.0), (0.0, 0.0, 0.0), (4.0, 0.0, 0.0)]);
        let half = Arrangement { explode: 0.5, ..Arrangement::default() };
        assert_eq!(x(&half), [(-2.0, 0.0, 0.0), (0.0, 0.0, 0.0), (2.0, 0.0, 0.0)]);
        assert_eq!(x(&Arrangement::default()), [(0.0, 0.0, 0.0); 3]);
        let placed = arrangement.placed(&scene());
        assert_eq!(placed.parts[2].bounds.min.x, 11.5);
        assert_eq!(placed.parts[2].world_from_part.w_axis.x, 12.0);
        assert_eq!(arrangement.stats(&scene()).bounds.size().x, 17.0);
    }

    #[test]
    fn hiding_moves_nothing_and_leaves_no_extent() {
        let mut arrangement = Arrangement { explode: 1.0, ..Arrangement::default() };
        let before = arrangement.offsets(&scene());
        arrangement.parts.insert(2, PartLook { presence: Presence::Hidden, ..PartLook::default() });
        assert_eq!(arrangement.offsets(&scene()), before);
        assert!(arrangement.placed(&scene()).parts[2].bounds.is_empty());
        // From −4.5 to 4.5: what is left.
        assert_eq!(arrangement.stats(&scene()).bounds.size().x, 9.0);
        assert_eq!(arrangement.framed_bounds(&scene()).size().x, 17.0);
    }

    #[test]
    fn isolating_ghosts_the_rest() {
        let mut arrangement = Arrangement::default();
        arrangement.parts.insert(0, PartLook { color: Some([1.0, 0.0, 0.0]), ..PartLook::default() });
        arrangement.isolate(&BTreeSet::from([1]), 3);
        let presences: Vec<_> = (0..3).map(|p| arrangement.look(p).presence).collect();
        assert_eq!(presences, [Presence::Ghosted, Presence::Shown, Presence::Ghosted]);
        assert_eq!(arrangement.look(0).color, Some([1.0, 0.0, 0.0]));
        assert!(!arrangement.parts.contains_key(&1), "what looks as always has no entry");
        let stats = arrangement.stats(&scene());
        assert_eq!((stats.faded_parts, stats.recolored_parts, stats.selected_parts), (2, 1, 0));
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let scene = scene();
        let fails = |a: Arrangement, word: &str| {
            let e = a.check(&scene).unwrap_err().to_string();
            assert!(e.contains(word), "{e}");
        };
        assert_eq!(Arrangement::default().check(&scene), Ok(()));
        fails(Arrangement { selected: BTreeSet::from([3]), ..Arrangement::default() }, "part 3 does not exist");
        fails(Arrangement { explode: f64::NAN, ..Arrangement::default() }, "explode");
        fails(Arrangement { explode: 5.0, ..Arrangement::default() }, "0 to 4");
        let look = |look: PartLook| Arrangement { parts: BTreeMap::from([(1, look)]), ..Arrangement::default() };
        fails(look(PartLook { opacity: -0.1, ..PartLook::default() }), "opacity");
        fails(look(PartLook { color: Some([0.0, 2.0, 0.0]), ..PartLook::default() }), "colour");
        let section = Section { normal: DVec3::X, offset: 0.0, enabled: true, caps: false };
        fails(Arrangement { sections: vec![section; 7], ..Arrangement::default() }, "7 section planes");
        let long = Section { normal: DVec3::ONE, ..section };
        fails(Arrangement { sections: vec![long], ..Arrangement::default() }, "normal");
    }
}
