//! `touchdown doctor --peer` on two hosts.

use serde_json::Value;
use spatial::ports::Role;
use std::process::{Output, Stdio};
use tests::hosts::on_hosts;
use tests::programs;

/// What `doctor --json` has printed, if it found nothing bad.
fn report(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_str(&text).unwrap()
}

#[test]
fn two_doctors_on_two_hosts_hear_each_other() {
    on_hosts("doctor::two_doctors_on_two_hosts_hear_each_other", |hosts| {
        let touchdown = programs().join("touchdown");
        let doctors = [Role::Robot, Role::Controller].map(|role| {
            let mut command = hosts.command(role, &touchdown);
            command
                .args(["doctor", "--peer", "--json", "--wait-s", "60", "--measure-s", "1"])
                .stdout(Stdio::piped())
                .stderr(Stdio::piped());
            command.spawn().unwrap()
        });
        for doctor in doctors {
            let report = report(&doctor.wait_with_output().unwrap());
            let peer = &report["peers"][0];
            let count = |key: &str| peer[key].as_u64().unwrap();
            assert!(count("answered") > 0 && count("heard") > 0, "{peer}");
            assert!(peer["round_trip_p50_s"].as_f64().unwrap() > 0.0, "{peer}");
            let findings = report["findings"].as_array().unwrap();
            let multicast = findings
                .iter()
                .find(|finding| finding["name"] == "multicast")
                .unwrap();
            let observed = multicast["observed"].as_str().unwrap();
            assert!(
                observed.contains("through eth0 (the route for 224.0.0.0/4); with ttl=1"),
                "{observed}"
            );
        }
    });
}
