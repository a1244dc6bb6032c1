//! From axis angles to the pose of the sensor frame s, and back.
//!
//! Every robot here has six axes, and an axis coordinate is always an angle in rad: the gantry's linear axes are
//! driven by rack and pinion of radius 1 m, so that 1 rad is 1 m.
//!
//! [`Kinematics`] is the one interface that robot and controller use; [`Gantry`] and [`Arm`] stand behind it.

mod arm;
mod gantry;
mod newton;
mod unreachable;

pub use arm::{Arm, Joint, jacobian_of, sensor_pose};
pub use gantry::Gantry;
pub use newton::{smallest_singular_value, weighted_error};
pub use unreachable::Unreachable;

use crate::{Motion, Pose};
use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};

/// Six axis coordinates, velocities or accelerations: rad, rad/s, rad/s^2.
pub type Axes = Vector6<f64>;

/// How the six axes move the sensor frame s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kinematics {
    /// Six decoupled axes.
    Gantry(Gantry),
    /// Six revolute joints in series.
    Arm(Arm),
}

impl Kinematics {
    /// The pose `r_from_s` at `axes`.
    pub fn forward(&self, axes: &Axes) -> Pose {
        match self {
            Self::Gantry(gantry) => gantry.forward(axes),
            Self::Arm(arm) => arm.forward(axes),
        }
    }

    /// The Jacobian in r: rows velocity (m/s) and angular velocity (rad/s) of s, columns axes (rad/s).
    pub fn jacobian(&self, axes: &Axes) -> Matrix6<f64> {
        match self {
            Self::Gantry(gantry) => gantry.jacobian(axes),
            Self::Arm(arm) => arm.jacobian(axes),
        }
    }

    /// Motion of s in r from axis coordinates and their two derivatives.
    pub fn motion(&self, axes: &Axes, rates: &Axes, changes: &Axes) -> Motion {
        match self {
            Self::Gantry(gantry) => gantry.motion(axes, rates, changes),
            Self::Arm(arm) => arm.motion(axes, rates, changes),
        }
    }

    /// The axes at which s is at `r_from_s`, on the branch of `near` and close to it.
    ///
    /// Costs the same whatever is asked for. Ranges of the axes are not its concern.
    pub fn inverse(&self, r_from_s: &Pose, near: &Axes) -> Result<Axes, Unreachable> {
        match self {
            Self::Gantry(gantry) => Ok(gantry.inverse(r_from_s)),
            Self::Arm(arm) => arm.inverse(r_from_s, near),
        }
    }

    /// As [`Kinematics::inverse`] for a pose far away: from [`Kinematics::home`] along the straight way.
    pub fn reach(&self, r_from_s: &Pose) -> Result<Axes, Unreachable> {
        match self {
            Self::Gantry(gantry) => Ok(gantry.inverse(r_from_s)),
            Self::Arm(arm) => arm.reach(r_from_s),
        }
    }

    /// A regular posture in the middle of the working range.
    pub fn home(&self) -> Axes {
        match self {
            Self::Gantry(_) => Axes::zeros(),
            Self::Arm(_) => Arm::WORKING,
        }
    }
}

/// Position-like and rotation-like halves of six axis values.
pub fn split(axes: &Axes) -> (Vector3<f64>, Vector3<f64>) {
    (
        axes.fixed_rows::<3>(0).into_owned(),
        axes.fixed_rows::<3>(3).into_owned(),
    )
}

/// The six axis values of a translation and a rotation vector.
pub fn join(translation: Vector3<f64>, turn: Vector3<f64>) -> Axes {
    let mut axes = Axes::zeros();
    axes.fixed_rows_mut::<3>(0).copy_from(&translation);
    axes.fixed_rows_mut::<3>(3).copy_from(&turn);
    axes
}

/// The unit quaternion from components (w, x, y, z) as they are, without renormalising (that would change bits).
pub fn quaternion(components: [f64; 4]) -> UnitQuaternion<f64> {
    let [w, x, y, z] = components;
    UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z))
}
