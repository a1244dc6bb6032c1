//! What is told of conditions: rows for programs, a table for people.

use crate::bound::Figures;
use crate::compare::Summary;
use serde::Serialize;
use std::fmt::{Display, Formatter};

/// Mean and worst of the figures of many runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanAndWorst {
    /// Mean.
    pub mean: Figures,
    /// Worst.
    pub worst: Figures,
}

impl From<Summary> for MeanAndWorst {
    fn from(summary: Summary) -> Self {
        let [mean, worst] = [summary.mean, summary.worst].map(|metrics| Figures {
            peak_n: metrics.peak_n,
            settling_10_s: metrics.settling_10_s,
            settling_2_s: metrics.settling_2_s,
            iae_n_s: metrics.iae_n_s,
        });
        Self { mean, worst }
    }
}

impl From<Figures> for MeanAndWorst {
    fn from(figures: Figures) -> Self {
        Self {
            mean: figures,
            worst: figures,
        }
    }
}

/// One law, or the bound, under one condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConditionRow {
    /// What is changed, with its unit.
    pub condition: String,
    /// To what.
    pub value: String,
    /// Control law, or `bound`.
    pub law: String,
    /// Runs.
    pub runs: usize,
    /// Runs without figures.
    pub failed: usize,
    /// Why the first of them has none.
    pub reason: Option<String>,
    /// Of the other runs; `None`: there are none.
    pub figures: Option<MeanAndWorst>,
}

/// Rows as text: aligned columns, units in the header, `mean (worst)`.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a>(pub &'a [ConditionRow]);

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        writeln!(
            f,
            "condition                value  law            peak N     set10 ms      set2 ms        IAE N s"
        )?;
        let mut before = None;
        for row in self.0 {
            let condition = (&row.condition, &row.value);
            let named = before.replace(condition) != Some(condition);
            let [what, value] = if named {
                [&*row.condition, &*row.value]
            } else {
                ["", ""]
            };
            let mut line = format!("{what:23}  {value:>5}  {:8}", row.law);
            if let Some(figures) = &row.figures {
                let cells = |figures: &Figures| {
                    [
                        fixed(figures.peak_n, 1),
                        fixed(1e3 * figures.settling_10_s, 0),
                        fixed(1e3 * figures.settling_2_s, 0),
                        fixed(figures.iae_n_s, 3),
                    ]
                };
                let (mean, worst) = (cells(&figures.mean), cells(&figures.worst));
                for (i, (width, room)) in [(5, 7), (4, 6), (4, 6), (6, 8)].into_iter().enumerate() {
                    let worst = if row.runs > 1 {
                        format!("({})", worst[i])
                    } else {
                        String::new()
                    };
                    line += &format!("  {:>width$} {worst:>room$}", mean[i]);
                }
            }
            if let Some(reason) = &row.reason {
                line += &format!("  {} of {} runs failed: {reason}", row.failed, row.runs);
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// `-` for what is no number: never settled.
fn fixed(value: f64, decimals: usize) -> String {
    if value.is_nan() {
        return "-".to_owned();
    }
    format!("{value:.decimals$}")
}
