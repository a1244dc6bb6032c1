//! Where the law that a scenario is made for is not the best: what an honest report has to say.

use super::Section;
use crate::metrics::Metrics;
use crate::table::{FIGURES, Figure, Row};
use crate::tuning::Gains;

/// A figure in which another law is better.
#[derive(Clone, Debug)]
pub struct Loss<'a> {
    /// The scenario.
    pub scenario: &'a str,
    /// The figure's header, with its unit.
    pub figure: &'static str,
    /// The scenario's law.
    pub own: &'a Row,
    /// The law that is best there, with the same kind of gains.
    pub best: &'a Row,
    /// Means of the scenario's law and of the best one, in the header's unit; not a number: never.
    pub means: [f64; 2],
    /// How many decimals say something.
    pub decimals: usize,
}

/// The losses of a section's law, against laws with the same kind of gains: where another law's mean is closer to zero
/// by more than both confidence intervals together, the best one.
pub fn losses(section: &Section) -> Vec<Loss<'_>> {
    let rows = &section.comparison.rows;
    let mut all = Vec::new();
    for gains in [Gains::Default, Gains::Tuned] {
        let Some(own) = rows
            .iter()
            .find(|row| row.law == section.law && row.gains == gains)
        else {
            continue;
        };
        for figure in &FIGURES {
            let others = rows.iter().filter(|row| row.gains == gains && row.law != own.law);
            let better = others.filter(|other| is_better(figure, other, own));
            let best = better.min_by(|a, b| size(figure, &a.mean).total_cmp(&size(figure, &b.mean)));
            let (header, factor, decimals, value) = *figure;
            all.extend(best.map(|best| Loss {
                scenario: &section.scenario,
                figure: header,
                own,
                best,
                means: [own, best].map(|row| value(&row.mean) * factor),
                decimals,
            }));
        }
    }
    all
}

/// All figures of [`FIGURES`] are best at zero.
fn size(figure: &Figure, metrics: &Metrics) -> f64 {
    figure.3(metrics).abs()
}

fn is_better(figure: &Figure, other: &Row, own: &Row) -> bool {
    let doubt = |row: &Row| {
        let half = figure.3(&row.confidence);
        if half.is_nan() { 0.0 } else { half }
    };
    let (theirs, ours) = (size(figure, &other.mean), size(figure, &own.mean));
    // What nobody could read in a table is no loss.
    let least = 0.5 * libm::pow(10.0, -(figure.2 as f64)) / figure.1;
    !theirs.is_nan() && (ours.is_nan() || ours - theirs > (doubt(other) + doubt(own)).max(least))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Comparison;
    use crate::report::Origin;
    use node::scenario::Scenario;

    fn row(law: &str, peak_n: f64, settling_10_s: f64, half: f64) -> Row {
        let metrics = |peak_n, settling_10_s| Metrics {
            peak_n,
            settling_10_s,
            ..Metrics::default()
        };
        Row {
            confidence: metrics(half, half),
            ..Row::single("rigid", "gantry", law, metrics(peak_n, settling_10_s))
        }
    }

    #[test]
    fn what_is_worse_beyond_doubt_is_a_loss() {
        let section = |rows: Vec<Row>| Section {
            scenario: "paper".to_owned(),
            about: String::new(),
            law: "proposed".to_owned(),
            shoot_out: false,
            comparison: Comparison {
                rows,
                failures: Vec::new(),
            },
            origin: Origin::new(String::new(), &Scenario::default(), 1),
            panels: Vec::new(),
        };
        let found = |rows: Vec<Row>| {
            let section = section(rows);
            let found = losses(&section);
            found
                .iter()
                .map(|loss| (loss.figure, loss.best.law.clone()))
                .collect::<Vec<_>>()
        };
        let own = || row("proposed", 14.0, 0.05, 0.0);
        assert_eq!(found(vec![own(), row("pd", 20.0, 0.08, 0.0)]), []);
        assert_eq!(
            found(vec![
                own(),
                row("pd", 13.0, 0.08, 0.0),
                row("fzi", 12.0, 0.04, 0.0)
            ]),
            [("peak N", "fzi".to_owned()), ("set10 ms", "fzi".to_owned())]
        );
        assert_eq!(found(vec![own(), row("pd", 13.0, 0.08, 2.0)]), []);
        let never = row("proposed", 14.0, f64::NAN, 0.0);
        assert_eq!(
            found(vec![never, row("pd", 20.0, 0.08, 0.0)]),
            [("set10 ms", "pd".to_owned())]
        );
    }
}
