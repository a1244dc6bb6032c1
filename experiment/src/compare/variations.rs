//! One experiment at several contact phases and seeds.

use crate::in_process;
use crate::metrics::{Metrics, NoFigures, Recording};
use node::scenario::Scenario;
use rayon::prelude::*;
use spatial::TICK_S;
use std::ops::Range;

/// The same experiment at `phases` contact phases relative to T and with `seeds` seeds each: the tool starts
/// higher by the way it travels in a fraction of T.
///
/// The fractions are multiples of the golden ratio, modulo 1: well spread over T *and* over 1 ms, as multiples of
/// 1 ms are not (PLANT.md section 2).
pub fn variations(scenario: &Scenario, phases: usize, seeds: usize) -> Vec<Scenario> {
    variations_from(scenario, 0..phases, 0..seeds as i64)
}

/// The same for the `phases` with these numbers, whose contact phases are all different, and for `seeds` beyond the
/// scenario's.
pub fn variations_from(scenario: &Scenario, phases: Range<usize>, seeds: Range<i64>) -> Vec<Scenario> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let period_s = scenario.timing.command_period_ticks as f64 * TICK_S;
    let mut all = Vec::new();
    for phase in phases {
        let fraction = (phase as f64 + 0.5) * GOLDEN;
        let fraction = fraction - libm::floor(fraction);
        for seed in seeds.clone() {
            let mut varied = scenario.clone();
            varied.task.start_position_m[2] += fraction * period_s * scenario.task.approach_speed_m_per_s;
            // From the largest seed on to 0.
            varied.timing.seed = varied.timing.seed.wrapping_add(seed) & i64::MAX;
            all.push(varied);
        }
    }
    all
}

/// The figures of all `variations` in their order, calling `done` after every run. They do not depend on the
/// number of threads.
pub fn outcomes(variations: &[Scenario], done: impl Fn() + Sync) -> Vec<Result<Metrics, NoFigures>> {
    let outcome = |scenario| {
        let outcome = metrics(scenario);
        done();
        outcome
    };
    variations.par_iter().map(outcome).collect()
}

/// The figures of one run in process.
pub fn metrics(scenario: &Scenario) -> Result<Metrics, NoFigures> {
    let mut recording = Recording::new(scenario);
    in_process::run(scenario, |tick| recording.observe(tick));
    recording.metrics()
}
