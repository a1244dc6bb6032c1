//! When the tool counts as in contact.
//!
//! Two levels: a contact ([`Detector`]) is what an approach is there for, and ends by itself; a collision
//! ([`crate::collision`]) stops the robot.

mod cusum;

pub use cusum::Cusum;

use node::scenario;
use spatial::TICK_S;

/// The least detection threshold, in standard deviations of the noise: whatever compliance is assumed, noise is no
/// contact. Three false alarms in a million samples.
const ABOVE_NOISE: f64 = 4.5;

/// A threshold on the contact force along the normal, as the deflection *of the tcp* shows it, and a cumulative sum of
/// it beside.
///
/// In contact that deflection is geometric and immune to the tool's swing, and it carries a quarter of the noise
/// that the sensor's own force has. While the robot accelerates, the tool's inertia deflects the sensor too: the
/// threshold is raised by the force that the largest recent acceleration can cause, and the sum's allowance as well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detector {
    threshold_n: f64,
    /// The threshold that the noise asks for, N.
    least_n: f64,
    cusum: Option<Cusum>,
    apparent_mass_kg: f64,
    fading_s: f64,
    /// Largest recent acceleration, fading, m/s^2.
    envelope: f64,
}

impl Detector {
    /// A detector that fires above `threshold_n`, raised by `apparent_mass_kg` times the largest acceleration, which
    /// is forgotten within `fading_s`.
    pub fn new(threshold_n: f64, apparent_mass_kg: f64, fading_s: f64, cusum: Option<Cusum>) -> Self {
        Self {
            threshold_n,
            least_n: 0.0,
            cusum,
            apparent_mass_kg,
            fading_s,
            envelope: 0.0,
        }
    }

    /// What `controller` says, in a noise of `noise_n` (N rms along the normal).
    pub fn of(controller: &scenario::Controller, noise_n: f64) -> Self {
        let (adaptation, cusum) = (&controller.adaptation, &controller.cusum);
        // What the tool's inertia deflects looks like as much more force as the sensor is softer than assumed.
        let softer = if adaptation.enabled {
            adaptation.maximum_ratio
        } else {
            1.0
        };
        let tared = controller.tare_s / TICK_S;
        let sum = Cusum::new(cusum.allowance_n, noise_n, cusum.false_alarms_per_h, tared);
        let least_n = ABOVE_NOISE * noise_n;
        Self {
            least_n,
            ..Self::new(
                controller.detection_threshold_n.max(least_n),
                controller.apparent_mass_kg * softer,
                controller.detection_fading_s,
                cusum.enabled.then_some(sum),
            )
        }
    }

    /// Follow the acceleration (m/s^2) of the commanded motion over one cycle of `ticks`.
    pub fn follow(&mut self, acceleration: f64, ticks: i64) {
        let fading = libm::exp(-(ticks as f64) * TICK_S / self.fading_s);
        self.envelope = libm::fabs(acceleration).max(self.envelope * fading);
        if let Some(cusum) = &mut self.cusum {
            cusum.prepare();
        }
    }

    /// Fire above `threshold_n` (N) from now on, as far as the noise allows.
    pub fn set_threshold(&mut self, threshold_n: f64) {
        self.threshold_n = threshold_n.max(self.least_n);
    }

    /// Take the force (N) of the next sample; whether it is a contact, for a robot that is `looking` for one. Before, nothing
    /// adds up.
    pub fn take(&mut self, force_n: f64, looking: bool) -> bool {
        let (threshold_n, raised_n) = (self.threshold_n(), self.raised_n());
        let summed = match &mut self.cusum {
            Some(cusum) if looking => cusum.take(force_n, raised_n),
            Some(cusum) => {
                cusum.reset();
                false
            }
            None => false,
        };
        looking && (force_n > threshold_n || summed)
    }

    /// The threshold now, N.
    pub fn threshold_n(&self) -> f64 {
        self.threshold_n + self.raised_n()
    }

    /// The force (N) that the recent accelerations can cause.
    pub fn raised_n(&self) -> f64 {
        self.apparent_mass_kg * self.envelope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_rises_with_acceleration_and_comes_back() {
        let mut detector = Detector::new(0.8, 3.0, 0.05, None);
        detector.follow(-0.4, 4);
        assert!((detector.threshold_n() - 2.0).abs() < 1e-12);
        for _ in 0..250 {
            detector.follow(0.0, 4);
        }
        assert!((detector.threshold_n() - 0.8).abs() < 1e-6);
    }

    /// 0.45 N is never above the threshold of 0.82 N, and adds up to a contact after 5 samples: not while the robot
    /// accelerates, nor before it looks for one.
    #[test]
    fn what_stays_below_the_threshold_adds_up() {
        let mut detector = Detector::of(&scenario::Controller::default(), 0.16);
        assert!((0..100).all(|_| !detector.take(0.45, false)));
        detector.follow(0.1, 4);
        assert!((0..100).all(|_| !detector.take(0.45, true)));
        detector.follow(0.0, 1_000_000);
        assert_eq!((0..100).position(|_| detector.take(0.45, true)), Some(4));
        assert!(!detector.take(0.8, false) && detector.take(0.83, true));
    }

    /// 4.5 times 0.16 N are 0.72 N.
    #[test]
    fn no_threshold_is_below_the_noise() {
        let mut detector = Detector::of(&scenario::Controller::default(), 0.16);
        for (asked, found) in [(2.0, 2.0), (0.1, 0.72)] {
            detector.set_threshold(asked);
            assert!((detector.threshold_n() - found).abs() < 1e-12);
        }
    }
}
