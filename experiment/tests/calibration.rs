//! What a calibration learns, against the plant that it can't see.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use controller::calibration::{Calibration, Estimate, KnownTool, Rest, calibrate};
use experiment::calibrate::{self, CalibrateError};
use experiment::scenarios::Source;
use experiment::transcript;
use nalgebra::Vector3;
use node::scenario::Scenario;
use robot_sim::RobotSim;
use sensor_sim::SensorSim;
use spatial::ports::LinkMotion;
use spatial::{Motion, Pose, rotation};

/// The tool hanging at rest in sensor-sim, on a link that is turned by `tilt`, through an ideal signal chain.
fn hanging(scenario: &Scenario, tilt: Vector3<f64>) -> Rest {
    let r_from_s = Pose::from_parts(Vector3::new(0.0, 0.0, 1.0).into(), rotation::exp(tilt));
    let motion = Motion::at_rest(r_from_s);
    let link = LinkMotion {
        motion,
        ..RobotSim::new(scenario).link_motion()
    };
    let sample = SensorSim::new(scenario, &motion)
        .advance(&link)
        .deflections
        .samples[0];
    Rest {
        r_from_s: r_from_s.rotation,
        deflection: sample.deflection,
        wrench: sample.flags.wrench_measured.then_some(sample.wrench),
    }
}

/// Another sensor under another tool than assumed, with a large sag, seven rests; exact but for rounding.
#[test]
fn the_plants_own_balance_is_explained_exactly() {
    for (mass, stiffness, centre) in [
        (4.0, [300e3, 401.07], [0.03, 0.0, -0.06]),
        (0.8, [50e3, 30.0], [-0.02, 0.05, 0.03]),
        (12.0, [400e3, 150.0], [0.0, -0.04, -0.1]),
    ] {
        let mut scenario = Scenario::default();
        let sensor = &mut scenario.sensor;
        [sensor.stiffness_n_per_m, sensor.stiffness_nm_per_rad] = stiffness;
        sensor.wrench_measured = true;
        sensor.delay_ticks = 0;
        (sensor.range_translation_m, sensor.range_rotation_rad) = (0.1, 1.0);
        (sensor.noise_translation_m, sensor.noise_rotation_rad) = (0.0, 0.0);
        (sensor.noise_force_n, sensor.noise_moment_nm) = (0.0, 0.0);
        (sensor.quantum_translation_m, sensor.quantum_rotation_rad) = (0.0, 0.0);
        scenario.tool.mass_kg = mass;
        scenario.tool.centre_of_mass_in_s_m = centre;
        let tilts = [
            (0.0, 0.0),
            (0.3, 0.0),
            (0.2, 0.2),
            (0.0, 0.3),
            (-0.3, 0.0),
            (-0.2, -0.2),
            (0.0, -0.3),
        ];
        let rests = tilts.map(|(x, y)| hanging(&scenario, Vector3::new(x, y, 0.1)));
        let found = calibrate(&rests, &KnownTool::default()).unwrap();
        let tool = found.tool.unwrap();
        let c_phi = found.compliance_rad_per_nm.unwrap().value;
        assert!((tool.mass_kg.value - mass).abs() < 1e-9 * mass, "{tool:?}");
        assert!(
            (tool.centre_of_mass_in_s_m.value - Vector3::from(centre)).norm() < 1e-9,
            "{tool:?}"
        );
        assert!((found.compliance_m_per_n.value * stiffness[0] - 1.0).abs() < 1e-9);
        assert!((c_phi * stiffness[1] - 1.0).abs() < 1e-9, "{c_phi}");
        let biases = [found.translation_bias_m.value, found.rotation_bias_rad.value];
        assert!(biases.iter().all(|bias| bias.norm() < 1e-11), "{biases:?}");
    }
}

/// The calibration of the scenario `name` with `settings`, in process.
fn run(name: &str, settings: &[&str]) -> (Scenario, Result<Calibration, CalibrateError>) {
    let source = Source::find(name).unwrap();
    let settings: Vec<String> = settings.iter().map(|&text| text.to_owned()).collect();
    let overrides = calibrate::overrides(&settings, |overrides| source.scenario(overrides)).unwrap();
    let scenario = source.scenario(&overrides).unwrap();
    calibrate::check(&scenario).unwrap();
    let entries = transcript::in_process(&scenario).unwrap();
    let found = calibrate::from_transcript(&scenario, &entries);
    (scenario, found)
}

/// What was found of a scalar is its real value within `relative` and five standard deviations.
#[track_caller]
fn assert_found(estimate: Estimate<f64>, truth: f64, relative: f64) {
    let error = (estimate.value - truth).abs();
    assert!(
        error < relative * truth && error < 5.0 * estimate.sigma,
        "{estimate:?}, not {truth}"
    );
}

/// Sensor and tool are not what the controller assumes; noise, quantisation, low pass and delay are those of the
/// reference sensor; nothing is told of the truth.
const UNLIKE: [&str; 5] = [
    "sensor.stiffness_n_per_m=200e3",
    "sensor.stiffness_nm_per_rad=250",
    "tool.mass_kg=5",
    "tool.centre_of_mass_in_s_m=[0.02, -0.03, -0.08]",
    "task.calibration_rest_s=0.6",
];

#[test]
fn gantry_and_arm_learn_all_with_a_measured_wrench() {
    for (robot, gears) in [("paper", "rigid"), ("arm", "elastic")] {
        let gears = format!("robot.gears={gears}");
        let settings = [&UNLIKE[..], &["sensor.wrench_measured=true", &gears]].concat();
        let (_, found) = run(robot, &settings);
        let found = found.unwrap();
        let tool = found.tool.unwrap();
        assert_found(tool.mass_kg, 5.0, 2e-3);
        assert_found(found.compliance_m_per_n, 1.0 / 200e3, 5e-3);
        assert_found(found.compliance_rad_per_nm.unwrap(), 1.0 / 250.0, 5e-3);
        let centre = tool.centre_of_mass_in_s_m.value - Vector3::new(0.02, -0.03, -0.08);
        assert!(centre.norm() < 2e-4, "{centre} m off");
        assert!(tool.force_bias_n.value.norm() < 0.1 && tool.moment_bias_nm.value.norm() < 5e-3);
    }
}

#[test]
fn without_a_wrench_a_known_tool_gives_the_compliances() {
    let known = [
        "controller.tool_mass_kg=5",
        "controller.tool_centre_of_mass_in_s_m=[0.02, -0.03, -0.08]",
    ];
    let (_, found) = run("paper", &[&UNLIKE[..], &known].concat());
    let found = found.unwrap();
    assert_eq!(found.tool, None);
    assert_found(found.compliance_m_per_n, 1.0 / 200e3, 5e-3);
    assert_found(found.compliance_rad_per_nm.unwrap(), 1.0 / 250.0, 5e-3);
}

#[test]
fn what_a_run_does_not_tell_is_named() {
    let quick = ["task.calibration_rest_s=0.1", "task.approach_speed_m_per_s=0.1"];
    let error = |more: &[&str]| run("paper", &[&quick, more].concat()).1.unwrap_err().to_string();
    assert!(error(&["controller.tool_mass_kg=0"]).ends_with("set controller.tool_mass_kg"),);
    let short = error(&["timing.duration_s=3"]);
    assert!(
        short.starts_with(
            "the run ended before the last of 7 rests was over, after 3 s; raise timing.duration_s to "
        ),
        "{short}"
    );
    assert_eq!(
        error(&["sensor.range_rotation_rad=0.0034"]),
        "the sensor was at the end of its range in rest 5; lower task.calibration_tilt_rad, or use a stiffer sensor or \
         a lighter tool"
    );
    assert_eq!(
        error(&["sensor.dropout_start_s=0.3", "sensor.dropout_duration_s=0.3"]),
        "controller latched SensorStale at tick 328; the sensor was silent for longer than controller.stale_fault_s"
    );
    let missing = run(
        "paper",
        &[&quick[..], &["controller.tool_centre_of_mass_in_s_m=[0, 0, 0]"]].concat(),
    );
    assert_eq!(
        missing.1.unwrap().compliance_rad_per_nm.unwrap_err().to_string(),
        "no wrench is measured, so that the tool's centre of mass must be known to learn the rotational compliance; \
         set controller.tool_centre_of_mass_in_s_m"
    );
}

#[test]
fn a_tilt_beyond_the_axes_is_refused_before_the_run() {
    let scenario = Source::find("paper")
        .unwrap()
        .scenario(&[
            "task.calibration_tilt_rad=0.9".to_owned(),
            "robot.gantry.axis_maximum_rad=[1, 1, 1, 0.5, 1.5, 1.5]".to_owned(),
        ])
        .unwrap();
    assert_eq!(
        calibrate::check(&scenario).unwrap_err().to_string(),
        "rest 1 of the calibration puts axis 3 at 0.900 rad, outside -1.5..=0.5 rad; lower task.calibration_tilt_rad or \
         start elsewhere"
    );
}
