//! When the tool counts as in contact.

use spatial::TICK_S;

/// A threshold on the contact force along the normal, as the deflection *of the tcp* shows it.
///
/// In contact that deflection is geometric and immune to the tool's swing, and it carries a quarter of the noise
/// that the sensor's own force has. While the robot accelerates, the tool's inertia deflects the sensor too: the
/// threshold is raised by the force that the largest recent acceleration can cause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detector {
    threshold_n: f64,
    apparent_mass_kg: f64,
    fading_s: f64,
    /// Largest recent acceleration, fading, m/s^2.
    envelope: f64,
}

impl Detector {
    /// A detector that fires above `threshold_n`, raised by `apparent_mass_kg` times the largest acceleration, which
    /// is forgotten within `fading_s`.
    pub fn new(threshold_n: f64, apparent_mass_kg: f64, fading_s: f64) -> Self {
        Self {
            threshold_n,
            apparent_mass_kg,
            fading_s,
            envelope: 0.0,
        }
    }

    /// Follow the acceleration (m/s^2) of the commanded motion over one cycle of `ticks`.
    pub fn follow(&mut self, acceleration: f64, ticks: i64) {
        let fading = libm::exp(-(ticks as f64) * TICK_S / self.fading_s);
        self.envelope = libm::fabs(acceleration).max(self.envelope * fading);
    }

    /// Fire above `threshold_n` (N) from now on.
    pub fn set_threshold(&mut self, threshold_n: f64) {
        self.threshold_n = threshold_n;
    }

    /// The threshold now, N.
    pub fn threshold_n(&self) -> f64 {
        self.threshold_n + self.apparent_mass_kg * self.envelope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_rises_with_acceleration_and_comes_back() {
        let mut detector = Detector::new(0.8, 3.0, 0.05);
        detector.follow(-0.4, 4);
        assert!((detector.threshold_n() - 2.0).abs() < 1e-12);
        for _ in 0..250 {
            detector.follow(0.0, 4);
        }
        assert!((detector.threshold_n() - 0.8).abs() < 1e-6);
    }
}
