//! The runs of a sweep, in their order, and the file that they are written to.

use super::{Definition, SweepError};
use crate::compare::{metrics, variations};
use crate::metrics::{Metrics, NoFigures};
use crate::tuning::{Gains, Tuned};
use node::scenario::Scenario;
use rayon::prelude::*;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

/// Runs between two writes.
const CHUNK: usize = 256;
/// Columns before the figures.
const FIRST_COLUMNS: [&str; 9] = [
    "configuration_hash",
    "map",
    "law",
    "gains",
    "x",
    "y",
    "phase",
    "figures",
    "state",
];
/// A force that varies by less than this share of the desired one, rms, at the end has settled.
const QUIET: f64 = 0.10;
/// One that rings more than that dies out if it has lost a tenth within 0.6 s, and if it does not bounce any more: the
/// amplitude of bounces is bounded by other things.
const DYING: f64 = 0.9;
const BOUNCING: f64 = 0.5;

/// The first line of the file.
pub const HEADER: fn() -> String = || {
    let columns = FIRST_COLUMNS.into_iter().chain(Metrics::NAMES);
    columns.collect::<Vec<_>>().join(",")
};

/// One run: where it belongs, and its scenario.
#[derive(Clone, Debug)]
pub struct Run {
    /// Number of its map.
    pub map: usize,
    /// Number of its law.
    pub law: usize,
    /// Index of its value along x.
    pub x: usize,
    /// Index of its value along y.
    pub y: usize,
    /// Contact phase.
    pub phase: usize,
    /// All of it.
    pub scenario: Scenario,
}

/// Where the force of a run has gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// To rest: at the end it varies by at most 10 % of the desired force, rms.
    Settled,
    /// It still rings, by up to half of the desired force, but has lost a tenth or more of that within 0.6 s.
    Decaying,
    /// It rings on, or a fault has latched.
    Unstable,
}

impl State {
    const ALL: [(Self, &'static str); 3] = [
        (Self::Settled, "settled"),
        (Self::Decaying, "decaying"),
        (Self::Unstable, "unstable"),
    ];

    fn word(self) -> &'static str {
        Self::ALL
            .into_iter()
            .find(|(state, _)| *state == self)
            .map_or("", |(_, word)| word)
    }
}

/// What has come of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Its figures; none: a fault, or no contact.
    pub metrics: Option<Metrics>,
    /// Where its force has gone.
    pub state: State,
}

impl Outcome {
    fn new(result: &Result<Metrics, NoFigures>, desired_n: f64) -> Self {
        let metrics = result.as_ref().ok().copied();
        let state = match metrics {
            Some(metrics) if metrics.steady_sigma_n <= QUIET * desired_n => State::Settled,
            Some(metrics)
                if metrics.ringing_ratio < DYING && metrics.steady_sigma_n <= BOUNCING * desired_n =>
            {
                State::Decaying
            }
            _ => State::Unstable,
        };
        Self { metrics, state }
    }
}

/// All runs of a sweep.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What they are runs of.
    pub definition: Definition,
    /// In the order of the file.
    pub runs: Vec<Run>,
}

impl Plan {
    /// The runs of `definition` with gains from `tuned`; what can't be combined is refused here.
    pub fn new(definition: Definition, tuned: &Tuned) -> Result<Self, SweepError> {
        let scenario = definition.scenario()?;
        let mut runs = Vec::new();
        for (map, described) in definition.maps.iter().enumerate() {
            for (law, word) in definition.laws(described).iter().enumerate() {
                for (y, &up) in described.y.values.iter().enumerate() {
                    for (x, &right) in described.x.values.iter().enumerate() {
                        let mut overrides = described.set.clone();
                        overrides.push(format!("controller.law={word}"));
                        overrides.extend(described.x.axis.overrides(right, &scenario));
                        overrides.extend(described.y.axis.overrides(up, &scenario));
                        let varied = scenario.with(&overrides)?;
                        let varied = match tuned.apply(definition.gains, &varied)? {
                            Some(varied) => varied,
                            None => varied,
                        };
                        let phases = variations(&varied, definition.phases, 1);
                        runs.extend(phases.into_iter().enumerate().map(|(phase, scenario)| Run {
                            map,
                            law,
                            x,
                            y,
                            phase,
                            scenario,
                        }));
                    }
                }
            }
        }
        Ok(Self { definition, runs })
    }

    /// One number for all runs, of their configurations' hashes in their order (FNV-1a).
    pub fn hash(&self) -> u64 {
        let bytes = self.runs.iter().flat_map(|run| run.scenario.hash().to_be_bytes());
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
        })
    }

    /// Simulated time of all runs, s.
    pub fn simulated_s(&self) -> f64 {
        self.runs.iter().map(|run| run.scenario.timing.duration_s).sum()
    }

    /// Run what the file `path` has not yet and write it there; the outcomes of all runs, and how many were there
    /// already. `done` is told of each run, those found included. The file is flushed after every 256 runs.
    pub fn run(&self, path: &Path, done: impl Fn(usize) + Sync) -> Result<(Vec<Outcome>, usize), SweepError> {
        let unusable = |source| SweepError::File {
            path: path.to_owned(),
            source,
        };
        let mut outcomes = self.resume(path)?;
        let found = outcomes.len();
        done(found);
        let mut file = OpenOptions::new().append(true).open(path).map_err(unusable)?;
        for chunk in self.runs[found..].chunks(CHUNK) {
            let finished: Vec<Outcome> = chunk
                .par_iter()
                .map(|run| {
                    let result = metrics(&run.scenario);
                    if let Err(reason @ NoFigures::TooShort { .. }) = result {
                        return Err(self.nothing_judged(run, reason));
                    }
                    let outcome = Outcome::new(&result, run.scenario.task.pressing_force_n());
                    done(1);
                    Ok(outcome)
                })
                .collect::<Result<_, SweepError>>()?;
            let lines: String = chunk
                .iter()
                .zip(&finished)
                .map(|(run, outcome)| self.line(run, outcome))
                .collect();
            file.write_all(lines.as_bytes()).map_err(unusable)?;
            file.flush().map_err(unusable)?;
            outcomes.extend(finished);
        }
        Ok((outcomes, found))
    }

    fn nothing_judged(&self, run: &Run, reason: NoFigures) -> SweepError {
        let map = &self.definition.maps[run.map];
        SweepError::NothingJudged {
            map: map.name.clone(),
            law: self.definition.laws(map)[run.law].clone(),
            reason,
        }
    }

    /// The outcomes that `path` has, which holds nothing else afterwards: a line that was cut off is removed.
    fn resume(&self, path: &Path) -> Result<Vec<Outcome>, SweepError> {
        let unusable = |source| SweepError::File {
            path: path.to_owned(),
            source,
        };
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(unusable(error)),
        };
        let header = HEADER() + "\n";
        if !text.starts_with(&header) && !header.starts_with(&text) {
            return Err(self.foreign(path, 1, &text, &header));
        }
        let whole = text.get(header.len()..).unwrap_or_default();
        let whole = &whole[..whole.rfind('\n').map_or(0, |end| end + 1)];
        let mut outcomes = Vec::new();
        for (i, line) in whole.lines().enumerate() {
            let Some(outcome) = self.runs.get(i).and_then(|run| self.read(run, line)) else {
                let expected = self.runs.get(i).map_or("no further run".to_owned(), hash);
                return Err(self.foreign(path, i + 2, line, &expected));
            };
            outcomes.push(outcome);
        }
        let kept = header + whole;
        if kept != text {
            File::create(path)
                .and_then(|mut file| file.write_all(kept.as_bytes()))
                .map_err(unusable)?;
        }
        Ok(outcomes)
    }

    #[expect(clippy::unused_self, reason = "a question to the plan")]
    fn foreign(&self, path: &Path, line: usize, found: &str, expected: &str) -> SweepError {
        SweepError::Foreign {
            path: path.to_owned(),
            line,
            found: found.chars().take(16).collect(),
            expected: expected.trim_end().chars().take(40).collect(),
        }
    }

    fn line(&self, run: &Run, outcome: &Outcome) -> String {
        let map = &self.definition.maps[run.map];
        let law = &self.definition.laws(map)[run.law];
        let gains = self.definition.gains.word();
        let (x, y) = (map.x.values[run.x], map.y.values[run.y]);
        let figures = match &outcome.metrics {
            Some(metrics) => metrics.values().map(|value| format!("{value:?}")).join(","),
            None => vec![""; Metrics::COUNT].join(","),
        };
        let (has, state) = (u8::from(outcome.metrics.is_some()), outcome.state.word());
        format!(
            "{},{},{law},{gains},{x:?},{y:?},{},{has},{state},{figures}\n",
            hash(run),
            map.name,
            run.phase
        )
    }

    /// The outcome in `line`, if it is the line of `run`.
    fn read(&self, run: &Run, line: &str) -> Option<Outcome> {
        let fields: Vec<_> = line.split(',').collect();
        let (first, figures) = fields.split_at_checked(FIRST_COLUMNS.len())?;
        let mut values = [0.0; Metrics::COUNT];
        if first[7] == "1" {
            let numbers = figures.iter().map(|figure| figure.parse().ok());
            for (value, number) in values.iter_mut().zip(numbers) {
                *value = number?;
            }
        }
        let outcome = Outcome {
            metrics: (first[7] == "1").then(|| Metrics::from_values(values)),
            state: State::ALL.into_iter().find(|(_, word)| *word == first[8])?.0,
        };
        // Nothing but what would be written.
        (self.line(run, &outcome).trim_end() == line).then_some(outcome)
    }

    /// The gains that a law runs with.
    pub fn gains(&self) -> Gains {
        self.definition.gains
    }
}

/// The configuration of a run: 16 hexadecimal digits.
fn hash(run: &Run) -> String {
    format!("{:016x}", run.scenario.hash())
}
