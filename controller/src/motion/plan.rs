//! What a cycle has decided about the coming instants.

use crate::contact::PREVIEW;
use crate::dofs::{Dofs, TaskFrame};
use crate::posture::Posture;
use spatial::kinematics::{Axes, Kinematics, Unreachable};
use spatial::ports::HORIZON;

/// Where the robot is to be at the coming instants, T apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    /// Coordinates of the hanging tcp.
    pub(super) coordinates: [Dofs; PREVIEW],
    /// The axes there.
    pub(super) axes: [Axes; PREVIEW],
    /// The coordinates of the set-point given.
    pub(super) commanded: Dofs,
}

impl Plan {
    /// To stay at `coordinates`, where the axes are at `axes`.
    pub(super) fn stay(coordinates: Dofs, axes: Axes) -> Self {
        Self {
            coordinates: [coordinates; PREVIEW],
            axes: [axes; PREVIEW],
            commanded: coordinates,
        }
    }

    /// The axes at `coordinates`, each on the branch of its predecessor. What was planned before for the same place, a
    /// period later in this plan, is not computed again.
    pub(super) fn inverse(
        &self,
        kinematics: &Kinematics,
        frame: &TaskFrame,
        posture: &Posture,
        coordinates: &[Dofs; PREVIEW],
    ) -> Result<[Axes; PREVIEW], Unreachable> {
        let mut known = (self.coordinates[0], self.axes[0]);
        let mut axes = [known.1; PREVIEW];
        for (i, (wanted, slot)) in coordinates.iter().zip(&mut axes).enumerate() {
            let planned = self.coordinates.get(i + 1).zip(self.axes.get(i + 1));
            known = match planned {
                _ if known.0 == *wanted => known,
                Some((coordinates, axes)) if coordinates == wanted => (*wanted, *axes),
                _ => {
                    let pose = posture.sensor_pose(&frame.pose(wanted));
                    (*wanted, kinematics.inverse(&pose, &known.1)?)
                }
            };
            *slot = known.1;
        }
        Ok(axes)
    }
}

/// Bounds the ways of the tcp and of the sensor frame from the `actual` axes to where `set_points` send them to `most`
/// (m), which bounds turns too; whether that changes the first one.
pub(super) fn bound_lead(
    kinematics: &Kinematics,
    posture: &Posture,
    most: f64,
    actual: &Axes,
    set_points: &mut [Axes; HORIZON],
) -> bool {
    let points = |axes: &Axes| {
        let r_from_s = kinematics.forward(axes);
        [r_from_s, posture.hanging_tcp(&r_from_s)].map(|pose| pose.translation.vector)
    };
    let from = points(actual);
    let mut binds = [false; HORIZON];
    for (set_point, binds) in set_points.iter_mut().zip(&mut binds) {
        let to = points(set_point);
        let lead = (to[0] - from[0]).norm().max((to[1] - from[1]).norm());
        if lead > most {
            *set_point = actual + (*set_point - actual) * (most / lead);
            *binds = true;
        }
    }
    binds[0]
}
