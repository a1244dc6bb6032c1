//! What was said in a run, message by message: from the loop in one process, or from the nodes' records.
//!
//! A record holds more: each node's status, and what the controller has heard.

use crate::in_process;
use lcmtypes::{Encoded, Event, EventLogReader, EventLogWriter, LogError, Message};
use node::record::HEARD;
use node::scenario::Scenario;
use spatial::TICK_US;
use spatial::ports::{Invalid, NodeStatus, Task};
use std::path::Path;

/// One message of a run.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry {
    /// Time of the tick, us.
    pub utime: i64,
    /// Channel.
    pub channel: String,
    /// Encoding.
    pub bytes: Vec<u8>,
}

impl From<Event> for Entry {
    fn from(event: Event) -> Self {
        Self {
            utime: event.utime,
            channel: event.channel,
            bytes: event.bytes,
        }
    }
}

/// All messages that the three nodes publish in a run of `scenario`, NODE_STATUS excepted, ordered by tick and
/// channel.
pub fn in_process(scenario: &Scenario) -> Result<Vec<Entry>, Invalid> {
    in_process_with(scenario, &[])
}

/// The same with `tasks`, as [`in_process::run_with`] takes them.
pub fn in_process_with(scenario: &Scenario, tasks: &[Task]) -> Result<Vec<Entry>, Invalid> {
    let mut entries = Vec::new();
    let mut failure = None;
    in_process::run_with(scenario, tasks, |tick| {
        let mut keep = |encoded: Result<Encoded, Invalid>| match encoded {
            Ok(encoded) => entries.push(entry(tick.link_motion.stamp.step, &encoded)),
            Err(invalid) => failure = Some(invalid),
        };
        keep(tick.link_motion.encode());
        keep(tick.sensor.tool_motion.encode());
        keep(tick.sensor.truth.encode());
        keep(tick.sensor.deflections.encode());
        if let Some(pose) = &tick.sensor.object_pose {
            keep(pose.encode());
        }
        if let Some(state) = &tick.robot_state {
            keep(state.encode());
        }
        if let Some(outputs) = &tick.controller {
            keep(outputs.command.encode());
            keep(outputs.status.encode());
        }
    });
    entries.sort();
    match failure {
        Some(invalid) => Err(invalid),
        None => Ok(entries),
    }
}

/// All events of several nodes' records in the order of time; those of one tick in the order of the records.
pub fn record<P: AsRef<Path>>(paths: &[P]) -> Result<Vec<Entry>, LogError> {
    let mut entries = Vec::new();
    for path in paths {
        for event in EventLogReader::open(path)? {
            entries.push(Entry::from(event?));
        }
    }
    entries.sort_by_key(|entry| entry.utime);
    Ok(entries)
}

/// What nodes have said in a `record`, NODE_STATUS excepted, ordered by tick and channel.
pub fn said(mut record: Vec<Entry>) -> Vec<Entry> {
    record.retain(|entry| entry.channel != NodeStatus::CHANNEL && !entry.channel.starts_with(HEARD));
    record.sort();
    record
}

/// The messages of several nodes' records, as [`said`].
pub fn from_logs<P: AsRef<Path>>(paths: &[P]) -> Result<Vec<Entry>, LogError> {
    record(paths).map(said)
}

/// Write `entries` as one LCM event log.
pub fn write_log(path: &Path, entries: &[Entry]) -> Result<(), LogError> {
    let mut log = EventLogWriter::create(path)?;
    for entry in entries {
        log.write(entry.utime, &entry.channel, &entry.bytes)?;
    }
    log.close()
}

/// The messages of type `M` among `entries`, in their order; those that can't be decoded are left out.
pub fn messages<M: Message>(entries: &[Entry]) -> impl Iterator<Item = M> {
    entries
        .iter()
        .filter(|entry| entry.channel == M::CHANNEL)
        .filter_map(|entry| M::decode(&entry.bytes).ok())
}

/// Where two transcripts differ first, in words; `None`: they are identical.
pub fn first_difference(left: &[Entry], right: &[Entry]) -> Option<String> {
    let name = |entry: &Entry| format!("{} of tick {}", entry.channel, entry.utime / TICK_US);
    let differing = left.iter().zip(right).find(|(a, b)| a != b);
    if let Some((a, b)) = differing {
        let byte = a.bytes.iter().zip(&b.bytes).position(|(x, y)| x != y);
        return Some(format!(
            "{} against {}, first differing byte {byte:?}",
            name(a),
            name(b)
        ));
    }
    if left.len() != right.len() {
        let next = left.get(right.len()).or(right.get(left.len()));
        return Some(format!(
            "{} against {} messages; the first only in one: {:?}",
            left.len(),
            right.len(),
            next.map(name)
        ));
    }
    None
}

fn entry(tick: i64, encoded: &Encoded) -> Entry {
    Entry {
        utime: tick * TICK_US,
        channel: encoded.channel().to_owned(),
        bytes: encoded.as_bytes().to_vec(),
    }
}
