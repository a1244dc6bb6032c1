//! What the non-contact sensor has seen of the object last.

use spatial::ports::ObjectPose;

/// The newest pose at which the object was seen, by sampling instant.
///
/// It is kept while the object is out of sight: how old it may be is for those to say who use it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectSensor {
    newest: Option<ObjectPose>,
}

impl ObjectSensor {
    /// Take a checked message: one that has not seen the object tells nothing, and one that was sampled no later
    /// than what is known comes too late.
    pub fn update(&mut self, pose: &ObjectPose) {
        let newer = |known: ObjectPose| pose.stamp.utime > known.stamp.utime;
        if pose.visible && self.newest.is_none_or(newer) {
            self.newest = Some(*pose);
        }
    }

    /// `r_from_o` as it was seen last, with its sampling instant and noise; `None`: never seen.
    pub fn newest(&self) -> Option<&ObjectPose> {
        self.newest.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use spatial::{Pose, ports::Stamp};

    fn sampled(utime: i64, visible: bool) -> ObjectPose {
        ObjectPose {
            stamp: Stamp {
                step: 100,
                utime,
                boot_id: 1,
            },
            visible,
            pose: Pose::identity(),
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            position_sigma_m: 0.0,
        }
    }

    #[test]
    fn the_newest_sample_that_has_seen_the_object_counts() {
        let mut sensor = ObjectSensor::default();
        let mut newest_after = |utime, visible| {
            sensor.update(&sampled(utime, visible));
            sensor.newest().map(|pose| pose.stamp.utime)
        };
        assert_eq!(newest_after(-8_000, false), None);
        assert_eq!(newest_after(8_000, true), Some(8_000));
        assert_eq!(newest_after(16_000, false), Some(8_000));
        assert_eq!(newest_after(24_000, true), Some(24_000));
        assert_eq!(newest_after(16_000, true), Some(24_000));
    }

    #[test]
    fn a_repeated_sampling_instant_changes_nothing() {
        let mut sensor = ObjectSensor::default();
        sensor.update(&sampled(8_000, true));
        let mut other = sampled(8_000, true);
        other.pose.translation.z = 1.0;
        sensor.update(&other);
        assert_eq!(sensor.newest(), Some(&sampled(8_000, true)));
    }
}
