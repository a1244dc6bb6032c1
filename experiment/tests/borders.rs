//! Where the loop becomes unstable, against PLANT.md section 7: a plant that hides it would be wrong.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use experiment::in_process;
use experiment::metrics::Recording;
use experiment::scenarios::Source;

/// Root mean square of the force error (N) between 0.3 and 0.6 s after contact, and between 1.2 and 1.5 s.
fn error(overrides: &[&str]) -> (f64, f64) {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    let scenario = Source::find("paper").unwrap().scenario(&overrides).unwrap();
    let mut recording = Recording::new(&scenario);
    in_process::run(&scenario, |tick| recording.observe(tick));
    let curve = recording.force_curve().unwrap();
    let rms = |from: f64, to: f64| {
        let inside = curve
            .time_s
            .iter()
            .zip(&curve.force_n)
            .filter(|(t, _)| (from..to).contains(*t));
        let squares: Vec<f64> = inside
            .map(|(_, f)| (f - scenario.task.desired_force_n) * (f - scenario.task.desired_force_n))
            .collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    (rms(0.3, 0.6), rms(1.2, 1.5))
}

fn assert_stable(overrides: &[&str]) {
    let (early, late) = error(overrides);
    assert!(
        late < 0.2 || late < 0.5 * early,
        "{overrides:?}: {early} N early, {late} N late"
    );
}

fn assert_unstable(overrides: &[&str]) {
    let (early, late) = error(overrides);
    assert!(late > 3.0, "{overrides:?}: {early} N early, {late} N late");
}

/// Misaligned by the sensor's delay, eq. (2) becomes unstable at about 32 ms; aligned, the delay does not matter.
#[test]
fn pairing_by_arrival_destabilises_a_late_sensor() {
    let literal = "controller.law=literal";
    let arrival = "controller.pairing=arrival";
    assert_stable(&[literal, arrival, "sensor.delay_ticks=16"]);
    assert_unstable(&[literal, arrival, "sensor.delay_ticks=36"]);
    assert_stable(&[literal, "sensor.delay_ticks=36"]);
}
