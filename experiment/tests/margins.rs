//! The loop's margins as the controller publishes them: by what it assumes, after the tare and after each request.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use controller::margins::Assessment;
use experiment::scenarios::Source;
use experiment::{in_process, linear};
use node::scenario::Scenario;
use spatial::ports::{ControllerPhase, ControllerStatus, Stamp, Task, TaskParameters};

/// Bits of parameters that can be changed.
const PD_PROPORTIONAL: usize = 14;
const COMPLIANCE: usize = 16;
const APPROACH_SPEED: usize = 4;

/// The inertia of the arm's links in its working posture, as `elastic_arm` assumes it.
const ARM_LINKS: [&str; 2] = [
    "controller.servo.link_inertia_kg_m2=[51.96, 53.79, 24.70, 1.179, 1.143, 0.5]",
    "controller.gears.link_coupling_kg_m2=[0, 0, 0.312, 0, -0.5, 15.706, 0, 0.867, 0, 0, 1.356, 0, 0, 0.197, 0]",
];

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let mut overrides: Vec<_> = overrides.iter().map(|&text| text.to_owned()).collect();
    overrides.push("timing.duration_s=0.4".to_owned());
    Source::find(name).unwrap().scenario(&overrides).unwrap()
}

fn statuses(scenario: &Scenario, tasks: &[Task]) -> Vec<ControllerStatus> {
    let mut statuses = Vec::new();
    in_process::run_with(scenario, tasks, |tick| {
        statuses.extend(tick.controller.map(|outputs| outputs.status));
    });
    statuses
}

/// What is published in the end.
fn published(name: &str, overrides: &[&str]) -> Assessment {
    Assessment::of(statuses(&scenario(name, overrides), &[]).last().unwrap())
}

/// The request for another value of each of these parameters from `tick` on.
fn change(tick: i64, changes: &[(usize, f64)]) -> Task {
    let mut values = [None; TaskParameters::COUNT];
    for (i, value) in changes {
        values[*i] = Some(*value);
    }
    Task {
        stamp: Stamp {
            step: 1,
            utime: tick * spatial::TICK_US,
            boot_id: 1,
        },
        parameters: TaskParameters::from_values(values),
        ..Task::default()
    }
}

fn near(found: f64, expected: f64, share: f64) -> bool {
    (found / expected - 1.0).abs() < share
}

/// Where what is assumed is what is, linear theory of what is and what is published are the same, on gantry and arm, with
/// rigid and elastic gears. (The sensor is assumed to be damped as the modes are.)
#[test]
fn they_are_those_of_linear_theory_where_what_is_assumed_is_true() {
    for name in ["paper", "arm", "elastic", "elastic_arm"] {
        for law in ["pd", "literal", "proposed", "impedance", "ros2", "fzi", "elastic"] {
            let law_key = format!("controller.law={law}");
            let mut overrides = vec![law_key.as_str()];
            if law == "elastic" && !name.starts_with("elastic") {
                // It assumes elastic gears anyway.
                continue;
            }
            if name == "arm" {
                overrides.extend(ARM_LINKS);
            }
            let found = published(name, &overrides);
            let theory =
                Assessment::new(found.law, &linear::closed(&scenario(name, &overrides)).unwrap()).unwrap();
            assert!(
                near(found.gain_margin, theory.gain_margin, 0.03)
                    && near(found.phase_margin_rad, theory.phase_margin_rad, 0.03),
                "{name}: {found:?}, not {theory:?}"
            );
        }
    }
}

/// Nothing is published before the delay is measured; from then on the same until something changes.
#[test]
fn they_are_published_before_the_start_and_stay() {
    let statuses = statuses(&scenario("paper", &[]), &[]);
    let (before, after): (Vec<_>, Vec<_>) = statuses
        .iter()
        .partition(|status| status.phase == ControllerPhase::Sync || status.phase == ControllerPhase::Init);
    assert!(before.iter().all(|status| !Assessment::of(status).known()));
    let known: Vec<_> = after.iter().skip(1).map(Assessment::of).collect();
    assert_eq!(after[1].phase, ControllerPhase::Ready);
    assert!(known[0].known() && known.iter().all(|it| *it == known[0]));
}

/// Half the force for the same deflection: a pd has twice as much to spare. The object of `proposed` is where it is,
/// whatever the compliance. What is assumed decides, not what is.
#[test]
fn an_assumed_compliance_changes_them_as_theory_says() {
    let doubled = [
        "controller.compliance_m_per_n=6.6666666666e-6",
        "controller.compliance_rad_per_nm=4.9866606e-3",
    ];
    for (law, ratio) in [("pd", 2.0), ("proposed", 1.0)] {
        let law_key = format!("controller.law={law}");
        let right = published("paper", &[&law_key]).gain_margin;
        let wrong = [&law_key, doubled[0], doubled[1]];
        let found = published("paper", &wrong).gain_margin;
        let theory = linear::closed(&scenario("paper", &wrong))
            .unwrap()
            .margins()
            .gain_margin;
        assert!(near(found / right, ratio, 0.05), "{law}: {right}, {found}");
        assert!(near(found, theory, 0.05), "{law}: {found}, {theory}");
    }
    let real = "sensor.stiffness_n_per_m=200e3";
    assert_eq!(published("paper", &[real]), published("paper", &[]));
}

/// The delay is the one that is measured.
#[test]
fn a_late_sensor_costs_margin() {
    let at = |ticks: i64| {
        let delay = format!("sensor.delay_ticks={ticks}");
        published("paper", &["controller.law=pd", &delay])
    };
    let [early, late] = [at(0), at(32)];
    assert!(early.gain_margin > 2.7 && early.concern().is_none(), "{early:?}");
    let concern = late.concern().unwrap();
    assert!(
        (1.0..1.5).contains(&late.gain_margin)
            && concern.contains("gain margin is 1.")
            && concern.contains("less than 2 ")
            && concern.contains("lower controller.pd.proportional_m_per_n"),
        "{late:?}: {concern}"
    );
}

/// From the cycle after the one that accepts it; before, the old margins are published still.
#[test]
fn a_request_that_raises_the_gain_is_answered_by_smaller_margins() {
    let pd = scenario("paper", &["controller.law=pd"]);
    let said = statuses(&pd, &[change(240, &[(PD_PROPORTIONAL, 8.1e-6)])]);
    let at = |tick: i64| Assessment::of(said.iter().find(|it| it.stamp.step == tick).unwrap());
    let (before, after) = (at(240), at(244));
    assert!(
        before.concern().is_none() && before.gain_margin > 2.0,
        "{before:?}"
    );
    assert!(
        after.gain_margin < 1.0 && after.phase_margin_rad < 0.0,
        "{after:?}"
    );
    assert!(after.concern().unwrap().contains("unstable"));

    let compliance = [(COMPLIANCE, 1e-5), (COMPLIANCE + 1, 7.48e-3)];
    let said = statuses(&pd, &[change(240, &compliance)]);
    let after = Assessment::of(said.last().unwrap());
    assert!(
        near(after.gain_margin, 3.0 * before.gain_margin, 0.1),
        "{after:?}"
    );

    let said = statuses(&pd, &[change(240, &[(APPROACH_SPEED, 0.01)])]);
    assert_eq!(Assessment::of(said.last().unwrap()), before);
}

/// As they are published, ROS 2's and FZI's laws are not made for a contact as stiff as this one.
#[test]
fn an_unstable_loop_says_how_far_it_has_to_go_back() {
    for law in ["ros2", "fzi"] {
        let law_key = format!("controller.law={law}");
        let found = published("paper", &[&law_key]);
        let closed = linear::closed(&scenario("paper", &[&law_key])).unwrap();
        assert!(
            found.gain_margin < 1.0 && found.phase_margin_rad < 0.0,
            "{law}: {found:?}"
        );
        assert!(closed.stable(0.98 * found.gain_margin) && !closed.stable(1.02 * found.gain_margin));
    }
}

/// What is named as the remedy is one.
#[test]
fn each_remedy_widens_the_margin() {
    for (law, remedies) in [
        (
            "pd",
            &[
                "controller.pd.proportional_m_per_n=1.35e-6",
                "controller.pd.derivative_m_per_n=5.5e-6",
            ][..],
        ),
        ("proposed", &["controller.proposed.settled_filter_gain=0.005"]),
        ("impedance", &["controller.impedance.damping_ns_per_m=2000"]),
        ("impedance", &["controller.proposed.settled_filter_gain=0.005"]),
        ("ros2", &["controller.ros2.damping_ratio=20"]),
        ("fzi", &["controller.fzi.error_scale=0.1"]),
        (
            "elastic",
            &["controller.elastic.unknown_acceleration_m_per_s2=0.03"],
        ),
        ("elastic", &["controller.elastic.deflection_noise_m=40e-6"]),
    ] {
        let name = if law == "elastic" { "elastic" } else { "paper" };
        let law_key = format!("controller.law={law}");
        let margin = |more: &[&str]| {
            let overrides: Vec<_> = more.iter().copied().chain([law_key.as_str()]).collect();
            let closed = linear::closed(&scenario(name, &overrides)).unwrap();
            Assessment::new(spatial::ports::Law::Pd, &closed)
                .unwrap()
                .gain_margin
        };
        let [before, after] = [margin(&[]), margin(remedies)];
        assert!(after > 1.1 * before, "{law}, {remedies:?}: {before}, {after}");
    }
}

/// A run for its figures does without.
#[test]
fn a_run_that_is_only_measured_assesses_nothing() {
    in_process::run(&scenario("paper", &[]), |tick| {
        assert!(
            tick.controller
                .is_none_or(|outputs| outputs.status.gain_margin == 0.0)
        );
    });
}

/// With the tcp straight below the sensor one mode alone is seen; the others, of which one is the contact's own, must not
/// spoil the regulator of `elastic`.
#[test]
fn the_law_behind_elastic_gears_regulates_without_a_lever() {
    for name in ["lever_0", "insert"] {
        let found = published(name, &["controller.law=elastic"]);
        assert!(
            found.concern().is_none() && found.gain_margin > 4.0,
            "{name}: {found:?}"
        );
    }
}
