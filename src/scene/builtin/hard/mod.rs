//! Scenes of the hard cases, `builtin:hard/NAME`: each makes one trap of the papers happen in nearly every pixel.
//!
//! Which picture of them is drawn, what is measured and what it must not exceed is said by the cases, which stand beside
//! the techniques ([`crate::scene::hard_case`]).

pub mod bent;
pub mod deep;
mod shared;

use super::parameters::Parameters;
use super::samples::parts;
use super::{Builtin, BuiltinError};
use crate::scene::Scene;

/// In front of the names of these scenes.
pub const PREFIX: &str = "hard/";

type Make = fn(&mut Parameters) -> Result<Scene, BuiltinError>;

/// A scene: how it is offered, and what makes it.
struct Hard {
    offered: Builtin,
    make: Make,
}

const fn hard(name: &'static str, description: &'static str, make: Make) -> Hard {
    Hard { offered: Builtin { name, description }, make }
}

const SCENES: &[Hard] = &[
    hard("hard/equal-keys", "faces of one part in one place (layers=2, colors=0) (T1)", deep::equal_keys),
    hard("hard/close-sheets", "tilted sheets, gap times the depth range apart (gap=1e-5) (T2)", deep::close_sheets),
    hard("hard/far-sheets", "sheets 1 apart, 900 away, between 0.5 and 1000 (T2)", deep::far_sheets),
    hard("hard/many-parts", "loose triangles, each a part of its own (parts=70000) (T4)", deep::many_parts),
    hard(
        "hard/stack",
        "squares behind each other, parts in turn (layers=20, gap=0.1, parts=4, alike=0) (T5)",
        deep::stack,
    ),
    hard("hard/contact", "two slanted sheets in one place, of other triangles each (T19)", deep::contact),
    hard(
        "hard/full-buckets",
        "eight parts whose bucket has one home, and a ninth beside them (T6)",
        deep::full_buckets,
    ),
    hard("hard/faint", "32 unlit squares behind each other (T26)", deep::faint),
    hard("hard/dark", "squares of dark colours (T26)", deep::dark),
    hard("hard/gaps", "ten shells 2 mm apart in a scene of a kilometre (T30)", deep::gaps),
    hard(
        "hard/soup",
        "triangles through each other (seed=71, parts=3, triangles=30, size=1, far=0) (T7, T10)",
        shared::soup,
    ),
    hard(
        "hard/assembly",
        "a bit of everything (seed=1, size=1, offset=0, baked=0): scaled, far from the origin, as vertices (T27 to T29)",
        shared::assembly,
    ),
    hard("hard/floor", "one triangle from far behind the eye to far ahead, and a ball (T29)", shared::floor),
    hard(
        "hard/tiles",
        "columns × columns random scenes of up to 12 triangles side by side (seed=1, columns=16)",
        shared::tiles,
    ),
    hard("hard/broken", "a sphere with broken normals, and triangles of no surface (T29)", bent::broken),
    hard("hard/ball", "a sphere with exact normals (radius=1, columns=160) (T8, T10)", bent::ball),
    hard("hard/normals", "squares that each have one normal, half of them grazing (T9)", bent::normals),
    hard(
        "hard/saddle",
        "a saddle of loose triangles; turned=1 winds and flips them at random (turned=0) (T11)",
        bent::saddle,
    ),
    hard("hard/facets", "open cylinder of unequal facets, banded normals (facets=24) (T31)", bent::facets),
    hard(
        "hard/flat-facets",
        "open cylinder of flat facets, each with its own normal (facets=48) (T31)",
        bent::flat_facets,
    ),
];

/// All of them, as offered.
pub fn names() -> impl Iterator<Item = Builtin> {
    SCENES.iter().map(|s| s.offered)
}

/// Makes one, not yet finished.
///
/// # Errors
/// [`BuiltinError`] if a parameter is unknown or out of range. `None` if there is no scene of the name.
pub(super) fn make(p: &mut Parameters) -> Option<Result<Scene, BuiltinError>> {
    let scene = SCENES.iter().find(|s| s.offered.name == p.scene())?;
    Some((scene.make)(p).map(|made| Scene { name: scene.offered.name.to_owned(), ..made }))
}
