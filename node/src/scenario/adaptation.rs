//! The section `[controller.adaptation]`.

use super::check::Conflicts;
use super::{Scenario, schema};

schema::section! {
    /// The adaptation of the compliance in contact, from the deflection and a wrench measured independently of it.
    Adaptation at "controller.adaptation" {
        /// Whether the compliance is adapted.
        enabled: bool = false;
        /// Weight of a new sample (each ms) in the compliance.
        gain: f64 = 0.02, in 1e-5..=1.0;
        /// Time after the detected contact from which samples count.
        start_delay_s: f64 = 0.03, in 0.0..=10.0;
        /// Contact force above which a sample tells of the translational compliance.
        force_gate_n: f64 = 3.0, in 1e-3..=1e5;
        /// Contact moment at s above which a sample tells of the rotational compliance.
        moment_gate_nm: f64 = 0.2, in 1e-4..=1e4;
        /// Least multiple of the configured compliance.
        minimum_ratio: f64 = 0.3, in 0.01..=1.0;
        /// Largest multiple of the configured compliance.
        maximum_ratio: f64 = 3.5, in 1.0..=100.0;
    }
}

impl Scenario {
    pub(super) fn check_adaptation(&self, conflicts: &mut Conflicts) {
        conflicts.require(
            !self.controller.adaptation.enabled || self.sensor.wrench_measured,
            &["controller.adaptation.enabled", "sensor.wrench_measured"],
            "controller.adaptation.enabled is true, but the sensor measures no wrench, and the compliance can't be \
             learnt from the deflection alone; set sensor.wrench_measured = true or controller.adaptation.enabled = \
             false"
                .to_owned(),
        );
    }
}
