//! One timeline for messages of two devices with clocks of their own: the robot's ticks.
//!
//! The controller's library knows simulated time alone, `step` times 1 ms. A state of the robot says which of its ticks
//! belongs to which instant of its clock; a sample of the sensor is brought there by way of the own clock
//! ([`node::clock_sync`]). So deflection and pose are paired by sampling time, whatever the messages' ways take, and no
//! clock needs to agree with another one.

use node::clock_sync::{ClockSync, Estimate};
use spatial::TICK_US;
use spatial::ports::{Deflections, ObjectPose, RobotState};

/// A sample may lie so far in the future before it is refused, us: what two estimates may be wrong by.
const FUTURE_US: f64 = 2_000.0;

/// What is known of the devices' time.
#[derive(Clone, Debug, Default)]
pub(super) struct Timeline {
    pub(super) robot: ClockSync,
    pub(super) sensor: ClockSync,
    /// The newest state's tick, us of simulated time, and its instant on the robot's clock, us.
    anchor: Option<[i64; 2]>,
    /// The newest sample that was taken, on the sensor's clock, us.
    newest_sample_utime: Option<i64>,
}

impl Timeline {
    /// Whether samples can be placed.
    pub(super) fn ready(&self) -> bool {
        self.robot.ready() && self.sensor.ready() && self.anchor.is_some()
    }

    /// Robot's and sensor's clock at `utime` of the own one (us), as far as they are known.
    pub(super) fn estimates(&self, utime: i64) -> [Option<Estimate>; 2] {
        [&self.robot, &self.sensor].map(|sync| sync.estimate(utime))
    }

    /// Another sensor, or the same one after a restart.
    pub(super) fn forget_sensor(&mut self) {
        (self.sensor, self.newest_sample_utime) = (ClockSync::default(), None);
    }

    /// A state of the robot, in simulated time.
    pub(super) fn place_state(&mut self, state: &RobotState) -> RobotState {
        let mut placed = *state;
        placed.stamp.utime = state.stamp.step * TICK_US;
        self.anchor = Some([placed.stamp.utime, state.stamp.utime]);
        placed
    }

    /// The sensor's samples in simulated time, at `utime` of the own clock (us); `None`: it can't be told yet. Samples that
    /// have been taken before, or lie in the future, are marked as none.
    pub(super) fn place_samples(&mut self, deflections: &Deflections, utime: i64) -> Option<Deflections> {
        let (now, from_sensor) = self.times(utime)?;
        let mut placed = *deflections;
        for sample in &mut placed.samples {
            let time = from_sensor(sample.utime);
            let known = self
                .newest_sample_utime
                .is_some_and(|newest| sample.utime <= newest);
            if known || time > now + FUTURE_US {
                sample.flags.valid = false;
            }
            sample.utime = libm::rint(time) as i64;
        }
        let taken = deflections.samples.iter().zip(&placed.samples);
        let newest = taken
            .filter(|(_, placed)| placed.flags.valid)
            .map(|(raw, _)| raw.utime);
        self.newest_sample_utime = newest.max().or(self.newest_sample_utime);
        Some(placed)
    }

    /// How long ago at `utime` of the own clock (us) the newest sample that was taken was measured, us.
    pub(super) fn sample_age_us(&self, utime: i64) -> Option<f64> {
        let sensor = self.sensor.estimate(utime)?;
        let newest = self.newest_sample_utime?;
        Some(utime as f64 + sensor.ahead_us - newest as f64)
    }

    /// A pose of the object in simulated time.
    pub(super) fn place_object(&self, pose: &ObjectPose, utime: i64) -> Option<ObjectPose> {
        let (now, from_sensor) = self.times(utime)?;
        let time = from_sensor(pose.stamp.utime);
        let mut placed = *pose;
        placed.stamp.utime = libm::rint(time) as i64;
        (time <= now + FUTURE_US).then_some(placed)
    }

    /// Simulated time now (us), and from the sensor's clock to it.
    fn times(&self, utime: i64) -> Option<(f64, impl Fn(i64) -> f64 + use<>)> {
        if !self.ready() {
            return None;
        }
        let [simulated, instant] = self.anchor?;
        let ([Some(robot), Some(sensor)], own) = (self.estimates(utime), utime) else {
            return None;
        };
        let from_robot = move |utime: f64| simulated as f64 + (utime - instant as f64);
        let now = from_robot(own as f64 + robot.ahead_us);
        Some((now, move |utime: i64| {
            from_robot(utime as f64 - sensor.ahead_us + robot.ahead_us)
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spatial::kinematics::Axes;
    use spatial::ports::{
        Authenticity, ClockEcho, DEFLECTION_SAMPLES, DeflectionSample, ENCODER_SAMPLES, Fault, RobotMode,
        SampleFlags, Stamp,
    };

    /// Own clock 50 s; the robot's is 1 s ahead, the sensor's 3 s behind; each way takes 100 us.
    const OWN: i64 = 50_000_000;
    const ROBOT: i64 = 1_000_000;
    const SENSOR: i64 = -3_000_000;

    fn sync(ahead: i64) -> ClockSync {
        let mut sync = ClockSync::default();
        for i in 1..=10 {
            let sent = OWN - 2_000_000 + i * 110_000;
            let echo = ClockEcho {
                command_send_utime: sent,
                receive_utime: sent + 100 + ahead,
                send_utime: sent + 400 + ahead,
            };
            sync.take(&echo, sent + 500);
        }
        sync
    }

    /// Knows that tick 3000 was now.
    fn timeline() -> Timeline {
        let mut timeline = Timeline {
            robot: sync(ROBOT),
            sensor: sync(SENSOR),
            ..Timeline::default()
        };
        timeline.place_state(&RobotState {
            stamp: Stamp {
                step: 3000,
                utime: OWN + ROBOT,
                boot_id: 1,
            },
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
        });
        timeline
    }

    /// Samples 1 ms apart whose newest is `age` us old now.
    fn deflections(age: i64) -> Deflections {
        Deflections {
            stamp: Stamp::default(),
            samples: std::array::from_fn(|i| DeflectionSample {
                utime: OWN + SENSOR - age - i as i64 * TICK_US,
                flags: SampleFlags {
                    valid: true,
                    ..SampleFlags::default()
                },
                ..DeflectionSample::default()
            }),
            echo: ClockEcho::default(),
            authenticity: Authenticity::default(),
        }
    }

    #[test]
    fn samples_get_the_robots_time() {
        let mut timeline = timeline();
        let placed = timeline.place_samples(&deflections(4_000), OWN).unwrap();
        assert_eq!(timeline.sample_age_us(OWN + 500), Some(4_500.0));
        let times = placed.samples.map(|sample| sample.utime);
        assert_eq!(times, std::array::from_fn(|i| 2_996_000 - i as i64 * 1000));
        assert!(placed.samples.iter().all(|sample| sample.flags.valid));
    }

    #[test]
    fn a_sample_is_taken_once() {
        let mut timeline = timeline();
        timeline.place_samples(&deflections(4_000), OWN);
        let placed = timeline.place_samples(&deflections(1_500), OWN).unwrap();
        let valid: Vec<_> = placed.samples.iter().map(|sample| sample.flags.valid).collect();
        assert_eq!(valid, [true, true, true, false, false, false, false, false]);
    }

    #[test]
    fn the_future_is_refused() {
        let placed = timeline().place_samples(&deflections(-5_000), OWN).unwrap();
        let valid = placed.samples.iter().filter(|sample| sample.flags.valid).count();
        assert_eq!(valid, DEFLECTION_SAMPLES - 3);
    }

    #[test]
    fn without_the_clocks_nothing_is_placed() {
        assert!(Timeline::default().place_samples(&deflections(0), OWN).is_none());
    }
}
