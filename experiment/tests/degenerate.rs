//! Physics at its edges: refused by name, or carried through to a named state. Others of the kind: a sensor that is silent,
//! late, at the end of its range or drops out, and a push (`injected.rs`); one that drifts (`adaptation.rs`); an object that
//! drops or is gone (`protection.rs`, `tasks.rs`); poses out of reach (`node/src/scenario/tests/conflicts.rs`).
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use experiment::in_process;
use experiment::scenarios::Source;
use spatial::ports::{ControllerPhase, ControllerStatus, Fault};

/// Why `overrides` of the scenario `name` are refused.
fn refusal(name: &str, overrides: &[&str]) -> String {
    let overrides: Vec<_> = overrides.iter().map(|&text| text.to_owned()).collect();
    Source::find(name)
        .unwrap()
        .scenario(&overrides)
        .unwrap_err()
        .to_string()
}

/// All statuses of the scenario `name` with `overrides`, and the largest contact force, N.
fn run(name: &str, overrides: &[&str]) -> (Vec<ControllerStatus>, f64) {
    let overrides: Vec<_> = overrides.iter().map(|&text| text.to_owned()).collect();
    let scenario = Source::find(name).unwrap().scenario(&overrides).unwrap();
    let (mut statuses, mut peak_n) = (Vec::new(), 0.0_f64);
    in_process::run(&scenario, |tick| {
        statuses.extend(tick.controller.map(|answer| answer.status));
        peak_n = peak_n.max(tick.sensor.truth.contact_force_peak_n);
    });
    (statuses, peak_n)
}

fn end(statuses: &[ControllerStatus]) -> (ControllerPhase, Fault) {
    statuses.last().map(|last| (last.phase, last.fault)).unwrap()
}

#[test]
fn nothing_weighs_nothing_and_yields_without_end() {
    for (key, limit) in [
        ("tool.mass_kg", "kg"),
        ("sensor.stiffness_n_per_m", "N/m"),
        ("sensor.stiffness_nm_per_rad", "Nm/rad"),
        ("controller.compliance_m_per_n", "m/N"),
    ] {
        let message = refusal("paper", &[&format!("{key}=0")]);
        let expected = format!("{key} is 0 {limit}, below the limit of ");
        assert!(message.contains(&expected), "{message}");
    }
    for key in [
        "robot.gantry.motor_inertia_kg_m2",
        "robot.gantry.link_inertia_kg_m2",
    ] {
        let message = refusal("paper", &[&format!("{key}=[0, 0, 0, 0, 0, 0]")]);
        assert!(
            message.contains(&format!("{key}[0] is 0 kg m^2, below the limit of ")),
            "{message}"
        );
    }
}

/// The arm stretched out: joints 4 and 6 turn about the same line.
#[test]
fn a_singular_pose_is_refused() {
    let message = refusal("arm", &["task.start_position_m=[0.9, 0, 0.03]"]);
    assert!(
        message.contains("task.start_position_m can't be reached: the pose is "),
        "{message}"
    );
}

#[test]
fn an_object_behind_the_tool_is_refused() {
    for height in ["0.05", "0.0301"] {
        let message = refusal("paper", &[&format!("object.height_m={height}")]);
        assert!(
            message.contains(&format!(
                "object.height_m is {height} m, not below the hanging tool's tcp"
            )),
            "{message}"
        );
    }
}

/// The tool hangs a micrometre above the object: it is touched in the approach's first ticks, or by the swing of the start.
#[test]
fn contact_at_the_start_is_contact() {
    let (statuses, peak_n) = run(
        "paper",
        &["task.start_position_m=[0, 0, 0.010131]", "object.height_m=0.0097"],
    );
    let (phase, fault) = end(&statuses);
    assert_eq!((phase, fault), (ControllerPhase::Settled, Fault::None));
    assert!(peak_n < 110.0, "{peak_n} N");
}

/// An object that yields by 100 mm under the force: it is followed down, and as long as the force is not there the phase says so.
#[test]
fn a_force_that_is_not_reached_is_no_settled_contact() {
    let yields = [
        "object.support_n_per_m=100",
        "object.support_ns_per_m=20",
        "timing.duration_s=6",
    ];
    let (statuses, peak_n) = run("soft", &yields);
    assert_eq!(end(&statuses), (ControllerPhase::Contact, Fault::None));
    assert!(peak_n < 10.0, "{peak_n} N");
}
