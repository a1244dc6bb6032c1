//! The two example programs, in process: every step does what it is to do.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use experiment::in_process;
use experiment::program::{StepResult, Steps, results, succeeded};
use experiment::scenarios::Source;
use node::scenario::Scenario;
use spatial::ports::{ControllerPhase, ControllerStatus, Fault, Truth};

struct Run {
    results: Vec<StepResult>,
    last: ControllerStatus,
    truths: Vec<Truth>,
}

fn run(name: &str, overrides: &[&str]) -> (Scenario, Run) {
    let overrides: Vec<_> = overrides.iter().map(|&text| text.to_owned()).collect();
    let scenario = Source::find(name).unwrap().scenario(&overrides).unwrap();
    let (mut statuses, mut truths) = (Vec::new(), Vec::new());
    in_process::run(&scenario, |tick| {
        statuses.extend(tick.controller.as_ref().map(|outputs| outputs.status));
        truths.push(tick.sensor.truth);
    });
    let run = Run {
        results: results(&scenario, statuses.iter().copied()),
        last: statuses[statuses.len() - 1],
        truths,
    };
    (scenario, run)
}

/// Four screws, each 0.12 mm higher than the one before, are met, pressed with 15 N and left.
#[test]
fn a_row_of_screws_is_pressed() {
    let (_, run) = run("screws", &[]);
    assert!(succeeded(&run.results), "{}", Steps(&run.results));
    assert_eq!(run.results.len(), 16);
    assert_eq!(
        (run.last.phase, run.last.fault),
        (ControllerPhase::Ready, Fault::None)
    );
    for (k, press) in run.results.iter().filter(|step| step.kind == "press").enumerate() {
        assert_eq!(press.workpiece, k);
        assert!((press.end_force_n - 15.0).abs() < 0.3, "{press:?}");
        let [x, _, z] = press.end_position_m;
        assert!((x - 0.03 * k as f64).abs() < 0.5e-3, "{press:?}");
        assert!((z - 0.010 - 0.004 * x).abs() < 20e-6, "{press:?}");
    }
}

/// The hole is 2.2 mm beside; the peg ends 15 mm deep in it and comes out again.
#[test]
fn a_peg_is_searched_for_and_inserted() {
    let (scenario, run) = run("peg", &[]);
    assert!(succeeded(&run.results), "{}", Steps(&run.results));
    let deepest = run
        .truths
        .iter()
        .min_by(|a, b| a.tcp_pose.translation.z.total_cmp(&b.tcp_pose.translation.z));
    let deepest = deepest.unwrap().tcp_pose.translation.vector;
    assert!((deepest.z + 0.015).abs() < 0.1e-3, "{deepest}");
    let [x, y] = scenario.object.origin_m;
    assert!(
        (deepest.x - x).abs() < 0.1e-3 && (deepest.y - y).abs() < 0.1e-3,
        "{deepest}"
    );
    assert!(run.last.tcp_pose.translation.z > 0.004);
}
