//! Where two messages differ first.

use crate::log::stamp;
use lcmtypes::schema::{Type, Value};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};

/// A member of a message that is another one than recorded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// Step of the message.
    pub step: i64,
    /// Its channel.
    pub channel: &'static str,
    /// Name of the member, with indices: `command_axis_position_rad[0][2]`.
    pub member: String,
    /// Its recorded value, with all digits.
    pub recorded: String,
    /// Its value as it comes out now.
    pub replayed: String,
}

impl Display for Difference {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self {
            step,
            channel,
            member,
            recorded,
            replayed,
        } = self;
        write!(
            f,
            "{channel} of step {step}: {member} is {recorded} in the log and {replayed} replayed"
        )
    }
}

impl Difference {
    /// The first one between two encodings on `channel`; `None`: they are the same.
    pub(super) fn first(channel: &'static str, recorded: &[u8], replayed: &[u8]) -> Option<Self> {
        if recorded == replayed {
            return None;
        }
        let values = |bytes| Type::values(channel, bytes).unwrap_or_default();
        let (old, new) = (values(recorded), values(replayed));
        let names = Type::of(channel)?.elements();
        let differs = names
            .zip(old.iter().zip(&new))
            .find(|(_, (old, new))| bits(old) != bits(new));
        let (member, recorded_value, replayed_value) = match differs {
            Some((member, (old, new))) => (member, told(old), told(new)),
            None => (
                "its encoding".to_owned(),
                format!("{recorded:?}"),
                format!("{replayed:?}"),
            ),
        };
        Some(Self {
            step: stamp(recorded).map_or(-1, |stamp| stamp.step),
            channel,
            member,
            recorded: recorded_value,
            replayed: replayed_value,
        })
    }
}

fn bits(value: &Value) -> u64 {
    match value {
        Value::Boolean(flag) => u64::from(*flag),
        Value::Integer(number) => number.cast_unsigned(),
        Value::Double(number) => number.to_bits(),
    }
}

fn told(value: &Value) -> String {
    match value {
        Value::Boolean(flag) => flag.to_string(),
        Value::Integer(number) => number.to_string(),
        Value::Double(number) => format!("{number:?}"),
    }
}
