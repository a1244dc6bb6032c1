//! The cumulative sum of what exceeds an allowance: it finds what a threshold finds late, a force that grows slowly.

use spatial::TICK_S;

/// `S(k) = max(0, S(k-1) + f(k) - a)`, an alarm above h (Page's test, one-sided).
///
/// A force that grows by r per sample passes a threshold of n sigma after `n / r`, and the sum `a / r + sqrt(2 h / r)`
/// after the contact: below some mm/s the sum is first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cusum {
    /// a, N.
    allowance_n: f64,
    /// h, N.
    limit_n: f64,
    /// S, N.
    sum_n: f64,
}

/// The least allowance, in standard deviations of the noise: what is left of a swing after the acceleration envelope
/// must not add up.
const LEAST_ALLOWANCE: f64 = 1.5;

/// What the discrete sum overshoots its limit by, in standard deviations of the noise (Siegmund, Sequential Analysis,
/// 1985, section X.2).
const OVERSHOOT: f64 = 1.166;

impl Cusum {
    /// A sum that leaves out `allowance_n` (N) and, in white noise of `noise_n` (N rms), gives `false_alarms_per_h`.
    ///
    /// Siegmund's approximation of the mean number of samples between false alarms, with everything in standard deviations
    /// and `b = h + 1.166`: `(e^(2 a b) - 2 a b - 1) / (2 a^2)`. Made for small allowances: at 1.5 sigma, and with a zero
    /// that rests on 0.2 s of the same noise, there are 4.5 times as many (0.9 instead of 0.2 an hour, by
    /// `touchdown bench detection`).
    pub fn new(allowance_n: f64, noise_n: f64, false_alarms_per_h: f64) -> Self {
        let allowance_n = allowance_n.max(LEAST_ALLOWANCE * noise_n);
        let samples = 3600.0 / TICK_S / false_alarms_per_h;
        let limit_n = if noise_n > 0.0 {
            let a = allowance_n / noise_n;
            let wanted = 2.0 * a * a * samples;
            // x = ln(wanted + x + 1), which a few steps solve.
            let x = (0..20).fold(1.0, |x, _| libm::log(wanted + x + 1.0));
            (0.5 * x / a - OVERSHOOT) * noise_n
        } else {
            0.0
        };
        Self {
            allowance_n,
            // Where noise alone would allow it, still more than one sample's worth.
            limit_n: limit_n.max(allowance_n),
            sum_n: 0.0,
        }
    }

    /// Take the force (N) of one sample, which may be `raised_n` (N) too large; whether that is an alarm.
    pub fn take(&mut self, force_n: f64, raised_n: f64) -> bool {
        self.sum_n = (self.sum_n + force_n - self.allowance_n - raised_n).max(0.0);
        self.sum_n > self.limit_n
    }

    /// Forget what was added up.
    pub fn reset(&mut self) {
        self.sum_n = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// a = 0.25 N = 1.56 sigma, one false alarm in 5 h: `e^(2 a b) = 2 a^2 1.8e7`, b = 5.85 sigma, h = 0.75 N.
    #[test]
    fn the_limit_follows_from_the_false_alarms() {
        let cusum = Cusum::new(0.25, 0.16, 0.2);
        assert!((cusum.limit_n - 0.75).abs() < 0.01, "{cusum:?}");
        let noisy = Cusum::new(0.25, 1.6, 0.2);
        assert!((noisy.allowance_n - 2.4).abs() < 1e-12, "{noisy:?}");
        let silent = Cusum::new(0.25, 0.0, 0.2);
        assert_eq!((silent.allowance_n, silent.limit_n), (0.25, 0.25));
    }

    /// A ramp of 35 N/s (1 mm/s on 28 um/N): 0.25 / 0.035 and sqrt(2 0.75 / 0.035) samples, 14 instead of 24.
    #[test]
    fn a_slow_ramp_is_found_early() {
        let mut cusum = Cusum::new(0.25, 0.16, 0.2);
        let found = (0..).find(|&i| cusum.take(0.035 * f64::from(i), 0.0));
        assert!((13..16).contains(&found.unwrap()), "{found:?}");
        cusum.reset();
        assert!(!cusum.take(0.9, 0.0) && !cusum.take(5.0, 5.0));
    }
}
