//! Plane curves of lines, arcs, fillets and chamfers, flattened with exact normals.

use glam::DVec2;

use super::Tolerance;

/// One instruction of a [`Path`].
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// A corner.
    To(f64, f64),
    /// A corner (x, y) rounded with this radius.
    Round(f64, f64, f64),
    /// A corner (x, y) cut this far back along both sides.
    Cut(f64, f64, f64),
    /// From the point before, around a center (first two numbers), the short way to a corner (last two).
    Arc(f64, f64, f64, f64),
    /// A corner whose incoming side is left open: another face closes it.
    Open(f64, f64),
    /// Smooth points with their (unsigned) tangents, e.g. of a spline; the last one is a corner.
    Curve(Vec<(DVec2, DVec2)>),
}

/// A point of a flattened path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// Where it is.
    pub point: DVec2,
    /// Unit normal of the piece that ends here.
    pub normal_in: DVec2,
    /// Unit normal of the piece that starts here.
    pub normal_out: DVec2,
    /// True if the piece that ends here is left open.
    pub open: bool,
}

/// A flattened curve. A closed one runs counter-clockwise with its normals outward; an open one has them to the right.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Path {
    /// The points in order.
    pub knots: Vec<Knot>,
    /// Whether the last knot joins the first.
    pub closed: bool,
}

/// The outward normal of a piece that runs along `tangent` counter-clockwise.
fn right_of(tangent: DVec2) -> DVec2 {
    DVec2::new(tangent.y, -tangent.x).normalize_or_zero()
}

impl Path {
    /// A closed outline through `steps`, in either sense.
    pub fn closed(steps: &[Step], tolerance: Tolerance) -> Path {
        Path::flatten(steps, tolerance, true)
    }

    /// An open profile through `steps` from the axis (x = 0) around the solid back to the axis, in either sense.
    pub fn open(steps: &[Step], tolerance: Tolerance) -> Path {
        Path::flatten(steps, tolerance, false)
    }

    /// A full circle of `count` chords; the first point lies in direction +x.
    pub fn circle(center: DVec2, radius: f64, count: usize) -> Path {
        let knots = (0..count)
            .map(|i| {
                let normal = DVec2::from_angle(std::f64::consts::TAU * i as f64 / count as f64);
                Knot { point: center + normal * radius, normal_in: normal, normal_out: normal, open: false }
            })
            .collect();
        Path { knots, closed: true }
    }

    /// A closed path through points that each have a normal on both sides. Must run counter-clockwise.
    pub fn from_knots(knots: impl IntoIterator<Item = (DVec2, DVec2, DVec2)>) -> Path {
        let knot = |(point, normal_in, normal_out)| Knot { point, normal_in, normal_out, open: false };
        Path { knots: knots.into_iter().map(knot).collect(), closed: true }
    }

    fn flatten(steps: &[Step], tolerance: Tolerance, closed: bool) -> Path {
        let corner = |s: &Step| match s {
            Step::To(x, y) | Step::Round(x, y, _) | Step::Cut(x, y, _) | Step::Open(x, y) | Step::Arc(_, _, x, y) => {
                DVec2::new(*x, *y)
            }
            Step::Curve(points) => points.last().map_or(DVec2::ZERO, |p| p.0),
        };
        let corners: Vec<DVec2> = steps.iter().map(corner).collect();
        let count = corners.len();
        // Every entry: a point and the tangents of the pieces before and after it, before they are signed.
        let mut points: Vec<(DVec2, Option<DVec2>, Option<DVec2>, bool)> = Vec::new();
        for (i, step) in steps.iter().enumerate() {
            let (before, here, after) = (corners[(i + count - 1) % count], corners[i], corners[(i + 1) % count]);
            let (arrive, leave) = ((here - before).normalize_or_zero(), (after - here).normalize_or_zero());
            match step {
                Step::To(..) => points.push((here, None, None, false)),
                Step::Open(..) => points.push((here, None, None, true)),
                Step::Cut(_, _, size) => {
                    points.push((here - arrive * *size, None, None, false));
                    points.push((here + leave * *size, None, None, false));
                }
                Step::Round(_, _, radius) => {
                    let turn = arrive.perp_dot(leave).atan2(arrive.dot(leave));
                    let back = radius * (turn.abs() * 0.5).tan();
                    let side = turn.signum() * *radius;
                    let center = here - arrive * back + arrive.perp() * side;
                    let steps = tolerance.arc(*radius, turn).max(2);
                    for k in 0..=steps {
                        let angle = turn * k as f64 / steps as f64;
                        let tangent = DVec2::from_angle(angle).rotate(arrive);
                        let ends = (k > 0).then_some(tangent);
                        let starts = (k < steps).then_some(tangent);
                        points.push((center - tangent.perp() * side, ends, starts, false));
                    }
                }
                Step::Arc(x, y, _, _) => {
                    let center = DVec2::new(*x, *y);
                    let (from, to) = (before - center, here - center);
                    let turn = from.perp_dot(to).atan2(from.dot(to));
                    let steps = tolerance.arc(from.length(), turn).max(2);
                    let tangent = |k: usize| {
                        DVec2::from_angle(turn * k as f64 / steps as f64).rotate(from).perp() * turn.signum()
                    };
                    if let Some(last) = points.last_mut() {
                        last.2 = Some(tangent(0));
                    }
                    for k in 1..=steps {
                        let t = tangent(k);
                        let point = if k == steps { here } else { center - t.perp() * turn.signum() };
                        points.push((point, Some(t), (k < steps).then_some(t), false));
                    }
                }
                Step::Curve(curve) => {
                    for (k, (point, tangent)) in curve.iter().enumerate() {
                        let along = if k + 1 < curve.len() { curve[k + 1].0 - *point } else { *point - curve[k - 1].0 };
                        let tangent = if tangent.dot(along) < 0.0 { -*tangent } else { *tangent };
                        let inner = k + 1 < curve.len();
                        points.push((*point, (k > 0).then_some(tangent), inner.then_some(tangent), false));
                    }
                }
            }
        }
        Path::from_tangents(points, closed)
    }

    fn from_tangents(points: Vec<(DVec2, Option<DVec2>, Option<DVec2>, bool)>, closed: bool) -> Path {
        // A zero-length piece would have no normal; it appears where two fillets meet.
        let mut kept: Vec<(DVec2, Option<DVec2>, Option<DVec2>, bool)> = Vec::with_capacity(points.len());
        for point in points {
            match kept.last_mut() {
                Some(last) if last.0.distance(point.0) < 1e-7 => {
                    last.2 = point.2;
                }
                _ => kept.push(point),
            }
        }
        if closed && kept.len() > 1 && kept[0].0.distance(kept[kept.len() - 1].0) < 1e-7 {
            let last = kept.pop().and_then(|p| p.1);
            kept[0].1 = last;
        }
        let count = kept.len();
        let area: f64 = (0..count).map(|i| kept[i].0.perp_dot(kept[(i + 1) % count].0)).sum();
        let knots = (0..count).map(|i| {
            let (point, ends, starts, open) = kept[i];
            let (before, after) = (kept[(i + count - 1) % count].0, kept[(i + 1) % count].0);
            Knot {
                point,
                normal_in: right_of(ends.unwrap_or(point - before)),
                normal_out: right_of(starts.unwrap_or(after - point)),
                open,
            }
        });
        let path = Path { knots: knots.collect(), closed };
        if area < 0.0 { path.reversed() } else { path }
    }

    /// The same curve run the other way, with its normals turned to stay to the right.
    fn reversed(&self) -> Path {
        let count = self.knots.len();
        let knots = (0..count).rev().map(|i| {
            let k = self.knots[i];
            // The piece that ends here after reversal is the one that started here, so its flag comes from the next.
            let open = self.knots[(i + 1) % count].open;
            Knot { point: k.point, normal_in: -k.normal_out, normal_out: -k.normal_in, open }
        });
        Path { knots: knots.collect(), closed: self.closed }
    }

    /// The points, for [`super::face`].
    pub fn points(&self) -> Vec<DVec2> {
        self.knots.iter().map(|k| k.point).collect()
    }

    /// Start and end of every piece.
    pub fn pieces(&self) -> impl Iterator<Item = (Knot, Knot)> + '_ {
        let count = self.knots.len();
        let pieces = if self.closed { count } else { count.saturating_sub(1) };
        (0..pieces).map(move |i| (self.knots[i], self.knots[(i + 1) % count]))
    }

    /// Every point moved by `distance` along its normals (mitred at corners); negative moves inward.
    #[must_use]
    pub fn offset(&self, distance: f64) -> Path {
        let mut path = self.clone();
        for knot in &mut path.knots {
            let mitre = knot.normal_in + knot.normal_out;
            knot.point += mitre * (2.0 * distance / mitre.length_squared().max(1e-3));
        }
        path
    }

    /// The path turned about the origin by `angle` radians and then shifted.
    #[must_use]
    pub fn placed(&self, angle: f64, shift: DVec2) -> Path {
        let turn = DVec2::from_angle(angle);
        let mut path = self.clone();
        for k in &mut path.knots {
            k.point = turn.rotate(k.point) + shift;
            k.normal_in = turn.rotate(k.normal_in);
            k.normal_out = turn.rotate(k.normal_out);
        }
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fillets_are_tangent_and_normals_point_outward() {
        let steps = [Step::Round(0.0, 0.0, 1.0), Step::To(10.0, 0.0), Step::Cut(10.0, 5.0, 1.0), Step::To(0.0, 5.0)];
        let forward = Path::closed(&steps, Tolerance(0.01));
        let backward: Vec<Step> = steps.iter().rev().cloned().collect();
        for path in [forward, Path::closed(&backward, Tolerance(0.01))] {
            let center = DVec2::new(5.0, 2.5);
            for knot in &path.knots {
                assert!(knot.normal_in.dot(knot.point - center) > 0.0, "{knot:?}");
                assert!(knot.normal_out.dot(knot.point - center) > 0.0, "{knot:?}");
                if knot.point.length() < 1.3 && knot.point.min_element() >= -1e-12 {
                    assert!(knot.normal_in.distance(knot.normal_out) < 1e-9, "the fillet meets its sides smoothly");
                }
            }
            for (a, b) in path.pieces() {
                assert!(a.point.distance(b.point) > 1e-6);
            }
        }
    }
}
