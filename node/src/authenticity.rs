//! Who has sent a message, and whether it is new: pure, for the nodes and for drivers of real devices.
//!
//! With a key, state, deflection, command and task end with a tag over all that stands before it ([`Keyring`]). What is
//! sent once and again is told by the *session*, a number that the robot draws, and by `seq`, which increases ([`Gate`]). The
//! contract is in `lcmtypes/README.md`.

mod gate;
mod keys;

pub use gate::{Gate, Refusal};
pub use keys::{KEY_BYTES, Key, Keyring};

use lcmtypes::Message;
use spatial::ports::{Authenticity, Command, Deflections, RobotState, Role, Task};

/// Who signs a message: each with a key of its own, derived from the one of the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Author {
    /// `robot-sim` or a robot's driver.
    Robot = 0,
    /// `sensor-sim` or a sensor's driver.
    Sensor = 1,
    /// `controller`.
    Controller = 2,
    /// Whoever asks by `TASK`.
    Operator = 3,
}

impl Author {
    /// What its key is derived with.
    const LABELS: [&str; 4] = [
        "touchdown robot",
        "touchdown sensor",
        "touchdown controller",
        "touchdown operator",
    ];

    /// The node that it is, if it is one.
    pub fn role(self) -> Option<Role> {
        match self {
            Self::Robot => Some(Role::Robot),
            Self::Sensor => Some(Role::Sensor),
            Self::Controller => Some(Role::Controller),
            Self::Operator => None,
        }
    }
}

/// A message that ends with `session`, `seq`, `key_id` and `tag`.
pub trait Signed: Message {
    /// Who sends it.
    const AUTHOR: Author;

    /// These.
    fn authenticity(&self) -> &Authenticity;

    /// These, to be set.
    fn authenticity_mut(&mut self) -> &mut Authenticity;
}

macro_rules! signed {
    ($($message:ident by $author:ident,)*) => {$(
        impl Signed for $message {
            const AUTHOR: Author = Author::$author;

            fn authenticity(&self) -> &Authenticity {
                &self.authenticity
            }

            fn authenticity_mut(&mut self) -> &mut Authenticity {
                &mut self.authenticity
            }
        }
    )*};
}

signed! {
    RobotState by Robot,
    Deflections by Sensor,
    Command by Controller,
    Task by Operator,
}

#[cfg(test)]
mod tests;
