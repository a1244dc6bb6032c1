//! What is missing on each channel, in steps.

use crate::log::stamp;
use crate::transcript::Entry;
use lcmtypes::Message;
use serde::Serialize;
use spatial::ports::{NodeStatus, Task};
use std::collections::{BTreeMap, BTreeSet};

/// One channel of a log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Channel {
    /// Its name.
    pub channel: String,
    /// Usable messages, repeated ones included.
    pub messages: usize,
    /// Those that say again what has been said.
    pub repeated: usize,
    /// Senders: more than one is a restart, or a second one.
    pub senders: usize,
    /// First and last step; `None`: its steps are of its sender's making.
    pub steps: Option<[i64; 2]>,
    /// Most frequent distance of two steps.
    pub period_steps: i64,
    /// Messages that are missing between them by that distance.
    pub missing: i64,
    /// Where.
    pub gaps: Vec<Gap>,
}

/// A place where messages are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Gap {
    /// Step of the last message before it.
    pub after_step: i64,
    /// How many are missing.
    pub missing: i64,
}

/// The channels of a log, by name.
pub(super) fn of(entries: &[Entry]) -> Vec<Channel> {
    let mut messages: BTreeMap<&str, Vec<&[u8]>> = BTreeMap::new();
    for entry in entries {
        messages.entry(&entry.channel).or_default().push(&entry.bytes);
    }
    messages
        .into_iter()
        .map(|(name, all)| channel(name, &all))
        .collect()
}

fn channel(name: &str, messages: &[&[u8]]) -> Channel {
    let mut steps: BTreeMap<i64, BTreeSet<i64>> = BTreeMap::new();
    let mut repeated = 0;
    for stamp in messages.iter().filter_map(|bytes| stamp(bytes)) {
        let new = steps.entry(stamp.boot_id).or_default().insert(stamp.step);
        repeated += usize::from(!new);
    }
    let mut channel = Channel {
        channel: name.to_owned(),
        messages: messages.len(),
        repeated,
        senders: steps.len(),
        steps: None,
        period_steps: 0,
        missing: 0,
        gaps: Vec::new(),
    };
    if [NodeStatus::CHANNEL, Task::CHANNEL].contains(&crate::log::said_on(name)) {
        channel.repeated = 0;
        return channel;
    }
    let distances = |of: &BTreeSet<i64>| -> Vec<[i64; 2]> {
        let pairs = of.iter().zip(of.iter().skip(1));
        pairs.map(|(before, after)| [*before, after - before]).collect()
    };
    let all: Vec<_> = steps.values().flat_map(distances).collect();
    let mut counts: BTreeMap<i64, usize> = BTreeMap::new();
    all.iter()
        .for_each(|[_, distance]| *counts.entry(*distance).or_default() += 1);
    // Of several as frequent ones the shortest.
    let most = counts.iter().rev().max_by_key(|(_, count)| **count);
    channel.period_steps = most.map_or(0, |(distance, _)| *distance);
    for [after_step, distance] in all {
        let missing = distance / channel.period_steps - 1;
        if missing > 0 {
            channel.missing += missing;
            channel.gaps.push(Gap { after_step, missing });
        }
    }
    let ends = |of: &BTreeSet<i64>| Some([*of.first()?, *of.last()?]);
    let ends = steps.values().filter_map(ends);
    channel.steps = ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    channel
}

#[cfg(test)]
mod tests {
    use super::*;
    use spatial::ports::Truth;

    /// A channel with messages of these steps, and boot ids.
    fn channel_of(name: &str, steps: &[(i64, i64)]) -> Channel {
        let entry = |(step, boot_id): &(i64, i64)| {
            let numbers = [0, *step, 0, *boot_id].map(i64::to_be_bytes);
            Entry {
                utime: 0,
                channel: name.to_owned(),
                bytes: numbers.concat(),
            }
        };
        let entries: Vec<_> = steps.iter().map(entry).collect();
        of(&entries).remove(0)
    }

    #[test]
    fn gaps_are_told_in_steps_of_the_channels_own_period() {
        let channel = channel_of(
            "ROBOT_STATE",
            &[(0, 1), (4, 1), (4, 1), (8, 1), (20, 1), (24, 1), (32, 1)],
        );
        assert_eq!((channel.messages, channel.repeated, channel.senders), (7, 1, 1));
        assert_eq!(
            (channel.steps, channel.period_steps, channel.missing),
            (Some([0, 32]), 4, 3)
        );
        let gaps: Vec<_> = channel
            .gaps
            .iter()
            .map(|gap| (gap.after_step, gap.missing))
            .collect();
        assert_eq!(gaps, [(8, 2), (24, 1)]);
    }

    #[test]
    fn a_restart_is_no_gap_and_order_does_not_matter() {
        let channel = channel_of(Truth::CHANNEL, &[(1, 1), (0, 1), (2, 1), (0, 2), (1, 2)]);
        assert_eq!((channel.senders, channel.missing, channel.repeated), (2, 0, 0));
        let single = channel_of(Truth::CHANNEL, &[(5, 1)]);
        assert_eq!((single.steps, single.missing), (Some([5, 5]), 0));
    }

    #[test]
    fn steps_of_requests_tell_of_no_gap() {
        let channel = channel_of(Task::CHANNEL, &[(1, 1), (9, 1), (9, 1)]);
        assert_eq!((channel.steps, channel.missing, channel.repeated), (None, 0, 0));
    }
}
