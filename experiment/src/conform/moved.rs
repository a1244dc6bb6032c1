//! Rules for a robot that is enabled, asked to stay, released, left alone, and reset.

use super::record::{At, Phase, Record, Saying, course, names};
use super::still::{STILL_RAD, moved, unmoved};
use super::{Expectation, Finding};
use spatial::TICK_S;
use spatial::ports::{Fault, HORIZON, RobotMode, RobotState};

/// All of them.
pub fn rules(record: &Record, expectation: &Expectation) -> Vec<Finding> {
    let mut findings = vec![
        arming(record),
        intruder(record),
        release(record),
        silence(record, expectation),
        reset_while_enabled(record),
        reset(record),
    ];
    if record.signed.is_some() {
        findings.push(unsigned(record));
    }
    findings
}

/// Under a key an enabled command that is not signed does nothing.
pub fn unsigned(record: &Record) -> Finding {
    const RULE: &str = "an enabled command that is not signed does nothing";
    let Some((_, states)) = states(record, Saying::Unsigned, 0) else {
        return Finding::not_seen(RULE, "it was not tried");
    };
    let remedy = "look at session, seq and tag (`node::authenticity`) before all else that a command says";
    unmoved(RULE, states, &[RobotMode::Idle], remedy)
}

/// The states that came while `saying` was said for the `nth` time (from 0).
fn states(record: &Record, saying: Saying, nth: usize) -> Option<(Phase, &[At<RobotState>])> {
    let phase = record
        .phases
        .iter()
        .filter(|it| it.saying == saying)
        .nth(nth)
        .copied()?;
    let states = record.states_in(phase);
    (!states.is_empty()).then_some((phase, states))
}

/// The modes while a reset was asked for; none: it was not.
fn modes_of_reset(record: &Record, saying: Saying) -> Option<Vec<RobotMode>> {
    let (phase, states) = states(record, saying, 0)?;
    let asked = |us: &&i64| (phase.from_us..phase.until_us).contains(*us);
    record.resets_us.iter().find(asked)?;
    Some(course(states))
}

/// Commands that stay arm the robot, and then are executed.
pub fn arming(record: &Record) -> Finding {
    const RULE: &str = "Idle, Armed, Following by commands that stay";
    let Some((_, states)) = states(record, Saying::Stay, 0) else {
        return Finding::not_seen(RULE, "it was not enabled");
    };
    let modes = course(states);
    let remedy = "arm by an enabled command that stays, and execute such commands once they have come for robot.arming_s";
    let way = [RobotMode::Idle, RobotMode::Armed, RobotMode::Following];
    // A machine that is busy makes the checker's commands late.
    let known = modes
        .iter()
        .all(|mode| way.contains(mode) || *mode == RobotMode::Bridging);
    let ordered = modes.iter().position(|mode| *mode == RobotMode::Armed)
        < modes.iter().position(|mode| *mode == RobotMode::Following);
    let observed = format!("{}{}", names(&modes), fault(states));
    if !known || !ordered || !modes.contains(&RobotMode::Following) {
        return Finding::broken(RULE, observed, remedy);
    }
    let step = |mode| {
        states
            .iter()
            .find(|it| it.message.mode == mode)
            .map_or(0, |it| it.message.stamp.step)
    };
    let took = match modes.contains(&RobotMode::Armed) {
        true => format!(
            "armed for {} ms",
            step(RobotMode::Following) - step(RobotMode::Armed)
        ),
        false => "not armed for as long as T".to_owned(),
    };
    let moved = states.first().map_or(0.0, |first| moved(first, states));
    let observed = format!("{observed}, {took}, axes within {:.3} mrad (1)", 1e3 * moved);
    Finding::judge(
        RULE,
        moved <= STILL_RAD,
        observed,
        "asked to stay, stay: take no other set-points than the command's",
    )
}

/// Who commands the robot is not disturbed by another one.
pub fn intruder(record: &Record) -> Finding {
    const RULE: &str = "enabled commands with another boot_id do nothing";
    let Some((_, states)) = states(record, Saying::Intruder, 0) else {
        return Finding::not_seen(RULE, "it was not tried");
    };
    let (modes, first) = ([RobotMode::Following, RobotMode::Bridging], &states[0]);
    if !modes.contains(&first.message.mode) {
        let observed = format!("the robot was not Following: {}", names(&course(states)));
        return Finding::not_seen(RULE, observed);
    }
    // The intruder asks for half of what counts as motion.
    let set = states
        .iter()
        .map(|it| (it.message.axis_setpoint - first.message.axis_setpoint).amax())
        .fold(0.0, f64::max);
    let remedy = "whose boot_id has armed the robot commands it, and nobody else, until it is idle again";
    if set > 0.1 * STILL_RAD {
        return Finding::broken(RULE, format!("set-points moved by {:.3} mrad", 1e3 * set), remedy);
    }
    unmoved(RULE, states, &modes, remedy)
}

/// A command without enable lets the robot come to rest.
pub fn release(record: &Record) -> Finding {
    const RULE: &str = "without enable it brakes to Idle";
    // The first release is before it was enabled.
    let Some((_, states)) = states(record, Saying::Released, 1) else {
        return Finding::not_seen(RULE, "it was not enabled");
    };
    let modes = course(states);
    let known = !modes
        .iter()
        .any(|mode| matches!(mode, RobotMode::Fault | RobotMode::Armed));
    let kept = known && modes.last() == Some(&RobotMode::Idle);
    let observed = format!("{}{}", names(&modes), fault(states));
    Finding::judge(
        RULE,
        kept,
        observed,
        "brake within the axes' limits on a command without enable, then be Idle; it is no fault",
    )
}

/// Silence is bridged by the horizon and the gap, not for longer and not for less.
pub fn silence(record: &Record, expectation: &Expectation) -> Finding {
    const RULE: &str = "silence is bridged, then FAULT_COMMAND_GAP at rest";
    let remedy = "follow the last horizon to its end, then wait command_gap_s, then brake and latch FAULT_COMMAND_GAP; if the \
                  robot's n_d or gap differ, say so (--delay-periods, --command-gap-s)";
    let Some((_, states)) = states(record, Saying::Silence, 0) else {
        return Finding::not_seen(RULE, "it was not left alone");
    };
    if states[0].message.mode != RobotMode::Following && states[0].message.mode != RobotMode::Bridging {
        return Finding::not_seen(
            RULE,
            format!("the robot was not Following: {}", names(&course(states))),
        );
    }
    let modes = course(states);
    let Some(stopped) = states.iter().find(|it| it.message.mode == RobotMode::Fault) else {
        return Finding::broken(RULE, format!("{}; no fault", names(&modes)), remedy);
    };
    if stopped.message.fault != Fault::CommandGap {
        return Finding::broken(RULE, format!("{}{}", names(&modes), fault(states)), remedy);
    }
    let period = record.period_ticks();
    let horizon = (expectation.delay_periods + HORIZON as i64) * period;
    let gap = libm::rint(expectation.command_gap_s / TICK_S) as i64;
    // It is seen with a state, and takes a tick or two to be noticed: 2 T.
    let most = horizon + gap + 2 * period;
    let [since, moved] = [
        (stopped.message.stamp.step - stopped.message.command_step) as f64,
        moved(&states[0], states),
    ];
    let observed = format!(
        "{}: {since} ms after the last command's state (horizon {horizon}, at most {most}), axes within {:.3} mrad (1)",
        names(&modes),
        1e3 * moved
    );
    let kept = since >= horizon as f64 && since <= most as f64 && moved <= STILL_RAD;
    Finding::judge(RULE, kept, observed, remedy)
}

/// A reset is refused while somebody asks for motion.
pub fn reset_while_enabled(record: &Record) -> Finding {
    const RULE: &str = "no reset while enabled commands come";
    let Some(modes) = modes_of_reset(record, Saying::ResetWhileEnabled) else {
        return Finding::not_seen(RULE, "it was not tried");
    };
    if modes.first() != Some(&RobotMode::Fault) {
        return Finding::not_seen(RULE, format!("the robot had no fault: {}", names(&modes)));
    }
    let kept = modes == [RobotMode::Fault];
    Finding::judge(
        RULE,
        kept,
        names(&modes),
        "clear a fault only if no enabled command has come for 2 T, whoever sent it",
    )
}

/// Once released, a reset ends the fault.
pub fn reset(record: &Record) -> Finding {
    const RULE: &str = "reset once enable is released";
    let Some(modes) = modes_of_reset(record, Saying::Reset) else {
        return Finding::not_seen(RULE, "it was not tried");
    };
    if modes.first() != Some(&RobotMode::Fault) {
        return Finding::not_seen(RULE, format!("the robot had no fault: {}", names(&modes)));
    }
    let kept = modes.last() == Some(&RobotMode::Idle);
    Finding::judge(
        RULE,
        kept,
        names(&modes),
        "TASK with ACTION_RESET ends MODE_FAULT once no enabled command has come for 2 T",
    )
}

/// The fault that `states` tell of, in words.
fn fault(states: &[At<RobotState>]) -> String {
    let faulty = states.iter().find(|it| it.message.fault != Fault::None);
    faulty.map_or(String::new(), |it| {
        format!(
            "; {:?} of axis {} is latched",
            it.message.fault, it.message.fault_axis
        )
    })
}
