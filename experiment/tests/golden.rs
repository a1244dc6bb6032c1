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
        (&["controller.law=pd"], "84e6e7bcc1e575e721ad14e776b7aa1d"),
        (&["controller.law=proposed"], "9b61699aee9d94d1739d8ee9fccc09a6"),
        (&["controller.law=literal"], "a1c55aa57e3a2291195d348c29c29a83"),
        (
            &["controller.law=pd", "controller.pairing=arrival"],
            "b0c697d5e2a712ab5e5424f0970516ba",
        ),
        (
            &["robot.kinematics=arm", "robot.gears=elastic"],
            "b9d2ca5b8c17db75c86f68ff5b66c408",
        ),
        (
            &[
                "sensor.wrench_measured=true",
                "controller.adaptation.enabled=true",
                "controller.compliance_rad_per_nm=5e-3",
            ],
            "9c7547191099dd15499a5cd775461e76",
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
