//! The motion along the normal as laws and shaping know it: rates that coordinates alone do not tell.

use super::Motion;
use crate::Settings;
use crate::command_dynamics::Target;
use crate::contact::{PREVIEW, Waypoint};
use crate::dofs::{Dofs, NORMAL};
use crate::shaping::Point;
use nalgebra::Vector3;
use node::scenario::Profile;
use spatial::TICK_S;
use spatial::kinematics::{Axes, join, split};
use spatial::ports::HORIZON;

impl Motion {
    /// Tell the law where the command filters will be at `tick`, when the next set-point begins to act.
    pub(super) fn track(&mut self, settings: &Settings, tick: i64) {
        let (dynamics, posture, frame) = (&self.dynamics, &self.posture, &self.frame);
        self.force_control.track(tick as f64 * TICK_S, || {
            let reached = dynamics.reached();
            let r_from_s = settings.kinematics.forward(&reached.position);
            let hanging = posture.hanging_tcp(&r_from_s);
            let lever = hanging.translation.vector - r_from_s.translation.vector;
            let jacobian = settings.kinematics.jacobian(&reached.position);
            let along = |rates: &Axes| {
                let (linear, angular) = split(&(jacobian * rates));
                (linear + angular.cross(&lever))[NORMAL]
            };
            Waypoint {
                position: frame.coordinates(&hanging)[NORMAL],
                rate: along(&reached.velocity),
                change: along(&reached.acceleration),
            }
        });
    }

    /// The motion along the normal that a law has planned, unless `coordinates` are elsewhere.
    pub(super) fn planned(&self, coordinates: &[Dofs; PREVIEW]) -> Option<&[Waypoint; PREVIEW]> {
        let motion = self.pressing().and(self.force_control.motion())?;
        let same = |(waypoint, all): (&Waypoint, &Dofs)| waypoint.position == all[NORMAL];
        motion.iter().zip(coordinates).all(same).then_some(motion)
    }

    /// Give `targets` the rates of the `motion` along the normal instead of those that follow from `coordinates`.
    pub(super) fn along_normal(
        &self,
        settings: &Settings,
        motion: &[Waypoint; PREVIEW],
        coordinates: &[Dofs; PREVIEW],
        axes: &Axes,
        targets: &mut [Target; HORIZON],
    ) {
        let upwards = join(Vector3::z(), Vector3::zeros());
        let per_metre = settings
            .kinematics
            .jacobian(axes)
            .lu()
            .solve(&upwards)
            .unwrap_or_default();
        let heights = coordinates.map(|all| Axes::repeat(all[NORMAL]));
        for ((target, known), waypoint) in targets
            .iter_mut()
            .zip(self.dynamics.targets(&heights))
            .zip(motion)
        {
            target.velocity += per_metre * (waypoint.rate - known.velocity[0]);
            target.acceleration += per_metre * (waypoint.change - known.acceleration[0]);
        }
    }

    /// How far the hanging tcp leads the deflected one at `point` of its way, m and rad.
    pub(super) fn lead(&self, settings: &Settings, point: &Point) -> Dofs {
        match settings.controller.shaping.profile {
            Profile::Smooth => self.swing.lead(-point.acceleration),
            Profile::Trapezoid => Dofs::zeros(),
        }
    }
}
