//! Three processes by the wall clock, each with a clock of its own, over a network that is not perfect.
//!
//! What is asserted are results and states; how long anything takes is up to the machine. One test at a time has it for
//! itself: this binary is apart from the other processes' tests, which are as fast as they can.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod authenticity;
mod hand_over;
mod hostile;
mod network;

use experiment::log::Log;
use experiment::transcript;
use spatial::ports::{ControllerPhase, Fault, NodeState, NodeStatus, RobotMode, Role};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tests::faults::{Injury, Moment, Outcome, inflict};
use tests::site::{LONG, Setting, Site};

static MACHINE: Mutex<()> = Mutex::new(());

/// The machine for one test alone, also after one that has failed.
fn alone() -> MutexGuard<'static, ()> {
    MACHINE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A busy machine may hold a process up for longer than a robot would wait, or a controller trust what it knows.
fn patient() -> Setting<'static> {
    Setting {
        overrides: &["robot.command_gap_s=0.25", "controller.stale_fault_s=0.25"],
        ..Setting::default()
    }
}

fn until_settled(site: &mut Site) {
    assert!(
        site.until(LONG, |heard| heard.phase() == Some(ControllerPhase::Settled)),
        "{:?}",
        site.heard.controller
    );
}

/// A sample of `make faults`.
fn sample(injury: Injury, moment: Moment) -> Outcome {
    let outcome = inflict(&patient(), injury, moment).unwrap();
    assert_eq!(outcome.broken(), None);
    outcome
}

#[test]
fn a_robot_without_its_controller_stops_and_can_be_used_again() {
    let _alone = alone();
    let outcome = sample(Injury::Kill(Role::Controller), Moment::Settled);
    assert_eq!(outcome.robot, (RobotMode::Fault, Fault::CommandGap));
    assert!(outcome.stop_ticks.is_some());
}

#[test]
fn a_controller_without_its_sensor_holds_and_says_so() {
    let _alone = alone();
    // For longer than the patient setting trusts a deflection.
    let outcome = sample(Injury::Cut(Role::Sensor, 1000), Moment::Contact);
    assert_eq!(outcome.controller, Fault::SensorStale);
}

#[test]
fn a_clock_that_steps_stops_the_experiment_by_name() {
    let _alone = alone();
    let outcome = sample(Injury::ClockStep(Role::Sensor, 1), Moment::Settled);
    assert_eq!(outcome.controller, Fault::ClockJump);
}

#[test]
fn a_second_controller_does_not_work_and_does_not_disturb() {
    let _alone = alone();
    let mut site = Site::start(&patient()).unwrap();
    until_settled(&mut site);
    let first = site.heard.nodes[Role::Controller as usize].unwrap().stamp.boot_id;
    let plan = site.bench.plan.clone();
    site.cell.start_another(&plan, Role::Controller).unwrap();
    let second = |site: &mut Site| {
        site.until(LONG, |heard| {
            heard.nodes[Role::Controller as usize]
                .is_some_and(|status| status.stamp.boot_id != first && status.state == NodeState::Fault)
        })
    };
    assert!(second(&mut site), "the second one is not heard of");
    let status = site.heard.nodes[Role::Controller as usize].unwrap();
    assert_eq!((status.fault, status.fault_found), (Fault::SecondOwner, first));
    site.listen(Duration::from_millis(300));
    assert_eq!(site.heard.command.unwrap().stamp.boot_id, first);
    assert_eq!(site.heard.robot.unwrap().fault, Fault::None);
    // Starting a process takes the cores from the first one for some cycles: it may have to settle again.
    until_settled(&mut site);
}

#[test]
fn another_scenario_is_refused_with_both_hashes() {
    let _alone = alone();
    let mut site = Site::start(&patient()).unwrap();
    until_settled(&mut site);
    site.cell.kill(Role::Controller);
    let mut plan = site.bench.plan.clone();
    plan.overrides.push("task.desired_force_n=11".to_owned());
    site.cell.start_another(&plan, Role::Controller).unwrap();
    let refused = site.until(LONG, |heard| {
        heard.nodes[Role::Controller as usize].is_some_and(|status| status.fault == Fault::HelloMismatch)
    });
    assert!(refused);
    let status = site.heard.nodes[Role::Controller as usize].unwrap();
    assert_eq!(
        (status.fault_expected, status.fault_found),
        (status.hello.configuration_hash, site.bench.scenario.hash())
    );
    // Both have kept what came before: the one that was refused, and the robot that had no controller.
    let directory = site.bench.directory.path().to_owned();
    for (name, role, fault) in [
        ("flight-controller-", Role::Controller, Fault::HelloMismatch),
        ("flight-robot-sim-", Role::Robot, Fault::CommandGap),
    ] {
        assert!(
            site.until(LONG, |_| kept(&directory, name).is_some()),
            "no {name}*"
        );
        let log = Log::open(&kept(&directory, name).unwrap()).unwrap();
        assert_eq!(log.complaints(), Vec::<String>::new());
        let told = transcript::messages::<NodeStatus>(&log.entries).last().unwrap();
        assert_eq!((told.role, told.fault), (role, fault));
        let heard = log
            .entries
            .iter()
            .any(|entry| entry.channel == "HEARD_ROBOT_COMMAND");
        assert_eq!(heard, role == Role::Robot);
    }
}

/// A flight record.
fn kept(directory: &Path, name: &str) -> Option<PathBuf> {
    let files = std::fs::read_dir(directory).unwrap().flatten();
    files.map(|entry| entry.path()).find(|path| {
        let file = path.file_name().unwrap().to_string_lossy();
        file.starts_with(name) && file.ends_with(".lcmlog")
    })
}
