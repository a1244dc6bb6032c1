//! Every parameter can change in contact, and none of them with a bump.

use super::{Said, change, scenario};
use rayon::prelude::*;
use spatial::ports::{ControllerPhase, Fault, ParameterAnswer, TaskParameters};

/// When a parameter changes: the contact has settled.
const TICK: i64 = 2000;

/// Another value of each parameter, in the order of their bits, for the scenario `face`, where moments are controlled.
const OTHER: [f64; TaskParameters::COUNT] = [
    16.0, 0.1, 0.2, 0.0, 0.05, 0.002, 0.010, 1.5, 50.0, 80.0, 0.001, 0.5, 20.0, 0.3, 4e-6, 20e-6, 4e-6, 3e-3,
];

/// With `law`, the largest step per tick of what the change of parameter `i` does to the force (N) and to the set-points
/// (rad), and what it does to the force in the end (N).
fn effect(law: &str, i: usize) -> [f64; 3] {
    let law = format!("controller.law={law}");
    let scenario = scenario("face", &[&law, "timing.duration_s=3.0", "task.force_controlled.about_x=true"]);
    let (without, with) = (Said::of(&scenario, &[]), Said::of(&scenario, &[change(TICK, i, OTHER[i])]));
    let status = with.status_at(TICK);
    assert_eq!(
        (status.task_step, status.task_answer, status.task_parameter, status.task_limit),
        (1, ParameterAnswer::Accepted, i as i32, OTHER[i]),
        "{}",
        TaskParameters::NAMES[i]
    );
    let end = with.statuses.last().unwrap();
    let pressing = matches!(end.phase, ControllerPhase::Contact | ControllerPhase::Settled);
    assert!(pressing && end.fault == Fault::None, "{}: {end:?}", TaskParameters::NAMES[i]);
    let force: Vec<f64> = with.force_n.iter().zip(&without.force_n).map(|(a, b)| a - b).collect();
    let of_force = force.windows(2).map(|two| (two[1] - two[0]).abs()).fold(0.0, f64::max);
    let set_points: Vec<_> =
        with.set_points.iter().zip(&without.set_points).map(|(a, b)| a.1 - b.1).collect();
    let of_set_points = set_points.windows(2).map(|two| (two[1] - two[0]).amax()).fold(0.0, f64::max);
    [of_force, of_set_points, force[force.len() - 200..].iter().sum::<f64>() / 200.0]
}

#[test]
fn every_parameter_changes_in_contact_without_a_bump() {
    for law in ["proposed", "pd"] {
        let effects: Vec<_> = (0..TaskParameters::COUNT).into_par_iter().map(|i| effect(law, i)).collect();
        for (i, [force, set_points, end]) in effects.into_iter().enumerate() {
            let name = TaskParameters::NAMES[i];
            println!("{law} {name}: {force:.4} N, {:.2} urad per cycle, in the end {end:.3} N", set_points * 1e6);
        }
    }
}

/// Refused with the limit that was left: of the key, or of what the values are together.
#[test]
fn what_the_scenario_would_refuse_is_refused_with_its_limit() {
    let scenario = scenario("paper", &["timing.duration_s=2.1"]);
    let refused = |i: usize, value: f64| {
        let said = Said::of(&scenario, &[change(TICK, i, value)]);
        let status = *said.status_at(TICK);
        assert_eq!(status.task_step, 1);
        (status.task_answer, status.task_parameter, status.task_limit)
    };
    use ParameterAnswer::OutOfRange;
    // Of the key.
    assert_eq!(refused(0, 0.01), (OutOfRange, 0, 0.1));
    assert_eq!(refused(10, 2.0), (OutOfRange, 10, 1.0));
    // About y nothing is force controlled.
    assert_eq!(refused(2, 0.5), (OutOfRange, 2, 0.0));
    // The sensor turns by 26.18 mrad: 0.10 m times the force, less the weight's moment, over 401.07 Nm/rad.
    let (answer, parameter, limit) = refused(0, 200.0);
    assert_eq!((answer, parameter), (OutOfRange, 0));
    assert!((limit - (0.02618 * 401.07 + 0.03 * 39.2266) / 0.10).abs() < 0.01, "{limit} N");
}
