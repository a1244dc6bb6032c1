//! The integration steps are chosen by convergence: the sensor's side, on the same motion of the link, against much
//! finer steps. (In the closed loop a sample that flips by one quantum would hide what the steps do.)
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use experiment::in_process;
use experiment::metrics::{Metrics, Recording};
use experiment::scenarios::Source;
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

/// Steel on steel: the peak of the impact, about 9 kN, with steps of a quarter; and it is the paper's (17) with the
/// effective mass and the speed at contact.
#[test]
fn the_steps_of_the_car_body_resolve_its_impact() {
    let scenario = Source::find("car_body").unwrap().scenario(&[]).unwrap();
    let link = link_of(&scenario);
    let steps = [scenario.sensor.integration_step_s, scenario.sensor.smooth_step_s];
    let errors = differences(&scenario, &link, steps, steps.map(|step| 0.25 * step));
    println!("{steps:?} against a quarter: peak, IAE, impact {errors:?}");
    assert!(errors[0] < 1e-3 && errors[2] < 1e-3, "{errors:?}");

    let effective = 1.0 / (1.0 / 100.0 + 0.07 * 0.07 / 4.0);
    // The impact lasts a third of a tick, so that its peak is in the first or the second one.
    let mut sensor = SensorSim::new(&scenario, &link[0].motion);
    let truths = link.iter().map(|link| sensor.advance(link).truth);
    let impact: Vec<_> = truths
        .filter(|truth| truth.first_contact_time_s >= 0.0)
        .take(2)
        .collect();
    let speed = impact[0].first_contact_speed_m_per_s;
    let peak = impact[0].contact_force_peak_n.max(impact[1].contact_force_peak_n);
    let closed = speed * (2e9_f64 * effective).sqrt();
    println!("impact {peak} N at {speed} m/s, closed form {closed} N");
    assert!((peak / closed - 1.0).abs() < 0.02, "{peak} N against {closed} N");
}
