//! Whether the contact force oscillates and grows, and how far the law's gain is lowered for it.
//!
//! A loop whose assumptions are wrong by too much (compliance, delay, gears) swings up in contact. Half-waves that grow,
//! one after the other, tell it from the ringing after an impact, which dies out, and from an object that shakes, which
//! does not grow for long.

use node::scenario;
use spatial::TICK_S;
use spatial::ports::Law;

/// Time constant of the mean about which the force oscillates, s: several periods of what swings up here.
const MEAN_S: f64 = 0.1;
/// Half-waves that are remembered.
const HALF_WAVES: usize = 5;
/// Growth from half-wave to half-wave that counts when it happens twice, and when it happens each time.
const FAST: f64 = 1.25;
const SLOW: f64 = 1.02;
/// What does not shrink by more than that over all half-waves, and is larger than half the desired force, is a limit
/// cycle: the tool leaves the object and comes back.
const LASTS: f64 = 0.8;
/// Share of the least amplitude beyond the mean at which a half-wave begins: noise begins none.
const BEGINS: f64 = 0.25;

/// Watches the error of the normal force, sample by sample, while a law acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OscillationObserver {
    enabled: bool,
    least_n: f64,
    least_gain: f64,
    /// `None`: nothing seen yet.
    mean_n: Option<f64>,
    /// The side of the mean that the present half-wave is on, 1 or -1; 0: none yet.
    side: f64,
    /// Its largest distance from the mean so far, N.
    peak_n: f64,
    /// Amplitudes of the half-waves before, the newest first, N.
    amplitudes: [f64; HALF_WAVES],
    gain: f64,
}

impl OscillationObserver {
    /// With what `controller` says; the gain is whole. That of a peer's law stays so: it is shown as it is published.
    pub fn new(controller: &scenario::Controller) -> Self {
        let parameters = &controller.oscillation;
        Self {
            enabled: parameters.enabled && !matches!(controller.law, Law::Ros2 | Law::Fzi),
            least_n: parameters.least_n,
            least_gain: parameters.least_gain,
            mean_n: None,
            side: 0.0,
            peak_n: 0.0,
            amplitudes: [0.0; HALF_WAVES],
            gain: 1.0,
        }
    }

    /// Take the force's error (N) of the next sample, with `desired_n` (N) sought; lowers the gain by half where it
    /// swings up.
    pub fn take(&mut self, error_n: f64, desired_n: f64) {
        let mean = self.mean_n.unwrap_or(error_n);
        let mean = mean + (error_n - mean) * (TICK_S / MEAN_S);
        self.mean_n = Some(mean);
        let off = error_n - mean;
        if off * self.side < 0.0 && libm::fabs(off) > BEGINS * self.least_n {
            self.amplitudes.rotate_right(1);
            self.amplitudes[0] = self.peak_n;
            (self.side, self.peak_n) = (off.signum(), 0.0);
            if self.enabled && (self.grows() || self.lasts(0.5 * libm::fabs(desired_n))) {
                self.gain = (0.5 * self.gain).max(self.least_gain);
                // What follows is judged by itself.
                self.forget();
            }
        } else if self.side == 0.0 && libm::fabs(off) > BEGINS * self.least_n {
            self.side = off.signum();
        }
        self.peak_n = self.peak_n.max(off * self.side);
    }

    /// Another contact: what was seen before is none of its oscillation. The gain stays as it is.
    pub fn forget(&mut self) {
        (self.mean_n, self.side, self.peak_n) = (None, 0.0, 0.0);
        self.amplitudes = [0.0; HALF_WAVES];
    }

    /// The whole gain again.
    pub fn restore(&mut self) {
        self.forget();
        self.gain = 1.0;
    }

    /// Factor for the law's gain, 1 or less.
    pub fn gain(&self) -> f64 {
        self.gain
    }

    /// Amplitude of the newest whole half-wave, N; 0: below the least amplitude.
    pub fn amplitude_n(&self) -> f64 {
        let newest = self.amplitudes[0];
        if newest >= self.least_n { newest } else { 0.0 }
    }

    fn lasts(&self, large_n: f64) -> bool {
        let [newest, .., oldest] = self.amplitudes;
        let least_n = large_n.max(self.least_n);
        self.amplitudes.iter().all(|it| *it > least_n) && newest > LASTS * oldest
    }

    fn grows(&self) -> bool {
        let [newest, .., oldest] = self.amplitudes;
        let by = |factor: f64, times: usize| {
            let mut pairs = self.amplitudes.windows(2).take(times);
            pairs.all(|pair| pair[1] > 0.0 && pair[0] > factor * pair[1])
        };
        newest >= self.least_n && (by(FAST, 2) || oldest > 0.0 && by(SLOW, HALF_WAVES - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// The gain after 1 s of an oscillation of 15 Hz whose amplitude `amplitude` tells at each time.
    fn gain(offset_n: f64, amplitude: impl Fn(f64) -> f64) -> f64 {
        let mut observer = OscillationObserver::new(&scenario::Controller::default());
        for i in 0..1000 {
            let time = f64::from(i) * TICK_S;
            observer.take(offset_n + amplitude(time) * libm::sin(TAU * 15.0 * time), 20.0);
        }
        observer.gain()
    }

    #[test]
    fn only_what_grows_lowers_the_gain() {
        assert!(gain(0.0, |t| 0.5 * libm::exp(3.0 * t)) < 1.0);
        assert!(gain(-3.0, |t| 0.1 * libm::exp(12.0 * t)) < 1.0);
        for offset in [0.0, 10.0] {
            assert_eq!(gain(offset, |_| 6.0), 1.0);
            assert_eq!(gain(offset, |t| 15.0 * libm::exp(-3.0 * t)), 1.0);
        }
        // A limit cycle of more than half of 20 N.
        assert!(gain(0.0, |_| 12.0) < 1.0);
        // Below 2 N nothing counts.
        assert_eq!(gain(0.0, |t| 0.1 * libm::exp(2.5 * t)), 1.0);
    }

    #[test]
    fn the_gain_is_halved_as_often_as_it_must_be_and_restored() {
        let mut observer = OscillationObserver::new(&scenario::Controller::default());
        let mut seen = Vec::new();
        for i in 0..2000 {
            let time = f64::from(i) * TICK_S;
            observer.take(0.5 * libm::exp(4.0 * time) * libm::sin(TAU * 15.0 * time), 10.0);
            seen.push(observer.gain());
        }
        seen.dedup();
        assert_eq!(seen[..3], [1.0, 0.5, 0.25]);
        assert_eq!(seen.last(), Some(&0.03125));
        assert!(observer.amplitude_n() > 2.0);
        observer.restore();
        assert_eq!((observer.gain(), observer.amplitude_n()), (1.0, 0.0));
    }
}
