//! The runs of a cell together, and what linear theory predicts of it.

use super::{Outcome, Plan, State};
use crate::linear::{self, Loop, Margins};
use crate::metrics::Metrics;
use rayon::prelude::*;
use serde::Serialize;

/// One law at one point of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Contact phases.
    pub runs: usize,
    /// Those whose force came to rest.
    pub settled_runs: usize,
    /// Those whose force rings on, or that latched a fault.
    pub unstable_runs: usize,
    /// Mean figures of the runs, where all have some.
    pub mean: Option<Metrics>,
    /// Worst figures of the runs, where all have some.
    pub worst: Option<Metrics>,
    /// What linear theory says; `None`: the law has no linear model.
    pub predicted: Option<Margins>,
}

impl Cell {
    /// Whether none of its runs is unstable.
    pub fn stable(&self) -> bool {
        self.unstable_runs == 0
    }

    /// Whether all of them came to rest.
    pub fn settled(&self) -> bool {
        self.settled_runs == self.runs
    }
}

/// All cells of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// By map, by law, and by row and column from the origin on.
    pub maps: Vec<Vec<Vec<Vec<Cell>>>>,
}

impl Cells {
    /// The cells of `plan` from the `outcomes` of all its runs, and their prediction.
    pub fn new(plan: &Plan, outcomes: &[Outcome]) -> Self {
        let phases = plan.definition.phases;
        let mut maps = Vec::new();
        let mut first = 0;
        for map in &plan.definition.maps {
            let (columns, rows) = (map.x.values.len(), map.y.values.len());
            let laws = plan.definition.laws(map).len();
            let at = |law: usize, cell: usize| first + (law * rows * columns + cell) * phases;
            // The plant of a cell is the same for all laws.
            let predicted: Vec<Vec<Option<Margins>>> = (0..rows * columns)
                .into_par_iter()
                .map(|cell| {
                    let response = linear::response(&plan.runs[at(0, cell)].scenario);
                    let predict = |law: usize| {
                        let scenario = &plan.runs[at(law, cell)].scenario;
                        Some(Loop::close(response.as_ref()?, &linear::law(scenario)?).margins())
                    };
                    (0..laws).map(predict).collect()
                })
                .collect();
            let cell = |law: usize, cell: usize| {
                let runs = &outcomes[at(law, cell)..at(law, cell) + phases];
                Cell {
                    predicted: predicted[cell][law],
                    ..summary(runs)
                }
            };
            let row = |law: usize, y: usize| (0..columns).map(|x| cell(law, y * columns + x)).collect();
            maps.push(
                (0..laws)
                    .map(|law| (0..rows).map(|y| row(law, y)).collect())
                    .collect(),
            );
            first += laws * rows * columns * phases;
        }
        Self { maps }
    }
}

fn summary(runs: &[Outcome]) -> Cell {
    let count = |state: State| runs.iter().filter(|run| run.state == state).count();
    let figures: Option<Vec<_>> = runs
        .iter()
        .map(|run| run.metrics.map(|metrics| metrics.values()))
        .collect();
    let over = |of: &dyn Fn(&[f64]) -> f64| {
        figures.as_ref().map(|figures| {
            Metrics::from_values(std::array::from_fn(|i| {
                of(&figures.iter().map(|values| values[i]).collect::<Vec<_>>())
            }))
        })
    };
    Cell {
        runs: runs.len(),
        settled_runs: count(State::Settled),
        unstable_runs: count(State::Unstable),
        mean: over(&|values| values.iter().sum::<f64>() / values.len() as f64),
        worst: over(&|values| {
            let larger = |a: f64, b: &f64| {
                if b.abs().total_cmp(&a.abs()).is_ge() {
                    *b
                } else {
                    a
                }
            };
            values.iter().fold(0.0, larger)
        }),
        predicted: None,
    }
}

/// How well one law's map agrees with linear theory, and how it does where it is stable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The map.
    pub map: String,
    /// The law.
    pub law: String,
    /// Cells.
    pub cells: usize,
    /// Cells all of whose runs came to rest.
    pub settled_cells: usize,
    /// Cells none of whose runs is unstable.
    pub stable_cells: usize,
    /// Cells of which theory says what simulation shows; `None`: the law has no linear model.
    pub agreeing_cells: Option<usize>,
    /// Of the others, those that have a neighbour (diagonal ones included) beyond the predicted border.
    pub near_border_cells: Option<usize>,
    /// Cells that are predicted stable and simulated unstable.
    pub too_hopeful_cells: Option<usize>,
    /// Mean IAE of the settled cells, N s.
    pub mean_iae_n_s: Option<f64>,
}

/// The verdicts of all maps and laws.
pub fn verdicts(plan: &Plan, cells: &Cells) -> Vec<Verdict> {
    let mut all = Vec::new();
    for (map, laws) in plan.definition.maps.iter().zip(&cells.maps) {
        for (law, rows) in plan.definition.laws(map).iter().zip(laws) {
            all.push(verdict(&map.name, law, rows));
        }
    }
    all
}

fn verdict(map: &str, law: &str, rows: &[Vec<Cell>]) -> Verdict {
    let flat: Vec<&Cell> = rows.iter().flatten().collect();
    let settled: Vec<&&Cell> = flat.iter().filter(|cell| cell.settled()).collect();
    let iae: Vec<f64> = settled
        .iter()
        .filter_map(|cell| cell.mean.map(|mean| mean.iae_n_s))
        .collect();
    let known = flat.iter().all(|cell| cell.predicted.is_some());
    let predicted = |y: usize, x: usize| rows[y][x].predicted.is_some_and(|margins| margins.stable);
    let (mut agreeing, mut near, mut hopeful) = (0, 0, 0);
    for (y, row) in rows.iter().enumerate() {
        for (x, cell) in row.iter().enumerate() {
            let theory = predicted(y, x);
            if theory == cell.stable() {
                agreeing += 1;
                continue;
            }
            hopeful += usize::from(theory);
            let around = |i: usize, count: usize| i.saturating_sub(1)..(i + 2).min(count);
            let mut neighbours =
                around(y, rows.len()).flat_map(|v| around(x, row.len()).map(move |u| (v, u)));
            near += usize::from(neighbours.any(|(v, u)| predicted(v, u) != theory));
        }
    }
    Verdict {
        map: map.to_owned(),
        law: law.to_owned(),
        cells: flat.len(),
        settled_cells: settled.len(),
        stable_cells: flat.iter().filter(|cell| cell.stable()).count(),
        agreeing_cells: known.then_some(agreeing),
        near_border_cells: known.then_some(near),
        too_hopeful_cells: known.then_some(hopeful),
        mean_iae_n_s: (!iae.is_empty()).then(|| iae.iter().sum::<f64>() / iae.len() as f64),
    }
}

/// The cells as CSV: the axes by their columns' names and units, counts, prediction, mean and worst figures.
pub fn cells_csv(plan: &Plan, cells: &Cells) -> String {
    let figures = |kind: &str| Metrics::NAMES.map(|name| format!("{kind}_{name}")).join(",");
    let mut text = format!(
        "map,law,gains,x_axis,x,y_axis,y,runs,settled_runs,unstable_runs,predicted_stable,predicted_gain_margin,\
         predicted_phase_margin_rad,{},{}\n",
        figures("mean"),
        figures("worst")
    );
    let numbers = |metrics: &Option<Metrics>| match metrics {
        Some(metrics) => metrics.values().map(|value| format!("{value:?}")).join(","),
        None => vec![""; Metrics::COUNT].join(","),
    };
    for (map, laws) in plan.definition.maps.iter().zip(&cells.maps) {
        for (law, rows) in plan.definition.laws(map).iter().zip(laws) {
            for (y, row) in map.y.values.iter().zip(rows) {
                for (x, cell) in map.x.values.iter().zip(row) {
                    let predicted = cell.predicted.map_or(",,".to_owned(), |margins| {
                        format!(
                            "{},{:.4},{:.4}",
                            u8::from(margins.stable),
                            margins.gain_margin,
                            margins.phase_margin_rad
                        )
                    });
                    text += &format!(
                        "{},{law},{},{},{x:?},{},{y:?},{},{},{},{predicted},{},{}\n",
                        map.name,
                        plan.definition.gains.word(),
                        map.x.axis.column(),
                        map.y.axis.column(),
                        cell.runs,
                        cell.settled_runs,
                        cell.unstable_runs,
                        numbers(&cell.mean),
                        numbers(&cell.worst)
                    );
                }
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(stable: bool, predicted: bool) -> Cell {
        Cell {
            runs: 2,
            settled_runs: 1,
            unstable_runs: usize::from(!stable),
            mean: None,
            worst: None,
            predicted: Some(Margins {
                stable: predicted,
                gain_margin: 1.0,
                phase_margin_rad: 0.0,
                crossover_hz: 1.0,
            }),
        }
    }

    #[test]
    fn disagreement_is_counted_by_its_distance_from_the_border() {
        let row = [
            (true, true),
            (false, true),
            (true, true),
            (false, true),
            (false, false),
        ];
        let rows = vec![row.map(|(stable, predicted)| cell(stable, predicted)).to_vec()];
        let verdict = verdict("m", "pd", &rows);
        assert_eq!((verdict.cells, verdict.stable_cells), (5, 2));
        assert_eq!(verdict.agreeing_cells, Some(3));
        assert_eq!(
            (verdict.near_border_cells, verdict.too_hopeful_cells),
            (Some(1), Some(2))
        );
    }

    #[test]
    fn a_cell_has_mean_and_worst_only_if_all_runs_have_figures() {
        let run = |peak_n: f64| Outcome {
            metrics: Some(Metrics {
                peak_n,
                settling_2_s: if peak_n > 15.0 { f64::NAN } else { 0.1 },
                ..Metrics::default()
            }),
            state: State::Settled,
        };
        let whole = summary(&[run(10.0), run(20.0)]);
        assert_eq!(whole.mean.unwrap().peak_n, 15.0);
        assert_eq!(whole.worst.unwrap().peak_n, 20.0);
        assert!(whole.worst.unwrap().settling_2_s.is_nan() && whole.stable() && whole.settled());
        let failed = Outcome {
            metrics: None,
            state: State::Unstable,
        };
        let part = summary(&[run(10.0), failed]);
        assert_eq!((part.mean, part.settled_runs, part.unstable_runs), (None, 1, 1));
    }
}
