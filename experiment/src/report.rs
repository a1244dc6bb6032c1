//! The report: laws, scenarios and maps as one HTML file that needs nothing but a browser.
//!
//! All of it is computed when it is written: [`Work::run`] runs every comparison and the sweep, [`Report::html`]
//! shows them. Beside every figure and table stands its [`Origin`]: the command that makes it again, the hash of its
//! configuration, and its seeds. The file is the same whatever the number of threads.

mod gather;
mod losses;
mod origin;
mod page;
pub(crate) mod parts;
mod ranking;
mod section;

pub use gather::Work;
pub use losses::{Loss, losses};
pub use origin::Origin;
pub use section::{Panel, Section};

use crate::figure::FigureError;
use crate::scenarios::SourceError;
use crate::sweep::{Cells, Plan, SweepError};
use crate::tuning::TuningError;
use node::scenario::ScenarioError;

/// What goes into a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Names or paths of scenarios, one section each.
    pub scenarios: Vec<String>,
    /// Contact phases relative to T.
    pub phases: usize,
    /// Seeds for each of them.
    pub seeds: usize,
    /// Name or path of the sweep whose maps are shown.
    pub sweep: String,
    /// Contact phases of each cell of the maps.
    pub sweep_phases: usize,
}

/// All that a report shows.
#[derive(Clone, Debug)]
pub struct Report {
    /// What was asked for.
    pub options: Options,
    /// Runs in all.
    pub runs: usize,
    /// One for each scenario.
    pub sections: Vec<Section>,
    /// The maps.
    pub maps: Maps,
}

/// The maps of a sweep.
#[derive(Clone, Debug)]
pub struct Maps {
    /// Where all of them come from.
    pub origin: Origin,
    /// What was run.
    pub plan: Plan,
    /// What came of it.
    pub cells: Cells,
    /// A figure for each map.
    pub figures: Vec<String>,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A scenario does not exist.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A scenario makes no sense.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// Its tuned gains are missing.
    #[error(transparent)]
    Tuning(#[from] TuningError),
    /// The maps can't be made.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A figure can't be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
}
