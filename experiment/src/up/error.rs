//! Why a cell is not started.

use super::CellConfig;
use crate::scenarios::SourceError;
use node::scenario::ScenarioError;
use std::io;
use std::path::PathBuf;

/// Why a cell is not started.
#[derive(Debug, thiserror::Error)]
pub enum UpError {
    /// No such file.
    #[error(
        "the cell {} can't be read: {source}; name an existing file, such as experiment/cells/two_hosts.toml",
        path.display()
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// It is not TOML, or a key or a type is wrong.
    #[error("the cell {name}: {message}")]
    Syntax {
        /// The file.
        name: String,
        /// What is wrong, and where.
        message: String,
    },
    /// Values that do not work: one line each.
    #[error("{}", problems.join("\n"))]
    Problems {
        /// Thing, value, limit, remedy.
        problems: Vec<String>,
    },
    /// Where its scenario comes from.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// Its scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// Nothing to do here.
    #[error(
        "no node of {name} runs on host {host:?}; its hosts are {}; name one of them by --host, or put {host:?} into the file",
        hosts.join(", ")
    )]
    NothingHere {
        /// The file.
        name: String,
        /// This host.
        host: String,
        /// Those with nodes.
        hosts: Vec<String>,
    },
    /// A node that runs elsewhere.
    #[error(
        "{node} of {name} runs on {there:?}, not on {host:?}; start it there, or change its host in the file"
    )]
    Elsewhere {
        /// The file.
        name: String,
        /// The node.
        node: &'static str,
        /// Where it runs; empty: nowhere.
        there: String,
        /// This host.
        host: String,
    },
}

impl UpError {
    /// No node of `config` belongs to `host`.
    pub(super) fn nothing_here(config: &CellConfig, host: &str) -> Self {
        Self::NothingHere {
            name: config.name.clone(),
            host: host.to_owned(),
            hosts: config.hosts().into_iter().map(str::to_owned).collect(),
        }
    }
}
