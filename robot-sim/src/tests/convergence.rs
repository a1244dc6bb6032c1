//! How fine the axes' integration has to be.

use super::*;
use node::scenario::{Gears, Kinematics};

/// Where s is (m) 0.2 s after all axes were asked for 2 mrad, with the tool plate held where s was.
fn end(kinematics: Kinematics, gears: Gears, step: f64) -> Vector3<f64> {
    let mut scenario = Scenario::default();
    scenario.robot.kinematics = kinematics;
    scenario.robot.gears = gears;
    scenario.robot.integration_step_s = step;
    scenario.robot.arming_s = 0.0;
    let mut robot = RobotSim::new(&scenario);
    let start = robot.state().axis_position[0];
    let held = tool(&robot);
    while robot.tick() < 200 {
        let due = robot
            .command_due()
            .then(|| command(&robot, |_| start + Axes::repeat(2e-3)));
        robot.advance(&held, due.as_ref());
    }
    robot.link_motion().motion.pose.translation.vector
}

/// The fourth order is seen. The default step of 1 ms errs by less than 20 nm of some mm of motion, 0.5 ms by less than
/// 1 nm, 0.1 ms by less than 1 pm: all far below what the exchange over 1 ms costs (PLANT.md section 4).
#[test]
fn the_integration_step_is_converged() {
    for (kinematics, gears) in [
        (Kinematics::Gantry, Gears::Rigid),
        (Kinematics::Gantry, Gears::Elastic),
        (Kinematics::Arm, Gears::Rigid),
        (Kinematics::Arm, Gears::Elastic),
    ] {
        let exact = end(kinematics, gears, 2e-5);
        let error = |step: f64| (end(kinematics, gears, step) - exact).norm();
        let (default, half, fine) = (error(1e-3), error(5e-4), error(1e-4));
        let ratio = default / half;
        assert!(
            (12.0..24.0).contains(&ratio),
            "{kinematics:?} {gears:?}: {default} {half}"
        );
        assert!(
            default < 2e-8 && half < 1e-9 && fine < 1e-12,
            "{kinematics:?} {gears:?}: {default} {half} {fine} m"
        );
    }
}
