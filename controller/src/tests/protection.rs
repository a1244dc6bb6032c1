//! Each protection by its cause, in every phase.

use super::*;
use ControllerPhase::{Approach, Contact, Ready, Settled};
use spatial::ports::{LIMIT_COLLISION_FORCE_X, LIMIT_FORCE, LIMIT_SEEK};

/// C of the tcp along z (PLANT.md section 5), m/N.
const COMPLIANCE: f64 = 28.267e-6;

/// The deflection at s under a wrench at the tcp (N, Nm): (3)-(6).
fn under(force: Vector3<f64>, moment: Vector3<f64>) -> Deflection {
    let at_s = moment + Vector3::new(0.10, 0.0, -0.15).cross(&force);
    Deflection {
        translation: force / 300e3,
        rotation: at_s / 401.07,
    }
}

/// A run in which the object is met at 400 ms, and something pushes the tool from tick `from` on: the last outputs, and the
/// phase just before.
fn pushed(scenario: &Scenario, from: i64, push: &Deflection) -> (Outputs, ControllerPhase, Axes) {
    let mut controller = Controller::new(scenario);
    let mut axes = scenario.start_axes().unwrap();
    let (mut before, mut at) = (ControllerPhase::Init, axes);
    for tick in (0..=from + 200).step_by(4) {
        let force = if tick < 400 { 0.0 } else { 10.0 };
        let deflections = sensed(tick, 0, |sampled| {
            let touched = under(
                Vector3::z() * if sampled < 400 { 0.0 } else { force },
                Vector3::zeros(),
            );
            if sampled < from { touched } else { touched + *push }
        });
        let outputs = controller.cycle(&Heard::complete(&state(tick, axes), &deflections, None));
        if tick < from {
            (before, at) = (outputs.status.phase, axes);
            assert_eq!(outputs.status.fault, Fault::None, "tick {tick}");
        }
        axes = outputs.command.axis_position[0];
        if tick == from + 200 {
            return (outputs, before, at);
        }
    }
    unreachable!("the last tick is a cycle's");
}

/// Every axis, in every phase: the fault, the bit of the axis, value and limit; and the robot stands where it was, not
/// where it was sent.
#[test]
fn a_collision_stops_the_robot_and_names_axis_and_value() {
    let scenario = weightless();
    let phases = [(240, Ready), (360, Approach), (440, Contact), (700, Settled)];
    for (from, phase) in phases {
        let free = from < 400;
        for axis in 0..6 {
            let most = match (free, axis < 3) {
                (true, true) => 60.0,
                (true, false) => 10.0,
                (false, true) => 350.0,
                (false, false) => 60.0,
            };
            let mut all = [0.0; 6];
            all[axis] = most;
            let [fx, fy, fz, mx, my, mz] = all;
            let push = under(Vector3::new(fx, fy, fz), Vector3::new(mx, my, mz));
            let mut scenario = scenario.clone();
            // A push from the side moves the tcp along the normal too, which could be the contact that is looked for.
            scenario.controller.detection_threshold_n = if free { 1e4 } else { 0.82 };
            scenario.controller.cusum.enabled = false;
            scenario.task.max_contact_force_n = 1e4;
            let (Outputs { command, status }, before, at) = pushed(&scenario, from, &push);
            assert_eq!(before, phase, "axis {axis}");
            assert_eq!(
                (status.phase, status.fault),
                (ControllerPhase::Fault, Fault::Collision),
                "{phase:?}, axis {axis}"
            );
            assert_eq!(status.limits / LIMIT_COLLISION_FORCE_X, 1 << axis, "{phase:?}");
            let expected = if axis == 2 && !free { most + 10.0 } else { most };
            assert!(
                (status.detection.statistic_n - expected).abs() < 0.5,
                "{status:?}"
            );
            let limits = [
                if axis < 3 { 30.0 } else { 4.0 },
                if axis < 3 { 300.0 } else { 50.0 },
            ];
            let limit = limits[usize::from(!free)];
            assert!(
                (limit..1.3 * limit).contains(&status.detection.threshold_n),
                "{status:?}"
            );
            let [next, .., last] = command.axis_position;
            assert!(
                next == last && (next - at).amax() < 6e-4,
                "{} {}",
                next - at,
                axis
            );
        }
    }
}

/// More along the normal than allowed is a fault of its own.
#[test]
fn too_much_force_is_a_fault() {
    let mut scenario = weightless();
    scenario.task.max_contact_force_n = 25.0;
    let push = under(Vector3::z() * 20.0, Vector3::zeros());
    for (from, phase) in [(440, Contact), (700, Settled)] {
        let (Outputs { status, .. }, before, _) = pushed(&scenario, from, &push);
        assert_eq!((before, status.fault), (phase, Fault::ForceLimit));
        assert_eq!(status.limits / LIMIT_COLLISION_FORCE_X, 1 << 2);
        assert!((status.detection.statistic_n - 30.0).abs() < 0.1 && status.detection.threshold_n == 25.0);
    }
}

/// A pd law that pushes on, since the sensor shows too little force, never asks for more than allowed.
#[test]
fn no_law_presses_harder_than_allowed() {
    let mut scenario = weightless();
    scenario.controller.law = spatial::ports::Law::Pd;
    scenario.task.max_contact_force_n = 15.0;
    let mut controller = Controller::new(&scenario);
    let axes = scenario.start_axes().unwrap();
    let kinematics = scenario.robot.kinematics();
    let tcp = |axes: &Axes| {
        (kinematics.forward(axes) * spatial::Pose::translation(0.10, 0.0, -0.15))
            .translation
            .z
    };
    let (mut lowest, mut bits) = (0.0_f64, 0);
    for tick in (0..=2000).step_by(4) {
        let force = if tick < 300 { 0.0 } else { 5.0 };
        let deflections = sensed(tick, 0, |_| lifted(COMPLIANCE * force));
        let outputs = controller.cycle(&Heard::complete(&state(tick, axes), &deflections, None));
        bits |= outputs.status.limits;
        if tick > 300 {
            lowest = lowest.min(tcp(&outputs.command.axis_position[0]) - tcp(&axes));
        }
    }
    // 15 N less the 5 N that it presses with where it is.
    assert!((lowest + 10.0 * COMPLIANCE).abs() < 2e-6, "{lowest} m");
    assert!(bits & LIMIT_FORCE != 0);
}

/// The object is gone: it is sought with 10 mm/s at most by every law, although they would go down much faster.
#[test]
fn a_lost_object_is_sought_slowly() {
    use spatial::ports::Law;
    for law in [Law::Pd, Law::PdReset, Law::Literal, Law::Proposed, Law::Impedance] {
        let mut scenario = weightless();
        scenario.controller.law = law;
        scenario.controller.pd.proportional_m_per_n = 1e-4;
        scenario.controller.limits.seek_speed_m_per_s = 0.004;
        let mut controller = Controller::new(&scenario);
        let mut axes = scenario.start_axes().unwrap();
        let (mut heights, mut bits) = (Vec::new(), 0);
        for tick in (0..=1400).step_by(4) {
            let force = if (300..700).contains(&tick) { 10.0 } else { 0.0 };
            let deflections = sensed(tick, 0, |_| lifted(COMPLIANCE * force));
            let outputs = controller.cycle(&Heard::complete(&state(tick, axes), &deflections, None));
            axes = outputs.command.axis_position[0];
            assert_eq!(outputs.status.fault, Fault::None, "{law:?}, tick {tick}");
            if tick > 760 {
                bits |= outputs.status.limits;
                heights.push(axes.z);
            }
        }
        let fastest = heights
            .windows(25)
            .map(|pair| (pair[0] - pair[24]) / 0.096)
            .fold(0.0, f64::max);
        assert!((0.003..0.0042).contains(&fastest), "{law:?}: {fastest} m/s");
        assert!(bits & LIMIT_SEEK != 0, "{law:?}");
    }
}
