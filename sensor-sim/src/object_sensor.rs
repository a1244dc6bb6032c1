//! The non-contact sensor, a camera or a laser that sees the object from a distance: `OBJECT_POSE`.

use crate::noise::Noise;
use crate::signal::{dropout, quantised};
use nalgebra::Vector3;
use node::scenario;
use spatial::ports::{ObjectPose, Stamp};
use spatial::{Pose, TICK_US};
use std::ops::Range;

/// From where the object is to its delayed pose, as often as the scenario says.
///
/// Model choice: the object is seen while the tcp is near enough to its surface, as by a sensor beside the tool. The
/// position has a constant bias, white noise and a quantum along each axis of r; the orientation is exact; velocities
/// are not measured.
#[derive(Clone, Debug)]
pub struct ObjectSensor {
    settings: scenario::ObjectSensor,
    bias: Vector3<f64>,
    /// Ticks in which the sensor drops out.
    dropout: Range<i64>,
    delay_ticks: i64,
    noise: Noise,
    /// What was seen by tick, as a ring; `None`: nothing.
    ring: Vec<Option<Pose>>,
}

/// Makes the stream of random numbers another than the compliant sensor's of the same seed.
const STREAM: u64 = u64::from_be_bytes(*b"OBJ_POSE");

impl ObjectSensor {
    /// A sensor that has seen nothing yet.
    pub fn new(settings: &scenario::ObjectSensor, seed: i64) -> Self {
        let delay = usize::try_from(settings.delay_ticks).unwrap_or(0);
        Self {
            settings: settings.clone(),
            bias: settings.bias_m.into(),
            dropout: dropout(settings.dropout_start_s, settings.dropout_duration_s),
            delay_ticks: delay as i64,
            noise: Noise::new(seed as u64 ^ STREAM),
            ring: vec![None; delay + 1],
        }
    }

    /// Take the sample of the tick of `stamp`, at which the object is at `r_from_o` and the tcp at `tcp` (m, in r),
    /// and return what is published then: at multiples of the period the sample that has come through the delay.
    pub fn sample(&mut self, stamp: Stamp, r_from_o: &Pose, tcp: &Vector3<f64>) -> Option<ObjectPose> {
        let length = self.ring.len() as i64;
        let slot = |tick: i64| tick.rem_euclid(length) as usize;
        // Measured even if it is not seen: the stream of random numbers goes on.
        let measured = self.measure(r_from_o);
        let normal = r_from_o.rotation * Vector3::z();
        let distance = normal.dot(&(tcp - r_from_o.translation.vector));
        let seen = distance <= self.settings.range_m && !self.dropout.contains(&stamp.step);
        self.ring[slot(stamp.step)] = seen.then_some(measured);
        if !self.settings.due(stamp.step) {
            return None;
        }
        // Before the first sample has come through, the ring still holds nothing there.
        let sampled = stamp.step - self.delay_ticks;
        let pose = self.ring[slot(sampled)];
        Some(ObjectPose {
            stamp: Stamp {
                utime: sampled * TICK_US,
                ..stamp
            },
            visible: pose.is_some(),
            pose: pose.unwrap_or_else(Pose::identity),
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            position_sigma_m: self.settings.noise_m,
        })
    }

    fn measure(&mut self, r_from_o: &Pose) -> Pose {
        let noise = Vector3::from(self.noise.normals()) * self.settings.noise_m;
        let noisy = r_from_o.translation.vector + self.bias + noise;
        let position = noisy.map(|noisy| quantised(noisy, self.settings.quantum_m));
        Pose::from_parts(position.into(), r_from_o.rotation)
    }
}

#[cfg(test)]
mod tests;
