//! Long exponential steps against short Runge-Kutta ones, which know nothing of them, on the same motion of the link:
//! whatever the object is like, and whether the contact is smooth or not.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nalgebra::Vector3;
use node::scenario::{Scenario, ToolShape};
use sensor_sim::SensorSim;
use spatial::ports::{LinkMotion, Role, Stamp, Truth};
use spatial::{Motion, Pose, TICK_S, rotation};

/// The link 1 mm above an object at r's origin goes down by 1.2 mm within 0.1 s, turning by 2 mrad, and on by 50 um
/// and back, twice, within 0.4 s.
fn link(scenario: &Scenario, tick: i64) -> LinkMotion {
    let height = |t: f64| {
        let s = (t / 0.1).min(1.0);
        let down = 1.2e-3 * s * s * s * (10.0 + s * (-15.0 + s * 6.0));
        let u = (t - 0.1).max(0.0);
        down + 25e-6 * (1.0 - libm::cos(10.0 * std::f64::consts::PI * u))
    };
    let t = tick as f64 * TICK_S;
    let (h, rate) = (1e-6, |f: &dyn Fn(f64) -> f64| (f(t + 1e-6) - f(t - 1e-6)) / 2e-6);
    let start = Vector3::new(0.0, 0.0, 0.001) - Vector3::from(scenario.tool.tcp_in_s_m);
    let turn = |t: f64| height(t) * 1.6;
    let mut motion = Motion::at_rest(Pose::from_parts(
        (start - Vector3::z() * height(t)).into(),
        rotation::exp(Vector3::new(0.0, turn(t), 0.0)),
    ));
    if t > h {
        motion.velocity.z = -rate(&height);
        motion.angular_velocity.y = rate(&turn);
    }
    LinkMotion {
        stamp: Stamp::lockstep(tick, 1, Role::Robot),
        motion,
        kinetic_energy_j: 0.0,
        elastic_energy_j: 0.0,
        motor_work_j: 0.0,
        dissipated_energy_j: 0.0,
    }
}

/// The truth at each tick, in steps of at most `longest` and around kinks at most `shortest` s; and the last sample.
fn run(scenario: &Scenario, [longest, shortest]: [f64; 2]) -> (Vec<Truth>, Vector3<f64>) {
    let mut scenario = scenario.clone();
    scenario.sensor.smooth_step_s = longest;
    scenario.sensor.integration_step_s = shortest;
    let mut sensor = SensorSim::new(&scenario, &link(&scenario, 0).motion);
    let all: Vec<_> = (0..=500)
        .map(|tick| sensor.advance(&link(&scenario, tick)))
        .collect();
    let sample = all[500].deflections.samples[0].deflection.translation;
    (all.iter().map(|outputs| outputs.truth).collect(), sample)
}

/// The paper's tool and object without noise and quanta, the object at r's origin.
fn quiet() -> Scenario {
    let mut scenario = Scenario::default();
    scenario.object.height_m = 0.0;
    let sensor = &mut scenario.sensor;
    sensor.noise_translation_m = 0.0;
    sensor.noise_rotation_rad = 0.0;
    sensor.quantum_translation_m = 0.0;
    sensor.quantum_rotation_rad = 0.0;
    scenario
}

#[test]
fn long_steps_are_short_ones() {
    let mut face = quiet();
    face.tool.shape = ToolShape::Face;
    let mut yielding = quiet();
    yielding.object.support_n_per_m = 200e3;
    yielding.object.support_ns_per_m = 100.0;
    let mut moving = quiet();
    moving.object.swing_amplitude_m = [1e-4, 0.0, 5e-5];
    moving.object.swing_frequency_hz = 5.0;
    let mut round = quiet();
    round.object.exponent = 1.5;
    round.object.indentation_n_per_m = 4e9;
    let mut rough = quiet();
    rough.object.friction = 0.1;
    let mut stopped = quiet();
    // It hangs at 131 um.
    stopped.sensor.end_stop_m = 0.135e-3;
    stopped.sensor.end_stop_n_per_m = 1e6;
    let mut tilted = quiet();
    tilted.object.rotation_rad = [0.1, -0.05, 0.0];
    // What a surface that moves or yields takes up of a ringing force is not resolved in long steps.
    for (name, scenario, energy) in [
        ("point", quiet(), 1e-3),
        ("face", face, 1e-3),
        ("yielding", yielding, 4e-2),
        ("moving", moving, 4e-2),
        ("round", round, 1e-3),
        ("rough", rough, 1e-3),
        ("stopped", stopped, 1e-3),
        ("tilted", tilted, 1e-3),
    ] {
        let (found, sample) = run(&scenario, [1e-3, 1e-5]);
        let (exact, exact_sample) = run(&scenario, [2e-6, 2e-6]);
        let largest = |all: &[Truth], of: fn(&Truth) -> f64| all.iter().map(of).fold(0.0, f64::max);
        let z = |truth: &Truth| truth.tcp_deflection.translation.z;
        let reach = exact.iter().map(|truth| z(truth).abs()).fold(0.0, f64::max);
        let off = found
            .iter()
            .zip(&exact)
            .map(|(a, b)| (z(a) - z(b)).abs())
            .sum::<f64>();
        let impact = |all: &[Truth]| largest(all, |t| t.contact_force_peak_n);
        let motion = [
            off / found.len() as f64 / reach,
            impact(&found) / impact(&exact) - 1.0,
            (sample - exact_sample).norm() / reach,
        ];
        let kinetic = largest(&exact, |t| t.kinetic_energy_j);
        let (start, a, b) = (&found[0], &found[500], &exact[500]);
        let more = |of: fn(&Truth) -> f64| (of(a) - of(b)) / kinetic;
        let stored = |t: &Truth| t.kinetic_energy_j + t.gravity_energy_j + t.elastic_energy_j;
        let given_away = a.dissipated_energy_j + a.contact_work_j - a.link_work_j;
        let energies = [
            more(|t| t.link_work_j),
            more(|t| t.dissipated_energy_j),
            more(|t| t.contact_work_j),
            (stored(a) + given_away - stored(start)) / kinetic,
        ];
        println!(
            "{name}: deflection, impact, sample {motion:?}; link, damper, contact, account {energies:?}"
        );
        assert!(impact(&exact) > 10.0, "{name}: no impact");
        assert!(
            motion.iter().all(|error| error.abs() < 2e-4),
            "{name}: {motion:?}"
        );
        assert!(
            energies.iter().all(|error| error.abs() < energy),
            "{name}: {energies:?}"
        );
    }
}
