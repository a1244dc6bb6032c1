//! LCM event logs, whoever has recorded them: all that can be read, and what can't be.

pub mod sidecar;

use crate::transcript::Entry;
use lcmtypes::schema::Type;
use lcmtypes::{CHANNELS, DecodeError, Event, EventLogReader, LogError, Message, Suffix};
use node::record::HEARD;
use serde::Serialize;
use spatial::ports::{NodeStatus, Stamp, Task};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};

/// What a log holds.
#[derive(Debug)]
pub struct Log {
    /// The file.
    pub path: PathBuf,
    /// Every usable message, in the order of the file.
    pub entries: Vec<Entry>,
    /// Where and why reading has ended before the file does.
    pub damage: Option<LogError>,
    /// Messages of this contract that can't be used, channel by channel.
    pub unusable: Vec<Unusable>,
    /// Messages of other channels: how many of each.
    pub foreign: BTreeMap<String, usize>,
}

/// Messages of one channel that can't be used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unusable {
    /// Channel.
    pub channel: String,
    /// Its type.
    pub type_name: &'static str,
    /// How many.
    pub messages: usize,
    /// How many others of the channel are usable.
    pub usable: usize,
    /// Fingerprint of the first one and of the type as it is now, if they differ.
    pub fingerprints: Option<[u64; 2]>,
    /// Why the first one is not.
    pub reason: String,
}

/// A log of which nothing can be used.
#[derive(Debug, thiserror::Error)]
pub enum NoLog {
    /// It can't be read, or is no log.
    #[error(transparent)]
    Unreadable(#[from] LogError),
    /// It is empty.
    #[error("event log {path} is empty: nothing was recorded")]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Nothing of it is of this contract, or nothing usable.
    #[error("event log {path} has no message of Touchdown that can be used; {found}")]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What there is.
        found: String,
    },
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            channel,
            type_name,
            messages,
            reason,
            ..
        } = self;
        match self.fingerprints {
            Some([found, expected]) => write!(
                f,
                "{messages} messages of {channel} are left out: the type {type_name} has changed, its fingerprint is \
                 {found:#018x} in the log and {expected:#018x} in this program; use the version that recorded it"
            ),
            None => write!(
                f,
                "{messages} messages of {channel} are left out, the first one since {reason}"
            ),
        }
    }
}

/// The channel that the messages of `channel` were heard on, or itself.
pub fn said_on(channel: &str) -> &str {
    channel.strip_prefix(HEARD).unwrap_or(channel)
}

/// What ends `channel`, if it is one of this contract's with a suffix.
pub fn suffix(channel: &str) -> Option<Suffix> {
    let of = |name: &&str| channel.strip_prefix(*name)?.parse().ok();
    CHANNELS.iter().find_map(of)
}

/// The head of any message of this contract; `None`: it is shorter than one.
pub fn stamp(bytes: &[u8]) -> Option<Stamp> {
    let number = |start: usize| -> Option<i64> {
        let bytes = bytes.get(start..start + 8)?;
        Some(i64::from_be_bytes(bytes.try_into().ok()?))
    };
    Some(Stamp {
        step: number(8)?,
        utime: number(16)?,
        boot_id: number(24)?,
    })
}

impl Log {
    /// The log `path` with `entries` that are known to be usable.
    pub fn of(path: &Path, entries: Vec<Entry>) -> Self {
        Self {
            path: path.to_owned(),
            entries,
            damage: None,
            unusable: Vec::new(),
            foreign: BTreeMap::new(),
        }
    }

    /// Read all that can be read of the log at `path`.
    pub fn open(path: &Path) -> Result<Self, NoLog> {
        Self::of_cell(path, &Suffix::default())
    }

    /// The same of the cell whose channels end in `suffix` there: logs of the network hold all cells, those of
    /// `touchdown run --record` and of the nodes have plain names.
    pub fn of_cell(path: &Path, suffix: &Suffix) -> Result<Self, NoLog> {
        Self::from_events(path, suffix, EventLogReader::open(path)?)
    }

    /// The same of the log `path` whose events have been read.
    pub fn from_events(
        path: &Path,
        suffix: &Suffix,
        read: impl Iterator<Item = Result<Event, LogError>>,
    ) -> Result<Self, NoLog> {
        let mut log = Self::of(path, Vec::new());
        let mut events = 0;
        for event in read {
            match event {
                Ok(event) => {
                    events += 1;
                    log.take(Entry::from(event), suffix);
                }
                Err(damage) => log.damage = Some(damage),
            }
        }
        for unusable in &mut log.unusable {
            unusable.usable = log
                .entries
                .iter()
                .filter(|entry| entry.channel == unusable.channel)
                .count();
        }
        match (log.entries.is_empty(), events, log.damage.take()) {
            (true, 0, Some(damage)) => Err(damage.into()),
            (true, 0, None) => Err(NoLog::Empty { path: log.path }),
            (true, ..) => Err(log.nothing()),
            (false, _, damage) => Ok(Self { damage, ..log }),
        }
    }

    fn take(&mut self, mut entry: Entry, suffix: &Suffix) {
        if let Some(plain) = suffix.strip(&entry.channel) {
            entry.channel.truncate(plain.len());
        } else {
            *self.foreign.entry(entry.channel).or_default() += 1;
            return;
        }
        let channel = said_on(&entry.channel);
        if !CHANNELS.contains(&channel) {
            *self.foreign.entry(entry.channel).or_default() += 1;
            return;
        }
        let Err(error) = lcmtypes::check(channel, &entry.bytes) else {
            self.entries.push(entry);
            return;
        };
        match self.unusable.iter_mut().find(|it| it.channel == entry.channel) {
            Some(known) => known.messages += 1,
            None => self.unusable.push(Unusable {
                type_name: Type::of(channel).map_or("", |it| it.name),
                messages: 1,
                usable: 0,
                fingerprints: match error {
                    DecodeError::Fingerprint { found, expected, .. } => Some([found, expected]),
                    _ => None,
                },
                reason: error.to_string(),
                channel: entry.channel,
            }),
        }
    }

    /// Why nothing can be used.
    fn nothing(self) -> NoLog {
        let mut found: Vec<_> = self.unusable.iter().map(ToString::to_string).collect();
        if !self.foreign.is_empty() {
            let names: Vec<_> = self.foreign.keys().take(5).map(String::as_str).collect();
            found.push(format!("it has channels of others: {}", names.join(", ")));
            let suffixes: BTreeSet<_> = self.foreign.keys().filter_map(|name| suffix(name)).collect();
            for it in suffixes {
                found.push(format!("those that end in {it} are read with --suffix {it}"));
            }
        }
        NoLog::Foreign {
            path: self.path,
            found: found.join("; "),
        }
    }

    /// What was said, each message once, in the order of the file: a recorder on the network hears those twice that are
    /// repeated in lockstep.
    pub fn said(&self) -> Vec<Entry> {
        let mut known = BTreeSet::new();
        let once = |entry: &&Entry| {
            if entry.channel.starts_with(HEARD) {
                return false;
            }
            // Statuses and requests have a step of their own making.
            let counted = ![NodeStatus::CHANNEL, Task::CHANNEL].contains(&entry.channel.as_str());
            let stamp = stamp(&entry.bytes).filter(|_| counted);
            stamp.is_none_or(|stamp| known.insert((entry.channel.clone(), stamp.boot_id, stamp.step)))
        };
        self.entries.iter().filter(once).cloned().collect()
    }

    /// All that is wrong with it, one line each.
    pub fn complaints(&self) -> Vec<String> {
        let damage = self.damage.iter().map(ToString::to_string);
        damage
            .chain(self.unusable.iter().map(ToString::to_string))
            .collect()
    }
}

#[cfg(test)]
mod tests;
