//! Whether two nodes may work together: `NODE_STATUS` doubles as the hello.

use spatial::ports::{Hello, NodeStatus, Role};
use std::fmt;

/// A peer that must not be worked with, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// The peer.
    pub peer: Role,
    /// What differs.
    pub what: &'static str,
    /// Here.
    pub expected: i64,
    /// There.
    pub found: i64,
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            peer,
            what,
            expected,
            found,
        } = self;
        let remedy = match *what {
            "run id" => "another run uses this port; give each run a port or a suffix of its own",
            "protocol" => "the programs are of different versions; build them from one",
            "authentication" => "give all nodes the same --key FILE, or none of them one",
            "tick reached" => "it was restarted or belongs to an earlier run; restart all nodes",
            _ => "start all nodes with the same scenario file and the same --set",
        };
        write!(
            f,
            "{} has {what} {found}, here it is {expected}; {remedy}",
            role_name(*peer)
        )
    }
}

/// The program that plays a role.
pub fn role_name(role: Role) -> &'static str {
    match role {
        Role::Robot => "robot-sim",
        Role::Sensor => "sensor-sim",
        Role::Controller => "controller",
    }
}

/// Compare what must agree; a peer must also stand before its first tick.
pub fn compare(own: &Hello, peer: &NodeStatus) -> Result<(), Mismatch> {
    let theirs = &peer.hello;
    let pairs = [
        ("run id", own.run_id, theirs.run_id),
        ("protocol", i64::from(own.protocol), i64::from(theirs.protocol)),
        (
            "ticks per period",
            i64::from(own.ticks_per_cycle),
            i64::from(theirs.ticks_per_cycle),
        ),
        ("seed", own.seed, theirs.seed),
        (
            "configuration hash",
            own.configuration_hash,
            theirs.configuration_hash,
        ),
    ];
    match pairs.into_iter().find(|(_, expected, found)| expected != found) {
        Some((what, expected, found)) => Err(Mismatch {
            peer: peer.role,
            what,
            expected,
            found,
        }),
        None => Ok(()),
    }
}

/// Compare whether messages are authenticated: `own` with what a peer says of itself.
pub fn compare_keys(own: bool, peer: &NodeStatus) -> Result<(), Mismatch> {
    if own == peer.authenticated {
        return Ok(());
    }
    Err(Mismatch {
        peer: peer.role,
        what: "authentication",
        expected: i64::from(own),
        found: i64::from(peer.authenticated),
    })
}

/// Like [`compare`], for a peer that has to be at its start: before its first tick.
pub fn compare_at_start(own: &Hello, peer: &NodeStatus) -> Result<(), Mismatch> {
    compare(own, peer)?;
    match peer.stamp.step {
        -1 => Ok(()),
        found => Err(Mismatch {
            peer: peer.role,
            what: "tick reached",
            expected: -1,
            found,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::health::Health;

    fn hello() -> Hello {
        Hello {
            run_id: 7,
            protocol: 1,
            ticks_per_cycle: 4,
            seed: 3,
            configuration_hash: 99,
        }
    }

    #[test]
    fn each_difference_is_named_with_both_values() {
        let peer = |hello: Hello| Health::new(Role::Sensor, hello).status();
        assert_eq!(compare_at_start(&hello(), &peer(hello())), Ok(()));
        let others = [
            (Hello { run_id: 8, ..hello() }, "run id 8, here it is 7"),
            (
                Hello {
                    protocol: 2,
                    ..hello()
                },
                "protocol 2, here it is 1",
            ),
            (
                Hello {
                    ticks_per_cycle: 8,
                    ..hello()
                },
                "ticks per period 8, here it is 4",
            ),
            (Hello { seed: 4, ..hello() }, "seed 4, here it is 3"),
            (
                Hello {
                    configuration_hash: -1,
                    ..hello()
                },
                "configuration hash -1, here it is 99",
            ),
        ];
        for (other, expected) in others {
            let mismatch = compare(&hello(), &peer(other)).unwrap_err().to_string();
            assert!(
                mismatch.starts_with(&format!("sensor-sim has {expected}; ")),
                "{mismatch}"
            );
        }
        let mut with_key = peer(hello());
        with_key.authenticated = true;
        assert_eq!(compare_keys(true, &with_key), Ok(()));
        assert_eq!(
            compare_keys(false, &with_key).unwrap_err().to_string(),
            "sensor-sim has authentication 1, here it is 0; give all nodes the same --key FILE, or none of them one"
        );
        let mut late = peer(hello());
        late.stamp.step = 12;
        assert!(
            compare_at_start(&hello(), &late)
                .unwrap_err()
                .to_string()
                .contains("tick reached 12")
        );
    }
}
