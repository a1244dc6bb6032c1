//! Who answers what in lockstep, as pure functions of messages and durations.
//!
//! The robot is the clock master and the only node with a retransmission timer; sensor and controller react.
//! A lost datagram is thus repeated from one place, and a repeated one never multiplies.

use spatial::TICK_US;
use spatial::ports::Stamp;
use std::time::Duration;

/// What a reactive node does with a message of some tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The next tick: compute, publish and remember the answers.
    Compute,
    /// The tick answered last: publish the remembered answers again.
    Repeat,
    /// An older tick: a late duplicate.
    Ignore,
    /// A tick was skipped, or the peer is another process than before.
    Broken,
}

/// Keeps a reactive node in step with the clock master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Follower {
    last: i64,
    stride: i64,
    master_boot_id: i64,
}

impl Follower {
    /// Follows a master with `boot_id` that begins with tick 0 and goes on in strides of `stride` ticks.
    pub fn new(stride: i64, master_boot_id: i64) -> Self {
        Self::starting_at(0, stride, master_boot_id)
    }

    /// The same from tick `first` on.
    pub fn starting_at(first: i64, stride: i64, master_boot_id: i64) -> Self {
        Self {
            last: first - stride,
            stride,
            master_boot_id,
        }
    }

    /// The tick expected next.
    pub fn expected(&self) -> i64 {
        self.last + self.stride
    }

    /// Tick and process expected next.
    pub fn expected_stamp(&self) -> Stamp {
        let step = self.expected();
        Stamp {
            step,
            utime: step * TICK_US,
            boot_id: self.master_boot_id,
        }
    }

    /// What to do with a message of `step` from the process `boot_id`. After `Compute` that tick is the last one.
    pub fn classify(&mut self, step: i64, boot_id: i64) -> Answer {
        if boot_id != self.master_boot_id || step > self.expected() {
            return Answer::Broken;
        }
        if step == self.expected() {
            self.last = step;
            return Answer::Compute;
        }
        if step == self.last {
            Answer::Repeat
        } else {
            Answer::Ignore
        }
    }
}

/// When the clock master repeats the messages of an unanswered tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Retransmission {
    smoothed_tick_s: f64,
}

/// How long a peer may stay silent before the run is given up.
pub const PEER_SILENT: Duration = Duration::from_secs(3);
/// The longest wait between two repeats.
const LONGEST: Duration = Duration::from_millis(100);
/// The shortest wait before the first repeat.
const SHORTEST: Duration = Duration::from_millis(1);
/// Weight of a new tick in the smoothed duration.
const SMOOTHING: f64 = 0.05;

impl Default for Retransmission {
    fn default() -> Self {
        Self {
            smoothed_tick_s: LONGEST.as_secs_f64() / 8.0,
        }
    }
}

impl Retransmission {
    /// Remember how long a tick took, from its first sending to its last answer: with repeats an upper bound, so
    /// that the timer follows a machine that has become slower.
    pub fn observe(&mut self, tick: Duration) {
        self.smoothed_tick_s += SMOOTHING * (tick.as_secs_f64() - self.smoothed_tick_s);
    }

    /// How long to wait before repeating for the `repeats`-th time (0: the first): 8 times the smoothed tick, at
    /// least 1 ms, doubling to 100 ms.
    pub fn wait(&self, repeats: u32) -> Duration {
        let first = Duration::from_secs_f64(8.0 * self.smoothed_tick_s).max(SHORTEST);
        first
            .saturating_mul(1u32.checked_shl(repeats).unwrap_or(u32::MAX))
            .min(LONGEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_follower_computes_each_tick_once() {
        let mut follower = Follower::new(4, 77);
        assert_eq!(follower.classify(0, 77), Answer::Compute);
        assert_eq!(follower.classify(0, 77), Answer::Repeat);
        assert_eq!(follower.classify(4, 77), Answer::Compute);
        assert_eq!(follower.classify(0, 77), Answer::Ignore);
        assert_eq!(follower.classify(12, 77), Answer::Broken);
        assert_eq!(follower.classify(8, 78), Answer::Broken);
        assert_eq!(follower.classify(8, 77), Answer::Compute);
    }

    #[test]
    fn waits_double_from_eight_ticks_to_a_tenth_of_a_second() {
        let mut timer = Retransmission::default();
        assert_eq!(timer.wait(0), LONGEST);
        for _ in 0..1000 {
            timer.observe(Duration::from_micros(200));
        }
        let first = timer.wait(0);
        assert!((first.as_secs_f64() - 1.6e-3).abs() < 1e-5, "{first:?}");
        assert_eq!(timer.wait(1), first * 2);
        assert_eq!(timer.wait(40), LONGEST);
        for _ in 0..1000 {
            timer.observe(Duration::from_micros(10));
        }
        assert_eq!(timer.wait(0), SHORTEST);
    }
}
