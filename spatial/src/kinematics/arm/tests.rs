//! The arm against independent formulas and an analytic solution.

use super::*;
use crate::kinematics::split;
use nalgebra::Matrix3;
use proptest::prelude::*;

fn arm() -> Arm {
    Arm {
        base_in_r: Vector3::new(0.1, -0.2, 0.3),
    }
}

/// Anything within the ranges of PLANT.md section 2.
fn anywhere() -> impl Strategy<Value = Axes> {
    [-3.2..3.2, -2.7..0.6, -2.2..2.6, -6.1..6.1, -2.2..2.2, -6.1..6.1].prop_map(Axes::from)
}

/// Around the working posture, wrist and elbow bent.
fn regular() -> impl Strategy<Value = Axes> {
    [-1.0..1.0, -1.9..-1.0, 1.4..2.2, -0.8..0.8, 0.6..1.6, -1.5..1.5].prop_map(Axes::from)
}

fn about_x(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

fn about_y(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

fn about_z(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

proptest! {
    /// The wrist's position by plane trigonometry, the rotation as a product of matrices.
    #[test]
    fn forward_matches_plane_trigonometry(q in anywhere()) {
        let (s2, c2) = libm::sincos(q[1]);
        let (s3, c3) = libm::sincos(q[1] + q[2]);
        let (s1, c1) = libm::sincos(q[0]);
        let radius = 0.26 + 0.68 * c2 + 0.67 * c3 - 0.035 * s3;
        let height = 0.675 - 0.68 * s2 - 0.67 * s3 - 0.035 * c3;
        let flange = about_z(-q[0]) * about_y(q[1] + q[2]) * about_x(-q[3]) * about_y(q[4]) * about_x(-q[5]);
        let position = arm().base_in_r
            + Vector3::new(c1 * radius, -s1 * radius, height)
            + flange * Vector3::new(0.158, 0.0, 0.0);
        let pose = arm().forward(&q);
        prop_assert!((pose.translation.vector - position).norm() < 1e-14);
        let rotation = flange * about_y(-std::f64::consts::FRAC_PI_2);
        prop_assert!((pose.rotation.to_rotation_matrix().matrix() - rotation).norm() < 1e-14);
    }

    #[test]
    fn jacobian_matches_finite_differences(q in anywhere(), rate in anywhere()) {
        let h = 1e-6;
        let (before, after) = (arm().forward(&(q - rate * h)), arm().forward(&(q + rate * h)));
        let numeric = newton::weighted_error(&after, &before) / (2.0 * h);
        prop_assert!((arm().jacobian(&q) * rate - numeric).norm() < 1e-7 * (1.0 + rate.norm()));
    }

    #[test]
    fn motion_matches_finite_differences(q in anywhere(), rate in anywhere(), change in anywhere()) {
        let h = 1e-5;
        let at = |t: f64| arm().motion(&(q + rate * t + change * (0.5 * t * t)), &(rate + change * t), &change);
        let (before, now, after) = (at(-h), at(0.0), at(h));
        let linear = (after.velocity - before.velocity) / (2.0 * h) - now.acceleration;
        let angular = (after.angular_velocity - before.angular_velocity) / (2.0 * h) - now.angular_acceleration;
        // The third derivative grows with the cube of the speed, here up to 12 rad/s.
        prop_assert!(linear.norm() < 1e-4 && angular.norm() < 1e-4, "{linear} {angular}");
        let twist = arm().jacobian(&q) * rate;
        prop_assert!((join(now.velocity, now.angular_velocity) - twist).norm() < 1e-12 * (1.0 + rate.norm()));
    }

    #[test]
    fn inverse_inverts_forward_on_the_branch_nearby(q in regular(), way in anywhere()) {
        let near = q + way * (0.1 / way.norm().max(0.1));
        let found = arm().inverse(&arm().forward(&q), &near).unwrap();
        prop_assert!((found - q).norm() < 1e-8, "{}", found - q);
    }

    #[test]
    fn inverse_is_one_of_the_analytic_solutions(q in regular()) {
        let pose = arm().forward(&q);
        let found = arm().inverse(&pose, &(q + Axes::repeat(0.02))).unwrap();
        let nearest = analytic(&pose).iter().map(|other| (other - found).norm()).fold(f64::INFINITY, f64::min);
        prop_assert!(nearest < 1e-6, "{nearest}");
    }

    #[test]
    fn what_is_out_of_reach_is_refused(direction in anywhere()) {
        let way = split(&direction).0;
        prop_assume!(way.norm() > 0.1);
        let shoulder = arm().base_in_r + Vector3::new(0.0, 0.0, 0.675);
        let pose = Pose::from_parts((shoulder + way * (1.9 / way.norm())).into(), UnitQuaternion::identity());
        let out_of_reach = matches!(arm().inverse(&pose, &Arm::WORKING), Err(Unreachable::Residual { .. }));
        prop_assert!(out_of_reach);
        prop_assert!(arm().reach(&pose).is_err());
    }
}

/// All solutions of Brandstoetter, Angerer and Hofbaur for an ortho-parallel base and a spherical wrist, as the crate
/// rs-opw-kinematics computes them. There, zero is the arm stretched upwards and the tool points along z.
fn analytic(r_from_s: &Pose) -> Vec<Axes> {
    use rs_opw_kinematics::{
        glam, kinematic_traits::Kinematics, kinematics_impl, parameters::opw_kinematics,
    };
    use std::f64::consts::{FRAC_PI_2, PI};
    let robot = kinematics_impl::OPWKinematics::new(opw_kinematics::Parameters {
        a1: 0.26,
        a2: 0.035,
        b: 0.0,
        c1: 0.675,
        c2: 0.68,
        c3: 0.67,
        c4: 0.158,
        offsets: [0.0, -FRAC_PI_2, 0.0, 0.0, 0.0, 0.0],
        sign_corrections: [-1, 1, 1, -1, 1, -1],
        dof: 6,
    });
    let position = r_from_s.translation.vector - arm().base_in_r;
    let turn = (r_from_s.rotation * rotation::exp(Vector3::y() * PI)).into_inner();
    let solutions = robot.inverse(&rs_opw_kinematics::kinematic_traits::Pose::from_parts(
        glam::DVec3::new(position.x, position.y, position.z),
        glam::DQuat::from_xyzw(turn.i, turn.j, turn.k, turn.w),
    ));
    solutions.into_iter().map(Axes::from).collect()
}

#[test]
fn the_reference_postures_of_the_plant() {
    let arm = Arm {
        base_in_r: Vector3::zeros(),
    };
    let stretched = arm.forward(&Axes::zeros());
    assert!((stretched.translation.vector - Vector3::new(1.768, 0.0, 0.640)).norm() < 1e-12);
    let working = arm.forward(&Arm::WORKING);
    assert!((working.translation.vector - Vector3::new(0.9, 0.0, 0.9)).norm() < 1e-9);
    assert!(rotation::log(&working.rotation).norm() < 1e-9);
    assert!(newton::smallest_singular_value(&arm.jacobian(&Arm::WORKING)) > 0.1);
}

#[test]
fn singular_postures_are_refused_and_named() {
    for aligned in [
        Axes::new(0.0, -1.5, 1.9, 0.2, 1e-3, 0.1),
        Axes::new(0.3, -0.4, 0.054, 0.0, 1.0, 0.0),
    ] {
        let error = arm().inverse(&arm().forward(&aligned), &aligned).unwrap_err();
        assert!(matches!(error, Unreachable::Singular { .. }), "{error}");
        assert!(error.to_string().contains("smallest singular value"), "{error}");
    }
}

#[test]
fn poses_far_from_home_are_reached() {
    let home = arm().forward(&Arm::WORKING);
    for (shift, turn) in [
        (Vector3::new(0.2, 0.5, -0.6), Vector3::new(0.3, -0.2, 0.5)),
        (Vector3::new(-0.2, -0.6, 0.2), Vector3::new(0.0, 0.3, -1.0)),
    ] {
        let pose = Pose::from_parts(
            (home.translation.vector + shift).into(),
            rotation::exp(turn) * home.rotation,
        );
        let found = arm().forward(&arm().reach(&pose).unwrap());
        assert!(newton::weighted_error(&pose, &found).norm() < 1e-9);
    }
}
