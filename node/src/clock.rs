//! The only place that reads a clock (DESIGN: invariant 1).

use rustix::time::{ClockId, clock_gettime};
use std::time::{Duration, Instant};

/// Now, on the monotonic clock.
#[expect(clippy::disallowed_methods, reason = "the one place where time enters")]
pub fn now() -> Instant {
    Instant::now()
}

/// A node's own clock as its messages tell it: microseconds (`utime`) of an instant.
///
/// Two nodes' clocks need not agree in anything; [`crate::clock_sync`] measures how they differ.
pub trait Clock {
    /// `utime` at `instant`, us.
    fn utime(&self, instant: Instant) -> i64;
}

/// The host's monotonic clock, with the wall clock's epoch as it was at the start: a step of the wall clock changes
/// nothing.
#[derive(Clone, Copy, Debug)]
pub struct HostClock {
    started: Instant,
    /// The wall clock at the start, us since 1970.
    epoch_utime: i64,
}

impl HostClock {
    /// A clock that starts now.
    pub fn start() -> Self {
        let wall = clock_gettime(ClockId::Realtime);
        Self {
            started: now(),
            epoch_utime: wall.tv_sec * 1_000_000 + wall.tv_nsec / 1000,
        }
    }
}

impl Clock for HostClock {
    fn utime(&self, instant: Instant) -> i64 {
        self.epoch_utime + since(self.started, instant)
    }
}

/// A clock that goes wrong by a known amount, for tests.
#[derive(Clone, Copy, Debug)]
pub struct SkewedClock<C> {
    /// The right one.
    pub clock: C,
    /// When the error began.
    pub since: Instant,
    /// How far it is ahead then, s.
    pub offset_s: f64,
    /// How much faster it goes, 1e-6.
    pub drift_ppm: f64,
}

impl<C: Clock> Clock for SkewedClock<C> {
    fn utime(&self, instant: Instant) -> i64 {
        let elapsed = since(self.since, instant) as f64;
        let ahead = 1e6 * self.offset_s + 1e-6 * self.drift_ppm * elapsed;
        self.clock.utime(instant) + libm::rint(ahead) as i64
    }
}

/// Microseconds from one instant to another, negative if it is earlier.
fn since(from: Instant, to: Instant) -> i64 {
    let us = |duration: Duration| i64::try_from(duration.as_micros()).unwrap_or(i64::MAX);
    match to.checked_duration_since(from) {
        Some(later) => us(later),
        None => -us(from.duration_since(to)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_skewed_clock_is_wrong_by_what_it_is_told() {
        let clock = HostClock::start();
        let skewed = SkewedClock {
            clock,
            since: clock.started,
            offset_s: 0.012,
            drift_ppm: 20.0,
        };
        let ahead = |s: u64| {
            let instant = clock.started + Duration::from_secs(s);
            skewed.utime(instant) - clock.utime(instant)
        };
        assert_eq!([0, 100, 1000].map(ahead), [12_000, 14_000, 32_000]);
    }

    #[test]
    fn time_before_the_start_is_negative() {
        let clock = HostClock::start();
        let earlier = clock.started - Duration::from_micros(1500);
        assert_eq!(clock.utime(earlier) - clock.utime(clock.started), -1500);
    }
}
