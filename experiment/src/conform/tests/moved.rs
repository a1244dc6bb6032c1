use super::super::record::{Record, Saying};
use super::super::{Expectation, Verdict, moved};
use super::streams::robot;
use super::{EXPECTATION, breaks};
use spatial::kinematics::Axes;
use spatial::ports::{Fault, RobotMode, RobotState};

fn breaks_robot(rule: &str, words: &str, spoil: impl FnOnce(&mut Record)) {
    breaks(robot, rule, words, spoil);
}

/// Every state that came while `saying` was said for the `nth` time.
fn during(record: &mut Record, saying: Saying, nth: usize, spoil: impl Fn(&mut RobotState)) {
    let phase = *record
        .phases
        .iter()
        .filter(|it| it.saying == saying)
        .nth(nth)
        .unwrap();
    for it in &mut record.states {
        if (phase.from_us..phase.until_us).contains(&it.us) {
            spoil(&mut it.message);
        }
    }
}

fn mode(mode: RobotMode) -> impl Fn(&mut RobotState) {
    move |state| (state.mode, state.fault) = (mode, Fault::None)
}

#[test]
fn arming() {
    let rule = "Idle, Armed, Following by commands that stay";
    breaks_robot(rule, "Idle", |record| {
        during(record, Saying::Stay, 0, mode(RobotMode::Idle))
    });
    breaks_robot(rule, "Braking", |record| {
        during(record, Saying::Stay, 0, |it| {
            if it.mode == RobotMode::Armed {
                it.mode = RobotMode::Braking;
            }
        });
    });
    breaks_robot(rule, "Following, Armed", |record| {
        during(record, Saying::Stay, 0, |it| {
            it.mode = match it.mode {
                RobotMode::Armed => RobotMode::Following,
                RobotMode::Following => RobotMode::Armed,
                other => other,
            };
        });
    });
    breaks_robot(rule, "axes within 5.000 mrad (1)", |record| {
        during(record, Saying::Stay, 0, |it| {
            if it.mode == RobotMode::Following {
                it.axis_setpoint = Axes::repeat(5e-3);
            }
        });
    });
}

#[test]
fn one_commander_at_a_time() {
    let rule = "enabled commands with another boot_id do nothing";
    breaks_robot(rule, "set-points moved by 0.500 mrad", |record| {
        let odd = |step: i64| if step % 8 == 0 { 5e-4 } else { 0.0 };
        during(record, Saying::Intruder, 0, |it| {
            it.axis_setpoint = Axes::repeat(odd(it.stamp.step))
        });
    });
    breaks_robot(rule, "Following, Braking", |record| {
        during(record, Saying::Intruder, 0, |it| {
            if it.stamp.step % 200 == 100 {
                it.mode = RobotMode::Braking;
            }
        });
    });
}

#[test]
fn release() {
    let rule = "without enable it brakes to Idle";
    breaks_robot(rule, "Following", |record| {
        during(record, Saying::Released, 1, mode(RobotMode::Following))
    });
    breaks_robot(rule, "CommandGap of axis -1 is latched", |record| {
        during(record, Saying::Released, 1, |it| {
            if it.mode != RobotMode::Following {
                (it.mode, it.fault) = (RobotMode::Fault, Fault::CommandGap);
            }
        });
    });
}

#[test]
fn silence() {
    let rule = "silence is bridged, then FAULT_COMMAND_GAP at rest";
    breaks_robot(rule, "no fault", |record| {
        during(record, Saying::Silence, 0, mode(RobotMode::Following))
    });
    breaks_robot(rule, "AxisLimit", |record| {
        during(record, Saying::Silence, 0, |it| {
            if it.fault != Fault::None {
                it.fault = Fault::AxisLimit;
            }
        });
    });
    breaks_robot(rule, "axes within 2.996 mrad", |record| {
        during(record, Saying::Silence, 0, |it| {
            if it.mode == RobotMode::Fault {
                it.axis_position[0] = Axes::repeat(3e-3);
            }
        });
    });
    breaks_robot(rule, "4 ms after the last command's state", |record| {
        during(record, Saying::Silence, 0, |it| {
            if it.mode == RobotMode::Fault {
                it.command_step = it.stamp.step - 4;
            }
        });
    });
    let late = Expectation {
        command_gap_s: 0.0,
        ..EXPECTATION
    };
    let finding = moved::silence(&robot(), &late);
    assert_eq!(finding.verdict, Verdict::Broken);
    assert!(
        finding
            .observed
            .contains("64 ms after the last command's state (horizon 40, at most 48)"),
        "{finding:?}"
    );
}

#[test]
fn resets() {
    breaks_robot("no reset while enabled commands come", "Fault, Idle", |record| {
        during(record, Saying::ResetWhileEnabled, 0, |it| {
            if it.stamp.step % 100 == 52 {
                (it.mode, it.fault) = (RobotMode::Idle, Fault::None);
            }
        });
    });
    breaks_robot("reset once enable is released", "Fault", |record| {
        during(record, Saying::Reset, 0, |it| {
            (it.mode, it.fault) = (RobotMode::Fault, Fault::CommandGap)
        });
    });
}

#[test]
fn what_was_not_tried_is_not_judged() {
    let unseen = |record: &Record| {
        let findings = moved::rules(record, &EXPECTATION);
        let unseen = findings.iter().filter(|it| it.verdict == Verdict::NotSeen);
        unseen.count()
    };
    let mut record = robot();
    record.resets_us.clear();
    assert_eq!(unseen(&record), 2);
    record.phases.truncate(5);
    assert_eq!(unseen(&record), 6);
}
