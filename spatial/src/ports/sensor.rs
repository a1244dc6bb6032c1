//! `SENSOR_DEFLECTION` and `OBJECT_POSE`: what the compliant sensor and a non-contact sensor measure.

use super::{
    Authenticity, Check, ClockEcho, Invalid, Stamp, check_utime, finite_pose, finite_vectors, in_range,
};
use crate::{Deflection, Pose, Wrench};
use nalgebra::Vector3;

/// Samples in one message, the newest first.
pub const DEFLECTION_SAMPLES: usize = 8;

/// What is known about one sample: the bits of `deflection_flags`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleFlags {
    /// The sample was taken; otherwise the sensor dropped out.
    pub valid: bool,
    /// A component is at the end of the measuring range.
    pub saturated: bool,
    /// `wrench` is measured independently of the deflection.
    pub wrench_measured: bool,
}

impl SampleFlags {
    /// The bits of the wire: 1 valid, 2 saturated, 4 wrench measured.
    pub fn bits(self) -> i32 {
        i32::from(self.valid) | i32::from(self.saturated) << 1 | i32::from(self.wrench_measured) << 2
    }

    /// The flags that `bits` of the wire stand for.
    pub fn from_bits(bits: i32) -> Self {
        Self {
            valid: bits & 1 != 0,
            saturated: bits & 2 != 0,
            wrench_measured: bits & 4 != 0,
        }
    }
}

/// One reading of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeflectionSample {
    /// Sampling instant, us on the sensor's clock; in lockstep tick times 1000.
    pub utime: i64,
    /// Deflection s -> s', in s.
    pub deflection: Deflection,
    /// Independently measured wrench at s, in s; zero unless flagged.
    pub wrench: Wrench,
    /// Validity.
    pub flags: SampleFlags,
}

/// The sensor's last eight readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deflections {
    /// Tick at which the message is sent; `utime` is the sampling instant of `samples[0]`.
    pub stamp: Stamp,
    /// Newest first; those never taken are flagged invalid.
    pub samples: [DeflectionSample; DEFLECTION_SAMPLES],
    /// The controller's clock, echoed.
    pub echo: ClockEcho,
    /// Sender and order.
    pub authenticity: Authenticity,
}

impl Check for Deflections {
    fn check(&self) -> Result<(), Invalid> {
        self.stamp.check()?;
        self.samples.iter().try_for_each(|sample| {
            check_utime(sample.utime)?;
            finite_vectors(
                "deflection",
                &[sample.deflection.translation, sample.deflection.rotation],
            )?;
            finite_vectors("deflection_wrench", &[sample.wrench.force, sample.wrench.moment])
        })
    }
}

/// An object's pose as a non-contact sensor or a model gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectPose {
    /// Tick at which the message is sent; `utime` is the sampling instant.
    pub stamp: Stamp,
    /// Whether the object is seen; if not, what follows tells nothing, and the pose is the identity.
    pub visible: bool,
    /// `r_from_o`.
    pub pose: Pose,
    /// Velocity of its origin in r, m/s; zero from a sensor that measures no velocities.
    pub velocity: Vector3<f64>,
    /// Angular velocity in r, rad/s; zero from a sensor that measures no velocities.
    pub angular_velocity: Vector3<f64>,
    /// Standard deviation of the position along each axis of r, m.
    pub position_sigma_m: f64,
}

impl Check for ObjectPose {
    fn check(&self) -> Result<(), Invalid> {
        self.stamp.check()?;
        finite_pose("object_pose", &self.pose)?;
        finite_vectors("object_velocity", &[self.velocity, self.angular_velocity])?;
        super::finite("object_position_sigma_m", [&self.position_sigma_m])?;
        in_range(
            "object_position_sigma_m",
            i64::from(self.position_sigma_m < 0.0),
            0,
            0,
        )
    }
}
