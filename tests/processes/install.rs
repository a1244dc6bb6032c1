//! `make install` and what comes of it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tests::programs;

fn make(target: &str, place: &Path) {
    let mut command = Command::new("make");
    command
        .arg(target)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .arg("PREFIX=/opt/touchdown")
        .arg(format!("DESTDIR={}", place.display()))
        .arg(format!("BUILT={}", programs().display()));
    let output = command.output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// All files below `directory`.
fn files(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let each = |path: PathBuf| match path.is_dir() {
        true => files(&path),
        false => vec![path],
    };
    entries.flat_map(each).collect()
}

#[test]
fn what_is_installed_works_from_there_and_is_removed_again() {
    let place = tempfile::tempdir().unwrap();
    make("install", place.path());
    let prefix = place.path().join("opt/touchdown");
    let unit = fs::read_to_string(prefix.join("lib/systemd/system/touchdown@.service")).unwrap();
    assert!(
        unit.contains("\nExecStart=/opt/touchdown/bin/touchdown up "),
        "{unit}"
    );
    assert!(prefix.join("share/touchdown/types/task_t.lcm").is_file());

    // Three processes, with the scenario that is installed.
    let mut run = Command::new(prefix.join("bin/touchdown"));
    run.args([
        "run",
        "share/touchdown/scenarios/paper.toml",
        "--laws",
        "proposed",
        "--json",
        "--out",
        "out",
    ]);
    let output = run.current_dir(&prefix).env_remove("RUST_LOG").output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["rows"][0]["law"], "proposed");

    fs::remove_dir_all(prefix.join("out")).unwrap();
    make("uninstall", place.path());
    assert_eq!(files(place.path()), Vec::<PathBuf>::new());
}
