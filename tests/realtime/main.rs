//! Three processes by the wall clock, each with a clock of its own, over a network that is not perfect.
//!
//! What is asserted are results and states; how long anything takes is up to the machine. One test at a time has it for
//! itself: this binary is apart from the other processes' tests, which are as fast as they can.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod authenticity;
mod hand_over;
mod hostile;

use experiment::log::Log;
use experiment::metrics::{Metrics, Recording};
use experiment::transcript;
use spatial::ports::{ControllerPhase, Fault, NodeState, NodeStatus, RobotMode, Role};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tests::Impairment;
use tests::faults::{Injury, Moment, Outcome, inflict};
use tests::hosts::on_hosts;
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

fn in_process(site: &Site) -> Metrics {
    let mut scenario = site.bench.scenario.clone();
    scenario.timing.duration_s = 3.0;
    let mut recording = Recording::new(&scenario);
    experiment::in_process::run(&scenario, |tick| recording.observe(tick));
    recording.metrics().unwrap()
}

/// 200 us and as much jitter, 1 % loss.
fn ordinary() -> Impairment {
    Impairment {
        loss: 0.01,
        delay: Duration::from_micros(200),
        jitter: Duration::from_micros(200),
        seed: 5,
        ..Impairment::default()
    }
}

/// On such a network, clocks 12 ms and 20 ppm apart: the same experiment as in lockstep.
#[test]
fn on_an_ordinary_network_with_clocks_apart_the_figures_are_those_of_lockstep() {
    let _alone = alone();
    let flags: [&[&str]; 3] = [
        &[],
        &["--clock-offset-s=0.012", "--clock-drift-ppm=20"],
        &["--clock-offset-s=-3600"],
    ];
    let mut site = Site::start(&Setting {
        impairment: ordinary(),
        flags,
        ..patient()
    })
    .unwrap();
    until_settled(&mut site);
    site.listen(Duration::from_millis(1700));
    let expected = in_process(&site);
    let clocks = site.heard.nodes[Role::Controller as usize].unwrap();
    // Against the controller's own clock: the robot's is an hour ahead, the sensor's 12 ms more.
    for (i, ahead_s) in [(0, 3600.0), (1, 3600.012)] {
        let (found, bound) = (clocks.clock_offset_s[i], clocks.clock_bound_s[i]);
        // 20 ppm of the seconds that it runs.
        let drifted = 200e-6;
        assert!(
            bound > 0.0 && (found - ahead_s).abs() < bound + drifted,
            "{found} +- {bound} s"
        );
    }
    assert_same_figures(site, &expected);
}

fn assert_same_figures(site: Site, expected: &Metrics) {
    let scenario = site.bench.scenario.clone();
    let entries = site.finish().unwrap();
    let found = Recording::from_transcript(&scenario, &entries)
        .0
        .metrics()
        .unwrap();
    for (name, found, expected) in [
        ("peak", found.peak_n, expected.peak_n),
        ("IAE", found.iae_n_s, expected.iae_n_s),
    ] {
        assert!(
            (found / expected - 1.0).abs() < 0.2,
            "{name}: {found} instead of {expected}"
        );
    }
    assert!((found.steady_error_n).abs() < 0.1, "{}", found.steady_error_n);
}

/// The same on three hosts, joined by a bridge and the relay, whose monotonic clocks are days apart.
fn on_three_hosts(name: &str, scenario: &str) {
    on_hosts(name, |hosts| {
        let mut site = Site::start(&Setting {
            scenario,
            impairment: ordinary(),
            hosts: Some(hosts),
            ..patient()
        })
        .unwrap();
        until_settled(&mut site);
        site.listen(Duration::from_millis(1700));
        let expected = in_process(&site);
        assert_same_figures(site, &expected);
    });
}

#[test]
fn on_three_hosts_the_rigid_arm_presses_as_in_lockstep() {
    let _alone = alone();
    on_three_hosts("on_three_hosts_the_rigid_arm_presses_as_in_lockstep", "arm");
}

#[test]
fn on_three_hosts_the_elastic_arm_presses_as_in_lockstep() {
    let _alone = alone();
    on_three_hosts(
        "on_three_hosts_the_elastic_arm_presses_as_in_lockstep",
        "elastic_arm",
    );
}

/// 5 % loss, 5 % duplicates, 5 % overtaken.
#[test]
fn on_a_bad_network_it_stays_in_contact() {
    let _alone = alone();
    let impairment = Impairment {
        loss: 0.05,
        duplication: 0.05,
        reordering: 0.05,
        jitter: Duration::from_micros(300),
        seed: 6,
        ..Impairment::default()
    };
    let mut site = Site::start(&Setting {
        impairment,
        ..patient()
    })
    .unwrap();
    until_settled(&mut site);
    for _ in 0..50 {
        site.listen(Duration::from_millis(20));
        // What the sensor's deflection stands for: the contact itself still rings after the impact.
        let error_n = site.heard.controller.unwrap().force_error_n;
        assert!(error_n.abs() < 1.0, "{error_n} N");
    }
    let robot = site.heard.robot.unwrap();
    assert_eq!(robot.fault, Fault::None);
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

/// One bit in every hundredth message is wrong. No tag tells yet that it is: what can't be is refused, what could be is
/// believed. No process ends, and nothing moves beyond its limits.
#[test]
fn wrong_bits_end_no_process() {
    let _alone = alone();
    let mut site = Site::start(&Setting {
        impairment: Impairment {
            corruption: 0.01,
            seed: 7,
            ..Impairment::default()
        },
        ..patient()
    })
    .unwrap();
    assert!(site.until(LONG, |heard| {
        heard.robot.is_some_and(|robot| robot.stamp.step > 3000)
    }));
    let limit = site.bench.scenario.robot.drives().velocity_limit_rad_per_s.amax();
    assert!(site.heard.speed_rad_per_s <= limit);
    // Each still answers.
    site.heard.nodes = [None; 3];
    assert!(site.until(LONG, |heard| heard.nodes.iter().all(Option::is_some)));
}
