//! A two-spool turbofan, nested as real ones are: nacelle around fan case around core cowl around casings around drums
//! around shafts.
//!
//! Lengths are millimetres; the root node scales to metres and turns the axis (z, front to back) to +x, so that a view
//! along −z shows the engine from its side with the intake on the left. Every blade is a part; the blades of a row share
//! a mesh.

mod core;
mod rows;
mod statics;

use glam::{DMat4, DVec2, DVec3};

use super::assembly::Assembly;
use super::kit::{Path, Shell, Step, Tolerance, revolve};
use crate::scene::Scene;

/// Chord tolerance of casings and discs, mm.
const COARSE: Tolerance = Tolerance(0.5);

/// Chord tolerance of bearings and fuel nozzles, mm.
const SMALL: Tolerance = Tolerance(0.15);

/// Chord tolerance of bolts, of which there are hundreds, mm.
const BOLT: Tolerance = Tolerance(0.25);

/// Materials by what they are for.
struct Materials {
    nacelle: usize,
    cowl: usize,
    casing: usize,
    fan: usize,
    compressor: usize,
    stator: usize,
    disc: usize,
    liner: usize,
    fuel: usize,
    turbine: usize,
    vane: usize,
    exhaust: usize,
    lp_shaft: usize,
    hp_shaft: usize,
    bearing: usize,
    cage: usize,
    bolt: usize,
}

pub(super) fn scene() -> Scene {
    let mut a = Assembly::new("engine");
    let m = Materials {
        nacelle: a.material("nacelle composite", 0xC4CCD4, 0.0, 0.45),
        cowl: a.material("core cowl", 0xA4B4C2, 0.1, 0.5),
        casing: a.material("casing alloy", 0x9CA6A8, 0.6, 0.45),
        fan: a.material("fan titanium", 0x9AA8B8, 0.8, 0.3),
        compressor: a.material("compressor blades", 0xA8C0CC, 0.75, 0.32),
        stator: a.material("compressor vanes", 0x8CA898, 0.6, 0.4),
        disc: a.material("discs", 0x8E94A0, 0.8, 0.38),
        liner: a.material("combustor liner", 0xC49A6A, 0.6, 0.45),
        fuel: a.material("fuel system", 0xB8A85A, 0.6, 0.4),
        turbine: a.material("turbine blades", 0xB88468, 0.75, 0.35),
        vane: a.material("turbine vanes", 0xA8907C, 0.65, 0.42),
        exhaust: a.material("exhaust", 0xA09088, 0.6, 0.5),
        lp_shaft: a.material("low-pressure shaft", 0x7C90AC, 0.8, 0.35),
        hp_shaft: a.material("high-pressure shaft", 0xA87C88, 0.8, 0.35),
        bearing: a.material("bearing steel", 0xD4D8DC, 0.9, 0.22),
        cage: a.material("cage bronze", 0xC8A45C, 0.7, 0.4),
        bolt: a.material("bolts", 0xA6A8B0, 0.85, 0.35),
    };
    let place = DMat4::from_scale(DVec3::splat(0.001)) * DMat4::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let root = a.group(None, "Turbofan", place);
    statics::add(&mut a, root, &m);
    core::add(&mut a, root, &m);
    rows::add(&mut a, root, &m);
    a.into_scene()
}

/// A smooth curve through (z, r) points, as (r, z) points with tangents: cubics with the slopes of a Catmull–Rom spline
/// over chord length, which does not overshoot where points lie unevenly. More points where it turns more.
fn smooth(points: &[(f64, f64)]) -> Vec<(DVec2, DVec2)> {
    const TURN: f64 = 0.075;
    let p: Vec<DVec2> = points.iter().map(|&(z, r)| DVec2::new(r, z)).collect();
    let n = p.len();
    let chord = |i: usize| p[i + 1] - p[i];
    let slope = |i: usize| match i {
        0 => chord(0).normalize(),
        i if i + 1 == n => chord(i - 1).normalize(),
        i => {
            let (a, b) = (chord(i - 1), chord(i));
            (a.normalize() * b.length() + b.normalize() * a.length()) / (a.length() + b.length())
        }
    };
    let mut curve = Vec::new();
    for i in 0..n - 1 {
        let length = chord(i).length();
        let (a, b, ta, tb) = (p[i], p[i + 1], slope(i) * length, slope(i + 1) * length);
        let turned = ta.angle_to(chord(i)).abs() + chord(i).angle_to(tb).abs();
        let steps = ((turned / TURN).ceil() as usize).clamp(1, 10);
        // The end of a span is the start of the next.
        for k in 0..steps + usize::from(i + 2 == n) {
            let t = k as f64 / steps as f64;
            let (t2, t3) = (t * t, t * t * t);
            let at =
                a * (2.0 * t3 - 3.0 * t2 + 1.0) + ta * (t3 - 2.0 * t2 + t) + b * (3.0 * t2 - 2.0 * t3) + tb * (t3 - t2);
            let along = (a - b) * (6.0 * (t2 - t)) + ta * (3.0 * t2 - 4.0 * t + 1.0) + tb * (3.0 * t2 - 2.0 * t);
            curve.push((at, along.normalize()));
        }
    }
    curve
}

/// A sheet of this thickness under the smooth curve through (z, r) points that run from front to back.
fn sheet(points: &[(f64, f64)], thickness: f64) -> Shell {
    let outer = smooth(points);
    let inner = outer.iter().rev().map(|&(p, t)| (p - DVec2::new(t.y, -t.x) * thickness, -t)).collect();
    revolve(&Path::closed(&[Step::Curve(outer), Step::Curve(inner)], COARSE), COARSE)
}

/// A conical or cylindrical tube with a bolting flange at each end: inner radii at both ends, thickness, flange height.
fn flanged(z: (f64, f64), r: (f64, f64), thickness: f64, flange: f64) -> Shell {
    let w = 10.0;
    let outer = (r.0 + thickness, r.1 + thickness);
    let steps = [
        Step::To(r.0, z.0),
        Step::Cut(outer.0 + flange, z.0, 1.5),
        Step::Cut(outer.0 + flange, z.0 + w, 1.5),
        Step::Round(outer.0, z.0 + w, 4.0),
        Step::Round(outer.1, z.1 - w, 4.0),
        Step::Cut(outer.1 + flange, z.1 - w, 1.5),
        Step::Cut(outer.1 + flange, z.1, 1.5),
        Step::To(r.1, z.1),
    ];
    revolve(&Path::closed(&steps, COARSE), COARSE)
}

/// A plain tube with chamfered ends.
fn tube(z: (f64, f64), inner: f64, outer: f64) -> Shell {
    let cut = 0.2 * (outer - inner);
    let steps = [(inner, z.0), (outer, z.0), (outer, z.1), (inner, z.1)].map(|(r, z)| Step::Cut(r, z, cut));
    revolve(&Path::closed(&steps, COARSE), COARSE)
}

/// A disc with a heavy bore, a thin web and a rim: middle z, radii of bore and rim, widths of bore, web and rim.
fn disc(z: f64, bore: f64, rim: f64, widths: (f64, f64, f64)) -> Shell {
    let (hub, web, edge) = (widths.0 / 2.0, widths.1 / 2.0, widths.2 / 2.0);
    let (inner, outer) = (bore + 0.22 * (rim - bore), rim - 0.14 * (rim - bore));
    let half = |side: f64| {
        [
            Step::Round(bore, z + side * hub, 3.0),
            Step::Round(inner, z + side * hub, 4.0),
            Step::Round(inner + 10.0, z + side * web, 6.0),
            Step::Round(outer - 6.0, z + side * web, 6.0),
            Step::Round(outer, z + side * edge, 3.0),
            Step::Cut(rim, z + side * edge, 1.0),
        ]
    };
    let mut steps = half(-1.0).to_vec();
    steps.extend(half(1.0).into_iter().rev());
    revolve(&Path::closed(&steps, COARSE), COARSE)
}

#[cfg(test)]
mod tests {
    use super::super::{
        build,
        kit::shell::{faults, volume},
        probe::Rays,
    };
    use glam::DVec3;

    #[test]
    fn every_mesh_is_a_closed_solid() {
        let scene = build("engine").unwrap();
        let mut found = Vec::new();
        for mesh in &scene.meshes {
            let primitive = &mesh.primitives[0];
            found.extend(faults(primitive).into_iter().map(|f| format!("{}: {f}", mesh.name)));
            if volume(primitive) <= 0.0 {
                found.push(format!("{} is inside out", mesh.name));
            }
        }
        assert_eq!(found, Vec::<String>::new());
    }

    #[test]
    fn it_is_nested_thirty_shells_deep_seen_from_the_side() {
        let scene = build("engine").unwrap();
        let triangles = scene.triangle_count();
        assert!((150_000..900_000).contains(&triangles), "{triangles} triangles");
        // A shell here is a part that goes around the axis.
        let size = scene.bounds().size();
        let around = |p: &&crate::scene::Part| {
            let b = p.bounds;
            b.min.y < 0.0 && b.max.y > 0.0 && b.min.z < 0.0 && b.max.z > 0.0
        };
        let shells = scene.parts.iter().filter(around).count();
        assert!(shells >= 30, "{shells} shells around the axis");
        assert!(size.x > 2.0 && size.y > 1.5, "metres: {size}");
        let sphere = scene.bounds().bounding_sphere();
        let depths = Rays::new(&scene).depth_map(sphere.center, sphere.radius, DVec3::NEG_Z, 80);
        assert!(depths.iter().all(|d| d % 2 == 0), "closed solids are entered as often as they are left");
        let deepest = depths.iter().copied().max().unwrap_or(0);
        println!("engine: largest depth complexity {deepest}, {shells} shells");
        assert!(deepest >= 30, "{deepest} layers");
    }
}
