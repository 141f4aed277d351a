//! Polygons to triangles: OBJ and PLY have faces of any number of corners, concave ones among them.
//!
//! Convex polygons become a fan from their first corner, which is also what most programs make of quads. Others are
//! flattened along the axis nearest to their normal (Newell's, which is defined for corners that are not quite in a plane)
//! and their ears are cut off one by one: a corner is an ear if it is convex and no other corner lies in its triangle. That
//! is right for every simple polygon, and for one whose holes are joined to its outline by a double edge. It takes quadratic
//! time, so all polygons of a file share a budget, after which the rest is filled as fans and told; a single face of some ten
//! thousand corners is within it. Where a polygon crosses itself there is no right answer; something is cut off all the same.
//!
//! Libraries that fill polygons exist and one of them fills the caps of sections here (`scene::cut`), but they give new
//! points on a grid of integers. Faces have to keep the file's vertices, with their texture coordinates and neighbours.

use glam::{DVec2, DVec3};

/// Corners that are looked at for one file, all ears together: a second or two.
const BUDGET: u64 = 400_000_000;

/// Triangulates the polygons of one file.
#[derive(Debug)]
pub(super) struct Polygons {
    budget: u64,
    /// Polygons that may be filled wrongly because the budget was spent.
    pub(super) unfinished: u64,
    flat: Vec<DVec2>,
    next: Vec<u32>,
    previous: Vec<u32>,
}

impl Default for Polygons {
    fn default() -> Polygons {
        Polygons { budget: BUDGET, unfinished: 0, flat: Vec::new(), next: Vec::new(), previous: Vec::new() }
    }
}

impl Polygons {
    /// Calls `emit` for the triangles of a polygon, as numbers of its corners, wound as it is. `n` corners give at most
    /// `n − 2` triangles. Corners may be anywhere, and may not be finite.
    pub(super) fn triangulate(
        &mut self,
        corners: usize,
        position: impl Fn(usize) -> DVec3,
        mut emit: impl FnMut([usize; 3]),
    ) {
        match corners {
            0..=2 => return,
            3 => return emit([0, 1, 2]),
            _ => {}
        }
        let fan = |emit: &mut dyn FnMut([usize; 3])| (1..corners - 1).for_each(|i| emit([0, i, i + 1]));
        // Relative to the first corner, so that distance from the origin costs nothing.
        let first = position(0);
        let mut normal = DVec3::ZERO;
        for i in 0..corners {
            let (a, b) = (position(i) - first, position((i + 1) % corners) - first);
            normal += DVec3::new((a.y - b.y) * (a.z + b.z), (a.z - b.z) * (a.x + b.x), (a.x - b.x) * (a.y + b.y));
        }
        let size = normal.abs();
        if !normal.is_finite() || size.max_element() == 0.0 {
            return fan(&mut emit);
        }
        let flatten = |p: DVec3| match size {
            s if s.z >= s.x && s.z >= s.y => DVec2::new(p.x * normal.z.signum(), p.y),
            s if s.y >= s.x => DVec2::new(p.z * normal.y.signum(), p.x),
            _ => DVec2::new(p.y * normal.x.signum(), p.z),
        };
        self.flat.clear();
        self.flat.extend((0..corners).map(|i| flatten(position(i) - first)));
        let turn = |i: usize| {
            let at = |k: usize| self.flat[k % corners];
            (at(i + 1) - at(i)).perp_dot(at(i + 2) - at(i + 1))
        };
        // Corners on a straight edge make triangles without area in a fan, and are then missing in the surface.
        if (0..corners).all(|i| turn(i) > 0.0) && self.winds_once() {
            return fan(&mut emit);
        }
        self.cut_ears(&mut emit);
    }

    /// Whether a polygon that turns left at every corner goes around once (a star goes around twice).
    fn winds_once(&self) -> bool {
        let n = self.flat.len();
        let edge = |i: usize| self.flat[(i + 1) % n] - self.flat[i % n];
        let crossings = (0..n).filter(|&i| edge(i).y < 0.0 && edge(i + 1).y >= 0.0).count();
        crossings == 1
    }

    fn cut_ears(&mut self, emit: &mut dyn FnMut([usize; 3])) {
        let n = self.flat.len();
        self.next.clear();
        self.next.extend((1..n as u32).chain([0]));
        self.previous.clear();
        self.previous.extend([n as u32 - 1].into_iter().chain(0..n as u32 - 1));
        let mut left = n;
        let mut at = 0_usize;
        // How many corners were looked at since the last ear.
        let mut waited = 0;
        while left > 3 {
            let (a, c) = (self.previous[at] as usize, self.next[at] as usize);
            // After a whole turn without an ear the polygon crosses itself or has no area: anything goes.
            if waited > left || self.is_ear(a, at, c) {
                emit([a, at, c]);
                self.next[a] = c as u32;
                self.previous[c] = a as u32;
                left -= 1;
                waited = 0;
                // Not the next corner but the one after, so that triangles do not all meet in one.
                at = self.next[c] as usize;
            } else {
                waited += 1;
                at = c;
            }
            if self.budget == 0 {
                self.unfinished += 1;
                let mut last = self.next[at] as usize;
                for _ in 0..left - 2 {
                    let after = self.next[last] as usize;
                    emit([at, last, after]);
                    last = after;
                }
                return;
            }
        }
        emit([self.previous[at] as usize, at, self.next[at] as usize]);
    }

    fn is_ear(&mut self, a: usize, b: usize, c: usize) -> bool {
        let flat = &self.flat;
        let [p, q, r] = [flat[a], flat[b], flat[c]];
        if (q - p).perp_dot(r - q) <= 0.0 {
            return false;
        }
        let (low, high) = (p.min(q).min(r), p.max(q).max(r));
        let mut at = self.next[c] as usize;
        while at != a {
            self.budget = self.budget.saturating_sub(1);
            let s = flat[at];
            let inside = s.cmpge(low).all()
                && s.cmple(high).all()
                && (q - p).perp_dot(s - p) >= 0.0
                && (r - q).perp_dot(s - q) >= 0.0
                && (p - r).perp_dot(s - r) >= 0.0;
            // Where a hole is joined to the outline, corners lie on each other.
            if inside && s != p && s != q && s != r {
                return false;
            }
            at = self.next[at] as usize;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(points: &[[f64; 3]]) -> Vec<[usize; 3]> {
        let mut all = Vec::new();
        Polygons::default().triangulate(points.len(), |i| points[i].into(), |t| all.push(t));
        all
    }

    /// The area of a polygon and of its triangles (all of which must be wound as it is) agree.
    fn filled(outline: &[[f64; 2]]) {
        // In three planes, so that each axis is dropped once, and turned over.
        let planes: [fn([f64; 2]) -> [f64; 3]; 4] =
            [|[x, y]| [x, y, 0.0], |[x, y]| [0.0, x, y], |[x, y]| [y, 1e6, x], |[x, y]| [y, x, 0.5]];
        for plane in planes {
            let points: Vec<[f64; 3]> = outline.iter().map(|&p| plane(p)).collect();
            let at = |i: usize| DVec3::from(points[i]);
            let whole = (1..points.len() - 1).map(|i| (at(i) - at(0)).cross(at(i + 1) - at(0))).sum::<DVec3>();
            let all = triangles(&points);
            assert_eq!(all.len(), points.len() - 2);
            let mut sum = 0.0;
            for &[a, b, c] in &all {
                let area = (at(b) - at(a)).cross(at(c) - at(a));
                assert!(area.dot(whole) >= 0.0, "{all:?}");
                sum += area.length();
            }
            assert!((sum - whole.length()).abs() < 1e-9 * whole.length(), "{sum} of {}", whole.length());
        }
    }

    #[test]
    fn simple_polygons_are_filled_and_no_more() {
        filled(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        // An arrow head: the fan from its first corner would be wrong.
        filled(&[[1.0, 0.0], [0.0, 1.0], [0.3, 0.0], [0.0, -1.0]]);
        filled(&[[0.3, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]]);
        // Straight edges with corners on them.
        filled(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0], [0.0, 1.0]]);
        // A comb.
        let comb: Vec<[f64; 2]> = (0..40)
            .map(|i| [f64::from(i), if i % 2 == 0 { 0.1 } else { 5.0 }])
            .chain([[39.0, -1.0], [0.0, -1.0]])
            .rev()
            .collect();
        filled(&comb);
        // A square with a square hole, joined by a double edge.
        let hole = [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0], [1.0, 1.0]];
        let mut joined = vec![[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0], [0.0, 0.0]];
        joined.extend(hole);
        filled(&joined);
    }

    #[test]
    fn odd_polygons_end() {
        assert_eq!(triangles(&[[0.0; 3]; 2]), [] as [[usize; 3]; 0]);
        assert_eq!(triangles(&[[0.0; 3]; 7]).len(), 5);
        assert_eq!(triangles(&[[f64::NAN, 0.0, 0.0], [0.0; 3], [1.0; 3], [2.0, 0.0, 0.0]]).len(), 2);
        // A bow tie, and a star that goes around twice.
        assert_eq!(triangles(&[[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.1, 0.0]]).len(), 2);
        let star = |i: usize| (i as f64 * 0.8 * std::f64::consts::PI).sin_cos();
        let star: Vec<[f64; 3]> = (0..5).map(|i| [star(i).1, star(i).0, 0.0]).collect();
        assert_eq!(triangles(&star).len(), 3);
    }

    #[test]
    fn a_spent_budget_is_told() {
        let mut polygons = Polygons { budget: 10, ..Polygons::default() };
        let zigzag = |i: usize| DVec3::new(i as f64, (i % 2) as f64, 0.0);
        let mut count = 0;
        polygons.triangulate(101, |i| if i == 100 { DVec3::new(50.0, 9.0, 0.0) } else { zigzag(i) }, |_| count += 1);
        assert_eq!((count, polygons.unfinished), (99, 1));
    }
}
