//! The three programs as child processes: started, watched, and stopped whatever happens.

mod child;
mod command;
mod error;

pub use command::{Ended, NodeCommand};
pub use error::LaunchError;

use crate::transcript::{self, Entry};
use child::{Node, how};
use crossbeam::channel::Receiver;
use crossbeam::select;
use lcmtypes::{Lcm, LcmBuilder, Subscription};
use node::clock;
use node::greeting::role_name;
use spatial::ports::{NodeState, NodeStatus, Role};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Which LCM URL each process uses for the device channels and for the simulated world.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wiring {
    /// By role: device channels.
    pub device: [String; 3],
    /// By role: the simulated world.
    pub world: [String; 3],
    /// Where the nodes' status is heard.
    pub watch: String,
}

/// What to start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Where the programs are.
    pub programs: PathBuf,
    /// The scenario file all of them read.
    pub scenario: PathBuf,
    /// `key=value` overrides.
    pub overrides: Vec<String>,
    /// How they are wired.
    pub wiring: Wiring,
    /// Identity of the run.
    pub run_id: i64,
    /// Where each node's record goes, as [`Plan::record`].
    pub directory: PathBuf,
    /// Further flags, by role.
    pub flags: [Vec<String>; 3],
    /// Program and arguments that start a program, by role, such as one that enters a namespace; empty: none. What is
    /// started so does not end with this process.
    pub through: [Vec<String>; 3],
}

/// How long a started process may take to be heard of, and how long a running robot may stay silent. Longer than
/// the robot waits for its peers, so that it can say which of them is silent.
const SILENT: Duration = Duration::from_secs(4);
/// Between two looks at the children.
const LOOK: Duration = Duration::from_millis(20);
/// How long a child may take to end before it is killed.
const PATIENCE: Duration = Duration::from_secs(2);

impl Wiring {
    /// All processes on the same two URLs.
    pub fn shared(device: &str, world: &str) -> Self {
        let all = |url: &str| std::array::from_fn(|_| url.to_owned());
        Self {
            device: all(device),
            world: all(world),
            watch: device.to_owned(),
        }
    }

    /// Let messages leave the host, as far as the next router.
    pub fn leave_host(&mut self) {
        let urls = self.device.iter_mut().chain(&mut self.world);
        for url in urls.chain([&mut self.watch]) {
            *url = url.replace("ttl=0", "ttl=1");
        }
    }
}

impl Plan {
    /// Where the node in `role` records what it publishes.
    pub fn record(&self, role: Role) -> PathBuf {
        self.directory.join(format!("{}.lcmlog", role_name(role)))
    }

    /// The records of all nodes, in the order in which a tick goes through them.
    pub fn records(&self) -> [PathBuf; 3] {
        [Role::Robot, Role::Sensor, Role::Controller].map(|role| self.record(role))
    }
}

/// Run the three programs through a scenario and return all they have said; their own records are removed.
pub fn run(plan: &Plan, stop: &Receiver<()>, progress: impl FnMut(i64)) -> Result<Vec<Entry>, LaunchError> {
    record(plan, stop, progress).map(transcript::said)
}

/// The same with all else that the nodes have recorded, in the order of time.
pub fn record(
    plan: &Plan,
    stop: &Receiver<()>,
    progress: impl FnMut(i64),
) -> Result<Vec<Entry>, LaunchError> {
    let mut cell = Cell::start(plan)?;
    cell.watch(stop, progress)?;
    cell.stop()?;
    let entries = transcript::record(&plan.records())?;
    for record in &plan.records() {
        // Everything is in `entries`; a file that can't be removed does no harm.
        let _ = std::fs::remove_file(record);
    }
    Ok(entries)
}

/// Three running processes; dropping it stops them.
pub struct Cell {
    run_id: i64,
    nodes: Vec<Node>,
    _link: Lcm,
    statuses: Subscription<NodeStatus>,
}

impl Cell {
    /// Start sensor-sim, controller and robot-sim.
    pub fn start(plan: &Plan) -> Result<Self, LaunchError> {
        Self::start_with(plan, || ())
    }

    /// The same; `before` is done when only the robot, which begins the run, is still to be started.
    pub fn start_with(plan: &Plan, before: impl FnOnce()) -> Result<Self, LaunchError> {
        let mut before = Some(before);
        let mut cell = Self::empty(&plan.wiring.watch, plan.run_id)?;
        for role in [Role::Sensor, Role::Controller, Role::Robot] {
            if let Some(before) = before.take_if(|_| role == Role::Robot) {
                before();
            }
            // A failure drops the cell, which stops those already started.
            cell.nodes.push(Node::start(&plan.command(role))?);
        }
        Ok(cell)
    }

    /// A cell without nodes, of which `watch` hears.
    fn empty(watch: &str, run_id: i64) -> Result<Self, LaunchError> {
        let mut builder = LcmBuilder::open(watch)?;
        let statuses = builder.subscribe(64);
        Ok(Self {
            run_id,
            nodes: Vec::new(),
            _link: builder.start()?,
            statuses,
        })
    }

    /// Start one more node in `role`: after the end of the one before, or beside it.
    pub fn start_another(&mut self, plan: &Plan, role: Role) -> Result<(), LaunchError> {
        self.nodes.push(Node::start(&plan.command(role))?);
        Ok(())
    }

    /// Kill the node in `role` that was started last, and forget it.
    pub fn kill(&mut self, role: Role) {
        if let Some(i) = self.nodes.iter().rposition(|node| node.role == role) {
            let mut node = self.nodes.remove(i);
            node.signal(rustix::process::Signal::KILL);
            node.wait_until(clock::now() + PATIENCE);
        }
    }

    /// Process id of the node in `role`.
    pub fn process_id(&self, role: Role) -> Option<u32> {
        self.nodes
            .iter()
            .find(|node| node.role == role)
            .map(|node| node.child.id())
    }

    /// Watch until the robot has finished the scenario; `progress` sees the tick it has reached.
    pub fn watch(&mut self, stop: &Receiver<()>, mut progress: impl FnMut(i64)) -> Result<(), LaunchError> {
        loop {
            select! {
                recv(self.statuses.receiver()) -> received => {
                    if let Ok(received) = received {
                        let status = received.message;
                        if status.hello.run_id != self.run_id {
                            return Err(LaunchError::Foreign { role: status.role, run_id: status.hello.run_id });
                        }
                        if let Some(node) = self.nodes.iter_mut().find(|node| node.role == status.role) {
                            node.status = Some(status);
                            node.heard = clock::now();
                        }
                        if status.role == Role::Robot {
                            progress(status.stamp.step);
                            if status.state == NodeState::Finished {
                                return Ok(());
                            }
                        }
                        self.faults(&status)?;
                    }
                }
                recv(stop) -> _ => return Err(LaunchError::Interrupted),
                default(LOOK) => {}
            }
            self.look()?;
        }
    }

    /// Stop all processes and wait for their end, so that their records are complete.
    pub fn stop(mut self) -> Result<(), LaunchError> {
        self.end_all()
    }

    fn faults(&self, status: &NodeStatus) -> Result<(), LaunchError> {
        // A node that only tells of one, such as of a record that can't be written, works.
        if status.state != NodeState::Fault {
            return Ok(());
        }
        let node = self.nodes.iter().find(|node| node.role == status.role);
        Err(LaunchError::Faulty {
            role: status.role,
            fault: status.fault,
            tick: status.fault_step,
            peer: status.fault_peer,
            expected: status.fault_expected,
            found: status.fault_found,
            last: node.map_or_else(String::new, Node::last_words),
        })
    }

    /// Whether any process has ended or gone silent.
    fn look(&mut self) -> Result<(), LaunchError> {
        let tick = self
            .nodes
            .iter()
            .filter_map(|node| node.status.map(|status| status.stamp.step))
            .max()
            .unwrap_or(-1);
        for node in &mut self.nodes {
            if let Ok(Some(status)) = node.child.try_wait() {
                node.listen_to_the_end();
                return Err(LaunchError::Died {
                    role: node.role,
                    status: how(status),
                    tick,
                    last: node.last_words(),
                });
            }
        }
        let now = clock::now();
        // Sensor and controller only answer; once the run goes on, the robot alone tells that it does.
        let started = self.nodes.iter().all(|node| node.status.is_some());
        let silent = self.nodes.iter().find(|node| {
            let expected = node.status.is_none() || (started && node.role == Role::Robot);
            expected && now.saturating_duration_since(node.heard) > SILENT
        });
        match silent {
            Some(node) => Err(LaunchError::Silent {
                role: node.role,
                seconds: SILENT.as_secs(),
            }),
            None => Ok(()),
        }
    }

    fn end_all(&mut self) -> Result<(), LaunchError> {
        for node in &self.nodes {
            node.signal(rustix::process::Signal::TERM);
        }
        let give_up = clock::now() + PATIENCE;
        let mut first_failure = Ok(());
        for node in &mut self.nodes {
            let ended = node.wait_until(give_up);
            if !ended.is_some_and(|status| status.success()) && first_failure.is_ok() {
                first_failure = Err(LaunchError::Died {
                    role: node.role,
                    status: ended.map_or_else(|| "did not end when asked to".to_owned(), how),
                    tick: node.status.map_or(-1, |status| status.stamp.step),
                    last: node.last_words(),
                });
            }
        }
        self.nodes.clear();
        first_failure
    }
}

impl Drop for Cell {
    fn drop(&mut self) {
        // Whoever drops it without `stop` has an error of its own to tell.
        let _ = self.end_all();
    }
}

/// Where the programs of this workspace are: beside the running one, or one directory above a test.
pub fn programs() -> std::io::Result<PathBuf> {
    let own = std::env::current_exe()?;
    let directory = own.parent().unwrap_or(Path::new("."));
    if directory.ends_with("deps") {
        return Ok(directory.parent().unwrap_or(directory).to_owned());
    }
    Ok(directory.to_owned())
}
