//! Many runs as three figures each.

use crate::metrics::{Metrics, NoFigures};

/// Mean, worst and confidence of the figures over phases and seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Runs.
    pub runs: usize,
    /// Mean of each figure.
    pub mean: Metrics,
    /// Largest magnitude of each figure.
    pub worst: Metrics,
    /// Half the width of the mean's 95 % confidence interval; not a number for a single run.
    pub confidence: Metrics,
}

impl Summary {
    /// The summary of `outcomes`, each for itself; `None` if one of them has no figures, or if there are none.
    pub fn of(outcomes: &[Result<Metrics, NoFigures>]) -> Option<Self> {
        Self::over_phases(outcomes, 1)
    }

    /// The same with confidence over contact phases.
    ///
    /// Each `seeds` of them in a row are one contact phase's. Where there are several phases, their means are the sample
    /// that the confidence is taken from: the seeds of a phase share what it does.
    pub fn over_phases(outcomes: &[Result<Metrics, NoFigures>], seeds: usize) -> Option<Self> {
        let (mut mean, mut worst) = ([0.0; Metrics::COUNT], [0.0f64; Metrics::COUNT]);
        let mut all = Vec::with_capacity(outcomes.len());
        for outcome in outcomes {
            let values = outcome.as_ref().ok()?.values();
            all.push(values);
            for (i, value) in values.into_iter().enumerate() {
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
            confidence: Metrics::from_values(confidence(&all, seeds.max(1))),
        })
    }
}

type Values = [f64; Metrics::COUNT];

/// Half the width of the 95 % confidence interval of the mean over the phases; over all runs if there is one phase.
fn confidence(all: &[Values], seeds: usize) -> Values {
    let mean =
        |runs: &[Values], i: usize| runs.iter().map(|values| values[i]).sum::<f64>() / runs.len() as f64;
    let several = all.len() > seeds && all.len().is_multiple_of(seeds);
    std::array::from_fn(|i| {
        let sample: Vec<f64> = if several {
            all.chunks(seeds).map(|phase| mean(phase, i)).collect()
        } else {
            all.iter().map(|values| values[i]).collect()
        };
        let count = sample.len() as f64;
        let centre = sample.iter().sum::<f64>() / count;
        let squares = sample
            .iter()
            .map(|value| (value - centre) * (value - centre))
            .sum::<f64>();
        students_t(sample.len() - 1) * (squares / (count - 1.0) / count).sqrt()
    })
}

/// The two-sided 95 % quantile of Student's t distribution; beyond the table its expansion in 1 / `freedom`.
fn students_t(freedom: usize) -> f64 {
    const TABLE: [f64; 11] = [
        f64::NAN,
        12.706,
        4.303,
        3.182,
        2.776,
        2.571,
        2.447,
        2.365,
        2.306,
        2.262,
        2.228,
    ];
    TABLE.get(freedom).copied().unwrap_or_else(|| {
        let n = freedom as f64;
        1.959_964 + 2.372_27 / n + 2.822_5 / (n * n)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_that_is_no_number_is_the_worst() {
        let rows = [1.0, f64::NAN, 2.0].map(|settling_2_s| {
            Ok(Metrics {
                settling_2_s,
                ..Metrics::default()
            })
        });
        let summary = Summary::of(&rows).unwrap();
        assert!(summary.worst.settling_2_s.is_nan() && summary.mean.settling_2_s.is_nan());
    }

    /// Phase means 1, 2, 3: standard deviation 1, t = 4.303 at two degrees of freedom.
    #[test]
    fn confidence_rests_on_the_phases() {
        let rows: Vec<_> = [0.9, 1.1, 1.8, 2.2, 3.0, 3.0]
            .into_iter()
            .map(|peak_n| {
                Ok(Metrics {
                    peak_n,
                    ..Metrics::default()
                })
            })
            .collect();
        let confidence = Summary::over_phases(&rows, 2).unwrap().confidence;
        assert!((confidence.peak_n - 4.303 / 3.0f64.sqrt()).abs() < 1e-9);
        let single = Summary::of(&rows[..1]).unwrap().confidence;
        assert!(single.peak_n.is_nan());
        // Tabulated values of 12, 30 and 120 degrees of freedom.
        for (freedom, t) in [(12, 2.179), (30, 2.042), (120, 1.980)] {
            assert!(
                (students_t(freedom) - t).abs() < 3e-3,
                "{freedom}: {}",
                students_t(freedom)
            );
        }
    }
}
