//! The compliance adapted in contact, against what a wrong one costs without; and the watch on the sensor's zero.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use experiment::in_process;
use experiment::metrics::{Metrics, Recording};
use experiment::scenarios::Source;
use node::scenario::Scenario;
use spatial::ports::{ControllerPhase, ControllerStatus};

const ADAPTED: [&str; 2] = [
    "sensor.wrench_measured=true",
    "controller.adaptation.enabled=true",
];

fn scenario(name: &str, settings: &[&str]) -> Scenario {
    let overrides: Vec<String> = settings.iter().map(|&text| text.to_owned()).collect();
    Source::find(name).unwrap().scenario(&overrides).unwrap()
}

/// The figures, and the last status, of a run of `name` with an assumed compliance `ratio` times the real one.
fn run(name: &str, ratio: f64, settings: &[&str]) -> (Metrics, ControllerStatus) {
    let mut scenario = scenario(name, settings);
    scenario.controller.compliance_m_per_n = ratio / scenario.sensor.stiffness_n_per_m;
    scenario.controller.compliance_rad_per_nm = ratio / scenario.sensor.stiffness_nm_per_rad;
    let mut recording = Recording::new(&scenario);
    let mut last = None;
    in_process::run(&scenario, |tick| {
        recording.observe(tick);
        last = tick.controller.map(|outputs| outputs.status).or(last);
    });
    (recording.metrics().unwrap(), last.unwrap())
}

/// Whether the force ends at the desired one, with the real compliance known.
#[track_caller]
fn assert_adapted(name: &str, ratio: f64, settings: &[&str]) {
    let (metrics, status) = run(name, ratio, settings);
    let what = format!("{name}, {ratio} times C, {settings:?}");
    assert!(
        metrics.steady_error_n.abs() <= 0.1,
        "{what}: {} N",
        metrics.steady_error_n
    );
    let found = [
        status.compliance.translation[(0, 0)] * 300e3,
        status.compliance.rotation[(0, 0)] * 401.07,
    ];
    assert!(
        found.iter().all(|found| (found - 1.0).abs() < 0.02),
        "{what}: {found:?} times C"
    );
    assert!(
        status.compliance_confidence > 0.9,
        "{what}: {}",
        status.compliance_confidence
    );
}

#[test]
fn with_deflection_output_a_compliance_wrong_by_0_4_to_2_5_costs_nothing_in_the_end() {
    for ratio in [0.4, 0.7, 1.0, 1.5, 2.0, 2.5] {
        assert_adapted("paper", ratio, &ADAPTED);
    }
    for ratio in [0.4, 2.5] {
        assert_adapted("arm", ratio, &ADAPTED);
        assert_adapted("elastic", ratio, &ADAPTED);
        assert_adapted("paper", ratio, &[ADAPTED[0], ADAPTED[1], "controller.law=pd"]);
    }
}

#[test]
fn with_force_output_up_to_2() {
    for ratio in [0.4, 0.7, 1.0, 1.5, 2.0] {
        assert_adapted(
            "paper",
            ratio,
            &[ADAPTED[0], ADAPTED[1], "controller.sensor_output=force"],
        );
    }
}

/// What the tests above could not tell from a law that does not need C.
#[test]
fn without_adaptation_the_force_is_wrong_by_the_ratio() {
    for ratio in [0.4, 2.5] {
        // What the tool's inertia deflects looks like 2.5 times as much force with 0.4 times the compliance.
        let settings = [ADAPTED[0], "controller.apparent_mass_kg=10"];
        let (metrics, status) = run("paper", ratio, &settings);
        let expected = 10.0 * (ratio - 1.0);
        assert!(
            (metrics.steady_error_n - expected).abs() < 0.5,
            "{} N",
            metrics.steady_error_n
        );
        assert_eq!(status.compliance_confidence, 0.0);
        assert!((status.compliance.rotation[(1, 1)] * 401.07 - ratio).abs() < 1e-9);
    }
}

/// Planning anew in each cycle makes no bump where there is nothing to learn.
#[test]
fn a_right_compliance_is_left_alone() {
    let [(without, _), (with, _)] = [run("paper", 1.0, &ADAPTED[..1]), run("paper", 1.0, &ADAPTED)];
    assert!(
        with.peak_n < without.peak_n + 0.05,
        "{} N, {} N",
        with.peak_n,
        without.peak_n
    );
    assert!(
        with.iae_n_s < 1.05 * without.iae_n_s,
        "{} N s, {} N s",
        with.iae_n_s,
        without.iae_n_s
    );
    assert!(with.orientation_max_rad < without.orientation_max_rad + 2e-5);
    assert!(with.orientation_end_rad < without.orientation_end_rad + 2e-5);
}

/// The first status that says that the zero has drifted, and the last one before the approach.
fn drift(settings: &[&str]) -> (Option<ControllerStatus>, ControllerStatus) {
    let mut standing = vec!["task.standstill_s=2"];
    standing.extend(settings);
    let (mut first, mut last) = (None, None);
    in_process::run(&scenario("paper", &standing), |tick| {
        if let Some(status) = tick.controller.map(|outputs| outputs.status)
            && status.phase <= ControllerPhase::Ready
        {
            first = first.or((status.limits & 64 != 0).then_some(status));
            last = Some(status);
        }
    });
    (first, last.unwrap())
}

/// 15 um/s of the sensor's translation are 15 um/s at the tcp, 0.53 N/s: 0.4 N are reached 0.75 s after the tare's
/// middle, and the low pass follows 0.5 s later.
#[test]
fn a_drifting_zero_is_said_before_it_is_a_contact() {
    let drifting = "sensor.drift_translation_m_per_s=[0, 0, 15e-6]";
    let (first, last) = drift(&[drifting]);
    let first = first.unwrap();
    assert!(
        (1200..1500).contains(&first.stamp.step),
        "tick {}",
        first.stamp.step
    );
    assert!(first.detection.statistic_n < 0.82 + 0.6 && first.detection.contact_step == -1);
    assert!(last.limits & 64 != 0);
    // The tare stays as it was.
    assert_eq!(last.tare, first.tare);
    let (first, _) = drift(&[]);
    assert_eq!(first, None);
    let (first, _) = drift(&[drifting, "controller.drift_limit_n=2"]);
    assert_eq!(first, None);
}
