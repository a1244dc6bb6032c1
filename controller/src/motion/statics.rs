//! From wrenches and accelerations at the tcp to the axes.

use super::Motion;
use crate::Settings;
use crate::dofs::{Selection, TcpCompliance};
use crate::posture::Posture;
use nalgebra::Vector3;
use spatial::kinematics::{Axes, join, split};
use spatial::{Compliance, Pose, Wrench};

impl Motion {
    /// From the sensor frame to the hanging tcp while the axes are at `axes`, m in r.
    pub(super) fn lever(&self, settings: &Settings, axes: &Axes) -> Vector3<f64> {
        let r_from_s = settings.kinematics.forward(axes);
        self.posture.hanging_tcp(&r_from_s).translation.vector - r_from_s.translation.vector
    }

    /// The magnitude of the tcp's acceleration (m/s^2) that `changes` (rad/s^2) of the axes at `axes` cause: whatever its
    /// direction, the tool's swing shows along the normal.
    pub(super) fn tcp_acceleration(&self, settings: &Settings, axes: &Axes, changes: &Axes) -> f64 {
        let (linear, angular) = split(&(settings.kinematics.jacobian(axes) * changes));
        (linear + angular.cross(&self.lever(settings, axes))).norm()
    }

    /// The torque (Nm) on the axes at `axes` under the desired wrench at the tcp.
    pub(super) fn torque(&self, settings: &Settings, axes: &Axes) -> Axes {
        let Wrench { force, moment } = settings.desired;
        let at_s = join(force, moment + self.lever(settings, axes).cross(&force));
        settings.kinematics.jacobian(axes).tr_mul(&at_s)
    }
}

/// The compliance of a tcp that hangs as in `posture`, in r.
pub(super) fn tcp_compliance(
    compliance: &Compliance,
    posture: &Posture,
    r_from_s: &Pose,
    selection: &Selection,
) -> TcpCompliance {
    let rotation = r_from_s.rotation.to_rotation_matrix().into_inner();
    let in_r = Compliance {
        translation: rotation * compliance.translation * rotation.transpose(),
        rotation: rotation * compliance.rotation * rotation.transpose(),
    };
    TcpCompliance::new(&in_r, posture.lever(), selection)
}
