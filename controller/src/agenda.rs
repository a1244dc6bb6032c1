//! Requests that wait for their cycle.
//!
//! In lockstep a request belongs to a cycle like any other input: its `utime` is an instant of simulated time, and the
//! first cycle from then on that has no older one to follow takes it. So a request that is there in time takes effect
//! at the same tick in every run; one whose time is over, such as 0, is taken by the next cycle.

use spatial::TICK_US;
use spatial::ports::Task;

/// How many can wait.
const LENGTH: usize = 16;

/// Requests on their way to the controller, at most one a cycle.
#[derive(Clone, Debug)]
pub struct Agenda(Vec<Task>);

impl Default for Agenda {
    fn default() -> Self {
        Self(Vec::with_capacity(LENGTH))
    }
}

impl Agenda {
    /// Let a request wait; `false`: it waits already, or too many do.
    pub fn add(&mut self, task: &Task) -> bool {
        let same =
            |known: &Task| (known.stamp.boot_id, known.stamp.step) == (task.stamp.boot_id, task.stamp.step);
        let takes = self.0.len() < LENGTH && !self.0.iter().any(same);
        if takes {
            self.0.push(*task);
        }
        takes
    }

    /// The request that the cycle at `tick` is to follow: of those that are due the earliest one, of several senders'
    /// the one with the smaller identity.
    pub fn due(&mut self, tick: i64) -> Option<Task> {
        let order = |i: &usize| {
            let stamp = self.0[*i].stamp;
            (stamp.utime, stamp.boot_id, stamp.step)
        };
        let due = (0..self.0.len()).filter(|&i| self.0[i].stamp.utime <= tick * TICK_US);
        due.min_by_key(order).map(|i| self.0.swap_remove(i))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spatial::ports::Stamp;

    fn task(step: i64, utime: i64) -> Task {
        Task {
            stamp: Stamp {
                step,
                utime,
                boot_id: 7,
            },
            ..Task::default()
        }
    }

    #[test]
    fn each_request_waits_for_its_cycle_and_is_taken_once() {
        let mut agenda = Agenda::default();
        assert!(agenda.add(&task(2, 9_000)) && agenda.add(&task(1, 8_000)));
        assert!(!agenda.add(&task(1, 8_000)), "it waits already");
        let mut taken = |tick| agenda.due(tick).map(|task| task.stamp.step);
        assert_eq!([4, 8, 12, 16].map(&mut taken), [None, Some(1), Some(2), None]);
    }

    #[test]
    fn no_more_wait_than_there_is_room_for() {
        let mut agenda = Agenda::default();
        let accepted = (0..1000).filter(|step| agenda.add(&task(*step, 0))).count();
        assert_eq!(accepted, LENGTH);
    }
}
