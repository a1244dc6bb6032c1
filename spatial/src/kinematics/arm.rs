//! Six revolute joints in series: an articulated robot of the KUKA KR 16-2 class.

use super::{Axes, Unreachable, join, newton};
use crate::{Motion, Pose, rotation};
use nalgebra::{Matrix6, UnitQuaternion, Vector3};
use std::f64::consts::FRAC_1_SQRT_2;

/// Where a joint sits on its predecessor, and about what it turns.
struct Mount {
    /// Origin in the predecessor's frame, m.
    offset: Vector3<f64>,
    /// Axis in the predecessor's frame.
    axis: Vector3<f64>,
}

/// Base to a1, a1 to a2, ... (PLANT.md section 2, from the data sheet's lengths and directions of turning). At zero
/// all frames are parallel to the base's, z up, and the stretched arm points along x.
const MOUNTS: [Mount; 6] = [
    Mount {
        offset: Vector3::new(0.0, 0.0, 0.675),
        axis: Vector3::new(0.0, 0.0, -1.0),
    },
    Mount {
        offset: Vector3::new(0.26, 0.0, 0.0),
        axis: Vector3::new(0.0, 1.0, 0.0),
    },
    Mount {
        offset: Vector3::new(0.68, 0.0, 0.0),
        axis: Vector3::new(0.0, 1.0, 0.0),
    },
    Mount {
        offset: Vector3::new(0.67, 0.0, -0.035),
        axis: Vector3::new(-1.0, 0.0, 0.0),
    },
    Mount {
        offset: Vector3::new(0.0, 0.0, 0.0),
        axis: Vector3::new(0.0, 1.0, 0.0),
    },
    Mount {
        offset: Vector3::new(0.0, 0.0, 0.0),
        axis: Vector3::new(-1.0, 0.0, 0.0),
    },
];

/// From a6 to the flange, m.
const FLANGE: Vector3<f64> = Vector3::new(0.158, 0.0, 0.0);

/// How many stages lead to a pose far away.
const STAGES: i32 = 32;

/// The arm, standing upright at `base_in_r`.
///
/// The sensor frame s is the flange's, turned by -90 deg about y: parallel to r when the flange looks down and
/// a1 + a6 = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    /// Origin of the base in r, m; the base is parallel to r.
    pub base_in_r: Vector3<f64>,
}

/// A joint in r, with the link that it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// A point on the axis and origin of the link's frame, m.
    pub origin: Vector3<f64>,
    /// Axis, a unit vector.
    pub axis: Vector3<f64>,
    /// `r_from_link`.
    pub rotation: UnitQuaternion<f64>,
}

impl Arm {
    /// The working posture: flange at (0.9, 0, 0.9) m of the base, looking down (PLANT.md section 2).
    pub const WORKING: Axes = Axes::new(0.0, -1.515_053_960, 1.919_692_981, 0.0, 1.166_157_306, 0.0);

    /// All joints in r, from the base to the flange.
    pub fn joints(&self, axes: &Axes) -> [Joint; 6] {
        let mut origin = self.base_in_r;
        let mut rotation = UnitQuaternion::identity();
        std::array::from_fn(|i| {
            origin += rotation * MOUNTS[i].offset;
            let axis = rotation * MOUNTS[i].axis;
            let (sine, cosine) = libm::sincos(0.5 * axes[i]);
            let turn = MOUNTS[i].axis * sine;
            rotation *= super::quaternion([cosine, turn.x, turn.y, turn.z]);
            Joint {
                origin,
                axis,
                rotation,
            }
        })
    }

    /// The pose `r_from_s` at `axes`.
    pub fn forward(&self, axes: &Axes) -> Pose {
        sensor_pose(&self.joints(axes)[5])
    }

    /// The Jacobian in r: rows velocity (m/s) and angular velocity (rad/s) of s, columns joints (rad/s).
    pub fn jacobian(&self, axes: &Axes) -> Matrix6<f64> {
        self.pose_and_jacobian(axes).1
    }

    /// Motion of s in r from joint angles and their two derivatives, from link to link.
    pub fn motion(&self, axes: &Axes, rates: &Axes, changes: &Axes) -> Motion {
        let joints = self.joints(axes);
        let mut motion = Motion::at_rest(Pose::translation(
            self.base_in_r.x,
            self.base_in_r.y,
            self.base_in_r.z,
        ));
        for (i, joint) in joints.iter().enumerate() {
            motion.carry(joint.origin);
            motion.turn(joint.axis, rates[i], changes[i]);
        }
        let pose = sensor_pose(&joints[5]);
        motion.carry(pose.translation.vector);
        Motion { pose, ..motion }
    }

    /// The joint angles at which s is at `r_from_s`, on the branch of `near`; see the file `newton.rs`.
    pub fn inverse(&self, r_from_s: &Pose, near: &Axes) -> Result<Axes, Unreachable> {
        newton::solve(r_from_s, near, |axes| self.pose_and_jacobian(axes))
    }

    /// As [`Arm::inverse`], from the working posture along the straight way in 32 stages.
    pub fn reach(&self, r_from_s: &Pose) -> Result<Axes, Unreachable> {
        let mut axes = Self::WORKING;
        let start = self.forward(&axes);
        let way = newton::weighted_error(r_from_s, &start);
        let (shift, turn) = super::split(&way);
        for stage in 1..STAGES {
            let share = f64::from(stage) / f64::from(STAGES);
            let pose = Pose::from_parts(
                (start.translation.vector + shift * share).into(),
                rotation::exp(turn * share) * start.rotation,
            );
            axes = self.inverse(&pose, &axes)?;
        }
        self.inverse(r_from_s, &axes)
    }

    fn pose_and_jacobian(&self, axes: &Axes) -> (Pose, Matrix6<f64>) {
        let joints = self.joints(axes);
        let pose = sensor_pose(&joints[5]);
        (pose, jacobian_of(&joints, &pose))
    }
}

/// The Jacobian of the sensor frame at `pose`, in r: rows velocity (m/s) and angular velocity (rad/s), columns joints.
pub fn jacobian_of(joints: &[Joint; 6], pose: &Pose) -> Matrix6<f64> {
    let mut jacobian = Matrix6::zeros();
    for (i, joint) in joints.iter().enumerate() {
        let lever = pose.translation.vector - joint.origin;
        jacobian.set_column(i, &join(joint.axis.cross(&lever), joint.axis));
    }
    jacobian
}

/// The pose `r_from_s` on the `last` link.
pub fn sensor_pose(last: &Joint) -> Pose {
    // Turned by -90 deg about y.
    let flange_from_s = super::quaternion([FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2, 0.0]);
    Pose::from_parts(
        (last.origin + last.rotation * FLANGE).into(),
        last.rotation * flange_from_s,
    )
}

#[cfg(test)]
mod tests;
