//! How near the programs come to the wire's own speed.
//!
//! The wire's own is what processes reach that do nothing but receive from a raw UDP multicast socket and send messages of the
//! same sizes ([`bare`]). Against it stand the time from a sensor's message to the command that answers it ([`cycles`]) and the
//! ticks that three programs in lockstep do in a second ([`ring`]); both are measured in turns, so that what the machine
//! does meanwhile concerns both alike. What a key adds to each message is computation alone ([`signatures`]).

pub mod bare;
pub mod cells;
pub mod cycles;
mod peer;
mod plant;
pub mod rates;
pub mod ring;
pub mod signatures;
mod statistics;
mod wire;

use crate::launch::{self, LaunchError, NodeCommand};
use crate::run_port::{RunPort, RunPortError};
use crossbeam::channel::{Receiver, RecvTimeoutError};
use lcmtypes::DecodeError;
use node::greeting::role_name;
use spatial::ports::{Invalid, Role};
use std::ffi::OsString;
use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How long nothing may be heard of a process.
const SILENT: Duration = Duration::from_secs(5);
/// How long a port has to be quiet before it is used.
const QUIET: Duration = Duration::from_millis(200);

/// The scenario that the programs run.
#[derive(Clone, Debug)]
pub struct Programs {
    /// The file.
    pub scenario: PathBuf,
    /// `key=value` overrides.
    pub overrides: Vec<String>,
}

impl Programs {
    /// With one more override.
    #[must_use]
    pub fn with(&self, change: String) -> Self {
        let mut changed = self.clone();
        changed.overrides.push(change);
        changed
    }
}

/// Why there is no measurement.
#[derive(Debug, thiserror::Error)]
pub enum WireSpeedError {
    /// A program can't be started, or a signal asks to end.
    #[error("{0}")]
    Launch(#[from] LaunchError),
    /// There is no port.
    #[error("{0}")]
    Port(#[from] RunPortError),
    /// The programs are not found.
    #[error("the directory of this program is not known: {0}; start it by its path")]
    Directory(io::Error),
    /// A socket.
    #[error(
        "can't {action} on port {port}: {source}; `touchdown doctor` checks whether multicast works here"
    )]
    Socket {
        /// What was to be done.
        action: &'static str,
        /// Where.
        port: u16,
        /// What the system said.
        source: io::Error,
    },
    /// A process does not answer.
    #[error(
        "no {what} was heard on port {port} for {seconds} s; stderr tells what became of the process that should send it"
    )]
    Silent {
        /// Channel.
        what: &'static str,
        /// Where.
        port: u16,
        /// For how long.
        seconds: u64,
    },
    /// The kernel does not tell what a process uses.
    #[error("/proc does not tell what a process uses: {0}; stderr tells what became of it")]
    Usage(io::Error),
    /// The simulated robot or sensor can't say what it should.
    #[error("{0}")]
    Own(#[from] Invalid),
    /// The controller's answer can't be used.
    #[error("{0}")]
    Answer(#[from] DecodeError),
}

impl Programs {
    /// What starts the program of `role` on `port`; `options` are added to its LCM URLs.
    pub(crate) fn command(
        &self,
        role: Role,
        port: &RunPort,
        options: &str,
    ) -> Result<NodeCommand, WireSpeedError> {
        let (device, world) = (port.device_url() + options, port.simulation_url() + options);
        let mut arguments: Vec<OsString> = vec!["--scenario".into(), self.scenario.clone().into()];
        arguments.extend(["--url", &device, "--sim-url", &world].map(OsString::from));
        for change in &self.overrides {
            arguments.extend(["--set", change].map(OsString::from));
        }
        command(role, program(role_name(role))?, arguments)
    }
}

fn command(role: Role, program: PathBuf, arguments: Vec<OsString>) -> Result<NodeCommand, WireSpeedError> {
    Ok(NodeCommand {
        role,
        through: Vec::new(),
        program,
        arguments,
        log: "warn",
    })
}

/// The program `name` of this workspace.
fn program(name: &str) -> Result<PathBuf, WireSpeedError> {
    Ok(launch::programs().map_err(WireSpeedError::Directory)?.join(name))
}

/// Wait until `instant`, or for a signal.
pub(crate) fn wait_until(instant: Instant, stop: &Receiver<()>) -> Result<(), LaunchError> {
    match stop.recv_deadline(instant) {
        Err(RecvTimeoutError::Timeout) => Ok(()),
        Ok(()) | Err(RecvTimeoutError::Disconnected) => Err(LaunchError::Interrupted),
    }
}
