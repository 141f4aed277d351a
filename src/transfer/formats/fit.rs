//! Smooth and stepped curves as straight pieces, with the largest error that this makes.
//!
//! Formats and control points know fewer curves than their sources do. Here a curve is halved until a straight piece
//! lies close enough at seven places; a jump becomes two points 1e-9 apart.

use super::super::points::{Interpolation, interpolate};
use crate::transfer::{
    ColorFunction, ColorPoint, ColorShape, ColorValue, OpacityCurve, OpacityFunction, OpacityPoint, OpacityShape,
    Points, TABLE_SIZE, TransferFunction,
};

/// How far a straight piece may be from a computed curve: an eighth of an 8-bit step.
pub(super) const TOLERANCE: f64 = 5e-4;
/// How far it may be from an image: an 8-bit step. Closer, and it follows the steps themselves.
const TOLERANCE_OF_IMAGES: f64 = 1.0 / 255.0;
/// Width of a piece that stands for a jump, in the units of its axis.
const JUMP: f64 = 1e-9;
/// Pieces narrower than this fraction of the range are not halved.
pub(super) const NARROWEST: f64 = 1.0 / 8192.0;

/// Points joined by straight lines.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fit<const N: usize> {
    /// Position and values.
    pub points: Vec<(f64, [f64; N])>,
    /// Largest distance, in any value, between the lines and what they follow, where it was looked at.
    pub error: f64,
}

impl<const N: usize> Fit<N> {
    /// No points yet.
    pub fn new() -> Fit<N> {
        Fit { points: Vec::new(), error: 0.0 }
    }

    /// Adds a point.
    pub fn push(&mut self, at: f64, values: [f64; N]) {
        self.points.push((at, values));
    }

    /// Adds the points behind `from`, up to `to`, that follow `curve`.
    pub fn follow(&mut self, curve: impl Fn(f64) -> [f64; N], [from, to]: [f64; 2], tolerance: f64, narrowest: f64) {
        let mut open = vec![(from, curve(from), to, curve(to))];
        while let Some((a, start, b, end)) = open.pop() {
            let mut worst = 0.0_f64;
            for i in 1..8 {
                let t = f64::from(i) / 8.0;
                let there = curve(a + (b - a) * t);
                for c in 0..N {
                    worst = worst.max((start[c] + (end[c] - start[c]) * t - there[c]).abs());
                }
            }
            if worst > tolerance && b - a > narrowest {
                let middle = a + (b - a) * 0.5;
                let there = curve(middle);
                open.push((middle, there, b, end));
                open.push((a, start, middle, there));
            } else {
                self.error = self.error.max(worst);
                self.push(b, end);
            }
        }
    }

    /// The value at `x`, constant beyond the ends.
    pub fn sample(&self, x: f64) -> [f64; N] {
        let next = self.points.partition_point(|p| p.0 <= x);
        match (next.checked_sub(1).and_then(|i| self.points.get(i)), self.points.get(next)) {
            (Some((a, start)), Some((b, end))) => {
                let t = (x - a) / (b - a);
                std::array::from_fn(|c| start[c] + (end[c] - start[c]) * t)
            }
            (Some((_, only)), None) | (None, Some((_, only))) => *only,
            (None, None) => [0.0; N],
        }
    }

    /// The same lines from the lower to the upper end of `ends`, which bound all positions.
    pub fn widened(mut self, ends: [f64; 2]) -> Fit<N> {
        if let Some(&(first, values)) = self.points.first()
            && first > ends[0]
        {
            self.points.insert(0, (ends[0], values));
        }
        if let Some(&(last, values)) = self.points.last()
            && last < ends[1]
        {
            self.push(ends[1], values);
        }
        self
    }
}

/// Points at `xs` with `mode` between them, as straight lines.
fn straight<const N: usize>(xs: &[f64], ys: &[[f64; N]], mode: Interpolation) -> Fit<N> {
    let mut fit = Fit::new();
    let channels: [Vec<f64>; N] = std::array::from_fn(|c| ys.iter().map(|y| y[c]).collect());
    for (i, (&x, &y)) in xs.iter().zip(ys).enumerate() {
        match (mode, i) {
            (_, 0) | (Interpolation::Linear, _) => fit.push(x, y),
            (Interpolation::Step, _) => {
                let before = x - JUMP;
                if before > xs[i - 1] && ys[i - 1] != y {
                    fit.push(before, ys[i - 1]);
                }
                fit.push(x, y);
            }
            (Interpolation::Monotone, _) => {
                let curve = |x: f64| std::array::from_fn(|c| interpolate(xs, &channels[c], mode, x));
                fit.follow(curve, [xs[i - 1], x], TOLERANCE, NARROWEST);
            }
        }
    }
    // Points that reading put into neighbouring numbers are set a little apart, so that no rounding joins them again.
    for i in 1..fit.points.len() {
        let apart = fit.points[i].0 - JUMP;
        let room = i < 2 || fit.points[i - 2].0 < apart;
        if room && fit.points[i - 1].0 > apart && apart >= xs[0] {
            fit.points[i - 1].0 = apart;
        }
    }
    fit
}

/// A colour function over κ as straight lines, from −1 to 1.
pub(super) fn color(function: &ColorFunction) -> Fit<3> {
    let fit = match &function.shape {
        ColorShape::Points { interpolation, points } => {
            let ys: Vec<[f64; 3]> = points.as_slice().iter().map(|p| p.color.0).collect();
            straight(&points.positions(), &ys, *interpolation)
        }
        ColorShape::Strip(raster) => {
            let pixels = raster.size().map_or(2, |[width, _]| width.max(2));
            let mut fit = Fit::new();
            for i in 0..pixels {
                let kappa = 2.0 * i as f64 / (pixels - 1) as f64 - 1.0;
                fit.push(kappa, function.sample(kappa));
            }
            fit
        }
    };
    fit.widened([-1.0, 1.0])
}

/// Opacity over |κ| at one depth as straight lines, from 0 to 1.
pub(super) fn opacity(function: &OpacityFunction, depth: f64) -> Fit<1> {
    let at = |kappa: f64| [function.sample(depth, kappa)];
    let fit = match &function.shape {
        OpacityShape::Curves { interpolation, curves, .. } => match curves.as_slice() {
            [curve] => {
                let ys: Vec<[f64; 1]> = curve.points.as_slice().iter().map(|p| [p.opacity]).collect();
                straight(&curve.points.positions(), &ys, *interpolation)
            }
            many => {
                // Between the places where any curve has a point, and just before them if curves jump there.
                let mut places: Vec<f64> = many.iter().flat_map(|c| c.points.positions()).chain([0.0, 1.0]).collect();
                if *interpolation == Interpolation::Step {
                    let before: Vec<f64> = places.iter().filter(|p| **p > JUMP).map(|p| p - JUMP).collect();
                    places.extend(before);
                }
                places.sort_by(f64::total_cmp);
                places.dedup();
                let mut fit = Fit::new();
                fit.push(0.0, at(0.0));
                for pair in places.windows(2) {
                    fit.follow(at, [pair[0], pair[1]], TOLERANCE, NARROWEST);
                }
                fit
            }
        },
        OpacityShape::Image(raster) => {
            let pixels = raster.size().map_or(2, |[_, height]| height.max(2));
            let mut fit = Fit::new();
            for i in 0..pixels {
                let kappa = i as f64 / (pixels - 1) as f64;
                fit.push(kappa, at(kappa));
            }
            fit
        }
    };
    fit.widened([0.0, 1.0])
}

impl TransferFunction {
    /// The same functions with control points in place of images, and the largest error that this makes in the baked
    /// tables: at most 1/255 for a strip and 2/255 for a map, which are steps of 8 bits. What has no image stays as it
    /// is. For editing, and for files that stand alone.
    ///
    /// An image that has not been loaded becomes what it samples as: neutral, and clear.
    pub fn without_images(&self) -> (TransferFunction, f64) {
        let mut function = self.clone();
        let (line, last) = (Interpolation::Linear, (TABLE_SIZE - 1) as f64);
        if let ColorShape::Strip(_) = self.color.shape {
            let table: Vec<[f64; 3]> =
                (0..TABLE_SIZE).map(|i| self.color.sample(2.0 * i as f64 / last - 1.0)).collect();
            let knots = corners(&table, TOLERANCE_OF_IMAGES);
            let points = knots.iter().map(|&i| (2.0 * i as f64 / last - 1.0, table[i])).collect();
            if let Some(points) = color_points(&Fit { points, error: 0.0 }) {
                function.color.shape = ColorShape::Points { interpolation: line, points };
            }
        }
        if let OpacityShape::Image(_) = self.opacity.shape {
            let table = self.opacity.bake();
            let columns: Vec<[f64; TABLE_SIZE]> =
                (0..TABLE_SIZE).map(|x| std::array::from_fn(|y| f64::from(table[y * TABLE_SIZE + x]))).collect();
            // One step for the choice of columns, one for the points on each.
            let curves = corners(&columns, TOLERANCE_OF_IMAGES).into_iter().filter_map(|x| {
                let values = columns[x].map(|v| [v]);
                let knots = corners(&values, TOLERANCE_OF_IMAGES);
                let points = knots.iter().map(|&y| (y as f64 / last, values[y])).collect();
                Some(OpacityCurve { depth: x as f64 / last, points: opacity_points(&Fit { points, error: 0.0 })? })
            });
            if let Ok(curves) = Points::new(curves.collect()) {
                function.opacity.shape =
                    OpacityShape::Curves { interpolation: line, depth_interpolation: line, curves };
            }
        }
        if function == *self {
            return (function, 0.0);
        }
        let (before, after) = (self.bake(), function.bake());
        let colors = before.color.iter().flatten().zip(after.color.iter().flatten());
        let all = colors.chain(before.opacity.iter().zip(&after.opacity));
        let error = all.fold(0.0_f32, |worst, (a, b)| worst.max((a - b).abs()));
        (function, f64::from(error))
    }
}

/// Which entries of a table to keep so that lines between them are within `tolerance` of all: the ends, and between two
/// that are kept the one farthest off, until none is (Ramer, Douglas, Peucker).
fn corners<const N: usize>(table: &[[f64; N]], tolerance: f64) -> Vec<usize> {
    let Some(last) = table.len().checked_sub(1) else {
        return Vec::new();
    };
    let (mut kept, mut open) = (vec![0], vec![(0, last)]);
    while let Some((a, b)) = open.pop() {
        let off = |i: usize| {
            let t = (i - a) as f64 / (b - a) as f64;
            (0..N).fold(0.0_f64, |worst, c| {
                worst.max((table[a][c] + (table[b][c] - table[a][c]) * t - table[i][c]).abs())
            })
        };
        let farthest = (a + 1..b).map(|i| (i, off(i))).max_by(|x, y| x.1.total_cmp(&y.1));
        match farthest {
            Some((i, distance)) if distance > tolerance => open.extend([(i, b), (a, i)]),
            _ if b > a => kept.push(b),
            _ => {}
        }
    }
    kept
}

/// The lines' points as control points, clamped to [0, 1]. `None` if there are none, or they are not over κ.
pub(super) fn color_points(fit: &Fit<3>) -> Option<Points<ColorPoint>> {
    let point = |&(kappa, v): &(f64, [f64; 3])| ColorPoint { kappa, color: ColorValue(v.map(|v| v.clamp(0.0, 1.0))) };
    Points::new(fit.points.iter().map(point).collect()).ok()
}

/// The lines' points as control points, clamped to [0, 1]. `None` if there are none, or they are not over |κ|.
pub(super) fn opacity_points(fit: &Fit<1>) -> Option<Points<OpacityPoint>> {
    let point = |&(kappa, [v]): &(f64, [f64; 1])| OpacityPoint { kappa, opacity: v.clamp(0.0, 1.0) };
    Points::new(fit.points.iter().map(point).collect()).ok()
}
