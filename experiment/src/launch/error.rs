//! Why a run ended before its scenario was over.

use lcmtypes::{LcmError, LogError};
use node::greeting::role_name;
use spatial::ports::{Fault, Role};
use std::path::PathBuf;

/// Why a run ended before its scenario was over.
#[derive(Debug, thiserror::Error)]
pub enum LaunchError {
    /// A program can't be started.
    #[error("can't start {}: {source}; build all programs with `cargo build --release`", path.display())]
    Start {
        /// The program.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The nodes' status can't be heard.
    #[error(transparent)]
    Lcm(#[from] LcmError),
    /// A process ended on its own.
    #[error("{} died ({status}) at tick {tick}; its last message: {last}", role_name(*role))]
    Died {
        /// Which.
        role: Role,
        /// How.
        status: String,
        /// Tick that it or the run had reached.
        tick: i64,
        /// Its last words on stderr.
        last: String,
    },
    /// A process has latched a fault.
    #[error(
        "{} latched {fault:?} at tick {tick} (peer {}, expected {expected}, found {found}); its last message: {last}",
        role_name(*role), role_name(*peer)
    )]
    Faulty {
        /// Which.
        role: Role,
        /// The fault.
        fault: Fault,
        /// When.
        tick: i64,
        /// Whom it concerns.
        peer: Role,
        /// What was expected.
        expected: i64,
        /// What was found.
        found: i64,
        /// Its last words on stderr.
        last: String,
    },
    /// A process of another run is heard.
    #[error(
        "another run's {} (run id {run_id}) is on this port; end it, or choose another --port",
        role_name(*role)
    )]
    Foreign {
        /// Which.
        role: Role,
        /// Identity of its run.
        run_id: i64,
    },
    /// A process is not heard of.
    #[error(
        "{} has not been heard of for {seconds} s; `touchdown doctor` checks whether multicast works here",
        role_name(*role)
    )]
    Silent {
        /// Which.
        role: Role,
        /// For how long.
        seconds: u64,
    },
    /// A node's record can't be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A signal asked to end.
    #[error("interrupted")]
    Interrupted,
}
