//! Runs as a user starts them.

use std::process::Stdio;
use tests::touchdown;

fn run(directory: &std::path::Path, seed: &str) -> std::process::Command {
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

/// Two runs at once on one machine find ports of their own, and each gives what it gives alone.
#[test]
fn two_runs_at_once_do_not_disturb_each_other() {
    let directories = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let seeds = ["1", "2"];
    let children: Vec<_> = directories
        .iter()
        .zip(seeds)
        .map(|(d, seed)| run(d.path(), seed).spawn().unwrap())
        .collect();
    let together: Vec<_> = children
        .into_iter()
        .map(|child| child.wait_with_output().unwrap())
        .collect();
    for ((output, directory), seed) in together.iter().zip(&directories).zip(seeds) {
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let scenario = node::scenario::Scenario::parse(
            "paper",
            &experiment::scenarios::Source::find("paper").unwrap().text,
            &[format!("timing.seed={seed}")],
        );
        let alone = experiment::compare::metrics(&scenario.unwrap()).unwrap();
        assert_eq!(peak(&output.stdout), alone.peak_n);
        for file in ["force.svg", "proposed.lcmlog", "proposed.csv", "scenario.toml"] {
            assert!(
                directory.path().join(file).metadata().unwrap().len() > 0,
                "{file}"
            );
        }
    }
}
