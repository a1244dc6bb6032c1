//! Every parameter can change in contact, and none of them with a bump.

use super::{Said, change, scenario};
use node::scenario::Scenario;
use rayon::prelude::*;
use spatial::ports::{ControllerPhase, Fault, ParameterAnswer, TaskParameters};

/// When a parameter changes: the contact has settled.
const TICK: i64 = 2000;

/// Another value of each parameter, in the order of their bits.
const OTHER: [f64; TaskParameters::COUNT] = [
    16.0, 0.1, 0.2, 0.1, 0.05, 0.002, 0.010, 1.5, 50.0, 80.0, 0.001, 0.5, 20.0, 0.3, 4e-6, 20e-6, 4e-6, 3e-3,
];

/// What the change of parameter `i` does in `scenario`, at most in a tick to the force (N), in a cycle to the set-points
/// (um or urad), and in the end to the force (N).
fn effect(scenario: &Scenario, i: usize) -> [f64; 3] {
    let (without, with) = (
        Said::of(scenario, &[]),
        Said::of(scenario, &[change(TICK, i, OTHER[i])]),
    );
    let (name, status) = (TaskParameters::NAMES[i], with.status_at(TICK));
    assert_eq!(
        (
            status.task_step,
            status.task_answer,
            status.task_parameter,
            status.task_limit
        ),
        (1, ParameterAnswer::Accepted, i as i32, OTHER[i]),
        "{name}"
    );
    let end = with.statuses.last().unwrap();
    let settled = end.phase == ControllerPhase::Settled;
    assert!(settled && end.fault == Fault::None, "{name}: {end:?}");
    let force: Vec<f64> = with
        .force_n
        .iter()
        .zip(&without.force_n)
        .map(|(a, b)| a - b)
        .collect();
    let of_force = force
        .windows(2)
        .map(|two| (two[1] - two[0]).abs())
        .fold(0.0, f64::max);
    let set_points: Vec<_> = with
        .set_points
        .iter()
        .zip(&without.set_points)
        .map(|(a, b)| a.1 - b.1)
        .collect();
    let of_set_points = set_points
        .windows(2)
        .map(|two| (two[1] - two[0]).amax())
        .fold(0.0, f64::max);
    [
        of_force,
        1e6 * of_set_points,
        force[force.len() - 200..].iter().sum::<f64>() / 200.0,
    ]
}

/// On a vertex, with laws that lead the robot and others: 6 N more, or a compliance 20 % off, come with less than 0.1 N
/// a tick, all else with less than 0.05 N.
#[test]
fn every_parameter_changes_in_contact_without_a_bump() {
    for law in ["proposed", "impedance", "pd", "literal"] {
        let law_ = format!("controller.law={law}");
        let scenario = scenario("paper", &[&law_, "timing.duration_s=3.0"]);
        // About no axis is a moment controlled here.
        let others: Vec<usize> = (0..TaskParameters::COUNT)
            .filter(|i| !(1..=3).contains(i))
            .collect();
        let effects: Vec<_> = others.par_iter().map(|&i| (i, effect(&scenario, i))).collect();
        for (i, [force, set_points, end]) in effects {
            let name = TaskParameters::NAMES[i];
            let told = format!("{law} {name}: {force} N a tick, {set_points} um a cycle, {end} N in the end");
            let most = if i == 0 { [0.1, 70.0] } else { [0.05, 25.0] };
            assert!(force < most[0] && set_points < most[1], "{told}");
            // What is asked for, and the force that a wrong compliance stands for; no other parameter changes it.
            let expected = match i {
                0 => 6.0,
                16 => 0.24,
                17 => 1.79,
                _ => 0.0,
            };
            assert!((end - expected).abs() < 0.06, "{told}");
        }
    }
}

/// The same of moments, on a face: its corners lift off and come down again on their own.
#[test]
fn moments_change_in_contact_without_a_bump() {
    let scenario = scenario(
        "face",
        &["timing.duration_s=3.0", "task.force_controlled.about_x=true"],
    );
    for i in [0, 1, 2] {
        let [force, set_points, end] = effect(&scenario, i);
        let name = TaskParameters::NAMES[i];
        assert!(
            force < 8.0 && set_points < 100.0,
            "{name}: {force} N a tick, {set_points} urad a cycle, {end} N"
        );
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
    assert!(
        (limit - (0.02618 * 401.07 + 0.03 * 39.2266) / 0.10).abs() < 0.01,
        "{limit} N"
    );
}
