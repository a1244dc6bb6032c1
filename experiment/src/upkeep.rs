//! What the three programs take of a machine: in real time a share of a core and page faults, and time to start.

use crate::cost::median;
use crate::launch::{Cell, LaunchError, NodeCommand, programs};
use crate::run_port::{RunPort, RunPortError};
use crate::usage::Usage;
use crate::wire_speed::{Programs, WireSpeedError, wait_until};
use crossbeam::channel::{Receiver, RecvTimeoutError};
use lcmtypes::{LcmBuilder, LcmError, Message, Subscription};
use node::clock;
use node::greeting::role_name;
use serde::Serialize;
use spatial::TICK_S;
use spatial::ports::{ControllerPhase, ControllerStatus, NodeStatus, RobotState, Role};
use std::io;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const ROLES: [Role; 3] = [Role::Robot, Role::Sensor, Role::Controller];
/// How long nothing may be heard of a process.
const SILENT: Duration = Duration::from_secs(10);
/// How long a port has to be quiet before it is used.
const QUIET: Duration = Duration::from_millis(200);
/// Between two looks at a process, or for a signal.
const LOOK: Duration = Duration::from_millis(50);
/// From when the programs have heard of each other to the first look.
const WARM_UP: Duration = Duration::from_secs(1);

/// What one program takes between two instants.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Cycles a second, 1/s.
    pub cycles_per_s: f64,
    /// Which program.
    pub program: &'static str,
    /// Its share of one core.
    pub core_share: f64,
    /// Page faults that took no reading from a disk.
    pub minor_faults: u64,
    /// Page faults that did.
    pub major_faults: u64,
    /// Whether it has its real-time rights, memory locked against paging included.
    pub realtime_rights: bool,
    /// Its first fault; `None`: it has none.
    pub fault: Option<String>,
}

/// How long a command takes to bring about a contact, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StartUp {
    /// From the start of `touchdown run` to its first `ROBOT_STATE`; the median.
    pub first_tick_s: f64,
    /// To the first `CONTROLLER_STATUS` that knows of the contact; the median.
    pub first_contact_s: f64,
    /// Its shortest.
    pub first_contact_s_min: f64,
    /// Its longest.
    pub first_contact_s_max: f64,
}

/// Why there is no measurement.
#[derive(Debug, thiserror::Error)]
pub enum UpkeepError {
    /// A program can't be started, or a signal asks to end.
    #[error("{0}")]
    Launch(#[from] LaunchError),
    /// The programs can't be started as those of `bench network`.
    #[error("{0}")]
    Programs(#[from] WireSpeedError),
    /// There is no port.
    #[error("{0}")]
    Port(#[from] RunPortError),
    /// They can't be heard.
    #[error("{0}")]
    Lcm(#[from] LcmError),
    /// The kernel does not tell.
    #[error("/proc does not tell what {program} uses: {source}; stderr tells what became of it")]
    Untold {
        /// Which.
        program: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// The command can't be started.
    #[error("can't start touchdown: {0}")]
    Start(io::Error),
    /// Something is not heard.
    #[error("no {what} was heard on port {port} for {} s; stderr tells what became of who should send it", SILENT.as_secs())]
    Silent {
        /// Channel.
        what: &'static str,
        /// Where.
        port: u16,
    },
}

/// What the three `programs` of a scenario with a cycle every `period_ticks` take in real time within `window`, which begins a
/// second after the programs know each other: their approach to the object, contact and pressing lie within it if it is long enough.
/// Files that they leave go to `directory`.
pub fn measure(
    programs: &Programs,
    period_ticks: i64,
    window: Duration,
    directory: &Path,
    stop: &Receiver<()>,
) -> Result<Vec<Row>, UpkeepError> {
    let port = RunPort::free(QUIET)?;
    let mut programs = programs.clone();
    programs.overrides.extend([
        "timing.mode=realtime".to_owned(),
        format!("timing.command_period_ticks={period_ticks}"),
    ]);
    let command = |role| -> Result<NodeCommand, WireSpeedError> {
        let mut command = programs.command(role, &port, "")?;
        command
            .arguments
            .extend(["--flight-dir".into(), directory.as_os_str().to_owned()]);
        Ok(command)
    };
    let nodes = ROLES.map(command).into_iter().collect::<Result<Vec<_>, _>>()?;
    // A link of its own hears nothing and is not woken up.
    let cell = Cell::of("memq://", 0, &nodes)?;
    statuses(&port, stop)?;
    wait_until(clock::now() + WARM_UP, stop)?;
    let started = clock::now();
    let before = usages(&cell)?;
    wait_until(started + window, stop)?;
    let (after, window_s) = (usages(&cell)?, (clock::now() - started).as_secs_f64());
    let statuses = statuses(&port, stop)?;
    let row = |i: usize| {
        let used = after[i] - before[i];
        Row {
            cycles_per_s: 1.0 / (period_ticks as f64 * TICK_S),
            program: role_name(ROLES[i]),
            core_share: used.core_s / window_s,
            minor_faults: used.minor_faults,
            major_faults: used.major_faults,
            realtime_rights: statuses[i].realtime,
            fault: Some(statuses[i].fault)
                .filter(|fault| *fault != spatial::ports::Fault::None)
                .map(|fault| format!("{fault:?}")),
        }
    };
    Ok((0..ROLES.len()).map(row).collect())
}

fn usages(cell: &Cell) -> Result<[Usage; 3], UpkeepError> {
    let mut usages = [Usage::default(); 3];
    for (usage, role) in usages.iter_mut().zip(ROLES) {
        let id = cell.process_id(role).unwrap_or_default();
        let program = role_name(role);
        *usage = Usage::of(id).map_err(|source| UpkeepError::Untold { program, source })?;
    }
    Ok(usages)
}

/// A status of each program, heard from now on. Nobody listens otherwise: who does is woken up by each message.
fn statuses(port: &RunPort, stop: &Receiver<()>) -> Result<[NodeStatus; 3], UpkeepError> {
    let mut builder = LcmBuilder::open(&port.device_url())?;
    let heard = builder.subscribe::<NodeStatus>(64);
    let _link = builder.start()?;
    let mut statuses = [None; 3];
    let deadline = clock::now() + SILENT;
    loop {
        let status = next(&heard, port.port(), deadline, stop)?;
        statuses[ROLES
            .iter()
            .position(|role| *role == status.role)
            .unwrap_or_default()] = Some(status);
        if let [Some(robot), Some(sensor), Some(controller)] = statuses {
            return Ok([robot, sensor, controller]);
        }
    }
}

/// The next message until `deadline`.
fn next<M: Message>(
    heard: &Subscription<M>,
    port: u16,
    deadline: Instant,
    stop: &Receiver<()>,
) -> Result<M, UpkeepError> {
    while clock::now() < deadline {
        wait_until(clock::now(), stop)?;
        match heard.receiver().recv_timeout(LOOK) {
            Ok(received) => return Ok(received.message),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    let what = M::CHANNEL;
    Err(UpkeepError::Silent { what, port })
}

/// A process that ends with this.
struct Ending(Child);

impl Drop for Ending {
    fn drop(&mut self) {
        if !matches!(self.0.try_wait(), Ok(None)) {
            return;
        }
        let id = i32::try_from(self.0.id())
            .ok()
            .and_then(rustix::process::Pid::from_raw);
        if let Some(id) = id {
            // Asked to, it ends those that it has started.
            let _ = rustix::process::kill_process(id, rustix::process::Signal::INT);
        }
        let _ = self.0.wait();
    }
}

/// How long `touchdown run` with the law `proposed` takes to the first tick and to the contact, `repetitions` times. `programs` tells
/// of what; what it writes goes to `directory`.
pub fn start_up(
    scenario: &Programs,
    repetitions: u16,
    directory: &Path,
    stop: &Receiver<()>,
) -> Result<StartUp, UpkeepError> {
    let touchdown = programs().map_err(UpkeepError::Start)?.join("touchdown");
    let (mut ticks, mut contacts) = (Vec::new(), Vec::new());
    for _ in 0..repetitions {
        let port = RunPort::free(QUIET)?.port();
        let mut builder = LcmBuilder::open(&format!("udpm://{}:{port}?ttl=0", crate::run_port::GROUP))?;
        let states = builder.subscribe::<RobotState>(1 << 14);
        let controls = builder.subscribe::<ControllerStatus>(1 << 14);
        let _link = builder.start()?;
        let mut command = Command::new(&touchdown);
        command.args(["run", "--laws", "proposed", "--port", &port.to_string(), "--out"]);
        command.arg(directory).arg(&scenario.scenario);
        for change in &scenario.overrides {
            command.args(["--set", change]);
        }
        let started = clock::now();
        let child = command.stdin(Stdio::null()).stdout(Stdio::null()).spawn();
        let mut child = Ending(child.map_err(UpkeepError::Start)?);
        let deadline = started + SILENT;
        next(&states, port, deadline, stop)?;
        ticks.push((clock::now() - started).as_secs_f64());
        while next(&controls, port, deadline, stop)?.phase != ControllerPhase::Contact {}
        contacts.push((clock::now() - started).as_secs_f64());
        while clock::now() < deadline && matches!(child.0.try_wait(), Ok(None)) {
            wait_until(clock::now() + LOOK, stop)?;
        }
    }
    for times in [&mut ticks, &mut contacts] {
        times.sort_by(f64::total_cmp);
    }
    Ok(StartUp {
        first_tick_s: median(&ticks),
        first_contact_s: median(&contacts),
        first_contact_s_min: contacts[0],
        first_contact_s_max: contacts[contacts.len() - 1],
    })
}
