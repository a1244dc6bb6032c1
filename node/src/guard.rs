//! Which commands a robot can execute, and why not the others: pure.

use crate::robot_states::Verdict;
use crate::scenario::{Drives, Scenario};
use spatial::TICK_S;
use spatial::kinematics::Axes;
use spatial::ports::{Check, Command, Fault};

/// How far set-points may exceed an axis's velocity limit: the command filter keeps to the limit and catches up with
/// a short excess. Model choice: twice; beyond that a command is a mistake.
const EXCESS: f64 = 2.0;

/// What the axes can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guard {
    drives: Drives,
    period_s: f64,
}

/// How far a set-point may lie from where the robot stands without asking for motion, rad.
const STAY_RAD: f64 = 1e-3;

impl Guard {
    /// The guard of a scenario's robot.
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            drives: scenario.robot.drives(),
            period_s: scenario.timing.command_period_ticks as f64 * TICK_S,
        }
    }

    /// What `command` asks for: whether all its set-points, the first one following `previous` (rad), can be executed.
    pub fn judge(&self, previous: &Axes, command: &Command) -> Verdict {
        if command.check().is_err() {
            let finite = |axis: &usize| command.axis_position.iter().all(|s| s[*axis].is_finite());
            let axis = (0..6).find(|axis| !finite(axis)).unwrap_or_default();
            return refused(Fault::CommandInvalid, axis);
        }
        let (mut previous, first) = (*previous, *previous);
        let mut stays = true;
        for setpoint in &command.axis_position {
            for axis in 0..6 {
                let range = self.drives.axis_minimum_rad[axis]..=self.drives.axis_maximum_rad[axis];
                if !range.contains(&setpoint[axis]) {
                    return refused(Fault::AxisLimit, axis);
                }
                let speed = libm::fabs(setpoint[axis] - previous[axis]) / self.period_s;
                if speed > EXCESS * self.drives.velocity_limit_rad_per_s[axis] {
                    return refused(Fault::VelocityLimit, axis);
                }
                stays &= libm::fabs(setpoint[axis] - first[axis]) < STAY_RAD;
            }
            previous = *setpoint;
        }
        if stays { Verdict::Stay } else { Verdict::Move }
    }
}

fn refused(fault: Fault, axis: usize) -> Verdict {
    Verdict::Refused(fault, axis as i32)
}
