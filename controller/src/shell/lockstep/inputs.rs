//! What a cycle in lockstep waits for.

use node::scenario;
use spatial::ports::{Deflections, ObjectPose, RobotState};

/// What has come so far of what the next cycle needs.
pub(super) struct Inputs {
    object_sensor: scenario::ObjectSensor,
    /// The state to be answered; `None`: it has been, or none has come.
    pub(super) state: Option<RobotState>,
    /// The newest deflections.
    pub(super) deflections: Option<Deflections>,
    /// The newest object pose that was due.
    pub(super) object_pose: Option<ObjectPose>,
}

impl Inputs {
    /// Nothing yet; object poses are due as `object_sensor` says.
    pub(super) fn new(object_sensor: &scenario::ObjectSensor) -> Self {
        Self {
            object_sensor: object_sensor.clone(),
            state: None,
            deflections: None,
            object_pose: None,
        }
    }

    /// Everything that the cycle of the waiting state's tick needs, once it is there: the deflections of that tick
    /// and, if one is due at that tick, the object pose of that tick.
    ///
    /// So the cycle uses the same object poses as the loop in one process, whatever is lost, doubled or late.
    pub(super) fn complete(&self) -> Option<(&RobotState, &Deflections, Option<&ObjectPose>)> {
        let state = self.state.as_ref()?;
        let tick = state.stamp.step;
        let deflections = self.deflections.as_ref().filter(|it| it.stamp.step == tick)?;
        let object_pose = if self.object_sensor.due(tick) {
            Some(self.object_pose.as_ref().filter(|it| it.stamp.step == tick)?)
        } else {
            None
        };
        Some((state, deflections, object_pose))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use spatial::kinematics::Axes;
    use spatial::ports::{
        Authenticity, ClockEcho, DEFLECTION_SAMPLES, DeflectionSample, ENCODER_SAMPLES, Fault, RobotMode,
        Role, Stamp,
    };

    fn state(tick: i64) -> RobotState {
        RobotState {
            stamp: Stamp::lockstep(tick, 1, Role::Robot),
            sample_count: 1,
            axis_position: [Axes::zeros(); ENCODER_SAMPLES],
            axis_velocity: Axes::zeros(),
            axis_setpoint: Axes::zeros(),
            mode: RobotMode::Following,
            fault: Fault::None,
            fault_axis: -1,
            command_step: -1,
            missed_commands: 0,
            echo: ClockEcho::default(),
            authenticity: Authenticity::default(),
        }
    }

    fn deflections(tick: i64) -> Deflections {
        Deflections {
            stamp: Stamp::lockstep(tick, 1, Role::Sensor),
            samples: [DeflectionSample::default(); DEFLECTION_SAMPLES],
            echo: ClockEcho::default(),
            authenticity: Authenticity::default(),
        }
    }

    fn object_pose(tick: i64) -> ObjectPose {
        ObjectPose {
            stamp: Stamp::lockstep(tick, 1, Role::Sensor),
            visible: true,
            pose: spatial::Pose::identity(),
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            position_sigma_m: 0.0,
        }
    }

    /// Whether the cycle of tick 16 can run with the newest `deflections` and `object_pose` of these ticks, and the
    /// tick of the object pose that it uses.
    fn cycle_16(
        period_ticks: Option<i64>,
        newest_deflections: i64,
        newest_pose: Option<i64>,
    ) -> Option<Option<i64>> {
        let mut inputs = Inputs::new(&scenario::ObjectSensor {
            enabled: period_ticks.is_some(),
            period_ticks: period_ticks.unwrap_or(8),
            ..Default::default()
        });
        inputs.state = Some(state(16));
        inputs.deflections = Some(deflections(newest_deflections));
        inputs.object_pose = newest_pose.map(object_pose);
        let complete = inputs.complete();
        complete.map(|(_, _, pose)| pose.map(|pose| pose.stamp.step))
    }

    #[test]
    fn a_cycle_waits_for_the_deflections_of_its_tick() {
        assert_eq!(cycle_16(None, 15, None), None);
        assert_eq!(cycle_16(None, 16, None), Some(None));
    }

    #[test]
    fn a_cycle_waits_for_the_object_pose_of_its_tick_if_one_is_due() {
        assert_eq!(cycle_16(Some(8), 16, None), None);
        assert_eq!(cycle_16(Some(8), 16, Some(8)), None);
        assert_eq!(cycle_16(Some(8), 15, Some(16)), None);
        assert_eq!(cycle_16(Some(8), 16, Some(16)), Some(Some(16)));
    }

    #[test]
    fn a_cycle_between_two_object_poses_uses_none() {
        assert_eq!(cycle_16(Some(12), 16, Some(12)), Some(None));
    }

    #[test]
    fn no_cycle_without_a_state() {
        let mut inputs = Inputs::new(&scenario::ObjectSensor::default());
        inputs.deflections = Some(deflections(0));
        assert!(inputs.complete().is_none());
    }
}
