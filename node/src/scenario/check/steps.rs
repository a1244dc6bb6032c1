//! Integration steps that divide their whole and resolve the fastest motion of gears and tool.

use super::{Conflicts, short};
use crate::scenario::{Gears, Scenario};
use spatial::TICK_S;
use std::f64::consts::TAU;

/// Largest angle by which the fastest motion of the tool may advance in one integration step, rad; the classical
/// Runge-Kutta method becomes unstable at 2.8.
const STEP_ANGLE_RAD: f64 = 1.0;

/// Largest angle by which a gear's mode may advance in one integration step, rad. Free motors and coupled links are
/// faster than the mode with the motor locked: a tenth of what the method stands.
const GEAR_ANGLE_RAD: f64 = 0.28;

/// What the gears' modes depend on.
const GEARS_BY: &[&str] = &[
    "robot.integration_step_s",
    "robot.gears",
    "robot.gantry.gear_frequency_hz",
    "robot.arm.gear_frequency_hz",
];

/// What the fastest motion depends on.
const FASTEST_BY: &[&str] = &[
    "sensor.integration_step_s",
    "tool.mass_kg",
    "tool.inertia_kg_m2",
    "tool.centre_of_mass_in_s_m",
    "tool.tcp_in_s_m",
    "sensor.stiffness_n_per_m",
    "sensor.stiffness_nm_per_rad",
    "sensor.damping_ns_per_m",
    "sensor.damping_nms_per_rad",
    "sensor.end_stop_n_per_m",
    "sensor.end_stop_nm_per_rad",
    "object.indentation_n_per_m",
    "object.rebound_ratio",
    "object.friction",
    "object.friction_speed_m_per_s",
    "object.support_n_per_m",
    "object.support_ns_per_m",
    "object.support_mass_kg",
];

/// The same while nothing slides.
const SMOOTH_BY: &[&str] = &[
    "sensor.smooth_step_s",
    "tool.mass_kg",
    "tool.inertia_kg_m2",
    "tool.centre_of_mass_in_s_m",
    "tool.tcp_in_s_m",
    "sensor.stiffness_n_per_m",
    "sensor.stiffness_nm_per_rad",
    "sensor.damping_ns_per_m",
    "sensor.damping_nms_per_rad",
    "sensor.end_stop_n_per_m",
    "sensor.end_stop_nm_per_rad",
    "object.indentation_n_per_m",
    "object.rebound_ratio",
    "object.support_n_per_m",
    "object.support_ns_per_m",
    "object.support_mass_kg",
];

impl Scenario {
    pub(super) fn check_steps(&self, conflicts: &mut Conflicts) {
        let (robot, sensor) = (&self.robot, &self.sensor);
        let steps: [(&'static [&'static str], f64, f64, &str); 3] = [
            (
                &["robot.integration_step_s"],
                robot.integration_step_s,
                TICK_S,
                "the tick of",
            ),
            (
                &["sensor.smooth_step_s"],
                sensor.smooth_step_s,
                TICK_S,
                "the tick of",
            ),
            (
                &["sensor.integration_step_s", "sensor.smooth_step_s"],
                sensor.integration_step_s,
                sensor.smooth_step_s,
                "sensor.smooth_step_s,",
            ),
        ];
        for (key, step, whole, name) in steps {
            let count = whole / step;
            conflicts.require(
                count > 0.5 && (count - count.round()).abs() <= 1e-9 * count,
                key,
                format!(
                    "{} is {} s, no whole fraction of {name} {} s; choose that over a whole number, such as {} s",
                    key[0],
                    short(step),
                    short(whole),
                    short(whole / finer(count)),
                ),
            );
        }

        let swinging = match robot.gears {
            Gears::Rigid => 0.0,
            Gears::Elastic => robot.drives().gear_frequency_hz.max(),
        };
        conflicts.require(
            robot.integration_step_s * swinging * TAU <= GEAR_ANGLE_RAD,
            GEARS_BY,
            format!(
                "robot.integration_step_s is {} s, too long for gears that swing with up to {} Hz; choose at most {} s, \
                 or softer gears",
                short(robot.integration_step_s),
                short(swinging),
                short(GEAR_ANGLE_RAD / (swinging * TAU)),
            ),
        );

        let steps: [(&'static [&'static str], f64, f64); 2] = [
            (
                FASTEST_BY,
                sensor.integration_step_s,
                self.fastest_rad_per_s(true),
            ),
            (SMOOTH_BY, sensor.smooth_step_s, self.fastest_rad_per_s(false)),
        ];
        for (keys, step, fastest) in steps {
            conflicts.require(
                step * fastest <= STEP_ANGLE_RAD,
                keys,
                format!(
                    "{} is {} s, too long for a tool that moves at up to {} rad/s between sensor and object; choose \
                     at most {} s, a heavier tool, or less stiffness and damping",
                    keys[0],
                    short(step),
                    short(fastest),
                    short(STEP_ANGLE_RAD / fastest),
                ),
            );
        }
    }
}

/// The next number of steps per tick, from `count` on, that makes each a whole number of nanoseconds.
fn finer(count: f64) -> f64 {
    let mut counts = count.ceil() as u32..=1_000_000;
    counts
        .find(|count| 1_000_000 % count == 0)
        .map_or(count, f64::from)
}
