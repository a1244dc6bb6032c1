//! What becomes of a cell's nodes: pure, a function of the statuses that are heard and of time.

use super::{CellConfig, ROLES};
use crate::launch::Ended;
use crate::program::words;
use node::greeting::{self, role_name};
use node::peers::SILENT;
use serde::Serialize;
use spatial::ports::{Fault, NodeState, NodeStatus, Role};
use std::fmt;
use std::time::{Duration, Instant};

/// A node that has not been heard of for so long after the start is asked for.
const EXPECTED: Duration = Duration::from_secs(5);
/// So many foreign processes are told of.
const MOST_FOREIGN: usize = 32;

/// Something has changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Event {
    /// Whom it concerns: a node, or the whole cell.
    pub node: &'static str,
    /// Where that is; empty: nowhere in particular.
    pub host: String,
    /// What has changed, and what to do about it.
    pub event: String,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:10}  {:12}  {}", self.node, self.host, self.event)
    }
}

/// What is known of a cell's nodes.
#[derive(Debug)]
pub struct Watch {
    run_id: i64,
    started: Instant,
    /// By role: where the node runs, and what starts it.
    places: [Option<(String, String)>; 3],
    known: [Option<Known>; 3],
    /// Processes of other cells, or second ones in a role, that have been told of.
    foreign: Vec<i64>,
    asked_for: [bool; 3],
    complete: bool,
}

#[derive(Debug)]
struct Known {
    status: NodeStatus,
    heard: Instant,
    silent: bool,
}

/// Text that is padded with zeros.
pub(crate) fn unpadded(text: &[u8]) -> String {
    let end = text.iter().position(|&byte| byte == 0).unwrap_or(text.len());
    text[..end].escape_ascii().to_string()
}

impl Watch {
    /// Of `cell`, whose nodes here are started `now`.
    pub fn new(cell: &CellConfig, now: Instant) -> Self {
        let mut places: [Option<(String, String)>; 3] = Default::default();
        for role in ROLES {
            places[role as usize] = cell
                .place(role)
                .map(|place| (place.host.clone(), cell.command_on(&place.host)));
        }
        Self {
            run_id: cell.run_id,
            started: now,
            places,
            known: Default::default(),
            foreign: Vec::new(),
            asked_for: [false; 3],
            complete: false,
        }
    }

    /// A status has been heard `now`.
    pub fn hear(&mut self, status: &NodeStatus, now: Instant) -> Vec<Event> {
        let boot_id = status.stamp.boot_id;
        let event = |event: String| Event {
            node: role_name(status.role),
            host: unpadded(&status.host),
            event,
        };
        if status.hello.run_id != self.run_id {
            let (found, own) = (status.hello.run_id, self.run_id);
            return self.stranger(boot_id, || {
                event(format!(
                    "belongs to run {found}, not to {own}, and is not listened to; give each cell a port or a suffix of its own (url)"
                ))
            });
        }
        let i = status.role as usize;
        let before = self.known[i].as_ref();
        let fresh = before.is_some_and(|known| now.saturating_duration_since(known.heard) < SILENT);
        let same = before.is_some_and(|known| known.status.stamp.boot_id == boot_id);
        if fresh && !same {
            return self.stranger(boot_id, || {
                event("a second process plays this role; end one of them".to_owned())
            });
        }
        let news = match before {
            None => Some("heard"),
            Some(_) if !same => Some("started anew"),
            Some(known) if known.silent => Some("heard again"),
            Some(_) => None,
        };
        let changed = before
            .is_none_or(|known| (known.status.state, known.status.fault) != (status.state, status.fault));
        self.known[i] = Some(Known {
            status: *status,
            heard: now,
            silent: false,
        });
        let mut events = Vec::new();
        if news.is_some() || changed {
            let state = self.state(status);
            events.push(event(match news {
                Some(news) => format!("{news}: {state}"),
                None => state,
            }));
        }
        events.extend(self.completeness());
        events
    }

    /// Who has gone silent, or has not come, `now`.
    pub fn look(&mut self, now: Instant) -> Vec<Event> {
        let mut events = Vec::new();
        for role in ROLES {
            let i = role as usize;
            let since = |instant: Instant| now.saturating_duration_since(instant);
            match &mut self.known[i] {
                Some(known) if !known.silent && since(known.heard) >= 4 * SILENT => {
                    known.silent = true;
                    events.push(Event {
                        node: role_name(role),
                        host: unpadded(&known.status.host),
                        event: format!("silent for {} s", (4 * SILENT).as_secs()),
                    });
                }
                None if !self.asked_for[i] && since(self.started) >= EXPECTED => {
                    self.asked_for[i] = true;
                    events.push(self.absent(role));
                }
                _ => {}
            }
        }
        events.extend(self.completeness());
        events
    }

    /// A node that was started here has ended on its own.
    pub fn end(&self, ended: &Ended) -> Event {
        let Ended { role, how, last, .. } = ended;
        let event = match ended.well {
            true => "has ended, as it was asked to by a signal".to_owned(),
            false => format!(
                "has died ({how}); its last message: {last}; the other nodes go on, and take it back when it is started \
                 again"
            ),
        };
        self.of(*role, event)
    }

    /// A node that was started here has not ended well when it was asked to: `how`, and what it said `last`.
    pub fn end_badly(&self, role: Role, how: &str, last: &str) -> Event {
        self.of(
            role,
            format!("did not end well ({how}); its last message: {last}"),
        )
    }

    fn of(&self, role: Role, event: String) -> Event {
        let place = self.places[role as usize].as_ref();
        Event {
            node: role_name(role),
            host: place.map_or(String::new(), |(host, _)| host.clone()),
            event,
        }
    }

    fn stranger(&mut self, boot_id: i64, event: impl FnOnce() -> Event) -> Vec<Event> {
        if self.foreign.contains(&boot_id) || self.foreign.len() >= MOST_FOREIGN {
            return Vec::new();
        }
        self.foreign.push(boot_id);
        vec![event()]
    }

    fn absent(&self, role: Role) -> Event {
        let seconds = EXPECTED.as_secs();
        let event = match &self.places[role as usize] {
            Some((_, command)) => format!(
                "not heard for {seconds} s; start it there: {command}; if it runs, `touchdown doctor --peer` on both hosts \
                 tells why it is not heard"
            ),
            None => format!("not heard for {seconds} s; start what plays this role"),
        };
        self.of(role, event)
    }

    /// State and fault in words, with a remedy.
    fn state(&self, status: &NodeStatus) -> String {
        if status.fault == Fault::None {
            return match status.state {
                NodeState::Finished => "the scenario is over; goes on until it is stopped".to_owned(),
                state => words(state.name()),
            };
        }
        let fault = words(status.fault.name());
        let peer = self.known[status.fault_peer as usize].as_ref();
        let compare = |peer: &NodeStatus| {
            greeting::compare(&status.hello, peer)?;
            greeting::compare_keys(status.authenticated, peer)
        };
        let mismatch = peer.and_then(|peer| compare(&peer.status).err());
        match (status.fault, mismatch) {
            (Fault::HelloMismatch, Some(mismatch)) => format!("fault: {fault}: {mismatch}"),
            (Fault::HelloMismatch, None) => format!(
                "fault: {fault}: {} has {}, here it is {}; start all nodes with the same cell file and the same programs",
                role_name(status.fault_peer),
                status.fault_found,
                status.fault_expected
            ),
            _ => format!("fault: {fault}; mend its cause, then `touchdown task reset` and `start`"),
        }
    }

    /// Tell once when all nodes are there and well, and again after it was otherwise.
    fn completeness(&mut self) -> Option<Event> {
        let well = |known: &Known| {
            let state = known.status.state;
            !known.silent && known.status.fault == Fault::None && state != NodeState::Starting
        };
        let complete = self.known.iter().all(|known| known.as_ref().is_some_and(well));
        let news = complete && !std::mem::replace(&mut self.complete, complete);
        self.complete = complete;
        news.then(|| Event {
            node: "cell",
            host: String::new(),
            event: "all nodes work with each other".to_owned(),
        })
    }
}

#[cfg(test)]
mod tests;
