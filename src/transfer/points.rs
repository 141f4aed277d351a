//! Control points along one axis, and what lies between them.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserializer, SeqAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};

/// What lies between control points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// The value of the last point at or before the place.
    Step,
    /// A straight line.
    Linear,
    /// A smooth cubic that never leaves the range of its two points (Fritsch and Butland's slopes). The default.
    #[default]
    Monotone,
}

/// Something that stands at a place on an axis.
pub trait ControlPoint {
    /// What the axis is called in error texts.
    const AXIS: &'static str;
    /// Where it stands.
    fn position(&self) -> f64;
    /// Why it is not allowed, if it is not.
    ///
    /// # Errors
    /// A sentence for the user.
    fn check(&self) -> Result<(), String>;
}

/// At least one control point, each allowed by itself, at strictly increasing positions.
///
/// The checks are made while reading, so that a text format's error carries the line of the point at fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Points<P>(Vec<P>);

impl<P: ControlPoint> Points<P> {
    /// Checks the points.
    ///
    /// # Errors
    /// A sentence for the user if there are none, one is not allowed, or two are out of order.
    pub fn new(points: Vec<P>) -> Result<Points<P>, String> {
        let mut last = None;
        for point in &points {
            follow(last, point)?;
            last = Some(point.position());
        }
        if points.is_empty() {
            return Err(no_points::<P>());
        }
        Ok(Points(points))
    }

    /// One point, known to be allowed.
    pub(super) fn one(point: P) -> Points<P> {
        Points(vec![point])
    }

    /// The points in order; never empty.
    pub fn as_slice(&self) -> &[P] {
        &self.0
    }

    /// Changes the points by a function that keeps what `Points` promises; where it did not, nothing is changed.
    pub(super) fn edit(&mut self, change: impl FnOnce(&mut Vec<P>))
    where
        P: Clone,
    {
        let mut changed = self.0.clone();
        change(&mut changed);
        if let Ok(sound) = Points::new(changed) {
            *self = sound;
        }
    }

    /// Positions of the points, strictly increasing.
    pub(super) fn positions(&self) -> Vec<f64> {
        self.0.iter().map(ControlPoint::position).collect()
    }
}

fn no_points<P: ControlPoint>() -> String {
    format!("there is no point; at least one over {} is needed", P::AXIS)
}

/// Checks a point by itself and against the position of the one before.
fn follow<P: ControlPoint>(last: Option<f64>, point: &P) -> Result<(), String> {
    point.check()?;
    let at = point.position();
    match last {
        Some(before) if at <= before => {
            Err(format!("{} = {at} follows {before}: points must stand in increasing order", P::AXIS))
        }
        _ => Ok(()),
    }
}

impl<P: Serialize> Serialize for Points<P> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de, P: ControlPoint + Deserialize<'de>> Deserialize<'de> for Points<P> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Points<P>, D::Error> {
        struct Sequence<P>(PhantomData<P>);
        impl<'de, P: ControlPoint + Deserialize<'de>> Visitor<'de> for Sequence<P> {
            type Value = Points<P>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "an array of points over {}", P::AXIS)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut array: A) -> Result<Points<P>, A::Error> {
                let mut points: Vec<P> = Vec::new();
                while let Some(point) =
                    array.next_element_seed(After { last: points.last().map(P::position), point: PhantomData })?
                {
                    points.push(point);
                }
                if points.is_empty() {
                    return Err(serde::de::Error::custom(no_points::<P>()));
                }
                Ok(Points(points))
            }
        }
        deserializer.deserialize_seq(Sequence(PhantomData))
    }
}

/// Reads one point that must stand after `last`. It asks for a newtype because a deserializer that knows spans puts
/// this element's on an error that comes from inside one.
struct After<P> {
    last: Option<f64>,
    point: PhantomData<P>,
}

impl<'de, P: ControlPoint + Deserialize<'de>> serde::de::DeserializeSeed<'de> for After<P> {
    type Value = P;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<P, D::Error> {
        deserializer.deserialize_newtype_struct("point", self)
    }
}

impl<'de, P: ControlPoint + Deserialize<'de>> Visitor<'de> for After<P> {
    type Value = P;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a point over {}", P::AXIS)
    }
    fn visit_newtype_struct<D: Deserializer<'de>>(self, deserializer: D) -> Result<P, D::Error> {
        let point = P::deserialize(deserializer)?;
        follow(self.last, &point).map_err(serde::de::Error::custom)?;
        Ok(point)
    }
}

/// Says why `value` is not a number in `[least, most]`.
///
/// # Errors
/// A sentence for the user.
pub(super) fn check_range(name: &str, value: f64, least: f64, most: f64) -> Result<(), String> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(format!("{name} = {value}: expected a number from {least} to {most}"))
    }
}

/// The value at `x` of the points (`xs[i]`, `ys[i]`), constant beyond both ends. `xs` increases strictly.
///
/// Where neighbouring values are equal the result is exactly that value, in every mode: whether a function is constant
/// can be read off its samples.
pub(super) fn interpolate(xs: &[f64], ys: &[f64], mode: Interpolation, x: f64) -> f64 {
    let count = xs.len().min(ys.len());
    between(xs, ys, mode, x, |j| slope(&xs[..count], &ys[..count], j))
}

/// [`interpolate`] for many places: what they have in common is computed once.
pub(super) struct Interpolant {
    xs: Vec<f64>,
    ys: Vec<f64>,
    /// Of the monotone cubic; none in other modes.
    slopes: Vec<f64>,
    mode: Interpolation,
}

impl Interpolant {
    /// As many positions as values.
    pub(super) fn new(mut xs: Vec<f64>, mut ys: Vec<f64>, mode: Interpolation) -> Interpolant {
        let count = xs.len().min(ys.len());
        xs.truncate(count);
        ys.truncate(count);
        let has_slopes = mode == Interpolation::Monotone && count > 1;
        let slopes = if has_slopes { (0..count).map(|j| slope(&xs, &ys, j)).collect() } else { Vec::new() };
        Interpolant { xs, ys, slopes, mode }
    }

    /// The value at `x`.
    pub(super) fn at(&self, x: f64) -> f64 {
        between(&self.xs, &self.ys, self.mode, x, |j| self.slopes.get(j).copied().unwrap_or_default())
    }
}

/// The value at `x` with these slopes at the points.
fn between(xs: &[f64], ys: &[f64], mode: Interpolation, x: f64, slope: impl Fn(usize) -> f64) -> f64 {
    let count = xs.len().min(ys.len());
    if count == 0 {
        return 0.0;
    }
    // The first point behind `x`; NaN is behind none and reads as the lower end.
    let next = if x.is_nan() { 0 } else { xs[..count].partition_point(|&p| p <= x) };
    if next == 0 {
        return ys[0];
    }
    if next == count {
        return ys[count - 1];
    }
    let i = next - 1;
    let width = xs[next] - xs[i];
    let t = (x - xs[i]) / width;
    let rise = ys[next] - ys[i];
    match mode {
        Interpolation::Step => ys[i],
        Interpolation::Linear => ys[i] + rise * t,
        Interpolation::Monotone => {
            let [start, end] = [i, next].map(|j| slope(j) * width);
            let s = 1.0 - t;
            let y = ys[i] + rise * (t * t * (3.0 - 2.0 * t)) + t * s * (s * start - t * end);
            // The curve stays between its points; this removes what rounding adds.
            y.clamp(ys[i].min(ys[next]), ys[i].max(ys[next]))
        }
    }
}

/// Slope of the monotone cubic at point `j`: 0 at an extremum, else the weighted harmonic mean of the two secants,
/// which is at most three times the smaller; at an end the only secant. All lie in Fritsch and Carlson's region.
fn slope(xs: &[f64], ys: &[f64], j: usize) -> f64 {
    let secant = |i: usize| (ys[i + 1] - ys[i]) / (xs[i + 1] - xs[i]);
    if j == 0 {
        return secant(0);
    }
    if j + 1 == xs.len() {
        return secant(j - 1);
    }
    let (before, behind) = (secant(j - 1), secant(j));
    if before * behind <= 0.0 {
        return 0.0;
    }
    let (h0, h1) = (xs[j] - xs[j - 1], xs[j + 1] - xs[j]);
    let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
    (w0 + w1) / (w0 / before + w1 / behind)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_mode_passes_through_its_points_and_holds_its_ends() {
        let (xs, ys) = ([-1.0, 0.0, 0.25, 1.0], [0.9, 0.5, 0.5, 0.1]);
        for mode in [Interpolation::Step, Interpolation::Linear, Interpolation::Monotone] {
            for (x, y) in xs.iter().zip(ys) {
                assert_eq!(interpolate(&xs, &ys, mode, *x), y, "{mode:?} at {x}");
            }
            assert_eq!(interpolate(&xs, &ys, mode, -9.0), 0.9);
            assert_eq!(interpolate(&xs, &ys, mode, 9.0), 0.1);
            assert_eq!(interpolate(&xs, &ys, mode, 0.1), 0.5, "{mode:?}: equal points give exactly their value");
            let many = Interpolant::new(xs.to_vec(), ys.to_vec(), mode);
            for x in (-12..=12).map(|i| f64::from(i) * 0.1).chain([f64::NAN, 0.25]) {
                assert_eq!(many.at(x), interpolate(&xs, &ys, mode, x), "{mode:?} at {x}: bit for bit the same");
            }
        }
        assert_eq!(interpolate(&xs, &ys, Interpolation::Step, -0.01), 0.9);
        assert!((interpolate(&xs, &ys, Interpolation::Linear, -0.5) - 0.7).abs() < 1e-15);
        assert_eq!(interpolate(&xs, &ys, Interpolation::Linear, f64::NAN), 0.9);
    }

    /// A cubic through the same points with central differences leaves [0, 1] here.
    #[test]
    fn the_monotone_cubic_is_flat_where_catmull_rom_overshoots() {
        let (xs, ys) = ([0.0, 0.5, 0.6, 1.0], [0.0, 0.0, 1.0, 1.0]);
        for i in 0..=1000 {
            let y = interpolate(&xs, &ys, Interpolation::Monotone, f64::from(i) / 1000.0);
            assert!((0.0..=1.0).contains(&y), "{y}");
        }
        let (t, tangents) = (0.9_f64, [(1.0 - 0.0) / 0.6 * 0.1, (1.0 - 0.0) / 0.5 * 0.1]);
        let s = 1.0 - t;
        let central = t * t * (3.0 - 2.0 * t) + t * s * (s * tangents[0] - t * tangents[1]);
        let ours = interpolate(&xs, &ys, Interpolation::Monotone, 0.59);
        assert!(ours <= 1.0 && (ours - central).abs() > 1e-3, "{ours} {central}");
    }

    proptest! {
        #[test]
        fn the_monotone_cubic_never_overshoots_and_never_turns_back(
            steps in prop::collection::vec((1e-3..1.0_f64, 0.0..1.0_f64), 2..8),
        ) {
            let mut x = 0.0;
            let xs: Vec<f64> = steps.iter().map(|s| { x += s.0; x }).collect();
            let ys: Vec<f64> = steps.iter().map(|s| s.1).collect();
            for i in 0..xs.len() - 1 {
                let rising = ys[i + 1] >= ys[i];
                let mut last = ys[i];
                for j in 0..=64 {
                    let at = xs[i] + (xs[i + 1] - xs[i]) * f64::from(j) / 64.0;
                    let y = interpolate(&xs, &ys, Interpolation::Monotone, at);
                    prop_assert!(y >= ys[i].min(ys[i + 1]) && y <= ys[i].max(ys[i + 1]));
                    let forward = if rising { y - last } else { last - y };
                    prop_assert!(forward >= -1e-12);
                    last = y;
                }
            }
        }
    }
}
