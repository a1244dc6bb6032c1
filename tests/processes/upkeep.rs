//! `touchdown bench nodes` and `touchdown bench growth`: that they measure, not what.

use serde_json::Value;
use tests::touchdown;

fn report(arguments: &str) -> Value {
    let output = touchdown().args(arguments.split(' ')).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Each row of `rows` has these keys with numbers above zero.
fn positive(rows: &Value, keys: &[&str]) -> usize {
    let rows = rows.as_array().unwrap();
    for (row, key) in rows.iter().flat_map(|row| keys.iter().map(move |key| (row, key))) {
        assert!(row[key].as_f64().unwrap() > 0.0, "{key}: {row}");
    }
    rows.len()
}

#[test]
fn the_programs_in_real_time_and_their_start_are_measured() {
    let report = report("bench nodes --json --repetitions 1 --seconds 0.3");
    let start = |key: &str| report["start_up"][key].as_f64().unwrap();
    assert!(0.0 < start("first_tick_s") && start("first_tick_s") < start("first_contact_s"));
    assert_eq!(positive(&report["rows"], &["core_share"]), 6);
    for (i, row) in report["rows"].as_array().unwrap().iter().enumerate() {
        assert_eq!(row["cycles_per_s"], [250.0, 1000.0][i / 3]);
        assert_eq!(row["program"], ["robot-sim", "sensor-sim", "controller"][i % 3]);
        assert!(
            row["minor_faults"].is_u64() && row["major_faults"].is_u64(),
            "{row}"
        );
    }
}

#[test]
fn growth_is_measured_and_drawn() {
    let directory = tempfile::tempdir().unwrap();
    let amount = "--turns 1 --cycles 5 --seconds 0.1 --cells 1,2 --logs 1,2 --set timing.duration_s=0.4";
    let out = directory.path().display();
    let report = report(&format!("bench growth --json {amount} --out {out}"));
    let rates = ["cycles_per_s", "core_share", "core_us_per_cycle"];
    assert_eq!(positive(&report["rates"], &rates), 5);
    let cells = ["cells", "ticks_per_s", "core_us_per_tick"];
    // Each number on ports of their own, and on one network.
    assert_eq!(positive(&report["cells"], &cells), 4);
    let logs = ["log_s", "log_mib", "analyse_core_s", "replay_core_s"];
    assert_eq!(positive(&report["logs"], &logs), 2);
    for name in ["rate", "cells", "log-time", "log-memory"] {
        assert!(
            directory.path().join(format!("growth-{name}.svg")).exists(),
            "{name}"
        );
    }
}
