//! `ROBOT_STATE`: what the encoders read.

use super::{Authenticity, Check, Fault, Invalid, Stamp, finite, in_range, wire_enum};
use crate::kinematics::Axes;

/// Encoder samples in one message, one tick apart.
pub const ENCODER_SAMPLES: usize = 8;

wire_enum! {
    /// State of the robot (DESIGN.md section 6).
    RobotMode {
        /// Waiting for an enabled command.
        #[default]
        Idle = 0,
        /// Counting good commands.
        Armed = 1,
        /// Executing commands.
        Following = 2,
        /// Commands are missing; following the last one's horizon.
        Bridging = 3,
        /// Coming to rest with the robot's own deceleration.
        Braking = 4,
        /// At rest, first cause latched.
        Fault = 5,
    }
}

/// The controller's latest send stamp, echoed so that it can measure clock offset and round trip. Zero: none yet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClockEcho {
    /// `send_utime` of the command last received, us on the controller's clock.
    pub command_send_utime: i64,
    /// When that command was received, us on the sender's own clock.
    pub receive_utime: i64,
    /// When this message was handed to the network, us on the sender's own clock.
    pub send_utime: i64,
}

/// The robot as its controller sees it: encoders are on the motor side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotState {
    /// Tick; `utime` is the sampling instant of `axis_position[0]`.
    pub stamp: Stamp,
    /// How many of `axis_position` are valid, 1 to 8.
    pub sample_count: i32,
    /// Encoder readings, newest first, one tick apart, rad.
    pub axis_position: [Axes; ENCODER_SAMPLES],
    /// Axis velocities at the newest sample, rad/s.
    pub axis_velocity: Axes,
    /// The set-point that the servo holds at the newest sample, rad.
    pub axis_setpoint: Axes,
    /// State of the robot.
    pub mode: RobotMode,
    /// First cause of a latched fault.
    pub fault: Fault,
    /// Axis (0 to 5) the fault concerns, -1: none.
    pub fault_axis: i32,
    /// Tick of the newest command accepted, -1: none.
    pub command_step: i64,
    /// Cycles without a new command since start.
    pub missed_commands: i64,
    /// The controller's clock, echoed.
    pub echo: ClockEcho,
    /// Sender and order.
    pub authenticity: Authenticity,
}

impl Check for RobotState {
    fn check(&self) -> Result<(), Invalid> {
        self.stamp.check()?;
        in_range(
            "robot_sample_count",
            i64::from(self.sample_count),
            1,
            ENCODER_SAMPLES as i64,
        )?;
        in_range("robot_fault_axis", i64::from(self.fault_axis), -1, 5)?;
        self.axis_position
            .iter()
            .try_for_each(|axes| finite("robot_axis_position_rad", axes.iter()))?;
        finite("robot_axis_velocity_rad_per_s", self.axis_velocity.iter())?;
        finite("robot_axis_setpoint_rad", self.axis_setpoint.iter())
    }
}
