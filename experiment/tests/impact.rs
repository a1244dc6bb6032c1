//! The assessment of the impact against simulated impacts: of a free tool, and in the closed loop.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use controller::impact::{Impact, KicksLaw, Rebound, Striker, Surface, ToolInertia};
use experiment::compare::variations;
use experiment::impact::simulated::Simulated;
use experiment::metrics::Recording;
use experiment::scenarios::Source;
use nalgebra::{UnitQuaternion, Vector3};
use node::scenario::{Object, Scenario, Sensor, Tool};
use rayon::prelude::*;
use sensor_sim::contacts::Contacts;
use sensor_sim::object::Yielding;
use sensor_sim::tool::{Body, Instant, State};
use spatial::{Motion, Pose};

const STEP_S: f64 = 1e-6;

/// Scenario, kinematics and detection threshold (N).
const PLANTS: [(&str, &str, f64); 4] = [
    ("paper", "gantry", 0.82),
    ("elastic", "gantry", 0.82),
    ("arm", "arm", 0.82),
    // The ringing of its gears would be taken for contact.
    ("elastic", "arm", 3.0),
];

/// The bit of `ControllerStatus::limits` that says that the approach is slowed.
const LIMIT_VELOCITY: i32 = 2;

/// A tool thrown at the object with 20 mm/s, its sensor cut off and without weight: peak (N), largest and remaining
/// indentation (m), duration (s) and speed afterwards (m/s), as `sensor-sim` integrates them.
fn thrown(tool: &Tool, object: &Object) -> [f64; 5] {
    let sensor = Sensor {
        damping_ns_per_m: 0.0,
        damping_nms_per_rad: 0.0,
        ..Sensor::default()
    };
    let mut body = Body::new(tool, &sensor);
    body.weight = Vector3::zeros();
    body.suspension.stiffness_n_per_m = 0.0;
    body.suspension.stiffness_nm_per_rad = 0.0;
    let object = Object {
        height_m: body.tcp.z,
        ..object.clone()
    };
    let mut contacts = Contacts::new(tool, &object);
    let now = Instant {
        link: Motion::at_rest(Pose::identity()),
        base: contacts.object().base(0.0),
    };
    let mut state = State {
        position: body.centre_of_mass,
        velocity: Vector3::new(0.0, 0.0, -0.02),
        rotation: UnitQuaternion::identity(),
        angular_velocity: Vector3::zeros(),
        surface: Yielding::default(),
    };
    let (mut peak, mut deepest, mut remaining, mut steps) = (0.0_f64, 0.0_f64, 0.0, 0);
    loop {
        state = body.integrate(&state, [&now; 3], &contacts, STEP_S).0;
        let force = contacts
            .load(&state, &state.rotation.to_rotation_matrix(), &now.base)
            .force
            .z;
        let h = contacts.remember(&state, &now.base);
        steps += 1;
        if force <= 0.0 {
            return [
                peak,
                deepest,
                remaining,
                f64::from(steps) * STEP_S,
                body.tcp_motion(&state).1.z,
            ];
        }
        (peak, deepest) = (peak.max(force), deepest.max(h));
        remaining = contacts.deepest(&state, &now.base).remaining_m;
    }
}

fn surface(object: &Object) -> Surface {
    Surface {
        law: KicksLaw::new(object.indentation_n_per_m, object.exponent).unwrap(),
        rebound: Rebound::new(object.rebound_ratio).unwrap(),
    }
}

/// Within 0.1 % in peak and depth and one integration step in duration: elastic and with c_re = 4 c_in, on the
/// normal through the centre of mass and off it, of a flat punch, a sphere and a cone.
#[test]
fn a_free_tool_strikes_as_assessed() {
    let in_line = Tool {
        centre_of_mass_in_s_m: [0.0, 0.0, -0.06],
        tcp_in_s_m: [0.0, 0.0, -0.15],
        ..Tool::default()
    };
    for tool in [Tool::default(), in_line] {
        let inertia = ToolInertia::new(tool.mass_kg, tool.inertia_kg_m2, tool.centre_of_mass_in_s_m).unwrap();
        let mass = inertia.at_tcp_kg(tool.tcp_in_s_m.into(), Vector3::z());
        for (exponent, coefficient) in [(1.0, 16e6), (1.5, 1e9), (2.0, 1e12)] {
            for ratio in [1.0, 4.0] {
                let object = Object {
                    exponent,
                    indentation_n_per_m: coefficient,
                    rebound_ratio: ratio,
                    ..Object::default()
                };
                let expected: Impact = surface(&object).struck_by(&Striker::new(mass, 0.02).unwrap());
                let [peak, depth, remaining, duration, speed] = thrown(&tool, &object);
                let what = format!("n = {exponent}, c_re / c_in = {ratio}, {mass} kg");
                let close = |found: f64, expected: f64, limit: f64| {
                    (found - expected).abs() <= limit * expected.abs()
                };
                assert!(
                    close(peak, expected.peak_force_n, 1e-3),
                    "{what}: {peak} N, {expected:?}"
                );
                assert!(
                    close(depth, expected.maximum_depth_m, 1e-3),
                    "{what}: {depth} m, {expected:?}"
                );
                assert!(
                    (remaining - expected.remaining_depth_m).abs() <= 1e-3 * depth,
                    "{what}: {remaining} m"
                );
                assert!(
                    (duration - expected.characteristic_time_s()).abs() <= STEP_S,
                    "{what}: {duration} s, {}",
                    expected.characteristic_time_s()
                );
                assert!(
                    close(speed, 0.02 * expected.restitution, 2e-3),
                    "{what}: {speed} m/s"
                );
            }
        }
    }
}

/// Each of [`PLANTS`] at `phases` contact phases, with `overrides` too.
fn runs(phases: usize, overrides: &[String]) -> Vec<(String, Scenario)> {
    let mut runs = Vec::new();
    for (name, kinematics, threshold_n) in PLANTS {
        let mut overrides = overrides.to_vec();
        overrides.push(format!("robot.kinematics={kinematics}"));
        overrides.push(format!("controller.detection_threshold_n={threshold_n}"));
        let scenario = Source::find(name).unwrap().scenario(&overrides).unwrap();
        let what = format!("{name}, {overrides:?}");
        runs.extend(
            variations(&scenario, phases, 1)
                .into_iter()
                .map(|scenario| (what.clone(), scenario)),
        );
    }
    runs
}

/// In the closed loop within 0.5 % of (17) with the effective mass and the true speed at the contact, over contact
/// phases, on gantry and arm, with rigid and with elastic gears. And the controller's own assessment, with what it
/// assumes and the speed that it has measured at the contact, within 1 % of the truth.
#[test]
fn a_run_meets_its_prediction_and_the_controller_tells_it() {
    runs(6, &[]).par_iter().for_each(|(what, scenario)| {
        let simulated = Simulated::of(scenario).unwrap();
        assert!(simulated.deviation().abs() < 0.005, "{what}: {simulated:?}");
        assert!(
            simulated.peak_force_n > 4.0 * simulated.controlled_peak_n,
            "{what}: {simulated:?}"
        );
        let assessed = simulated.controller.unwrap();
        let off = assessed.peak_force_n / simulated.peak_force_n - 1.0;
        assert!(off.abs() < 0.01 && !assessed.slowed, "{what}: {simulated:?}");
        let before = assessed.approach_speed_m_per_s / simulated.contact_speed_m_per_s - 1.0;
        assert!(before.abs() < 0.1, "{what}: {simulated:?}");
    });
}

/// What the controller assumes is not what is: a contact that is taken to be four times as soft is assessed as half as
/// hard, by the square root of (17).
#[test]
fn a_wrong_assumption_is_a_wrong_assessment() {
    let overrides = ["controller.impact.indentation_n_per_m=4e6".to_owned()];
    for (what, scenario) in runs(1, &overrides) {
        let simulated = Simulated::of(&scenario).unwrap();
        let share = simulated.controller.unwrap().peak_force_n / simulated.peak_force_n;
        assert!((share - 0.5).abs() < 0.005, "{what}: {simulated:?}");
    }
}

/// Materials (c_in, n and c_re), requested speeds and contact phases: the impact, the contact force beyond the one that
/// the sensor shows, stays within 12 % of `task.max_impact_force_n` all along, bounces included (10 % are seen in one
/// of 12 contact phases off an elastic object, whatever the approach's ramp); the force of the first impact within 5 % as a
/// whole. An approach that is slowed for it says so.
#[test]
fn the_allowed_impact_force_is_kept() {
    const ALLOWED_N: f64 = 40.0;
    // From wood across the grain (the softest of the paper's footnote 10) to a hard polymer, a sphere and a cone.
    let materials = [
        (1.0, 3.2e6, 4.0, 1e-4),
        (1.0, 16e6, 1.0, 1e-4),
        (1.0, 16e6, 4.0, 1e-4),
        (1.0, 1e8, 4.0, 4e-5),
        (1.5, 2e9, 4.0, 1e-4),
        (2.0, 1e12, 2.0, 1e-4),
    ];
    let mut all = Vec::new();
    for (exponent, coefficient, ratio, smooth_step_s) in materials {
        let struck = Object {
            exponent,
            indentation_n_per_m: coefficient,
            ..Object::default()
        };
        // Off the elastic one it may be slower; 1.8 kg strike.
        let allowed = surface(&struck).speed_for_force_m_per_s(1.8, ALLOWED_N).unwrap() / 1.7;
        for speed in [0.01, 0.1] {
            let overrides = [
                format!("object.exponent={exponent}"),
                format!("object.indentation_n_per_m={coefficient}"),
                format!("object.rebound_ratio={ratio}"),
                format!("controller.impact.exponent={exponent}"),
                format!("controller.impact.indentation_n_per_m={coefficient}"),
                format!("controller.impact.rebound_ratio={ratio}"),
                format!("task.approach_speed_m_per_s={speed}"),
                format!("task.max_impact_force_n={ALLOWED_N}"),
                // At least 0.45 s of cruise: what the ramp excites has faded to 3 % of the speed.
                "object.height_m=0.020".to_owned(),
                format!("sensor.smooth_step_s={smooth_step_s}"),
                format!("timing.duration_s={}", 0.95 + 0.010 / f64::min(speed, allowed)),
            ];
            all.extend(runs(2, &overrides));
        }
    }
    all.par_iter().for_each(|(what, scenario)| {
        let mut recording = Recording::new(scenario);
        let (mut peaks, mut slowed, mut limit) = (Vec::new(), false, 0.0);
        experiment::in_process::run(scenario, |tick| {
            recording.observe(tick);
            peaks.push(tick.sensor.truth.contact_force_peak_n);
            if let Some(outputs) = &tick.controller {
                slowed |= outputs.status.limits & LIMIT_VELOCITY != 0;
                limit = outputs.status.impact.speed_limit_m_per_s;
            }
        });
        assert_eq!(slowed, limit < scenario.task.approach_speed_m_per_s, "{what}");
        let curve = recording.force_curve().unwrap();
        let (mut first, mut most) = (0.0_f64, 0.0_f64);
        for ((peak, shown), time_s) in peaks.iter().zip(&curve.force_n).zip(&curve.time_s) {
            most = most.max(peak - shown.max(0.0));
            if *time_s < 0.005 {
                first = first.max(*peak);
            }
        }
        assert!(
            first > 0.0 && first <= 1.05 * ALLOWED_N,
            "first {first} N: {what}"
        );
        assert!(most <= 1.12 * ALLOWED_N, "{most} N: {what}");
    });
}
