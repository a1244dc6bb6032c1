//! The integration steps are chosen by convergence: the sensor's side, on the same motion of the link, against much
//! finer steps. (In the closed loop a sample that flips by one quantum would hide what the steps do.)
#![allow(clippy::unwrap_used, reason = "tests")]

use experiment::in_process;
use experiment::metrics::{Metrics, Recording};
use node::scenario::Scenario;
use sensor_sim::SensorSim;
use spatial::ports::LinkMotion;

/// The figures of `scenario` with other steps (integration, smooth; s) on the motion of `link`, and the largest
/// contact force (N).
fn with_steps(scenario: &Scenario, link: &[LinkMotion], steps: [f64; 2]) -> (Metrics, f64) {
    let mut scenario = scenario.clone();
    [scenario.sensor.integration_step_s, scenario.sensor.smooth_step_s] = steps;
    let mut sensor = SensorSim::new(&scenario, &link[0].motion);
    let mut recording = Recording::new(&scenario);
    let mut peak = 0.0_f64;
    for link in link {
        let truth = sensor.advance(link).truth;
        peak = peak.max(truth.contact_force_peak_n);
        recording.push(&truth);
    }
    (recording.metrics().unwrap(), peak)
}

fn link_of(scenario: &Scenario) -> Vec<LinkMotion> {
    let mut link = Vec::new();
    in_process::run(scenario, |tick| link.push(tick.link_motion));
    link
}

/// Relative differences of peak and IAE of the force, and of the impact's peak.
fn differences(scenario: &Scenario, link: &[LinkMotion], steps: [f64; 2], finer: [f64; 2]) -> [f64; 3] {
    let (found, impact) = with_steps(scenario, link, steps);
    let (exact, exact_impact) = with_steps(scenario, link, finer);
    [
        (found.peak_n / exact.peak_n - 1.0).abs(),
        (found.iae_n_s / exact.iae_n_s - 1.0).abs(),
        (impact / exact_impact - 1.0).abs(),
    ]
}

#[test]
fn the_steps_of_the_paper_err_by_less_than_a_thousandth() {
    let scenario = Scenario::default();
    let link = link_of(&scenario);
    let steps = [scenario.sensor.integration_step_s, scenario.sensor.smooth_step_s];
    for finer in [[2e-5, 2e-5], [2e-6, 2e-6]] {
        let errors = differences(&scenario, &link, steps, finer);
        println!("{steps:?} against {finer:?}: peak, IAE, impact {errors:?}");
        assert!(errors.iter().all(|error| *error < 1e-3), "{errors:?}");
    }
}
