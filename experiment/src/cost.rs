//! What computing costs, in time of a core.

use crate::in_process::{self, Part, Tick};
use node::scenario::Scenario;
use rustix::time::{ClockId, clock_gettime};

/// How often `run`, which does `ticks` ticks, would do a tick in a second of one core; of each of `repetitions`, from the
/// lowest to the highest.
pub fn ticks_per_core_s(ticks: i64, repetitions: u16, run: impl Fn()) -> Vec<f64> {
    let rate = |_| {
        let start_s = core_time_s();
        run();
        ticks as f64 / (core_time_s() - start_s)
    };
    let mut rates: Vec<f64> = (0..repetitions).map(rate).collect();
    rates.sort_by(f64::total_cmp);
    rates
}

/// What `part` alone costs in each tick, s, in the run of `scenario` in which `said` was said; the median of `repetitions`.
pub fn part_s_per_tick(part: Part, scenario: &Scenario, said: &[Tick], repetitions: u16) -> f64 {
    let replay = || in_process::replay(part, scenario, said);
    1.0 / median(&ticks_per_core_s(said.len() as i64, repetitions, replay))
}

/// The median of `sorted`, of which there is at least one.
pub fn median(sorted: &[f64]) -> f64 {
    (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2]) / 2.0
}

/// What this thread has had of a core until now, s.
fn core_time_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
