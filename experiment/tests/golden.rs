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
        (&["controller.law=pd"], "0db2d9a2e27d4c5ae4efde26d98b99f6"),
        (&["controller.law=proposed"], "87a9c95941543654d65958a47fb24f76"),
        (&["controller.law=literal"], "d3eb95be8f8a27c05c66b8f86ac421a5"),
        (
            &["controller.law=pd", "controller.pairing=arrival"],
            "9f921e2ba27790b3c23f13e8305659e9",
        ),
        (
            &["robot.kinematics=arm", "robot.gears=elastic"],
            "b56b18066358246b2c833d96f0255b13",
        ),
        (
            &[
                "sensor.wrench_measured=true",
                "controller.adaptation.enabled=true",
                "controller.compliance_rad_per_nm=5e-3",
            ],
            "a37249e6ed341167f761cb058b0466e3",
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
