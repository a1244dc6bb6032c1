//! Runs as a user starts them.

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
        let expected = ["force.svg", "proposed.csv", "proposed.lcmlog", "scenario.toml"];
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
