//! A single step of the command against PLANT.md section 5.

use super::*;

/// Of a small step at tick 0 (the filter stays within its limits): the encoder of axis z at each tick, per step.
fn answer(ticks: usize) -> Vec<f64> {
    let mut robot = RobotSim::new(&scenario());
    let start = robot.state().axis_position[0];
    let far = 0.1e-3;
    (0..ticks)
        .map(|_| {
            let due = robot
                .command_due()
                .then(|| command(&robot, |_| start + Axes::ith(2, far)));
            let z = (robot.state().axis_position[0].z - start.z) / far;
            robot.advance(&tool(&robot), due.as_ref());
            z
        })
        .collect()
}

/// The step of a second order of `w` rad/s and damping 0.80, `time` s after its start.
fn second_order(w: f64, time: f64) -> f64 {
    let (zeta, time) = (0.8, time.max(0.0));
    let damped = w * (1.0f64 - zeta * zeta).sqrt();
    let (sine, cosine) = libm::sincos(damped * time);
    1.0 - libm::exp(-zeta * w * time) * (cosine + zeta * w / damped * sine)
}

/// The dead time with which a second order fits best: 8 ms until the command acts (n_d T), 2 ms for the line to the
/// set-point over T, 0.3 ms for the servo.
#[test]
fn a_single_step_sees_a_dead_time_of_10_3_ms() {
    let found = answer(200);
    let error = |(w, dead_time): (f64, f64)| -> f64 {
        let errors = found.iter().enumerate();
        errors
            .map(|(tick, z)| z - second_order(w, tick as f64 * TICK_S - dead_time))
            .map(|e| e * e)
            .sum()
    };
    let candidates =
        (180..220).flat_map(|w| (180..250).map(move |t| (0.5 * f64::from(w), 0.05e-3 * f64::from(t))));
    let best = candidates.min_by(|a, b| error(*a).total_cmp(&error(*b))).unwrap();
    assert!((best.1 - 10.3e-3).abs() < 0.11e-3, "{best:?}");
    assert!((93.0..98.0).contains(&best.0), "{best:?}");
    assert!(error(best) < 2e-4, "{}", error(best));
    assert!(
        found[..=8].iter().all(|z| *z == 0.0) && found[10] > 0.0,
        "{found:?}"
    );
}
