//! A start is refused for each cause, with the reason, and nothing moves.

use super::*;
use node::scenario::ExpectedFrom;
use spatial::ports::{ParameterAnswer, Task, TaskAction};

/// What is different from a start that succeeds.
#[derive(Clone, Copy)]
struct Cause {
    /// Of all scenarios: what the controller assumes.
    scenario: fn(&mut Scenario),
    /// Of the robot's state, at a tick.
    robot: fn(&mut RobotState),
    /// Of the sensor's samples, at a tick.
    sensor: fn(&mut Deflections, i64),
}

impl Cause {
    fn none() -> Self {
        Self {
            scenario: |_| {},
            robot: |_| {},
            sensor: |_, _| {},
        }
    }
}

/// What the reference tool's weight deflects the sensor by (PLANT.md section 5).
fn hanging() -> Deflection {
    Deflection {
        translation: Vector3::new(0.0, 0.0, -130.7e-6),
        rotation: Vector3::new(0.0, 2.918e-3, 0.0),
    }
}

/// The status at 0.30 s, when the task has begun by itself or by request; nothing moves unless it has.
fn status(cause: Cause, by_itself: bool) -> ControllerStatus {
    let mut scenario = Scenario::default();
    scenario.task.starts_by_itself = by_itself;
    (cause.scenario)(&mut scenario);
    let mut controller = Controller::new(&scenario);
    let axes = scenario.start_axes().unwrap();
    let mut last = None;
    for tick in (0..=300).step_by(4) {
        let (mut state, mut deflections) = (state(tick, axes), sensed(tick, 0, |_| hanging()));
        // The tare is over; a standstill of 0.25 s is about to be.
        if tick >= 240 {
            (cause.robot)(&mut state);
        }
        (cause.sensor)(&mut deflections, tick);
        if !by_itself && tick == 256 {
            controller.request(&Task {
                stamp: Stamp {
                    step: 1,
                    utime: 0,
                    boot_id: 9,
                },
                action: TaskAction::Start,
                ..Task::default()
            });
        }
        let Outputs { command, status } = controller.cycle(&Heard::complete(&state, &deflections, None));
        let begun = status.phase == ControllerPhase::Approach;
        // The set-point is never farther ahead than it may be of a robot that is elsewhere.
        let most = if state.axis_position[0] == axes {
            1e-9
        } else {
            1.01e-3
        };
        let moved = command
            .axis_position
            .iter()
            .map(|it| (it - axes).amax())
            .fold(0.0, f64::max);
        assert!(begun || moved < most, "it moves by {moved} at {tick}");
        last = Some(status);
        if begun || (status.task_answer != ParameterAnswer::None && status.fault == Fault::None) {
            break;
        }
    }
    last.unwrap()
}

/// Both ways to begin give `answer` and `limit`.
fn assert_refused(cause: Cause, answer: ParameterAnswer, limit: f64) {
    for by_itself in [true, false] {
        let status = status(cause, by_itself);
        assert_eq!(status.phase, ControllerPhase::Ready, "{answer:?}");
        assert_eq!(
            (status.task_answer, status.task_step),
            (answer, i64::from(!by_itself))
        );
        assert!(
            (status.task_limit - limit).abs() < 1e-9,
            "{answer:?}: {}",
            status.task_limit
        );
    }
}

#[test]
fn with_everything_in_place_it_starts() {
    for by_itself in [true, false] {
        let status = status(Cause::none(), by_itself);
        assert_eq!(
            (status.phase, status.task_limit),
            (ControllerPhase::Approach, 0.0)
        );
        let expected = if by_itself {
            ParameterAnswer::None
        } else {
            ParameterAnswer::Accepted
        };
        assert_eq!(status.task_answer, expected);
    }
}

#[test]
fn the_fault_of_a_robot_is_the_controllers() {
    let faulty = Cause {
        robot: |state| state.fault = Fault::AxisLimit,
        ..Cause::none()
    };
    let status = status(faulty, true);
    assert_eq!(
        (status.phase, status.fault),
        (ControllerPhase::Fault, Fault::AxisLimit)
    );
}

#[test]
fn a_robot_that_is_stale_or_elsewhere_is_refused() {
    let robot = |robot| Cause {
        robot,
        ..Cause::none()
    };
    assert_refused(
        robot(|state| state.stamp.utime = 236_000),
        ParameterAnswer::RobotStale,
        0.012,
    );
    assert_refused(
        robot(|state| state.mode = RobotMode::Braking),
        ParameterAnswer::RobotNotReady,
        0.0,
    );
    let elsewhere = robot(|state| state.axis_position[0].x += 0.004);
    assert_refused(elsewhere, ParameterAnswer::RobotNotReady, 0.003);
}

#[test]
fn a_sensor_that_is_stale_or_saturated_is_refused() {
    let sensor = |sensor| Cause {
        sensor,
        ..Cause::none()
    };
    let silent = sensor(|deflections, tick| {
        let valid = tick < 240;
        deflections
            .samples
            .iter_mut()
            .for_each(|sample| sample.flags.valid &= valid);
    });
    assert_refused(silent, ParameterAnswer::SensorStale, 0.012);
    for saturated in [
        sensor(|deflections, tick| deflections.samples[0].flags.saturated = tick > 240),
        // Once within the tare.
        sensor(|deflections, tick| deflections.samples[0].flags.saturated = tick == 100),
    ] {
        assert_refused(saturated, ParameterAnswer::SensorSaturated, 0.0);
    }
}

#[test]
fn an_implausible_tare_is_refused() {
    fn all(deflections: &mut Deflections, change: fn(&mut Deflection)) {
        deflections
            .samples
            .iter_mut()
            .for_each(|sample| change(&mut sample.deflection));
    }
    let show = |sensor| Cause {
        sensor,
        ..Cause::none()
    };
    let assume = |scenario| Cause {
        scenario,
        ..Cause::none()
    };
    // Nothing hangs there, or the tool is another one.
    let limit = 4.0 / 4.0;
    assert_refused(
        show(|it, _| all(it, |it| *it = Deflection::default())),
        ParameterAnswer::ToolMass,
        limit,
    );
    assert_refused(
        assume(|it| it.controller.tool_mass_kg = 0.9),
        ParameterAnswer::ToolMass,
        3.6,
    );
    // Mounted upside down, on its side, and turned about the vertical by a quarter.
    for turned in [
        show(|it, _| all(it, |it| it.translation = -it.translation)),
        show(|it, _| all(it, |it| it.translation = Vector3::new(it.translation.z, 0.0, 0.0))),
        show(|it, _| all(it, |it| it.rotation = Vector3::new(it.rotation.y, 0.0, 0.0))),
    ] {
        assert_refused(turned, ParameterAnswer::SensorFrame, 0.5);
    }
    // 15 N along x besides the weight.
    let biased = show(|it, _| all(it, |it| it.translation.x = 15.0 / 300e3));
    assert_refused(biased, ParameterAnswer::SensorBias, 10.0);
}

#[test]
fn an_object_that_is_expected_has_to_be_seen() {
    let unseen = Cause {
        scenario: |it| it.controller.expected.from = ExpectedFrom::ObjectSensor,
        ..Cause::none()
    };
    assert_refused(unseen, ParameterAnswer::ObjectUnknown, 0.0);
}

/// A tool of which nothing is known may weigh what it likes, and a compliance assumed 2.5 times too large or too small is
/// no reason: it scales what is compared.
#[test]
fn what_is_not_known_or_only_scaled_is_plausible() {
    for change in [
        (|it| it.controller.tool_mass_kg = 0.0) as fn(&mut Scenario),
        |it| it.controller.compliance_rad_per_nm *= 2.5,
        |it| it.controller.compliance_m_per_n /= 2.5,
    ] {
        let cause = Cause {
            scenario: change,
            ..Cause::none()
        };
        assert_eq!(status(cause, true).phase, ControllerPhase::Approach);
    }
}
