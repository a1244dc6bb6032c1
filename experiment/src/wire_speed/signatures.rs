//! What it costs to sign a message and to check it, in time of a core.

use crate::cost::{median, ticks_per_core_s};
use crate::in_process;
use node::authenticity::{KEY_BYTES, Key, Keyring, Signed};
use node::scenario::Scenario;
use serde::Serialize;
use spatial::ports::Task;
use std::hint::black_box;

/// One kind of message.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Where it is sent.
    pub channel: &'static str,
    /// Of its encoding.
    pub bytes: usize,
    /// Its encoding and the tag, ns; median of the repetitions.
    pub sign_ns: f64,
    /// The same again, and the comparison, ns.
    pub check_ns: f64,
}

/// Of every kind, as in a run of `scenario`.
pub fn measure(scenario: &Scenario, repetitions: u16) -> Vec<Row> {
    let (mut states, mut deflections, mut commands) = (Vec::new(), Vec::new(), Vec::new());
    in_process::run(scenario, |tick| {
        states.extend(tick.robot_state);
        deflections.push(tick.sensor.deflections);
        commands.extend(tick.controller.map(|outputs| outputs.command));
    });
    let tasks = vec![Task::default(); commands.len()];
    vec![
        row(&states, repetitions),
        row(&deflections, repetitions),
        row(&commands, repetitions),
        row(&tasks, repetitions),
    ]
}

fn row<M: Signed>(messages: &[M], repetitions: u16) -> Row {
    let keyring = Keyring::new(Key::new(&[1; KEY_BYTES]), Vec::new());
    let signed = |message: &M| {
        let mut message = *message;
        keyring.sign(&mut message, 1, 1);
        message
    };
    let ns = |each: &dyn Fn()| {
        let rates = ticks_per_core_s(messages.len() as i64, repetitions, each);
        1e9 / median(&rates)
    };
    let sign_ns = ns(&|| {
        for message in messages {
            black_box(signed(black_box(message)));
        }
    });
    let all: Vec<M> = messages.iter().map(signed).collect();
    let check_ns = ns(&|| {
        for message in &all {
            let _ = black_box(keyring.verify(black_box(message)));
        }
    });
    let encoded = all.first().and_then(|message| message.encode().ok());
    Row {
        channel: M::CHANNEL,
        bytes: encoded.map_or(0, |encoded| encoded.as_bytes().len()),
        sign_ns,
        check_ns,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_that_is_signed_has_a_row() {
        let mut scenario = Scenario::default();
        scenario.timing.duration_s = 0.1;
        let rows = measure(&scenario, 1);
        let told: Vec<_> = rows.iter().map(|row| (row.channel, row.bytes)).collect();
        let expected = [
            ("ROBOT_STATE", 604),
            ("SENSOR_DEFLECTION", 956),
            ("ROBOT_COMMAND", 461),
            ("TASK", 224),
        ];
        assert_eq!(told, expected);
        assert!(rows.iter().all(|row| row.sign_ns > 0.0 && row.check_ns > 0.0));
    }
}
