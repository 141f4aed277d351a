//! A small surface-modelling kit: enough to build engineered parts from profiles, with **analytic** positions and
//! normals, so that what the renderer shows of curvature is the surface's and not the tessellation's.
//!
//! Everything works around the z axis of the part's own space. A [`Path`] is a plane curve with a normal on both sides
//! of every knot; it is revolved ([`revolve`]), extruded ([`wall`], [`bevel`]) and closed by planar faces ([`face`]).
//! Gears, threads, lofts and perforated tubes are built on the same [`Shell`].
//!
//! * **Sharp edges are split vertices.** A corner with two normals gives two vertices; equal pairs are welded.
//! * **Watertight by position.** Positions are rounded to a grid of a power of two, so that two faces that compute the
//!   same edge in different ways still meet exactly, and so that the last bit of a platform's `sin` does not show.
//! * **Winding follows the normals.** [`Shell::triangle`] orders its corners by the normals it is given.
//! * **Chord tolerance.** [`Tolerance`] says how far a chord may leave its arc; small radii get finer angles and large
//!   flats get the few triangles that their outline needs.

mod extrude;
mod fasteners;
mod gear;
mod loft;
mod path;
mod perforated;
mod planar;
mod revolve;
pub mod shell;
mod solids;
mod thread;

pub use extrude::{Chamfer, bevel, extrude, face, prism, wall};
pub use fasteners::{hex_bolt, hex_nut, socket_screw, turned, washer};
pub use gear::{external_gear, internal_gear, ribbed, spline};
pub use loft::{BladeSection, blade, three};
pub use path::{Path, Step};
pub use perforated::{Perforation, perforated_tube};
pub use revolve::{revolve, revolve_with};
pub use shell::{Shell, Vertex};
pub use solids::{ball, ball_divided, torus_tube};
pub use thread::thread;

/// Largest distance between a chord and its arc, in the part's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance(pub f64);

impl Tolerance {
    /// How many chords an arc of `radius` and `sweep` radians needs; at least one for every 45°.
    pub fn arc(self, radius: f64, sweep: f64) -> usize {
        let ratio = (1.0 - self.0 / radius.abs().max(self.0)).clamp(-1.0, 1.0);
        let step = (2.0 * ratio.acos()).min(std::f64::consts::FRAC_PI_4);
        ((sweep.abs() / step - 1e-9).ceil() as usize).max(1)
    }

    /// How many chords a full circle of `radius` gets: one of a short list of numbers that divide by 8, so that
    /// neighbouring rings of nearly equal radius agree.
    pub fn circle(self, radius: f64) -> usize {
        const STEPS: [usize; 14] = [16, 24, 32, 40, 48, 64, 80, 96, 128, 160, 192, 256, 320, 384];
        let needed = self.arc(radius, std::f64::consts::TAU);
        STEPS.into_iter().find(|&n| n >= needed).unwrap_or(512)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_stay_within_the_tolerance() {
        for (tolerance, radius) in [(0.02, 80.0), (0.02, 4.0), (0.5, 900.0), (0.1, 0.05)] {
            let n = Tolerance(tolerance).circle(radius);
            let sagitta = radius * (1.0 - (std::f64::consts::PI / n as f64).cos());
            assert!(sagitta <= tolerance * 1.000_001, "{n} chords at radius {radius} leave {sagitta}");
        }
    }
}
