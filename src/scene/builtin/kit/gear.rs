//! Involute spur gears and straight-sided splines as plane outlines.

use std::f64::consts::PI;

use glam::DVec2;

use super::{Path, Tolerance};

/// Pressure angle of every gear here: the standard 20°.
const PRESSURE: f64 = PI / 9.0;

/// Play on each flank, in modules.
const PLAY: f64 = 0.02;

/// Chords of an involute flank, of a root fillet, and of the tip and root lands.
const FLANK: usize = 7;
const FILLET: usize = 5;
const LAND: usize = 3;

/// A point with its (unsigned) tangent.
type Point = (DVec2, DVec2);

fn involute(angle: f64) -> f64 {
    angle.tan() - angle
}

/// Half the angle that a tooth of a gear with `teeth` teeth fills at `radius`; `play` is taken off at the pitch circle.
fn half_angle(module: f64, teeth: u32, radius: f64, play: f64) -> f64 {
    let pitch = module * f64::from(teeth) / 2.0;
    let base = pitch * PRESSURE.cos();
    let pressure = (base / radius).clamp(-1.0, 1.0).acos();
    PI / (2.0 * f64::from(teeth)) - play / pitch + involute(PRESSURE) - involute(pressure)
}

/// A point on the flank of the tooth around angle 0, on its side of positive angles.
fn flank(module: f64, teeth: u32, radius: f64, play: f64) -> Point {
    let at = |r: f64| DVec2::from_angle(half_angle(module, teeth, r, play)) * r;
    let base = module * f64::from(teeth) / 2.0 * PRESSURE.cos();
    // The involute's tangent: at pressure angle φ it leans by φ from the radius. Exact also at the base circle.
    let pressure = (base / radius).clamp(-1.0, 1.0).acos();
    let radial = DVec2::from_angle(half_angle(module, teeth, radius, play));
    (at(radius), DVec2::from_angle(-pressure).rotate(radial))
}

/// A circular-looking transition from `from` to a point of the circle around the origin: a parabola tangent to both.
/// It goes towards the angle `limit` and ends before it.
fn fillet(from: Point, circle: f64, limit: f64) -> Vec<Point> {
    let start = from.0;
    let reach = (start.length() - circle).abs() * 0.9;
    let room = limit - start.to_angle();
    let end_angle = start.to_angle() + room.signum() * (reach / circle).min(0.9 * room.abs());
    let end = DVec2::from_angle(end_angle) * circle;
    let along = end.perp();
    // Where the flank's tangent meets the circle's.
    let t = (end - start).perp_dot(along) / from.1.perp_dot(along);
    let control = start + from.1 * t;
    (0..=FILLET)
        .map(|k| {
            let u = k as f64 / FILLET as f64;
            let point = start * ((1.0 - u) * (1.0 - u)) + control * (2.0 * u * (1.0 - u)) + end * (u * u);
            (point, (control - start) * (1.0 - u) + (end - control) * u)
        })
        .collect()
}

/// Repeats a half tooth (from the middle of its tip to the middle of the gap, angles rising) around the circle.
/// `half` is a list of smooth pieces.
fn repeat(half: &[Vec<Point>], teeth: u32) -> Path {
    let mirror = |v: DVec2| DVec2::new(v.x, -v.y);
    let back: Vec<Vec<Point>> =
        half.iter().rev().map(|piece| piece.iter().rev().map(|p| (mirror(p.0), mirror(p.1))).collect()).collect();
    let mut knots: Vec<(DVec2, DVec2, DVec2)> = Vec::new();
    for tooth in 0..teeth {
        let turn = DVec2::from_angle(2.0 * PI * f64::from(tooth) / f64::from(teeth));
        for piece in back.iter().chain(half) {
            for pair in piece.windows(2) {
                let normal = |p: Point| {
                    let tangent = if p.1.dot(pair[1].0 - pair[0].0) < 0.0 { -p.1 } else { p.1 };
                    -turn.rotate(tangent).perp().normalize()
                };
                let (start, end) = (normal(pair[0]), normal(pair[1]));
                if let Some(last) = knots.last_mut() {
                    last.2 = start;
                }
                if knots.is_empty() {
                    knots.push((turn.rotate(pair[0].0), start, start));
                }
                knots.push((turn.rotate(pair[1].0), end, end));
            }
        }
    }
    // The last knot is the first again.
    if let (Some(last), true) = (knots.pop(), !knots.is_empty()) {
        knots[0].1 = last.1;
    }
    Path::from_knots(knots)
}

fn arc(radius: f64, from: f64, to: f64) -> Vec<Point> {
    arc_of(radius, from, to, LAND)
}

fn arc_of(radius: f64, from: f64, to: f64, chords: usize) -> Vec<Point> {
    (0..=chords)
        .map(|k| {
            let normal = DVec2::from_angle(from + (to - from) * k as f64 / chords as f64);
            (normal * radius, normal.perp())
        })
        .collect()
}

fn flanks(module: f64, teeth: u32, from: f64, to: f64, play: f64) -> Vec<Point> {
    (0..=FLANK).map(|k| flank(module, teeth, from + (to - from) * k as f64 / FLANK as f64, play)).collect()
}

/// Outline of an external involute gear: addendum 1 module, dedendum 1.25 modules, root fillets. A tooth lies at +x.
pub fn external_gear(module: f64, teeth: u32) -> Path {
    let pitch = module * f64::from(teeth) / 2.0;
    let (tip, root) = (pitch + module, pitch - 1.25 * module);
    let start = (pitch * PRESSURE.cos() * 1.0005).max(root + 0.4 * module);
    let play = PLAY * module;
    let side = flanks(module, teeth, tip, start, play);
    let foot = fillet(side[FLANK], root, PI / f64::from(teeth));
    let land = arc(root, foot[FILLET].0.to_angle(), PI / f64::from(teeth));
    let tip_land = arc(tip, 0.0, side[0].0.to_angle());
    repeat(&[tip_land, side, foot, land], teeth)
}

/// Outline of the opening of an internal involute gear, as seen from the opening: a **gap** lies at +x. Use it as a
/// hole.
pub fn internal_gear(module: f64, teeth: u32) -> Path {
    let pitch = module * f64::from(teeth) / 2.0;
    let (tip, root) = (pitch - module, pitch + 1.25 * module);
    let play = -PLAY * module;
    let side = flanks(module, teeth, root - 0.4 * module, tip, play);
    let mut foot = fillet(side[0], root, 0.0);
    foot.reverse();
    let root_land = arc(root, 0.0, foot[0].0.to_angle());
    let tip_land = arc(tip, side[FLANK].0.to_angle(), PI / f64::from(teeth));
    repeat(&[root_land, foot, side, tip_land], teeth)
}

/// Outline of a straight-sided spline shaft with `teeth` teeth between radii `root` and `tip`.
pub fn spline(teeth: u32, root: f64, tip: f64) -> Path {
    let pitch = PI / f64::from(teeth);
    let (top, foot) = (0.42 * pitch, 0.62 * pitch);
    let (a, b) = (DVec2::from_angle(top) * tip, DVec2::from_angle(foot) * root);
    repeat(&[arc(tip, 0.0, top), vec![(a, b - a), (b, b - a)], arc(root, foot, pitch)], teeth)
}

/// Outline of a round body of radius `radius` with `count` ribs of width `width` that reach to `tip`, filleted at their
/// roots. A rib lies at +x.
pub fn ribbed(count: u32, radius: f64, tip: f64, width: f64, tolerance: Tolerance) -> Path {
    let half = width / 2.0;
    let at = |r: f64| DVec2::new((r * r - half * half).max(0.0).sqrt(), half);
    let (top, start) = (at(tip), at(radius + width * 0.6));
    let line = top - start;
    let foot = fillet((start, line), radius, PI / f64::from(count));
    let (from, to) = (foot[FILLET].0.to_angle(), PI / f64::from(count));
    let land = arc_of(radius, from, to, tolerance.arc(radius, to - from));
    repeat(&[arc_of(tip, 0.0, top.to_angle(), 1), vec![(top, line), (start, line)], foot, land], count)
}

#[cfg(test)]
mod tests {
    use super::super::{
        Chamfer, Shell, face, prism,
        shell::{faults, volume},
    };
    use super::*;

    #[test]
    fn gears_are_closed_and_of_plausible_size() {
        for teeth in [18, 24] {
            let gear =
                prism(&external_gear(2.0, teeth), &[Path::circle(DVec2::ZERO, 9.0, 48)], -5.0, 5.0, Chamfer::None);
            let primitive = gear.primitive(0);
            assert!(faults(&primitive).is_empty(), "{:?}", faults(&primitive));
            let pitch = f64::from(teeth);
            let area = volume(&primitive) / 10.0;
            let disc = PI * (pitch * pitch - 81.0);
            assert!((area / disc - 1.0).abs() < 0.06, "{area} {disc}");
        }
    }

    #[test]
    fn teeth_at_the_pitch_circle_fill_half_of_it_less_the_play() {
        let half = half_angle(2.0, 24, 24.0, PLAY * 2.0);
        assert!(
            (half * 24.0 * 2.0 + 4.0 * PLAY - PI).abs() < 1e-9,
            "tooth thickness and play make half the circular pitch"
        );
    }

    #[test]
    fn normals_are_perpendicular_to_the_outline() {
        for path in [external_gear(2.0, 18), internal_gear(2.0, 60), spline(16, 18.0, 20.0)] {
            for (a, b) in path.pieces() {
                let along = (b.point - a.point).normalize();
                assert!(a.normal_out.dot(along).abs() < 0.45 && b.normal_in.dot(along).abs() < 0.45, "{a:?} {b:?}");
                assert!(along.perp_dot(a.normal_out) < 0.0, "normals lie to the right");
            }
            let mut shell = Shell::new();
            face(&mut shell, 0.0, &[path.points()], true);
            assert_eq!(shell.primitive(0).triangles.len(), path.knots.len() - 2);
        }
    }
}
