//! Many runs as two figures each.

use crate::metrics::{Metrics, NoFigures};

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
}
