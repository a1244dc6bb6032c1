//! Whom a node works with in real time: pure, a function of the statuses that it hears and of time.
//!
//! Nodes start in any order and restart at any time. A peer is taken on once its status shows that it runs the same
//! experiment; it stays until it has been silent for [`SILENT`]. Meanwhile another process in its role is not listened to.
//! A process that finds its own role taken when it starts does not work at all.

use crate::greeting::{self, Mismatch};
use spatial::ports::{Hello, NodeStatus, Role};
use std::time::{Duration, Instant};

/// Between two statuses of a node.
pub const STATUS_PERIOD: Duration = Duration::from_millis(100);
/// A peer of which nothing is heard for so long may be replaced.
pub const SILENT: Duration = Duration::from_millis(500);

/// A peer that is worked with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Peer {
    boot_id: i64,
    heard: Instant,
}

/// What a status tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// Nothing new.
    Known,
    /// From now on the node works with this process.
    Joined(Role),
    /// Not to be worked with, and why.
    Refused(Mismatch),
    /// The own role is taken by the process with this boot id.
    Taken(i64),
}

/// Whom a node works with.
#[derive(Clone, Debug)]
pub struct Peers {
    role: Role,
    boot_id: i64,
    hello: Hello,
    /// Whether messages are authenticated.
    authenticated: bool,
    started: Instant,
    /// By role.
    peers: [Option<Peer>; 3],
}

impl Peers {
    /// Of the process `boot_id` in `role`, which has `started` and says `hello`; `authenticated`: with a key.
    pub fn new(role: Role, boot_id: i64, hello: Hello, authenticated: bool, started: Instant) -> Self {
        Self {
            role,
            boot_id,
            hello,
            authenticated,
            started,
            peers: [None; 3],
        }
    }

    /// A status has been heard `now`.
    pub fn hear(&mut self, status: &NodeStatus, now: Instant) -> News {
        let (role, boot_id) = (status.role, status.stamp.boot_id);
        if role == self.role {
            return self.hear_twin(status, now);
        }
        let agrees = || {
            greeting::compare(&self.hello, status)?;
            greeting::compare_keys(self.authenticated, status)
        };
        let peer = &mut self.peers[role as usize];
        let fresh = peer.filter(|known| now.saturating_duration_since(known.heard) < SILENT);
        match fresh {
            Some(known) if known.boot_id == boot_id => {
                *peer = Some(Peer { boot_id, heard: now });
                News::Known
            }
            // Somebody else's experiment on the same channels does not disturb one that runs.
            Some(_) => News::Known,
            None => match agrees() {
                Err(mismatch) => News::Refused(mismatch),
                Ok(()) => {
                    let before = peer.replace(Peer { boot_id, heard: now });
                    match before {
                        Some(known) if known.boot_id == boot_id => News::Known,
                        _ => News::Joined(role),
                    }
                }
            },
        }
    }

    /// Another process in the own role: the one that has been there for longer goes on.
    fn hear_twin(&self, status: &NodeStatus, now: Instant) -> News {
        let other = status.stamp.boot_id;
        let established = now.saturating_duration_since(self.started) > SILENT;
        if other == self.boot_id || established || status.hello.run_id != self.hello.run_id {
            return News::Known;
        }
        News::Taken(other)
    }

    /// Whether the process `boot_id` is worked with as `role`.
    pub fn is(&self, role: Role, boot_id: i64) -> bool {
        self.peers[role as usize].is_some_and(|peer| peer.boot_id == boot_id)
    }

    /// The process that is worked with as `role`.
    pub fn boot_id(&self, role: Role) -> Option<i64> {
        self.peers[role as usize].map(|peer| peer.boot_id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock;
    use crate::health::Health;

    fn status(role: Role, boot_id: i64, run_id: i64) -> NodeStatus {
        let hello = Hello {
            run_id,
            ..Hello::default()
        };
        let mut status = Health::new(role, hello).status();
        status.stamp.boot_id = boot_id;
        status
    }

    fn peers() -> (Peers, Instant) {
        let started = clock::now();
        let own = Peers::new(Role::Controller, 1, Hello::default(), false, started);
        (own, started)
    }

    #[test]
    fn a_peer_stays_until_it_is_silent() {
        let (mut peers, start) = peers();
        let at = |ms: u64| start + Duration::from_millis(ms);
        let robot = |boot_id| status(Role::Robot, boot_id, 0);
        assert_eq!(peers.hear(&robot(5), at(0)), News::Joined(Role::Robot));
        assert_eq!(peers.hear(&robot(6), at(400)), News::Known);
        assert!(peers.is(Role::Robot, 5) && !peers.is(Role::Robot, 6));
        assert_eq!(peers.hear(&robot(5), at(450)), News::Known);
        assert_eq!(peers.hear(&robot(6), at(900)), News::Known);
        assert_eq!(peers.hear(&robot(6), at(1000)), News::Joined(Role::Robot));
        assert_eq!(peers.boot_id(Role::Robot), Some(6));
    }

    #[test]
    fn a_peer_that_pauses_is_the_same_afterwards() {
        let (mut peers, start) = peers();
        let sensor = status(Role::Sensor, 5, 0);
        assert_eq!(peers.hear(&sensor, start), News::Joined(Role::Sensor));
        assert_eq!(peers.hear(&sensor, start + 3 * SILENT), News::Known);
    }

    #[test]
    fn another_experiment_is_refused_but_does_not_disturb() {
        let (mut peers, start) = peers();
        let foreign = status(Role::Robot, 5, 9);
        assert!(matches!(
            peers.hear(&foreign, start),
            News::Refused(Mismatch {
                what: "run id",
                found: 9,
                ..
            })
        ));
        assert_eq!(
            peers.hear(&status(Role::Robot, 6, 0), start),
            News::Joined(Role::Robot)
        );
        assert_eq!(peers.hear(&foreign, start), News::Known);
    }

    #[test]
    fn who_has_a_key_is_refused_by_who_has_none() {
        let (mut peers, start) = peers();
        let mut robot = status(Role::Robot, 5, 0);
        robot.authenticated = true;
        assert!(matches!(
            peers.hear(&robot, start),
            News::Refused(Mismatch {
                what: "authentication",
                expected: 0,
                found: 1,
                ..
            })
        ));
    }

    #[test]
    fn who_comes_second_does_not_work() {
        let (mut peers, start) = peers();
        let other = status(Role::Controller, 2, 0);
        assert_eq!(peers.hear(&other, start + SILENT / 2), News::Taken(2));
        assert_eq!(
            peers.hear(&status(Role::Controller, 1, 0), start),
            News::Known,
            "itself"
        );
        assert_eq!(peers.hear(&other, start + 2 * SILENT), News::Known);
        assert_eq!(
            peers.hear(&status(Role::Controller, 2, 9), start),
            News::Known,
            "another run"
        );
    }
}
