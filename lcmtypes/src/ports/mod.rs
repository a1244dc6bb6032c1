//! Port structs to and from the C structs of `types/*.lcm`, member by member.

mod controller;
mod node;
mod robot;
mod sensor;
mod simulation;
mod task;

use crate::codec::Codec;
use crate::error::Unusable;
use nalgebra::{Matrix3, Vector3};
use spatial::ports::Invalid;
use spatial::{Pose, kinematics};
use std::ffi::CStr;

/// Which C struct and which channel belong to a port struct.
pub trait Wire {
    /// The C struct.
    type Raw: Codec;
    /// Name of the channel.
    const NAME: &'static CStr;
}

/// The same values in two layouts. Neither way changes a bit of a number.
pub trait Port: Wire + Sized {
    /// As the C struct.
    fn to_raw(&self) -> Self::Raw;

    /// From the C struct; refused where it can't be said as `Self`.
    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable>;
}

/// A position and a quaternion (w, x, y, z).
fn from_pose(pose: &Pose) -> ([f64; 3], [f64; 4]) {
    let q = pose.rotation.quaternion();
    (pose.translation.vector.into(), [q.w, q.i, q.j, q.k])
}

fn to_pose(position: [f64; 3], quaternion: [f64; 4]) -> Pose {
    Pose::from_parts(Vector3::from(position).into(), kinematics::quaternion(quaternion))
}

/// Row by row; nalgebra stores column by column.
fn from_matrix(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    matrix.transpose().into()
}

fn to_matrix(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from(rows).transpose()
}

fn to_bool(field: &'static str, value: i8) -> Result<bool, Unusable> {
    in_range(field, value.into(), 0, 1)?;
    Ok(value == 1)
}

fn in_range(field: &'static str, value: i64, minimum: i64, maximum: i64) -> Result<(), Unusable> {
    if (minimum..=maximum).contains(&value) {
        return Ok(());
    }
    Err(Invalid::OutOfRange {
        field,
        value,
        minimum,
        maximum,
    }
    .into())
}

/// The members of a C struct that hold an [`Authenticity`].
macro_rules! authenticity {
    ($raw:ident) => {
        spatial::ports::Authenticity {
            session: $raw.session,
            seq: $raw.seq,
            key_id: $raw.key_id,
            tag: $raw.tag,
        }
    };
}

/// The members of a C struct that hold a [`Stamp`](spatial::ports::Stamp).
macro_rules! stamp {
    ($raw:ident) => {
        spatial::ports::Stamp {
            step: $raw.step,
            utime: $raw.utime,
            boot_id: $raw.boot_id,
        }
    };
}
use {authenticity, stamp};
