//! Values that can't be together, word for word.

use super::refusal;
use crate::scenario::Scenario;

#[test]
fn the_tare_is_within_the_standstill() {
    assert_eq!(
        refusal("[task]\nstandstill_s = 0.1", &[]),
        "a.toml:2:1: controller.tare_s is 0.2 s, longer than task.standstill_s, 0.1 s; tare within the standstill"
    );
}

#[test]
fn a_conflict_is_reported_where_its_first_key_was_given_last() {
    assert_eq!(
        refusal(
            "[task]\nstandstill_s = 0.1\n[controller]\ntare_s = 0.3",
            &["controller.tare_s=0.4"]
        ),
        "--set controller.tare_s=0.4: controller.tare_s is 0.4 s, longer than task.standstill_s, 0.1 s; tare \
         within the standstill"
    );
}

#[test]
fn the_approach_is_within_the_robots_speed() {
    assert_eq!(
        refusal(
            "task.approach_speed_m_per_s = 1\nrobot.gantry.velocity_limit_rad_per_s = [1, 1, 0.5, 1, 1, 1]",
            &[]
        ),
        "a.toml:1:6: task.approach_speed_m_per_s is 1 m/s and turns axis 2 with 1 rad/s, above \
         robot.gantry.velocity_limit_rad_per_s[2], 0.5 rad/s; approach more slowly"
    );
}

#[test]
fn the_free_motion_is_within_what_the_axes_are_assumed_to_attain() {
    assert_eq!(
        refusal("controller.shaping.acceleration_m_per_s2 = 6", &[]),
        "a.toml:1:20: controller.shaping.acceleration_m_per_s2 is 6 m/s^2 and accelerates axis 2 with 6 rad/s^2, above \
         controller.acceleration_limit_rad_per_s2[2], 5 rad/s^2; accelerate less"
    );
}

#[test]
fn the_tool_starts_above_the_search_and_the_object() {
    assert_eq!(
        refusal("task.expected_height_m = 0.04", &[]),
        "a.toml:1:6: task.start_position_m[2] is 0.03 m, not above the end of the search, task.expected_height_m - \
         task.search_depth_m, 0.035 m; start higher or search deeper"
    );
    // 0.4 mm below the start, but the tool sags by that much.
    assert_eq!(
        refusal("object.height_m = 0.0296", &[]),
        "a.toml:1:8: object.height_m is 0.0296 m, not below the hanging tool's tcp at 0.0295758 m; start higher or \
         lower the object"
    );
}

#[test]
fn the_axes_reach_start_and_search() {
    assert_eq!(
        refusal("", &["robot.gantry.axis_minimum_rad=[-1, -1, 1, -1, -1, -1]"]),
        "--set robot.gantry.axis_minimum_rad=[-1, -1, 1, -1, -1, -1]: robot.gantry.axis_minimum_rad[2] is 1 rad, not \
         below robot.gantry.axis_maximum_rad[2], 1 rad; leave the axis room to move"
    );
    assert_eq!(
        refusal(
            "task.start_position_m = [1.2, 0, 0.03]\ntask.search_depth_m = 1\ntool.tcp_in_s_m = [0.1, 0, 0.1]",
            &[]
        ),
        "a.toml:1:6: task.start_position_m puts axis 0 at 1.1 rad, outside robot.gantry.axis_minimum_rad[0] to \
         robot.gantry.axis_maximum_rad[0], -1..=1 rad; start elsewhere or widen the axis\n\
         a.toml:2:6: task.search_depth_m ends the search with axis 2 at -1.1 rad, outside \
         robot.gantry.axis_minimum_rad[2] to robot.gantry.axis_maximum_rad[2], -1..=1 rad; search less deep or widen \
         the axis"
    );
}

#[test]
fn the_arm_reaches_start_and_search_fast_enough() {
    let arm = "robot.kinematics = 'arm'\n";
    let message = refusal(&format!("{arm}task.start_position_m = [1.0, 0, 0.03]"), &[]);
    assert!(
        message.starts_with("a.toml:2:6: task.start_position_m can't be reached: the pose is "),
        "{message}"
    );
    let message = refusal(
        &format!("{arm}robot.arm.axis_maximum_rad = [3, 0.6, 1.9, 6, 2, 6]"),
        &[],
    );
    assert_eq!(
        message,
        "a.toml:2:11: task.start_position_m puts axis 2 at 1.91969 rad, outside robot.arm.axis_minimum_rad[2] to \
         robot.arm.axis_maximum_rad[2], -2.26893..=1.9 rad; start elsewhere or widen the axis"
    );
    let message = refusal(
        &format!("{arm}task.approach_speed_m_per_s = 1"),
        &["robot.arm.velocity_limit_rad_per_s=[1, 1, 1, 1, 1, 1]"],
    );
    assert!(
        message.contains(
            "and turns axis 4 with 1.61648 rad/s, above robot.arm.velocity_limit_rad_per_s[4], 1 rad/s"
        ),
        "{message}"
    );
}

#[test]
fn the_integration_steps_divide_the_tick_and_resolve_the_tool() {
    assert_eq!(
        refusal(
            "robot.integration_step_s = 3e-4\nsensor.smooth_step_s = 3e-5",
            &[]
        ),
        "a.toml:1:7: robot.integration_step_s is 0.0003 s, no whole fraction of the tick of 0.001 s; choose that \
         over a whole number, such as 0.00025 s\n\
         a.toml:2:8: sensor.smooth_step_s is 3e-5 s, no whole fraction of the tick of 0.001 s; choose that over a \
         whole number, such as 2.5e-5 s"
    );
    assert_eq!(
        refusal("sensor.smooth_step_s = 1e-5", &[]),
        "a.toml:1:8: sensor.integration_step_s is 2e-5 s, longer than sensor.smooth_step_s, 1e-5 s, which is halved \
         until it is at most that; choose a shorter one"
    );
    assert_eq!(
        refusal("sensor.integration_step_s = 2e-4", &[]),
        "a.toml:1:8: sensor.integration_step_s is 0.0002 s, too long for a tool that moves at up to 5987.5 rad/s between \
         sensor and object; choose at most 0.000167015 s, a heavier tool, or less stiffness and damping"
    );
}

#[test]
fn the_integration_step_resolves_the_gears() {
    assert_eq!(
        refusal(
            "",
            &[
                "robot.gears=elastic",
                "robot.gantry.gear_frequency_hz=[14, 14, 14, 20, 20, 500]"
            ]
        ),
        "--set robot.gears=elastic: robot.integration_step_s is 0.001 s, too long for gears that swing with up to \
         500 Hz; choose at most 8.91268e-5 s, or softer gears"
    );
    let light = "robot.gantry.motor_inertia_kg_m2=[120, 120, 120, 0.01, 4, 4]";
    assert_eq!(
        refusal("", &["robot.gears=elastic", light]),
        "--set robot.gears=elastic: robot.integration_step_s is 0.001 s, too long for motors that swing against the gantry's \
         links with up to 283.549 Hz; choose at most 0.000785815 s, heavier motors, or softer gears"
    );
}

#[test]
fn the_load_is_within_the_sensors_range() {
    assert_eq!(
        refusal("tool.mass_kg = 100", &[]),
        "a.toml:1:6: the tool, hanging freely or pressing with task.desired_force_n or a step's, 10 N, deflects the sensor by \
         0.00326888 m, not less than sensor.range_translation_m, 0.0015 m; stiffen the sensor, widen its range or \
         load it less\n\
         a.toml:1:6: the tool, hanging freely or pressing with task.desired_force_n or a step's, 10 N, turns the sensor by \
         0.0733537 rad, not less than sensor.range_rotation_rad, 0.02618 rad; stiffen the sensor, widen its range \
         or load it less"
    );
    assert_eq!(
        refusal("", &["task.desired_force_n=150"]),
        "--set task.desired_force_n=150: the tool, hanging freely or pressing with task.desired_force_n or a step's, 150 N, \
         turns the sensor by 0.0344658 rad, not less than sensor.range_rotation_rad, 0.02618 rad; stiffen the \
         sensor, widen its range or load it less"
    );
}

#[test]
fn a_profile_has_increasing_times_and_a_height_for_each() {
    assert_eq!(
        refusal(
            "object.profile_time_s = [0, 1, 1]\nobject.profile_height_m = [0, 0.001]",
            &[]
        ),
        "a.toml:1:8: object.profile_time_s has 3 values, object.profile_height_m 2; list a height for each time\n\
         a.toml:1:8: object.profile_time_s goes from 1 s to 1 s; list increasing times"
    );
}

#[test]
fn friction_and_a_light_surface_need_shorter_steps() {
    let message = refusal("object.friction = 0.5", &[]);
    assert!(
        message.contains("sensor.integration_step_s is 2e-5 s, too long"),
        "{message}"
    );
    let message = refusal(
        "object.support_n_per_m = 1e6\nobject.support_mass_kg = 0.001",
        &[],
    );
    assert!(
        message.contains("sensor.integration_step_s is 2e-5 s, too long"),
        "{message}"
    );
}

#[test]
fn force_output_needs_a_measured_wrench() {
    let force = "[controller]\nsensor_output = 'force'\n";
    let message = refusal(force, &[]);
    assert!(
        message.contains("controller.sensor_output is \"force\", but the sensor measures no wrench; set "),
        "{message}"
    );
    assert!(
        Scenario::parse(
            "a.toml",
            &format!("{force}[sensor]\nwrench_measured = true\n"),
            &[]
        )
        .is_ok()
    );
}

#[test]
fn adaptation_needs_a_measured_wrench() {
    assert_eq!(
        refusal("controller.adaptation.enabled = true", &[]),
        "a.toml:1:23: controller.adaptation.enabled is true, but the sensor measures no wrench, and the compliance \
         can't be learnt from the deflection alone; set sensor.wrench_measured = true or \
         controller.adaptation.enabled = false"
    );
}

#[test]
fn an_object_pose_comes_with_a_cycle_of_the_controller() {
    assert_eq!(
        refusal("[object_sensor]\nenabled = true\nperiod_ticks = 10", &[]),
        "a.toml:3:1: object_sensor.period_ticks is 10 ticks, no multiple of timing.command_period_ticks, 4 ticks; \
         choose a multiple, such as 4 ticks"
    );
    assert!(Scenario::parse("a.toml", "object_sensor.period_ticks = 10", &[]).is_ok());
}

#[test]
fn each_kind_of_task_has_what_it_needs() {
    assert_eq!(
        refusal("[task.force_controlled]\nz = false", &[]),
        "a.toml:2:1: task.kind is \"press\", but task.force_controlled.z is false: nothing would press; set it to true, \
         or task.kind = \"position\""
    );
    assert_eq!(
        refusal("task.kind = \"position\"", &[]),
        "a.toml:1:6: task.kind is \"position\", but task.force_controlled.z is true: the position lies along z; set it \
         to false, or task.kind = \"press\""
    );
    assert_eq!(
        refusal("", &["controller.expected.from=object-sensor"]),
        "--set controller.expected.from=object-sensor: controller.expected.from is \"object-sensor\", but there is none: \
         the approach would never begin; set object_sensor.enabled = true, or expect the object from a \"model\" or \
         \"nothing\""
    );
}

#[test]
fn moments_have_a_degree_of_freedom_and_a_face_that_bears_them() {
    assert_eq!(
        refusal("task.desired_moment_nm = [0, 1, 0]", &[]),
        "a.toml:1:6: task.desired_moment_nm[1] is 1 Nm, but task.force_controlled.about_y is false; set it to true, or \
         the moment to 0"
    );
    assert_eq!(
        refusal(
            "task.desired_moment_nm = [0, 0.5, 0]\ntask.force_controlled.about_y = true\ntool.shape = \"face\"",
            &[]
        ),
        "a.toml:1:6: task.desired_moment_nm[1] is 0.5 Nm, more than the 0.2 Nm that task.desired_force_n bears on the \
         tool's face; choose a smaller moment, a larger face or more force"
    );
}

#[test]
fn a_tolerance_can_be_seen_to_be_exceeded() {
    assert_eq!(
        refusal(
            "task.kind = \"position\"\ntask.force_controlled.z = false\ntask.tolerance_m = 0.002",
            &[]
        ),
        "a.toml:3:6: task.tolerance_m is 0.002 m, not less than sensor.range_translation_m, 0.0015 m: it would never be \
         seen to be exceeded; tolerate less, or widen the range"
    );
}

/// `k / T_i / (k + 1 / T_i)` of 25 1/s and 0.03 s is 14.3 rad/s, 2.3 Hz; the motor is two thirds of the inertia.
#[test]
fn the_assumed_servos_are_stable() {
    let message = refusal("controller.servo.velocity_bandwidth_hz = 3", &[]);
    assert!(
        message.contains(
            "controller.servo.velocity_bandwidth_hz is 3 Hz, too little for axis 0, whose servo would swing up: choose \
             more than 5.11569 Hz, or a smaller position gain"
        ),
        "{message}"
    );
}

#[test]
fn protections_leave_room_for_the_task() {
    assert_eq!(
        refusal("controller.limits.workspace_minimum_m = [-1, -1, 0.04]", &[]),
        "a.toml:1:19: task.start_position_m[2] is 0.03 m, not within controller.limits.workspace_minimum_m[2] to \
         workspace_maximum_m[2], 0.04 to 10 m; start elsewhere or widen the workspace"
    );
    assert_eq!(
        refusal("controller.limits.axis_margin_rad = 0.95", &[]),
        "a.toml:1:19: task.start_position_m puts axis 0 at -0.1 rad, nearer than controller.limits.axis_margin_rad, \
         0.95 rad, to an end of -1..=1 rad; start elsewhere or keep less distance\n\
         a.toml:1:19: task.start_position_m puts axis 2 at 0.18 rad, nearer than controller.limits.axis_margin_rad, \
         0.95 rad, to an end of -1..=1 rad; start elsewhere or keep less distance"
    );
    assert_eq!(
        refusal("task.max_contact_force_n = 10", &[]),
        "a.toml:1:6: task.max_contact_force_n is 10 N, not above task.desired_force_n, 10 N; allow more, or press less"
    );
}

#[test]
fn an_impedance_must_be_damped() {
    let law = "controller.law = 'impedance'\ncontroller.impedance.damping_ns_per_m = ";
    assert_eq!(
        refusal(&format!("{law}100"), &[]),
        "a.toml:2:22: controller.impedance.damping_ns_per_m is 100, a damping ratio of 0.118884 with that mass on the \
         assumed sensor: the tool would swing; choose at least 168.232, or less mass"
    );
    assert!(Scenario::parse("a.toml", &format!("{law}200"), &[]).is_ok());
}

/// With 60 kg m^2 each, a coupling of 70 leaves the second axis 60 - 70^2 / 60.
#[test]
fn coupled_links_are_masses() {
    let mut coupling = [0.0; 15];
    coupling[0] = 70.0;
    assert_eq!(
        refusal(
            &format!("controller.gears.link_coupling_kg_m2 = {coupling:?}"),
            &[]
        ),
        "a.toml:1:18: controller.gears.link_coupling_kg_m2 leaves axis 1 no inertia (-21.6667 kg m^2 of \
         controller.servo.link_inertia_kg_m2[1], 60 kg m^2): couple it less"
    );
}
