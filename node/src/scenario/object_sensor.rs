//! The section `[object_sensor]`, and the schedule that both sides of its channel follow.

use super::check::Conflicts;
use super::{Scenario, schema};

schema::section! {
    /// The non-contact sensor as it is: what `OBJECT_POSE` brings, a camera's or a laser's view of the object.
    ObjectSensor at "object_sensor" {
        /// Whether there is one.
        enabled: bool = false;
        /// Period of publication, a multiple of T; the first is at tick 0.
        period_ticks: i64 = 8, in 1..=1000;
        /// Ticks from sampling to publication.
        delay_ticks: i64 = 8, in 0..=1000;
        /// White noise of the position along each axis of r, rms.
        noise_m: f64 = 50e-6, in 0.0..=0.1;
        /// Quantum of the position along each axis of r; 0: none.
        quantum_m: f64 = 10e-6, in 0.0..=0.1;
        /// How far the tcp may be from the surface, along its normal, for the object to be seen.
        range_m: f64 = 0.5, in 1e-3..=100.0;
        /// Mis-calibration: what is added to every position, in r.
        bias_m: [f64; 3] = [0.0, 0.0, 0.0], in -0.1..=0.1;
        /// When a drop-out begins: no sample sees the object until it ends.
        dropout_start_s: f64 = 0.0, in 0.0..=86400.0;
        /// How long the drop-out lasts; 0: there is none.
        dropout_duration_s: f64 = 0.0, in 0.0..=86400.0;
    }
}

impl ObjectSensor {
    /// Whether an `OBJECT_POSE` is published at `tick`: whoever receives it in lockstep has to wait for it.
    pub fn due(&self, tick: i64) -> bool {
        self.enabled && tick.checked_rem(self.period_ticks) == Some(0)
    }
}

impl Scenario {
    /// Every object pose belongs to one cycle of the controller.
    pub(super) fn check_object_sensor(&self, conflicts: &mut Conflicts) {
        let (sensor, command) = (&self.object_sensor, self.timing.command_period_ticks);
        conflicts.require(
            !sensor.enabled || sensor.period_ticks.checked_rem(command) == Some(0),
            &[
                "object_sensor.period_ticks",
                "timing.command_period_ticks",
                "object_sensor.enabled",
            ],
            format!(
                "object_sensor.period_ticks is {} ticks, no multiple of timing.command_period_ticks, {command} ticks; \
                 choose a multiple, such as {command} ticks",
                sensor.period_ticks
            ),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_due_at_multiples_of_the_period_if_there_is_a_sensor() {
        let mut sensor = ObjectSensor {
            period_ticks: 12,
            ..Default::default()
        };
        let due = |sensor: &ObjectSensor| (0..30).filter(|&tick| sensor.due(tick)).collect::<Vec<_>>();
        assert_eq!(due(&sensor), []);
        sensor.enabled = true;
        assert_eq!(due(&sensor), [0, 12, 24]);
    }
}
