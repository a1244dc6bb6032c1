//! What the types of `types/*.lcm` are made of, for programs that show any message: made from these files when the crate is
//! built.

use crate::error::DecodeError;
use crate::message;

include!(concat!(env!("OUT_DIR"), "/schema.rs"));

/// A type of `types/*.lcm`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Type {
    /// Its name, such as `robot_state_t`.
    pub name: &'static str,
    /// The comment above it.
    pub about: &'static str,
    /// Its members, in the order of the encoding.
    pub members: &'static [Member],
}

/// A member of a type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name, whose suffix is the unit.
    pub name: &'static str,
    /// What it, or each of its elements, is.
    pub kind: Kind,
    /// Sizes of an array, the outermost first; empty: it is none.
    pub dimensions: &'static [usize],
    /// The comment above it.
    pub about: &'static str,
}

/// A primitive type of LCM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `boolean`.
    Boolean,
    /// `byte`.
    Byte,
    /// `int32_t`.
    Int32,
    /// `int64_t`.
    Int64,
    /// `double`.
    Double,
}

/// A value of a primitive type.
#[derive(Clone, Copy, Debug)]
pub enum Value {
    /// Of a boolean.
    Boolean(bool),
    /// Of a byte or an integer.
    Integer(i64),
    /// Of a double.
    Double(f64),
}

impl Kind {
    /// Bytes of its encoding.
    pub fn size(self) -> usize {
        match self {
            Self::Boolean | Self::Byte => 1,
            Self::Int32 => 4,
            Self::Int64 | Self::Double => 8,
        }
    }

    /// Big-endian, as LCM has it.
    fn read(self, bytes: &[u8]) -> Value {
        let unsigned = bytes
            .iter()
            .fold(0u64, |value, byte| value << 8 | u64::from(*byte));
        match self {
            Self::Boolean => Value::Boolean(unsigned != 0),
            Self::Byte => Value::Integer(unsigned as i64),
            Self::Int32 => Value::Integer(i64::from(unsigned as u32 as i32)),
            Self::Int64 => Value::Integer(unsigned as i64),
            Self::Double => Value::Double(f64::from_bits(unsigned)),
        }
    }
}

impl Member {
    /// How many elements it has.
    pub fn count(&self) -> usize {
        self.dimensions.iter().product()
    }

    /// The name of element `i`, counted through all dimensions: `name[3][2]`.
    pub fn element(&self, i: usize) -> String {
        let mut indices = Vec::new();
        let mut rest = i;
        for size in self.dimensions.iter().rev() {
            indices.push(format!("[{}]", rest % size));
            rest /= size;
        }
        indices.reverse();
        format!("{}{}", self.name, indices.concat())
    }
}

impl Type {
    /// What `channel` carries.
    pub fn of(channel: &str) -> Option<&'static Self> {
        let (name, _) = message::type_of(channel)?;
        TYPES.iter().find(|it| it.name == name)
    }

    /// Bytes of an encoding.
    pub fn size(&self) -> usize {
        let members = self
            .members
            .iter()
            .map(|member| member.count() * member.kind.size());
        8 + members.sum::<usize>()
    }

    /// The values in an encoding of `channel`'s type, one for each element of each member, in their order. They need not be
    /// such as a node would accept.
    pub fn values(channel: &str, bytes: &[u8]) -> Result<Vec<Value>, DecodeError> {
        let unknown = || DecodeError::Channel(channel.to_owned());
        let (_, expected) = message::type_of(channel).ok_or_else(unknown)?;
        let name = *message::CHANNELS
            .iter()
            .find(|known| **known == channel)
            .ok_or_else(unknown)?;
        let this = Self::of(channel).ok_or_else(unknown)?;
        message::check_head(name, bytes, this.size(), expected)?;
        let mut rest = &bytes[8..];
        let mut values = Vec::new();
        for member in this.members {
            for _ in 0..member.count() {
                let (own, after) = rest.split_at(member.kind.size());
                values.push(member.kind.read(own));
                rest = after;
            }
        }
        Ok(values)
    }

    /// The names of these values: `robot_axis_position_rad[0][3]`.
    pub fn elements(&self) -> impl Iterator<Item = String> {
        let members = self.members.iter();
        members.flat_map(|member| (0..member.count()).map(|i| member.element(i)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CHANNELS;

    fn update(hash: i64, byte: u8) -> i64 {
        ((hash << 8) ^ (hash >> 55)).wrapping_add(i64::from(byte))
    }

    fn update_text(hash: i64, text: &str) -> i64 {
        text.bytes().fold(update(hash, text.len() as u8), update)
    }

    /// As lcm-gen computes it.
    fn fingerprint(this: &Type) -> u64 {
        let mut hash = 0x1234_5678;
        for member in this.members {
            hash = update_text(hash, member.name);
            hash = update_text(
                hash,
                match member.kind {
                    Kind::Boolean => "boolean",
                    Kind::Byte => "byte",
                    Kind::Int32 => "int32_t",
                    Kind::Int64 => "int64_t",
                    Kind::Double => "double",
                },
            );
            hash = update(hash, member.dimensions.len() as u8);
            for size in member.dimensions {
                hash = update_text(update(hash, 0), &size.to_string());
            }
        }
        (hash as u64).rotate_left(1)
    }

    #[test]
    fn every_channels_type_is_the_one_that_lcm_gen_knows() {
        for channel in CHANNELS {
            let this = Type::of(channel).unwrap();
            let (_, expected) = message::type_of(channel).unwrap();
            assert_eq!(fingerprint(this), expected, "{}", this.name);
            assert!(this.about.starts_with(channel), "{}: {:?}", this.name, this.about);
        }
        assert_eq!(Type::of("DOCTOR"), None);
    }

    #[test]
    fn elements_are_named_as_they_are_counted() {
        let this = Type::of("ROBOT_STATE").unwrap();
        let member = this
            .members
            .iter()
            .find(|member| member.dimensions == [8, 6])
            .unwrap();
        assert_eq!(
            (member.count(), member.element(9)),
            (48, format!("{}[1][3]", member.name))
        );
        assert_eq!(this.members[0].element(0), "step");
        assert!(this.members[0].about.starts_with("Tick (1 ms)"));
    }

    #[test]
    fn values_are_those_of_the_encoding() {
        use crate::Message;
        use spatial::ports::Task;
        let mut task = Task::default();
        task.stamp.step = 7;
        task.parameters.desired_force_n = Some(12.5);
        let encoded = task.encode().unwrap();
        let values = Type::values("TASK", encoded.as_bytes()).unwrap();
        let names: Vec<_> = Type::of("TASK").unwrap().elements().collect();
        let value = |name: &str| values[names.iter().position(|it| it == name).unwrap()];
        assert!(matches!(value("step"), Value::Integer(7)));
        assert!(matches!(value("task_desired_force_n"), Value::Double(12.5)));
        assert!(Type::values("TASK", &encoded.as_bytes()[1..]).is_err());
        assert!(Type::values("DOCTOR", &[]).is_err());
    }
}
