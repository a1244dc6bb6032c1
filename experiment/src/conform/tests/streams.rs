//! Streams of a robot and of a sensor that keep every rule.

use super::super::record::{At, Phase, Record, Saying, Signed};
use node::health::Health;
use spatial::kinematics::Axes;
use spatial::ports::*;

const PERIOD: i64 = 4;
/// How far the node's clock is ahead of the checker's, us.
const AHEAD_US: i64 = 7_000_000;
/// Each way takes so long, us.
const WAY_US: i64 = 100;
const BOOT_ID: i64 = 77;

type Course = &'static [(i64, RobotMode)];

const IDLE: Course = &[(0, RobotMode::Idle)];
const FAULT: Course = &[(0, RobotMode::Fault)];
const ARMING: Course = &[
    (0, RobotMode::Idle),
    (8, RobotMode::Armed),
    (208, RobotMode::Following),
];

/// What is said for how many ms, and the robot's mode from which ms of it on.
const PLAN: [(Saying, i64, Course); 15] = [
    (Saying::Released, 2000, IDLE),
    (Saying::Future, 300, IDLE),
    (Saying::Old, 300, IDLE),
    (Saying::Foreign, 300, IDLE),
    (Saying::OutOfRange, 300, IDLE),
    (Saying::Stay, 400, ARMING),
    (Saying::Intruder, 300, &[(0, RobotMode::Following)]),
    (
        Saying::Released,
        100,
        &[
            (0, RobotMode::Following),
            (8, RobotMode::Braking),
            (40, RobotMode::Idle),
        ],
    ),
    (Saying::Stay, 400, ARMING),
    (
        Saying::Silence,
        100,
        &[
            (0, RobotMode::Following),
            (12, RobotMode::Bridging),
            (56, RobotMode::Braking),
            (60, RobotMode::Fault),
        ],
    ),
    (Saying::Stay, 300, FAULT),
    (Saying::ResetWhileEnabled, 300, FAULT),
    (Saying::Released, 300, FAULT),
    (Saying::Reset, 100, &[(0, RobotMode::Fault), (8, RobotMode::Idle)]),
    (Saying::Released, 300, IDLE),
];

fn hello() -> Hello {
    Hello {
        protocol: PROTOCOL,
        ticks_per_cycle: PERIOD as i32,
        ..Hello::default()
    }
}

fn statuses(role: Role, until_us: i64) -> Vec<At<NodeStatus>> {
    let status = |us| {
        let mut message = Health::new(role, hello()).status();
        message.stamp = Stamp {
            step: 0,
            utime: us + AHEAD_US,
            boot_id: BOOT_ID,
        };
        At { us, message }
    };
    (0..until_us / 100_000)
        .map(|i| status(100_000 * i + 30))
        .collect()
}

fn command(us: i64) -> At<Command> {
    let message = Command {
        stamp: Stamp::default(),
        enable: false,
        axis_position: [Axes::zeros(); HORIZON],
        send_utime: us,
        authenticity: Authenticity::default(),
    };
    At { us, message }
}

/// What a message sent at `utime` of the node's clock echoes of the command that went at `sent`.
fn echo(sent: Option<i64>, utime: i64) -> ClockEcho {
    sent.map_or(ClockEcho::default(), |sent| ClockEcho {
        command_send_utime: sent,
        receive_utime: sent + WAY_US + AHEAD_US,
        send_utime: utime,
    })
}

/// A robot that turns each axis by 1 nrad per ms.
pub(super) fn robot() -> Record {
    robot_told(&PLAN)
}

fn robot_told(plan: &[(Saying, i64, Course)]) -> Record {
    let mut record = Record::new(Role::Robot);
    let (mut step, mut accepted, mut sent) = (0, -1, None);
    for &(saying, length, course) in plan {
        let from_us = step * 1000;
        record.phases.push(Phase {
            saying,
            from_us,
            until_us: from_us + length * 1000,
        });
        for ms in (0..length).step_by(PERIOD as usize) {
            let mode = course.iter().rev().find(|(from, _)| *from <= ms).unwrap().1;
            let faulty =
                mode == RobotMode::Fault || (mode == RobotMode::Braking && saying == Saying::Silence);
            let utime = step * 1000 + AHEAD_US;
            let us = step * 1000 + WAY_US + 20;
            let message = RobotState {
                stamp: Stamp {
                    step,
                    utime,
                    boot_id: BOOT_ID,
                },
                sample_count: (step + 1).min(8) as i32,
                axis_position: std::array::from_fn(|i| Axes::repeat(1e-9 * (step - i as i64) as f64)),
                axis_velocity: Axes::repeat(1e-6),
                axis_setpoint: Axes::zeros(),
                mode,
                fault: if faulty { Fault::CommandGap } else { Fault::None },
                fault_axis: -1,
                command_step: accepted,
                missed_commands: 0,
                echo: echo(sent, utime + 20),
                authenticity: Authenticity::default(),
            };
            record.states.push(At { us, message });
            if saying != Saying::Silence {
                (accepted, sent) = (step, Some(us + 30));
                record.commands.push(command(us + 30));
            }
            if matches!(saying, Saying::ResetWhileEnabled | Saying::Reset) {
                record.resets_us.push(us + 40);
            }
            step += PERIOD;
        }
    }
    record.listened_us = step * 1000;
    record.statuses = statuses(Role::Robot, record.listened_us);
    record
}

/// A sensor that publishes every `k` ticks.
pub(super) fn sensor_every(k: i64) -> Record {
    let mut record = Record::new(Role::Sensor);
    record.listened_us = 3_000_000;
    record.statuses = statuses(Role::Sensor, record.listened_us);
    record.commands = (0..750).map(|i| command(4000 * i + 500)).collect();
    for tick in (0..3000).step_by(k as usize) {
        let utime = tick * 1000 + AHEAD_US;
        let sample = |i: usize| {
            let n = tick - i as i64;
            let mut sample = DeflectionSample {
                utime: utime - 1000 * i as i64,
                ..DeflectionSample::default()
            };
            if n >= 0 {
                sample.deflection.translation.z = 1e-6 * (n * 7919 % 13) as f64;
                sample.flags.valid = true;
            }
            sample
        };
        // The command before the newest one is surely there.
        let sent = (tick >= 4).then_some((tick / 4 - 1) * 4000 + 500);
        let message = Deflections {
            stamp: Stamp {
                step: tick,
                utime,
                boot_id: BOOT_ID,
            },
            samples: std::array::from_fn(sample),
            echo: echo(sent, utime + 20),
            authenticity: Authenticity::default(),
        };
        record.deflections.push(At {
            us: tick * 1000 + WAY_US + 20,
            message,
        });
    }
    record
}

/// A robot that has the key.
pub(super) fn signing_robot() -> Record {
    let unsigned = (Saying::Unsigned, 300, IDLE);
    let mut record = robot_told(&[&PLAN[..5], &[unsigned], &PLAN[5..]].concat());
    record
        .statuses
        .iter_mut()
        .for_each(|it| it.message.authenticated = true);
    record.signed = Some(Signed {
        taken: record.states.len() as u64,
        ..Signed::default()
    });
    record
}

/// A sensor that publishes every tick.
pub(super) fn sensor() -> Record {
    sensor_every(1)
}
