//! Robot meets object, whatever the object does: a link that moves down as prescribed presses the tool on it.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nalgebra::Vector3;
use node::scenario::{Object, ObjectSensor, Scenario, Sensor, Tool, ToolShape};
use sensor_sim::{Outputs, SensorSim};
use spatial::ports::{LinkMotion, Role, Stamp, Truth};
use spatial::{GRAVITY_M_PER_S2, Motion, Pose, TICK_S, rotation};

/// The tool in line with the sensor, the object's origin in r's.
fn in_line() -> Scenario {
    Scenario {
        tool: Tool {
            centre_of_mass_in_s_m: [0.0, 0.0, -0.06],
            tcp_in_s_m: [0.0, 0.0, -0.15],
            ..Default::default()
        },
        object: Object {
            height_m: 0.0,
            ..Default::default()
        },
        ..Default::default()
    }
}

/// The link at `tick` on its way from `start` (m) down by `way` (m) within 1 s.
fn lowered(start: &Vector3<f64>, way: f64, tick: i64) -> LinkMotion {
    let s = (tick as f64 * TICK_S).min(1.0);
    let mut motion = Motion::at_rest(Pose::translation(start.x, start.y, start.z));
    motion.pose.translation.vector.z -= way * s * s * s * (10.0 + s * (-15.0 + s * 6.0));
    motion.velocity.z = -way * s * s * (30.0 + s * (-60.0 + s * 30.0));
    motion.acceleration.z = -way * s * (60.0 + s * (-180.0 + s * 120.0));
    LinkMotion {
        stamp: Stamp::lockstep(tick, 1, Role::Robot),
        motion,
        kinetic_energy_j: 0.0,
        elastic_energy_j: 0.0,
        motor_work_j: 0.0,
        dissipated_energy_j: 0.0,
    }
}

/// Lower the link from where the nominal tcp is 1 mm above r's origin (beside it by `aside`, m) by `way` (m) within
/// 1 s, smoothly, then wait for `rest` s. Shows what each tick brings, returns the last.
fn lower(scenario: &Scenario, aside: f64, way: f64, rest: f64, mut see: impl FnMut(&Truth)) -> Outputs {
    let start = Vector3::new(aside, 0.0, 0.001) - Vector3::from(scenario.tool.tcp_in_s_m);
    let at = |tick: i64| lowered(&start, way, tick);
    let mut sensor = SensorSim::new(scenario, &at(0).motion);
    let ticks = ((1.0 + rest) / TICK_S) as i64;
    let mut outputs = None;
    for tick in 0..=ticks {
        let now = sensor.advance(&at(tick));
        see(&now.truth);
        outputs = Some(now);
    }
    outputs.unwrap()
}

/// Where the tool ends.
fn end(scenario: &Scenario, aside: f64, way: f64) -> Truth {
    lower(scenario, aside, way, 0.5, |_| ()).truth
}

#[test]
fn a_face_aligns_itself_and_a_point_does_not() {
    let mut scenario = in_line();
    scenario.object.rotation_rad = [0.0, 0.004, 0.0];
    let normal = rotation::exp(scenario.object.rotation_rad.into()) * Vector3::z();
    for (shape, aligned) in [(ToolShape::Face, true), (ToolShape::Point, false)] {
        scenario.tool.shape = shape;
        let truth = end(&scenario, 0.0, 0.002);
        let left = (truth.tcp_pose.rotation * Vector3::z()).cross(&normal).norm();
        assert!(truth.contact_force.z > 100.0, "{} N", truth.contact_force.z);
        assert_eq!(left < 4e-4, aligned, "{left} rad");
        assert_eq!(left > 2e-3, !aligned, "{left} rad");
    }
}

#[test]
fn friction_drags_along_within_its_cone() {
    let mut scenario = in_line();
    scenario.object.friction = 0.3;
    scenario.object.velocity_m_per_s = [0.02, 0.0, 0.0];
    scenario.sensor.integration_step_s = 1e-5;
    let truth = lower(&scenario, 0.0, 0.0012, 0.5, |truth| {
        let force = truth.contact_force;
        assert!(force.xy().norm() <= 0.3 * force.z * (1.0 + 1e-12));
    })
    .truth;
    let force = truth.contact_force;
    assert!(force.z > 20.0 && force.x > 0.29 * force.z, "{force}");
    assert!(force.y.abs() < 1e-9 && truth.tcp_deflection.translation.x > 0.0);
}

#[test]
fn truth_follows_an_object_that_moves() {
    let mut scenario = in_line();
    scenario.object.velocity_m_per_s[2] = 0.1e-3;
    scenario.object.swing_amplitude_m[2] = 20e-6;
    scenario.object.swing_frequency_hz = 2.0;
    scenario.object.profile_time_s = vec![0.5, 1.0];
    scenario.object.profile_height_m = vec![0.0, 50e-6];
    let truth = lower(&scenario, 0.0, 0.0013, 1.0, |truth| {
        let found = truth.object_height_m - truth.tcp_pose.translation.vector.z;
        assert!((found - truth.indentation_m).abs() < 1e-12);
    })
    .truth;
    // 2 s at 0.1 mm/s, a whole number of periods, the profile's end.
    assert!((truth.object_height_m - 250e-6).abs() < 1e-12);
    assert!(truth.contact_force.z > 10.0);
}

#[test]
fn an_elastic_object_yields_by_what_it_carries() {
    let mut scenario = in_line();
    scenario.object.support_n_per_m = 100e3;
    scenario.object.support_ns_per_m = 200.0;
    let truth = lower(&scenario, 0.0, 0.0016, 2.0, |_| ()).truth;
    let (force, height) = (truth.contact_force.z, truth.object_height_m);
    assert!(force > 20.0);
    assert!(
        (height + force / 100e3).abs() < 1e-8,
        "{height} m under {force} N"
    );
}

/// The paper's introduction: an error of position is corrected by a chamfer through the sensor's compliance.
#[test]
fn a_chamfer_centres_a_peg_and_without_it_the_peg_stays_out() {
    let mut scenario = in_line();
    scenario.tool.shape = ToolShape::Peg;
    scenario.object.hole_radius_m = 0.0101;
    scenario.object.hole_chamfer_m = 0.002;
    for friction in [0.0, 0.05] {
        scenario.object.friction = friction;
        scenario.sensor.integration_step_s = if friction == 0.0 { 2e-5 } else { 1e-5 };
        let tcp = end(&scenario, 0.001, 0.011).tcp_pose.translation.vector;
        assert!(tcp.z < -0.009 && tcp.xy().norm() < 0.15e-3, "{tcp}");
    }
    scenario.object.hole_chamfer_m = 0.0;
    let truth = end(&scenario, 0.001, 0.0025);
    assert!(truth.tcp_pose.translation.vector.z > -1e-3 && truth.contact_force.z > 100.0);
}

#[test]
fn an_end_stop_stiffens_the_sensor() {
    let mut scenario = in_line();
    scenario.sensor = Sensor {
        end_stop_m: 0.5e-3,
        end_stop_n_per_m: 3e6,
        ..Default::default()
    };
    let truth = end(&scenario, 0.0, 0.002);
    let p = truth.tcp_deflection.translation.z;
    let expected = 300e3 * p + 3e6 * (p - 0.5e-3) + 4.0 * GRAVITY_M_PER_S2;
    assert!((0.8e-3..1e-3).contains(&p), "{p} m");
    let force = truth.contact_force.z;
    assert!((force / expected - 1.0).abs() < 2e-3, "{force} N at {p} m");
}

#[test]
fn a_measured_wrench_is_the_load_on_the_sensor() {
    let mut scenario = in_line();
    scenario.sensor.wrench_measured = true;
    scenario.sensor.noise_force_n = 0.0;
    scenario.sensor.noise_moment_nm = 0.0;
    for way in [0.0, 0.0014] {
        let Outputs {
            truth, deflections, ..
        } = lower(&scenario, 0.0, way, 2.0, |_| ());
        let sample = deflections.samples[0];
        assert!(sample.flags.wrench_measured);
        let load = truth.contact_force.z - 4.0 * GRAVITY_M_PER_S2;
        assert!(
            (sample.wrench.force.z - load).abs() < 0.02,
            "{} N of {load} N",
            sample.wrench.force.z
        );
        assert!(sample.wrench.force.xy().norm() < 1e-9 && sample.wrench.moment.norm() < 1e-9);
    }
}

#[test]
fn a_non_contact_sensor_sees_the_surface_yield_and_changes_nothing_else() {
    let mut scenario = in_line();
    scenario.object.support_n_per_m = 200e3;
    scenario.object.support_ns_per_m = 200.0;
    let blind = lower(&scenario, 0.0, 0.002, 0.5, |_| ());
    scenario.object_sensor = ObjectSensor {
        enabled: true,
        period_ticks: 4,
        delay_ticks: 0,
        noise_m: 0.0,
        quantum_m: 0.0,
        ..Default::default()
    };
    let seeing = lower(&scenario, 0.0, 0.002, 0.5, |_| ());
    let pose = seeing.object_pose.unwrap();
    assert!(pose.visible && seeing.truth.object_height_m < -1e-4);
    assert_eq!(pose.pose.translation.z, seeing.truth.object_height_m);
    let without = Outputs {
        object_pose: None,
        ..seeing
    };
    assert_eq!(without, blind);
}

/// Who joins while the tool presses finds it pressing as it did, at rest; in the air it hangs at rest.
#[test]
fn a_sensor_that_joins_finds_the_tool_in_balance() {
    let scenario = in_line();
    let start = Vector3::new(0.0, 0.0, 0.001) - Vector3::from(scenario.tool.tcp_in_s_m);
    for (way, pressed) in [(0.0013, true), (0.0005, false)] {
        let before = lower(&scenario, 0.0, way, 0.5, |_| ()).truth;
        let mut sensor = SensorSim::joining(&scenario, &lowered(&start, way, 1500));
        let mut peak_n: f64 = 0.0;
        for tick in 1500..1600 {
            let truth = sensor.advance(&lowered(&start, way, tick)).truth;
            peak_n = peak_n.max(truth.contact_force_peak_n);
            let error = (truth.contact_force - before.contact_force).norm();
            assert!(
                error < 0.01 * before.contact_force.norm() + 1e-9,
                "{tick}: {error} N"
            );
            assert!(
                truth.tcp_velocity.norm() < 1e-6,
                "{tick}: {} m/s",
                truth.tcp_velocity
            );
        }
        assert_eq!(before.contact_force.z > 1.0, pressed);
        assert!(peak_n < 1.01 * before.contact_force.norm() + 1e-9, "{peak_n} N");
    }
}
