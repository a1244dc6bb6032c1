//! How costs grow: with the rate of the cycles, the number of cells on a machine, and the length of a log.

mod figure;
mod logs;

pub use crate::wire_speed::cells::Row as CellRow;
pub use crate::wire_speed::rates::Row as RateRow;
pub use logs::Row as LogRow;

use crate::figure::FigureError;
use crate::launch::LaunchError;
use crate::wire_speed::{Programs, WireSpeedError, cells, rates};
use crossbeam::channel::Receiver;
use lcmtypes::LogError;
use node::scenario::{Scenario, ScenarioError};
use serde::Serialize;
use spatial::ports::Invalid;
use std::io;
use std::path::Path;
use std::time::Duration;

/// All of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Growth {
    /// The controller, by how often it is asked.
    pub rates: Vec<RateRow>,
    /// Cells in lockstep, by how many there are.
    pub cells: Vec<CellRow>,
    /// Analysis and replay, by how long the log is.
    pub logs: Vec<LogRow>,
}

/// How much is measured.
#[derive(Clone, Debug)]
pub struct Amount {
    /// How often each rate and each number of cells has its turn.
    pub turns: u16,
    /// Cycles of a turn of a rate.
    pub cycles: u32,
    /// How long a turn of a number of cells is timed.
    pub window: Duration,
    /// The numbers of cells.
    pub cells: Vec<usize>,
    /// The lengths of logs, s.
    pub logs_s: Vec<f64>,
}

/// Why there is no measurement.
#[derive(Debug, thiserror::Error)]
pub enum GrowthError {
    /// Programs can't be measured.
    #[error("{0}")]
    Programs(#[from] WireSpeedError),
    /// The scenario can't be longer.
    #[error("{0}")]
    Scenario(#[from] ScenarioError),
    /// The loop says what can't be said.
    #[error("{0}")]
    Invalid(#[from] Invalid),
    /// A log can't be written.
    #[error("{0}")]
    Write(#[from] LogError),
    /// A signal asks to end.
    #[error("{0}")]
    Launch(#[from] LaunchError),
    /// A log can't be read as a user does.
    #[error("can't tell what touchdown takes to read a log: {0}")]
    Command(io::Error),
    /// A command has failed.
    #[error("touchdown can't read a log that it has just written; stderr tells why")]
    Failed,
}

/// Measure the programs of `scenario`; `endless` are those of the same that don't end meanwhile. Logs go to `directory`.
pub fn measure(
    [programs, endless]: [&Programs; 2],
    scenario: &Scenario,
    amount: &Amount,
    directory: &Path,
    stop: &Receiver<()>,
) -> Result<Growth, GrowthError> {
    Ok(Growth {
        logs: logs::measure(programs, scenario, &amount.logs_s, directory, stop)?,
        rates: rates::measure(programs, scenario, amount.turns, amount.cycles, stop)?,
        cells: cells::measure(endless, &amount.cells, amount.turns, amount.window, stop)?,
    })
}

impl Growth {
    /// Draw it into files `growth-*.svg` in `directory`.
    pub fn draw(&self, directory: &Path) -> Result<(), FigureError> {
        figure::draw(self, directory)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_growth_has_a_figure() {
        let growth = Growth {
            rates: [1.0, 2.0, 4.0]
                .map(|times| RateRow {
                    cycles_per_s: 250.0 * times,
                    core_share: 0.01 * times,
                    core_us_per_cycle: 40.0,
                })
                .into(),
            cells: [(1, false), (16, false), (1, true), (16, true)]
                .map(|(cells, one_network)| CellRow {
                    cells,
                    one_network,
                    ticks_per_s: 2e4,
                    core_us_per_tick: 100.0,
                })
                .into(),
            logs: [3.0, 48.0]
                .map(|log_s| LogRow {
                    log_s,
                    log_mib: 2.0 * log_s,
                    analyse_core_s: 0.01 * log_s,
                    analyse_mib: 4.0 * log_s,
                    replay_core_s: 0.02 * log_s,
                    replay_mib: 3.0 * log_s,
                })
                .into(),
        };
        let directory = tempfile::tempdir().unwrap();
        growth.draw(directory.path()).unwrap();
        for (name, text) in [
            ("rate", "cycles/s"),
            ("cells", "with suffixes"),
            ("log-time", "replay"),
            ("log-memory", "MiB"),
        ] {
            let path = directory.path().join(format!("growth-{name}.svg"));
            let svg = std::fs::read_to_string(path).unwrap();
            assert!(svg.contains(text) && svg.contains("in proportion"), "{name}");
            assert!(!svg.contains("NaN"), "{name}");
        }
        let error = growth.draw(Path::new("no such directory")).unwrap_err();
        assert!(error.to_string().contains("can't be written"));
    }
}
