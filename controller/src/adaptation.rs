//! The sensor's compliance, adapted in contact from what is measured twice: the deflection and the wrench.
//!
//! Paper V uses "an adaptation scheme ... which has not been explained"; Model choice (PLANT.md section 7): normalised
//! least mean squares on one factor for each of the blocks C_p and C_phi, so that the configured C keeps its shape.
//!
//! Both inputs are *contact-only*: the deflection beyond its tare, and the wrench beyond its own. (3) and (4) are linear,
//! so that the tare drops out of both alike, and with it the biases. The tool's weight is in both inputs: what the
//! posture's tilt changes of it (0.1 N sideways at 4 kg and 2.5 mrad) deflects the sensor by C times that, and tells as
//! much about C as a contact force does. A wrench that was computed from the deflection would only give back the
//! compliance of that computation: its samples do not count.

use nalgebra::{Matrix3, Vector3};
use node::scenario;
use spatial::{Compliance, Deflection, Wrench};

/// The adapted compliance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptation {
    configured: Compliance,
    start_delay_s: f64,
    translation: Factor,
    rotation: Factor,
}

impl Adaptation {
    /// Nothing learnt yet: the `configured` compliance.
    pub fn new(parameters: &scenario::Adaptation, configured: Compliance) -> Self {
        let factor = |gate| Factor::new(parameters, gate);
        Self {
            configured,
            start_delay_s: parameters.start_delay_s,
            translation: factor(parameters.force_gate_n),
            rotation: factor(parameters.moment_gate_nm),
        }
    }

    /// Another `configured` compliance, of which the factors that are known are those of.
    pub fn configure(&mut self, configured: Compliance) {
        self.configured = configured;
    }

    /// Take one sample, `in_contact_s` s after the contact was detected: the contact-only deflection and the
    /// contact-only wrench that was measured independently of it, both at s, in s.
    ///
    /// The first samples after the impact are left out: the tool's inertia acts on the sensor there, and what its
    /// damping exerts is in the wrench alone.
    pub fn take(&mut self, in_contact_s: f64, deflection: &Deflection, wrench: &Wrench) {
        if in_contact_s >= self.start_delay_s {
            let Compliance {
                translation,
                rotation,
            } = &self.configured;
            self.translation
                .take(translation, &deflection.translation, &wrench.force);
            self.rotation.take(rotation, &deflection.rotation, &wrench.moment);
        }
    }

    /// The compliance as it is known now.
    pub fn compliance(&self) -> Compliance {
        Compliance {
            translation: self.configured.translation * self.translation.ratio,
            rotation: self.configured.rotation * self.rotation.ratio,
        }
    }

    /// From 0 (as configured, nothing learnt) to 1: how well the measurements since then support both blocks; that of
    /// the block known less. It tends to `1 - sum |s - C w|^2 / sum |s|^2`, the coefficient of determination of the
    /// recent samples.
    pub fn confidence(&self) -> f64 {
        self.translation.confidence().min(self.rotation.confidence())
    }
}

/// The factor from a configured block of C to the real one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Factor {
    gain: f64,
    gate: f64,
    minimum: f64,
    maximum: f64,
    ratio: f64,
    /// Share of the recent past's weights, 0 to 1, that samples have filled.
    excitation: f64,
    /// Recent mean of |s|^2, of those samples.
    measured: f64,
    /// Recent mean of |s - C w|^2.
    residual: f64,
}

impl Factor {
    fn new(parameters: &scenario::Adaptation, gate: f64) -> Self {
        Self {
            gain: parameters.gain,
            gate,
            minimum: parameters.minimum_ratio,
            maximum: parameters.maximum_ratio,
            ratio: 1.0,
            excitation: 0.0,
            measured: 0.0,
            residual: 0.0,
        }
    }

    /// One step of `k += g (s - k C w) . C w / (|C w|^2 + |C w_0|^2)` with w_0 of the gate's size along w, if w is
    /// beyond that gate.
    fn take(&mut self, configured: &Matrix3<f64>, yielded: &Vector3<f64>, load: &Vector3<f64>) {
        let square = load.norm_squared();
        let expected = configured * load;
        let error = yielded - expected * self.ratio;
        let gate = expected.norm_squared() * self.gate * self.gate / square;
        let step = self.gain * error.dot(&expected) / (expected.norm_squared() + gate);
        let (measured, residual) = (yielded.norm_squared(), error.norm_squared());
        // Numbers so large that their squares overflow tell nothing.
        let usable = [square, step, measured, residual].iter().all(|x| x.is_finite());
        if !usable || square <= self.gate * self.gate {
            return;
        }
        self.ratio = (self.ratio + step).clamp(self.minimum, self.maximum);
        self.excitation += self.gain * (1.0 - self.excitation);
        self.measured += self.gain * (measured - self.measured);
        self.residual += self.gain * (residual - self.residual);
    }

    fn confidence(&self) -> f64 {
        if self.measured > 0.0 {
            self.excitation * (1.0 - self.residual / self.measured).max(0.0)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn reference() -> Compliance {
        Compliance::isotropic(1.0 / 300e3, 1.0 / 401.07)
    }

    fn adaptation() -> Adaptation {
        Adaptation::new(&scenario::Adaptation::default(), reference())
    }

    fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
        [-limit..limit, -limit..limit, -limit..limit].prop_map(Vector3::from)
    }

    /// Any number at all, those at the ends of f64 included.
    fn wild() -> impl Strategy<Value = Vector3<f64>> {
        [any::<f64>(), any::<f64>(), any::<f64>()].prop_map(Vector3::from)
    }

    /// How far a block has been scaled.
    fn ratios(adaptation: &Adaptation) -> [f64; 2] {
        let (found, configured) = (adaptation.compliance(), reference());
        [
            found.translation[(0, 0)] / configured.translation[(0, 0)],
            found.rotation[(0, 0)] / configured.rotation[(0, 0)],
        ]
    }

    proptest! {
        /// 10 N at d = (0.10, 0, -0.15) m, with the noise of the reference sensor, for a second; the assumed C is
        /// wrong by 1/0.4 to 1/2.5.
        #[test]
        fn it_converges_to_the_true_compliance(
            truth in [0.4..2.5, 0.4..2.5], noise in proptest::collection::vec([vector(1.7), vector(1.7)], 1000)
        ) {
            let mut adaptation = adaptation();
            let wrench = Wrench { force: Vector3::new(0.0, 0.0, 10.0), moment: Vector3::new(0.0, -1.0, 0.0) };
            let real = Compliance {
                translation: reference().translation * truth[0],
                rotation: reference().rotation * truth[1],
            };
            for [of_deflection, of_wrench] in noise {
                let exact = real * wrench;
                let deflection = Deflection {
                    translation: exact.translation + of_deflection * 2e-6,
                    rotation: exact.rotation + of_deflection * 40e-6,
                };
                let measured = Wrench {
                    force: wrench.force + of_wrench * 0.2,
                    moment: wrench.moment + of_wrench * 0.005,
                };
                adaptation.take(1.0, &deflection, &measured);
            }
            let pairs: [(f64, f64); 2] = std::array::from_fn(|i| (ratios(&adaptation)[i], truth[i]));
            for (found, expected) in pairs {
                prop_assert!((found - expected).abs() < 0.03 * expected.max(1.0), "{found}, not {expected}");
            }
            prop_assert!(adaptation.confidence() > 0.9, "{}", adaptation.confidence());
        }

        #[test]
        fn it_stays_within_its_bounds_whatever_it_is_given(
            samples in proptest::collection::vec((wild(), wild(), wild(), wild()), 1..50)
        ) {
            let mut adaptation = adaptation();
            for (translation, rotation, force, moment) in samples {
                adaptation.take(1.0, &Deflection { translation, rotation }, &Wrench { force, moment });
                for ratio in ratios(&adaptation) {
                    prop_assert!((0.3 - 1e-12..=3.5 + 1e-12).contains(&ratio), "{ratio}");
                }
                prop_assert!((0.0..=1.0).contains(&adaptation.confidence()));
            }
        }

        /// Nothing moves below the gates of 3 N and 0.2 Nm, nor within 30 ms of the contact, whatever the deflection.
        #[test]
        fn without_excitation_it_does_not_move(
            p in vector(1e-3), phi in vector(0.02), weak in vector(0.1), strong in vector(100.0)
        ) {
            let mut adaptation = adaptation();
            let before = adaptation;
            let deflection = Deflection { translation: p, rotation: phi };
            adaptation.take(1.0, &deflection, &Wrench { force: weak * 17.0, moment: weak });
            adaptation.take(0.029, &deflection, &Wrench { force: strong, moment: strong });
            prop_assert_eq!(adaptation, before);
            prop_assert_eq!(adaptation.confidence(), 0.0);
        }
    }

    /// Beyond the bounds it stops at them, and says so by a lower confidence.
    #[test]
    fn it_stops_at_its_bounds() {
        let wrench = Wrench {
            force: Vector3::new(0.0, 0.0, 10.0),
            moment: Vector3::new(0.0, -1.0, 0.0),
        };
        for (factor, bound) in [(5.0, 3.5), (0.1, 0.3)] {
            let mut adaptation = adaptation();
            (0..1000).for_each(|_| adaptation.take(1.0, &(reference() * wrench * factor), &wrench));
            let ratios = ratios(&adaptation);
            assert!(
                ratios.iter().all(|ratio| (ratio - bound).abs() < 1e-12),
                "{ratios:?}"
            );
            assert!(adaptation.confidence() < 0.95, "{}", adaptation.confidence());
        }
    }

    /// A deflection that has nothing to do with the wrench earns no confidence.
    #[test]
    fn what_does_not_fit_is_not_trusted() {
        let mut adaptation = adaptation();
        let wrench = Wrench {
            force: Vector3::new(0.0, 0.0, 10.0),
            moment: Vector3::new(0.0, -1.0, 0.0),
        };
        let across = Deflection {
            translation: Vector3::new(30e-6, 0.0, 0.0),
            rotation: Vector3::new(2.5e-3, 0.0, 0.0),
        };
        (0..1000).for_each(|_| adaptation.take(1.0, &across, &wrench));
        assert!(adaptation.confidence() < 0.01, "{}", adaptation.confidence());
    }
}
