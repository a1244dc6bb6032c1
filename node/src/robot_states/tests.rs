//! Every state that can be reached, with all that can happen in it.

use super::*;
use std::collections::BTreeSet;

/// Counters so small that all their values can be visited.
const PATIENCE: Patience = Patience {
    arming: 2,
    missing: 2,
    horizon: 4,
    gap: 2,
};

/// What may happen within one tick.
#[derive(Clone, Copy, Debug)]
enum Event {
    Nothing,
    Command(Heard, Verdict),
    Latch(Fault),
    Reset { cause_gone: bool },
}

fn events() -> Vec<Event> {
    let verdicts = [
        Verdict::Stay,
        Verdict::Move,
        Verdict::Refused(Fault::AxisLimit, 3),
    ];
    let mut events = vec![
        Event::Nothing,
        Event::Latch(Fault::SimLost),
        Event::Reset { cause_gone: false },
        Event::Reset { cause_gone: true },
    ];
    for age in -1..=PATIENCE.horizon + 1 {
        for owner in [7, 8] {
            for enable in [false, true] {
                for (verdict, sensed) in verdicts.into_iter().flat_map(|it| [(it, false), (it, true)]) {
                    let heard = Heard {
                        age,
                        owner,
                        enable,
                        sensed,
                    };
                    events.push(Event::Command(heard, verdict));
                }
            }
        }
    }
    events
}

/// What happened, and what came of it; the tick that follows is passed `standing` or not.
struct Step {
    before: RobotStates,
    event: Event,
    answer: Answer,
    /// Before the tick has passed.
    between: RobotStates,
    after: RobotStates,
}

/// A machine: what a command, a fault or a reset makes of a state.
type Machine = fn(&mut RobotStates, Event) -> Answer;

fn real(states: &mut RobotStates, event: Event) -> Answer {
    match event {
        Event::Nothing => {}
        Event::Command(heard, verdict) => return states.hear(&PATIENCE, heard, || verdict),
        Event::Latch(fault) => states.latch(fault, -1),
        Event::Reset { cause_gone } => {
            states.reset(&PATIENCE, cause_gone);
        }
    }
    Answer::Ignored
}

fn key(states: &RobotStates) -> (RobotMode, Fault, i32, Option<i64>, i64, i64, i64) {
    let s = states;
    (
        s.mode,
        s.fault,
        s.fault_axis,
        s.owner,
        s.silence,
        s.released,
        s.armed,
    )
}

/// Visit all that can be reached; the first invariant that does not hold, and how many states there are.
fn explore(machine: Machine) -> Result<usize, String> {
    let start = RobotStates::new(&PATIENCE);
    let mut known = BTreeSet::from([key(&start)]);
    let mut open = vec![start];
    while let Some(before) = open.pop() {
        for event in events() {
            for standing in [false, true] {
                let mut between = before;
                let answer = machine(&mut between, event);
                let mut after = between;
                after.pass(&PATIENCE, standing);
                let step = Step {
                    before,
                    event,
                    answer,
                    between,
                    after,
                };
                if let Some(broken) = broken(&step, standing) {
                    return Err(format!("{broken}: {before:?}, {event:?}, {answer:?}, {after:?}"));
                }
                if known.insert(key(&after)) {
                    open.push(after);
                }
            }
        }
    }
    Ok(known.len())
}

/// The invariant that a step breaks.
fn broken(step: &Step, standing: bool) -> Option<&'static str> {
    let Step {
        before,
        event,
        answer,
        between,
        after,
    } = step;
    let moves = |mode| {
        matches!(
            mode,
            RobotMode::Following | RobotMode::Bridging | RobotMode::Braking
        )
    };
    let executed = *answer == Answer::Execute;
    if executed && between.mode != RobotMode::Following {
        return Some("motion outside Following");
    }
    if let Event::Command(heard, verdict) = event {
        let foreign = before.owner.is_some_and(|owner| owner != heard.owner);
        if foreign && (executed || (between.mode, between.owner) != (before.mode, before.owner)) {
            return Some("a second owner is heard");
        }
        let useless = heard.age < 0 || heard.age > PATIENCE.horizon || !heard.enable;
        if executed && (useless || matches!(verdict, Verdict::Refused(..))) {
            return Some("a command is executed that must not be");
        }
        let armed = before.mode == RobotMode::Armed && before.armed >= PATIENCE.arming;
        if executed && !moves(before.mode) && !(armed && *verdict == Verdict::Stay) {
            return Some("motion without arming");
        }
        if executed && !moves(before.mode) && !heard.sensed {
            return Some("motion begins without the sensor");
        }
        if executed && before.silence <= heard.age {
            return Some("an older command overtakes a newer one");
        }
    }
    let reset = matches!(event, Event::Reset { cause_gone: true }) && before.released > PATIENCE.missing;
    if before.fault != Fault::None
        && between.fault != before.fault
        && !(reset && before.mode == RobotMode::Fault)
    {
        return Some("the first fault is not kept");
    }
    if before.mode == RobotMode::Fault && between.mode != RobotMode::Fault && !reset {
        return Some("a way out of Fault without a reset");
    }
    if between.fault != Fault::None && !matches!(between.mode, RobotMode::Braking | RobotMode::Fault) {
        return Some("motion goes on with a fault");
    }
    if (after.mode == RobotMode::Fault) != (after.fault != Fault::None && after.mode != RobotMode::Braking) {
        return Some("Fault without a fault");
    }
    if moves(between.mode) && !moves(after.mode) && !standing {
        return Some("a state of rest while the robot moves");
    }
    let silent = between.silence > PATIENCE.bridged();
    if silent
        && matches!(
            after.mode,
            RobotMode::Following | RobotMode::Bridging | RobotMode::Armed
        )
    {
        return Some("silence is bridged for too long");
    }
    if after.mode == RobotMode::Following && after.silence > PATIENCE.missing + 1 {
        return Some("missing commands are not told");
    }
    None
}

#[test]
fn no_state_that_can_be_reached_breaks_an_invariant() {
    let states = explore(real).unwrap_or_else(|broken| panic!("{broken}"));
    // Fewer would mean that something can't happen in the test.
    assert!(states > 200, "{states} states");
}

/// The exploration finds mistakes: two machines with one each.
#[test]
fn mistakes_are_found() {
    let newest_fault: Machine = |states, event| {
        if let Event::Latch(fault) = event {
            (states.fault, states.mode) = (fault, RobotMode::Braking);
            return Answer::Ignored;
        }
        real(states, event)
    };
    let anybody: Machine = |states, event| {
        if let Event::Command(heard, _) = event
            && states.mode == RobotMode::Following
        {
            states.owner = Some(heard.owner);
        }
        real(states, event)
    };
    for (machine, expected) in [
        (newest_fault, "the first fault is not kept"),
        (anybody, "a second owner is heard"),
    ] {
        let found = explore(machine).expect_err("a mistake is not found");
        assert!(found.starts_with(expected), "{found}");
    }
}

fn command(age: i64, enable: bool) -> Heard {
    Heard {
        age,
        owner: 7,
        enable,
        sensed: true,
    }
}

/// One tick with a good command that asks for `verdict`.
fn tick(states: &mut RobotStates, verdict: Verdict) -> Answer {
    let answer = states.hear(&PATIENCE, command(0, true), || verdict);
    states.pass(&PATIENCE, true);
    answer
}

fn following() -> RobotStates {
    let mut states = RobotStates::new(&PATIENCE);
    while tick(&mut states, Verdict::Stay) != Answer::Execute {}
    states
}

#[test]
fn a_robot_follows_once_commands_have_come_for_long_enough() {
    let mut states = RobotStates::new(&PATIENCE);
    let answers: Vec<_> = (0..4).map(|_| tick(&mut states, Verdict::Stay)).collect();
    let (counted, execute) = (Answer::Counted, Answer::Execute);
    assert_eq!(answers, [counted, counted, execute, execute]);
    assert_eq!(tick(&mut states, Verdict::Move), execute);
    // While it is armed, nobody moves it.
    let mut states = RobotStates::new(&PATIENCE);
    tick(&mut states, Verdict::Stay);
    assert_eq!(tick(&mut states, Verdict::Move), counted);
    assert_eq!(states.mode(), RobotMode::Idle);
}

#[test]
fn without_a_fresh_sensor_it_stays_armed() {
    let mut states = RobotStates::new(&PATIENCE);
    let blind = Heard {
        sensed: false,
        ..command(0, true)
    };
    for _ in 0..10 {
        assert_eq!(states.hear(&PATIENCE, blind, || Verdict::Stay), Answer::Counted);
        states.pass(&PATIENCE, true);
        assert_eq!(states.mode(), RobotMode::Armed);
    }
    assert_eq!(tick(&mut states, Verdict::Stay), Answer::Execute);
    // Once it follows, what the sensor says is the controller's business.
    assert_eq!(states.hear(&PATIENCE, blind, || Verdict::Move), Answer::Execute);
}

#[test]
fn missing_commands_are_bridged_then_the_robot_brakes() {
    let mut states = following();
    let modes: Vec<_> = (0..8)
        .map(|tick| {
            states.pass(&PATIENCE, tick > 6);
            states.mode()
        })
        .collect();
    use RobotMode::{Braking, Bridging, Fault as Stopped, Following};
    assert_eq!(
        modes,
        [
            Following, Following, Bridging, Bridging, Bridging, Bridging, Braking, Stopped
        ]
    );
    assert_eq!(states.fault(), Fault::CommandGap);
    assert_eq!(tick(&mut states, Verdict::Stay), Answer::Ignored);
}

#[test]
fn a_command_that_comes_in_time_ends_the_bridging() {
    let mut states = following();
    for _ in 0..5 {
        states.pass(&PATIENCE, false);
    }
    assert_eq!(states.mode(), RobotMode::Bridging);
    assert_eq!(tick(&mut states, Verdict::Move), Answer::Execute);
    assert_eq!(
        (states.mode(), states.fault()),
        (RobotMode::Following, Fault::None)
    );
}

#[test]
fn a_fault_is_cleared_by_a_reset_once_nobody_asks_for_motion() {
    let mut states = following();
    states.latch(Fault::AxisLimit, 2);
    states.pass(&PATIENCE, true);
    assert!(!states.reset(&PATIENCE, true), "motion is asked for");
    for _ in 0..3 {
        states.hear(&PATIENCE, command(0, false), || Verdict::Stay);
        states.pass(&PATIENCE, true);
    }
    assert!(!states.reset(&PATIENCE, false), "the cause is there");
    assert_eq!((states.fault(), states.fault_axis()), (Fault::AxisLimit, 2));
    assert!(states.reset(&PATIENCE, true));
    assert_eq!((states.mode(), states.fault()), (RobotMode::Idle, Fault::None));
}

#[test]
fn who_lets_go_lets_the_robot_stop_without_a_fault() {
    let mut states = following();
    states.hear(&PATIENCE, command(0, false), || Verdict::Stay);
    assert_eq!(states.mode(), RobotMode::Braking);
    states.pass(&PATIENCE, false);
    assert_eq!(states.mode(), RobotMode::Braking);
    states.pass(&PATIENCE, true);
    assert_eq!((states.mode(), states.fault()), (RobotMode::Idle, Fault::None));
}
