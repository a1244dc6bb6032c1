//! Counts of what was received and what was not.

use crate::error::Refusal;
use std::ops::Add;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// Messages since the link was started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Decoded, checked and queued.
    pub received: u64,
    /// Taken from a full queue to make room for a newer one.
    pub dropped: u64,
    /// Dropped by the kernel because the socket's buffer was full (counted per link); `None`: it does not tell.
    pub kernel_dropped: Option<u64>,
    /// Wrong fingerprint, length or values.
    pub undecodable: u64,
    /// Packets that are no LCM message of a single packet (counted per link).
    pub malformed: u64,
    /// On channels that are none of this contract's (counted per link).
    pub foreign: u64,
    /// Panics while delivering.
    pub panics: u64,
}

impl Add for Counters {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            received: self.received + other.received,
            dropped: self.dropped + other.dropped,
            kernel_dropped: match (self.kernel_dropped, other.kernel_dropped) {
                (Some(one), Some(other)) => Some(one + other),
                (one, other) => one.or(other),
            },
            undecodable: self.undecodable + other.undecodable,
            malformed: self.malformed + other.malformed,
            foreign: self.foreign + other.foreign,
            panics: self.panics + other.panics,
        }
    }
}

/// [`Counters`] that one thread counts and any thread reads, and the last refusal.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    received: AtomicU64,
    dropped: AtomicU64,
    undecodable: AtomicU64,
    malformed: AtomicU64,
    foreign: AtomicU64,
    panics: AtomicU64,
    refusal: Mutex<Option<Refusal>>,
}

impl Tally {
    /// A message is about to be queued: who takes it finds it counted.
    pub(crate) fn receive(&self) {
        self.received.fetch_add(1, Relaxed);
    }

    pub(crate) fn drop_oldest(&self) {
        self.dropped.fetch_add(1, Relaxed);
    }

    pub(crate) fn pass_over(&self) {
        self.foreign.fetch_add(1, Relaxed);
    }

    pub(crate) fn refuse(&self, refusal: Refusal) {
        let counter = match refusal {
            Refusal::Undecodable(_) => &self.undecodable,
            Refusal::Malformed { .. } => &self.malformed,
            Refusal::Panicked => &self.panics,
        };
        // The refusal first: who sees the count also finds the reason.
        *self.refusal.lock().unwrap_or_else(PoisonError::into_inner) = Some(refusal);
        counter.fetch_add(1, Relaxed);
    }

    pub(crate) fn counters(&self) -> Counters {
        Counters {
            received: self.received.load(Relaxed),
            dropped: self.dropped.load(Relaxed),
            kernel_dropped: None,
            undecodable: self.undecodable.load(Relaxed),
            malformed: self.malformed.load(Relaxed),
            foreign: self.foreign.load(Relaxed),
            panics: self.panics.load(Relaxed),
        }
    }

    pub(crate) fn last_refusal(&self) -> Option<Refusal> {
        self.refusal
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}
