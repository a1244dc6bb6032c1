//! What a sample of the sensor stands for, and where the robot was then.

use super::*;
use spatial::ports::Law;

/// A controller after 0.3 s at the scenario's start with the sag of PLANT.md section 5, ready for contact, and its axes.
fn hanging(scenario: &Scenario) -> (Controller, Axes, Deflection) {
    let mut controller = Controller::new(scenario);
    let axes = scenario.start_axes().unwrap();
    let sag = Deflection {
        translation: Vector3::new(0.0, 0.0, -130.7e-6),
        rotation: Vector3::new(0.0, 2.918e-3, 0.0),
    };
    for tick in (0..=300).step_by(4) {
        controller.cycle(&Heard::complete(
            &state(tick, axes),
            &sensed(tick, 0, |_| sag),
            None,
        ));
    }
    (controller, axes, sag)
}

/// Paper (5), (6): a force at d = (0.10, 0, -0.15) m exerts d x f about the sensor, which is no moment at the tcp.
#[test]
fn a_force_at_the_tcp_is_a_force_without_moment_there() {
    let scenario = weightless();
    let (mut controller, axes, sag) = hanging(&scenario);
    let forces = [
        (Vector3::x(), Vector3::new(0.0, -0.15, 0.0)),
        (Vector3::y(), Vector3::new(0.15, 0.0, 0.10)),
        (Vector3::z(), Vector3::new(0.0, -0.10, 0.0)),
    ];
    for (i, (force, moment_at_s)) in (0..).zip(forces) {
        let tick = 304 + 4 * i;
        // 1 mm at 300 N, 1 deg at 7 Nm.
        let pushed = Deflection {
            translation: sag.translation + force * (10.0 * 1e-3 / 300.0),
            rotation: sag.rotation + moment_at_s * (10.0 * 1f64.to_radians() / 7.0),
        };
        let wrench = controller
            .cycle(&Heard::complete(
                &state(tick, axes),
                &sensed(tick, 0, |_| pushed),
                None,
            ))
            .status
            .wrench;
        assert!((wrench.force - force * 10.0).norm() < 1e-6, "{wrench:?}");
        assert!(wrench.moment.norm() < 1e-4, "{wrench:?}");
    }
}

/// A moment is the same everywhere.
#[test]
fn a_moment_is_a_moment_without_force() {
    let (mut controller, axes, sag) = hanging(&weightless());
    let moment = Vector3::new(0.3, -0.2, 0.1);
    let turned = Deflection {
        rotation: sag.rotation + moment * (1f64.to_radians() / 7.0),
        ..sag
    };
    let wrench = controller
        .cycle(&Heard::complete(
            &state(304, axes),
            &sensed(304, 0, |_| turned),
            None,
        ))
        .status
        .wrench;
    assert!(
        wrench.force.norm() < 1e-9 && (wrench.moment - moment).norm() < 1e-4,
        "{wrench:?}"
    );
}

/// The robot moves down through the object at constant speed; the sensor's low pass turns the ramp of the deflection,
/// `v t`, into `v (t - tau (1 - e^(-t / tau)))`, late by tau = 1 / (2 pi f), and the wire delays it further. The object
/// must not seem to move (PLANT.md section 7: misaligned times cost stability).
#[test]
fn the_object_stands_still_however_fast_the_robot_and_late_the_sensor() {
    for (speed, bandwidth, delay) in [
        (0.020, 200.0, 4),
        (0.005, 200.0, 0),
        (0.020, 20.0, 7),
        (0.1, 80.0, 32),
    ] {
        let mut scenario = weightless();
        scenario.controller.law = Law::Literal;
        // Pushed by centimetres, as no sensor is.
        scenario.controller.collision.enabled = false;
        scenario.task.max_contact_force_n = 1e6;
        scenario.controller.sensor_bandwidth_hz = bandwidth;
        let start = scenario.start_axes().unwrap();
        let touched = 0.4;
        let moved = |tick: i64| start - Axes::ith(2, speed * (tick as f64 * TICK_S - 0.3).max(0.0));
        let object = start.z + scenario.controller.tcp_in_s_m[2] - speed * (touched - 0.3);
        let tau = 1.0 / (TAU * bandwidth);
        let shown = |tick: i64| {
            let t = (tick as f64 * TICK_S - touched).max(0.0);
            lifted(speed * (t - tau * (1.0 - libm::exp(-t / tau))))
        };
        let mut controller = Controller::new(&scenario);
        for tick in (0..=700).step_by(4) {
            let status = controller
                .cycle(&Heard::complete(
                    &state(tick, moved(tick)),
                    &sensed(tick, delay, shown),
                    None,
                ))
                .status;
            if (tick - delay) as f64 * TICK_S > touched + 20.0 * tau {
                let height = status.object_pose.translation.vector.z;
                assert!(status.object_known);
                assert!(
                    (height - object).abs() < 1e-9,
                    "{height} m, not {object} m, at tick {tick}"
                );
            }
        }
    }
}

/// Paper (3), (4): a sensor that outputs a wrench is one that outputs the deflection C times it.
#[test]
fn a_force_sample_stands_for_the_deflection_under_it() {
    let run = |output: SensorOutput| -> Vec<Outputs> {
        let mut scenario = weightless();
        scenario.controller.sensor_output = output;
        let mut controller = Controller::new(&scenario);
        let start = scenario.start_axes().unwrap();
        let cycle = |tick: i64| {
            let mut deflections = undeflected(tick);
            for sample in &mut deflections.samples {
                let force = if sample.utime > 400_000 { 10.0 } else { 0.0 };
                // What the tool exerts at s with this force at the tcp, (0, 0, 10) N and (0, -1, 0) Nm, or what yields
                // under it; the other one of the two is nonsense.
                sample.wrench = Wrench {
                    force: Vector3::new(0.0, 0.0, force),
                    moment: Vector3::new(0.0, -0.1 * force, 0.0),
                };
                sample.deflection = Deflection {
                    translation: Vector3::new(0.0, 0.0, force * 3.3333333333e-6),
                    rotation: Vector3::new(0.0, -0.1 * force * 2.4933303e-3, 0.0),
                };
                match output {
                    SensorOutput::Deflection => sample.wrench.force.y = 1e3,
                    SensorOutput::Force => {
                        sample.deflection.translation.y = 1e-3;
                        sample.flags.wrench_measured = true;
                    }
                }
            }
            controller.cycle(&Heard::complete(&state(tick, start), &deflections, None))
        };
        (0..=500).step_by(4).map(cycle).collect()
    };
    let (deflections, forces) = (run(SensorOutput::Deflection), run(SensorOutput::Force));
    for (of_deflections, of_forces) in deflections.iter().zip(&forces) {
        let difference = of_deflections.command.axis_position[0] - of_forces.command.axis_position[0];
        assert!(difference.norm() < 1e-12, "{difference}");
        let (one, other) = (&of_deflections.status, &of_forces.status);
        assert_eq!((one.phase, one.object_known), (other.phase, other.object_known));
        assert!((one.object_pose.translation.vector - other.object_pose.translation.vector).norm() < 1e-12);
        assert!((one.force_error_n - other.force_error_n).abs() < 1e-8);
    }
    // Without the exact rotation 10 N; with it 0.5 um more.
    let last = forces[forces.len() - 1].status;
    assert!(last.object_known && last.force_error_n.abs() < 0.03, "{last:?}");
    assert!((last.wrench.force.z - 10.0).abs() < 1e-6 && last.wrench.moment.norm() < 1e-6);
}

/// An approach towards an object that a non-contact sensor is to show begins once it has been seen.
#[test]
fn the_approach_waits_for_the_object_to_be_seen() {
    let mut scenario = weightless();
    scenario.controller.expected.from = scenario::ExpectedFrom::ObjectSensor;
    scenario.controller.expected.object_motion = scenario::ObjectMotion::Fixed;
    let axes = scenario.start_axes().unwrap();
    let mut controller = Controller::new(&scenario);
    let seen = |tick: i64| ObjectPose {
        stamp: Stamp::lockstep(tick, 1, Role::Sensor),
        visible: tick >= 400,
        pose: spatial::Pose::translation(0.0, 0.0, 0.01),
        velocity: Vector3::zeros(),
        angular_velocity: Vector3::zeros(),
        position_sigma_m: 50e-6,
    };
    for tick in (0..=600).step_by(4) {
        let pose = (tick % 8 == 0).then(|| seen(tick));
        let status = controller
            .cycle(&Heard::complete(
                &state(tick, axes),
                &undeflected(tick),
                pose.as_ref(),
            ))
            .status;
        let expected = match tick {
            ..200 => ControllerPhase::Sync,
            200..400 => ControllerPhase::Ready,
            _ => ControllerPhase::Approach,
        };
        assert_eq!(status.phase, expected, "tick {tick}");
    }
}
