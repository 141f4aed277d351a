//! Section planes on the command line.
//!
//! `AXIS=POSITION` is a plane across an axis: `x=0.5` cuts away what lies beyond x = 0.5, `-x=0.5` what lies before it.
//! `NX,NY,NZ,POSITION` is any plane: what has normal · x above the position is cut away, the normal taken as a direction.
//! Positions are in the file's coordinates, or, with a percent sign, in percent of the model's box along the normal (for an
//! axis along the axis, whatever its sign). A normal that has length 1 already is taken as it is, bit for bit. Behind a plane
//! may stand `:open`, for no caps, and `:off`, for one that does not cut.

use clap::Args;
use glam::DVec3;

use super::failure::{Exit, Failure};
use crate::math::Bounds;
use crate::scene::{Arrangement, Scene, Section};

/// Options for section planes.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Sections")]
pub struct SectionArgs {
    /// Cut away what lies beyond a plane: x=0.5, -x=0.5 for the other side, y=50% of the model's box, or NX,NY,NZ,POSITION,
    /// with :open behind it for a cut without caps; up to six, in place of those of a session
    #[arg(long, value_name = "PLANE", value_parser = plane, allow_hyphen_values = true)]
    pub section: Vec<Plane>,
    /// Leave cuts open
    #[arg(long)]
    pub no_caps: bool,
}

/// A plane as it is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit vector towards what is cut away.
    normal: DVec3,
    /// Direction along which the position counts: the normal, or the axis that it lies on.
    along: DVec3,
    /// Position along it.
    position: Position,
    /// Whether it cuts.
    enabled: bool,
    /// Whether the cut is closed.
    caps: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Position {
    /// In the file's coordinates.
    At(f64),
    /// A share of the model's box.
    Share(f64),
}

fn position(text: &str) -> Option<Position> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match text.strip_suffix('%') {
        Some(percent) => Some(Position::Share(number(percent)? / 100.0)),
        None => Some(Position::At(number(text)?)),
    }
}

fn plane(text: &str) -> Result<Plane, String> {
    let mut words = text.split(':');
    let place = words.next().unwrap_or_default();
    let (mut enabled, mut caps) = (true, true);
    let mut known = true;
    for word in words {
        match word {
            "open" => caps = false,
            "off" => enabled = false,
            _ => known = false,
        }
    }
    let made = |normal, along, position| Plane { normal, along, position, enabled, caps };
    let across_axis = |(axis, at): (&str, &str)| {
        let (axis, sign) = match axis.trim().strip_prefix('-') {
            Some(axis) => (axis, -1.0),
            None => (axis.trim().strip_prefix('+').unwrap_or(axis.trim()), 1.0),
        };
        let along = match axis {
            "x" | "X" => DVec3::X,
            "y" | "Y" => DVec3::Y,
            "z" | "Z" => DVec3::Z,
            _ => return None,
        };
        Some(made(along * sign, along, position(at)?))
    };
    let any = || {
        let fields: Vec<&str> = place.split(',').collect();
        let [x, y, z, at] = fields[..] else { return None };
        let number = |t: &str| t.trim().parse::<f64>().ok();
        let direction = DVec3::new(number(x)?, number(y)?, number(z)?);
        let is_unit = (direction.length() - 1.0).abs() < 1e-12;
        let normal = if is_unit { direction } else { direction.try_normalize()? };
        Some(made(normal, normal, position(at)?))
    };
    let found = match place.split_once('=').filter(|_| known) {
        Some(parts) => across_axis(parts),
        None if known => any(),
        None => None,
    };
    found.ok_or_else(|| "expected a plane as in x=0.5, -y=12, z=50% or NX,NY,NZ,POSITION, and :open or :off".to_owned())
}

impl Plane {
    /// The section of a model in a box, in the file's coordinates.
    fn section(&self, bounds: &Bounds) -> Section {
        let at = match self.position {
            Position::At(at) => at,
            Position::Share(share) if !bounds.is_empty() => {
                let heights = bounds.corners().map(|c| self.along.dot(c));
                let low = heights.into_iter().fold(f64::INFINITY, f64::min);
                let high = heights.into_iter().fold(f64::NEG_INFINITY, f64::max);
                low + share * (high - low)
            }
            Position::Share(_) => 0.0,
        };
        // Along the normal itself there is nothing to turn round, and no rounding.
        let turned = if self.along == self.normal { 1.0 } else { self.along.dot(self.normal) };
        Section { normal: self.normal, offset: at * turned, enabled: self.enabled, caps: self.caps }
    }
}

impl SectionArgs {
    /// Changes an arrangement as the options say.
    ///
    /// # Errors
    /// [`Exit::Usage`] for more planes than can cut.
    pub fn apply(&self, arrangement: &mut Arrangement, scene: &Scene) -> Result<(), Failure> {
        if !self.section.is_empty() {
            let framed = arrangement.framed_bounds(scene);
            let bounds = if framed.is_empty() {
                framed
            } else {
                Bounds { min: framed.min + scene.origin, max: framed.max + scene.origin }
            };
            arrangement.sections = self.section.iter().map(|p| p.section(&bounds)).collect();
        }
        if self.no_caps {
            arrangement.sections.iter_mut().for_each(|s| s.caps = false);
        }
        arrangement.check_values().map_err(|e| Failure::of(Exit::Usage, &e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(text: &str) -> Section {
        let bounds = Bounds { min: DVec3::new(-1.0, 0.0, 10.0), max: DVec3::new(1.0, 4.0, 20.0) };
        plane(text).unwrap_or_else(|e| panic!("{text}: {e}")).section(&bounds)
    }

    #[test]
    fn planes_are_read_as_they_are_meant() {
        for (text, normal, offset) in [
            ("x=0.5", DVec3::X, 0.5),
            ("-y=12", DVec3::NEG_Y, -12.0),
            ("Z=-1e-3", DVec3::Z, -1e-3),
            ("+z=50%", DVec3::Z, 15.0),
            // The lower quarter goes: the plane is where y is 1.
            ("-y=25%", DVec3::NEG_Y, -1.0),
            ("0,2,0,3", DVec3::Y, 3.0),
            ("0,-1,0,0%", DVec3::NEG_Y, -4.0),
            ("-1,0,0,-7", DVec3::NEG_X, -7.0),
        ] {
            assert_eq!(section(text), Section { normal, offset, enabled: true, caps: true }, "{text}");
        }
        let plain = section("x=0.5");
        assert_eq!(section("x=0.5:open"), Section { caps: false, ..plain });
        assert_eq!(section("1,0,0,0.5:off"), Section { enabled: false, ..plain });
        assert_eq!(section("x=0.5:off:open"), Section { enabled: false, caps: false, ..plain });
        let slanted = section("3,4,0,1");
        assert!((slanted.normal - DVec3::new(0.6, 0.8, 0.0)).length() < 1e-15);
        for wrong in [
            "",
            "x",
            "x=",
            "w=1",
            "x=NaN",
            "x=inf",
            "1,2,3",
            "0,0,0,1",
            "1,2,3,4,5",
            "x=5%%",
            "--x=1",
            "a,b,c,1",
            "x=1:",
            "x=1:shut",
        ] {
            assert!(plane(wrong).is_err(), "{wrong}");
        }
    }
}
