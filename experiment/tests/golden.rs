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
        (&["controller.law=pd"], "d7ebb8c02a425c10f1e4ae452df4711b"),
        (&["controller.law=proposed"], "21b72aeab90420689a031f0ec362a3e9"),
        (&["controller.law=literal"], "994866653da06180d3c339dd69f5f4dd"),
        (
            &["controller.law=pd", "controller.pairing=arrival"],
            "fc941583b3216df6a4f02a85487fef18",
        ),
        (
            &["robot.kinematics=arm", "robot.gears=elastic"],
            "5253872617936a3122c2d7b19ccc364e",
        ),
        (
            &[
                "sensor.wrench_measured=true",
                "controller.adaptation.enabled=true",
                "controller.compliance_rad_per_nm=5e-3",
            ],
            "e6b848c4301458a790625179f25e0f29",
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
