//! Laws side by side: a table for people and rows for programs.

use crate::metrics::Metrics;
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
    /// Runs that the figures are taken from.
    pub runs: usize,
    /// Mean of each figure.
    pub mean: Metrics,
    /// Worst of each figure; of one run, the same.
    pub worst: Metrics,
}

impl Row {
    /// The row of a single run.
    pub fn single(robot: &str, kinematics: &str, law: &str, metrics: Metrics) -> Self {
        Self {
            robot: robot.to_owned(),
            kinematics: kinematics.to_owned(),
            law: law.to_owned(),
            runs: 1,
            mean: metrics,
            worst: metrics,
        }
    }
}

/// Rows as text: aligned columns, units in the header; `mean (worst)` where a row stands for several runs.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a>(pub &'a [Row]);

/// Header, factor from the SI unit to the header's, and decimals of each figure in [`Metrics::values`].
const FIGURES: [(&str, f64, usize); 7] = [
    ("peak N", 1.0, 1),
    ("set10 ms", 1e3, 0),
    ("set2 ms", 1e3, 0),
    ("IAE N s", 1.0, 3),
    ("steady error N", 1.0, 3),
    ("orientation max mrad", 1e3, 2),
    ("end mrad", 1e3, 3),
];

impl Display for Table<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let names = |name: fn(&Row) -> &str, header| {
            let cells = self.0.iter().map(|row| name(row).to_owned());
            Column::new(header, cells.collect(), Align::Left)
        };
        let mut columns = vec![
            names(|row| &row.robot, "robot"),
            names(|row| &row.kinematics, "kinematics"),
            names(|row| &row.law, "law"),
        ];
        for (i, (header, factor, decimals)) in FIGURES.into_iter().enumerate() {
            let number = |metrics: &Metrics| fixed(metrics.values()[i] * factor, decimals);
            let means: Vec<_> = self.0.iter().map(|row| number(&row.mean)).collect();
            let worsts: Vec<_> = self
                .0
                .iter()
                .map(|row| (row.runs > 1).then(|| format!("({})", number(&row.worst))))
                .collect();
            let cells = join(&means, &worsts);
            columns.push(Column::new(header, cells, Align::Right));
        }
        print_columns(f, &columns, self.0.len())
    }
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

    fn row(law: &str, runs: usize, mean: [f64; 7], worst: [f64; 7]) -> Row {
        let (mean, worst) = (Metrics::from_values(mean), Metrics::from_values(worst));
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
        let json = serde_json::to_string(&row("pd", 36, PD, PD_WORST)).unwrap();
        assert_eq!(
            json,
            concat!(
                r#"{"robot":"rigid","kinematics":"gantry","law":"pd","runs":36,"#,
                r#""mean":{"peak_n":22.13,"settling_10_s":0.1314,"settling_2_s":0.1961,"iae_n_s":0.6183,"#,
                r#""steady_error_n":-0.0021,"orientation_max_rad":0.0053849,"orientation_end_rad":0.0002512},"#,
                r#""worst":{"peak_n":23.04,"settling_10_s":0.1389,"settling_2_s":0.2123,"iae_n_s":0.6511,"#,
                r#""steady_error_n":-0.0112,"orientation_max_rad":0.0055111,"orientation_end_rad":0.0003121}}"#
            )
        );
    }

    #[test]
    fn no_rows_are_a_header() {
        assert_eq!(Table(&[]).to_string().lines().count(), 1);
    }
}
