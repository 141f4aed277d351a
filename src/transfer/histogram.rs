//! How many layers have which depth and |κ|: what stands behind the opacity editor.

/// Counts of (depth, |κ|), both over [0, 1].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Histogram2d {
    size: [usize; 2],
    counts: Vec<u64>,
    total: u64,
    left_out: u64,
}

/// More columns or rows are not made.
const MOST: usize = 4096;

impl Histogram2d {
    /// No counts yet: `size` columns over depth and rows over |κ|, each at least 1 and at most 4096.
    pub fn new(size: [usize; 2]) -> Histogram2d {
        let size = size.map(|n| n.clamp(1, MOST));
        Histogram2d { size, counts: vec![0; size[0] * size[1]], total: 0, left_out: 0 }
    }

    /// Counts all of `layers`, each (depth, κ).
    pub fn of(size: [usize; 2], layers: impl IntoIterator<Item = (f64, f64)>) -> Histogram2d {
        let mut histogram = Histogram2d::new(size);
        histogram.extend(layers);
        histogram
    }

    /// Counts one layer, at the nearest cell if it lies outside [0, 1]. A sign of κ does not count. A layer without a
    /// number for either is only counted as left out.
    pub fn add(&mut self, depth: f64, kappa: f64) {
        if depth.is_nan() || kappa.is_nan() {
            self.left_out += 1;
            return;
        }
        let cell = |v: f64, n: usize| ((v.clamp(0.0, 1.0) * n as f64) as usize).min(n - 1);
        let index = cell(kappa.abs(), self.size[1]) * self.size[0] + cell(depth, self.size[0]);
        self.counts[index] += 1;
        self.total += 1;
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Layers counted.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Layers without a depth or a curvature.
    pub fn left_out(&self) -> u64 {
        self.left_out
    }

    /// Layers in column `x` (depth) and row `y` (|κ|, from 0 upwards); 0 outside.
    pub fn count(&self, x: usize, y: usize) -> u64 {
        if x < self.size[0] && y < self.size[1] { self.counts[y * self.size[0] + x] } else { 0 }
    }

    /// Layers per column, over depth.
    pub fn over_depth(&self) -> Vec<u64> {
        (0..self.size[0]).map(|x| (0..self.size[1]).map(|y| self.count(x, y)).sum()).collect()
    }

    /// Layers per row, over |κ|.
    pub fn over_kappa(&self) -> Vec<u64> {
        self.counts.chunks(self.size[0]).map(|row| row.iter().sum()).collect()
    }

    /// A picture of the counts: rows from the top, the largest |κ| first, so that it lies behind a map of opacities.
    /// 0 where there is nothing, 255 at the largest count, between them by the logarithm of one more than the count;
    /// a single layer is never 0.
    pub fn log_image(&self) -> Vec<u8> {
        let most = self.counts.iter().copied().max().unwrap_or(0);
        let full = (most as f64).ln_1p();
        let level = |count: u64| match count {
            0 => 0,
            n => ((n as f64).ln_1p() / full * 255.0).round().clamp(1.0, 255.0) as u8,
        };
        self.counts.chunks(self.size[0]).rev().flatten().map(|n| level(*n)).collect()
    }
}

impl Extend<(f64, f64)> for Histogram2d {
    fn extend<I: IntoIterator<Item = (f64, f64)>>(&mut self, layers: I) {
        for (depth, kappa) in layers {
            self.add(depth, kappa);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_fall_into_their_cells() {
        let layers = [(0.0, 0.0), (0.1, -0.1), (1.0, -1.0), (9.0, 7.0), (0.6, 0.3), (f64::NAN, 0.0), (0.0, f64::NAN)];
        let h = Histogram2d::of([4, 2], layers);
        assert_eq!((h.size(), h.total(), h.left_out()), ([4, 2], 5, 2));
        assert_eq!((h.count(0, 0), h.count(3, 1), h.count(2, 0), h.count(9, 9)), (2, 2, 1, 0));
        assert_eq!((h.over_depth(), h.over_kappa()), (vec![2, 0, 1, 2], vec![3, 2]));
        // |κ| upwards: the upper row is the first. ln 2 / ln 3 · 255 = 160.9.
        assert_eq!(h.log_image(), [0, 0, 0, 255, 255, 0, 161, 0]);
    }

    #[test]
    fn an_empty_one_and_a_crowded_one_have_pictures() {
        assert_eq!(Histogram2d::new([0, 3]).log_image(), [0; 3]);
        let mut h = Histogram2d::of([2, 1], (0..100_000).map(|_| (0.0, 0.0)));
        h.add(1.0, f64::INFINITY);
        assert_eq!(h.log_image()[0], 255);
        assert!(h.log_image()[1] > 0, "one layer among many is seen");
    }
}
