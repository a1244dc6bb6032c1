//! Every law on every plant over contact phases and seeds, in process and on all cores.

mod summary;
mod variations;

pub use summary::Summary;
pub use variations::{metrics, outcomes, variations, variations_from};

use crate::table::Row;
use crate::tuning::{Gains, Tuned, TuningError};
use node::scenario::Scenario;
use serde::Serialize;
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
    /// With which gains.
    pub gains: Vec<Gains>,
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
    /// With which gains.
    pub gains: Gains,
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
            gains,
            phase,
            seed,
            reason,
        } = self;
        write!(
            f,
            "law {law}{} on {robot} {kinematics}, phase {phase}, seed {seed}: {reason}",
            gains.suffix()
        )
    }
}

impl Matrix {
    /// Runs in all, or fewer where a law has nothing to tune.
    pub fn runs(&self) -> usize {
        let combinations = self.robots.len() * self.kinematics.len() * self.laws.len() * self.gains.len();
        combinations * self.phases * self.seeds
    }

    /// Run all combinations on the rest of `scenario`, with tuned gains from `tuned`, calling `done` after every run.
    /// What can't be combined is refused before the first run. A law that has nothing to tune has no tuned row.
    pub fn run(
        &self,
        scenario: &Scenario,
        tuned: &Tuned,
        done: impl Fn() + Sync,
    ) -> Result<Comparison, TuningError> {
        let mut plan = Vec::new();
        for robot in &self.robots {
            for kinematics in &self.kinematics {
                for law in &self.laws {
                    let varied = scenario.with(&[
                        format!("robot.gears={robot}"),
                        format!("robot.kinematics={kinematics}"),
                        format!("controller.law={law}"),
                    ])?;
                    for &gains in &self.gains {
                        let Some(varied) = tuned.apply(gains, &varied)? else {
                            continue;
                        };
                        let runs = variations(&varied, self.phases, self.seeds);
                        plan.push((robot, kinematics, law, gains, runs));
                    }
                }
            }
        }
        let mut comparison = Comparison::default();
        for (robot, kinematics, law, gains, variations) in plan {
            let outcomes = outcomes(&variations, &done);
            for (i, outcome) in outcomes.iter().enumerate() {
                if let Err(reason) = outcome {
                    comparison.failures.push(Failure {
                        robot: robot.clone(),
                        kinematics: kinematics.clone(),
                        law: law.clone(),
                        gains,
                        phase: i / self.seeds + 1,
                        seed: variations[i].timing.seed,
                        reason: reason.to_string(),
                    });
                }
            }
            if let Some(summary) = Summary::over_phases(&outcomes, self.seeds) {
                comparison.rows.push(Row {
                    robot: robot.clone(),
                    kinematics: kinematics.clone(),
                    law: law.clone(),
                    gains,
                    runs: summary.runs,
                    mean: summary.mean,
                    worst: summary.worst,
                    confidence: summary.confidence,
                });
            }
        }
        Ok(comparison)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::NoFigures;
    use spatial::ports::{Fault, Role};

    fn matrix(laws: &[&str], phases: usize) -> Matrix {
        Matrix {
            robots: vec!["rigid".to_owned()],
            kinematics: vec!["gantry".to_owned()],
            laws: laws.iter().map(|&law| law.to_owned()).collect(),
            gains: vec![Gains::Default],
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
            .run(
                &scenario(&["timing.duration_s=0.5", "timing.seed=7"]),
                &Tuned::default(),
                || (),
            )
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
            let comparison = both.run(&scenario, &Tuned::default(), || ()).unwrap();
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
    fn a_latched_fault_is_no_good_run() {
        let outcome = metrics(&scenario(&[
            "robot.gantry.axis_maximum_rad=[1.0,1.0,1.0,1.5,0.001,1.5]",
            // The controller, which would not go there, is to think that the axes reach further.
            "controller.limits.axis_margin_rad=-0.1",
        ]));
        assert!(
            matches!(
                outcome,
                Err(NoFigures::Faulty {
                    node: Role::Robot,
                    fault: Fault::AxisLimit,
                    ..
                })
            ),
            "{outcome:?}"
        );
        let outcome = metrics(&scenario(&["object.height_m=-0.5"]));
        assert!(
            matches!(
                outcome,
                Err(NoFigures::Faulty {
                    node: Role::Controller,
                    fault: Fault::NoContact,
                    ..
                })
            ),
            "{outcome:?}"
        );
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
}
