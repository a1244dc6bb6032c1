//! The bits of a run, pinned: the same in debug and release, and on other CPUs (`make bits` emulates two).

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use experiment::transcript;
use node::scenario::Scenario;
use sha2::{Digest, Sha256};
use std::fmt::Write;

fn hash(overrides: &[&str]) -> String {
    let text = experiment::scenarios::Source::find("paper").unwrap().text;
    let mut overrides: Vec<_> = overrides.iter().map(|&text| text.to_owned()).collect();
    overrides.push("timing.duration_s=2.0".to_owned());
    let scenario = Scenario::parse("paper", &text, &overrides).unwrap();
    let mut hasher = Sha256::new();
    for entry in transcript::in_process(&scenario).unwrap() {
        hasher.update(entry.utime.to_be_bytes());
        hasher.update(entry.channel.as_bytes());
        hasher.update(&entry.bytes);
    }
    hasher
        .finalize()
        .iter()
        .take(16)
        .fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
}

/// Every channel of the paper's experiment, NODE_STATUS excepted. A change of a message type, of the physics or of
/// a law changes these: say in the commit why.
#[test]
fn the_papers_experiment() {
    let pinned: [(&[&str], &str); 6] = [
        (&["controller.law=pd"], "7995ff17a245856b696c22fc2d00517f"),
        (&["controller.law=proposed"], "a6c9c444f37604eb4f0c0696c6d34cc6"),
        (&["controller.law=literal"], "861029a734b419c723b14e76a315a99e"),
        (
            &["controller.law=pd", "controller.pairing=arrival"],
            "832a6de18af388a00b30c1a52d282a71",
        ),
        (
            &["robot.kinematics=arm", "robot.gears=elastic"],
            "eaffffb06f56e80666237bee7780e081",
        ),
        (
            &[
                "sensor.wrench_measured=true",
                "controller.adaptation.enabled=true",
                "controller.compliance_rad_per_nm=5e-3",
            ],
            "e4df0e6850f2919f0f338f3bbea867e2",
        ),
    ];
    let found = pinned.map(|(overrides, _)| (overrides, hash(overrides)));
    let lines: String = found.iter().map(|pair| format!("{pair:?},\n")).collect();
    assert!(
        found
            .iter()
            .zip(pinned)
            .all(|(found, pinned)| found.1 == pinned.1),
        "found:\n{lines}"
    );
}
