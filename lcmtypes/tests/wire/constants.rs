//! The constants of the .lcm files are the discriminants of the enumerations.

use spatial::ports::*;
use std::collections::BTreeMap;
use std::fs;

type Constants = BTreeMap<String, i64>;

/// The constants with a prefix that lcm-gen wrote into a type's header.
fn of_header(type_name: &str, prefix: &str) -> Constants {
    let header = format!("{}/touchdown_{type_name}.h", env!("OUT_DIR"));
    let header = fs::read_to_string(header).expect("the build script generates it");
    let start = format!("#define TOUCHDOWN_{}_{prefix}_", type_name.to_uppercase());
    let lines = header
        .lines()
        .filter_map(|line| line.strip_prefix(&start)?.split_once(' '));
    lines
        .map(|(name, value)| (name.to_owned(), value.parse().expect("a number")))
        .collect()
}

/// `LockstepBroken` -> `LOCKSTEP_BROKEN`.
fn shout(name: &str) -> String {
    let mut words = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push('_');
        }
        words.push(letter.to_ascii_uppercase());
    }
    words
}

macro_rules! enumeration {
    ($name:ident) => {
        $name::ALL
            .iter()
            .map(|value| (shout(value.name()), value.code().into()))
            .collect::<Constants>()
    };
}

#[test]
fn constants_are_discriminants() {
    for (type_name, prefix, expected) in [
        ("robot_state_t", "MODE", enumeration!(RobotMode)),
        ("controller_status_t", "PHASE", enumeration!(ControllerPhase)),
        ("controller_status_t", "LAW", enumeration!(Law)),
        ("controller_status_t", "ANSWER", enumeration!(ParameterAnswer)),
        ("node_status_t", "STATE", enumeration!(NodeState)),
        ("node_status_t", "FAULT", enumeration!(Fault)),
        ("node_status_t", "ROLE", enumeration!(Role)),
        ("task_t", "ACTION", enumeration!(TaskAction)),
    ] {
        assert_eq!(
            of_header(type_name, prefix),
            expected,
            "{prefix}_* of {type_name}.lcm"
        );
    }
}

#[test]
fn parameters_are_numbered_as_their_mask_bits() {
    let bits = (0..)
        .zip(TaskParameters::NAMES)
        .map(|(bit, name)| (name.to_uppercase(), bit));
    assert_eq!(of_header("task_t", "PARAMETER"), bits.collect());
}

#[test]
fn flags_are_the_bits_of_a_sample() {
    let none = SampleFlags::default();
    let flags = [
        ("VALID", SampleFlags { valid: true, ..none }),
        (
            "SATURATED",
            SampleFlags {
                saturated: true,
                ..none
            },
        ),
        (
            "WRENCH",
            SampleFlags {
                wrench_measured: true,
                ..none
            },
        ),
    ];
    let bits = flags.map(|(name, flags)| (name.to_owned(), flags.bits().into()));
    assert_eq!(of_header("sensor_deflection_t", "FLAG"), bits.into());
}

#[test]
fn the_protocol_is_the_contract() {
    let header = fs::read_to_string(concat!(env!("OUT_DIR"), "/touchdown_node_status_t.h")).unwrap();
    let line = format!("#define TOUCHDOWN_NODE_STATUS_T_PROTOCOL {PROTOCOL}");
    assert!(header.lines().any(|found| found == line), "no \"{line}\"");
}
