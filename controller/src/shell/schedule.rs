//! When the next cycle begins, and of which tick; pure.
//!
//! A cycle begins with the later of the robot's state and the deflections of its tick; without the deflections T/4 after the
//! state; without a state T/4 after the instant at which it should have come, which is T after the last one.

use node::peers::SILENT;
use spatial::TICK_US;
use std::time::{Duration, Instant};

/// What has come, and what is waited for.
#[derive(Clone, Debug)]
pub(super) struct Schedule {
    period_ticks: i64,
    /// For so long cycles go on without a state.
    longest: Duration,
    /// Tick of the robot's newest state, and of one that no cycle has used.
    newest_state: Option<Newest>,
    waiting_state: Option<i64>,
    /// Tick of the newest deflections.
    newest_deflections: Option<Newest>,
    /// Tick of the last cycle.
    last: Option<i64>,
    /// Cycles without a state since the last one.
    without: i64,
    due: Option<Instant>,
}

/// The newest of a device's messages.
#[derive(Clone, Copy, Debug)]
struct Newest {
    step: i64,
    came: Instant,
}

impl Newest {
    /// Whether it can't have been true, if a message of tick `step` has come `at` an instant: nobody's ticks go back for long.
    fn has_lied(&self, step: i64, at: Instant) -> bool {
        step < self.step && at.saturating_duration_since(self.came) > SILENT
    }
}

/// A cycle that begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cycle {
    /// Its tick.
    pub(super) tick: i64,
    /// When it was due.
    pub(super) due: Instant,
    /// The state of its tick is there, or an older one.
    pub(super) with_state: bool,
}

impl Schedule {
    /// Of cycles `period_ticks` apart; a robot that is silent for `longest` is waited for.
    pub(super) fn new(period_ticks: i64, longest: Duration) -> Self {
        Self {
            period_ticks,
            longest,
            newest_state: None,
            waiting_state: None,
            newest_deflections: None,
            last: None,
            without: 0,
            due: None,
        }
    }

    /// When the next cycle begins with what is there; `None`: not before something comes.
    pub(super) fn due(&self) -> Option<Instant> {
        self.due
    }

    /// The robot's state of tick `step` has come `at` an instant: how many were lost before it; `None`: it is not new.
    pub(super) fn take_state(&mut self, step: i64, at: Instant) -> Option<i64> {
        let before = self.newest_state.map(|newest| newest.step);
        if before.is_some_and(|newest| step <= newest) {
            return None;
        }
        (self.newest_state, self.waiting_state) = (Some(Newest { step, came: at }), Some(step));
        self.without = 0;
        self.due = Some(match self.last {
            // Its cycle has been run without it. The next one is due when the robot is there: its time may have slipped.
            Some(last) if step <= last => at + self.ticks(last + self.period_ticks - step) + self.patience(),
            _ if self.newest_deflections.is_some_and(|newest| newest.step >= step) => at,
            _ => at + self.patience(),
        });
        Some(before.map_or(0, |newest| ((step - newest) / self.period_ticks - 1).max(0)))
    }

    /// The deflections of tick `step` have come `at` an instant: how many were lost before them; `None`: they are not new.
    pub(super) fn take_deflections(&mut self, step: i64, at: Instant) -> Option<i64> {
        let before = self.newest_deflections.map(|newest| newest.step);
        if before.is_some_and(|newest| step <= newest) {
            return None;
        }
        self.newest_deflections = Some(Newest { step, came: at });
        let waits = |state: i64| step >= state && self.last.is_none_or(|last| state > last);
        if self.waiting_state.is_some_and(waits) {
            self.due = Some(at);
        }
        Some(before.map_or(0, |newest| step - newest - 1))
    }

    /// Whether the robot's newest state has been a lie, as one of tick `step` shows that has come `at` an instant.
    pub(super) fn misled_by_state(&self, step: i64, at: Instant) -> bool {
        self.newest_state.is_some_and(|newest| newest.has_lied(step, at))
    }

    /// The same of the newest deflections.
    pub(super) fn misled_by_deflections(&self, step: i64, at: Instant) -> bool {
        self.newest_deflections
            .is_some_and(|newest| newest.has_lied(step, at))
    }

    /// Another sensor: its ticks are counted anew.
    pub(super) fn forget_sensor(&mut self) {
        self.newest_deflections = None;
    }

    /// The cycle that is due `now`, which begins.
    pub(super) fn begin(&mut self, now: Instant) -> Option<Cycle> {
        let due = self.due.filter(|due| *due <= now)?;
        let state = self.waiting_state.take();
        let next = self.last.map(|last| last + self.period_ticks);
        let Some(tick) = state.max(next.filter(|next| state.is_none_or(|state| state < *next))) else {
            self.due = None;
            return None;
        };
        self.last = Some(tick);
        // When the next state should have come, and T/4 more. A cycle without its state began T/4 late already.
        let late = if state == Some(tick) {
            self.patience()
        } else {
            Duration::ZERO
        };
        self.due = Some(due + self.ticks(self.period_ticks) + late);
        if state.is_none() {
            self.without += 1;
            // Its silence has been told by then. A robot that comes back, its time having stood still, must not find commands
            // of a future that it takes long to reach.
            if self.ticks(self.without * self.period_ticks) > self.longest {
                self.due = None;
            }
        }
        Some(Cycle {
            tick,
            due,
            with_state: state.is_some(),
        })
    }

    /// How long a cycle waits for what it lacks.
    fn patience(&self) -> Duration {
        self.ticks(self.period_ticks) / 4
    }

    fn ticks(&self, ticks: i64) -> Duration {
        Duration::from_micros(ticks.saturating_mul(TICK_US).unsigned_abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use node::clock;

    const MS: Duration = Duration::from_millis(1);

    fn schedule() -> (Schedule, Instant) {
        (Schedule::new(4, 20 * MS), clock::now())
    }

    /// The ticks of the cycles that begin, looked at every quarter of a millisecond, while state and deflections of tick n
    /// come n ms after the start as `comes` says: how late, ms; `None`: not at all.
    fn cycles(
        schedule: &mut Schedule,
        start: Instant,
        ticks: std::ops::Range<i64>,
        comes: impl Fn(i64) -> [Option<f64>; 2],
    ) -> Vec<(i64, f64)> {
        let mut found = Vec::new();
        for quarter in 4 * ticks.start..4 * ticks.end {
            let ms = 0.25 * quarter as f64;
            let now = start + MS.mul_f64(ms);
            for step in ticks.start..=quarter / 4 {
                let here = |late: Option<f64>| late.is_some_and(|late| step as f64 + late == ms);
                let [state, deflections] = comes(step);
                if step % 4 == 0 && here(state) {
                    schedule.take_state(step, now);
                }
                if here(deflections) {
                    schedule.take_deflections(step, now);
                }
            }
            if let Some(cycle) = schedule.begin(now) {
                found.push((cycle.tick, ms));
            }
        }
        found
    }

    #[test]
    fn a_cycle_begins_with_what_comes_later() {
        for comes in [[Some(0.25), Some(0.5)], [Some(0.5), Some(0.25)]] {
            let (mut schedule, start) = schedule();
            let found = cycles(&mut schedule, start, 0..13, |_| comes);
            assert_eq!(found, [(0, 0.5), (4, 4.5), (8, 8.5), (12, 12.5)]);
        }
    }

    #[test]
    fn what_is_missing_is_waited_for_a_quarter_of_a_period() {
        let (mut schedule, start) = schedule();
        let found = cycles(&mut schedule, start, 0..21, |step| match step {
            4 => [Some(0.0), None],
            5..8 => [None, None],
            8 => [None, Some(0.0)],
            _ => [Some(0.0), Some(0.0)],
        });
        assert_eq!(
            found,
            [(0, 0.0), (4, 5.0), (8, 10.0), (12, 12.0), (16, 16.0), (20, 20.0)]
        );
    }

    /// The robot's time slips by 3 ms: one cycle is run without its state, and then the states are waited for again.
    #[test]
    fn after_a_slip_the_robot_leads_again() {
        let (mut schedule, start) = schedule();
        let found = cycles(&mut schedule, start, 0..30, |step| match step {
            ..8 => [Some(0.0), Some(0.0)],
            _ => [Some(3.0), Some(3.0)],
        });
        let ticks: Vec<_> = found.iter().map(|cycle| cycle.0).collect();
        assert_eq!(ticks, [0, 4, 8, 12, 16, 20, 24]);
        assert_eq!(
            found[2..],
            [(8, 9.0), (12, 15.0), (16, 19.0), (20, 23.0), (24, 27.0)]
        );
    }

    #[test]
    fn a_robot_that_is_gone_is_not_run_ahead_of() {
        let (mut schedule, start) = schedule();
        let found = cycles(&mut schedule, start, 0..200, |step| match step {
            ..8 => [Some(0.0), Some(0.0)],
            _ => [None, None],
        });
        assert_eq!(found.last().unwrap().0, 28);
        assert_eq!(schedule.due(), None);
        // Back after its time has stood still.
        let back = start + 500 * MS;
        assert_eq!(schedule.take_state(8, back), Some(0));
        assert_eq!(schedule.due(), Some(back + 25 * MS));
    }

    /// Somebody has said in a device's name that it is far ahead: half a second later it is believed again.
    #[test]
    fn a_tick_of_the_future_is_not_believed_for_ever() {
        let (mut schedule, start) = schedule();
        assert_eq!(schedule.take_state(8_000_000, start), Some(0));
        assert_eq!(schedule.take_deflections(8_000_000, start), Some(0));
        for (ms, misled) in [(4, false), (500, false), (501, true)] {
            let at = start + ms * MS;
            assert_eq!(schedule.misled_by_state(8, at), misled);
            assert_eq!(schedule.misled_by_deflections(8, at), misled);
        }
        assert!(
            !schedule.misled_by_state(8_000_000, start + 1000 * MS),
            "it stands still"
        );
    }

    #[test]
    fn what_was_lost_is_counted_and_what_is_old_is_not_taken() {
        let (mut schedule, start) = schedule();
        assert_eq!(
            [0, 4, 16, 12].map(|step| schedule.take_state(step, start)),
            [Some(0), Some(0), Some(2), None]
        );
        assert_eq!(
            [0, 1, 4, 2].map(|step| schedule.take_deflections(step, start)),
            [Some(0), Some(0), Some(2), None]
        );
    }
}
