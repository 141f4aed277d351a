//! Bolts, screws, nuts and washers. All stand on z = 0 with the underside of the head (or the lower face) and point
//! their shank towards −z.

use std::f64::consts::TAU;

use glam::DVec2;

use super::{Chamfer, Path, Shell, Step, Tolerance, Vertex, extrude, face, revolve, thread::thread, wall};

/// Chords on each side of a chamfered hexagon: the chamfer's edge on it is a hyperbola.
const HEX_CHORDS: usize = 4;

/// A hexagon of the given width across flats, with every side divided into `chords`.
fn hexagon(across_flats: f64, chords: usize) -> Path {
    let corner = across_flats / 3.0_f64.sqrt();
    let at = |i: usize| DVec2::from_angle(TAU * i as f64 / 6.0) * corner;
    let side_normal = |i: usize| DVec2::from_angle(TAU * (i as f64 + 0.5) / 6.0);
    Path::from_knots((0..6).flat_map(|i| {
        (0..chords).map(move |k| {
            let before = if k == 0 { side_normal(i + 5) } else { side_normal(i) };
            (at(i).lerp(at(i + 1), k as f64 / chords as f64), before, side_normal(i))
        })
    }))
}

/// The hexagonal sides between two heights with a 30° chamfer above and, if asked, below; gives the flat circles left.
fn hex_sides(shell: &mut Shell, across_flats: f64, z0: f64, z1: f64, both: bool) -> [Vec<DVec2>; 2] {
    let hexagon = hexagon(across_flats, HEX_CHORDS);
    let circle = across_flats * 0.475;
    let slope = 30.0_f64.to_radians().tan();
    let drop = |p: DVec2| ((p.length() - circle) * slope).max(0.0);
    let low = |p: DVec2| z0 + if both { drop(p) } else { 0.0 };
    let high = |p: DVec2| z1 - drop(p);
    for (a, b) in hexagon.pieces() {
        let v = |p: DVec2, z: f64, n: DVec2| Vertex::new(p.extend(z), n.extend(0.0));
        shell.quad(
            v(a.point, low(a.point), a.normal_out),
            v(b.point, low(b.point), b.normal_in),
            v(b.point, high(b.point), b.normal_in),
            v(a.point, high(a.point), a.normal_out),
        );
        for (top, make) in [(true, true), (false, both)] {
            if !make {
                continue;
            }
            let (z, height) =
                if top { (z1, &high as &dyn Fn(DVec2) -> f64) } else { (z0, &low as &dyn Fn(DVec2) -> f64) };
            let cone = |p: DVec2, at: DVec2, z: f64| {
                Vertex::new(at.extend(z), (p.normalize() * slope).extend(if top { 1.0 } else { -1.0 }))
            };
            let (ca, cb) = (a.point.normalize() * circle, b.point.normalize() * circle);
            shell.quad(
                cone(a.point, a.point, height(a.point)),
                cone(b.point, b.point, height(b.point)),
                cone(b.point, cb, z),
                cone(a.point, ca, z),
            );
        }
    }
    let round: Vec<DVec2> = hexagon.knots.iter().map(|k| k.point.normalize() * circle).collect();
    [if both { round.clone() } else { hexagon.points() }, round]
}

fn circle(radius: f64, tolerance: Tolerance) -> Path {
    Path::circle(DVec2::ZERO, radius, tolerance.circle(radius))
}

/// Shank of `diameter` from z = 0 down to −`length`, threaded over the last `threaded`; the top is open, a circle of
/// the shank's radius.
fn shank(shell: &mut Shell, diameter: f64, pitch: f64, length: f64, threaded: f64, tolerance: Tolerance) {
    let (major, minor) = (diameter / 2.0, diameter / 2.0 - 0.6134 * pitch);
    let chords = tolerance.circle(major);
    let tip = 0.6 * pitch;
    let plain = -(length - threaded);
    let run_out = plain - 0.5 * pitch;
    // Upper plain part and the cone down to the thread's root; the open side is the thread's.
    let angles: Vec<f64> = (0..chords).map(|i| TAU * i as f64 / chords as f64).collect();
    let profile = Path::closed(
        &[
            Step::To(0.0, -length),
            Step::To(minor - tip, -length),
            Step::To(minor, -length + tip),
            Step::Open(minor, run_out),
            Step::To(major, plain),
            Step::To(major, 0.0),
            Step::Open(0.0, 0.0),
        ],
        tolerance,
    );
    shell.add(&super::revolve_with(&profile, &angles), glam::DMat4::IDENTITY);
    thread(shell, minor, major, pitch, -length + tip, run_out, chords);
}

/// A hexagon bolt: metric proportions for `diameter` (head height 0.65 d, 1.6 d across flats).
pub fn hex_bolt(diameter: f64, pitch: f64, length: f64, threaded: f64, tolerance: Tolerance) -> Shell {
    let mut shell = Shell::new();
    let [under, top] = hex_sides(&mut shell, 1.6 * diameter, 0.0, 0.65 * diameter, false);
    face(&mut shell, 0.65 * diameter, &[top], true);
    face(&mut shell, 0.0, &[under, circle(diameter / 2.0, tolerance).points()], false);
    shank(&mut shell, diameter, pitch, length, threaded, tolerance);
    shell
}

/// A hexagon nut from z = 0 up, with a plain bore a little wider than the thread and countersunk rims.
pub fn hex_nut(diameter: f64, tolerance: Tolerance) -> Shell {
    let height = 0.8 * diameter;
    let mut shell = Shell::new();
    let [low, high] = hex_sides(&mut shell, 1.6 * diameter, 0.0, height, true);
    let bore = circle(diameter * 0.505, tolerance);
    let rim = 0.05 * diameter;
    wall(&mut shell, &bore, rim, height - rim, false);
    super::bevel(&mut shell, &bore, rim, 0.0, rim, false);
    super::bevel(&mut shell, &bore, height - rim, height, rim, false);
    let wide = bore.offset(rim).points();
    face(&mut shell, 0.0, &[low, wide.clone()], false);
    face(&mut shell, height, &[high, wide], true);
    shell
}

/// A cap screw with a hexagon socket: head 1.5 d wide, d high.
pub fn socket_screw(diameter: f64, pitch: f64, length: f64, tolerance: Tolerance) -> Shell {
    let mut shell = Shell::new();
    let (radius, height, rim) = (0.75 * diameter, diameter, 0.08 * diameter);
    let outer = circle(radius, tolerance);
    wall(&mut shell, &outer, 0.0, height - rim, true);
    super::bevel(&mut shell, &outer, height - rim, height, rim, true);
    let socket = hexagon(0.8 * diameter, 1);
    wall(&mut shell, &socket, 0.45 * height, height, false);
    face(&mut shell, 0.45 * height, &[socket.points()], true);
    face(&mut shell, height, &[outer.offset(-rim).points(), socket.points()], true);
    face(&mut shell, 0.0, &[outer.points(), circle(diameter / 2.0, tolerance).points()], false);
    shank(&mut shell, diameter, pitch, length, (length * 0.7).min(2.2 * diameter), tolerance);
    shell
}

/// A plain washer for `diameter`, from z = 0 up.
pub fn washer(diameter: f64, tolerance: Tolerance) -> Shell {
    let (hole, rim) = (diameter * 0.53, diameter * 1.0);
    let t = 0.18 * diameter;
    let cut = Chamfer::Cut(0.2 * t);
    extrude(&circle(rim, tolerance), &[circle(hole, tolerance)], 0.0, t, [cut, cut], [Chamfer::None; 2])
}

/// A solid or hollow turned part: `revolve` of a closed profile given by its corners.
pub fn turned(steps: &[Step], tolerance: Tolerance) -> Shell {
    revolve(&Path::closed(steps, tolerance), tolerance)
}

#[cfg(test)]
mod tests {
    use super::super::shell::{faults, volume};
    use super::*;

    #[test]
    fn fasteners_are_closed() {
        let tolerance = Tolerance(0.02);
        let shells = [
            ("bolt", hex_bolt(8.0, 1.25, 30.0, 20.0, tolerance)),
            ("nut", hex_nut(8.0, tolerance)),
            ("screw", socket_screw(5.0, 0.8, 14.0, tolerance)),
            ("washer", washer(8.0, tolerance)),
        ];
        for (name, shell) in shells {
            let primitive = shell.primitive(0);
            assert!(faults(&primitive).is_empty(), "{name}: {:?}", faults(&primitive));
            assert!(volume(&primitive) > 0.0, "{name} is inside out");
        }
    }
}
