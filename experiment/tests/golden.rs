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
    let pinned: [(&[&str], &str); 5] = [
        (&["controller.law=pd"], "df8a4006426a009664aef1782ba00441"),
        (&["controller.law=proposed"], "633b6ae69d18a880e3bfc67dae5e5760"),
        (&["controller.law=literal"], "0f9cf26989b07f2a90989dc851c14dbb"),
        (
            &["controller.law=pd", "controller.pairing=arrival"],
            "d0a638a59a78b6d07415d84b62ecc8ed",
        ),
        (
            &["robot.kinematics=arm", "robot.gears=elastic"],
            "71a09ecce44d28486334ad9f5f205d74",
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
