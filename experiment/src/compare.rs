//! Every law on every plant over contact phases and seeds, in process and on all cores.

use crate::in_process;
use crate::metrics::{Metrics, Recording, WINDOW_S};
use crate::table::Row;
use node::scenario::{Scenario, ScenarioError};
use rayon::prelude::*;
use serde::Serialize;
use spatial::TICK_S;
use std::fmt::{Display, Formatter};

/// What to compare: all combinations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Matrix {
    /// Words of `robot.gears`.
    pub robots: Vec<String>,
    /// Words of `robot.kinematics`.
    pub kinematics: Vec<String>,
    /// Words of `controller.law`.
    pub laws: Vec<String>,
    /// Contact phases relative to T.
    pub phases: usize,
    /// Seeds for each of them.
    pub seeds: usize,
}

/// One row for every combination, or the runs that stand in its way.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// The combinations all of whose runs gave figures.
    pub rows: Vec<Row>,
    /// The runs that gave none.
    pub failures: Vec<Failure>,
}

/// A run that gave no figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    /// What joins motor and link.
    pub robot: String,
    /// Kinematics.
    pub kinematics: String,
    /// Control law.
    pub law: String,
    /// Contact phase, from 1.
    pub phase: usize,
    /// Seed of the run.
    pub seed: i64,
    /// What went wrong.
    pub reason: String,
}

impl Display for Failure {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let Self {
            robot,
            kinematics,
            law,
            phase,
            seed,
            reason,
        } = self;
        write!(
            f,
            "law {law} on {robot} {kinematics}, phase {phase}, seed {seed}: {reason}"
        )
    }
}

/// Why a run gave no figures.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoFigures {
    /// The tool never met the object.
    #[error(
        "no contact within {duration_s} s; raise timing.duration_s or task.search_depth_m, or check object.height_m"
    )]
    NoContact {
        /// Length of the run, s.
        duration_s: f64,
    },
    /// It ended too early.
    #[error(
        "contact at {contact_s:.3} s and end at {duration_s} s leave less than the \
         {WINDOW_S} s that are judged; raise timing.duration_s"
    )]
    TooShort {
        /// First contact, s.
        contact_s: f64,
        /// Length of the run, s.
        duration_s: f64,
    },
}

impl Matrix {
    /// Runs in all.
    pub fn runs(&self) -> usize {
        self.robots.len() * self.kinematics.len() * self.laws.len() * self.phases * self.seeds
    }

    /// Run all combinations on the rest of `scenario`, calling `done` after every run. What can't be combined is
    /// refused before the first run.
    pub fn run(&self, scenario: &Scenario, done: impl Fn() + Sync) -> Result<Comparison, ScenarioError> {
        let mut plan = Vec::new();
        for robot in &self.robots {
            for kinematics in &self.kinematics {
                for law in &self.laws {
                    let varied = scenario.with(&[
                        format!("robot.gears={robot}"),
                        format!("robot.kinematics={kinematics}"),
                        format!("controller.law={law}"),
                    ])?;
                    plan.push((
                        robot,
                        kinematics,
                        law,
                        variations(&varied, self.phases, self.seeds),
                    ));
                }
            }
        }
        let mut comparison = Comparison::default();
        for (robot, kinematics, law, variations) in plan {
            let outcomes = outcomes(&variations, &done);
            for (i, outcome) in outcomes.iter().enumerate() {
                if let Err(reason) = outcome {
                    comparison.failures.push(Failure {
                        robot: robot.clone(),
                        kinematics: kinematics.clone(),
                        law: law.clone(),
                        phase: i / self.seeds + 1,
                        seed: variations[i].timing.seed,
                        reason: reason.to_string(),
                    });
                }
            }
            if let Some(Summary { runs, mean, worst }) = Summary::of(&outcomes) {
                comparison.rows.push(Row {
                    robot: robot.clone(),
                    kinematics: kinematics.clone(),
                    law: law.clone(),
                    runs,
                    mean,
                    worst,
                });
            }
        }
        Ok(comparison)
    }
}

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

impl Summary {
    /// The summary of `outcomes`; `None` if one of them has no figures, or if there are none.
    pub fn of(outcomes: &[Result<Metrics, NoFigures>]) -> Option<Self> {
        let (mut mean, mut worst) = ([0.0; 7], [0.0f64; 7]);
        for outcome in outcomes {
            for (i, value) in outcome.as_ref().ok()?.values().into_iter().enumerate() {
                mean[i] += value / outcomes.len() as f64;
                // A figure that is not a number is the worst of all.
                if value.abs().total_cmp(&worst[i].abs()).is_ge() {
                    worst[i] = value;
                }
            }
        }
        (!outcomes.is_empty()).then(|| Self {
            runs: outcomes.len(),
            mean: Metrics::from_values(mean),
            worst: Metrics::from_values(worst),
        })
    }
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
            // From the largest seed on to 0.
            varied.timing.seed = varied.timing.seed.wrapping_add(seed as i64) & i64::MAX;
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
    in_process::run(scenario, |tick| recording.push(&tick.sensor.truth));
    let duration_s = scenario.timing.duration_s;
    recording.metrics().ok_or(match recording.first_contact_s() {
        None => NoFigures::NoContact { duration_s },
        Some(contact_s) => NoFigures::TooShort {
            contact_s,
            duration_s,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(laws: &[&str], phases: usize) -> Matrix {
        Matrix {
            robots: vec!["rigid".to_owned()],
            kinematics: vec!["gantry".to_owned()],
            laws: laws.iter().map(|&law| law.to_owned()).collect(),
            phases,
            seeds: 2,
        }
    }

    fn scenario(overrides: &[&str]) -> Scenario {
        let overrides: Vec<_> = overrides.iter().map(|&text| text.to_owned()).collect();
        Scenario::default().with(&overrides).unwrap()
    }

    #[test]
    fn runs_without_figures_are_named_one_by_one() {
        let comparison = matrix(&["pd", "proposed"], 1)
            .run(&scenario(&["timing.duration_s=0.5", "timing.seed=7"]), || ())
            .unwrap();
        assert!(comparison.rows.is_empty());
        let failures: Vec<_> = comparison.failures.iter().map(Failure::to_string).collect();
        assert_eq!(failures.len(), 4);
        assert!(
            failures[1]
                .starts_with("law pd on rigid gantry, phase 1, seed 8: no contact within 0.5 s; raise"),
            "{failures:?}"
        );
        assert!(failures[2].starts_with("law proposed on"), "{failures:?}");
    }

    /// PLANT.md section 6, rigid: peak at most 17 N, settled within 60 ms.
    #[test]
    fn the_arm_with_rigid_gears_attains_what_the_gantry_must() {
        let arm = crate::scenarios::Source::find("arm")
            .unwrap()
            .scenario(&[])
            .unwrap();
        let Summary { worst, .. } = Summary::of(&outcomes(&variations(&arm, 8, 1), || ())).unwrap();
        assert!(
            worst.peak_n <= 17.0 && worst.settling_10_s <= 0.060 && worst.iae_n_s <= 0.32,
            "{worst:?}"
        );
    }

    #[test]
    fn every_kinematics_runs_on_every_scenario() {
        let both = Matrix {
            kinematics: vec!["gantry".to_owned(), "arm".to_owned()],
            seeds: 1,
            ..matrix(&["proposed"], 1)
        };
        for name in crate::scenarios::names() {
            let scenario = crate::scenarios::Source::find(name)
                .unwrap()
                .scenario(&[])
                .unwrap();
            let comparison = both.run(&scenario, || ()).unwrap();
            assert_eq!(
                (comparison.rows.len(), comparison.failures.len()),
                (2, 0),
                "{name}"
            );
        }
    }

    #[test]
    fn a_run_that_ends_early_says_so() {
        let outcome = metrics(&scenario(&["timing.duration_s=2.0"]));
        assert!(matches!(outcome, Err(NoFigures::TooShort { .. })), "{outcome:?}");
    }

    #[test]
    fn seeds_go_on_from_the_largest_to_zero() {
        let seed = format!("timing.seed={}", i64::MAX);
        let seeds: Vec<_> = variations(&scenario(&[&seed]), 1, 3)
            .iter()
            .map(|varied| varied.timing.seed)
            .collect();
        assert_eq!(seeds, [i64::MAX, 0, 1]);
    }

    #[test]
    fn a_figure_that_is_no_number_is_not_hidden() {
        let rows = [1.0, f64::NAN, 2.0].map(|peak_n| {
            Ok(Metrics {
                peak_n,
                ..Metrics::default()
            })
        });
        let summary = Summary::of(&rows).unwrap();
        assert!(summary.worst.peak_n.is_nan() && summary.mean.peak_n.is_nan());
    }
}
