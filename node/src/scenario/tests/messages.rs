//! Each kind of refusal, word for word.

use super::refusal;
use crate::scenario::{Scenario, schema::Entry};

const SECTIONS: &str = "[timing], [network], [robot], [robot.gantry], [robot.arm], [sensor], [tool], [object], [object_sensor], \
                         [task], [task.force_controlled], [program], [controller], [controller.pd], [controller.proposed], \
                         [controller.impedance], [controller.ros2], [controller.fzi], [controller.expected], [controller.servo], \
                         [controller.gears], [controller.elastic], [controller.shaping], [controller.adaptation], \
                         [controller.impact], [controller.cusum], [controller.collision], [controller.oscillation], [controller.limits]";

const OBJECT_KEYS: &str = "height_m, indentation_n_per_m, rebound_ratio, exponent, friction, friction_speed_m_per_s, origin_m, \
                           rotation_rad, velocity_m_per_s, swing_amplitude_m, swing_frequency_hz, swing_phase_rad, \
                           profile_time_s, profile_height_m, support_n_per_m, support_ns_per_m, support_mass_kg, hole_radius_m, \
                           hole_chamfer_m, hole_depth_m";

#[test]
fn a_missing_file() {
    let error = Scenario::load("missing.toml".as_ref(), &[]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "missing.toml: the scenario can't be read: No such file or directory (os error 2); name an existing file, \
         such as experiment/scenarios/paper.toml"
    );
}

#[test]
fn text_that_is_not_toml() {
    assert_eq!(
        refusal("[robot]\nfilter_damping = 4x\ngears = \"rigid", &[]),
        "a.toml:2:18: not valid TOML at \"4x\": string values must be quoted, expected literal string\n\
         a.toml:3:15: not valid TOML at the end of the line: invalid basic string, expected `\"`"
    );
    assert_eq!(
        refusal("robot.gears = 'rigid'\nrobot.gears = 'rigid'", &[]),
        "a.toml:2:7: not valid TOML at \"gears\": duplicate key"
    );
}

#[test]
fn names_that_do_not_exist() {
    assert_eq!(
        refusal("[object]\nheigth_m = 0.0", &[]),
        format!(
            "a.toml:2:1: unknown key object.heigth_m; [object] knows {OBJECT_KEYS}; did you mean object.height_m?"
        )
    );
    assert_eq!(
        refusal("[object]\nlaw = 'pd'\n'height_m ' = 0", &[]),
        format!(
            "a.toml:2:1: unknown key object.law; [object] knows {OBJECT_KEYS}; did you mean controller.law?\n\
             a.toml:3:1: unknown key object.\"height_m \"; [object] knows {OBJECT_KEYS}"
        )
    );
    assert_eq!(
        refusal("mode = 'lockstep'", &[]),
        format!(
            "a.toml:1:1: unknown key mode; a scenario has the sections {SECTIONS}; did you mean timing.mode?"
        )
    );
    assert_eq!(
        refusal("[sensors]", &[]),
        format!("a.toml:1:2: unknown section [sensors]; a scenario has {SECTIONS}; did you mean [sensor]?")
    );
    assert_eq!(
        refusal("[controller.pid]\n[controller.ros]", &[]),
        format!(
            "a.toml:1:13: unknown section [controller.pid]; a scenario has {SECTIONS}; did you mean [controller.pd]?\n\
             a.toml:2:13: unknown section [controller.ros]; a scenario has {SECTIONS}; did you mean [controller.ros2]?"
        )
    );
    assert_eq!(
        refusal("robot = 4", &[]),
        "a.toml:1:1: robot is 4, not a section; write [robot] and its keys on the lines below"
    );
}

#[test]
fn values_of_the_wrong_type() {
    assert_eq!(
        refusal(
            "[robot]\nfilter_frequency_hz = 'fast'\ncommand_delay_periods = 2.5\ngears = true",
            &[]
        ),
        "a.toml:2:23: robot.filter_frequency_hz is \"fast\", not a finite number; choose a value in 0.1..=200 Hz\n\
         a.toml:3:25: robot.command_delay_periods is 2.5, not an integer; choose a value in 0..=10 periods\n\
         a.toml:4:9: robot.gears is true, not a word; choose \"rigid\" or \"elastic\""
    );
    assert_eq!(
        refusal("[tool]\ntcp_in_s_m = 0.1\ninertia_kg_m2 = [1, 2]", &[]),
        "a.toml:2:14: tool.tcp_in_s_m is 0.1, not an array of numbers; choose 3 values in -5..=5 m\n\
         a.toml:3:17: tool.inertia_kg_m2 has 2 values instead of 3; list 3 numbers in 1e-7..=100000 kg m^2"
    );
    assert_eq!(
        refusal(
            "object.profile_time_s = [0, 'a']\nobject.profile_height_m = 1",
            &[]
        ),
        "a.toml:1:29: object.profile_time_s[1] is \"a\", not a finite number; choose a value in 0..=86400 s\n\
         a.toml:2:27: object.profile_height_m is 1, not an array of numbers; choose values in -1..=1 m"
    );
    let mut flag = false;
    let text = toml::de::DeValue::parse("true").unwrap();
    assert_eq!((flag.slot(()).put("a.b", &text), flag), (Ok(()), true));
    let misfits = flag
        .slot(())
        .put("a.b", &toml::de::DeValue::parse("1").unwrap())
        .unwrap_err();
    assert_eq!(
        misfits[0].1.to_string(),
        "a.b is 1, not a truth value; choose true or false"
    );
}

#[test]
fn values_out_of_range() {
    assert_eq!(
        refusal(
            "[robot]\nfilter_frequency_hz = 1500.0\ngantry.motor_inertia_kg_m2 = [1, 1, -1, 1, 1, nan]",
            &[]
        ),
        "a.toml:2:23: robot.filter_frequency_hz is 1500 Hz, above the limit of 200 Hz; choose a value in \
         0.1..=200 Hz\n\
         a.toml:3:37: robot.gantry.motor_inertia_kg_m2[2] is -1 kg m^2, below the limit of 0.001 kg m^2; choose a value \
         in 0.001..=10000 kg m^2\n\
         a.toml:3:47: robot.gantry.motor_inertia_kg_m2[5] is nan, not a finite number; choose a value in \
         0.001..=10000 kg m^2"
    );
    assert_eq!(
        refusal(
            "timing.seed = 99999999999999999999\ntool.mass_kg = -inf\ntask.desired_force_n = 1e999",
            &[]
        ),
        "a.toml:1:15: timing.seed is 99999999999999999999, above the limit of 9223372036854775807; choose a value \
         in 0..=9223372036854775807\n\
         a.toml:2:16: tool.mass_kg is -inf, not a finite number; choose a value in 0.001..=10000 kg\n\
         a.toml:3:24: task.desired_force_n is 1e999, not a finite number; choose a value in 0.1..=100000 N"
    );
}

#[test]
fn words_that_are_unknown() {
    assert_eq!(
        refusal("timing.mode = 'lokstep'\ncontroller.law = 'magic'", &[]),
        "a.toml:1:15: timing.mode is the unknown word \"lokstep\"; choose \"lockstep\" or \"realtime\"; did you \
         mean \"lockstep\"?\n\
         a.toml:2:18: controller.law is the unknown word \"magic\"; choose \"pd\" or \"pd-reset\" or \"literal\" or \"proposed\" or \
         \"impedance\" or \"elastic\" or \"ros2\" or \"fzi\""
    );
}

#[test]
fn overrides() {
    assert_eq!(
        refusal(
            "",
            &[
                "controller.law=dp",
                "timing.seed=-1",
                "timing.seed",
                "=3",
                "timing.seed=",
                "tool.mass_kg=1 kg"
            ]
        ),
        "--set controller.law=dp: controller.law is the unknown word \"dp\"; choose \"pd\" or \"pd-reset\" or \"literal\" or \"proposed\" or \
         \"impedance\" or \"elastic\" or \"ros2\" or \"fzi\"\n\
         --set timing.seed=-1: timing.seed is -1, below the limit of 0; choose a value in 0..=9223372036854775807\n\
         --set timing.seed: not an assignment; write --set section.key=value\n\
         --set =3: not an assignment; write --set section.key=value\n\
         --set timing.seed=: not an assignment; write --set section.key=value\n\
         --set tool.mass_kg=1 kg: not valid TOML at \"1 kg\": string values must be quoted, expected literal string"
    );
}

#[test]
fn problems_are_listed_in_the_order_of_the_file_up_to_a_limit() {
    let text: String = (0..30).map(|i| format!("key_{} = {i}\n", 29 - i)).collect();
    let message = refusal(&text, &["law=pd"]);
    let lines: Vec<_> = message.lines().collect();
    assert_eq!(lines.len(), 21);
    for (i, line) in lines[..20].iter().enumerate() {
        assert!(
            line.starts_with(&format!("a.toml:{}:1: unknown key key_{};", i + 1, 29 - i)),
            "{line}"
        );
    }
    assert_eq!(lines[20], "and 11 more problems");
}
