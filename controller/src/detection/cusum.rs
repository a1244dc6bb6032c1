//! The cumulative sum of what exceeds an allowance: it finds what a threshold finds late, a force that grows slowly.

use nalgebra::{SMatrix, SVector};
use spatial::TICK_S;

/// `S(k) = max(0, S(k-1) + f(k) - a)`, an alarm above h (Page's test, one-sided).
///
/// A force that grows by r per sample passes a threshold of n sigma after `n / r`, and the sum `a / r + sqrt(2 h / r)`
/// after the contact: below some mm/s the sum is first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cusum {
    /// a, N.
    allowance_n: f64,
    /// Standard deviation of the noise, N.
    noise_n: f64,
    /// h as it is known.
    limit: Limit,
    /// S, N.
    sum_n: f64,
}

/// The least allowance, in standard deviations of the noise: what is left of a swing after the acceleration envelope
/// must not add up.
const LEAST_ALLOWANCE: f64 = 1.5;

/// Values of the sum that are told apart when its false alarms are counted.
const CELLS: usize = 32;

impl Cusum {
    /// A sum that leaves out `allowance_n` (N) and, in white noise of `noise_n` (N rms), gives `false_alarms_per_h` with a
    /// zero that is the mean of `tared` samples of the same noise.
    pub fn new(allowance_n: f64, noise_n: f64, false_alarms_per_h: f64, tared: f64) -> Self {
        let allowance_n = allowance_n.max(LEAST_ALLOWANCE * noise_n);
        let wanted = false_alarms_per_h * TICK_S / 3600.0;
        Self {
            allowance_n,
            noise_n,
            limit: Limit::new(allowance_n / noise_n, tared.max(10.0), wanted),
            sum_n: 0.0,
        }
    }

    /// Come closer to the limit, in a cycle before it is asked for: all at once costs five times as much as any other cycle.
    pub fn prepare(&mut self) {
        if self.noise_n > 0.0 {
            self.limit.improve();
        }
    }

    /// h, N.
    fn limit_n(&mut self) -> f64 {
        if self.noise_n > 0.0 {
            while self.limit.improve() {}
            // Where noise alone would allow it, still more than one sample's worth.
            (self.noise_n * self.limit.h).max(self.allowance_n)
        } else {
            self.allowance_n
        }
    }

    /// Take the force (N) of one sample, which may be `raised_n` (N) too large; whether that is an alarm.
    pub fn take(&mut self, force_n: f64, raised_n: f64) -> bool {
        self.sum_n = (self.sum_n + force_n - self.allowance_n - raised_n).max(0.0);
        self.sum_n > self.limit_n()
    }

    /// Forget what was added up.
    pub fn reset(&mut self) {
        self.sum_n = 0.0;
    }
}

/// The limit h, in standard deviations of the noise, that is passed in a share `wanted` of the samples, with an allowance
/// `a` (likewise), where zero and that deviation rest on `tared` samples. The logarithm of that share is nearly linear in h,
/// so that the secant method finds it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Limit {
    a: f64,
    tared: f64,
    wanted: f64,
    h: f64,
    /// Of the excess by h.
    slope: f64,
    /// The excess at h; `None`: not computed yet.
    excess: Option<f64>,
    /// Improvements that are left at most.
    left: usize,
}

impl Limit {
    fn new(a: f64, tared: f64, wanted: f64) -> Self {
        Self {
            a,
            tared,
            wanted,
            h: 3.0,
            slope: -2.0 * a,
            excess: None,
            left: 8,
        }
    }

    /// One step; whether it can still become better.
    fn improve(&mut self) -> bool {
        let Some(before) = self.excess else {
            self.excess = Some(self.excess_at(self.h));
            return true;
        };
        if self.left == 0 {
            return false;
        }
        let next = (self.h - before / self.slope).clamp(0.1, 50.0);
        if libm::fabs(next - self.h) < 1e-4 {
            self.left = 0;
            return false;
        }
        let now = self.excess_at(next);
        self.slope = (now - before) / (next - self.h);
        (self.h, self.excess) = (next, Some(now));
        self.left -= 1;
        true
    }

    /// The logarithm of how many times too often `h` is passed.
    fn excess_at(&self, h: f64) -> f64 {
        // Means over normal distributions by three points each (Gauss and Hermite): of the zero, and of the deviation.
        let off = libm::sqrt(3.0 / self.tared);
        let wider = 1.0 + libm::sqrt(1.5 / self.tared);
        let narrower = 2.0 - wider;
        let a = self.a;
        let by_zero = alarms(a - off, h) + alarms(a + off, h);
        let by_deviation = alarms(a / wider, h / wider) + alarms(a / narrower, h / narrower);
        libm::log((2.0 * alarms(a, h) + by_zero + by_deviation) / (6.0 * self.wanted))
    }
}

/// Share of the samples of white noise with standard deviation 1 at which a sum with the allowance `a` passes `h`.
///
/// The sum as a Markov chain over cells of width `w = 2 h / (2 m - 1)`, from whose lowest the mean number of steps to an
/// alarm follows by one linear system (Brook and Evans, Biometrika 59, 1972).
fn alarms(a: f64, h: f64) -> f64 {
    let w = 2.0 * h / (2 * CELLS - 1) as f64;
    let below = |x: f64| 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
    // Up to the upper end of a cell `ahead` cells higher, from CELLS lower on: what is asked for often, once.
    let up_to: [f64; 2 * CELLS] =
        std::array::from_fn(|ahead| below((ahead as f64 - CELLS as f64 + 0.5) * w + a));
    let chain = SMatrix::<f64, CELLS, CELLS>::from_fn(|i, j| {
        let ahead = CELLS + j - i;
        let share = match j {
            0 => up_to[ahead],
            _ => up_to[ahead] - up_to[ahead - 1],
        };
        f64::from(i == j) - share
    });
    let steps = chain.lu().solve(&SVector::<f64, CELLS>::repeat(1.0));
    // A sum that never passes.
    steps.map_or(f64::MIN_POSITIVE, |steps| 1.0 / steps[0].max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two-sided sums with a = 0.5 run for 465 samples on average with h = 5, and for 168 with h = 4 (Montgomery, Introduction
    /// to Statistical Quality Control, table of average run lengths); one side alone twice as long.
    #[test]
    fn the_chain_counts_as_the_tables_do() {
        for (h, samples) in [(5.0, 930.0), (4.0, 336.0)] {
            let found = 1.0 / alarms(0.5, h);
            assert!((found / samples - 1.0).abs() < 0.01, "{h}: {found}");
        }
    }

    /// Beyond the noise the larger, the fewer false alarms are wanted and the fewer samples zero rests on.
    #[test]
    fn the_limit_follows_from_the_false_alarms() {
        let [rarely, often, zeroed] = [(0.2, 200.0), (2.0, 200.0), (0.2, 1e9)]
            .map(|(per_h, tared)| Cusum::new(0.25, 0.16, per_h, tared).limit_n());
        assert!(
            often < rarely && zeroed < rarely,
            "{rarely} N, {often} N, {zeroed} N"
        );
        let share = alarms(0.25 / 0.16, zeroed / 0.16);
        assert!((share * 3.6e6 / 0.2 - 1.0).abs() < 0.01, "{share}");
        let noisy = Cusum::new(0.25, 1.6, 0.2, 200.0);
        assert!((noisy.allowance_n - 2.4).abs() < 1e-12, "{noisy:?}");
        let mut silent = Cusum::new(0.25, 0.0, 0.2, 200.0);
        assert_eq!((silent.allowance_n, silent.limit_n()), (0.25, 0.25));
    }

    /// Step by step as at once, within as many cycles as there are between tare and start at T = 4 ms.
    #[test]
    fn the_limit_is_there_before_it_is_asked_for() {
        let mut prepared = Cusum::new(0.25, 0.16, 0.2, 200.0);
        let mut at_once = prepared;
        for _ in 0..12 {
            prepared.prepare();
        }
        assert!(!prepared.limit.improve());
        assert_eq!(prepared.limit_n(), at_once.limit_n());
    }

    /// A ramp of 35 N/s (1 mm/s on 28 um/N): 0.25 / 0.035 and sqrt(2 0.75 / 0.035) samples, 14 instead of 24.
    #[test]
    fn a_slow_ramp_is_found_early() {
        let mut cusum = Cusum::new(0.25, 0.16, 0.2, 200.0);
        let found = (0..).find(|&i| cusum.take(0.035 * f64::from(i), 0.0));
        assert!((13..16).contains(&found.unwrap()), "{found:?}");
        cusum.reset();
        assert!(!cusum.take(0.9, 0.0) && !cusum.take(5.0, 5.0));
    }
}
