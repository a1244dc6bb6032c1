//! How well a node's messages come.

use std::time::{Duration, Instant};

/// Rate and loss are those of so long.
const SPAN: Duration = Duration::from_secs(1);
/// Ticks are counted anew after a leap by more than so many.
const LEAP: i64 = 100_000;

/// The messages of one process on its channel.
#[derive(Clone, Debug)]
pub(super) struct Stream {
    pub(super) boot_id: i64,
    pub(super) heard: Instant,
    last_step: i64,
    /// Ticks from one message to the next: the least that has been seen.
    spacing: i64,
    since: Instant,
    received: i64,
    missing: i64,
    rate_hz: f64,
    loss_ratio: f64,
}

impl Stream {
    pub(super) fn new(boot_id: i64, step: i64, now: Instant) -> Self {
        Self {
            boot_id,
            heard: now,
            last_step: step,
            spacing: i64::MAX,
            since: now,
            received: 0,
            missing: 0,
            rate_hz: 0.0,
            loss_ratio: 0.0,
        }
    }

    /// A message of `step` has come. A repeated or overtaken one is none of its own.
    pub(super) fn hear(&mut self, step: i64, now: Instant) {
        self.heard = self.heard.max(now);
        let ticks = step.saturating_sub(self.last_step);
        if ticks.abs() > LEAP {
            self.last_step = step;
        }
        if !(1..=LEAP).contains(&ticks) {
            return;
        }
        self.last_step = step;
        if ticks < self.spacing {
            // What has been counted with a wrong spacing counts no more.
            (self.spacing, self.missing) = (ticks, 0);
        }
        self.received += 1;
        self.missing += ticks / self.spacing - 1;
        let span = now.saturating_duration_since(self.since);
        if span >= SPAN {
            self.rate_hz = self.received as f64 / span.as_secs_f64();
            self.loss_ratio = self.missing as f64 / (self.missing + self.received) as f64;
            (self.since, self.received, self.missing) = (now, 0, 0);
        }
    }

    /// Messages a second; 0 while silent.
    pub(super) fn rate_hz(&self, now: Instant) -> f64 {
        self.unless_silent(now, self.rate_hz)
    }

    /// Share of the messages that has not come here; 0 while silent.
    pub(super) fn loss_ratio(&self, now: Instant) -> f64 {
        self.unless_silent(now, self.loss_ratio)
    }

    fn unless_silent(&self, now: Instant, value: f64) -> f64 {
        match now.saturating_duration_since(self.heard) < 2 * SPAN {
            true => value,
            false => 0.0,
        }
    }
}
