//! Cycles for which messages are missing.

use super::*;
use spatial::ports::{LIMIT_HOLD, ParameterAnswer, Task, TaskAction};

/// A cycle at `tick` of which the state is missing.
fn stateless<'a>(tick: i64, deflections: &'a Deflections) -> Heard<'a> {
    Heard {
        tick,
        state: None,
        deflections: Some(deflections),
        object: None,
    }
}

#[test]
fn before_the_first_state_nothing_is_enabled() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let axes = scenario.start_axes().unwrap();
    for tick in (0..40).step_by(4) {
        let deflections = undeflected(tick);
        let Outputs { command, status } = controller.cycle(&stateless(tick, &deflections));
        assert!(!command.enable && command.stamp.step == tick);
        assert_eq!((status.phase, status.fault), (ControllerPhase::Init, Fault::None));
    }
    let outputs = controller.cycle(&Heard::complete(&state(40, axes), &undeflected(40), None));
    assert_eq!(outputs.command.axis_position, [axes; HORIZON]);
    assert!(outputs.command.enable && outputs.status.phase == ControllerPhase::Sync);
}

/// Tare, start and the way down are the same, bit by bit, with every other state missing.
#[test]
fn on_its_way_no_state_is_missed() {
    let scenario = weightless();
    let [mut all, mut half] = [(); 2].map(|()| Controller::new(&scenario));
    let mut axes = scenario.start_axes().unwrap();
    for tick in (0..1200).step_by(4) {
        let (state, deflections) = (state(tick, axes), undeflected(tick));
        let complete = Heard::complete(&state, &deflections, None);
        let expected = all.cycle(&complete);
        let found = half.cycle(&Heard {
            state: complete.state.filter(|_| tick % 8 == 0),
            ..complete
        });
        assert_eq!(found.command, expected.command, "tick {tick}");
        assert_eq!(found.status.phase, expected.status.phase, "tick {tick}");
        axes = expected.command.axis_position[0];
    }
    assert!(scenario.start_axes().unwrap().z - axes.z > 0.01);
}

/// The tcp moves on the robot that goes up and down; its samples tell where it was as soon as the encoders do, and the same.
#[test]
fn samples_wait_for_their_encoder_readings() {
    let scenario = weightless();
    let [mut all, mut lossy] = [(); 2].map(|()| Controller::new(&scenario));
    let start = scenario.start_axes().unwrap();
    let moved = |tick: i64| {
        let mut axes = start;
        axes.z += 1e-3 * libm::sin(0.03 * (tick - 240).clamp(0, 1000) as f64);
        axes
    };
    let mut waited = 0;
    for tick in (0..800).step_by(4) {
        let state = RobotState {
            sample_count: (tick + 1).min(ENCODER_SAMPLES as i64) as i32,
            axis_position: std::array::from_fn(|age| moved(tick - age as i64)),
            ..state(tick, start)
        };
        let deflections = undeflected(tick);
        let complete = Heard::complete(&state, &deflections, None);
        let expected = all.cycle(&complete).status.tcp_pose;
        let lost = tick % 20 == 8;
        let found = lossy.cycle(&Heard {
            state: complete.state.filter(|_| !lost),
            ..complete
        });
        assert_eq!(found.status.fault, Fault::None);
        if lost && tick > 240 {
            assert_ne!(found.status.tcp_pose, expected, "tick {tick}");
            waited += 1;
        } else {
            assert_eq!(found.status.tcp_pose, expected, "tick {tick}");
        }
    }
    assert!(waited > 20);
}

/// A robot that is silent for more than 3 T, 12 ms, is held, and its silence of more than 20 ms is a fault that stays when it
/// speaks again, until it is asked to go.
#[test]
fn a_silent_robot_is_held_and_then_a_fault() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let mut axes = scenario.start_axes().unwrap();
    let mut held = None;
    let mut thresholds_n = Vec::new();
    let request = |count, action| Task {
        stamp: Stamp {
            step: count,
            utime: 0,
            boot_id: 9,
        },
        action,
        ..Task::default()
    };
    for tick in (0..=900).step_by(4) {
        // Reset too early, and in time.
        if tick == 600 || tick == 800 {
            controller.request(&request(tick, TaskAction::Reset));
        }
        let (state, deflections) = (state(tick, axes), undeflected(tick));
        let silent = (500..700).contains(&tick);
        let complete = Heard::complete(&state, &deflections, None);
        let Outputs { command, status } = controller.cycle(&Heard {
            state: complete.state.filter(|_| !silent),
            ..complete
        });
        axes = command.axis_position[0];
        let expected = match tick {
            ..=516 => Fault::None,
            800.. => Fault::None,
            _ => Fault::StateStale,
        };
        assert_eq!(status.fault, expected, "tick {tick}");
        thresholds_n.push(status.detection.threshold_n);
        let holds = status.limits & LIMIT_HOLD != 0;
        assert_eq!(holds, tick == 512 || tick == 516, "tick {tick}");
        if tick == 600 {
            assert_eq!(status.task_answer, ParameterAnswer::FaultLatched);
        }
        if expected != Fault::None {
            let still = *held.get_or_insert(axes);
            assert_eq!(command.axis_position, [still; HORIZON], "tick {tick}");
        }
    }
    // What swings is no contact.
    let [moving_n, stopped_n] = [508, 516].map(|tick: usize| thresholds_n[tick / 4]);
    assert!(stopped_n > moving_n + 1.0, "{moving_n} N, {stopped_n} N");
}

/// No cycle tells of it meanwhile: what the controller knows is too old all the same.
#[test]
fn a_controller_that_stood_still_does_not_go_on() {
    let scenario = weightless();
    for (stood, fault) in [
        (20, Fault::None),
        (24, Fault::StateStale),
        (200, Fault::StateStale),
    ] {
        let mut controller = Controller::new(&scenario);
        let mut axes = scenario.start_axes().unwrap();
        let mut last = Fault::None;
        for tick in (0..=500).step_by(4).chain([500 + stood]) {
            let (state, deflections) = (state(tick, axes), undeflected(tick));
            let Outputs { command, status } = controller.cycle(&Heard::complete(&state, &deflections, None));
            (axes, last) = (command.axis_position[0], status.fault);
        }
        assert_eq!(last, fault, "{stood} ms");
    }
}

/// On its way down it stands still for 52 ms: the robot has come to the end of the horizon that it took last, and is held
/// there. Sent back to where it was before, it would leave an object and meet it a second time.
#[test]
fn a_robot_that_went_on_by_its_horizon_is_held_at_its_end() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let mut axes = scenario.start_axes().unwrap();
    let mut end = axes;
    for tick in (0..=600).step_by(4) {
        let outputs = controller.cycle(&Heard::complete(&state(tick, axes), &undeflected(tick), None));
        (axes, end) = (
            outputs.command.axis_position[0],
            outputs.command.axis_position[HORIZON - 1],
        );
    }
    assert!(axes.z - end.z > 0.5e-3, "it is on its way: {} m", axes.z - end.z);
    let mut taken = 600;
    for tick in (652..=1000).step_by(4) {
        let mut state = state(tick, end);
        state.command_step = taken;
        let Outputs { command, status } =
            controller.cycle(&Heard::complete(&state, &undeflected(tick), None));
        assert_eq!(status.fault, Fault::StateStale, "tick {tick}");
        let off = (command.axis_position[0] - end).amax();
        assert!(off < 1e-12, "tick {tick}: {off} rad from the horizon's end");
        taken = tick;
    }
}

/// What is found outside the cycle, as a clock that has jumped, stops the experiment as any fault does; before the tare there is
/// nothing to stop.
#[test]
fn a_fault_from_elsewhere_is_latched_after_the_tare() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let axes = scenario.start_axes().unwrap();
    let mut faults = Vec::new();
    for tick in (0..1200).step_by(4) {
        if tick == 40 || tick == 800 {
            controller.latch(Fault::ClockJump);
        }
        let outputs = controller.cycle(&Heard::complete(&state(tick, axes), &undeflected(tick), None));
        if faults.last() != Some(&outputs.status.fault) {
            faults.push(outputs.status.fault);
        }
    }
    assert_eq!(faults, [Fault::None, Fault::ClockJump]);
}
