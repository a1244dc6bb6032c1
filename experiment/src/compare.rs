//! Every law on one plant over contact phases and seeds, in process and on all cores.

use crate::in_process;
use crate::metrics::{Metrics, Recording};
use node::scenario::Scenario;
use rayon::prelude::*;
use spatial::TICK_S;

/// Mean and worst of the figures over phases and seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Runs.
    pub runs: usize,
    /// Mean of each figure.
    pub mean: Metrics,
    /// Largest magnitude of each figure.
    pub worst: Metrics,
}

/// The same experiment at `phases` contact phases relative to T and with `seeds` seeds each: the tool starts
/// higher by the way it travels in a fraction of T.
///
/// The fractions are multiples of the golden ratio, modulo 1: well spread over T *and* over 1 ms, as multiples of
/// 1 ms are not (PLANT.md section 2).
pub fn variations(scenario: &Scenario, phases: usize, seeds: usize) -> Vec<Scenario> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let period_s = scenario.timing.command_period_ticks as f64 * TICK_S;
    let mut all = Vec::with_capacity(phases * seeds);
    for phase in 0..phases {
        let fraction = (phase as f64 + 0.5) * GOLDEN;
        let fraction = fraction - libm::floor(fraction);
        for seed in 0..seeds {
            let mut varied = scenario.clone();
            varied.task.start_position_m[2] += fraction * period_s * scenario.task.approach_speed_m_per_s;
            varied.timing.seed += seed as i64;
            all.push(varied);
        }
    }
    all
}

/// Run all `variations` and summarise their figures; `None` where a run made no contact. The result does not
/// depend on the number of threads.
pub fn summarise(variations: &[Scenario]) -> Option<Summary> {
    let rows: Vec<Option<Metrics>> = variations.par_iter().map(metrics).collect();
    let rows: Vec<Metrics> = rows.into_iter().collect::<Option<_>>()?;
    let count = rows.len() as f64;
    let (mut mean, mut worst) = ([0.0; 7], [0.0f64; 7]);
    for row in &rows {
        for (i, value) in row.values().into_iter().enumerate() {
            mean[i] += value / count;
            if value.abs() >= worst[i].abs() {
                worst[i] = value;
            }
        }
    }
    Some(Summary {
        runs: rows.len(),
        mean: Metrics::from_values(mean),
        worst: Metrics::from_values(worst),
    })
}

/// The figures of one run in process.
pub fn metrics(scenario: &Scenario) -> Option<Metrics> {
    let mut recording = Recording::new(scenario);
    in_process::run(scenario, |tick| recording.push(&tick.sensor.truth));
    recording.metrics()
}
