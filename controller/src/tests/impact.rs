//! The assessment of the impact in the running controller, and the approach that it slows.

use super::*;

/// Status and height of the commanded tcp, cycle by cycle, of an approach that meets the object (which yields to
/// nothing) 20 mm below the start, on a robot that is where it was sent.
fn approach(scenario: &Scenario) -> Vec<(ControllerStatus, f64)> {
    let mut controller = Controller::new(scenario);
    let mut axes = scenario.start_axes().unwrap();
    let object = axes.z - 0.020;
    let mut before = axes;
    (0..=3000)
        .step_by(4)
        .map(|tick| {
            let shown = |sampled: i64| {
                let share = (sampled - (tick - 4)) as f64 / 4.0;
                lifted((object - (before.z + (axes.z - before.z) * share)).max(0.0))
            };
            let outputs = controller.cycle(&Heard::complete(
                &state(tick, axes),
                &sensed(tick, 0, shown),
                None,
            ));
            before = axes;
            axes = outputs.command.axis_position[0];
            (outputs.status, axes.z)
        })
        .collect()
}

/// 107.264 N at 20 mm/s (PLANT.md section 5), told all along the cruise and kept after the contact.
#[test]
fn the_impact_is_told_in_every_cycle_and_kept_after_the_contact() {
    let statuses = approach(&weightless());
    let (first, _) = &statuses[0];
    assert_eq!(first.impact, Default::default());
    let contact = statuses
        .iter()
        .position(|(status, _)| status.detection.contact_step >= 0)
        .unwrap();
    let cruise = &statuses[contact - 50..contact];
    for (status, _) in cruise {
        let impact = &status.impact;
        assert!((impact.speed_m_per_s - 0.020).abs() < 1e-4, "{impact:?}");
        assert!((impact.effective_mass_kg - 1.798).abs() < 0.001, "{impact:?}");
        assert!((impact.peak_force_n / 107.264 - 1.0).abs() < 0.005, "{impact:?}");
        assert_eq!((impact.speed_limit_m_per_s, status.limits & 2), (0.0, 0));
    }
    let kept = statuses[contact].0.impact;
    assert!((kept.peak_force_n / 107.264 - 1.0).abs() < 0.005, "{kept:?}");
    assert!(
        statuses[contact..]
            .iter()
            .all(|(status, _)| status.impact == kept)
    );
}

/// 26.816 N are a quarter of that: 5 mm/s, said with bit 2 as long as the approach lasts.
#[test]
fn the_approach_is_slowed_to_the_allowed_force() {
    let mut scenario = weightless();
    scenario.task.max_impact_force_n = 26.816;
    let statuses = approach(&scenario);
    let approaching = statuses
        .iter()
        .filter(|(status, _)| status.phase == ControllerPhase::Approach);
    assert!(approaching.clone().count() > 500);
    for (status, _) in approaching {
        assert_eq!(status.limits & 2, 2);
        assert!((status.impact.speed_limit_m_per_s - 0.005).abs() < 1e-6);
    }
    let fastest = statuses
        .windows(2)
        .map(|pair| (pair[0].1 - pair[1].1) / 4e-3)
        .fold(0.0, f64::max);
    // Set-points that are fed forward overshoot a little at the end of the ramp.
    assert!((0.00499..0.00530).contains(&fastest), "{fastest} m/s");
    // What is slow enough is left alone.
    scenario.task.approach_speed_m_per_s = 0.004;
    assert!(
        approach(&scenario)
            .iter()
            .all(|(status, _)| status.limits & 2 == 0)
    );
}
