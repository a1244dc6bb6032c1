//! Replays of runs in one process, whole, changed, and cut.

use super::*;
use crate::scenarios::Source;
use crate::transcript;
use lcmtypes::Encoded;
use node::record::HEARD;
use spatial::TICK_US;
use spatial::ports::{Deflections, RobotState, Stamp, Task, TaskAction};
use std::path::Path;

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let overrides: Vec<_> = overrides.iter().map(|text| (*text).to_owned()).collect();
    Source::find(name).unwrap().scenario(&overrides).unwrap()
}

fn log(entries: Vec<Entry>) -> Log {
    Log::of(Path::new(""), entries)
}

fn tasks() -> [Task; 2] {
    [(1, 700, Some(12.5)), (2, 900, None)].map(|(step, tick, force)| {
        let mut task = Task {
            stamp: Stamp {
                step,
                utime: tick * TICK_US,
                boot_id: 5,
            },
            ..Task::default()
        };
        task.parameters.desired_force_n = force;
        if force.is_none() {
            task.action = TaskAction::Stop;
        }
        task
    })
}

#[test]
fn a_run_with_requests_comes_out_the_same() {
    for (name, overrides) in [
        (
            "paper",
            &["controller.law=proposed", "timing.duration_s=1.2"] as &[&str],
        ),
        ("expected", &["timing.duration_s=1.0"]),
        ("elastic", &["controller.law=elastic", "timing.duration_s=1.0"]),
    ] {
        let scenario = scenario(name, overrides);
        let mut entries = transcript::in_process_with(&scenario, &tasks()).unwrap();
        for task in tasks() {
            entries.push(Entry {
                utime: 0,
                channel: "TASK".to_owned(),
                bytes: task.encode().unwrap().as_bytes().to_vec(),
            });
        }
        let cycles = scenario.timing.ticks() as usize / 4 + 1;
        let replay = replay(&scenario, &log(entries)).unwrap();
        assert_eq!(replay.difference, None, "{name}");
        assert_eq!((replay.commands, replay.statuses), (cycles, cycles), "{name}");
        assert_eq!(replay.stopped, None);
    }
}

#[test]
fn the_first_difference_is_told_with_both_values() {
    let short = ["timing.duration_s=0.9"];
    let of = scenario("paper", &short);
    let entries = transcript::in_process(&of).unwrap();
    let other = scenario("paper", &["timing.duration_s=0.9", "task.desired_force_n=11"]);
    let found = replay(&other, &log(entries.clone())).unwrap().difference.unwrap();
    assert_eq!(
        found.to_string(),
        "CONTROLLER_STATUS of step 0: controller_desired_force_n[2] is 10.0 in the log and 11.0 replayed"
    );
    // One bit of one set-point.
    let mut changed = entries;
    let entry = changed
        .iter_mut()
        .find(|entry| entry.channel == "ROBOT_COMMAND" && entry.utime == 400 * TICK_US)
        .unwrap();
    let mut command = Command::decode(&entry.bytes).unwrap();
    let before = command.axis_position[1][2];
    command.axis_position[1][2] = f64::from_bits(before.to_bits() ^ 1);
    entry.bytes = command.encode().unwrap().as_bytes().to_vec();
    let replay = replay(&of, &log(changed)).unwrap();
    let found = replay.difference.unwrap();
    assert_eq!(
        (found.step, found.channel, replay.commands),
        (400, "ROBOT_COMMAND", 100)
    );
    assert_eq!(found.member, "command_axis_position_rad[1][2]");
    assert_eq!(found.replayed, format!("{before:?}"));
    assert_ne!(found.recorded, found.replayed);
}

#[test]
fn what_can_not_be_repeated_is_said() {
    let scenario = scenario("paper", &["timing.duration_s=0.5"]);
    let entries = transcript::in_process(&scenario).unwrap();
    let without = |channel: &str, ticks: std::ops::Range<i64>| {
        let mut entries = entries.clone();
        entries.retain(|entry| entry.channel != channel || !ticks.contains(&(entry.utime / TICK_US)));
        replay(&scenario, &log(entries))
    };
    let gap = without("SENSOR_DEFLECTION", 200..204).unwrap();
    assert_eq!((gap.commands, gap.difference), (50, None));
    assert_eq!(
        gap.stopped.unwrap(),
        "the log lacks SENSOR_DEFLECTION of step 200: what follows can't be repeated"
    );
    let refusal = |result: Result<Replay, Unreplayable>| result.unwrap_err().to_string();
    assert!(refusal(without("ROBOT_STATE", 0..100)).starts_with("the log begins at step 100"));
    let nothing = entries
        .iter()
        .filter(|entry| entry.channel.starts_with("SIM_"))
        .cloned();
    assert!(refusal(replay(&scenario, &log(nothing.collect()))).contains("nothing to compare"));
    let mut live = entries.clone();
    for entry in live
        .iter_mut()
        .filter(|entry| entry.channel == RobotState::CHANNEL)
    {
        let mut state = RobotState::decode(&entry.bytes).unwrap();
        state.stamp.utime += 1_700_000_000_000_000;
        entry.bytes = state.encode().unwrap().as_bytes().to_vec();
    }
    assert!(refusal(replay(&scenario, &log(live))).contains("without HEARD_* channels"));
}

/// As the controller records it in real time: a fault that its shell has found is no message.
#[test]
fn a_clock_that_has_jumped_comes_out_the_same() {
    let scenario = scenario("paper", &["timing.duration_s=0.9"]);
    let run = transcript::in_process(&scenario).unwrap();
    let (mut controller, mut entries) = (Controller::new(&scenario), Vec::new());
    let mut faults = Vec::new();
    for state in transcript::messages::<RobotState>(&run) {
        let tick = state.stamp.step;
        let deflections = transcript::messages::<Deflections>(&run).find(|it| it.stamp.step == tick);
        if tick == 600 {
            controller.latch(Fault::ClockJump);
        }
        let Outputs { command, status } = controller.cycle(&Heard {
            tick,
            state: Some(&state),
            deflections: deflections.as_ref(),
            object: None,
        });
        faults.push(status.fault);
        let mut keep = |before: &str, encoded: Encoded| {
            entries.push(Entry {
                utime: tick * TICK_US,
                channel: format!("{before}{}", encoded.channel()),
                bytes: encoded.as_bytes().to_vec(),
            });
        };
        keep("", command.encode().unwrap());
        keep("", status.encode().unwrap());
        keep(HEARD, state.encode().unwrap());
        keep(HEARD, deflections.unwrap().encode().unwrap());
    }
    assert_eq!((faults[149], faults[150]), (Fault::None, Fault::ClockJump));
    let replay = replay(&scenario, &log(entries)).unwrap();
    assert_eq!(
        (replay.difference, replay.statuses),
        (None, scenario.timing.ticks() as usize / 4 + 1)
    );
}
