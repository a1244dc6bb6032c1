//! A cell in real time on one host or several: `touchdown up` starts the nodes that belong to this host and tells what
//! becomes of all of them.
//!
//! Nothing is restarted here: nodes find each other again whenever they are started, so that whoever supervises a host
//! (systemd, a person) can do that node by node.

mod config;
mod error;
mod watch;

pub use config::{CellConfig, Place, same_host};
pub use error::UpError;
pub(crate) use watch::unpadded;
pub use watch::{Event, Watch};

use crate::launch::{Cell, LaunchError, NodeCommand};
use crossbeam::channel::Receiver;
use crossbeam::select;
use node::clock;
use node::greeting::role_name;
use spatial::ports::Role;
use std::ffi::OsString;
use std::path::Path;
use std::time::Duration;

/// All roles, in the order in which they are started.
pub const ROLES: [Role; 3] = [Role::Sensor, Role::Controller, Role::Robot];
/// Between two looks at the children.
const LOOK: Duration = Duration::from_millis(20);

impl CellConfig {
    /// What starts the nodes of `roles`, whose programs are in `programs`, with the scenario in `scenario`.
    pub fn commands(&self, roles: &[Role], programs: &Path, scenario: &Path) -> Vec<NodeCommand> {
        let command = |role: Role| {
            let run_id = self.run_id.to_string();
            let mut arguments: Vec<OsString> = vec!["--scenario".into(), scenario.into()];
            let mut flag = |name: &str, value: &str| arguments.extend([name, value].map(OsString::from));
            flag("--url", &self.url);
            flag("--sim-url", &self.sim_url);
            flag("--run-id", &run_id);
            for change in &self.overrides {
                flag("--set", change);
            }
            if let Some(place) = self.place(role) {
                let numbers = [("--cpu", place.cpu), ("--priority", place.priority)];
                for (name, value) in numbers {
                    if let Some(value) = value {
                        flag(name, &value.to_string());
                    }
                }
            }
            for key in &self.keys {
                arguments.extend([OsString::from("--key"), key.into()]);
            }
            NodeCommand {
                role,
                through: Vec::new(),
                program: programs.join(role_name(role)),
                arguments,
                log: "info",
            }
        };
        roles.iter().copied().map(command).collect()
    }
}

/// Attend to `cell` until `stop`, or until none of its nodes is left here; what happens is told. Then all are stopped.
/// Returns whether none
/// has died, or ended with a fault.
pub fn attend(
    mut cell: Cell,
    mut watch: Watch,
    stop: &Receiver<()>,
    mut tell: impl FnMut(Event),
) -> Result<bool, LaunchError> {
    let mut well = true;
    loop {
        let statuses = cell.statuses().clone();
        select! {
            recv(statuses) -> received => if let Ok(received) = received {
                watch.hear(&received.message, received.received_at).into_iter().for_each(&mut tell);
            },
            recv(stop) -> _ => {
                let ended = cell.stop();
                well &= ended.is_ok();
                return ended.map(|()| well).or_else(|error| match error {
                    LaunchError::Died { role, status, last, .. } => {
                        tell(watch.end_badly(role, &status, &last));
                        Ok(false)
                    }
                    error => Err(error),
                });
            }
            default(LOOK) => {}
        }
        for ended in cell.ended() {
            well &= ended.well;
            tell(watch.end(&ended));
        }
        if cell.is_empty() {
            return Ok(well);
        }
        watch.look(clock::now()).into_iter().for_each(&mut tell);
    }
}
