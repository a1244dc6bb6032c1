//! Why a sweep does not run.

use super::definition::names;
use crate::tuning::TuningError;
use node::scenario::ScenarioError;
use std::io;
use std::path::PathBuf;

/// Why a sweep does not run.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Neither a built-in sweep nor a path.
    #[error("unknown sweep {name:?}; the built-in ones are: {}; a path works too: it contains a / or ends with .toml",
        names().collect::<Vec<_>>().join(", "))]
    Unknown {
        /// The name.
        name: String,
    },
    /// A definition that means nothing.
    #[error("the sweep {name}: {message}")]
    Definition {
        /// Name or path.
        name: String,
        /// What is wrong.
        message: String,
    },
    /// Its scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// Where the scenario comes from.
    #[error(transparent)]
    Source(#[from] crate::scenarios::SourceError),
    /// Its tuned gains.
    #[error(transparent)]
    Tuning(#[from] TuningError),
    /// The runs in the file are not this sweep's.
    #[error(
        "line {line} of {} is no run of this sweep: {found:?} instead of the configuration {expected}; choose another \
         --out, or --fresh to begin anew",
        path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
        /// Where, from 1.
        line: usize,
        /// The beginning of what is there.
        found: String,
        /// The configuration that belongs there.
        expected: String,
    },
    /// A run that its length does not leave anything to judge of.
    #[error("map {map}, law {law}: {reason}")]
    NothingJudged {
        /// Its map.
        map: String,
        /// Its law.
        law: String,
        /// Why.
        reason: crate::metrics::NoFigures,
    },
    /// A file that can't be read or written.
    #[error("{} can't be read or written: {source}; choose a directory that can be written to", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A figure that can't be drawn.
    #[error("the map {map} can't be drawn: {message}")]
    Draw {
        /// Its name.
        map: String,
        /// Why.
        message: String,
    },
}
