//! Laws side by side: a table for people and rows for programs.

use crate::metrics::Metrics;
use crate::tuning::Gains;
use serde::Serialize;
use std::fmt::{Display, Formatter, Result};

/// What is told of one law on one plant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What joins motor and link: `rigid`, ...
    pub robot: String,
    /// Kinematics: `gantry`, ...
    pub kinematics: String,
    /// Control law: `pd`, `proposed`, ...
    pub law: String,
    /// With which gains.
    pub gains: Gains,
    /// Runs that the figures are taken from.
    pub runs: usize,
    /// Mean of each figure.
    pub mean: Metrics,
    /// Worst of each figure; of one run, the same.
    pub worst: Metrics,
    /// Half the width of the mean's 95 % confidence interval; of one run, no number.
    pub confidence: Metrics,
}

impl Row {
    /// The row of a single run.
    pub fn single(robot: &str, kinematics: &str, law: &str, metrics: Metrics) -> Self {
        Self {
            robot: robot.to_owned(),
            kinematics: kinematics.to_owned(),
            law: law.to_owned(),
            gains: Gains::Default,
            runs: 1,
            mean: metrics,
            worst: metrics,
            confidence: Metrics::from_values([f64::NAN; Metrics::COUNT]),
        }
    }
}

/// Rows as text: aligned columns, units in the header; `mean (worst)` where a row stands for several runs.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a>(pub &'a [Row]);

/// The other figures: [`Table`] and this one together show all.
#[derive(Clone, Copy, Debug)]
pub struct MoreFigures<'a>(pub &'a [Row]);

/// Header, factor from the SI unit to the header's, decimals, and which of [`Metrics`].
type Figure = (&'static str, f64, usize, fn(&Metrics) -> f64);

const FIGURES: [Figure; 7] = [
    ("peak N", 1.0, 1, |m| m.peak_n),
    ("set10 ms", 1e3, 0, |m| m.settling_10_s),
    ("set2 ms", 1e3, 0, |m| m.settling_2_s),
    ("IAE N s", 1.0, 3, |m| m.iae_n_s),
    ("steady error N", 1.0, 3, |m| m.steady_error_n),
    ("orientation max mrad", 1e3, 2, |m| m.orientation_max_rad),
    ("end mrad", 1e3, 3, |m| m.orientation_end_rad),
];

const MORE: [Figure; 9] = [
    ("overshoot %", 1e2, 0, |m| m.overshoot_ratio),
    ("set5 ms", 1e3, 0, |m| m.settling_5_s),
    ("impulse above N s", 1.0, 3, |m| m.impulse_above_n_s),
    ("steady sigma N", 1.0, 3, |m| m.steady_sigma_n),
    ("ringing ratio", 1.0, 2, |m| m.ringing_ratio),
    ("rebounds", 1.0, 1, |m| m.rebounds),
    ("detection ms", 1e3, 1, |m| m.detection_delay_s),
    ("impact N", 1.0, 1, |m| m.impact_peak_n),
    ("energy mJ", 1e3, 3, |m| m.energy_j),
];

impl Display for Table<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write_figures(f, self.0, &FIGURES)
    }
}

impl Display for MoreFigures<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write_figures(f, self.0, &MORE)
    }
}

fn write_figures(f: &mut Formatter<'_>, rows: &[Row], figures: &[Figure]) -> Result {
    let names = |name: fn(&Row) -> &str, header| {
        let cells = rows.iter().map(|row| name(row).to_owned());
        Column::new(header, cells.collect(), Align::Left)
    };
    let mut columns = vec![
        names(|row| &row.robot, "robot"),
        names(|row| &row.kinematics, "kinematics"),
        names(|row| &row.law, "law"),
    ];
    if rows.iter().any(|row| row.gains != Gains::Default) {
        columns.push(names(|row| row.gains.word(), "gains"));
    }
    for &(header, factor, decimals, figure) in figures {
        let number = |metrics: &Metrics| fixed(figure(metrics) * factor, decimals);
        let means: Vec<_> = rows.iter().map(|row| number(&row.mean)).collect();
        let worsts: Vec<_> = rows
            .iter()
            .map(|row| (row.runs > 1).then(|| format!("({})", number(&row.worst))))
            .collect();
        let cells = join(&means, &worsts);
        columns.push(Column::new(header, cells, Align::Right));
    }
    print_columns(f, &columns, rows.len())
}

/// Header and `rows` rows of `columns`.
pub(crate) fn print_columns(f: &mut Formatter<'_>, columns: &[Column], rows: usize) -> Result {
    for line in 0..=rows {
        let cells: Vec<_> = columns.iter().map(|column| column.cell(line)).collect();
        writeln!(f, "{}", cells.join("  ").trim_end())?;
    }
    Ok(())
}

/// A number with fixed decimals, zero without a sign, and `-` for what is no number: never settled.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    if value.is_nan() {
        return "-".to_owned();
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.bytes().all(|b| b == b'0' || b == b'.') => zero.to_owned(),
        _ => text,
    }
}

/// Two cells as one, each part aligned.
fn join(means: &[String], worsts: &[Option<String>]) -> Vec<String> {
    let worst = |cell: &Option<String>| cell.clone().unwrap_or_default();
    let width = worsts.iter().map(|cell| worst(cell).len()).max().unwrap_or(0);
    let gap = usize::from(width > 0);
    means
        .iter()
        .zip(worsts)
        .map(|(mean, cell)| format!("{mean}{:gap$}{:>width$}", "", worst(cell)))
        .collect()
}

pub(crate) enum Align {
    Left,
    Right,
}

/// The cells of a column below its header.
pub(crate) struct Column {
    cells: Vec<String>,
    width: usize,
    align: Align,
}

impl Column {
    pub(crate) fn new(header: &str, mut cells: Vec<String>, align: Align) -> Self {
        cells.insert(0, header.to_owned());
        let width = cells.iter().map(String::len).max().unwrap_or(0);
        Self { cells, width, align }
    }

    fn cell(&self, line: usize) -> String {
        let (cell, width) = (&self.cells[line], self.width);
        match self.align {
            Align::Left => format!("{cell:width$}"),
            Align::Right => format!("{cell:>width$}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PD: [f64; 7] = [22.13, 0.1314, 0.1961, 0.6183, -0.0021, 5.3849e-3, 0.2512e-3];
    const PD_WORST: [f64; 7] = [23.04, 0.1389, 0.2123, 0.6511, -0.0112, 5.5111e-3, 0.3121e-3];
    const PROPOSED: [f64; 7] = [9.98, 0.0489, 0.0761, 0.2203, -0.0004, 4.1e-3, 10e-6];

    fn metrics([peak, set10, set2, iae, steady, turned, end]: [f64; 7]) -> Metrics {
        Metrics {
            peak_n: peak,
            settling_10_s: set10,
            settling_2_s: set2,
            iae_n_s: iae,
            steady_error_n: steady,
            orientation_max_rad: turned,
            orientation_end_rad: end,
            ..Metrics::default()
        }
    }

    fn row(law: &str, runs: usize, mean: [f64; 7], worst: [f64; 7]) -> Row {
        let (mean, worst) = (metrics(mean), metrics(worst));
        Row {
            runs,
            worst,
            ..Row::single("rigid", "gantry", law, mean)
        }
    }

    #[test]
    fn several_runs_show_mean_and_worst() {
        let rows = [
            row("pd", 36, PD, PD_WORST),
            row("proposed", 36, PROPOSED, PROPOSED),
        ];
        assert_eq!(
            Table(&rows).to_string(),
            "\
robot  kinematics  law            peak N   set10 ms    set2 ms        IAE N s   steady error N  orientation max mrad       end mrad
rigid  gantry      pd        22.1 (23.0)  131 (139)  196 (212)  0.618 (0.651)  -0.002 (-0.011)           5.38 (5.51)  0.251 (0.312)
rigid  gantry      proposed  10.0 (10.0)   49  (49)   76  (76)  0.220 (0.220)   0.000  (0.000)           4.10 (4.10)  0.010 (0.010)
"
        );
    }

    #[test]
    fn one_run_has_no_worst() {
        let rows = [row("pd", 1, PD, PD), row("proposed", 1, PROPOSED, PROPOSED)];
        assert_eq!(
            Table(&rows).to_string(),
            "\
robot  kinematics  law       peak N  set10 ms  set2 ms  IAE N s  steady error N  orientation max mrad  end mrad
rigid  gantry      pd          22.1       131      196    0.618          -0.002                  5.38     0.251
rigid  gantry      proposed    10.0        49       76    0.220           0.000                  4.10     0.010
"
        );
    }

    #[test]
    fn never_settled_is_no_number() {
        let mut never = PD;
        never[2] = f64::NAN;
        let rows = [row("pd", 36, PD, never)];
        let table = Table(&rows).to_string();
        assert!(table.contains("131 (131)  196 (-)  0.618 (0.618)"), "{table}");
        let json = serde_json::to_string(&rows[0]).unwrap();
        assert!(json.contains(r#""settling_2_s":null"#), "{json}");
    }

    #[test]
    fn rows_are_objects_with_units_in_their_keys() {
        let json = serde_json::to_value(row("pd", 36, PD, PD_WORST)).unwrap();
        let keys: Vec<_> = json.as_object().unwrap().keys().cloned().collect();
        assert_eq!(
            keys,
            [
                "confidence",
                "gains",
                "kinematics",
                "law",
                "mean",
                "robot",
                "runs",
                "worst"
            ]
        );
        assert_eq!(json["mean"]["settling_10_s"], 0.1314);
        assert_eq!(json["worst"]["iae_n_s"], 0.6511);
        for kind in ["mean", "worst", "confidence"] {
            assert_eq!(json[kind].as_object().unwrap().len(), Metrics::COUNT);
        }
    }

    #[test]
    fn tuned_rows_are_told_apart_and_the_other_figures_have_their_table() {
        let tuned = Row {
            gains: Gains::Tuned,
            ..row("pd", 1, PD, PD)
        };
        let table = MoreFigures(&[row("pd", 1, PD, PD), tuned]).to_string();
        assert!(
            table.starts_with("robot  kinematics  law  gains    overshoot %  set5 ms  impulse above N s"),
            "{table}"
        );
        assert!(
            table
                .lines()
                .nth(2)
                .unwrap()
                .starts_with("rigid  gantry      pd   tuned"),
            "{table}"
        );
    }

    #[test]
    fn no_rows_are_a_header() {
        assert_eq!(Table(&[]).to_string().lines().count(), 1);
    }
}
