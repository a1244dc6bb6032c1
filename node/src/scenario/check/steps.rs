//! Integration steps that divide their whole and resolve the fastest motion of gears and tool.

use super::{Conflicts, short};
use crate::scenario::{Gears, Kinematics, Scenario};
use spatial::TICK_S;
use std::f64::consts::TAU;

/// Largest angle by which the fastest motion of the tool may advance in one integration step, rad; the classical
/// Runge-Kutta method becomes unstable at 2.8.
const STEP_ANGLE_RAD: f64 = 1.0;

/// Largest angle by which a gear's mode may advance in one integration step, rad. Free motors and coupled links are
/// faster than the mode with the motor locked: a tenth of what the method stands.
const GEAR_ANGLE_RAD: f64 = 0.28;

/// The same of a motor that swings against the links of a gantry: half of what the method stands.
const FREE_ANGLE_RAD: f64 = 1.4;

/// What that depends on.
const FREE_BY: &[&str] = &[
    "robot.integration_step_s",
    "robot.gears",
    "robot.gantry.gear_frequency_hz",
    "robot.gantry.motor_inertia_kg_m2",
    "robot.gantry.link_inertia_kg_m2",
];

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

impl Scenario {
    pub(super) fn check_steps(&self, conflicts: &mut Conflicts) {
        let (robot, sensor) = (&self.robot, &self.sensor);
        let steps: [(&'static [&'static str], f64); 2] = [
            (&["robot.integration_step_s"], robot.integration_step_s),
            (&["sensor.smooth_step_s"], sensor.smooth_step_s),
        ];
        for (key, step) in steps {
            let count = TICK_S / step;
            conflicts.require(
                count > 0.5 && (count - count.round()).abs() <= 1e-9 * count,
                key,
                format!(
                    "{} is {} s, no whole fraction of the tick of {} s; choose that over a whole number, such as {} s",
                    key[0],
                    short(step),
                    short(TICK_S),
                    short(TICK_S / finer(count)),
                ),
            );
        }
        conflicts.require(
            sensor.integration_step_s <= sensor.smooth_step_s,
            &["sensor.integration_step_s", "sensor.smooth_step_s"],
            format!(
                "sensor.integration_step_s is {} s, longer than sensor.smooth_step_s, {} s, which is halved until it \
                 is at most that; choose a shorter one",
                short(sensor.integration_step_s),
                short(sensor.smooth_step_s),
            ),
        );

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

        let free = self.free_gears_hz();
        let told = robot.integration_step_s * swinging * TAU > GEAR_ANGLE_RAD;
        conflicts.require(
            told || robot.integration_step_s * free * TAU <= FREE_ANGLE_RAD,
            FREE_BY,
            format!(
                "robot.integration_step_s is {} s, too long for motors that swing against the gantry's links with up to {} \
                 Hz; choose at most {} s, heavier motors, or softer gears",
                short(robot.integration_step_s),
                short(free),
                short(FREE_ANGLE_RAD / (free * TAU)),
            ),
        );

        let fastest = self.fastest_rad_per_s();
        conflicts.require(
            sensor.integration_step_s * fastest <= STEP_ANGLE_RAD,
            FASTEST_BY,
            format!(
                "sensor.integration_step_s is {} s, too long for a tool that moves at up to {} rad/s between sensor and \
                 object; choose at most {} s, a heavier tool, or less stiffness and damping",
                short(sensor.integration_step_s),
                short(fastest),
                short(STEP_ANGLE_RAD / fastest),
            ),
        );
    }
}

impl Scenario {
    /// How fast a motor of a gantry with elastic gears swings against its link, Hz; 0: there is none. An arm's links depend on
    /// its posture; its motors have a least inertia.
    fn free_gears_hz(&self) -> f64 {
        match (self.robot.gears, self.robot.kinematics) {
            (Gears::Elastic, Kinematics::Gantry) => {
                let gantry = &self.robot.gantry;
                let free = |i: usize| {
                    let ratio = gantry.link_inertia_kg_m2[i] / gantry.motor_inertia_kg_m2[i];
                    gantry.gear_frequency_hz[i] * (1.0 + ratio).sqrt()
                };
                (0..6).map(free).fold(0.0, f64::max)
            }
            _ => 0.0,
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
