//! What ends a node's work: said once, latched by its first cause, published.

use crate::greeting::{Mismatch, role_name};
use spatial::ports::{Fault, Invalid, Role, Stamp};
use std::fmt;
use std::path::PathBuf;

/// A reason why a node does not go on.
#[derive(Clone, Debug, PartialEq)]
pub enum Problem {
    /// A peer differs in what must agree.
    Refused(Mismatch),
    /// A peer skipped a tick or is another process than before.
    Broken {
        /// The peer.
        peer: Role,
        /// Tick and process expected.
        expected: Stamp,
        /// What came.
        found: Stamp,
    },
    /// A peer has not answered a tick.
    Silent {
        /// The peers.
        peers: Vec<Role>,
        /// The tick.
        tick: i64,
        /// For how long, s.
        seconds: u64,
    },
    /// A peer has latched a fault.
    PeerFault {
        /// The peer.
        peer: Role,
        /// Its fault.
        fault: Fault,
    },
    /// The own role is taken.
    Taken {
        /// This process.
        own: i64,
        /// The process that has it.
        other: i64,
    },
    /// The robot has latched a fault (real time).
    RobotFault {
        /// Why.
        fault: Fault,
        /// The axis that it concerns, -1: none.
        axis: i32,
    },
    /// The simulated world does not go on (real time).
    WorldSilent {
        /// The tick.
        tick: i64,
        /// For how long, s.
        seconds: f64,
    },
    /// A message of this node can't be published.
    OwnMessage {
        /// Its channel.
        channel: &'static str,
        /// Why.
        invalid: Invalid,
    },
    /// The record can't be written.
    Record {
        /// The log.
        path: PathBuf,
        /// Why.
        cause: String,
    },
}

impl Problem {
    /// The fault to latch, the peer that it concerns (`own`: none), and what was expected and found.
    pub fn fault(&self, own: Role) -> (Fault, Role, i64, i64) {
        match self {
            Self::Refused(mismatch) => (
                Fault::HelloMismatch,
                mismatch.peer,
                mismatch.expected,
                mismatch.found,
            ),
            Self::Broken {
                peer,
                expected,
                found,
            } if expected.boot_id != found.boot_id => {
                (Fault::LockstepBroken, *peer, expected.boot_id, found.boot_id)
            }
            Self::Broken {
                peer,
                expected,
                found,
            } => (Fault::LockstepBroken, *peer, expected.step, found.step),
            Self::Silent { peers, tick, .. } => (
                Fault::PeerSilent,
                peers.first().copied().unwrap_or(own),
                *tick,
                *tick - 1,
            ),
            Self::PeerFault { peer, fault } => (*fault, *peer, 0, 0),
            Self::Taken { own: this, other } => (Fault::SecondOwner, own, *this, *other),
            Self::RobotFault { fault, axis } => (*fault, own, 0, i64::from(*axis)),
            Self::WorldSilent { tick, .. } => (Fault::SimLost, Role::Sensor, *tick, *tick - 1),
            Self::OwnMessage { .. } => (Fault::MessageInvalid, own, 0, 0),
            Self::Record { .. } => (Fault::RecordFailed, own, 0, 0),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(mismatch) => mismatch.fmt(f),
            Self::Broken {
                peer,
                expected,
                found,
            } if expected.boot_id != found.boot_id => write!(
                f,
                "lockstep broken: {} is not the process it was (boot id {:x}, expected {:x}); is there a second one \
                 on this LCM URL? restart all nodes",
                role_name(*peer),
                found.boot_id,
                expected.boot_id
            ),
            Self::Broken {
                peer,
                expected,
                found,
            } => write!(
                f,
                "lockstep broken: {} sent tick {}, expected {}; was a node restarted, or is there a second one on \
                 this LCM URL? restart all nodes",
                role_name(*peer),
                found.step,
                expected.step
            ),
            Self::Silent { peers, tick, seconds } => {
                let names: Vec<_> = peers.iter().map(|peer| role_name(*peer)).collect();
                let what = if *tick < 0 {
                    "the greeting".to_owned()
                } else {
                    format!("tick {tick}")
                };
                write!(
                    f,
                    "no answer to {what} from {} for {seconds} s; running, and on the same LCM URL? `touchdown doctor` \
                     checks the network",
                    names.join(" and ")
                )
            }
            Self::PeerFault { peer, fault } => {
                write!(f, "{} has latched the fault {fault:?}", role_name(*peer))
            }
            Self::Taken { own, other } => write!(
                f,
                "another process (boot id {other:x}) plays this role already, this one is {own:x}; stop it first, or give \
                 each cell channels of its own by --url"
            ),
            Self::RobotFault { fault, axis } => {
                let (what, remedy) = match fault {
                    Fault::CommandGap => (
                        "no command for robot.command_gap_s beyond the horizon of the last one".to_owned(),
                        "see that the controller runs and is heard",
                    ),
                    _ if *axis >= 0 => (
                        format!("{fault:?} of axis {axis}"),
                        "see that what commands the robot keeps to its limits",
                    ),
                    _ => (format!("{fault:?}"), "mend its cause"),
                };
                write!(
                    f,
                    "the robot has stopped: {what}; {remedy}, then `touchdown task reset`"
                )
            }
            Self::WorldSilent { tick, seconds } => write!(
                f,
                "no answer to tick {tick} from sensor-sim for {seconds} s: the simulated world stands still; restart \
                 sensor-sim, then `touchdown task reset`"
            ),
            Self::OwnMessage { channel, invalid } => {
                write!(f, "own message on {channel} can't be published: {invalid}")
            }
            Self::Record { path, cause } => write!(
                f,
                "the record {} can't be written: {cause}; make room or run without --record",
                path.display()
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_process_is_told_by_its_boot_id_and_a_skipped_tick_by_its_number() {
        let expected = Stamp {
            step: 4,
            utime: 4000,
            boot_id: 7,
        };
        let broken = |found| Problem::Broken {
            peer: Role::Sensor,
            expected,
            found,
        };
        let skipped = broken(Stamp { step: 6, ..expected });
        assert_eq!(
            skipped.fault(Role::Robot),
            (Fault::LockstepBroken, Role::Sensor, 4, 6)
        );
        assert!(
            skipped
                .to_string()
                .starts_with("lockstep broken: sensor-sim sent tick 6, expected 4;")
        );
        let other = broken(Stamp {
            boot_id: 8,
            ..expected
        });
        assert_eq!(
            other.fault(Role::Robot),
            (Fault::LockstepBroken, Role::Sensor, 7, 8)
        );
        assert!(other.to_string().contains("boot id 8, expected 7"));
    }

    #[test]
    fn all_silent_peers_are_named() {
        let silent = Problem::Silent {
            peers: vec![Role::Sensor, Role::Controller],
            tick: -1,
            seconds: 3,
        };
        let text = silent.to_string();
        assert!(
            text.starts_with("no answer to the greeting from sensor-sim and controller for 3 s;"),
            "{text}"
        );
        assert_eq!(silent.fault(Role::Robot).0, Fault::PeerSilent);
    }
}
