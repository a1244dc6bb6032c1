//! When a tick of the simulated world is on the own clock.
//!
//! A real sensor reads its clock when it samples. The simulated one samples at the ticks of robot-sim, whose message tells
//! when that was on *its* clock; the fastest message of the last seconds tells how the clocks differ.

/// A fastest message is remembered for one to two times as long, us.
const SPAN_US: i64 = 4_000_000;

/// From robot-sim's clock to the own one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Offset {
    /// The smallest difference of the present span and of the one before, us.
    smallest: [Option<i64>; 2],
    began_utime: i64,
}

impl Offset {
    /// A message that tells of `sent_utime` (robot-sim's clock) has come at `arrived_utime` (own clock); how far the own
    /// clock is ahead, us, at most the fastest message's way too much.
    pub(super) fn take(&mut self, sent_utime: i64, arrived_utime: i64) -> i64 {
        let ahead = arrived_utime.saturating_sub(sent_utime);
        if arrived_utime.saturating_sub(self.began_utime) >= SPAN_US {
            self.smallest = [None, self.smallest[0]];
            self.began_utime = arrived_utime;
        }
        let smallest = self.smallest[0].map_or(ahead, |known| known.min(ahead));
        self.smallest[0] = Some(smallest);
        self.smallest[1].map_or(smallest, |known| known.min(smallest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fastest_message_counts_and_is_forgotten_in_time() {
        let mut offset = Offset::default();
        let second = 1_000_000;
        assert_eq!(offset.take(10 * second, 10 * second + 700), 700);
        assert_eq!(offset.take(11 * second, 11 * second + 300), 300);
        assert_eq!(offset.take(12 * second, 12 * second + 900), 300);
        // The next span still knows it, the one after does not.
        assert_eq!(offset.take(15 * second, 15 * second + 900), 300);
        assert_eq!(offset.take(20 * second, 20 * second + 800), 800);
    }
}
