//! A loop that swings up in contact: its gain is lowered until it settles, and that is said.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use experiment::in_process;
use experiment::scenarios::Source;
use spatial::ports::{ControllerStatus, Fault, LIMIT_GAIN};

/// The last status of a run of `name` with `overrides`, whether the gain was ever lowered, the largest force (N) that the tcp's
/// deflection shows, and the
/// force's largest error in the last quarter second, N.
fn run(name: &str, overrides: &[&str]) -> (ControllerStatus, bool, f64, f64) {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    let scenario = Source::find(name).unwrap().scenario(&overrides).unwrap();
    let (mut last, mut lowered, mut peak, mut error) = (None, false, 0.0_f64, 0.0_f64);
    let end = scenario.timing.ticks() - 250;
    in_process::run(&scenario, |tick| {
        let truth = &tick.sensor.truth;
        if truth.stamp.step > end {
            error = error.max((truth.contact_force.z - scenario.task.desired_force_n).abs());
        }
        if let Some(answer) = tick.controller {
            peak = peak.max(answer.status.detection.statistic_n);
            lowered |= answer.status.limits & LIMIT_GAIN != 0;
            last = Some(answer.status);
        }
    });
    (last.unwrap(), lowered, peak, error)
}

/// Assumptions and gains beyond the border of stability. Without the observer the force grows until the tool bounces or
/// the robot is stopped; with it the force comes to rest near what is desired, and never leaves `most_n`.
#[test]
fn what_swings_up_is_calmed_before_the_force_leaves_a_bound() {
    let (force, wrench) = ("controller.sensor_output=force", "sensor.wrench_measured=true");
    let stiffer = "controller.compliance_m_per_n=10e-6";
    let turns = "controller.compliance_rad_per_nm=7.48e-3";
    let cases: [(&str, &[&str]); 4] = [
        (
            "paper",
            &["controller.law=literal", force, wrench, stiffer, turns],
        ),
        (
            "paper",
            &["controller.law=pd", "controller.pd.proportional_m_per_n=12e-6"],
        ),
        ("elastic", &["controller.law=literal"]),
        (
            "elastic",
            &["controller.law=pd", "controller.pd.proportional_m_per_n=6e-6"],
        ),
    ];
    for (name, overrides) in cases {
        let long = [overrides, &["timing.duration_s=5.0"]].concat();
        let off = [&long[..], &["controller.oscillation.enabled=false"]].concat();
        let (_, lowered, unchecked_n, swings_n) = run(name, &off);
        assert!(
            !lowered && swings_n > 5.0,
            "{overrides:?}: {swings_n} N, {unchecked_n} N"
        );
        let (status, lowered, peak_n, error_n) = run(name, &long);
        println!(
            "{name} {overrides:?}: {unchecked_n:.1} N, {swings_n:.1} N; calmed {peak_n:.1} N, {error_n:.2} N"
        );
        assert!(lowered && status.limits & LIMIT_GAIN != 0, "{overrides:?}");
        assert_eq!(status.fault, Fault::None, "{overrides:?}");
        assert!(
            peak_n < 60.0 && error_n < 1.0,
            "{overrides:?}: {peak_n} N, {error_n} N"
        );
    }
}

/// Nothing is lowered where nothing swings up: stable laws on every robot, an object that moves and shakes. (A tool that
/// rocks onto a tilted face does swing up, and is calmed.)
#[test]
fn the_gain_of_what_is_stable_stays() {
    for (name, laws) in [
        (
            "paper",
            &["pd", "pd-reset", "literal", "proposed", "impedance"][..],
        ),
        ("arm", &["pd", "proposed"]),
        ("elastic", &["pd", "proposed", "elastic"]),
        ("elastic_arm", &["pd", "proposed", "elastic"]),
        ("conveyor", &["proposed"]),
        ("expected", &["proposed"]),
    ] {
        for law in laws {
            let law = format!("controller.law={law}");
            let (_, lowered, peak_n, _) = run(name, &[&law]);
            assert!(!lowered, "{name}, {law}: {peak_n} N");
        }
    }
}
