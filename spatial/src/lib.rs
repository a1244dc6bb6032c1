//! The vocabulary that all of Touchdown shares. Pure: no socket, no clock, no thread, no randomness.
//!
//! | Quantity | Type | Unit | Frame |
//! |---|---|---|---|
//! | pose `a_from_b` of frame b in frame a | [`Pose`] | m, rad | maps coordinates in b to coordinates in a |
//! | [`Wrench`]: what the **environment exerts on the tool** | `force`, `moment` | N, Nm | named by the variable (`wrench_at_s`) |
//! | [`Deflection`] from a nominal to a deflected frame | `translation`, `rotation` | m, rad | the nominal frame (`deflection_at_s`: s -> s') |
//! | [`Compliance`] of the sensor, only `Compliance * Wrench -> Deflection` | two 3 x 3 blocks | m/N, rad/Nm | sensor |
//! | [`Motion`] of a frame: pose, velocities, accelerations | | m, rad, s | reference |
//!
//! Frames: `r` reference (z up), `s` nominal sensor frame on the robot's last link, `s1` (s') the deflected
//! sensor frame on the tool plate, `t` the tcp (parallel to s), `ta`, `td` its actual and desired pose, `o` the
//! object. A trailing `1` is the paper's prime. Neighbours cancel: `r_from_s * s_from_t = r_from_t`.
//! SI units and radians everywhere. A rotation as a vector is a rotation vector (axis times angle).

mod elastic;
pub mod kinematics;
mod motion;
pub mod ports;
pub mod rotation;
mod spring;

pub use elastic::{Compliance, Deflection, Wrench};
pub use motion::{Motion, MotionSegment};
pub use spring::ToolSuspension;

use nalgebra::{Isometry3, Vector3};

/// A rigid transformation in SE(3); `a_from_b` maps coordinates in b to coordinates in a.
pub type Pose = Isometry3<f64>;

/// One tick: servo, sensor sampling and the exchange of the physics, s.
pub const TICK_S: f64 = 0.001;

/// One tick, us: the unit of `utime` on the wire.
pub const TICK_US: i64 = 1000;

/// Standard gravity, m/s^2 (the CGPM's conventional value), along -z of r.
pub const GRAVITY_M_PER_S2: f64 = 9.80665;

/// The pose at `position` (m) turned by `rotation_vector` (rad).
pub fn pose(position: Vector3<f64>, rotation_vector: Vector3<f64>) -> Pose {
    Pose::from_parts(position.into(), rotation::exp(rotation_vector))
}
