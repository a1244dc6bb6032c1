//! Wrench, deflection and compliance: what presses, how far it yields, and their ratio.

use crate::{Pose, rotation};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::ops::{Add, Mul, Sub};

/// Force and moment that the **environment exerts on the tool**, in the frame its variable names.
///
/// The one sign convention of all Touchdown: pressing down on a table gives a positive `force.z`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Force, N.
    pub force: Vector3<f64>,
    /// Moment about the frame's origin, Nm.
    pub moment: Vector3<f64>,
}

/// The small displacement from a nominal to a deflected frame, expressed in the nominal one: real minus virtual.
///
/// Pressing down on a table deflects upwards: a positive `translation.z`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deflection {
    /// Position of the deflected origin, m.
    pub translation: Vector3<f64>,
    /// Rotation vector from nominal to deflected, rad.
    pub rotation: Vector3<f64>,
}

/// Compliance of an elastic sensor about its own frame, eqs. (3) and (4): no coupling between the two blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compliance {
    /// `C_p`, m/N.
    pub translation: Matrix3<f64>,
    /// `C_phi`, rad/Nm.
    pub rotation: Matrix3<f64>,
}

impl Wrench {
    /// The power, W, that this wrench feeds into a body moving with `velocity` (m/s) and `angular_velocity`
    /// (rad/s), both at the wrench's own frame.
    pub fn power(&self, velocity: Vector3<f64>, angular_velocity: Vector3<f64>) -> f64 {
        self.force.dot(&velocity) + self.moment.dot(&angular_velocity)
    }
}

impl Deflection {
    /// The deflection as the transformation `a_from_a1`.
    pub fn to_pose(&self) -> Pose {
        Pose::from_parts(self.translation.into(), rotation::exp(self.rotation))
    }

    /// The deflection that the transformation `a_from_a1` describes.
    pub fn from_pose(a_from_a1: &Pose) -> Self {
        Self {
            translation: a_from_a1.translation.vector,
            rotation: rotation::log(&a_from_a1.rotation),
        }
    }

    /// The same deflection seen from frame b, which is mounted at `a_from_b` on both the nominal and the
    /// deflected side: `b_from_b1 = a_from_b^-1 * a_from_a1 * a_from_b`, exactly.
    ///
    /// The paper's (7), (8) are its first order; see the controller.
    pub fn seen_from(&self, a_from_b: &Pose) -> Self {
        Self::from_pose(&(a_from_b.inverse() * self.to_pose() * a_from_b))
    }
}

impl Compliance {
    /// A sensor equally stiff along all axes: `translation_m_per_n` and `rotation_rad_per_nm`.
    pub fn isotropic(translation_m_per_n: f64, rotation_rad_per_nm: f64) -> Self {
        Self {
            translation: Matrix3::identity() * translation_m_per_n,
            rotation: Matrix3::identity() * rotation_rad_per_nm,
        }
    }
}

/// Paper (3), (4): `p = C_p f`, `phi = C_phi m`.
impl Mul<Wrench> for Compliance {
    type Output = Deflection;

    fn mul(self, wrench: Wrench) -> Deflection {
        Deflection {
            translation: self.translation * wrench.force,
            rotation: self.rotation * wrench.moment,
        }
    }
}

/// Sum of two wrenches at the same frame.
impl Add for Wrench {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            force: self.force + other.force,
            moment: self.moment + other.moment,
        }
    }
}

/// Difference of two wrenches at the same frame: contact-only wrench = total - tare.
impl Sub for Wrench {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            force: self.force - other.force,
            moment: self.moment - other.moment,
        }
    }
}

impl Mul<f64> for Wrench {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            force: self.force * factor,
            moment: self.moment * factor,
        }
    }
}

/// Sum of two small deflections, to first order (rotation vectors add).
impl Add for Deflection {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            translation: self.translation + other.translation,
            rotation: self.rotation + other.rotation,
        }
    }
}

/// Difference of two small deflections, to first order: contact-only deflection = total - tare.
impl Sub for Deflection {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            translation: self.translation - other.translation,
            rotation: self.rotation - other.rotation,
        }
    }
}

impl Mul<f64> for Deflection {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            translation: self.translation * factor,
            rotation: self.rotation * factor,
        }
    }
}

/// A quaternion's four components as (w, x, y, z), the order of the wire.
pub(crate) fn components(rotation: &UnitQuaternion<f64>) -> [f64; 4] {
    let q = rotation.quaternion();
    [q.w, q.i, q.j, q.k]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
        [-limit..limit, -limit..limit, -limit..limit].prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn deflection_survives_the_round_trip_through_a_pose(p in vector(0.01), phi in vector(1.5)) {
            let deflection = Deflection { translation: p, rotation: phi };
            let back = Deflection::from_pose(&deflection.to_pose());
            prop_assert!((back.translation - p).norm() < 1e-15 && (back.rotation - phi).norm() < 1e-13);
        }

        #[test]
        fn seeing_from_another_frame_and_back_is_the_identity(
            p in vector(0.01), phi in vector(0.5), d in vector(0.3), turn in vector(1.5)
        ) {
            let deflection = Deflection { translation: p, rotation: phi };
            let a_from_b = crate::pose(d, turn);
            let back = deflection.seen_from(&a_from_b).seen_from(&a_from_b.inverse());
            prop_assert!((back.translation - p).norm() < 1e-14 && (back.rotation - phi).norm() < 1e-13);
        }
    }
}
