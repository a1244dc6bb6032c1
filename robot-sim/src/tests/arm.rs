//! The arm's links: mass matrix, velocity terms, energy.

use super::*;
use crate::arm_links::ArmLinks;
use nalgebra::Cholesky;
use node::scenario::{Gears, Kinematics};
use proptest::prelude::*;
use spatial::kinematics::Arm;

fn links() -> ArmLinks {
    ArmLinks::new(&Scenario::default().robot.arm)
}

fn anywhere() -> impl Strategy<Value = Axes> {
    [-3.2..3.2, -2.7..0.6, -2.2..2.6, -6.1..6.1, -2.2..2.2, -6.1..6.1].prop_map(Axes::from)
}

/// Kinetic energy from the motion of each link, by finite differences of its pose.
fn kinetic_energy(links: &ArmLinks, position: &Axes, velocity: &Axes) -> f64 {
    let h = 1e-6;
    let (before, now, after) = (
        links.arm.joints(&(position - velocity * h)),
        links.arm.joints(position),
        links.arm.joints(&(position + velocity * h)),
    );
    (0..6)
        .map(|i| {
            let link = &links.links[i];
            let centre = |joint: &spatial::kinematics::Joint| joint.origin + joint.rotation * link.centre;
            let speed = (centre(&after[i]) - centre(&before[i])) / (2.0 * h);
            let turn =
                spatial::rotation::log(&(after[i].rotation * before[i].rotation.inverse())) / (2.0 * h);
            let turn = now[i].rotation.inverse() * turn;
            0.5 * link.mass * speed.norm_squared() + 0.5 * link.inertia.dot(&turn.component_mul(&turn))
        })
        .sum()
}

proptest! {
    #[test]
    fn the_mass_matrix_gives_the_kinetic_energy(q in anywhere(), v in anywhere()) {
        let mass = links().mass_matrix(&q);
        let expected = kinetic_energy(&links(), &q, &v);
        prop_assert!((0.5 * v.dot(&(mass * v)) - expected).abs() < 1e-6 * (1.0 + expected));
        prop_assert!(Cholesky::new(mass).is_some() && (mass - mass.transpose()).norm() == 0.0);
    }

    /// Lagrange: `c = dM/dt v - 1/2 grad_q (v^T M v)`.
    #[test]
    fn the_velocity_terms_follow_from_the_mass_matrix(q in anywhere(), v in anywhere()) {
        let h = 1e-5;
        let links = links();
        let rate = (links.mass_matrix(&(q + v * h)) - links.mass_matrix(&(q - v * h))) / (2.0 * h);
        let gradient = Axes::from_fn(|i, _| {
            let step = Axes::ith(i, h);
            let change = links.mass_matrix(&(q + step)) - links.mass_matrix(&(q - step));
            v.dot(&(change * v)) / (2.0 * h)
        });
        let expected = rate * v - gradient * 0.5;
        let bias = links.at(&q, &v).bias;
        prop_assert!((bias - expected).norm() < 1e-5 * (1.0 + expected.norm()), "{bias} {expected}");
    }

    #[test]
    fn gravity_is_the_gradient_of_the_potential_energy(q in anywhere()) {
        let mut links = links();
        links.gravity = Vector3::new(0.0, 0.0, -spatial::GRAVITY_M_PER_S2);
        let h = 1e-5;
        let bias = links.at(&q, &Axes::zeros()).bias;
        for i in 0..6 {
            let step = Axes::ith(i, h);
            let slope = (links.potential_energy(&(q + step)) - links.potential_energy(&(q - step))) / (2.0 * h);
            prop_assert!((bias[i] - slope).abs() < 1e-6, "{i}: {} {slope}", bias[i]);
        }
    }
}

/// PLANT.md section 2: diagonal near 50, 50, 25, 1.2, 1.2, 0.5 kg m^2, decoupled 44 kg along z; and decoupled joints err
/// by about 25 %.
#[test]
fn the_working_posture_has_the_inertias_of_the_plant() {
    let mass = links().mass_matrix(&Arm::WORKING);
    for (i, near) in [50.0, 50.0, 25.0, 1.2, 1.2, 0.5].into_iter().enumerate() {
        assert!(
            (mass[(i, i)] / near - 1.0).abs() < 0.1,
            "joint {i}: {} kg m^2",
            mass[(i, i)]
        );
    }
    let along_z: Axes = links().arm.jacobian(&Arm::WORKING).row(2).transpose();
    let coupled = 1.0 / along_z.dot(&Cholesky::new(mass).unwrap().solve(&along_z));
    let decoupled = 1.0 / along_z.dot(&along_z.component_div(&mass.diagonal()));
    assert!((decoupled - 44.0).abs() < 2.0, "{decoupled} kg");
    assert!((coupled / decoupled - 1.25).abs() < 0.1, "{coupled} kg");
}

fn arm_scenario(gears: Gears) -> Scenario {
    let mut scenario = scenario();
    scenario.robot.kinematics = Kinematics::Arm;
    scenario.robot.gears = gears;
    scenario
}

/// The arm falls freely for a second, motors loose: kinetic + elastic + potential energy stays.
#[test]
fn energy_is_conserved_under_gravity() {
    for gears in [Gears::Rigid, Gears::Elastic] {
        let mut scenario = arm_scenario(gears);
        scenario.robot.gear_damping = 0.0;
        let mut dynamics = Dynamics::new(&scenario);
        let mut falling = links();
        falling.gravity = Vector3::new(0.0, 0.0, -spatial::GRAVITY_M_PER_S2);
        dynamics.links = links::Links::Arm(falling);
        let mut state = State::at_rest(Axes::new(0.2, -1.2, 1.4, 0.4, 0.8, -0.3));
        state.motor_velocity = Axes::new(0.5, -0.4, 0.6, 1.0, -1.0, 1.5);
        state.link_velocity = state.motor_velocity;
        let energy = |state: &State| {
            dynamics.kinetic_energy(state, &dynamics.posture(state))
                + dynamics.elastic_energy(state)
                + falling.potential_energy(&state.link_position)
        };
        let start = energy(&state);
        let mut largest = 0.0f64;
        for _ in 0..10_000 {
            let posture = dynamics.posture(&state);
            let link = dynamics.link_motion(
                &state,
                &posture,
                &Axes::zeros(),
                &Motion::at_rest(spatial::Pose::identity()),
            );
            let (next, _) = dynamics.integrate(&state, &posture, &Axes::zeros(), &link, [0.0, 1e-4]);
            state = next;
            largest = largest.max(dynamics.kinetic_energy(&state, &dynamics.posture(&state)));
        }
        let error = energy(&state) - start;
        assert!(
            largest > 100.0 && error.abs() < 1e-8 * largest,
            "{error} of {largest} J"
        );
    }
}

/// Motors locked but for one joint at a time, each gear swings with its frequency: `k_j = M_jj (2 pi f_j)^2`.
#[test]
fn gears_are_stiff_enough_for_their_modes() {
    let dynamics = Dynamics::new(&arm_scenario(Gears::Elastic));
    let gears = dynamics.gears.unwrap();
    let mass = links().mass_matrix(&Arm::WORKING);
    for (i, expected) in [14.0, 15.0, 17.0, 20.0, 22.0, 25.0].into_iter().enumerate() {
        let frequency = (gears.stiffness[i] / mass[(i, i)]).sqrt() / TAU;
        assert!((frequency - expected).abs() < 1e-9, "{frequency}");
    }
}

/// The same command dynamics as the gantry's, joint by joint and hence along z.
#[test]
fn a_small_step_of_the_tool_is_reached_without_side_effects() {
    for gears in [Gears::Rigid, Gears::Elastic] {
        let mut robot = RobotSim::new(&arm_scenario(gears));
        let start = robot.link_motion().motion.pose;
        let mut lower = start;
        lower.translation.vector.z -= 1e-3;
        let axes = robot
            .dynamics
            .kinematics
            .inverse(&lower, &robot.state().axis_position[0])
            .unwrap();
        while robot.tick() < 4000 {
            let due = robot.command_due().then(|| command(&robot, |_| axes));
            robot.advance(&tool(&robot), due.as_ref());
        }
        let found = robot.link_motion().motion.pose;
        assert!(
            (found.translation.vector - lower.translation.vector).norm() < 1e-8,
            "{found}"
        );
        assert!(spatial::rotation::log(&found.rotation).norm() < 1e-8);
    }
}
