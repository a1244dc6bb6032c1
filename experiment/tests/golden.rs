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
        (&["controller.law=pd"], "1d598d61d8dd87e6e14e8a5b1541193f"),
        (&["controller.law=proposed"], "24c0302d86d0f82fad3b8608d83be671"),
        (&["controller.law=literal"], "154fb794dc31eab2e52b37c53c68f7ba"),
        (
            &["controller.law=pd", "controller.pairing=arrival"],
            "69be185a21e24830767e159738a5f192",
        ),
        (
            &["robot.kinematics=arm", "robot.gears=elastic"],
            "3b83bed24d324448fe9ef2bf323f7f7e",
        ),
        (
            &[
                "sensor.wrench_measured=true",
                "controller.adaptation.enabled=true",
                "controller.compliance_rad_per_nm=5e-3",
            ],
            "bc96e0c9d89db38c86498428ecafb9ca",
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
