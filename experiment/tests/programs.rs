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
    /// The phase in which the fault came, if one did.
    failed_in: Option<ControllerPhase>,
    truths: Vec<Truth>,
}

fn run_until_end(name: &str, overrides: &[&str]) -> (Scenario, Run) {
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
        failed_in: (statuses.windows(2))
            .find(|pair| pair[1].fault != Fault::None)
            .map(|pair| pair[0].phase),
        truths,
    };
    (scenario, run)
}

/// Four screws, each 0.12 mm higher than the one before, are met, pressed with 15 N and left.
#[test]
fn a_row_of_screws_is_pressed() {
    let (_, run) = run_until_end("screws", &[]);
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
    let (scenario, run) = run_until_end("peg", &[]);
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

/// How each step of `kind` has ended.
fn ends(run: &Run, kind: &str) -> Vec<String> {
    let steps = run.results.iter().filter(|step| step.kind == kind);
    steps.map(|step| step.result.clone()).collect()
}

/// Each cause of a failure ends its step, is named, and leaves the workpiece out, or latches a fault.
#[test]
fn what_goes_wrong_ends_its_step_with_its_name() {
    let short = "timing.duration_s=4.0";
    let (_, run) = run_until_end("screws", &[short, "object.height_m=-0.02"]);
    assert_eq!(ends(&run, "approach")[0], "search", "{}", Steps(&run.results));
    // A band that no noise keeps to.
    let (_, run) = run_until_end(
        "screws",
        &["timing.duration_s=5.5", "controller.settled_band_n=1e-3"],
    );
    assert_eq!(ends(&run, "press")[0], "time", "{}", Steps(&run.results));
    // Less than what this law overshoots to: that stops the robot, whatever follows a failure.
    let limited = [short, "task.max_contact_force_n=17", "controller.law=pd"];
    let (_, run) = run_until_end("screws", &limited);
    assert_eq!(run.last.fault, Fault::ForceLimit, "{}", Steps(&run.results));
    // The plate is higher than the move leads: met with 50 mm/s, left with 30 N at most after the impact.
    let collides = [short, "object.height_m=0.018", "program.on_failure=fault"];
    let (_, run) = run_until_end("screws", &collides);
    assert_eq!(run.last.fault, Fault::Collision, "{}", Steps(&run.results));
    assert_eq!(ends(&run, "move"), ["collision"]);
    let force = run.truths[run.truths.len() - 500..]
        .iter()
        .map(|it| it.contact_force.z)
        .fold(0.0, f64::max);
    assert!(force < 60.0, "{force} N");
}

/// A sensor that falls silent is a fault in every phase, and the robot holds: what moves on is the tool's swing.
#[test]
fn a_silent_sensor_is_a_fault_in_every_phase_of_a_program() {
    use ControllerPhase::{Approach, Contact, Move, Retract, Settled};
    for (at_s, phase) in [
        (0.4, Move),
        (0.7, Approach),
        (0.9, Contact),
        (1.3, Settled),
        (1.6, Retract),
    ] {
        let start = format!("sensor.dropout_start_s={at_s}");
        let overrides = [&start, "sensor.dropout_duration_s=1.0", "timing.duration_s=3.2"];
        let (_, run) = run_until_end("screws", &overrides);
        assert_eq!(
            (run.failed_in, run.last.fault),
            (Some(phase), Fault::SensorStale),
            "{at_s} s"
        );
        let step = run.results.last().unwrap();
        assert!(
            step.result == "sensor stale" && step.start_s < at_s,
            "{phase:?}: {}",
            Steps(&run.results)
        );
        // Where the tcp is on average over 0.2 s, several swings.
        let mean = |from_s: f64| {
            let from = (1e3 * from_s) as usize;
            let points = run.truths[from..from + 200].iter();
            points
                .map(|truth| truth.tcp_pose.translation.vector)
                .sum::<nalgebra::Vector3<f64>>()
                / 200.0
        };
        let moved = (mean(at_s + 0.5) - mean(2.99)).norm();
        assert!(moved < 50e-6, "{phase:?}: {moved} m");
    }
}
