//! Each cause that a protection is there for, injected in every phase in which the robot is led: the named fault latches,
//! the command neither jumps nor leaves what the robot executes, the robot comes to rest, and a reset brings it back.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use controller::{Controller, Heard};
use experiment::scenarios::Source;
use node::scenario::Scenario;
use robot_sim::RobotSim;
use sensor_sim::SensorSim;
use spatial::TICK_US;
use spatial::ports::{
    ControllerPhase, ControllerStatus, Deflections, Fault, RobotMode, RobotState, Stamp, Task, TaskAction,
};

/// Cycles in a phase before the cause sets in.
const INTO_PHASE: usize = 6;
/// How long the cause lasts, ticks.
const LASTS: i64 = 500;
/// From its end to the reset, and from there to the judgement, ticks.
const RESTS: i64 = 300;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cause {
    /// No sample of the sensor is valid.
    DropOut,
    /// No message of the sensor comes.
    SilentSensor,
    /// Samples are a tenth of a second older than they were.
    LateSensor,
    /// No state of the robot comes.
    SilentRobot,
    /// The robot says that it has a fault.
    FaultyRobot,
    /// 400 N sideways.
    Push,
    /// Every sample is at the end of the range.
    Saturated,
}

impl Cause {
    const ALL: [Self; 7] = [
        Self::DropOut,
        Self::SilentSensor,
        Self::LateSensor,
        Self::SilentRobot,
        Self::FaultyRobot,
        Self::Push,
        Self::Saturated,
    ];

    /// The fault that it is to latch.
    fn fault(self) -> Fault {
        match self {
            Self::DropOut | Self::SilentSensor | Self::LateSensor => Fault::SensorStale,
            Self::SilentRobot => Fault::StateStale,
            Self::FaultyRobot => Fault::VelocityLimit,
            Self::Push => Fault::Collision,
            Self::Saturated => Fault::DeflectionSaturated,
        }
    }

    /// What it makes of the messages.
    fn impair(self, state: &mut Option<RobotState>, deflections: &mut Option<Deflections>) {
        let each = |deflections: &mut Option<Deflections>,
                    change: &dyn Fn(&mut spatial::ports::DeflectionSample)| {
            if let Some(deflections) = deflections {
                deflections.samples.iter_mut().for_each(change);
            }
        };
        match self {
            Self::DropOut => each(deflections, &|sample| sample.flags.valid = false),
            Self::SilentSensor => *deflections = None,
            Self::LateSensor => each(deflections, &|sample| sample.utime -= 100 * TICK_US),
            Self::SilentRobot => *state = None,
            Self::FaultyRobot => {
                if let Some(state) = state {
                    (state.fault, state.mode) = (Fault::VelocityLimit, RobotMode::Braking);
                }
            }
            Self::Push => each(deflections, &|sample| {
                sample.deflection.translation.x += 400.0 / 300e3
            }),
            Self::Saturated => each(deflections, &|sample| sample.flags.saturated = true),
        }
    }
}

/// What came of it.
#[derive(Debug)]
struct Outcome {
    /// When the fault had latched after the cause had set in, ticks.
    after: Option<i64>,
    fault: Fault,
    /// At the end of the cause.
    rest: RobotState,
    /// At the end.
    last: ControllerStatus,
}

/// `scenario` until `phase`, then `cause`, then a reset.
fn inject(scenario: &Scenario, phase: ControllerPhase, cause: Cause) -> Option<Outcome> {
    let mut robot = RobotSim::new(scenario);
    let mut sensor = SensorSim::new(scenario, &robot.link_motion().motion);
    let mut controller = Controller::new(scenario);
    let mut cycles = 0;
    let mut since = None;
    let (mut after, mut fault, mut rest) = (None, Fault::None, None);
    for tick in 0..scenario.timing.ticks() {
        let sensed = sensor.advance(&robot.link_motion());
        let mut command = None;
        if robot.command_due() {
            let mut state = Some(robot.state());
            let mut deflections = Some(sensed.deflections);
            let age = since.map(|since| tick - since);
            if age.is_some_and(|age| (0..LASTS).contains(&age)) {
                cause.impair(&mut state, &mut deflections);
            }
            if age == Some(LASTS) {
                rest = Some(robot.state());
            }
            if age == Some(LASTS + RESTS) {
                controller.request(&Task {
                    stamp: Stamp {
                        step: 1,
                        utime: 0,
                        boot_id: 7,
                    },
                    action: TaskAction::Reset,
                    ..Task::default()
                });
            }
            let answer = controller.cycle(&Heard {
                tick,
                state: state.as_ref(),
                deflections: deflections.as_ref(),
                object: None,
            });
            cycles = if answer.status.phase == phase {
                cycles + 1
            } else {
                0
            };
            if since.is_none() && cycles >= INTO_PHASE {
                since = Some(tick + scenario.timing.command_period_ticks);
            }
            if answer.status.fault != Fault::None && after.is_none() {
                (after, fault) = (since.map(|since| tick - since), answer.status.fault);
            }
            if age == Some(LASTS + 2 * RESTS) {
                return Some(Outcome {
                    after,
                    fault,
                    rest: rest?,
                    last: answer.status,
                });
            }
            command = Some(answer.command);
        }
        robot.advance(&sensed.tool_motion, command.as_ref());
        // Neither a jump nor anything out of range: its guard refuses nothing.
        assert_eq!(
            robot.state().fault,
            Fault::None,
            "{phase:?}, {cause:?}, tick {tick}"
        );
    }
    None
}

fn assert_stops_and_comes_back(name: &str, overrides: &[&str], phase: ControllerPhase) {
    assert_stops(name, overrides, phase, &Cause::ALL);
}

fn assert_stops(name: &str, overrides: &[&str], phase: ControllerPhase, causes: &[Cause]) {
    let overrides: Vec<_> = overrides.iter().map(|&text| text.to_owned()).collect();
    let scenario = Source::find(name).unwrap().scenario(&overrides).unwrap();
    for &cause in causes {
        let outcome = inject(&scenario, phase, cause);
        let Some(outcome) = outcome else {
            panic!("{name} does not come to {phase:?} in time");
        };
        let what = format!("{name}, {phase:?}, {cause:?}: {outcome:?}");
        assert_eq!(outcome.fault, cause.fault(), "{what}");
        assert!((0..=200).contains(&outcome.after.unwrap()), "{what}");
        assert!(outcome.rest.axis_velocity.amax() < 2e-3, "{what}");
        assert_eq!(
            (outcome.last.phase, outcome.last.fault),
            (ControllerPhase::Ready, Fault::None),
            "{what}"
        );
    }
}

#[test]
fn before_it_begins() {
    let late = ["task.standstill_s=1.5", "timing.duration_s=3"];
    assert_stops_and_comes_back("paper", &late, ControllerPhase::Ready);
}

#[test]
fn on_the_way_down() {
    assert_stops_and_comes_back("paper", &[], ControllerPhase::Approach);
    assert_stops_and_comes_back("elastic_arm", &[], ControllerPhase::Approach);
}

#[test]
fn in_contact() {
    for law in ["pd", "literal", "proposed", "impedance"] {
        let law = format!("controller.law={law}");
        assert_stops_and_comes_back("paper", &[&law], ControllerPhase::Contact);
    }
    assert_stops_and_comes_back("elastic_arm", &[], ControllerPhase::Contact);
}

#[test]
fn once_the_force_has_settled() {
    for law in ["pd", "proposed", "impedance"] {
        let law = format!("controller.law={law}");
        assert_stops_and_comes_back("paper", &[&law], ControllerPhase::Settled);
    }
    assert_stops_and_comes_back("elastic_arm", &[], ControllerPhase::Settled);
}

#[test]
fn on_a_way_through_the_air_and_back_from_the_object() {
    assert_stops_and_comes_back("screws", &[], ControllerPhase::Move);
    assert_stops_and_comes_back("screws", &[], ControllerPhase::Retract);
}

#[test]
fn on_a_search() {
    // A peg and a hole are simulated slowly.
    let causes = [Cause::DropOut, Cause::SilentRobot, Cause::Push];
    assert_stops("peg", &[], ControllerPhase::Search, &causes);
}

#[test]
fn in_a_calibration() {
    let calibrate = ["task.kind=calibrate", "timing.duration_s=12"];
    // A sensor at the end of its range is the calibration's own affair (`experiment/tests/calibration.rs`).
    let causes: Vec<_> = Cause::ALL
        .into_iter()
        .filter(|cause| *cause != Cause::Saturated)
        .collect();
    assert_stops("paper", &calibrate, ControllerPhase::Calibrate, &causes);
}
