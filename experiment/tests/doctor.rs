//! `touchdown doctor` as its users see it: who is on a URL, and what two hosts hear of each other.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod common;

use common::touchdown;
use experiment::run_port::RunPort;
use lcmtypes::LcmBuilder;
use serde_json::Value;
use spatial::ports::{Fault, Hello, NodeState, Role};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

fn port() -> RunPort {
    RunPort::free(Duration::ZERO).unwrap()
}

/// The object that `doctor --json` has printed.
fn report(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(&text)
        .unwrap_or_else(|error| panic!("{error}: {text}{}", String::from_utf8_lossy(&output.stderr)))
}

fn named<'a>(report: &'a Value, name: &str) -> &'a Value {
    let findings = report["findings"].as_array().unwrap();
    findings
        .iter()
        .find(|finding| finding["name"] == name)
        .unwrap_or_else(|| panic!("no {name} in {report}"))
}

/// Both hear each other without loss worth the name.
fn assert_heard(output: &Output) {
    let report = report(output);
    assert_eq!(output.status.code(), Some(0), "{report}");
    let peer = &report["peers"][0];
    let count = |key: &str| peer[key].as_u64().unwrap();
    assert!(count("answered") > 0 && count("heard") > 0, "{peer}");
    assert!(peer["round_trip_p50_s"].as_f64().unwrap() > 0.0, "{peer}");
}

#[test]
fn two_doctors_on_one_host_hear_each_other() {
    let port = port();
    let url = port.device_url();
    let start = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_touchdown"));
        command.args([
            "doctor",
            "--peer",
            "--json",
            "--wait-s",
            "60",
            "--measure-s",
            "1",
            "--url",
            &url,
        ]);
        command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let both = [start(), start()].map(|child| child.wait_with_output().unwrap());
    both.iter().for_each(assert_heard);
}

#[test]
fn a_doctor_alone_names_the_probable_causes() {
    let port = port();
    let (code, stdout, _) = touchdown(&format!("doctor --peer --wait-s 1 --url {}", port.device_url()));
    assert_eq!(code, 1, "{stdout}");
    for text in [
        "no other host heard",
        "ttl=0 keeps datagrams on one host",
        "IGMP snooping",
    ] {
        assert!(stdout.contains(text), "{stdout}");
    }
}

#[test]
fn who_is_on_a_url_is_told_and_a_fault_is_bad() {
    let port = port();
    let link = LcmBuilder::open(&port.device_url()).unwrap().start().unwrap();
    let hello = Hello {
        run_id: 7,
        ticks_per_cycle: 4,
        ..Hello::default()
    };
    let mut status = node::health::Health::new(Role::Controller, hello).status();
    (status.stamp.boot_id, status.state, status.fault) = (42, NodeState::Fault, Fault::SensorStale);
    let (done, ended) = crossbeam::channel::bounded::<()>(0);
    let node = std::thread::spawn(move || {
        while ended.recv_timeout(Duration::from_millis(20))
            == Err(crossbeam::channel::RecvTimeoutError::Timeout)
        {
            link.publish(&status).unwrap();
        }
    });
    let (code, stdout, stderr) = touchdown(&format!("doctor --json --url {}", port.device_url()));
    drop(done);
    node.join().unwrap();
    assert_eq!(code, 1, "{stdout}{stderr}");
    let report: Value = serde_json::from_str(&stdout).unwrap();
    let found = named(&report, "controller");
    assert_eq!(found["verdict"], "bad");
    let observed = found["observed"].as_str().unwrap();
    assert!(observed.contains(": fault, run 7: sensor stale;"), "{observed}");
    assert!(
        found["remedy"]
            .as_str()
            .unwrap()
            .starts_with("touchdown task reset --url")
    );
}

/// The example units are what systemd takes.
#[test]
fn the_units_are_valid() {
    let directory = tempfile::tempdir().unwrap();
    let units = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/systemd");
    for (unit, name) in [
        ("touchdown.service", "touchdown.service"),
        ("touchdown@.service", "touchdown@controller.service"),
    ] {
        let text = std::fs::read_to_string(format!("{units}/{unit}")).unwrap();
        let installed = "/usr/local/bin/touchdown";
        assert!(text.contains(installed));
        let file = directory.path().join(name);
        std::fs::write(&file, text.replace(installed, env!("CARGO_BIN_EXE_touchdown"))).unwrap();
        let verified = Command::new("systemd-analyze").arg("verify").arg(&file).output();
        let Ok(output) = verified else {
            eprintln!("SKIPPED: there is no systemd-analyze on this host");
            return;
        };
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && said.is_empty(), "{name}: {said}");
    }
}
