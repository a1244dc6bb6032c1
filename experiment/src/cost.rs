//! What computing costs, in time of a core.

use crate::compare::{outcomes, variations};
use crate::in_process::{self, Part, Tick};
use node::clock;
use node::scenario::Scenario;
use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;

/// Contact phases and seeds of the runs of which [`scaling`] measures how they share the cores.
const RUNS: [usize; 2] = [16, 4];

/// How many times as fast as on one thread the runs of a sweep are on several.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Scaling {
    /// On how many.
    pub threads: usize,
    /// Of how many runs.
    pub runs: usize,
    /// The median of all pairs of measurements, one after the other.
    pub speed_up: f64,
    /// The lowest pair.
    pub speed_up_min: f64,
    /// The highest pair.
    pub speed_up_max: f64,
    /// The median divided by the threads, or by the cores where there are fewer.
    pub speed_up_per_core: f64,
}

/// Time variations of `scenario`, as a sweep runs them, on one thread and on `threads`, `repetitions` times in turns.
pub fn scaling(
    scenario: &Scenario,
    threads: usize,
    repetitions: u16,
) -> Result<Scaling, ThreadPoolBuildError> {
    let runs = variations(scenario, RUNS[0], RUNS[1]);
    let pools = [1, threads].map(|count| ThreadPoolBuilder::new().num_threads(count).build());
    let [one, all] = pools;
    let (one, all) = (one?, all?);
    let seconds = |pool: &rayon::ThreadPool| {
        let started = clock::now();
        pool.install(|| outcomes(&runs, || ()));
        (clock::now() - started).as_secs_f64()
    };
    let mut ratios: Vec<f64> = (0..repetitions).map(|_| seconds(&one) / seconds(&all)).collect();
    ratios.sort_by(f64::total_cmp);
    let cores = std::thread::available_parallelism().map_or(threads, usize::from);
    let speed_up = median(&ratios);
    Ok(Scaling {
        threads,
        runs: runs.len(),
        speed_up,
        speed_up_min: ratios[0],
        speed_up_max: ratios[ratios.len() - 1],
        speed_up_per_core: speed_up / threads.min(cores) as f64,
    })
}

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
pub(crate) fn core_time_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
