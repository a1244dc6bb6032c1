//! What a scenario says about the robot, in the terms of whichever kinematics it names.

use super::{Kinematics, Robot, Scenario};
use spatial::kinematics::{self, Axes, Unreachable};
use spatial::{Pose, kinematics::Kinematics as Model};

/// The six axes of the robot that a scenario names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drives {
    /// The section that they come from.
    pub section: &'static str,
    /// Inertia of each motor, kg m^2.
    pub motor_inertia_kg_m2: Axes,
    /// Natural frequency of each link on its gear, motor locked, Hz.
    pub gear_frequency_hz: Axes,
    /// Lower end of each axis, rad.
    pub axis_minimum_rad: Axes,
    /// Upper end of each axis, rad.
    pub axis_maximum_rad: Axes,
    /// Largest velocity of the command filter, rad/s.
    pub velocity_limit_rad_per_s: Axes,
    /// Largest acceleration of the command filter, rad/s^2.
    pub acceleration_limit_rad_per_s2: Axes,
}

macro_rules! drives {
    ($section:expr, $name:literal) => {
        Drives {
            section: $name,
            motor_inertia_kg_m2: $section.motor_inertia_kg_m2.into(),
            gear_frequency_hz: $section.gear_frequency_hz.into(),
            axis_minimum_rad: $section.axis_minimum_rad.into(),
            axis_maximum_rad: $section.axis_maximum_rad.into(),
            velocity_limit_rad_per_s: $section.velocity_limit_rad_per_s.into(),
            acceleration_limit_rad_per_s2: $section.acceleration_limit_rad_per_s2.into(),
        }
    };
}

impl Robot {
    /// The axes of the chosen kinematics.
    pub fn drives(&self) -> Drives {
        match self.kinematics {
            Kinematics::Gantry => drives!(self.gantry, "robot.gantry"),
            Kinematics::Arm => drives!(self.arm, "robot.arm"),
        }
    }

    /// The chosen kinematics.
    pub fn kinematics(&self) -> Model {
        match self.kinematics {
            Kinematics::Gantry => Model::Gantry(kinematics::Gantry),
            Kinematics::Arm => Model::Arm(kinematics::Arm {
                base_in_r: self.arm.base_position_m.into(),
            }),
        }
    }
}

impl Scenario {
    /// The axes at which the nominal tcp is at the task's start position, s parallel to r.
    pub fn start_axes(&self) -> Result<Axes, Unreachable> {
        self.axes_at(self.task.start_position_m)
    }

    /// The axes at which the nominal tcp is at `position` (m) in r, s parallel to r.
    pub(super) fn axes_at(&self, position: [f64; 3]) -> Result<Axes, Unreachable> {
        let [x, y, z] = std::array::from_fn(|i| position[i] - self.tool.tcp_in_s_m[i]);
        self.robot.kinematics().reach(&Pose::translation(x, y, z))
    }
}
