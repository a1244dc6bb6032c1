//! The bits of a run, pinned: the same in debug and release, on every x86-64 CPU (`make bits`), today and tomorrow.

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
        (&["controller.law=pd"], "64ba81c511414a6917449b4e2ada4c27"),
        (&["controller.law=proposed"], "050c38996f5e6d542cdce777181fd794"),
        (&["controller.law=literal"], "950fbd0cf69631d92c1a6d1bd21f735a"),
        (
            &["controller.law=pd", "controller.pairing=arrival"],
            "209a86db37c61b170424a04488eaaaee",
        ),
        (
            &["robot.kinematics=arm", "robot.gears=elastic"],
            "21382736b2448972b142ce641834d395",
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
