//! A controller that is started anew in the middle of an experiment: it does not take what the tool presses with for zero.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use controller::{Controller, Heard};
use node::scenario::Scenario;
use robot_sim::RobotSim;
use sensor_sim::SensorSim;
use spatial::ports::{ControllerPhase, ControllerStatus, Fault, Stamp, Task, TaskAction};

/// What is seen of a run at tick `at` and the last one: status, contact force (N) and height of the tcp (m).
struct Seen {
    status: ControllerStatus,
    force_n: f64,
    height_m: f64,
}

/// `scenario` with another controller from tick `swapped` on, which is asked to start at each of `starts`; what is seen at
/// the end of each tick in `looks`.
fn run(scenario: &Scenario, swapped: i64, starts: &[i64], looks: &[i64]) -> Vec<Seen> {
    let mut robot = RobotSim::new(scenario);
    let mut sensor = SensorSim::new(scenario, &robot.link_motion().motion);
    let mut controller = Controller::new(scenario);
    let mut seen = Vec::new();
    let mut status = None;
    for tick in 0..=*looks.last().unwrap() {
        let sensed = sensor.advance(&robot.link_motion());
        let mut command = None;
        if tick == swapped {
            controller = Controller::new(scenario);
        }
        if starts.contains(&tick) {
            controller.request(&Task {
                stamp: Stamp {
                    step: tick,
                    utime: 0,
                    boot_id: 7,
                },
                action: TaskAction::Start,
                ..Task::default()
            });
        }
        if robot.command_due() {
            let state = robot.state();
            let answer = controller.cycle(&Heard::complete(&state, &sensed.deflections, None));
            status = Some(answer.status);
            command = Some(answer.command);
        }
        robot.advance(&sensed.tool_motion, command.as_ref());
        if looks.contains(&tick) {
            seen.push(Seen {
                status: status.unwrap(),
                force_n: sensed.truth.contact_force.z,
                height_m: sensed.truth.tcp_pose.translation.z,
            });
        }
    }
    seen
}

fn scenario(overrides: &[&str]) -> Scenario {
    let text = experiment::scenarios::Source::find("paper").unwrap().text;
    let overrides: Vec<_> = overrides.iter().map(|&text| text.to_owned()).collect();
    Scenario::parse("paper", &text, &overrides).unwrap()
}

#[test]
fn it_leads_the_tool_back_takes_zero_anew_and_presses_as_before() {
    for overrides in [&[][..], &["robot.kinematics=arm"]] {
        let scenario = scenario(overrides);
        let seen = run(&scenario, 2000, &[3000], &[250, 1999, 2999, 7999]);
        let [start, pressing, waiting, again] = &seen[..] else {
            unreachable!()
        };
        assert!((pressing.force_n - 10.0).abs() < 0.2, "{}", pressing.force_n);
        // Nothing begins by itself, and nothing moves.
        assert_eq!(waiting.status.phase, ControllerPhase::Ready);
        assert!((waiting.force_n - 10.0).abs() < 0.5, "{}", waiting.force_n);
        assert_eq!(
            (again.status.phase, again.status.fault),
            (ControllerPhase::Settled, Fault::None)
        );
        assert!((again.force_n - 10.0).abs() < 0.2, "{}", again.force_n);
        // Zero is what it was before.
        let zero = [start, again].map(|seen| seen.status.tare.translation);
        assert!((zero[0] - zero[1]).norm() < 2e-6, "{zero:?}");
    }
}

#[test]
fn in_the_air_it_returns_to_the_start_first() {
    let scenario = scenario(&[]);
    let seen = run(&scenario, 500, &[1000], &[250, 499, 6999]);
    assert_eq!(seen[1].status.phase, ControllerPhase::Approach);
    assert!(seen[1].height_m < seen[0].height_m - 1e-3);
    assert_eq!(seen[2].status.phase, ControllerPhase::Settled);
    assert!((seen[2].force_n - 10.0).abs() < 0.2, "{}", seen[2].force_n);
}
