//! What became of a program's steps, from what the controller publishes of them: a table for people, rows for programs.

use crate::table::{Align, Column, fixed, print_columns};
use node::scenario::{Scenario, StepKind};
use serde::Serialize;
use spatial::TICK_S;
use spatial::ports::{ControllerStatus, Fault, LIMIT_STEP_SEARCH, LIMIT_STEP_TIME, LIMIT_STEP_TOLERANCE};
use std::fmt::{Display, Formatter, Result};

/// What became of one step. Forces and position as the controller measures them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepResult {
    /// Index in the program.
    pub step: i32,
    /// What it does: `approach`, ...
    pub kind: String,
    /// How often `next` has led back to an earlier step before.
    pub workpiece: usize,
    /// When it began, s.
    pub start_s: f64,
    /// How long it took, s.
    pub duration_s: f64,
    /// How it ended: `done`, `time`, `search`, `tolerance`, a fault, or `unfinished` when the run was over.
    pub result: String,
    /// Largest normal force, N.
    pub largest_force_n: f64,
    /// Normal force at its end, mean over 50 ms, N.
    pub end_force_n: f64,
    /// Deflected tcp at its end in r, m.
    pub end_position_m: [f64; 3],
}

/// The means at a step's end are taken over that time, s.
const END_S: f64 = 0.05;
/// Bits of `limits` that say why the step before failed, and what they are called.
const FAILURES: [(i32, &str); 3] = [
    (LIMIT_STEP_TIME, "time"),
    (LIMIT_STEP_SEARCH, "search"),
    (LIMIT_STEP_TOLERANCE, "tolerance"),
];

/// How a step that is followed by `next` has ended.
fn ended(next: &ControllerStatus) -> String {
    let failure = FAILURES.iter().find(|(bit, _)| next.limits & bit != 0);
    match failure {
        _ if next.fault != Fault::None => words(next.fault.name()),
        Some((_, name)) => (*name).to_owned(),
        None => "done".to_owned(),
    }
}

/// A name such as `NoContact` as words: `no contact`.
pub fn words(name: &str) -> String {
    let mut words = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.push(letter.to_ascii_lowercase());
    }
    words
}

/// The results of a program's steps in the order in which they were done.
///
/// A step that `next` leads back to itself is told as one: the index that is published stays the same.
pub fn results(scenario: &Scenario, statuses: impl IntoIterator<Item = ControllerStatus>) -> Vec<StepResult> {
    let mut results: Vec<StepResult> = Vec::new();
    let mut within: Vec<ControllerStatus> = Vec::new();
    let mut workpiece = 0;
    for status in statuses {
        let Some(last) = within.last() else {
            if status.program_step >= 0 && status.fault == Fault::None {
                within.push(status);
            }
            continue;
        };
        let (before, faulty) = (last.program_step, status.fault != Fault::None);
        if status.program_step != before || faulty {
            results.push(result(scenario, &within, workpiece, ended(&status)));
            within.clear();
            workpiece += usize::from((0..before).contains(&status.program_step));
        }
        if status.program_step >= 0 && !faulty {
            within.push(status);
        } else if faulty {
            return results;
        }
    }
    if !within.is_empty() {
        results.push(result(scenario, &within, workpiece, "unfinished".to_owned()));
    }
    results
}

fn result(scenario: &Scenario, within: &[ControllerStatus], workpiece: usize, result: String) -> StepResult {
    let (first, last) = (&within[0], &within[within.len() - 1]);
    let at_s = |status: &ControllerStatus| status.stamp.step as f64 * TICK_S;
    let period_s = scenario.timing.command_period_ticks as f64 * TICK_S;
    let force = |status: &ControllerStatus| status.detection.statistic_n;
    let end: Vec<f64> = within
        .iter()
        .filter(|it| at_s(it) > at_s(last) - END_S)
        .map(force)
        .collect();
    let kind = usize::try_from(first.program_step)
        .ok()
        .and_then(|i| scenario.program.steps().get(i))
        .map_or(StepKind::Next, |step| step.kind);
    StepResult {
        step: first.program_step,
        kind: format!("{kind:?}").to_lowercase(),
        workpiece,
        start_s: at_s(first),
        duration_s: at_s(last) - at_s(first) + period_s,
        result,
        largest_force_n: within.iter().map(force).fold(f64::NEG_INFINITY, f64::max),
        end_force_n: end.iter().sum::<f64>() / end.len() as f64,
        end_position_m: last.tcp_pose.translation.vector.into(),
    }
}

/// Whether all steps have done what they were to do.
pub fn succeeded(results: &[StepResult]) -> bool {
    !results.is_empty() && results.iter().all(|step| step.result == "done")
}

/// Results as text: aligned columns, units in the header.
#[derive(Clone, Copy, Debug)]
pub struct Steps<'a>(pub &'a [StepResult]);

impl Display for Steps<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let column = |header, align, cell: &dyn Fn(&StepResult) -> String| {
            Column::new(header, self.0.iter().map(cell).collect(), align)
        };
        let position = |step: &StepResult| {
            let [x, y, z] = step.end_position_m.map(|x| fixed(x * 1e3, 2));
            format!("{x:>7} {y:>6} {z:>6}")
        };
        let columns = [
            column("step", Align::Right, &|it| it.step.to_string()),
            column("kind", Align::Left, &|it| it.kind.clone()),
            column("workpiece", Align::Right, &|it| it.workpiece.to_string()),
            column("start s", Align::Right, &|it| fixed(it.start_s, 3)),
            column("took s", Align::Right, &|it| fixed(it.duration_s, 3)),
            column("result", Align::Left, &|it| it.result.clone()),
            column("largest N", Align::Right, &|it| fixed(it.largest_force_n, 2)),
            column("at its end N", Align::Right, &|it| fixed(it.end_force_n, 2)),
            column("tcp at its end mm", Align::Right, &position),
        ];
        print_columns(f, &columns, self.0.len())
    }
}
