//! Between sensor and tcp, and from deflections to the desired pose: the paper's eqs. (3)-(12).
//!
//! `d` is the vector from the sensor to the tcp in s (m); s and t are parallel. (3) and (4) are
//! [`Compliance`]` * `[`Wrench`].
//!
//! The equations as the paper has them. [`crate::posture`] composes them: as they stand
//! (`controller.transform = "twist"`), or with (7)-(10), which are 0.8 % off, in exact form (`"exact"`).

use nalgebra::Vector3;
use spatial::{Compliance, Deflection, Pose, Wrench};

/// Paper (5), (6): the wrench at the sensor of a wrench at the tcp, `f_s = f_t`, `m_s = m_t + d x f_t`.
pub fn wrench_at_sensor(wrench_at_t: &Wrench, d: Vector3<f64>) -> Wrench {
    Wrench {
        force: wrench_at_t.force,
        moment: wrench_at_t.moment + d.cross(&wrench_at_t.force),
    }
}

/// Paper (7), (8) solved for the tcp: `p_t = p_s - d x phi_s`, `phi_t = phi_s`.
///
/// First order of footnote 5, which is [`Deflection::seen_from`]; 0.56 um off at 2.5 mrad and d = 0.18 m.
pub fn deflection_at_tcp(deflection_at_s: &Deflection, d: Vector3<f64>) -> Deflection {
    Deflection {
        translation: deflection_at_s.translation - d.cross(&deflection_at_s.rotation),
        rotation: deflection_at_s.rotation,
    }
}

/// Paper (7), (8): the deflection at the sensor, `p_s = p_t + d x phi_t`, `phi_s = phi_t`.
pub fn deflection_at_sensor(deflection_at_t: &Deflection, d: Vector3<f64>) -> Deflection {
    Deflection {
        translation: deflection_at_t.translation + d.cross(&deflection_at_t.rotation),
        rotation: deflection_at_t.rotation,
    }
}

/// Paper (9), (10): the deflection at the tcp, in t, under the desired wrench at the tcp.
///
/// `p_td = C_p f - d x (C_phi (m + d x f))`, `phi_td = C_phi (m + d x f)`.
pub fn desired_deflection(compliance: &Compliance, desired_at_t: &Wrench, d: Vector3<f64>) -> Deflection {
    deflection_at_tcp(&(*compliance * wrench_at_sensor(desired_at_t, d)), d)
}

/// Paper (12): the object's pose `r_from_o`, where the deflected tcp is: `T_ta T_ta'`.
pub fn object_pose(r_from_ta: &Pose, ta_from_ta1: &Pose) -> Pose {
    r_from_ta * ta_from_ta1
}

/// Paper (11) in the form of footnote 7: the nominal tcp's pose at which the object is met with the desired
/// deflection, `r_from_td = r_from_o * td_from_td1^-1`.
pub fn desired_pose(r_from_o: &Pose, td_from_td1: &Pose) -> Pose {
    r_from_o * td_from_td1.inverse()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
        [-limit..limit, -limit..limit, -limit..limit].prop_map(Vector3::from)
    }

    fn sensor() -> Compliance {
        Compliance::isotropic(1.0 / 300e3, 1.0 / 401.07)
    }

    proptest! {
        /// The work of a wrench in a small displacement is the same at the sensor and at the tcp.
        #[test]
        fn power_is_the_same_at_sensor_and_tcp(
            f in vector(100.0), m in vector(10.0), p in vector(0.1), phi in vector(0.1), d in vector(0.3)
        ) {
            let at_t = Wrench { force: f, moment: m };
            let deflection_at_t = Deflection { translation: p, rotation: phi };
            let at_s = wrench_at_sensor(&at_t, d);
            let deflection_at_s = deflection_at_sensor(&deflection_at_t, d);
            let work_at_t = at_t.power(p, phi);
            let work_at_s = at_s.power(deflection_at_s.translation, deflection_at_s.rotation);
            prop_assert!((work_at_t - work_at_s).abs() < 1e-12 * (1.0 + work_at_t.abs()));
        }

        #[test]
        fn sensor_and_tcp_deflections_are_inverse(p in vector(0.01), phi in vector(0.1), d in vector(0.3)) {
            let at_s = Deflection { translation: p, rotation: phi };
            let back = deflection_at_sensor(&deflection_at_tcp(&at_s, d), d);
            prop_assert!((back.translation - p).norm() < 1e-16);
        }

        /// (7), (8) are the first order of footnote 5: halving the angle quarters the error.
        #[test]
        fn the_twist_errs_with_the_square_of_the_angle(phi in vector(1.0), d in vector(0.3)) {
            prop_assume!(phi.norm() > 0.2 && phi.cross(&phi.cross(&d)).norm() > 0.01);
            let s_from_t = Pose::translation(d.x, d.y, d.z);
            let error = |angle: f64| {
                let at_s = Deflection { translation: Vector3::zeros(), rotation: phi * angle };
                let exact = at_s.seen_from(&s_from_t);
                (exact.translation - deflection_at_tcp(&at_s, d).translation).norm()
            };
            let ratio = error(2e-3) / error(1e-3);
            prop_assert!((3.98..4.02).contains(&ratio), "{ratio}");
        }

        #[test]
        fn the_desired_pose_shows_the_desired_deflection(
            p in vector(1e-3), phi in vector(0.02), position in vector(1.0), turn in vector(1.0)
        ) {
            let td_from_td1 = Deflection { translation: p, rotation: phi }.to_pose();
            let r_from_o = spatial::pose(position, turn);
            let r_from_td = desired_pose(&r_from_o, &td_from_td1);
            let found = object_pose(&r_from_td, &td_from_td1);
            prop_assert!((found.translation.vector - position).norm() < 1e-14);
            prop_assert!(found.rotation.angle_to(&r_from_o.rotation) < 1e-7);
        }
    }

    /// PLANT.md section 5: 10 N along z at d = (0.10, 0, -0.15) m.
    #[test]
    fn the_reference_posture_of_the_paper() {
        let d = Vector3::new(0.10, 0.0, -0.15);
        let wrench = Wrench {
            force: Vector3::new(0.0, 0.0, 10.0),
            moment: Vector3::zeros(),
        };
        let at_s = sensor() * wrench_at_sensor(&wrench, d);
        assert!((at_s.translation.z - 33.3e-6).abs() < 0.1e-6);
        assert!((at_s.rotation.y - -2.493e-3).abs() < 0.001e-3);
        let at_t = desired_deflection(&sensor(), &wrench, d);
        assert!((at_t.translation - Vector3::new(374.0e-6, 0.0, 282.7e-6)).norm() < 0.1e-6);
    }
}
