//! Commands that can't be executed: a named fault, and no motion.

use super::*;
use node::scenario::Kinematics;

/// The robot of `kinematics`, and a horizon whose last set-point has axis `axis` moved by `shift`.
fn refused(kinematics: Kinematics, axis: usize, shift: f64) -> (RobotSim, Axes) {
    let mut scenario = scenario();
    scenario.robot.kinematics = kinematics;
    let mut robot = RobotSim::new(&scenario);
    let start = robot.state().axis_position[0];
    let command = command(&robot, |i| {
        if i == 7 {
            start + Axes::ith(axis, shift)
        } else {
            start
        }
    });
    robot.advance(&tool(&robot), Some(&command));
    (robot, start)
}

#[test]
fn each_cause_has_its_name_and_nothing_moves() {
    let cases = [
        (Kinematics::Gantry, 3, f64::NAN, Fault::CommandInvalid),
        (Kinematics::Gantry, 3, f64::INFINITY, Fault::CommandInvalid),
        (Kinematics::Gantry, 5, 1.6, Fault::AxisLimit),
        (Kinematics::Gantry, 0, 0.0081, Fault::VelocityLimit),
        (Kinematics::Arm, 4, f64::NAN, Fault::CommandInvalid),
        (Kinematics::Arm, 1, -1.2, Fault::AxisLimit),
        (Kinematics::Arm, 2, 0.8, Fault::AxisLimit),
        (Kinematics::Arm, 0, -0.022, Fault::VelocityLimit),
        (Kinematics::Arm, 5, 0.0859, Fault::VelocityLimit),
    ];
    for (kinematics, axis, shift, fault) in cases {
        let (mut robot, start) = refused(kinematics, axis, shift);
        let state = robot.state();
        let found = (state.mode, state.fault, state.fault_axis);
        assert_eq!(
            found,
            (RobotMode::Fault, fault, axis as i32),
            "{kinematics:?} {shift}"
        );
        for _ in 0..100 {
            let good = robot
                .command_due()
                .then(|| command(&robot, |_| start + Axes::repeat(1e-3)));
            robot.advance(&tool(&robot), good.as_ref());
        }
        assert!((robot.state().axis_position[0] - start).norm() < 1e-6);
        assert_eq!(robot.state().fault, fault);
    }
}

#[test]
fn the_first_set_point_must_follow_the_last_command() {
    let mut robot = RobotSim::new(&scenario());
    let start = robot.state().axis_position[0];
    let jump = command(&robot, |_| start + Axes::ith(1, 0.0081));
    robot.advance(&tool(&robot), Some(&jump));
    assert_eq!(robot.state().fault, Fault::VelocityLimit);
}

#[test]
fn a_short_excess_of_velocity_is_executed_within_the_limit() {
    let mut robot = RobotSim::new(&scenario());
    let start = robot.state().axis_position[0];
    let jump = command(&robot, |_| start + Axes::ith(1, 0.0079));
    robot.advance(&tool(&robot), Some(&jump));
    assert_eq!(
        (robot.state().fault, robot.state().mode),
        (Fault::None, RobotMode::Following)
    );
}

#[test]
fn a_start_out_of_reach_is_a_fault_and_not_a_panic() {
    let mut scenario = scenario();
    scenario.robot.kinematics = Kinematics::Arm;
    scenario.task.start_position_m = [3.0, 0.0, 0.0];
    let robot = RobotSim::new(&scenario);
    assert_eq!(
        (robot.state().fault, robot.state().mode),
        (Fault::Unreachable, RobotMode::Fault)
    );
    assert_eq!(robot.state().axis_position[0], spatial::kinematics::Arm::WORKING);
}
