//! Three processes by the wall clock, each with a clock of its own, over a network that is not perfect.
//!
//! What is asserted are results and states; how long anything takes is up to the machine.

use experiment::metrics::{Metrics, Recording};
use spatial::ports::{ControllerPhase, Fault, NodeState, RobotMode, Role};
use std::time::Duration;
use tests::Impairment;
use tests::faults::{Injury, Moment, Outcome, inflict};
use tests::site::{LONG, Site};

/// A busy machine may hold a process up for longer than a robot would wait.
const PATIENT: &str = "robot.command_gap_s=0.25";

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

/// 200 us and as much jitter, 1 % loss, clocks 12 ms and 20 ppm apart: the same experiment as in lockstep.
#[test]
fn on_an_ordinary_network_with_clocks_apart_the_figures_are_those_of_lockstep() {
    let impairment = Impairment {
        loss: 0.01,
        delay: Duration::from_micros(200),
        jitter: Duration::from_micros(200),
        seed: 5,
        ..Impairment::default()
    };
    let flags: [&[&str]; 3] = [
        &[],
        &["--clock-offset-s=0.012", "--clock-drift-ppm=20"],
        &["--clock-offset-s=-3600"],
    ];
    let mut site = Site::start("paper", &[PATIENT], impairment, flags).unwrap();
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

/// 5 % loss, 5 % duplicates, 5 % overtaken, 1 % with a wrong bit.
#[test]
fn on_a_bad_network_it_stays_in_contact() {
    let impairment = Impairment {
        loss: 0.05,
        duplication: 0.05,
        reordering: 0.05,
        corruption: 0.01,
        jitter: Duration::from_micros(300),
        seed: 6,
        ..Impairment::default()
    };
    let mut site = Site::start("paper", &[PATIENT], impairment, [&[], &[], &[]]).unwrap();
    until_settled(&mut site);
    for _ in 0..10 {
        site.listen(Duration::from_millis(100));
        let force_n = site.heard.truth.unwrap().contact_force.z;
        assert!((force_n - 10.0).abs() < 2.0, "{force_n} N");
    }
    let robot = site.heard.robot.unwrap();
    assert_eq!(robot.fault, Fault::None);
}

/// A sample of `make faults`.
fn sample(injury: Injury, moment: Moment) -> Outcome {
    let outcome = inflict("paper", &[], Impairment::default(), injury, moment).unwrap();
    let [after_n, before_n] = outcome.force_n;
    assert!(
        after_n <= 1.2 * before_n.max(10.0),
        "{after_n} N after {before_n} N"
    );
    let [fastest, limit] = outcome.speed_rad_per_s;
    assert!(fastest <= limit, "{fastest} rad/s");
    let again_n = outcome.again_n.clone().unwrap();
    assert!((again_n - 10.0).abs() < 0.5, "{again_n} N");
    outcome
}

#[test]
fn a_robot_without_its_controller_stops_and_can_be_used_again() {
    let outcome = sample(Injury::Kill(Role::Controller), Moment::Settled);
    assert_eq!(outcome.robot, (RobotMode::Fault, Fault::CommandGap));
    let [took, may] = outcome.stop_ticks.unwrap();
    assert!(took <= may, "{took} ms");
}

#[test]
fn a_controller_without_its_sensor_holds_and_says_so() {
    let outcome = sample(Injury::Cut(Role::Sensor, 200), Moment::Contact);
    assert_eq!(outcome.controller, Fault::SensorStale);
}

#[test]
fn a_second_controller_does_not_work_and_does_not_disturb() {
    let mut site = Site::start("paper", &[PATIENT], Impairment::default(), [&[], &[], &[]]).unwrap();
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
    assert_eq!(site.heard.phase(), Some(ControllerPhase::Settled));
}

#[test]
fn another_scenario_is_refused_with_both_hashes() {
    let mut site = Site::start("paper", &[PATIENT], Impairment::default(), [&[], &[], &[]]).unwrap();
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
}
