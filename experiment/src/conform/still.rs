//! Rules for a robot that nobody enables: it stands, whatever else it is told.

use super::Finding;
use super::record::{At, Record, Saying, course, names};
use spatial::ports::{Fault, RobotMode, RobotState};

/// So far an axis may move without being enabled, rad.
pub(super) const STILL_RAD: f64 = 1e-3;

/// What the robot must not take notice of, and the rule.
const PROBES: [(Saying, &str); 4] = [
    (Saying::Future, "a command from the future does nothing"),
    (Saying::Old, "an old command does nothing"),
    (Saying::Foreign, "a command with another boot_id does nothing"),
    (Saying::OutOfRange, "without enable no set-point matters"),
];

/// All of them.
pub fn rules(record: &Record) -> Vec<Finding> {
    let probes = PROBES.iter().map(|(saying, rule)| probe(record, *saying, rule));
    std::iter::once(idle(record)).chain(probes).collect()
}

/// While nobody enables it, the robot is idle and stands.
pub fn idle(record: &Record) -> Finding {
    const RULE: &str = "without enable the robot is idle and stands";
    let Some(phase) = record.phase(Saying::Released) else {
        return Finding::not_seen(RULE, "no command was sent");
    };
    let states = record.states_in(phase);
    if let Some(first) = states.first().filter(|it| it.message.fault != Fault::None) {
        let observed = format!(
            "it has latched {:?}; mend its cause, and clear it by `touchdown task reset`",
            first.message.fault
        );
        return Finding::not_seen(RULE, observed);
    }
    unmoved(
        RULE,
        states,
        &[RobotMode::Idle],
        "execute nothing without command_enable, however valid",
    )
}

/// What one kind of command that is nobody's business has done.
pub fn probe(record: &Record, saying: Saying, rule: &'static str) -> Finding {
    let Some(phase) = record.phase(saying) else {
        return Finding::not_seen(rule, "it was not tried");
    };
    let states = record.states_in(phase);
    if states.first().is_some_and(|it| it.message.fault != Fault::None) {
        return Finding::not_seen(rule, "the robot had latched a fault before");
    }
    let taken =
        |it: &&At<RobotState>| saying == Saying::Future && it.message.command_step > it.message.stamp.step;
    if let Some(state) = states.iter().find(taken) {
        let observed = format!(
            "step {} has accepted the command of step {}",
            state.message.stamp.step, state.message.command_step
        );
        return Finding::broken(rule, observed, "refuse a command whose step is in the future");
    }
    unmoved(
        rule,
        states,
        &[RobotMode::Idle],
        "look at boot_id, step and command_enable before the set-points",
    )
}

/// The modes of `states` are `allowed`, no fault is latched, and no axis moves.
pub(super) fn unmoved(
    rule: &'static str,
    states: &[At<RobotState>],
    allowed: &[RobotMode],
    remedy: &str,
) -> Finding {
    let Some(first) = states.first() else {
        return Finding::not_seen(rule, "no state came meanwhile");
    };
    let modes = course(states);
    if modes.iter().any(|mode| !allowed.contains(mode)) {
        return Finding::broken(
            rule,
            format!("modes {} (allowed: {})", names(&modes), names(allowed)),
            remedy,
        );
    }
    if let Some(state) = states.iter().find(|it| it.message.fault != Fault::None) {
        let observed = format!(
            "{:?} of axis {} is latched",
            state.message.fault, state.message.fault_axis
        );
        return Finding::broken(rule, observed, remedy);
    }
    let moved = moved(first, states);
    let observed = format!(
        "{} in {} states, axes within {:.3} mrad (1)",
        names(&modes),
        states.len(),
        1e3 * moved
    );
    Finding::judge(rule, moved <= STILL_RAD, observed, remedy)
}

/// How far any axis or set-point is from where `first` has it, at most, rad.
pub(super) fn moved(first: &At<RobotState>, states: &[At<RobotState>]) -> f64 {
    let far = |it: &At<RobotState>| {
        let axes = (it.message.axis_position[0] - first.message.axis_position[0]).amax();
        axes.max((it.message.axis_setpoint - first.message.axis_setpoint).amax())
    };
    states.iter().map(far).fold(0.0, f64::max)
}
