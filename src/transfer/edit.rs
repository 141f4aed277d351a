//! What an editor does to control points: insert, move, remove, scale, find.
//!
//! Every function is total. Whatever position, value or index it is given (NaN and infinities included), the points
//! stay at least one, each allowed, at strictly increasing positions; what cannot be done is not done, and the answer
//! says so. Points are addressed by index; moving never changes the order, so an index stays valid during a drag.

use std::collections::BTreeSet;

use super::points::{ControlPoint, Interpolation, Points, interpolate};
use super::{
    ColorFunction, ColorPoint, ColorShape, ColorValue, OpacityCurve, OpacityFunction, OpacityPoint, OpacityShape,
    TransferFunction,
};

/// Neighbouring points are kept at least so far apart, in the units of their axis; closer ones that a file brought stay
/// until they are moved.
pub const LEAST_GAP: f64 = 1e-4;

/// A control point with a value that an editor changes.
pub trait EditPoint: ControlPoint + Copy {
    /// What stands at the position.
    type Value: Copy;
    /// Lowest and highest position.
    const DOMAIN: [f64; 2];
    /// The value there.
    fn value(&self) -> Self::Value;
    /// A point at a position of the domain, its value made allowed: clamped to [0, 1], `instead` where it is NaN.
    fn new(position: f64, value: Self::Value, instead: Self::Value) -> Self;
    /// The value at `position` between points.
    fn between(points: &Points<Self>, interpolation: Interpolation, position: f64) -> Self::Value;
    /// The value moved away from `about` by `factor`.
    fn scaled(value: Self::Value, factor: f64, about: f64) -> Self::Value;
}

fn allowed(value: f64, instead: f64) -> f64 {
    if value.is_nan() { instead } else { value.clamp(0.0, 1.0) }
}

fn scaled(value: f64, factor: f64, about: f64) -> f64 {
    about + (value - about) * factor
}

impl EditPoint for ColorPoint {
    type Value = [f64; 3];
    const DOMAIN: [f64; 2] = [-1.0, 1.0];
    fn value(&self) -> [f64; 3] {
        self.color.0
    }
    fn new(kappa: f64, value: [f64; 3], instead: [f64; 3]) -> ColorPoint {
        ColorPoint { kappa, color: ColorValue(std::array::from_fn(|i| allowed(value[i], instead[i]))) }
    }
    fn between(points: &Points<ColorPoint>, interpolation: Interpolation, position: f64) -> [f64; 3] {
        let xs = points.positions();
        std::array::from_fn(|c| {
            let ys: Vec<f64> = points.as_slice().iter().map(|p| p.color.0[c]).collect();
            interpolate(&xs, &ys, interpolation, position)
        })
    }
    fn scaled(value: [f64; 3], factor: f64, about: f64) -> [f64; 3] {
        value.map(|v| scaled(v, factor, about))
    }
}

impl EditPoint for OpacityPoint {
    type Value = f64;
    const DOMAIN: [f64; 2] = [0.0, 1.0];
    fn value(&self) -> f64 {
        self.opacity
    }
    fn new(kappa: f64, value: f64, instead: f64) -> OpacityPoint {
        OpacityPoint { kappa, opacity: allowed(value, instead) }
    }
    fn between(points: &Points<OpacityPoint>, interpolation: Interpolation, position: f64) -> f64 {
        let ys: Vec<f64> = points.as_slice().iter().map(|p| p.opacity).collect();
        interpolate(&points.positions(), &ys, interpolation, position)
    }
    fn scaled(value: f64, factor: f64, about: f64) -> f64 {
        scaled(value, factor, about)
    }
}

/// Where a new point may stand near `position`: at least [`LEAST_GAP`] from its neighbours. Its index and its place.
fn room(positions: &[f64], [least, most]: [f64; 2], position: f64) -> Option<(usize, f64)> {
    if position.is_nan() {
        return None;
    }
    let position = position.clamp(least, most);
    let index = positions.partition_point(|p| *p <= position);
    let free = bounds(positions.get(..index)?.last(), positions.get(index), [least, most])?;
    Some((index, position.clamp(free[0], free[1])))
}

/// The free places between two neighbours, if there are any.
fn bounds(before: Option<&f64>, behind: Option<&f64>, [least, most]: [f64; 2]) -> Option<[f64; 2]> {
    let from = before.map_or(least, |p| p + LEAST_GAP);
    let to = behind.map_or(most, |p| p - LEAST_GAP);
    (from <= to).then_some([from, to])
}

/// Adds a point with the value that the curve has there, so that a straight or stepped curve does not change. It is
/// put [`LEAST_GAP`] from a point that stands there.
///
/// Returns its index; `None`, with nothing changed, if there is no room or `position` is NaN.
pub fn insert<P: EditPoint>(points: &mut Points<P>, interpolation: Interpolation, position: f64) -> Option<usize> {
    let (index, place) = room(&points.positions(), P::DOMAIN, position)?;
    let value = P::between(points, interpolation, place);
    points.edit(|all| all.insert(index, P::new(place, value, value)));
    Some(index)
}

/// Moves a point and sets its value. It stays between its neighbours and in its domain, and its value is clamped; a
/// position or value that is NaN leaves the old one, and so does a position where neighbours leave no room.
///
/// Returns the point as it stands now; `None` if there is no such point.
pub fn move_to<P: EditPoint>(points: &mut Points<P>, index: usize, position: f64, value: P::Value) -> Option<P> {
    let old = *points.as_slice().get(index)?;
    let positions = points.positions();
    let place = place(&positions, index, P::DOMAIN, position)?;
    let new = P::new(place, value, old.value());
    points.edit(|all| {
        if let Some(point) = all.get_mut(index) {
            *point = new;
        }
    });
    Some(new)
}

/// Where point `index` comes to stand when it is moved to `position`.
fn place(positions: &[f64], index: usize, domain: [f64; 2], position: f64) -> Option<f64> {
    let old = *positions.get(index)?;
    let before = index.checked_sub(1).and_then(|i| positions.get(i));
    let free = bounds(before, positions.get(index + 1), domain);
    Some(match free {
        Some([from, to]) if !position.is_nan() => position.clamp(from, to),
        _ => old,
    })
}

/// Moves several points together, by `by` along their axis and as `change` says in value. They go only as far as every one of
/// them can without coming nearer than [`LEAST_GAP`] to a point that stays or leaving the domain, so that they keep their
/// distances. Indices that do not exist are passed over; NaN moves nothing.
///
/// Returns by how much they were moved along their axis.
pub fn shift<P: EditPoint>(
    points: &mut Points<P>,
    indices: &BTreeSet<usize>,
    by: f64,
    change: impl Fn(P::Value) -> P::Value,
) -> f64 {
    let positions = points.positions();
    let any = indices.first().is_some_and(|i| *i < positions.len());
    let mut free = if by.is_nan() || !any { 0.0 } else { by };
    for &i in indices.iter().filter(|i| **i < positions.len()) {
        let at = positions[i];
        let stays = |other: &usize| !indices.contains(other);
        if by > 0.0 {
            let next = Some(i + 1).filter(|n| *n < positions.len());
            let to = next.filter(stays).map_or(P::DOMAIN[1], |n| positions[n] - LEAST_GAP);
            free = free.min((to - at).max(0.0));
        } else {
            let last = i.checked_sub(1);
            let to = last.filter(stays).map_or(P::DOMAIN[0], |n| positions[n] + LEAST_GAP);
            free = free.max((to - at).min(0.0));
        }
    }
    points.edit(|all| {
        for &i in indices {
            if let Some(point) = all.get_mut(i) {
                let (place, old) = (point.position(), point.value());
                let place = (place + free).clamp(P::DOMAIN[0], P::DOMAIN[1]);
                *point = P::new(place, change(old), old);
            }
        }
    });
    free
}

/// Removes points; one stays.
///
/// Returns how many were removed.
pub fn remove_all<P: ControlPoint + Clone>(points: &mut Points<P>, indices: &BTreeSet<usize>) -> usize {
    indices.iter().rev().filter(|&&i| remove(points, i)).count()
}

/// Removes a point. The last one stays.
///
/// Returns whether it was removed.
pub fn remove<P: ControlPoint + Clone>(points: &mut Points<P>, index: usize) -> bool {
    let may = points.as_slice().len() > 1 && index < points.as_slice().len();
    if may {
        points.edit(|all| {
            all.remove(index);
        });
    }
    may
}

/// Moves every value away from `about` (or towards it) by `factor`, clamped to [0, 1]: `about` 0 makes a curve of
/// opacities higher or lower, 0.5 makes colours act more or less. NaN changes nothing.
pub fn scale<P: EditPoint>(points: &mut Points<P>, factor: f64, about: f64) {
    points.edit(|all| {
        for point in all {
            let old = point.value();
            *point = P::new(point.position(), P::scaled(old, factor, about), old);
        }
    });
}

/// The point whose position is nearest, if it is within `tolerance`. Of two as near, the first.
pub fn nearest<P: ControlPoint>(points: &Points<P>, position: f64, tolerance: f64) -> Option<usize> {
    closest(points.as_slice().iter().map(|p| (p.position() - position) / tolerance))
}

/// The point of a curve nearest to ([`OpacityPoint::kappa`], opacity), if it is within an ellipse with half axes
/// `tolerance`: a picked point is the nearest on the screen if these are one length on it.
pub fn nearest_on_curve(points: &Points<OpacityPoint>, at: [f64; 2], tolerance: [f64; 2]) -> Option<usize> {
    let points = points.as_slice().iter();
    closest(points.map(|p| ((p.kappa - at[0]) / tolerance[0]).hypot((p.opacity - at[1]) / tolerance[1])))
}

/// The curve and its point nearest to (depth, |κ|), if it is within an ellipse with half axes `tolerance`.
pub fn nearest_in_map(curves: &Points<OpacityCurve>, at: [f64; 2], tolerance: [f64; 2]) -> Option<(usize, usize)> {
    let all = || {
        curves.as_slice().iter().enumerate().flat_map(|(i, c)| (0..c.points.as_slice().len()).map(move |j| (i, j, c)))
    };
    let index = closest(all().map(|(_, j, curve)| {
        let kappa = curve.points.as_slice()[j].kappa;
        ((curve.depth - at[0]) / tolerance[0]).hypot((kappa - at[1]) / tolerance[1])
    }))?;
    all().nth(index).map(|(i, j, _)| (i, j))
}

/// The index of the smallest of the distances, if it is at most 1.
fn closest(distances: impl Iterator<Item = f64>) -> Option<usize> {
    distances
        .map(f64::abs)
        .enumerate()
        .filter(|(_, d)| *d <= 1.0)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

/// Adds a curve at a depth, with the opacities that the function has there over the |κ| of its neighbours' points.
///
/// Returns its index; `None`, with nothing changed, if there is no room, `depth` is NaN, or the function is an image.
pub fn insert_curve(function: &mut OpacityFunction, depth: f64) -> Option<usize> {
    let OpacityShape::Curves { curves, .. } = &function.shape else {
        return None;
    };
    let (index, depth) = room(&curves.positions(), [0.0, 1.0], depth)?;
    let neighbours = [index.checked_sub(1), Some(index)].into_iter().flatten().filter_map(|i| curves.as_slice().get(i));
    let mut places: Vec<f64> = neighbours.flat_map(|c| c.points.positions()).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|b, a| *b - *a < LEAST_GAP);
    let point = |kappa: f64| OpacityPoint { kappa, opacity: allowed(function.sample(depth, kappa), 0.0) };
    let points = Points::new(places.into_iter().map(point).collect()).ok()?;
    if let OpacityShape::Curves { curves, .. } = &mut function.shape {
        curves.edit(|all| all.insert(index, OpacityCurve { depth, points }));
    }
    Some(index)
}

/// Moves a curve to a depth, between its neighbours. NaN leaves it.
///
/// Returns the depth where it stands now; `None` if there is no such curve.
pub fn move_curve(curves: &mut Points<OpacityCurve>, index: usize, depth: f64) -> Option<f64> {
    let depth = place(&curves.positions(), index, [0.0, 1.0], depth)?;
    curves.edit(|all| {
        if let Some(curve) = all.get_mut(index) {
            curve.depth = depth;
        }
    });
    Some(depth)
}

/// Changes the points of one curve by any of the functions here.
///
/// Returns what `change` returns; `None` if there is no such curve.
pub fn with_curve<R>(
    curves: &mut Points<OpacityCurve>,
    index: usize,
    change: impl FnOnce(&mut Points<OpacityPoint>) -> R,
) -> Option<R> {
    let mut answer = None;
    curves.edit(|all| answer = all.get_mut(index).map(|curve| change(&mut curve.points)));
    answer
}

/// Multiplies the opacities of every curve.
pub fn scale_curves(curves: &mut Points<OpacityCurve>, factor: f64) {
    curves.edit(|all| all.iter_mut().for_each(|curve| scale(&mut curve.points, factor, 0.0)));
}

impl ColorFunction {
    /// The points and what lies between them, to be edited. `None` for an image; [`TransferFunction::make_editable`]
    /// turns it into points.
    pub fn points_mut(&mut self) -> Option<(&mut Interpolation, &mut Points<ColorPoint>)> {
        match &mut self.shape {
            ColorShape::Points { interpolation, points } => Some((interpolation, points)),
            ColorShape::Strip(_) => None,
        }
    }

    /// Sets what lies between points.
    ///
    /// Returns whether it was set: an image has no such choice.
    pub fn set_interpolation(&mut self, to: Interpolation) -> bool {
        self.points_mut().map(|(interpolation, _)| *interpolation = to).is_some()
    }
}

impl OpacityFunction {
    /// The curves, to be edited. `None` for an image; [`TransferFunction::make_editable`] turns it into curves.
    pub fn curves_mut(&mut self) -> Option<&mut Points<OpacityCurve>> {
        match &mut self.shape {
            OpacityShape::Curves { curves, .. } => Some(curves),
            OpacityShape::Image(_) => None,
        }
    }

    /// Sets what lies between the points of a curve, and between curves; `None` leaves it.
    ///
    /// Returns whether it was set: an image has no such choice.
    pub fn set_interpolation(&mut self, along: Option<Interpolation>, between: Option<Interpolation>) -> bool {
        match &mut self.shape {
            OpacityShape::Curves { interpolation, depth_interpolation, .. } => {
                *interpolation = along.unwrap_or(*interpolation);
                *depth_interpolation = between.unwrap_or(*depth_interpolation);
                true
            }
            OpacityShape::Image(_) => false,
        }
    }
}

impl TransferFunction {
    /// Puts control points in place of images ([`TransferFunction::without_images`]).
    ///
    /// Returns the largest error that this made; 0 if there was no image.
    pub fn make_editable(&mut self) -> f64 {
        let (points, error) = self.without_images();
        *self = points;
        error
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn curve(points: &[(f64, f64)]) -> Points<OpacityPoint> {
        Points::new(points.iter().map(|p| OpacityPoint::from(*p)).collect()).unwrap()
    }

    #[test]
    fn inserting_changes_no_straight_curve() {
        let mut points = curve(&[(0.0, 0.2), (0.4, 0.9), (1.0, 0.1)]);
        let before = points.clone();
        assert_eq!(insert(&mut points, Interpolation::Linear, 0.7), Some(2));
        assert_eq!(points.as_slice().len(), 4);
        for i in 0..=100 {
            let x = f64::from(i) / 100.0;
            let [a, b] = [&before, &points].map(|p| OpacityPoint::between(p, Interpolation::Linear, x));
            assert!((a - b).abs() < 1e-12, "{x}: {a} {b}");
        }
        // On a point: next to it. At the upper end, where one stands: before it is no place behind it.
        assert_eq!(insert(&mut points, Interpolation::Linear, 0.4), Some(2));
        assert!((points.as_slice()[2].kappa - 0.4 - LEAST_GAP).abs() < 1e-12);
        assert_eq!(insert(&mut points, Interpolation::Linear, 1.0), None);
        assert_eq!(insert(&mut points, Interpolation::Linear, f64::NAN), None);
    }

    #[test]
    fn a_point_stays_between_its_neighbours() {
        let mut points = curve(&[(0.0, 0.2), (0.4, 0.9), (1.0, 0.1)]);
        let moved = move_to(&mut points, 1, 7.0, -3.0).unwrap();
        assert_eq!(moved, OpacityPoint { kappa: 1.0 - LEAST_GAP, opacity: 0.0 });
        assert_eq!(move_to(&mut points, 1, f64::NAN, f64::NAN), Some(moved));
        assert_eq!(move_to(&mut points, 0, -1.0, 0.5).unwrap(), OpacityPoint { kappa: 0.0, opacity: 0.5 });
        assert_eq!(move_to(&mut points, 3, 0.5, 0.5), None);
        assert!(remove(&mut points, 1) && remove(&mut points, 0) && !remove(&mut points, 0), "one point stays");
    }

    #[test]
    fn several_points_keep_their_distances() {
        let mut points = curve(&[(0.1, 0.2), (0.3, 0.9), (0.5, 0.4), (0.9, 1.0)]);
        let moved = shift(&mut points, &[1, 2, 7].into(), 5.0, |v| v + 0.2);
        assert_eq!(moved, 0.9 - LEAST_GAP - 0.5);
        let expected = curve(&[(0.1, 0.2), (0.3 + moved, 1.0), (0.5 + moved, 0.4 + 0.2), (0.9, 1.0)]);
        assert_eq!(points, expected);
        assert_eq!(shift(&mut points, &[0, 3].into(), -1.0, |v| v), 0.0, "the last cannot");
        assert_eq!(shift(&mut points, &[0].into(), -1.0, |v| v), -0.1);
        assert_eq!(shift(&mut points, &[9].into(), f64::INFINITY, |v| v), 0.0);
        let mut points = curve(&[(0.1, 0.2), (0.3, 0.9), (0.5, 0.4)]);
        assert_eq!(remove_all(&mut points, &[0, 1, 2, 9].into()), 2);
        assert_eq!(points, curve(&[(0.1, 0.2)]));
    }

    #[test]
    fn the_nearest_point_is_found_within_the_tolerance() {
        let points = curve(&[(0.0, 0.2), (0.4, 0.9), (0.5, 0.1)]);
        assert_eq!(nearest(&points, 0.44, 0.1), Some(1));
        assert_eq!(nearest(&points, 0.44, 0.03), None);
        assert_eq!(nearest_on_curve(&points, [0.44, 0.15], [0.1, 0.1]), Some(2));
        assert_eq!(nearest_on_curve(&points, [f64::NAN, 0.15], [0.1, 0.1]), None);
        let at = |depth, points| OpacityCurve { depth, points };
        let curves = Points::new(vec![at(0.1, points), at(0.8, curve(&[(0.45, 0.0)]))]).unwrap();
        assert_eq!(nearest_in_map(&curves, [0.7, 0.45], [0.2, 0.2]), Some((1, 0)));
        assert_eq!(nearest_in_map(&curves, [0.1, 0.48], [0.2, 0.2]), Some((0, 2)));
        assert_eq!(nearest_in_map(&curves, [0.4, 0.48], [0.2, 0.2]), None);
    }

    #[test]
    fn scaling_is_about_a_value_and_clamped() {
        let mut points = curve(&[(0.0, 0.2), (1.0, 0.9)]);
        scale(&mut points, 2.0, 0.0);
        assert_eq!(points.as_slice().iter().map(|p| p.opacity).collect::<Vec<_>>(), [0.4, 1.0]);
        scale(&mut points, f64::NAN, 0.0);
        assert_eq!(points.as_slice()[0].opacity, 0.4);
        let mut colors = Points::new(vec![ColorPoint { kappa: 0.0, color: ColorValue([0.5, 0.6, 0.1]) }]).unwrap();
        scale(&mut colors, 0.0, 0.5);
        assert_eq!(colors.as_slice()[0].color.0, [0.5; 3]);
    }

    #[test]
    fn a_new_curve_is_what_the_function_was_there() {
        let text = "[color]\npoints = [{ kappa = 0, color = 0.5 }]\n[opacity]\ninterpolation = 'linear'\ncurves = [
            { depth = 0, points = [[0, 0.1], [0.5, 0.3], [1, 0.9]] },
            { depth = 1, points = [[0, 0.3], [0.7, 0.8], [1, 1]] },
        ]";
        let mut function = TransferFunction::from_toml(text, "test").unwrap().opacity;
        let before = function.bake();
        assert_eq!(insert_curve(&mut function, 0.25), Some(1));
        let worst = before.iter().zip(function.bake()).fold(0.0_f32, |m, (a, b)| m.max((a - b).abs()));
        assert!(worst < 1e-6, "{worst}");
        let curves = function.curves_mut().unwrap();
        assert_eq!(move_curve(curves, 1, 2.0), Some(1.0 - LEAST_GAP));
        assert_eq!(with_curve(curves, 1, |points| insert(points, Interpolation::Linear, 0.1)), Some(Some(1)));
        assert_eq!(with_curve(curves, 9, |points| points.as_slice().len()), None);
    }

    #[derive(Clone, Debug)]
    enum Gesture {
        Insert(f64),
        Move(usize, f64, f64),
        Shift(Vec<usize>, f64, f64),
        Remove(usize),
        Scale(f64, f64),
        Curve(f64),
        MoveCurve(usize, f64),
        RemoveCurve(usize),
        Mode(u8),
    }

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![
            8 => -1.5..1.5_f64,
            1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 1.0, -1.0, 1e300, 5e-324]),
            1 => (0..40_u32).prop_map(|i| f64::from(i) * LEAST_GAP),
        ]
    }

    fn gesture() -> impl Strategy<Value = Gesture> {
        prop_oneof![
            6 => number().prop_map(Gesture::Insert),
            6 => (0..12_usize, number(), number()).prop_map(|(i, x, y)| Gesture::Move(i, x, y)),
            4 => (prop::collection::vec(0..12_usize, 0..5), number(), number())
                .prop_map(|(i, x, y)| Gesture::Shift(i, x, y)),
            3 => (0..12_usize).prop_map(Gesture::Remove),
            1 => (number(), number()).prop_map(|(f, a)| Gesture::Scale(f, a)),
            2 => number().prop_map(Gesture::Curve),
            2 => (0..5_usize, number()).prop_map(|(i, d)| Gesture::MoveCurve(i, d)),
            1 => (0..5_usize).prop_map(Gesture::RemoveCurve),
            1 => (0..3_u8).prop_map(Gesture::Mode),
        ]
    }

    proptest! {
        #[test]
        fn no_gestures_break_the_invariants(gestures in prop::collection::vec(gesture(), 1..60)) {
            let mut function = TransferFunction::uniform(0.3);
            for gesture in &gestures {
                let mode = function.color.points_mut().map(|(i, _)| *i).unwrap_or_default();
                let (_, colors) = function.color.points_mut().unwrap();
                let opacity = &mut function.opacity;
                match *gesture {
                    Gesture::Insert(x) => {
                        let before = colors.as_slice().len();
                        let added = insert(colors, mode, x).is_some();
                        prop_assert_eq!(colors.as_slice().len(), before + usize::from(added));
                        with_curve(opacity.curves_mut().unwrap(), 0, |points| insert(points, mode, x));
                    }
                    Gesture::Move(i, x, y) => {
                        let count = colors.as_slice().len();
                        let moved = move_to(colors, i, x, [y, 1.0 - y, x]);
                        prop_assert_eq!(moved.is_some(), i < count);
                        prop_assert_eq!(moved, colors.as_slice().get(i).copied());
                        with_curve(opacity.curves_mut().unwrap(), i % 2, |points| move_to(points, i, x, y));
                    }
                    Gesture::Shift(ref indices, by, change) => {
                        let indices: BTreeSet<usize> = indices.iter().copied().collect();
                        let before = colors.positions();
                        let moved = shift(colors, &indices, by, |v| v.map(|c| c + change));
                        prop_assert!(moved.abs() <= by.abs() || by.is_nan());
                        for (i, (a, b)) in before.iter().zip(colors.positions()).enumerate() {
                            let by = if indices.contains(&i) { moved } else { 0.0 };
                            prop_assert!((b - a - by).abs() < 1e-12, "point {} of {:?}", i, gesture);
                        }
                        with_curve(opacity.curves_mut().unwrap(), 0, |p| shift(p, &indices, by, |v| v * change));
                    }
                    Gesture::Remove(i) => {
                        remove(colors, i);
                        with_curve(opacity.curves_mut().unwrap(), 0, |points| remove(points, i));
                    }
                    Gesture::Scale(factor, about) => {
                        scale(colors, factor, about);
                        scale_curves(opacity.curves_mut().unwrap(), factor);
                    }
                    Gesture::Curve(depth) => {
                        insert_curve(opacity, depth);
                    }
                    Gesture::MoveCurve(i, depth) => {
                        move_curve(opacity.curves_mut().unwrap(), i, depth);
                    }
                    Gesture::RemoveCurve(i) => {
                        remove(opacity.curves_mut().unwrap(), i);
                    }
                    Gesture::Mode(i) => {
                        let to = [Interpolation::Step, Interpolation::Linear, Interpolation::Monotone][usize::from(i)];
                        prop_assert!(function.color.set_interpolation(to));
                        prop_assert!(function.opacity.set_interpolation(Some(to), None));
                    }
                }
                let (_, colors) = function.color.points_mut().unwrap();
                prop_assert!(Points::new(colors.as_slice().to_vec()).is_ok(), "{:?}: {:?}", gesture, colors);
                let curves = function.opacity.curves_mut().unwrap();
                prop_assert!(Points::new(curves.as_slice().to_vec()).is_ok());
                for curve in curves.as_slice() {
                    prop_assert!(Points::new(curve.points.as_slice().to_vec()).is_ok(), "{:?}: {:?}", gesture, curve);
                }
            }
            let text = function.to_toml().unwrap();
            prop_assert_eq!(TransferFunction::from_toml(&text, "edited").unwrap(), function);
        }
    }
}
