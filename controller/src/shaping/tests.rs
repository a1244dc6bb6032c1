//! Assumed models against PLANT.md, and shaped changes of speed on oscillators.

use super::*;
use crate::dofs::NORMAL;
use nalgebra::Vector3;
use node::scenario::{Gears, Kinematics, Scenario};
use std::f64::consts::TAU;

fn swing(scenario: &Scenario) -> Swing {
    let start = scenario.start_axes().unwrap();
    Swing::new(&scenario.controller, &scenario.robot.kinematics(), &start)
}

fn elastic(kinematics: Kinematics) -> Scenario {
    let mut scenario = Scenario::default();
    scenario.robot.kinematics = kinematics;
    scenario.controller.gears.kind = Gears::Elastic;
    scenario
}

/// PLANT.md section 5: the free modes.
#[test]
fn the_modes_of_the_tool_on_the_sensor() {
    let found = *swing(&Scenario::default()).modes_hz();
    let expected = [16.56, 17.52, 31.28, 43.59, 66.31, 73.76];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }
    assert!(found[6..].iter().all(|&hz| hz > 1e4));
}

/// PLANT.md section 2: the decoupled variant of the arm, with the sensor, motors locked.
#[test]
fn the_modes_of_the_arm_with_elastic_gears() {
    let mut scenario = elastic(Kinematics::Arm);
    scenario.controller.servo.link_inertia_kg_m2 = [50.0, 50.0, 25.0, 1.2, 1.2, 0.5];
    scenario.controller.gears.frequency_hz = [14.0, 15.0, 17.0, 20.0, 22.0, 25.0];
    let found = *swing(&scenario).modes_hz();
    for (found, expected) in found.iter().zip([13.0, 14.1, 14.9, 16.7, 17.8, 21.9, 23.3, 24.7]) {
        assert!((found - expected).abs() < 0.06, "{found} {expected}");
    }
    assert!(found[8] > 31.5, "{found:?}");
}

/// A tool of 4 kg accelerated along z presses with 4 N per m/s^2 at its centre of mass, which lies 0.03 m before s: the
/// sensor yields by 13.3 um and turns by 0.299 mrad, which is 29.9 um along z and 44.9 um along x at the tcp.
#[test]
fn the_tcp_leads_by_what_the_acceleration_deflects() {
    let lead = swing(&Scenario::default()).lead(1.0);
    let turn = -0.12 * 2.493_330_3e-3;
    let expected = Vector3::new(turn * -0.15, 0.0, 13.333e-6 - turn * 0.10);
    assert!((lead.fixed_rows::<3>(0) - expected).norm() < 1e-9, "{lead}");
    assert!((lead[4] - turn).abs() < 1e-9, "{lead}");
    // Behind a gear of 14 Hz, the 60 kg of the link and the tool's 4 kg.
    let more = swing(&elastic(Kinematics::Gantry)).lead(1.0) - lead;
    let gear = 64.0 / 60.0 / (TAU * 14.0 * TAU * 14.0);
    assert!(more[NORMAL] > gear && more[NORMAL] < 1.2 * gear, "{more} {gear}");
}

/// The largest deviation of an undamped oscillator of `hz` after its base has been moved with `speed` by `shape`: the
/// integral of the base's acceleration times sine and cosine, over w, by the trapezoidal rule.
fn left_swinging(shape: &Shape, speed: f64, hz: f64) -> f64 {
    let (steps, w) = (8000, TAU * hz);
    let h = shape.ramp_time(speed) / f64::from(steps);
    let (mut re, mut im) = (0.0, 0.0);
    for i in 0..=steps {
        let time = h * f64::from(i);
        let a = shape.ramp(0.0, speed, time).acceleration;
        re += h * a * libm::cos(w * time) / w;
        im += h * a * libm::sin(w * time) / w;
    }
    libm::hypot(re, im)
}

/// Above the edge nothing is left swinging beyond the ripple's share of what the acceleration deflects twice.
#[test]
fn what_is_above_the_edge_hardly_swings() {
    let shape = Shape::smooth(2.0, 15.0, 0.01);
    for speed in [0.002, 0.02, 0.1, 0.25, 0.5] {
        for i in 0..200 {
            let hz = 15.0 + 0.3 * f64::from(i);
            let deflection = 2.0 / (TAU * hz * TAU * hz);
            let left = left_swinging(&shape, speed, hz) / (2.0 * deflection);
            assert!(left < 0.013, "{left} at {hz} Hz, {speed} m/s");
        }
    }
}

/// The derivatives are those of the distance, and the acceleration keeps to its limit.
#[test]
fn a_ramp_is_consistent() {
    for shape in [Shape::smooth(2.0, 15.0, 0.01), Shape::trapezoid(2.0)] {
        let (change, h) = (0.25, 1e-4);
        let duration = shape.ramp_time(change);
        let at = |i: i32| shape.ramp(0.1, change, duration * 0.3 + h * f64::from(i));
        let (before, now, after) = (at(-1), at(0), at(1));
        assert!(((after.distance - before.distance) / (2.0 * h) - now.speed).abs() < 1e-6);
        assert!(((after.speed - before.speed) / (2.0 * h) - now.acceleration).abs() < 1e-3);
        let end = shape.ramp(0.1, change, duration);
        assert!((end.speed - 0.35).abs() < 1e-12, "{end:?}");
        assert!((end.distance - 0.225 * duration).abs() < 1e-12, "{end:?}");
        assert!(now.acceleration <= 2.0);
    }
}

/// A residual that is larger than what would swing anyway needs hardly any window; a smaller one a longer one.
#[test]
fn the_window_is_as_long_as_the_residual_asks_for() {
    let mut scenario = Scenario::default();
    let swing = swing(&scenario);
    let mut window = |residual_m: f64, mode_error: f64| {
        scenario.controller.shaping.residual_m = residual_m;
        scenario.controller.shaping.mode_error = mode_error;
        Shape::new(&scenario.controller.shaping, &swing).window()
    };
    let (exact, robust, fine) = (window(1e-6, 0.0), window(1e-6, 0.1), window(1e-7, 0.1));
    assert!(exact < robust && robust < fine, "{exact} {robust} {fine}");
    assert!(window(1e-3, 0.1) < 0.07);
}
