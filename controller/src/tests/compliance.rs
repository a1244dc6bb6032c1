//! The compliance as it is known, and the calibration's way, of a controller on a robot that does as the test says.

use super::*;

/// The last status of a controller whose sensor is `factor` times as compliant as assumed, under its tool's weight and,
/// from 0.4 s on, 10 N at the tcp. What of the wrench is measured, `flag` says by the tick.
fn pressed(factor: f64, output: SensorOutput, flag: impl Fn(i64) -> SampleFlags) -> ControllerStatus {
    let mut scenario = weightless();
    scenario.controller.sensor_output = output;
    scenario.controller.adaptation.enabled = true;
    let real = Compliance::isotropic(factor / 300e3, factor / 401.07);
    let wrench = |tick: i64| {
        let force = if tick >= 400 { 10.0 } else { 0.0 };
        // 3 N of bias and 4 kg at c = (0.03, 0, -0.06) m; 10 N at d = (0.10, 0, -0.15) m.
        Wrench {
            force: Vector3::new(3.0, 0.0, force - 39.2),
            moment: Vector3::new(0.0, 1.18 - 0.10 * force, 0.0),
        }
    };
    let mut controller = Controller::new(&scenario);
    let axes = scenario.start_axes().unwrap();
    let mut status = None;
    for tick in (0..=1200).step_by(4) {
        let mut deflections = sensed(tick, 0, |sampled| real * wrench(sampled));
        for sample in &mut deflections.samples {
            let sampled = sample.utime / TICK_US;
            sample.wrench = wrench(sampled);
            sample.flags = SampleFlags {
                valid: sampled >= 0,
                ..flag(sampled)
            };
        }
        status = Some(
            controller
                .cycle(&Heard::complete(&state(tick, axes), &deflections, None))
                .status,
        );
    }
    status.unwrap()
}

fn measured(_: i64) -> SampleFlags {
    SampleFlags {
        wrench_measured: true,
        ..SampleFlags::default()
    }
}

/// In both modes; the weight and the biases are in deflection and wrench alike and drop out with their tares.
#[test]
fn what_is_published_is_what_was_learnt() {
    for output in [SensorOutput::Deflection, SensorOutput::Force] {
        for factor in [0.5, 2.0] {
            let status = pressed(factor, output, measured);
            let found = status.compliance.rotation[(2, 2)] * 401.07;
            assert!(
                (found - factor).abs() < 1e-5 * factor,
                "{output:?}: {found}, not {factor}"
            );
            assert!(
                status.compliance_confidence > 0.99,
                "{}",
                status.compliance_confidence
            );
            // The published wrench is that at the tcp, with the compliance learnt.
            assert!(
                (status.wrench.force - Vector3::new(0.0, 0.0, 10.0)).norm() < 1e-3,
                "{:?}",
                status.wrench
            );
        }
    }
}

/// A wrench that is not flagged as measured was computed from the deflection; a saturated sample tells nothing either.
#[test]
fn only_a_measured_wrench_counts() {
    let computed = |_| SampleFlags::default();
    let saturated = |tick| SampleFlags {
        saturated: true,
        ..measured(tick)
    };
    let configured = pressed(1.0, SensorOutput::Deflection, computed).compliance;
    for status in [
        pressed(2.0, SensorOutput::Deflection, computed),
        pressed(2.0, SensorOutput::Deflection, saturated),
    ] {
        assert_eq!(
            (status.compliance, status.compliance_confidence),
            (configured, 0.0)
        );
    }
}

/// With an assumed compliance of 0.4 times the real one the noise looks 2.5 times as strong: the threshold follows.
#[test]
fn the_threshold_is_above_the_noise() {
    let threshold = |noise_m: f64| {
        let scenario = weightless();
        let mut controller = Controller::new(&scenario);
        let axes = scenario.start_axes().unwrap();
        // Up and down, with this standard deviation.
        let noise = |tick: i64| lifted(if tick % 2 == 0 { noise_m } else { -noise_m });
        let mut status = None;
        for tick in (0..=240).step_by(4) {
            let deflections = sensed(tick, 0, noise);
            status = Some(
                controller
                    .cycle(&Heard::complete(&state(tick, axes), &deflections, None))
                    .status,
            );
        }
        status.unwrap().detection.threshold_n
    };
    assert!((threshold(2e-6) - 0.82).abs() < 1e-6);
    // 28.27 um/N.
    let found = threshold(20e-6);
    assert!((found - 4.5 * 20.0 / 28.27).abs() < 0.02, "{found} N");
}

/// Level, six tilts and back; the index of the rest is published while it is measured, and only then.
#[test]
fn a_calibration_goes_through_its_rests_and_comes_back() {
    let mut scenario = weightless();
    scenario.task.kind = TaskKind::Calibrate;
    scenario.task.calibration_rest_s = 0.2;
    scenario.task.approach_speed_m_per_s = 0.1;
    let mut controller = Controller::new(&scenario);
    let start = scenario.start_axes().unwrap();
    let (mut axes, mut seen) = (start, Vec::new());
    let mut tick = 0;
    let last = loop {
        let Outputs { command, status } =
            controller.cycle(&Heard::complete(&state(tick, axes), &undeflected(tick), None));
        assert_eq!((status.fault, status.limits), (Fault::None, 0));
        if seen.last() != Some(&status.program_step) {
            seen.push(status.program_step);
        }
        axes = command.axis_position[0];
        tick += 4;
        if tick > 300 && status.phase == ControllerPhase::Ready {
            break status;
        }
        assert!(tick < 20_000);
    };
    assert_eq!(seen, [-1, 0, -1, 1, -1, 2, -1, 3, -1, 4, -1, 5, -1, 6, -1]);
    assert_eq!(last.program_step, -1);
    assert!((axes - start).norm() < 1e-9);
}
