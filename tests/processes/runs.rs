//! Runs as a user starts them.

use experiment::scenarios::Source;
use experiment::{calibrate, transcript};
use node::scenario::Scenario;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use tests::touchdown;

fn run(directory: &Path, seed: &str) -> std::process::Command {
    let mut command = touchdown();
    command
        .args([
            "run", "paper", "--laws", "proposed", "--json", "--seed", seed, "--out",
        ])
        .arg(directory);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn peak(json: &[u8]) -> f64 {
    let report: serde_json::Value = serde_json::from_slice(json).unwrap();
    report["rows"][0]["mean"]["peak_n"].as_f64().unwrap()
}

fn alone(seed: &str) -> f64 {
    let text = experiment::scenarios::Source::find("paper").unwrap().text;
    let scenario = node::scenario::Scenario::parse("paper", &text, &[format!("timing.seed={seed}")]);
    experiment::compare::metrics(&scenario.unwrap()).unwrap().peak_n
}

/// Two runs at once on one machine find ports of their own, and each gives what it gives alone, also into the same
/// directory.
fn assert_undisturbed(directories: [&Path; 2]) {
    let seeds = ["1", "2"];
    let children = [0, 1].map(|i| run(directories[i], seeds[i]).spawn().unwrap());
    let together = children.map(|child| child.wait_with_output().unwrap());
    for ((output, directory), seed) in together.iter().zip(directories).zip(seeds) {
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        assert_eq!(peak(&output.stdout), alone(seed));
        let entries = fs::read_dir(directory).unwrap();
        let names: BTreeSet<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        let expected = ["force.svg", "proposed.csv", "scenario.toml"];
        assert_eq!(names, expected.map(str::to_owned).into());
    }
}

#[test]
fn two_runs_at_once_do_not_disturb_each_other() {
    let directories = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    assert_undisturbed(directories.each_ref().map(tempfile::TempDir::path));
}

#[test]
fn two_runs_at_once_into_the_same_directory_do_not_either() {
    let directory = tempfile::tempdir().unwrap();
    assert_undisturbed([directory.path(); 2]);
}

/// What is learnt of another sensor than assumed is printed, and written so that a scenario can be made of it; it is
/// what the loop in one process gives.
#[test]
fn a_calibration_becomes_a_scenario() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("found.toml");
    let settings = [
        "sensor.stiffness_n_per_m=200e3",
        "sensor.wrench_measured=true",
        "task.calibration_rest_s=0.4",
        "task.approach_speed_m_per_s=0.1",
    ];
    let mut command = touchdown();
    command.args(["calibrate", "--json", "--out"]).arg(&file);
    settings.iter().for_each(|setting| {
        command.args(["--set", setting]);
    });
    let output = command.output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();

    let source = Source::find("paper").unwrap();
    let overrides = calibrate::overrides(&settings.map(str::to_owned), |all| source.scenario(all)).unwrap();
    let scenario = source.scenario(&overrides).unwrap();
    let entries = transcript::in_process(&scenario).unwrap();
    let alone = calibrate::from_transcript(&scenario, &entries).unwrap();
    let number = |key: &str| report["compliance_m_per_n"][key].as_f64().unwrap();
    for (printed, expected) in [
        (number("value"), alone.compliance_m_per_n.value),
        (number("standard_deviation"), alone.compliance_m_per_n.sigma),
        (number("configured"), 3.3333333333e-6),
    ] {
        // JSON is read to within a few bits.
        assert!(
            (printed / expected - 1.0).abs() < 1e-14,
            "{printed}, not {expected}"
        );
    }
    assert_eq!(
        report["tool_centre_of_mass_in_s_m"]["value"]
            .as_array()
            .unwrap()
            .len(),
        3
    );
    assert_eq!(report["missing"], serde_json::Value::Null);

    let found = Scenario::load(&file, &[]).unwrap().controller;
    assert!(
        (found.compliance_m_per_n / 5e-6 - 1.0).abs() < 0.02,
        "{}",
        found.compliance_m_per_n
    );
    assert!(
        (found.tool_mass_kg - 4.0).abs() < 0.02,
        "{} kg",
        found.tool_mass_kg
    );
}
