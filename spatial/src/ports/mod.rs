//! What crosses a node's border, as plain structs: one per LCM channel.
//!
//! The wire's encoding, channel names and fingerprints live in `lcmtypes`; a node's library only sees these.
//! Every struct has a [`Check`], called before a message is published and before one is used.

mod authenticity;
mod command;
mod controller;
mod fault;
mod node;
mod robot;
mod sensor;
mod simulation;
mod task;

pub use authenticity::Authenticity;
pub use command::{Command, HORIZON};
pub use controller::{
    ControllerPhase, ControllerStatus, Detection, ImpactAssessment, LIMIT_ACCELERATION, LIMIT_AXIS,
    LIMIT_COLLISION_FORCE_X, LIMIT_DEFLECTION, LIMIT_DRIFT, LIMIT_FORCE, LIMIT_LEAD, LIMIT_SEEK,
    LIMIT_STEP_SEARCH, LIMIT_STEP_TIME, LIMIT_STEP_TOLERANCE, LIMIT_VELOCITY, LIMIT_WORKSPACE, Law,
};
pub use fault::Fault;
pub use node::{Hello, Latencies, LinkQuality, NodeState, NodeStatus, PROTOCOL, Role};
pub use robot::{ClockEcho, ENCODER_SAMPLES, RobotMode, RobotState};
pub use sensor::{DEFLECTION_SAMPLES, DeflectionSample, Deflections, ObjectPose, SampleFlags};
pub use simulation::{LinkMotion, ToolMotion, Truth};
pub use task::{ParameterAnswer, Task, TaskAction, TaskParameters};

use crate::{Pose, elastic::components};
use nalgebra::Vector3;

/// The head of every message.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamp {
    /// Tick (1 ms) that the message belongs to.
    pub step: i64,
    /// Sampling instant on the sender's clock, us; in lockstep tick times 1000.
    pub utime: i64,
    /// Random per process start; in lockstep a function of seed and role.
    pub boot_id: i64,
}

impl Stamp {
    /// Whether the time is that of the tick, as in lockstep.
    pub fn is_lockstep(&self) -> bool {
        self.utime == self.step * crate::TICK_US
    }

    /// Steps and times beyond any experiment's would overflow in arithmetic.
    fn check(&self) -> Result<(), Invalid> {
        in_range("step", self.step, -1, LATEST_STEP)?;
        check_utime(self.utime)
    }

    /// The stamp of tick `step` in lockstep: simulated time, and a boot id that the seed and the role determine.
    pub fn lockstep(step: i64, seed: i64, role: Role) -> Self {
        // SplitMix64's output function: neighbouring seeds and roles give unrelated ids.
        let mut z = (seed as u64).wrapping_mul(4).wrapping_add(role as u64 + 1);
        z = z.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self {
            step,
            utime: step * crate::TICK_US,
            boot_id: ((z ^ (z >> 31)) >> 1) as i64,
        }
    }
}

/// A value of a message that can't be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Invalid {
    /// Infinite or not a number.
    #[error("{field} is {value}, not a finite number; the message is refused")]
    NotFinite {
        /// Name of the field.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// A quaternion whose norm is not 1.
    #[error("{field} has norm {norm}, not 1 within 1e-6; the message is refused")]
    NotNormalised {
        /// Name of the field.
        field: &'static str,
        /// Its norm.
        norm: f64,
    },
    /// A value outside what the field can mean.
    #[error("{field} is {value}, outside {minimum}..={maximum}; the message is refused")]
    OutOfRange {
        /// Name of the field.
        field: &'static str,
        /// Its value.
        value: i64,
        /// Smallest meaningful value.
        minimum: i64,
        /// Largest meaningful value.
        maximum: i64,
    },
}

/// Whether a message can be used at all: finite numbers, unit quaternions, counts in range.
pub trait Check {
    /// `Ok` or the first value that can't be used.
    fn check(&self) -> Result<(), Invalid>;
}

/// Ticks of 285 years.
const LATEST_STEP: i64 = 9_000_000_000_000;

/// A time within 285 years of the clock's epoch, either way.
fn check_utime(utime: i64) -> Result<(), Invalid> {
    let latest = LATEST_STEP * crate::TICK_US;
    in_range("utime", utime, -latest, latest)
}

/// How far a quaternion's norm may be from 1: beyond any rounding, below any harm.
const NORM_TOLERANCE: f64 = 1e-6;

fn finite<'a>(field: &'static str, values: impl IntoIterator<Item = &'a f64>) -> Result<(), Invalid> {
    match values.into_iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(Invalid::NotFinite { field, value }),
        None => Ok(()),
    }
}

fn finite_vectors(field: &'static str, vectors: &[Vector3<f64>]) -> Result<(), Invalid> {
    vectors.iter().try_for_each(|vector| finite(field, vector.iter()))
}

fn finite_pose(field: &'static str, pose: &Pose) -> Result<(), Invalid> {
    finite(field, pose.translation.vector.iter())?;
    let q = components(&pose.rotation);
    finite(field, &q)?;
    let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    if (norm - 1.0).abs() > NORM_TOLERANCE {
        return Err(Invalid::NotNormalised { field, norm });
    }
    Ok(())
}

fn in_range(field: &'static str, value: i64, minimum: i64, maximum: i64) -> Result<(), Invalid> {
    if (minimum..=maximum).contains(&value) {
        return Ok(());
    }
    Err(Invalid::OutOfRange {
        field,
        value,
        minimum,
        maximum,
    })
}

/// An enumeration whose discriminants are the constants of a .lcm file.
macro_rules! wire_enum {
    ($(#[$meta:meta])* $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $value:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(i32)]
        pub enum $name {
            $($(#[$variant_meta])* $variant = $value,)*
        }

        impl $name {
            /// Every value, in the order of the wire's constants.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// The value that the wire's constant `code` stands for.
            pub fn from_code(code: i32) -> Result<Self, $crate::ports::Invalid> {
                match code {
                    $($value => Ok(Self::$variant),)*
                    _ => Err($crate::ports::Invalid::OutOfRange {
                        field: stringify!($name),
                        value: i64::from(code),
                        minimum: 0,
                        maximum: Self::ALL.len() as i64 - 1,
                    }),
                }
            }

            /// The wire's constant.
            pub fn code(self) -> i32 {
                self as i32
            }

            /// The variant's name.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => stringify!($variant),)*
                }
            }
        }
    };
}
use wire_enum;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_must_be_finite_and_normalised() {
        let mut pose = Pose::identity();
        assert_eq!(finite_pose("pose", &pose), Ok(()));
        pose.translation.vector.y = f64::NAN;
        assert!(matches!(
            finite_pose("pose", &pose),
            Err(Invalid::NotFinite { field: "pose", .. })
        ));
        pose.translation.vector.y = 0.0;
        pose.rotation = crate::kinematics::quaternion([1.0, 0.01, 0.0, 0.0]);
        assert!(matches!(
            finite_pose("pose", &pose),
            Err(Invalid::NotNormalised { .. })
        ));
    }

    #[test]
    fn codes_survive_the_round_trip_and_unknown_ones_are_refused() {
        for &fault in Fault::ALL {
            assert_eq!(Fault::from_code(fault.code()), Ok(fault));
        }
        let message = Fault::from_code(999).unwrap_err().to_string();
        assert!(message.starts_with("Fault is 999, outside 0..="), "{message}");
    }
}
