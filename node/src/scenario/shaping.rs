//! The section `[controller.shaping]`: how the free motion is shaped.

use super::check::{Conflicts, short};
use super::{Profile, Scenario, schema};
use spatial::kinematics::join;

schema::section! {
    /// How the speed of the free motion changes.
    Shaping at "controller.shaping" {
        /// How it changes: with steps of the acceleration, or such that neither tool nor gears swing.
        profile: Profile = Profile::Smooth;
        /// Largest acceleration of the tcp.
        acceleration_m_per_s2: f64 = 2.0, in 1e-3..=50.0;
        /// Largest swing of the tcp that a change of speed may leave, whatever its size: the less, the longer it takes.
        residual_m: f64 = 1e-6, in 1e-9..=1e-3;
        /// How wrong the assumed frequencies of tool and gears may be, as a share of them.
        mode_error: f64 = 0.1, in 0.0..=0.5;
    }
}

impl Scenario {
    /// The acceleration of the free motion against what the axes are assumed to attain.
    pub(super) fn check_shaping(&self, conflicts: &mut Conflicts) {
        let controller = &self.controller;
        let acceleration = controller.shaping.acceleration_m_per_s2;
        let Ok(start) = self.start_axes() else { return };
        let down = join([0.0, 0.0, -acceleration].into(), [0.0; 3].into());
        let jacobian = self.robot.kinematics().jacobian(&start);
        let changes = jacobian.lu().solve(&down).unwrap_or_default();
        for i in 0..6 {
            let [change, limit] = [changes[i].abs(), controller.acceleration_limit_rad_per_s2[i]];
            conflicts.require(
                change <= limit,
                &[
                    "controller.shaping.acceleration_m_per_s2",
                    "controller.acceleration_limit_rad_per_s2",
                ],
                format!(
                    "controller.shaping.acceleration_m_per_s2 is {} m/s^2 and accelerates axis {i} with {} rad/s^2, above \
                     controller.acceleration_limit_rad_per_s2[{i}], {} rad/s^2; accelerate less",
                    short(acceleration),
                    short(change),
                    short(limit),
                ),
            );
        }
    }
}
