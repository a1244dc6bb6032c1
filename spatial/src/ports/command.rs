//! `ROBOT_COMMAND`: where the controller wants the axes, and when.

use super::{Authenticity, Check, Invalid, Stamp, finite};
use crate::kinematics::Axes;

/// Set-points in one command, spaced by the command period T.
pub const HORIZON: usize = 8;

/// A short horizon of axis set-points, so that a lost command costs little.
///
/// A command issued at t_k acts from t_k + n_d T: the axes then move linearly from the previous set-point and
/// reach `axis_position[i]` at t_k + (n_d + 1 + i) T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Tick of the robot state that this command answers.
    pub stamp: Stamp,
    /// Whether the robot may move; published with `false` from the start on.
    pub enable: bool,
    /// The next set-points, T apart, rad.
    pub axis_position: [Axes; HORIZON],
    /// When the message was handed to the network, us on the controller's clock (0 in lockstep).
    pub send_utime: i64,
    /// Sender and order.
    pub authenticity: Authenticity,
}

impl Check for Command {
    fn check(&self) -> Result<(), Invalid> {
        self.stamp.check()?;
        self.axis_position
            .iter()
            .try_for_each(|axes| finite("command_axis_position_rad", axes.iter()))
    }
}
