//! What a node sends and takes under a key.
//!
//! A tag alone would be as good when it comes a second time. Hence the robot draws a *session*, which the others repeat: the
//! controller takes it from the robot's states, the sensor from the controller's commands. A receiver takes what belongs to
//! the present session or the one before, each number of a sender at most once, and in order. What the robot executes is so of
//! a session that it has drawn itself since the sender's process has joined. Who asks counts on from the robot's numbers, so
//! that those of all askers are comparable, and a request is soon too old.

use super::keys::{HmacSha256, KEY_BYTES, Keyring, keyed};
use super::{Author, Signed};
use hmac::Mac;
use spatial::ports::Authenticity;
use thiserror::Error;

/// A request is good for so many states of the robot.
const REQUEST_STATES: u64 = 500;

/// Why a message is as good as none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Refusal {
    /// Not signed, or with a key that this node does not have.
    #[error("{}; give all nodes the same --key FILE", unknown(*.found))]
    Key {
        /// Id of the key, 0: not signed.
        found: i32,
    },
    /// The tag is not that of the message.
    #[error("its tag is wrong: it is forged, or altered on its way, or for another channel")]
    Tag,
    /// It belongs to no session that counts.
    #[error("it belongs to session {found:x}, which is over or not known")]
    Session {
        /// The session.
        found: i64,
    },
    /// It has been heard, or a later one has.
    #[error("it is number {found} of its sender, which is not later than {last}: repeated, or overtaken")]
    Old {
        /// Its number.
        found: i64,
        /// The last one taken.
        last: i64,
    },
    /// A request that is not of now.
    #[error(
        "it was asked for at state {found} of the robot, which is at {newest}, more than {REQUEST_STATES} away"
    )]
    Late {
        /// Its number.
        found: i64,
        /// The newest one of the robot.
        newest: i64,
    },
}

fn unknown(key_id: i32) -> String {
    match key_id {
        0 => "it is not signed".to_owned(),
        _ => format!("it is signed with key {key_id:08x}, which this node does not have"),
    }
}

/// The present session and the one before; 0: none.
#[derive(Clone, Copy, Debug, Default)]
struct Sessions {
    present: i64,
    previous: i64,
    /// How many there have been: the present one's number.
    count: u64,
}

impl Sessions {
    fn begin(&mut self, session: i64) {
        if session != self.present {
            (self.previous, self.present) = (self.present, session);
            self.count += 1;
        }
    }

    /// The number of `session`, if it counts.
    fn number(&self, session: i64) -> Option<u64> {
        match session {
            0 => None,
            _ if session == self.present => Some(self.count),
            _ if session == self.previous => Some(self.count - 1),
            _ => None,
        }
    }
}

/// What has been heard of an author.
#[derive(Clone, Copy, Debug, Default)]
struct Peer {
    /// Of which process: of those who ask, the robot's, whose numbers theirs are.
    boot_id: i64,
    /// Number of the session from which on it is listened to.
    since: u64,
    /// Last number taken.
    seq: i64,
}

/// What a node sends and takes under a key.
#[derive(Clone, Debug)]
pub struct Gate {
    keyring: Keyring,
    own: Author,
    /// The robot's: what it draws sessions with.
    source: Option<HmacSha256>,
    sessions: Sessions,
    seq: i64,
    /// By author.
    peers: [Peer; 4],
}

impl Gate {
    /// The robot's, which draws sessions from `secret`: random bytes of this process alone.
    pub fn of_robot(keyring: Keyring, secret: &[u8; KEY_BYTES]) -> Self {
        let mut gate = Self::new(keyring, Author::Robot);
        gate.source = Some(keyed(secret));
        gate.renew();
        gate
    }

    /// That of anyone else.
    pub fn new(keyring: Keyring, own: Author) -> Self {
        Self {
            keyring,
            own,
            source: None,
            sessions: Sessions::default(),
            seq: 0,
            peers: [Peer::default(); 4],
        }
    }

    /// The present session, 0: not known yet.
    pub fn session(&self) -> i64 {
        self.sessions.present
    }

    /// The robot begins another session.
    pub fn renew(&mut self) {
        if let Some(source) = &self.source {
            let drawn = source.clone().chain_update(self.sessions.count.to_be_bytes());
            let [a, b, c, d, e, f, g, h, ..] = <[u8; 32]>::from(drawn.finalize().into_bytes());
            let session = i64::from_be_bytes([a, b, c, d, e, f, g, h]) & i64::MAX;
            self.sessions.begin(session.max(1));
        }
    }

    /// Begin a session where there is no robot that draws one, as when a sensor alone is tried.
    pub fn suppose(&mut self, session: i64) {
        self.sessions.begin(session);
    }

    /// Sign an own message as the next one of the present session.
    pub fn sign<M: Signed>(&mut self, message: &mut M) {
        self.seq = match self.own {
            Author::Operator => self.newest_state().max(self.seq.saturating_add(1)),
            _ => self.seq.saturating_add(1),
        };
        self.keyring.sign(message, self.sessions.present, self.seq);
    }

    /// Take a message that has come, or say why it is as good as none. Peers' are those of a process that is worked with.
    pub fn admit<M: Signed>(&mut self, message: &M) -> Result<(), Refusal> {
        self.keyring.verify(message)?;
        let Authenticity { session, seq, .. } = *message.authenticity();
        let boot_id = match M::AUTHOR {
            Author::Operator => self.peers[Author::Robot as usize].boot_id,
            _ => message.stamp().boot_id,
        };
        let newest = self.newest_state();
        if M::AUTHOR == Author::Operator && seq.abs_diff(newest) > REQUEST_STATES {
            return Err(Refusal::Late { found: seq, newest });
        }
        if self.peers[M::AUTHOR as usize].boot_id != boot_id {
            self.meet(M::AUTHOR, boot_id);
        }
        let peer = &mut self.peers[M::AUTHOR as usize];
        if seq <= peer.seq {
            let last = peer.seq;
            return Err(Refusal::Old { found: seq, last });
        }
        let teaches = match self.own {
            Author::Robot => false,
            Author::Controller | Author::Operator => M::AUTHOR == Author::Robot,
            Author::Sensor => M::AUTHOR == Author::Controller,
        };
        if teaches && session != 0 {
            self.sessions.begin(session);
        } else if self
            .sessions
            .number(session)
            .is_none_or(|number| number < peer.since)
        {
            return Err(Refusal::Session { found: session });
        }
        peer.seq = seq;
        Ok(())
    }

    /// Number of the robot's newest state.
    fn newest_state(&self) -> i64 {
        match self.own {
            Author::Robot => self.seq,
            _ => self.peers[Author::Robot as usize].seq,
        }
    }

    /// Another process: it begins to count anew. What it may have said before is not taken again: by the robot nothing of a session
    /// that it has not drawn since, by the others nothing of the one before.
    fn meet(&mut self, author: Author, boot_id: i64) {
        self.renew();
        let mut since = 0;
        match self.own {
            Author::Robot => since = self.sessions.count,
            _ => self.sessions.previous = 0,
        }
        if (self.own, author) == (Author::Operator, Author::Robot) {
            self.seq = 0;
        }
        let seq = 0;
        self.peers[author as usize] = Peer { boot_id, since, seq };
    }
}
