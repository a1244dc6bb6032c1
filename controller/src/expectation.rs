//! Where the object is expected before the tool touches it: from a model, or from a non-contact sensor.
//!
//! Paper II-B and IV-C: of an impact that is foreseen, the speed and with it the force can be made small. So the
//! approach slows down where the object is expected, and moves with the object if that moves.

use crate::fading_memory::FadingMemory;
use nalgebra::Vector3;
use node::scenario::{Expected, ExpectedFrom, Scenario};
use spatial::Pose;
use spatial::ports::ObjectPose;

/// Where the tcp will be when it touches the object, in r.
#[derive(Clone, Debug)]
pub struct Expectation {
    source: ExpectedFrom,
    modelled: Vector3<f64>,
    /// Position of the tcp at the contact, by axis of r.
    seen: [FadingMemory; 3],
    newest_utime: Option<i64>,
    t1_from_o: Pose,
}

impl Expectation {
    /// What the scenario's controller expects, nothing seen yet.
    pub fn new(scenario: &Scenario) -> Self {
        let expected: &Expected = &scenario.controller.expected;
        let seen = FadingMemory::new(
            expected.object_motion.degree(),
            expected.filter_gain,
            expected.filter_gain,
        );
        Self {
            source: expected.from,
            modelled: Vector3::z() * scenario.task.expected_height_m,
            seen: [seen; 3],
            newest_utime: None,
            t1_from_o: offset(expected),
        }
    }

    /// Take a checked message: one that has not seen the object tells nothing, and one that was sampled no later
    /// than what is known comes too late.
    pub fn take(&mut self, pose: &ObjectPose) {
        let utime = pose.stamp.utime;
        if !pose.visible || self.newest_utime.is_some_and(|known| utime <= known) {
            return;
        }
        self.newest_utime = Some(utime);
        let r_from_t1 = pose.pose * self.t1_from_o.inverse();
        for (axis, memory) in self.seen.iter_mut().enumerate() {
            memory.take(1e-6 * utime as f64, r_from_t1.translation.vector[axis]);
        }
    }

    /// Expect the modelled object at `height_m` (m in r) from now on; at the beginning of an approach, which would follow it
    /// there otherwise.
    pub(crate) fn expect_at_height(&mut self, height_m: f64) {
        self.modelled.z = height_m;
    }

    /// Position (m) of the tcp in r as it touches the object at `time_s`, and the object's velocity (m/s); `None`:
    /// nothing is expected, or nothing has been seen yet.
    pub fn at(&self, time_s: f64) -> Option<(Vector3<f64>, Vector3<f64>)> {
        match self.source {
            ExpectedFrom::Nothing => None,
            ExpectedFrom::Model => Some((self.modelled, Vector3::zeros())),
            ExpectedFrom::ObjectSensor => {
                let mut position = Vector3::zeros();
                let mut velocity = Vector3::zeros();
                for (axis, memory) in self.seen.iter().enumerate() {
                    (position[axis], velocity[axis]) = memory.at(time_s)?;
                }
                Some((position, velocity))
            }
        }
    }

    /// Whether the approach can begin: what is to be expected is known, its velocity included.
    pub fn ready(&self) -> bool {
        self.source != ExpectedFrom::ObjectSensor || self.seen.iter().all(FadingMemory::is_settled)
    }

    /// Paper, footnote 3: the pose of the object's frame, seen from the tcp that touches it.
    pub fn t1_from_o(&self) -> &Pose {
        &self.t1_from_o
    }
}

fn offset(expected: &Expected) -> Pose {
    spatial::pose(expected.object_in_tcp_m.into(), expected.object_in_tcp_rad.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use node::scenario::ObjectMotion;
    use spatial::ports::Stamp;

    fn expectation(offset_m: [f64; 3]) -> Expectation {
        let mut scenario = Scenario::default();
        scenario.controller.expected = Expected {
            from: ExpectedFrom::ObjectSensor,
            object_motion: ObjectMotion::Steady,
            filter_gain: 0.1,
            object_in_tcp_m: offset_m,
            ..Expected::default()
        };
        Expectation::new(&scenario)
    }

    fn seen(utime: i64, x: f64, visible: bool) -> ObjectPose {
        ObjectPose {
            stamp: Stamp {
                step: 100,
                utime,
                boot_id: 1,
            },
            visible,
            pose: Pose::translation(x, 0.0, 0.02),
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            position_sigma_m: 0.0,
        }
    }

    #[test]
    fn only_newer_samples_that_see_the_object_count() {
        let mut expectation = expectation([0.0; 3]);
        let mut x_after = |utime, x, visible| {
            expectation.take(&seen(utime, x, visible));
            expectation
                .at(1e-6 * utime as f64)
                .map(|(position, _)| position.x)
        };
        assert_eq!(x_after(-8_000, 1.0, false), None);
        assert_eq!(x_after(8_000, 1.0, true), Some(1.0));
        assert_eq!(x_after(16_000, 2.0, false), Some(1.0));
        assert_eq!(x_after(8_000, 3.0, true), Some(1.0));
    }

    /// 50 mm/s along x, seen from a tcp that touches it 10 mm behind its origin; it is lost after 4 s.
    #[test]
    fn a_moving_object_is_predicted_until_it_has_been_lost_for_long() {
        let mut expectation = expectation([0.010, 0.0, 0.0]);
        for n in 0..=500 {
            expectation.take(&seen(8_000 * n, 0.05 * 8e-3 * n as f64, true));
        }
        for (time, x, speed) in [
            (4.0, 0.19, 0.05),
            (4.1, 0.195, 0.05),
            (4.15, 0.1975, 0.05),
            (9.0, 0.2, 0.0),
        ] {
            let (position, velocity) = expectation.at(time).unwrap();
            assert!(
                (position - Vector3::new(x, 0.0, 0.02)).norm() < 1e-9,
                "{position}"
            );
            assert!((velocity.x - speed).abs() < 1e-9);
        }
    }
}
