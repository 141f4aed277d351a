//! `builtin:flow`: a stream surface that rolls up, as the surfaces of Carnecky 2013 (Figures 9 to 13) do.
//!
//! The flow runs along x. Two vortices of unequal strength turn the same way, wind around each other as such vortices do, and
//! drag at what flows in their cores. A surface of streamlines begins on a line across both: it is drawn into two scrolls, one
//! wound tighter than the other, whose outer turns are slung around each other. The surface is open on all four sides and, as
//! the field is steady, never meets itself; from any side a sight line crosses it many times.
//!
//! Its parametrization is the natural one of an integral surface and lies in the first set of texture coordinates: u along the
//! line of seeds, v the time since, both from 0 to 1.
//!
//! # How it is made
//! Each streamline is integrated in `f64` by Runge and Kutta's fourth order, together with its derivative by the seed, so that
//! normals are those of the surface and not of its triangles. Streamlines are added, halfway between two in u, in the row in
//! which the two have moved too far apart or their normals turn too much (Hultquist 1992 does the same with what is known of the
//! row alone; here a new one is integrated from its own seed, and lies on the surface exactly). A streamline never ends early.
//! Positions are rounded to 2⁻²⁰, so that the last bit of a platform's `exp` does not show.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3};

use super::{BuiltinError, assembly::Assembly, parameters::Parameters};
use crate::scene::{Primitive, Scene};

/// Half the distance of the two vortices.
const APART: f64 = 0.5;
/// Radius of a core.
const CORE: f64 = 0.3;
/// Circulation of each vortex.
const CIRCULATION: [f64; 2] = [2.6, 1.9];
/// Speed along x outside the cores, and how much of it is lost within them.
const SPEED: f64 = 1.0;
const DRAG: f64 = 0.35;
/// Time that the surface is followed.
const TIME: f64 = 4.6;
/// The line of seeds, from and to.
const SEEDS: [DVec3; 2] = [DVec3::new(0.0, -0.06, -1.35), DVec3::new(0.0, 0.05, 1.25)];
/// Streamlines are numbered along the line of seeds in units of this share of it.
const FINEST: u32 = 1 << 16;
/// Most radians that the normal may turn from one streamline to the next.
const TURN: f64 = 0.16;
/// Positions are multiples of this.
const GRID: f64 = 1.0 / 1_048_576.0;
/// Normals are.
const NORMAL_GRID: f64 = 1.0 / 1_048_576.0;

/// Velocity of the steady flow at a point.
pub fn velocity(p: DVec3) -> DVec3 {
    // Each vortex is carried by the other: both turn about their common centre, as far as the flow has come.
    let total = CIRCULATION[0] + CIRCULATION[1];
    let turning = total / (std::f64::consts::TAU * 4.0 * APART * APART);
    let (sin, cos) = (turning * p.x / SPEED).sin_cos();
    let mut v = DVec3::new(SPEED, 0.0, 0.0);
    for (k, sign) in [(0, 1.0), (1, -1.0)] {
        // The stronger one stays nearer to the centre.
        let arm = sign * 2.0 * APART * CIRCULATION[1 - k] / total;
        let (y, z) = (p.y + arm * sin, p.z - arm * cos);
        let square = y * y + z * z;
        let core = (-square / (CORE * CORE)).exp();
        // (1 - e^-s) / s, which is smooth at 0.
        let s = square / (CORE * CORE);
        let fraction = if s < 1e-8 { 1.0 - 0.5 * s } else { -(-s).exp_m1() / s };
        let rate = CIRCULATION[k] * fraction / (std::f64::consts::TAU * CORE * CORE);
        v += DVec3::new(-DRAG * SPEED * core, -z * rate, y * rate);
    }
    v
}

/// A point of a streamline and its derivative by u, which is unit at the seed.
#[derive(Clone, Copy, Debug)]
struct State {
    position: DVec3,
    across: DVec3,
}

impl State {
    fn rate(self) -> State {
        // A central difference is good to ten digits here, and has no formula to get wrong.
        let step = 1e-5 / self.across.length().max(1e-9);
        let ahead = velocity(self.position + self.across * step);
        let behind = velocity(self.position - self.across * step);
        State { position: velocity(self.position), across: (ahead - behind) / (2.0 * step) }
    }

    fn plus(self, rate: State, time: f64) -> State {
        State { position: self.position + rate.position * time, across: self.across + rate.across * time }
    }

    /// A step of Runge and Kutta's fourth order.
    fn stepped(self, time: f64) -> State {
        let a = self.rate();
        let b = self.plus(a, time / 2.0).rate();
        let c = self.plus(b, time / 2.0).rate();
        let d = self.plus(c, time).rate();
        self.plus(a, time / 6.0).plus(b, time / 3.0).plus(c, time / 3.0).plus(d, time / 6.0)
    }

    fn normal(self) -> DVec3 {
        self.across.cross(velocity(self.position)).normalize_or_zero()
    }
}

/// Streamlines by their number, each followed over all rows.
struct Streamlines {
    rows: usize,
    known: BTreeMap<u32, Vec<State>>,
}

impl Streamlines {
    /// The state of streamline `line` in a row.
    fn at(&mut self, line: u32, row: usize) -> State {
        let rows = self.rows;
        self.known.entry(line).or_insert_with(|| {
            let across = SEEDS[1] - SEEDS[0];
            let seed = SEEDS[0] + across * (f64::from(line) / f64::from(FINEST));
            let mut state = State { position: seed, across };
            let steps = 1024_usize.div_ceil(rows).max(2);
            let time = TIME / (rows * steps) as f64;
            let mut all = vec![state];
            for _ in 0..rows {
                state = (0..steps).fold(state, |s, _| s.stepped(time));
                all.push(state);
            }
            all
        })[row]
    }

    /// Whether two streamlines are too far apart in a row, by distance or by how much the surface turns between them.
    fn is_apart(&mut self, (a, b): (u32, u32), row: usize, length: f64) -> bool {
        let (a, b) = (self.at(a, row), self.at(b, row));
        let near = a.position.distance(b.position);
        near > length || (near > length / 16.0 && a.normal().angle_between(b.normal()) > TURN)
    }
}

/// The surface with `rows` rows of triangles along the flow.
pub fn surface(rows: usize) -> Primitive {
    let length = SPEED * TIME / rows as f64;
    let mut lines = Streamlines { rows, known: BTreeMap::new() };
    let mut row = vec![0, FINEST];
    loop {
        let next = refined(&mut lines, &row, 0, length);
        if next.len() == row.len() {
            break;
        }
        row = next;
    }
    let mut p = Primitive::default();
    let mut place = |lines: &mut Streamlines, row: &[u32], j: usize| -> Vec<(u32, DVec3)> {
        let vertex = |&line: &u32| {
            let state = lines.at(line, j);
            let position = (state.position / GRID).round() * GRID;
            p.positions.push(position.as_vec3().to_array());
            let normal = (state.normal() / NORMAL_GRID).round() * NORMAL_GRID + DVec3::ZERO;
            p.normals.push(normal.as_vec3().to_array());
            p.uvs[0].push([line as f32 / FINEST as f32, j as f32 / rows as f32]);
            ((p.positions.len() - 1) as u32, position)
        };
        row.iter().map(vertex).collect()
    };
    let mut triangles = Vec::new();
    let mut low = place(&mut lines, &row, 0);
    for j in 1..=rows {
        let next = refined(&mut lines, &row, j, length);
        let high = place(&mut lines, &next, j);
        let mut h = 0;
        for (l, pair) in row.windows(2).enumerate() {
            let (a, b, c) = (low[l], low[l + 1], high[h]);
            if next[h + 1] == pair[1] {
                let d = high[h + 1];
                if a.1.distance_squared(d.1) <= b.1.distance_squared(c.1) {
                    triangles.extend([[a.0, b.0, d.0], [a.0, d.0, c.0]]);
                } else {
                    triangles.extend([[a.0, b.0, c.0], [b.0, d.0, c.0]]);
                }
                h += 1;
            } else {
                let (middle, d) = (high[h + 1], high[h + 2]);
                triangles.extend([[a.0, b.0, middle.0], [b.0, d.0, middle.0], [a.0, middle.0, c.0]]);
                h += 2;
            }
        }
        (row, low) = (next, high);
    }
    p.triangles = triangles;
    p
}

/// A row with a streamline more wherever two are too far apart.
fn refined(lines: &mut Streamlines, row: &[u32], j: usize, length: f64) -> Vec<u32> {
    let mut all = Vec::with_capacity(row.len() + 16);
    for pair in row.windows(2) {
        all.push(pair[0]);
        if pair[1] - pair[0] > 1 && lines.is_apart((pair[0], pair[1]), j, length) {
            all.push(pair[0].midpoint(pair[1]));
        }
    }
    all.extend(row.last());
    all
}

pub(super) fn scene(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [rows] = p.take([("rows", 128.0, 16.0, 1024.0)])?;
    let mut assembly = Assembly::new("flow");
    let root = assembly.group(None, "flow", DMat4::IDENTITY);
    let material = assembly.material("surface", 0x8FB3C9, 0.0, 0.45);
    let mesh = assembly.mesh_of("stream surface", Primitive { material, ..surface(rows as usize) });
    assembly.part(root, "stream surface", mesh, DMat4::IDENTITY);
    Ok(assembly.into_scene())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::{build, probe::Rays};
    use super::*;

    fn point(p: &Primitive, i: u32) -> DVec3 {
        Vec3::from(p.positions[i as usize]).as_dvec3()
    }

    #[test]
    fn it_is_one_smooth_sheet() {
        let p = surface(64);
        let mut edges: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let (mut worst_angle, mut thinnest) = (0.0_f64, f64::INFINITY);
        for t in &p.triangles {
            let [a, b, c] = t.map(|i| point(&p, i));
            let cross = (b - a).cross(c - a);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            thinnest = thinnest.min(cross.length() / (longest * longest));
            for &i in t {
                let normal = Vec3::from(p.normals[i as usize]).as_dvec3();
                worst_angle = worst_angle.max(normal.angle_between(cross));
            }
            for e in 0..3 {
                let ends = [t[e], t[(e + 1) % 3]];
                *edges.entry([ends[0].min(ends[1]), ends[0].max(ends[1])]).or_default() += 1;
            }
        }
        println!(
            "{} triangles, thinnest {thinnest:.4}, normals within {:.1}°",
            p.triangles.len(),
            worst_angle.to_degrees()
        );
        assert!(thinnest > 0.003 && worst_angle.to_degrees() < 30.0);
        assert!(edges.values().all(|&n| n <= 2), "an edge belongs to two triangles at most");
        // Euler's number of a disc: one piece, one rim, no hole.
        let euler = p.positions.len() as i64 - edges.len() as i64 + p.triangles.len() as i64;
        assert_eq!(euler, 1);
    }

    /// The parametrization is what it says: through every vertex runs the streamline of its u, for the time of its v.
    #[test]
    fn parameters_are_seed_and_time() {
        let p = surface(32);
        for i in (0..p.positions.len()).step_by(97) {
            let [u, v] = p.uvs[0][i].map(f64::from);
            let seed = SEEDS[0] + (SEEDS[1] - SEEDS[0]) * u;
            let mut state = State { position: seed, across: DVec3::Z };
            for _ in 0..4000 {
                state = state.stepped(v * TIME / 4000.0);
            }
            let found = point(&p, i as u32);
            assert!(state.position.distance(found) < 1e-5, "{u} {v}: {} and {found}", state.position);
        }
    }

    #[test]
    fn it_overlaps_itself_many_times_and_is_refined_where_it_stretches() {
        let scene = build("flow?rows=64").unwrap();
        let sphere = scene.bounds().bounding_sphere();
        for direction in [DVec3::new(0.1, -1.0, 0.2), DVec3::NEG_Z] {
            let depths = Rays::new(&scene).depth_map(sphere.center, sphere.radius, direction, 80);
            let deepest = depths.iter().max().copied().unwrap_or(0);
            println!("{deepest} layers along {direction}");
            assert!(deepest >= 6, "{deepest}");
        }
        let p = &scene.meshes[0].primitives[0];
        let in_row = |v: f32| p.uvs[0].iter().filter(|uv| uv[1] == v).count();
        assert!(in_row(1.0) > 2 * in_row(0.0), "{} and {}", in_row(1.0), in_row(0.0));
        assert_eq!(surface(64), surface(64));
        assert!(matches!(build("flow?rows=4"), Err(BuiltinError::BadValue { .. })));
    }
}
