//! A robot that is given to another controller.

use super::*;
use spatial::ports::{ParameterAnswer, Task, TaskAction};

fn asked(controller: &mut Controller, step: i64, action: TaskAction) {
    let mut task = Task {
        action,
        ..Task::default()
    };
    task.stamp.step = step;
    controller.request(&task);
}

/// On its way down: nothing is enabled from that cycle on, and it goes on from where the robot has come to rest.
#[test]
fn a_released_robot_is_left_alone_until_it_is_taken_again() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let mut axes = scenario.start_axes().unwrap();
    let cycle = |controller: &mut Controller, tick: i64, axes: Axes, mode: RobotMode| {
        let state = RobotState {
            mode,
            ..state(tick, axes)
        };
        controller.cycle(&Heard::complete(&state, &undeflected(tick), None))
    };
    for tick in (0..600).step_by(4) {
        let command = cycle(&mut controller, tick, axes, RobotMode::Following).command;
        assert!(command.enable);
        axes = command.axis_position[0];
    }
    assert!(scenario.start_axes().unwrap().z - axes.z > 1e-3);
    asked(&mut controller, 1, TaskAction::Release);
    let braked = axes - Axes::new(0.0, 0.0, 2e-4, 0.0, 0.0, 0.0);
    for tick in (600..800).step_by(4) {
        let (axes, mode) = match tick {
            ..608 => (axes, RobotMode::Following),
            608..640 => (braked, RobotMode::Braking),
            _ => (braked, RobotMode::Idle),
        };
        let outputs = cycle(&mut controller, tick, axes, mode);
        assert!(!outputs.command.enable, "tick {tick}");
        assert_eq!(
            (outputs.status.phase, outputs.status.task_answer),
            (ControllerPhase::Ready, ParameterAnswer::Accepted)
        );
    }
    asked(&mut controller, 2, TaskAction::Start);
    for tick in (800..900).step_by(4) {
        let mode = if tick < 860 {
            RobotMode::Armed
        } else {
            RobotMode::Following
        };
        let Outputs { command, status } = cycle(&mut controller, tick, braked, mode);
        assert!(command.enable && status.task_answer == ParameterAnswer::RobotNotReady);
        let moved = command.axis_position.map(|axes| (axes - braked).amax());
        assert!(moved.iter().all(|moved| *moved < 1e-9), "tick {tick}: {moved:?}");
    }
    asked(&mut controller, 3, TaskAction::Start);
    let mut phase = ControllerPhase::Ready;
    for tick in (900..1000).step_by(4) {
        let before = axes;
        let Outputs { command, status } = cycle(&mut controller, tick, braked, RobotMode::Following);
        axes = command.axis_position[0];
        assert!(tick == 900 || (axes - before).amax() < 1e-4, "tick {tick}");
        phase = status.phase;
    }
    assert_eq!(phase, ControllerPhase::Approach);
}
