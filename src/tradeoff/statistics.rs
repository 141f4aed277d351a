//! Medians and how sure they are.
//!
//! Times of frames have long tails, so the median stands for them, with the percentile bootstrap's 95 % interval (Efron 1979):
//! the samples are drawn anew with replacement, and the interval holds the middle 95 % of the medians that result. It
//! cannot be wider than the samples, so fewer than [`ENOUGH`] cannot cover 95 % (the probability that all of n lie on one side of the
//! true median is 2^(1−n)); the number of samples belongs beside every interval.

use serde::Serialize;

/// Values from which on an interval can hold 95 %.
pub const ENOUGH: usize = 6;

/// Resamples behind an interval.
const RESAMPLES: usize = 2000;

/// A sequence of pseudo-random numbers that depends on the seed alone (SplitMix64, Steele 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number from 0 to below `end`, which is at least 1.
    pub fn below(&mut self, end: usize) -> usize {
        ((u128::from(self.bits()) * end as u128) >> 64) as usize
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Middle of the values; the mean of the two middle ones of an even number; `None` of none.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    median_of_sorted(&sorted)
}

fn median_of_sorted(sorted: &[f64]) -> Option<f64> {
    let n = sorted.len();
    let high = *sorted.get(n / 2)?;
    Some(if n % 2 == 1 { high } else { 0.5 * (sorted[n / 2 - 1] + high) })
}

/// The smallest value that at least the share `p` (0 to 1) of the values do not exceed (nearest rank); `None` of none.
pub fn percentile(values: &[f64], p: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (p.clamp(0.0, 1.0) * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

/// The exponent e of the power law y = c xᵉ through points of positive coordinates: least squares over their logarithms. `None`
/// if there are not two different x.
pub fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> =
        points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0).map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = logs.len() as f64;
    let (x, y) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let spread: f64 = logs.iter().map(|p| (p.0 - x).powi(2)).sum();
    let together: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (spread > 1e-12).then(|| together / spread)
}

/// A median with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The median.
    pub median: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
    /// Values that it was made of.
    pub count: usize,
}

/// The median of the values and its interval; `None` of none. The same values and seed give the same interval.
pub fn estimate(values: &[f64], seed: u64) -> Option<Estimate> {
    let median = median(values)?;
    let mut random = Random::new(seed);
    let mut sample = vec![0.0; values.len()];
    let medians: Vec<f64> = (0..RESAMPLES)
        .filter_map(|_| {
            sample.fill_with(|| values[random.below(values.len())]);
            sample.sort_by(f64::total_cmp);
            median_of_sorted(&sample)
        })
        .collect();
    let (low, high) = (percentile(&medians, 0.025)?, percentile(&medians, 0.975)?);
    Some(Estimate { median, low, high, count: values.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_is_that_of_the_power_law() {
        let law = |e: f64| [3.0_f64, 10.0, 55.0, 240.0].map(|x| (x, 0.7 * x.powf(e)));
        for e in [0.0, 0.9, 1.0, 2.5] {
            assert!((exponent(&law(e)).unwrap() - e).abs() < 1e-12);
        }
        // One of four measured twice as long as the law says: least squares follow it in part.
        let mut off = law(1.0);
        off[3].1 *= 2.0;
        let e = exponent(&off).unwrap();
        assert!(e > 1.1 && e < 1.3, "{e}");
        assert_eq!(exponent(&[(2.0, 1.0), (2.0, 3.0)]), None);
        assert_eq!(exponent(&[(0.0, 1.0), (2.0, 3.0)]), None);
        assert_eq!(exponent(&[]), None);
    }

    #[test]
    fn medians_and_percentiles_of_short_lists() {
        assert_eq!((median(&[]), percentile(&[], 0.5), estimate(&[], 1)), (None, None, None));
        assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 3.0])), (Some(2.0), Some(2.5)));
        let hundred: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(
            [0.0, 0.01, 0.95, 0.99, 1.0].map(|p| percentile(&hundred, p).unwrap()),
            [1.0, 1.0, 95.0, 99.0, 100.0]
        );
        let one = estimate(&[7.0], 1).unwrap();
        assert_eq!((one.low, one.median, one.high, one.count), (7.0, 7.0, 7.0, 1));
    }

    #[test]
    fn an_interval_depends_on_values_and_seed_alone() {
        let values = [3.0, 1.0, 4.0, 1.5, 9.0, 2.6];
        assert_eq!(estimate(&values, 5), estimate(&values, 5));
        let e = estimate(&values, 5).unwrap();
        assert!(e.low <= e.median && e.median <= e.high && e.low >= 1.0 && e.high <= 9.0);
    }

    /// Frame times as they are: a floor, and delays above it that fall off exponentially.
    #[test]
    fn the_interval_covers_the_true_median_in_simulation() {
        let mut random = Random::new(2016);
        for count in [9, 15, 30] {
            let trials = 600;
            let truth = 10.0 + std::f64::consts::LN_2;
            let covered = (0..trials)
                .filter(|&trial| {
                    let times: Vec<f64> = (0..count).map(|_| 10.0 - (1.0 - random.unit()).ln()).collect();
                    let e = estimate(&times, trial).unwrap();
                    e.low <= truth && truth <= e.high
                })
                .count();
            let share = covered as f64 / trials as f64;
            println!("{count} samples: {:.1} % covered", 100.0 * share);
            assert!((0.92..=0.985).contains(&share), "{count} samples: {share}");
        }
    }

    #[test]
    fn random_numbers_are_even() {
        let mut random = Random::new(1);
        let mut counts = [0_u32; 7];
        (0..70_000).for_each(|_| counts[random.below(7)] += 1);
        assert!(counts.iter().all(|c| c.abs_diff(10_000) < 400), "{counts:?}");
    }
}
