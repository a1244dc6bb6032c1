//! What goes out comes in, to the bit; what can't be used is refused and says why.

use crate::draw::{Arbitrary, Counting};
use crate::samples::{Sample, for_all_messages};
use lcmtypes::{DecodeError, Message, Unusable};
use proptest::prelude::*;
use spatial::ports::*;
use std::fmt::Debug;

/// As `Debug` shows it, which tells -0 from 0 and prints every digit.
fn text(message: &impl Debug) -> String {
    format!("{message:?}")
}

fn survives<M: Message + Sample + Debug>(seed: u64) {
    let message = M::sample(&mut Arbitrary(seed));
    let encoded = message.encode().expect("a usable message");
    let decoded = M::decode(encoded.as_bytes()).expect("its own encoding");
    assert_eq!(text(&decoded), text(&message));
    assert_eq!(decoded.encode().as_ref(), Ok(&encoded));
    assert_eq!(decoded.stamp(), message.stamp());
    assert_eq!(encoded.channel(), M::CHANNEL);
}

/// A changed byte is refused, or is part of a message that encodes to just these bytes.
fn one_changed_byte<M: Message + Sample>(seed: u64, place: usize, value: u8) {
    let encoded = M::sample(&mut Arbitrary(seed))
        .encode()
        .expect("a usable message");
    let mut bytes = encoded.as_bytes().to_vec();
    let place = place % bytes.len();
    bytes[place] = value;
    match M::decode(&bytes) {
        Ok(message) => assert_eq!(
            message.encode().expect("decoded messages are checked").as_bytes(),
            bytes
        ),
        Err(error) => assert!(error.to_string().starts_with(M::CHANNEL), "{error}"),
    }
}

proptest! {
    #[test]
    fn every_message_survives_to_the_bit(seed: u64) {
        macro_rules! all { ($($message:ty),*) => { $(survives::<$message>(seed);)* } }
        for_all_messages!(all);
    }

    #[test]
    fn an_encoding_has_one_meaning(seed: u64, place: usize, value: u8) {
        macro_rules! all { ($($message:ty),*) => { $(one_changed_byte::<$message>(seed, place, value);)* } }
        for_all_messages!(all);
    }

    #[test]
    fn no_bytes_do_harm(bytes in prop::collection::vec(any::<u8>(), 0..1400)) {
        macro_rules! all { ($($message:ty),*) => { $(prop_assert!(<$message>::decode(&bytes).is_err());)* } }
        for_all_messages!(all);
    }
}

#[test]
fn another_length_is_refused_with_both_lengths() {
    let encoded = Task::default().encode().unwrap();
    for length in [0, 7, 8, 100, 223] {
        let error = Task::decode(&encoded.as_bytes()[..length]).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("TASK carries {length} bytes, not 224; regenerate the sender's types from types/*.lcm")
        );
    }
    let longer = [encoded.as_bytes(), &[0]].concat();
    assert!(matches!(
        Task::decode(&longer),
        Err(DecodeError::Length {
            found: 225,
            expected: 224,
            ..
        })
    ));
}

#[test]
fn another_fingerprint_is_refused_with_both_fingerprints() {
    let encoded = Task::default().encode().unwrap();
    let error = Command::decode(encoded.as_bytes()).unwrap_err();
    let [found, expected] = [Task::fingerprint(), Command::fingerprint()];
    assert!(
        error
            .to_string()
            .contains(&format!("fingerprint {found:#018x}, not {expected:#018x}")),
        "{error}"
    );
}

/// The counting sample with one byte, or a big-endian number, replaced.
fn refused<M: Message + Sample + Debug>(place: usize, bytes: &[u8]) -> String {
    let mut encoding = M::sample(&mut Counting::default())
        .encode()
        .unwrap()
        .as_bytes()
        .to_vec();
    encoding[place..place + bytes.len()].copy_from_slice(bytes);
    M::decode(&encoding).unwrap_err().to_string()
}

#[test]
fn values_that_cannot_be_used_are_refused_by_name() {
    let nan = f64::NAN.to_be_bytes();
    let one = 1.0_f64.to_be_bytes();
    for (message, expected) in [
        (
            refused::<RobotState>(36, &nan),
            "ROBOT_STATE: robot_axis_position_rad is NaN, not a finite number",
        ),
        (
            refused::<RobotState>(35, &[9]),
            "ROBOT_STATE: robot_sample_count is 9, outside 1..=8",
        ),
        (
            refused::<Command>(32, &[2]),
            "ROBOT_COMMAND: command_enable is 2, outside 0..=1",
        ),
        (
            refused::<NodeStatus>(32, b"Robot"),
            "NODE_STATUS: node_role is \"Robot",
        ),
        (
            refused::<LinkMotion>(56, &one),
            "SIM_LINK_MOTION: link_motion has norm 1.16",
        ),
        (
            refused::<Deflections>(867, &[8]),
            "SENSOR_DEFLECTION: deflection_flags is ",
        ),
        (refused::<Task>(38, &[1]), "TASK: task_parameter_mask is "),
        (
            refused::<Task>(36, &[0; 8]),
            "TASK: task_desired_force_n is 0.25, but bit 0 of task_parameter_mask is not set",
        ),
    ] {
        assert!(message.starts_with(expected), "{message} instead of {expected}");
    }
}

#[test]
fn an_unset_parameter_is_not_a_zero() {
    let parameters = TaskParameters {
        expected_height_m: Some(0.0),
        ..TaskParameters::default()
    };
    let task = Task {
        parameters,
        ..Task::default()
    };
    let decoded = Task::decode(task.encode().unwrap().as_bytes()).unwrap();
    assert_eq!(decoded.parameters.expected_height_m, Some(0.0));
    assert_eq!(decoded.parameters.desired_force_n, None);
}

#[test]
fn nothing_is_encoded_before_it_has_been_checked() {
    let mut command = Command::sample(&mut Counting::default());
    command.axis_position[7][5] = f64::INFINITY;
    let error = command.encode().unwrap_err().to_string();
    assert!(
        error.starts_with("command_axis_position_rad is inf, not a finite number"),
        "{error}"
    );
}

#[test]
fn a_role_is_plain_text() {
    let mut role = [0; 32];
    role[..3].copy_from_slice(b"arm");
    let message = Unusable::Role(role).to_string();
    assert!(message.starts_with("node_role is \"arm\\x00"), "{message}");
}
