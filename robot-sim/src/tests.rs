//! The robot's answer to commands against PLANT.md section 5.

mod arm;
mod convergence;
mod elastic;
mod faults;
mod modes;
mod reaction;
mod step;

use super::*;
use nalgebra::Vector3;
use spatial::ports::{HORIZON, RobotMode};

/// No tool, and a sensor so soft that the robot does not feel it.
fn scenario() -> Scenario {
    let mut scenario = Scenario::default();
    scenario.tool.mass_kg = 0.0;
    scenario.sensor.stiffness_n_per_m = 1e-6;
    scenario.sensor.stiffness_nm_per_rad = 1e-6;
    scenario.sensor.damping_ns_per_m = 0.0;
    scenario.sensor.damping_nms_per_rad = 0.0;
    scenario.robot.arming_s = 0.0;
    scenario
}

fn command(robot: &RobotSim, axis_position: impl Fn(i64) -> Axes) -> Command {
    Command {
        stamp: robot.stamp(),
        enable: true,
        axis_position: std::array::from_fn(|i| axis_position(i as i64)),
        send_utime: 0,
        authenticity: Authenticity::default(),
    }
}

fn tool(robot: &RobotSim) -> ToolMotion {
    ToolMotion {
        stamp: robot.stamp(),
        motion: robot.link_motion().motion,
    }
}

/// Amplitude ratio and lag (s) from command to encoder of axis z at `frequency` Hz.
fn response(scenario: &Scenario, frequency: f64) -> (f64, f64) {
    let mut robot = RobotSim::new(scenario);
    let start = scenario.start_axes().unwrap();
    let amplitude = 0.1e-3;
    let angle = |tick: i64| TAU * frequency * tick as f64 * TICK_S;
    // Project on sine and cosine over a whole number of periods, once the start is forgotten.
    let (first, last) = (2_000, 2_000 + libm::rint(20.0 / frequency / TICK_S) as i64);
    let (mut in_phase, mut out_of_phase) = (0.0, 0.0);
    while robot.tick() < last {
        if robot.tick() >= first {
            let z = robot.state().axis_position[0].z - start.z;
            let (sine, cosine) = libm::sincos(angle(robot.tick()));
            in_phase += z * sine * 2.0 / (last - first) as f64;
            out_of_phase += z * cosine * 2.0 / (last - first) as f64;
        }
        let command = robot.command_due().then(|| {
            // What is asked for now; the horizon repeats it, as a controller without preview would.
            let now = angle(robot.tick());
            command(&robot, |_| start + Axes::ith(2, amplitude * libm::sin(now)))
        });
        robot.advance(&tool(&robot), command.as_ref());
    }
    let ratio = libm::hypot(in_phase, out_of_phase) / amplitude;
    (ratio, -libm::atan2(out_of_phase, in_phase) / (TAU * frequency))
}

/// Rigid: dead time 12.2-12.3 ms, 93-95 rad/s, damping 0.80, -3 dB at 13.1 Hz.
#[test]
fn command_dynamics_are_those_of_the_reference() {
    let (ratio, _) = response(&scenario(), 13.1);
    assert!((ratio - 0.5f64.sqrt()).abs() < 0.02, "{ratio} at 13.1 Hz");
    for frequency in [1.0, 5.0, 10.0] {
        let (_, lag) = response(&scenario(), frequency);
        let x = TAU * frequency / 94.0;
        let second_order = libm::atan2(2.0 * 0.8 * x, 1.0 - x * x) / (TAU * frequency);
        let dead_time = lag - second_order;
        assert!(
            (dead_time - 12.25e-3).abs() < 0.40e-3,
            "{dead_time} s at {frequency} Hz"
        );
    }
}

#[test]
fn a_force_deflects_the_axis_and_the_servo_brings_it_back() {
    // The default sensor, pushed up by 0.1 mm: 30 N on the robot.
    let scenario = Scenario::default();
    let mut robot = RobotSim::new(&scenario);
    let rest = robot.link_motion().motion;
    let mut pushed = rest;
    let weight = scenario.tool.mass_kg * spatial::GRAVITY_M_PER_S2;
    pushed.pose.translation.vector += Vector3::new(0.0, 0.0, 0.1e-3 - weight / 300e3);
    // The moment that the hanging tool exerts and the robot compensates.
    let moment = scenario.tool.centre_of_mass_in_s_m[0] * weight;
    pushed.pose.rotation = spatial::rotation::exp(Vector3::new(0.0, moment / 401.07, 0.0));
    let (mut largest, mut velocity) = (0.0f64, 0.0f64);
    for _ in 0..2000 {
        robot.advance(
            &ToolMotion {
                stamp: robot.stamp(),
                motion: pushed,
            },
            None,
        );
        let z = robot.link_motion().motion.pose.translation.vector.z - rest.pose.translation.vector.z;
        largest = largest.max(z.abs());
        velocity = robot.state().axis_velocity.norm();
    }
    assert!(largest > 1e-6 && largest < 50e-6, "{largest} m");
    let z = robot.state().axis_position[0].z - rest.pose.translation.vector.z;
    assert!(z.abs() < 1e-8 && velocity < 1e-6, "{z} m, {velocity} m/s");
}

#[test]
fn missed_commands_are_counted_and_the_last_horizon_is_followed() {
    let mut robot = RobotSim::new(&scenario());
    let start = robot.state().axis_position[0];
    let once = command(&robot, |i| start + Axes::ith(0, 1e-4 * (i + 1) as f64));
    robot.advance(&tool(&robot), Some(&once));
    while robot.tick() < 1000 {
        robot.advance(&tool(&robot), None);
    }
    assert_eq!(robot.state().missed_commands, 249);
    assert_eq!(robot.state().command_step, 0);
    let travelled = robot.state().axis_position[0].x - start.x;
    assert!((travelled - 1e-4 * HORIZON as f64).abs() < 1e-8, "{travelled}");
}

#[test]
fn encoder_samples_are_the_recent_past_newest_first() {
    let mut robot = RobotSim::new(&scenario());
    let start = robot.state().axis_position[0];
    let mut past = vec![start.z];
    for tick in 0..40 {
        let down = robot
            .command_due()
            .then(|| command(&robot, |_| start - Axes::ith(2, 1e-3 * f64::from(tick))));
        robot.advance(&tool(&robot), down.as_ref());
        past.push(robot.state().axis_position[0].z);
        let state = robot.state();
        for age in 0..state.sample_count as usize {
            assert_eq!(state.axis_position[age].z, past[past.len() - 1 - age]);
        }
    }
}
