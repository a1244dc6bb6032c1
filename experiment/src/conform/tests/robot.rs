use super::super::record::{Record, Refused, Saying};
use super::streams::robot;
use super::{all_kept, breaks};
use spatial::kinematics::Axes;
use spatial::ports::{ClockEcho, Fault, RobotMode, RobotState};

fn breaks_robot(rule: &str, words: &str, spoil: impl FnOnce(&mut Record)) {
    breaks(robot, rule, words, spoil);
}

/// Every state that came while `saying` was said first.
fn during(record: &mut Record, saying: Saying, spoil: impl Fn(&mut RobotState)) {
    let phase = record.phase(saying).unwrap();
    for it in &mut record.states {
        if (phase.from_us..phase.until_us).contains(&it.us) {
            spoil(&mut it.message);
        }
    }
}

#[test]
fn a_good_robot_keeps_every_rule() {
    all_kept(&robot());
}

#[test]
fn a_robot_that_follows_the_wire_in_a_hurry_may_slip_if_it_says_so() {
    let mut record = robot();
    for it in record.states.iter_mut().skip(100) {
        it.us += 50_000;
        it.message.stamp.utime += 50_000;
        it.message.echo.send_utime += 50_000;
    }
    for it in record.statuses.iter_mut().skip(3) {
        it.message.slip_s = 0.05;
    }
    let finding = super::super::robot::utime(&record);
    assert_eq!(finding.verdict, super::Verdict::Kept, "{finding:?}");
    breaks_robot("utime grows by 1 ms per tick", "50.00 ms", |record| {
        for it in record.states.iter_mut().skip(100) {
            it.message.stamp.utime += 50_000;
        }
    });
}

#[test]
fn what_every_node_says_of_itself() {
    breaks_robot(
        "messages can be used",
        "3 messages on ROBOT_STATE are refused: not finite",
        |record| {
            let (channel, why) = ("ROBOT_STATE", "not finite".to_owned());
            record.refused = vec![Refused {
                channel,
                count: 3,
                why,
            }];
        },
    );
    let rule = "NODE_STATUS every 100 ms";
    breaks_robot(rule, "1 heard", |record| record.statuses.truncate(1));
    breaks_robot(rule, "median 200 ms", |record| {
        let mut i = 0;
        record.statuses.retain(|_| {
            i += 1;
            i % 2 == 0
        });
    });
    breaks_robot(rule, "longest 700 ms", |record| {
        drop(record.statuses.drain(5..11))
    });
    let rule = "hello agrees with itself and the peers";
    breaks_robot(rule, "seed: 5", |record| {
        record.statuses[9].message.hello.seed = 5
    });
    breaks_robot(rule, "node_protocol is 9", |record| {
        record
            .statuses
            .iter_mut()
            .for_each(|it| it.message.hello.protocol = 9);
    });
    breaks_robot(rule, "node_ticks_per_cycle is 0", |record| {
        record
            .statuses
            .iter_mut()
            .for_each(|it| it.message.hello.ticks_per_cycle = 0);
    });
    let rule = "one positive boot_id in all messages";
    breaks_robot(rule, "2 different ones", |record| {
        record.states[5].message.stamp.boot_id = 78
    });
    breaks_robot(rule, "-3, not above 0", |record| {
        record
            .states
            .iter_mut()
            .for_each(|it| it.message.stamp.boot_id = -3);
        record
            .statuses
            .iter_mut()
            .for_each(|it| it.message.stamp.boot_id = -3);
    });
}

#[test]
fn the_echo() {
    let rule = "echo of the newest command";
    breaks_robot(rule, "without a command", |record| {
        record.states[0].message.echo.send_utime = 5
    });
    breaks_robot(rule, "has not sent", |record| {
        record.states[900].message.echo.command_send_utime += 1
    });
    breaks_robot(rule, "before its command was received", |record| {
        record.states[900].message.echo.receive_utime = record.states[900].message.echo.send_utime + 1;
    });
    breaks_robot(rule, "before it was sent", |record| {
        record.states[900].message.echo = record.states[902].message.echo;
    });
    breaks_robot(rule, "older than the one before", |record| {
        record.states[900].message.echo = record.states[880].message.echo;
    });
    breaks_robot(rule, "or none", |record| {
        record
            .states
            .iter_mut()
            .for_each(|it| it.message.echo = ClockEcho::default());
    });
    breaks_robot(rule, "messages echo a command older than", |record| {
        let echo = record.states[1].message.echo;
        record
            .states
            .iter_mut()
            .skip(1)
            .for_each(|it| it.message.echo = echo);
    });
}

#[test]
fn sampling_instants_are_honest() {
    let rule = "utime is not later than sending";
    breaks_robot(rule, "after it was sent", |record| {
        record.states[9].message.stamp.utime += 1000
    });
    breaks_robot(rule, "on arrival 60.12 ms old", |record| {
        record
            .states
            .iter_mut()
            .for_each(|it| it.message.stamp.utime -= 60_000);
    });
    breaks_robot(rule, "at least -8.", |record| {
        // A clock that the echo's stamps are not read from.
        for it in &mut record.states {
            it.message.stamp.utime += 9_000;
            it.message.echo.send_utime += 9_000;
            it.message.echo.receive_utime += 9_000;
        }
        // One honest exchange says what the clock is.
        let honest = &mut record.states[900].message;
        honest.stamp.utime -= 9_000;
        honest.echo.send_utime -= 8_970;
        honest.echo.receive_utime -= 9_030;
    });
}

#[test]
fn pace_and_ticks() {
    breaks_robot("ROBOT_STATE every T", "0 heard", |record| record.states.clear());
    breaks_robot("ROBOT_STATE every T", "median 6.00 ms", |record| {
        record
            .states
            .iter_mut()
            .enumerate()
            .for_each(|(i, it)| it.us += 2000 * i as i64);
    });
    let rule = "step grows by T";
    breaks_robot(rule, "13 is no multiple of T = 4 ticks", |record| {
        record.states[3].message.stamp.step = 13
    });
    breaks_robot(rule, "8 follows 8", |record| {
        record.states[3].message.stamp.step = 8
    });
    breaks_robot(rule, "states missing", |record| {
        record.states.retain(|it| it.message.stamp.step % 40 != 0);
    });
    let rule = "utime grows by 1 ms per tick";
    breaks_robot(rule, "not later than the one before", |record| {
        record.states[50].message.stamp.utime = record.states[49].message.stamp.utime;
    });
    breaks_robot(rule, "it shifts by", |record| {
        record
            .states
            .iter_mut()
            .for_each(|it| it.message.stamp.utime += it.message.stamp.step * 10);
    });
}

#[test]
fn readings_stay_what_they_were() {
    let rule = "eight readings, one tick apart";
    breaks_robot(
        rule,
        "reading 6 of step 36 is not reading 2 of step 32",
        |record| {
            record.states[9].message.axis_position[6].x += 1e-9;
        },
    );
    breaks_robot(rule, "is not reading", |record| {
        record
            .states
            .iter_mut()
            .for_each(|it| it.message.axis_position.reverse());
    });
    breaks_robot(rule, "3 after", |record| {
        record
            .states
            .iter_mut()
            .for_each(|it| it.message.sample_count = 3);
    });
}

#[test]
fn a_fault_is_named() {
    let rule = "mode and fault agree";
    breaks_robot(rule, "Idle with fault AxisLimit of axis 2", |record| {
        (
            record.states[9].message.fault,
            record.states[9].message.fault_axis,
        ) = (Fault::AxisLimit, 2);
    });
    breaks_robot(rule, "Fault with fault None", |record| {
        record.states[9].message.mode = RobotMode::Fault
    });
    breaks_robot(rule, "of axis 3", |record| {
        record.states[9].message.fault_axis = 3
    });
}

#[test]
fn without_enable_nothing_happens() {
    let rule = "without enable the robot is idle and stands";
    breaks_robot(rule, "Idle, Armed", |record| {
        record.states[90].message.mode = RobotMode::Armed
    });
    breaks_robot(rule, "axes within 2.000 mrad (1)", |record| {
        record.states[90].message.axis_position[0] = Axes::repeat(2e-3);
    });
    for (saying, rule) in [
        (Saying::Future, "a command from the future does nothing"),
        (Saying::Old, "an old command does nothing"),
        (Saying::Foreign, "a command with another boot_id does nothing"),
        (Saying::OutOfRange, "without enable no set-point matters"),
    ] {
        breaks_robot(rule, "modes Braking", |record| {
            during(record, saying, |it| it.mode = RobotMode::Braking)
        });
        breaks_robot(rule, "axes within", |record| {
            during(record, saying, |it| {
                it.axis_setpoint = Axes::repeat(1e-3 * it.stamp.step as f64)
            });
        });
    }
    breaks_robot(
        "a command from the future does nothing",
        "has accepted the command of step 9",
        |record| {
            during(record, Saying::Future, |it| it.command_step = 999_999);
        },
    );
    breaks_robot(
        "without enable no set-point matters",
        "AxisLimit of axis 0 is latched",
        |record| {
            let last = record.phase(Saying::OutOfRange).unwrap().until_us;
            let state = record.states.iter_mut().rev().find(|it| it.us < last).unwrap();
            (state.message.fault, state.message.fault_axis) = (Fault::AxisLimit, 0);
        },
    );
}

#[test]
fn a_robot_with_a_fault_is_not_judged_for_standing() {
    let mut record = robot();
    for it in &mut record.states {
        (it.message.mode, it.message.fault) = (RobotMode::Fault, Fault::AxisLimit);
    }
    let finding = super::super::still::idle(&record);
    assert_eq!(finding.verdict, super::Verdict::NotSeen);
    assert!(finding.observed.contains("AxisLimit") && finding.observed.contains("touchdown task reset"));
}
