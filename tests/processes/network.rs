//! `touchdown bench network`: that it measures, not what.

use serde_json::Value;
use tests::touchdown;

#[test]
fn the_programs_and_bare_processes_are_measured_in_turns() {
    let arguments = "bench network --json --repetitions 1 --seconds 0.1 --turns 1 --cycles 5";
    let output = touchdown()
        .args(arguments.split(' '))
        .args(["--set", "timing.duration_s=0.4"])
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    for key in [
        "lockstep_ratio",
        "lockstep_ticks_per_s",
        "bare_ticks_per_s",
        "in_process_ticks_per_s",
        "start_up_s",
        "controller_us_per_cycle",
        "loop_p50_ratio",
        "loop_p999_ratio",
        "loop_1000_hz_p50_ratio",
        "loop_1000_hz_p999_ratio",
        "loop_back_to_back_p50_ratio",
        "loop_back_to_back_p999_ratio",
    ] {
        assert!(report[key].as_f64().unwrap() > 0.0, "{key}: {report}");
    }
    for row in report["signatures"].as_array().unwrap() {
        let [bytes, sign_ns, check_ns] = ["bytes", "sign_ns", "check_ns"].map(|key| row[key].as_f64());
        assert!(
            bytes > Some(200.0) && sign_ns > Some(0.0) && check_ns > Some(0.0),
            "{row}"
        );
    }
    let loops = report["loops"].as_array().unwrap();
    for pace in ["250 Hz", "1000 Hz", "back to back"] {
        for receive in ["raw", "controller"] {
            let row = loops
                .iter()
                .find(|row| row["pace"] == pace && row["receive"] == receive)
                .unwrap();
            let number = |key: &str| row[key].as_f64().unwrap();
            assert_eq!(number("cycles") + number("lost"), 5.0, "{row}");
            assert!(
                0.0 < number("p50_us") && number("p50_us") <= number("p999_us"),
                "{row}"
            );
            assert_eq!(receive == "raw", number("p50_ratio") == 1.0, "{row}");
        }
    }
}

#[test]
fn what_would_not_be_lockstep_is_refused() {
    let output = touchdown()
        .args(["bench", "network", "--set", "timing.mode=realtime"])
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("leave it at lockstep"), "{stderr}");
}
