//! Six decoupled axes: the reference case.

use super::{Axes, join, split};
use crate::{Motion, Pose, rotation};
use nalgebra::Matrix6;

/// Six decoupled axes at the origin of s: three of translation (x, y, z) and one rotation vector.
///
/// `r_from_s = (position = axes 1-3, rotation = Exp(axes 4-6))`; all zero: s coincides with r.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gantry;

impl Gantry {
    /// The pose `r_from_s` at `axes`.
    pub fn forward(&self, axes: &Axes) -> Pose {
        let (position, turn) = split(axes);
        Pose::from_parts(position.into(), rotation::exp(turn))
    }

    /// The axes at which s is at `r_from_s`: the solution with a rotation of at most pi. Always exists.
    pub fn inverse(&self, r_from_s: &Pose) -> Axes {
        join(r_from_s.translation.vector, rotation::log(&r_from_s.rotation))
    }

    /// The Jacobian in r: rows velocity (m/s) and angular velocity (rad/s) of s, columns axes (rad/s).
    pub fn jacobian(&self, axes: &Axes) -> Matrix6<f64> {
        let mut jacobian = Matrix6::identity();
        let turn = split(axes).1;
        jacobian
            .fixed_view_mut::<3, 3>(3, 3)
            .copy_from(&rotation::left_jacobian(turn));
        jacobian
    }

    /// Motion of s in r from axis coordinates and their two derivatives.
    ///
    /// The rate of change of the rotational Jacobian is kept to first order,
    /// `d/dt J(v) v' = J v'' + (v' x (v x v'))...`, which vanishes for a turn about a fixed axis.
    pub fn motion(&self, axes: &Axes, rates: &Axes, changes: &Axes) -> Motion {
        let (position, turn) = split(axes);
        let (velocity, turn_rate) = split(rates);
        let (acceleration, turn_change) = split(changes);
        let jacobian = rotation::left_jacobian(turn);
        // J(v) = I + [v]/2 + [v]^2/6 + ...; its derivative times v', to second order in v.
        let coriolis = (turn_rate.cross(&(turn.cross(&turn_rate)))) / 6.0;
        Motion {
            pose: Pose::from_parts(position.into(), rotation::exp(turn)),
            velocity,
            angular_velocity: jacobian * turn_rate,
            acceleration,
            angular_acceleration: jacobian * turn_change + coriolis,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn axes() -> impl Strategy<Value = Axes> {
        [-1.5..1.5, -1.5..1.5, -1.5..1.5, -1.5..1.5, -1.5..1.5, -1.5..1.5].prop_map(Axes::from)
    }

    proptest! {
        #[test]
        fn inverse_inverts_forward(q in axes()) {
            let gantry = Gantry;
            prop_assert!((gantry.inverse(&gantry.forward(&q)) - q).norm() < 1e-12);
        }

        #[test]
        fn jacobian_matches_finite_differences(q in axes(), rate in axes()) {
            let gantry = Gantry;
            let h = 1e-6;
            let (before, after) = (gantry.forward(&(q - rate * h)), gantry.forward(&(q + rate * h)));
            let velocity = (after.translation.vector - before.translation.vector) / (2.0 * h);
            let turning = rotation::log(&(after.rotation * before.rotation.inverse())) / (2.0 * h);
            prop_assert!((gantry.jacobian(&q) * rate - join(velocity, turning)).norm() < 1e-7);
        }
    }

    #[test]
    fn motion_matches_finite_differences_at_working_angles() {
        // Within the few hundredths of a radian that a gantry turns, with all axes moving.
        let gantry = Gantry;
        let at = |t: f64| Axes::from([0.1, 0.2, 0.3, 0.02, -0.01, 0.03]) * libm::sin(3.0 * t + 0.4);
        let rate = |t: f64| at(t) * (3.0 * libm::cos(3.0 * t + 0.4) / libm::sin(3.0 * t + 0.4));
        let change = |t: f64| at(t) * -9.0;
        let h = 1e-5;
        let motion = |t: f64| gantry.motion(&at(t), &rate(t), &change(t));
        let (before, now, after) = (motion(-h), motion(0.0), motion(h));
        assert!(((after.velocity - before.velocity) / (2.0 * h) - now.acceleration).norm() < 1e-8);
        let numeric = (after.angular_velocity - before.angular_velocity) / (2.0 * h);
        assert!((numeric - now.angular_acceleration).norm() < 1e-6);
    }
}
