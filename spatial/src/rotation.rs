//! Rotations as rotation vectors: the exponential map of SO(3), its inverse and its Jacobian.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Square of an angle (rad) up to which a few terms of a Taylor series are exact to within rounding: within a tick
/// and within the sensor's range all rotations are that small, and the series take a tenth of the time.
const SMALL: f64 = 2e-3;

/// The rotation by |v| about v (rad): Exp of SO(3), `(cos |v|/2, sin(|v|/2) v/|v|)`.
#[inline]
pub fn exp(v: Vector3<f64>) -> UnitQuaternion<f64> {
    let square = 0.25 * v.norm_squared();
    let (cosine, sine_ratio) = if square < SMALL {
        (
            1.0 - square
                * (1.0 / 2.0 - square * (1.0 / 24.0 - square * (1.0 / 720.0 - square * (1.0 / 40320.0)))),
            1.0 - square
                * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0 - square * (1.0 / 362880.0)))),
        )
    } else {
        let half = square.sqrt();
        let (sine, cosine) = libm::sincos(half);
        (cosine, sine / half)
    };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, v * (0.5 * sine_ratio)))
}

/// The rotation vector (rad, |v| <= pi) of a rotation: Log of SO(3).
///
/// Evaluated as `2 atan2(|q_v|, |q_w|) q_v / |q_v|`, which keeps full relative accuracy near zero.
#[inline]
pub fn log(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = rotation.quaternion();
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    let vector = q.imag() * sign;
    let cosine = q.w * sign;
    let square = vector.norm_squared();
    if square < SMALL * cosine * cosine {
        // atan(x)/x with x = |q_v|/|q_w|.
        let t = square / (cosine * cosine);
        let ratio = 1.0 - t * (1.0 / 3.0 - t * (0.2 - t * (1.0 / 7.0 - t * (1.0 / 9.0 - t * (1.0 / 11.0)))));
        return vector * (2.0 * ratio / cosine);
    }
    let sine = square.sqrt();
    vector * (2.0 * libm::atan2(sine, cosine) / sine)
}

/// The matrix of the cross product, `skew(a) b = a x b`.
pub fn skew(a: Vector3<f64>) -> Matrix3<f64> {
    a.cross_matrix()
}

/// The left Jacobian J of Exp: the angular velocity, in the fixed frame, of `Exp(v(t))` is `J(v) dv/dt`.
///
/// `J = I + (1 - cos a)/a^2 [v] + (a - sin a)/a^3 [v]^2` with `a = |v|`
/// (e.g. Barfoot, State Estimation for Robotics, eq. 7.77).
pub fn left_jacobian(v: Vector3<f64>) -> Matrix3<f64> {
    let (first, second) = left_jacobian_factors(v);
    // [v]^2 = v v^T - |v|^2 I.
    let straight = Matrix3::from_diagonal_element(1.0 - v.norm_squared() * second);
    straight + skew(v) * first + v * (v * second).transpose()
}

/// The angular velocity of `Exp(v)` in the fixed frame while v changes at `rate`: `J(v) rate`.
#[inline]
pub fn angular_velocity(v: Vector3<f64>, rate: Vector3<f64>) -> Vector3<f64> {
    let (first, second) = left_jacobian_factors(v);
    let across = v.cross(&rate);
    rate + across * first + v.cross(&across) * second
}

/// The factors of [v] and [v]^2 in [`left_jacobian`].
#[inline]
fn left_jacobian_factors(v: Vector3<f64>) -> (f64, f64) {
    let square = v.norm_squared();
    if square < 1e-4 {
        // Taylor series: the closed forms cancel here; the next terms are below 1e-16.
        (
            0.5 - square / 24.0 + square * square / 720.0,
            1.0 / 6.0 - square / 120.0 + square * square / 5040.0,
        )
    } else {
        let angle = square.sqrt();
        let (sine, cosine) = libm::sincos(angle);
        ((1.0 - cosine) / square, (angle - sine) / (square * angle))
    }
}

/// The inverse of [`left_jacobian`], for |v| < 2 pi.
///
/// `J^-1 = I - [v]/2 + (1/a^2 - (1 + cos a)/(2 a sin a)) [v]^2`.
pub fn left_jacobian_inverse(v: Vector3<f64>) -> Matrix3<f64> {
    let k = skew(v);
    Matrix3::identity() - k * 0.5 + k * k * left_jacobian_inverse_factor(v)
}

/// The rate of change of v at which `Exp(v)` turns with `angular_velocity` in the fixed frame: `J(v)^-1 w`.
#[inline]
pub fn rate_of_change(v: Vector3<f64>, angular_velocity: Vector3<f64>) -> Vector3<f64> {
    let across = v.cross(&angular_velocity);
    angular_velocity - across * 0.5 + v.cross(&across) * left_jacobian_inverse_factor(v)
}

/// The factor of [v]^2 in [`left_jacobian_inverse`].
#[inline]
fn left_jacobian_inverse_factor(v: Vector3<f64>) -> f64 {
    let square = v.norm_squared();
    if square < 1e-4 {
        1.0 / 12.0 + square / 720.0 + square * square / 30240.0
    } else {
        let half = 0.5 * square.sqrt();
        let (sine, cosine) = libm::sincos(half);
        (1.0 - half * cosine / sine) / square
    }
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
        fn log_inverts_exp(v in vector(1.8)) {
            prop_assert!((log(&exp(v)) - v).norm() < 1e-13 * (1.0 + v.norm()));
        }

        #[test]
        fn log_inverts_exp_of_tiny_rotations(v in vector(1.0), exponent in 0..16) {
            let v = v * libm::pow(10.0, -f64::from(exponent));
            prop_assert!((log(&exp(v)) - v).norm() <= 1e-14 * v.norm());
        }

        #[test]
        fn log_takes_the_short_way(v in vector(1.8)) {
            let far = UnitQuaternion::new_unchecked(-exp(v).into_inner());
            prop_assert!((log(&far) - v).norm() < 1e-13 * (1.0 + v.norm()));
        }

        #[test]
        fn left_jacobian_is_the_derivative_of_exp(v in vector(1.7), d in vector(1.0)) {
            let h = 1e-6;
            let turn = exp(v + d * h) * exp(v - d * h).inverse();
            let numeric = log(&turn) / (2.0 * h);
            prop_assert!((left_jacobian(v) * d - numeric).norm() < 1e-8);
            prop_assert!((left_jacobian(v) * d - angular_velocity(v, d)).norm() < 1e-14);
        }

        #[test]
        fn left_jacobian_inverse_inverts(v in vector(1.8), scale in prop_oneof![Just(1.0), Just(1e-2), Just(1e-5)]) {
            let v = v * scale;
            let product = left_jacobian(v) * left_jacobian_inverse(v);
            prop_assert!((product - Matrix3::identity()).norm() < 1e-12);
            let d = Vector3::new(0.3, -0.5, 0.7);
            prop_assert!((left_jacobian_inverse(v) * d - rate_of_change(v, d)).norm() < 1e-14);
        }
    }

    #[test]
    fn series_and_closed_form_meet() {
        for factor in [0.999_999, 1.000_001] {
            let v = Vector3::new(0.6, -0.48, 0.64) * (2.0 * SMALL.sqrt() * factor);
            let q = exp(v);
            let half = 0.5 * v.norm();
            assert!((q.w - libm::cos(half)).abs() < 2e-16);
            assert!((q.imag() - v * (libm::sin(half) / v.norm())).norm() < 2e-17);
            assert!((log(&q) - v).norm() < 2e-17);
        }
        let v = Vector3::new(0.006, -0.006, 0.005_291_5);
        let below = v * (0.999_999 * 0.01 / v.norm());
        let above = v * (1.000_001 * 0.01 / v.norm());
        assert!((left_jacobian(below) - left_jacobian(above)).norm() < 1e-7);
        assert!((left_jacobian_inverse(below) - left_jacobian_inverse(above)).norm() < 1e-7);
    }
}
