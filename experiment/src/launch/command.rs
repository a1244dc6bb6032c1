//! What starts a node, and a cell of which only some nodes are started here.

use super::child::{Node, how};
use super::{Cell, LaunchError, Plan};
use lcmtypes::Received;
use node::greeting::role_name;
use spatial::ports::{NodeStatus, Role};
use std::ffi::OsString;
use std::path::PathBuf;

/// What starts a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeCommand {
    /// What it plays.
    pub role: Role,
    /// What starts it, such as a program that enters a network namespace; empty: nothing beside this process.
    pub through: Vec<String>,
    /// Its program.
    pub program: PathBuf,
    /// Its flags.
    pub arguments: Vec<OsString>,
    /// What it logs, where the environment does not say.
    pub log: &'static str,
}

/// How a node has ended on its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ended {
    /// Which.
    pub role: Role,
    /// Whether it was asked to, by a signal, and did so well.
    pub well: bool,
    /// How, in words.
    pub how: String,
    /// Its last words on stderr.
    pub last: String,
}

impl Plan {
    /// What starts the node in `role`.
    pub(super) fn command(&self, role: Role) -> NodeCommand {
        let index = role as usize;
        let wiring = &self.wiring;
        let run_id = self.run_id.to_string();
        let mut arguments: Vec<OsString> = vec!["--scenario".into(), self.scenario.clone().into()];
        arguments.extend(["--url", &wiring.device[index]].map(OsString::from));
        arguments.extend(["--sim-url", &wiring.world[index]].map(OsString::from));
        arguments.extend(["--run-id", &run_id].map(OsString::from));
        arguments.extend(["--record".into(), self.record(role).into()]);
        for change in &self.overrides {
            arguments.extend(["--set", change].map(OsString::from));
        }
        arguments.extend(self.flags[index].iter().map(OsString::from));
        NodeCommand {
            role,
            through: self.through[index].clone(),
            program: self.programs.join(role_name(role)),
            arguments,
            log: "warn",
        }
    }
}

impl Cell {
    /// Start `nodes` alone; `watch` is where all nodes of the cell are heard, wherever they run.
    pub fn of(watch: &str, run_id: i64, nodes: &[NodeCommand]) -> Result<Self, LaunchError> {
        let mut cell = Self::empty(watch, run_id)?;
        for node in nodes {
            // A failure drops the cell, which stops those already started.
            cell.nodes.push(Node::start(node)?);
        }
        Ok(cell)
    }

    /// Where the nodes' statuses arrive, those on other hosts included.
    pub fn statuses(&self) -> &crossbeam::channel::Receiver<Received<NodeStatus>> {
        self.statuses.receiver()
    }

    /// Nodes that have ended on their own since the last call; they are forgotten.
    pub fn ended(&mut self) -> Vec<Ended> {
        let mut ended = Vec::new();
        self.nodes.retain_mut(|node| match node.child.try_wait() {
            Ok(Some(status)) => {
                node.listen_to_the_end();
                ended.push(Ended {
                    role: node.role,
                    well: status.success(),
                    how: how(status),
                    last: node.last_words(),
                });
                false
            }
            _ => true,
        });
        ended
    }

    /// Whether no node that was started here is left.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }
}
