//! Whether the sensor still shows zero force where there is none.

use spatial::TICK_S;

/// Follows the force that is shown before contact, where it should be zero since the tare, and compares its slow part
/// with a limit.
///
/// Model choice: a first-order low pass. The reference sensor's noise (0.16 N) leaves 5 mN of sigma behind it, and the
/// start of an approach v m / tau, 60 mN at 20 mm/s and 1.5 kg. In contact nothing can be said of the drift: the last
/// finding stands, since a force measured against a tare that has drifted is wrong by the drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriftWatch {
    limit_n: f64,
    drift_n: f64,
}

/// Time constant of the low pass, s.
const TIME_CONSTANT_S: f64 = 0.5;

impl DriftWatch {
    /// No drift yet; it must stay below `limit_n` (N) along the contact's normal.
    pub fn new(limit_n: f64) -> Self {
        Self {
            limit_n,
            drift_n: 0.0,
        }
    }

    /// The same limit, and no drift yet.
    pub fn anew(&self) -> Self {
        Self::new(self.limit_n)
    }

    /// Take the force (N) along the normal that one sample, a tick after the last, shows without contact.
    pub fn take(&mut self, force_n: f64) {
        let weight = TICK_S / TIME_CONSTANT_S;
        self.drift_n += weight * (force_n - self.drift_n);
    }

    /// The slow part of that force, N.
    pub fn drift_n(&self) -> f64 {
        self.drift_n
    }

    /// Whether it is beyond the limit.
    pub fn exceeds(&self) -> bool {
        self.drift_n.abs() > self.limit_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_force_is_drift_and_a_swing_is_not() {
        let mut watch = DriftWatch::new(0.4);
        // 1 N of swing at 17 Hz.
        for tick in 0..3000 {
            watch.take(libm::sin(std::f64::consts::TAU * 17.0 * f64::from(tick) * TICK_S));
            assert!(!watch.exceeds(), "{} N at tick {tick}", watch.drift_n());
        }
        // A ramp of 0.1 N/s, which the low pass follows 0.5 s late: 0.4 N after 4.5 s.
        let drifting = |watch: &mut DriftWatch, sign: f64| {
            (0..10_000).position(|tick| {
                watch.take(sign * 0.1 * f64::from(tick) * TICK_S);
                watch.exceeds()
            })
        };
        for sign in [1.0, -1.0] {
            let found = drifting(&mut DriftWatch::new(0.4), sign);
            assert!(
                found.is_some_and(|tick| (4490..4510).contains(&tick)),
                "{found:?}"
            );
        }
    }
}
