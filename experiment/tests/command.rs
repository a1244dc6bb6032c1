//! The command `touchdown` as its users see it: exit codes, refusals, and nothing but data on stdout.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod common;

use common::touchdown;
use serde_json::Value;
use std::collections::BTreeSet;

#[test]
fn what_does_not_exist_is_refused_by_name() {
    for (arguments, error) in [
        (
            "compare --set timing.mode=realtim",
            "timing.mode is the unknown word \"realtim\"; choose \"lockstep\" or \"realtime\"",
        ),
        ("compare --laws pid", "controller.law is the unknown word \"pid\""),
        (
            "compare --laws pd,proposed,pd",
            "--laws names \"pd\" twice; name each once",
        ),
        (
            "run --laws proposed,proposed",
            "--laws names \"proposed\" twice; name each once",
        ),
        (
            "compare papre",
            "unknown scenario \"papre\"; the built-in ones are: paper",
        ),
        ("compare missing.toml", "the scenario missing.toml can't be read"),
        ("compare --set task.desired_force_n=-1", "below the limit of 0.1"),
        (
            "bench simulation --set robot.mass_kg=1",
            "unknown key robot.mass_kg",
        ),
        (
            "compare --phases 0",
            "invalid value '0' for '--phases <N>': 0 is not in 1..=1000",
        ),
        (
            "compare --seeds 0",
            "invalid value '0' for '--seeds <N>': 0 is not in 1..=1000",
        ),
        ("compare --law pd", "unexpected argument '--law'"),
    ] {
        let (code, stdout, stderr) = touchdown(arguments);
        assert_eq!((code, stdout.as_str()), (2, ""), "{arguments}: {stderr}");
        assert!(stderr.starts_with("error: "), "{arguments}: {stderr}");
        assert!(stderr.contains(error), "{arguments}: {stderr}");
    }
}

#[test]
fn a_comparison_is_one_object_with_units_in_its_keys() {
    let (code, stdout, stderr) = touchdown("compare --laws proposed --phases 2 --seeds 1 --json");
    assert_eq!((code, stderr.as_str()), (0, ""));
    let report: Value = serde_json::from_str(&stdout).unwrap();
    assert_keys(
        &report,
        "command scenario configuration_hash phases seeds rows failures",
    );
    assert_eq!(
        (&report["command"], &report["scenario"]),
        (&"compare".into(), &"paper".into())
    );
    assert_eq!((&report["phases"], &report["seeds"]), (&2.into(), &1.into()));
    assert_eq!(report["configuration_hash"].as_str().unwrap().len(), 16);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 1);
    assert_keys(&rows[0], "robot kinematics law gains runs mean worst confidence");
    for kind in ["mean", "worst"] {
        assert_keys(
            &rows[0][kind],
            "peak_n overshoot_ratio settling_10_s settling_5_s settling_2_s iae_n_s impulse_above_n_s steady_error_n \
             steady_sigma_n ringing_ratio rebounds orientation_max_rad orientation_end_rad detection_delay_s \
             impact_peak_n energy_j",
        );
        assert!(rows[0][kind]["peak_n"].as_f64().unwrap() > 10.0);
    }
}

#[test]
fn runs_without_contact_fail_by_name() {
    let arguments = "compare --set timing.duration_s=0.5 --laws pd --phases 2 --seeds 1";
    let (code, stdout, stderr) = touchdown(arguments);
    assert_eq!((code, stdout.as_str()), (1, ""), "{stderr}");
    let errors: Vec<_> = stderr.lines().collect();
    assert_eq!(errors.len(), 2, "{stderr}");
    assert!(
        errors[1]
            .starts_with("error: law pd on rigid gantry, phase 2, seed 1: no contact within 0.5 s; raise "),
        "{stderr}"
    );
    let (code, stdout, _) = touchdown(&format!("{arguments} --json"));
    let report: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(code, 1);
    assert_keys(
        &report["failures"][1],
        "robot kinematics law gains phase seed reason",
    );
}

#[test]
fn the_rate_of_the_simulation_is_measured() {
    let (code, stdout, _) =
        touchdown("bench simulation --repetitions 2 --threads 3 --set timing.duration_s=0.1 --json");
    let report: Value = serde_json::from_str(&stdout).unwrap();
    let number = |key: &str| report[key].as_f64().unwrap();
    assert_eq!(code, 0);
    assert_eq!(number("ticks"), 101.0);
    assert!(number("simulated_s_per_core_s_min") > 0.0, "{stdout}");
    for part in ["robot", "sensor", "controller"] {
        assert!(number(&format!("{part}_us_per_tick")) > 0.0, "{stdout}");
    }
    let sweep = &report["sweep"];
    assert_keys(
        sweep,
        "threads runs speed_up speed_up_min speed_up_max speed_up_per_core",
    );
    assert_eq!((&sweep["threads"], &sweep["runs"]), (&3.into(), &64.into()));
    assert!(
        number("simulated_s_per_core_s") <= number("simulated_s_per_core_s_max"),
        "{stdout}"
    );
    assert!(
        (number("ticks_per_core_s") / number("simulated_s_per_core_s") - 1e3).abs() < 1e-6,
        "{stdout}"
    );
}

#[test]
fn a_python_without_mujoco_is_refused() {
    let (code, _, stderr) = touchdown("bench mujoco --python false");
    assert_eq!(code, 2);
    assert!(
        stderr.starts_with("error: false has no package mujoco; `pip install mujoco`"),
        "{stderr}"
    );
}

#[test]
fn help_tells_the_exit_codes() {
    let (code, stdout, _) = touchdown("--help");
    assert_eq!(code, 0);
    for line in [
        "0    all is well",
        "1    the",
        "2    wrong usage",
        "130  interrupted",
    ] {
        assert!(stdout.contains(line), "{stdout}");
    }
}

/// Whether `object` has these keys, separated by spaces, and no others.
#[track_caller]
fn assert_keys(object: &Value, keys: &str) {
    let found: BTreeSet<_> = object.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(found, keys.split(' ').collect());
}
