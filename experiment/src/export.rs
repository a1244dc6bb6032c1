//! Logs for other programs: MCAP with JSON, which Foxglove shows as it is, and CSV.
//!
//! Names, types and comments are those of the .lcm files ([`lcmtypes::schema`]).

mod csv;
mod mcap;

pub use csv::write_csv;
pub use mcap::write_mcap;

use crate::log::{Log, said_on};
use crate::transcript::Entry;
use lcmtypes::schema::{Type, Value};
use std::io;
use std::path::{Path, PathBuf};

/// A file that can't be written.
#[derive(Debug, thiserror::Error)]
#[error("can't write {path}: {source}; choose a place that can be written to")]
pub struct ExportError {
    /// The file.
    pub path: PathBuf,
    /// What the system said.
    pub source: io::Error,
}

impl ExportError {
    fn new(path: &Path, source: impl Into<io::Error>) -> Self {
        Self {
            path: path.to_owned(),
            source: source.into(),
        }
    }
}

/// The usable messages of a log with their types and values.
fn messages(log: &Log) -> impl Iterator<Item = (&Entry, &'static Type, Vec<Value>)> {
    log.entries.iter().filter_map(|entry| {
        let channel = said_on(&entry.channel);
        Some((
            entry,
            Type::of(channel)?,
            Type::values(channel, &entry.bytes).ok()?,
        ))
    })
}

#[cfg(test)]
mod tests;
