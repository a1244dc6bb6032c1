//! What is known of the other hosts: pure, a function of the words that are heard and of time.

use super::word::Word;
use crate::up::unpadded;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// So many other doctors are listened to.
const MOST: usize = 16;

/// What was heard of another host.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Peer {
    /// Its name.
    pub host: String,
    /// Questions from there, from the first to the last that was heard.
    pub sent: usize,
    /// How many of these were heard.
    pub heard: usize,
    /// Own questions, from the first to the last that was answered from there.
    pub asked: usize,
    /// How many of these were answered.
    pub answered: usize,
    /// Median of the round trip, s; without answers 0, as the next ones.
    pub round_trip_p50_s: f64,
    /// Its 99th percentile, s.
    pub round_trip_p99_s: f64,
    /// How far its wall clock is ahead of the one here, s.
    pub clock_offset_s: f64,
    /// Bound of that offset's error: half the shortest round trip, s.
    pub clock_bound_s: f64,
}

#[derive(Debug, Default)]
struct Known {
    host: [u8; 32],
    heard: BTreeSet<u32>,
    answered: BTreeSet<u32>,
    /// Round trips, us, and how far its clock was ahead, us.
    trips: Vec<(i64, i64)>,
}

/// The words of one doctor, and those it hears.
#[derive(Debug)]
pub(super) struct Tally {
    host: [u8; 32],
    id: u64,
    /// When each question was sent, us.
    sent_us: Vec<i64>,
    known: BTreeMap<u64, Known>,
}

impl Tally {
    /// Of the doctor `id`, which is not 0, on `host`.
    pub(super) fn new(host: [u8; 32], id: u64) -> Self {
        Self {
            host,
            id,
            sent_us: Vec::new(),
            known: BTreeMap::new(),
        }
    }

    /// Whether another doctor has been heard.
    pub(super) fn any(&self) -> bool {
        !self.known.is_empty()
    }

    /// The next question, sent at `now_us`.
    pub(super) fn ask(&mut self, now_us: i64) -> Word {
        let number = u32::try_from(self.sent_us.len()).unwrap_or(u32::MAX);
        self.sent_us.push(now_us);
        Word {
            host: self.host,
            id: self.id,
            number,
            sent_us: now_us,
            ..Word::default()
        }
    }

    /// A word was received at `received_us`; a question's answer, which is still to be given its `sent_us`.
    pub(super) fn hear(&mut self, word: &Word, received_us: i64) -> Option<Word> {
        let strange = !self.known.contains_key(&word.id) && self.known.len() >= MOST;
        if word.id == self.id || word.id == 0 || strange {
            return None;
        }
        let known = self.known.entry(word.id).or_default();
        known.host = word.host;
        if word.to == 0 {
            known.heard.insert(word.number);
            return Some(Word {
                host: self.host,
                id: self.id,
                number: word.number,
                to: word.id,
                received_us,
                sent_us: received_us,
            });
        }
        let asked_us = *self.sent_us.get(usize::try_from(word.number).ok()?)?;
        if word.to == self.id && known.answered.insert(word.number) {
            // Whoever lies about its clock is measured wrongly, and nothing overflows.
            let there = word.sent_us.saturating_sub(word.received_us);
            let trip = received_us.saturating_sub(asked_us).saturating_sub(there);
            let ahead = word
                .received_us
                .saturating_sub(asked_us)
                .saturating_add(word.sent_us.saturating_sub(received_us))
                / 2;
            known.trips.push((trip.max(0), ahead));
        }
        None
    }

    /// What was heard of each.
    pub(super) fn peers(&self) -> Vec<Peer> {
        self.known.values().map(Known::peer).collect()
    }
}

/// How many numbers there are from the first to the last.
fn span(numbers: &BTreeSet<u32>) -> usize {
    match (numbers.first(), numbers.last()) {
        (Some(first), Some(last)) => (last - first) as usize + 1,
        _ => 0,
    }
}

impl Known {
    fn peer(&self) -> Peer {
        let mut trips: Vec<i64> = self.trips.iter().map(|(trip, _)| *trip).collect();
        trips.sort_unstable();
        let at = |share: f64| {
            let index = (share * trips.len() as f64) as usize;
            trips.get(index).map_or(0.0, |us| *us as f64 / 1e6)
        };
        let best = self.trips.iter().min();
        Peer {
            host: unpadded(&self.host),
            sent: span(&self.heard),
            heard: self.heard.len(),
            asked: span(&self.answered),
            answered: self.answered.len(),
            round_trip_p50_s: at(0.5),
            round_trip_p99_s: at(0.99),
            clock_offset_s: best.map_or(0.0, |(_, ahead)| *ahead as f64 / 1e6),
            clock_bound_s: best.map_or(0.0, |(trip, _)| *trip as f64 / 2e6),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(name: &str) -> [u8; 32] {
        let mut padded = [0; 32];
        padded[..name.len()].copy_from_slice(name.as_bytes());
        padded
    }

    /// A way of 100 us there and 100 us back, 50 us in between, a clock that is 1 s ahead; every fifth question is lost.
    #[test]
    fn losses_round_trips_and_clocks_are_counted() {
        let (mut here, mut there) = (Tally::new(named("a"), 1), Tally::new(named("b"), 2));
        for i in 0..100 {
            let now = i * 10_000;
            let question = here.ask(now);
            if i % 5 == 2 {
                continue;
            }
            let received_us = now + 100 + 1_000_000;
            let answer = there.hear(&question, received_us).unwrap();
            let answer = Word {
                sent_us: received_us + 50,
                ..answer
            };
            assert_eq!(here.hear(&answer, now + 250), None);
            // Doubled: nothing new.
            assert_eq!(here.hear(&answer, now + 900), None);
        }
        let [b] = here.peers().try_into().unwrap();
        assert_eq!((b.host.as_str(), b.asked, b.answered), ("b", 100, 80));
        assert_eq!((b.round_trip_p50_s, b.round_trip_p99_s), (200e-6, 200e-6));
        assert_eq!((b.clock_offset_s, b.clock_bound_s), (1.0, 100e-6));
        let [a] = there.peers().try_into().unwrap();
        assert_eq!((a.host.as_str(), a.sent, a.heard, a.answered), ("a", 100, 80, 0));
    }

    #[test]
    fn what_is_not_meant_for_it_or_makes_no_sense_is_left_alone() {
        let mut here = Tally::new(named("a"), 1);
        let own = here.ask(0);
        assert_eq!(here.hear(&own, 5), None);
        assert!(!here.any());
        let answer = Word {
            id: 2,
            number: u32::MAX,
            to: 1,
            received_us: i64::MIN,
            sent_us: i64::MAX,
            ..Word::default()
        };
        here.hear(&answer, 5);
        here.hear(&Word { number: 0, ..answer }, 5);
        here.hear(
            &Word {
                to: 3,
                number: 0,
                ..answer
            },
            5,
        );
        assert_eq!(here.peers()[0].answered, 1);
        for id in 10..100 {
            here.hear(
                &Word {
                    id,
                    ..Word::default()
                },
                5,
            );
        }
        assert_eq!(here.peers().len(), MOST);
    }
}
