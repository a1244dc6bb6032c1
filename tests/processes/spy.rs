//! `touchdown spy`: lcm-spy's own database knows every type.

use std::env;
use std::process::Command;
use tests::touchdown;

#[test]
fn lcm_spy_decodes_every_channel() {
    let there = |program| {
        Command::new(program)
            .arg("-version")
            .output()
            .is_ok_and(|it| it.status.success())
    };
    if !(there("javac") && there("java")) {
        assert!(env::var_os("CI").is_none(), "no Java is there");
        eprintln!("skipped: no Java is there; `./setup.sh test` installs it");
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let mut command = touchdown();
    command
        .args(["spy", "--check", "--json", "--out"])
        .arg(directory.path());
    let output = command.output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let types = report["types"].as_array().unwrap();
    assert_eq!(types.len(), lcmtypes::CHANNELS.len());
    for (found, channel) in types.iter().zip(lcmtypes::CHANNELS) {
        assert_eq!(found["channel"], *channel);
        assert!(
            found["class"].as_str().unwrap().starts_with("touchdown."),
            "{found}"
        );
    }
    assert!(directory.path().join("touchdown-types.jar").is_file());
}

#[test]
fn what_is_missing_is_named_with_its_remedy() {
    let directory = tempfile::tempdir().unwrap();
    let mut command = touchdown();
    command
        .args(["spy", "--check", "--out"])
        .arg(directory.path())
        .env("PATH", "");
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains(" is missing; sudo apt-get install "), "{said}");
}
