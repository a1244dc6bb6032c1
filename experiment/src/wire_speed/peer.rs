//! Who answers the sensor's messages: a process, and what this one keeps of it.

use super::bare::Bare;
use super::cycles::Receive;
use super::plant::{Plant, Said};
use super::wire::Wire;
use super::{Programs, QUIET, SILENT, WireSpeedError, command, wait_until};
use crate::launch::{Cell, NodeCommand};
use crate::run_port::RunPort;
use crate::usage::Usage;
use crossbeam::channel::Receiver;
use lcmtypes::{Message, datagram};
use node::clock;
use node::health::{self, Health};
use node::scenario::Scenario;
use spatial::ports::{Command, ControllerStatus, Deflections, NodeStatus, ObjectPose, RobotState, Role};
use std::path::Path;
use std::time::Duration;

/// How long an answer may take before the question is repeated.
const REPEAT: Duration = Duration::from_millis(100);
/// Answers by Python's LCM.
const ECHO: &str = include_str!("echo.py");

/// A process that answers, and robot and sensor of its own.
pub(super) struct Peer {
    wire: Wire,
    plant: Plant,
    /// Its last answer, if it is one that a robot can follow.
    command: Option<Command>,
    /// Whether its answers have content.
    controls: bool,
    cell: Cell,
    _port: RunPort,
}

impl Peer {
    /// Start a process that receives by `receive`, and wait until it answers.
    pub(super) fn start(
        receive: &Receive,
        programs: &Programs,
        scenario: &Scenario,
        stop: &Receiver<()>,
    ) -> Result<Self, WireSpeedError> {
        let port = RunPort::free(QUIET)?;
        let period_ticks = scenario.timing.command_period_ticks;
        let node = match receive {
            Receive::Raw => Bare::command(Role::Controller, &port, period_ticks, Duration::ZERO)?,
            Receive::Own => programs.command(Role::Controller, &port, "")?,
            Receive::Liblcm => programs.command(Role::Controller, &port, Receive::LIBLCM)?,
            Receive::Python(python) => echo(python, &port)?,
        };
        let wire = Wire::join(port.port(), REPEAT)?;
        let mut peer = Self {
            wire,
            plant: Plant::new(scenario),
            command: None,
            controls: matches!(receive, Receive::Own | Receive::Liblcm),
            // Nobody listens beside the two, who would have to be woken up, too.
            cell: Cell::of("memq://", 0, &[node])?,
            _port: port,
        };
        if peer.controls {
            peer.greet(scenario, stop)?;
        }
        let first = peer.prepare()?;
        peer.exchange(&first)?;
        Ok(peer)
    }

    /// What its process has used.
    pub(super) fn usage(&self) -> Result<Usage, WireSpeedError> {
        let id = self.cell.process_id(Role::Controller).unwrap_or_default();
        Usage::of(id).map_err(WireSpeedError::Usage)
    }

    /// Say who the robot is until the controller has answered.
    fn greet(&mut self, scenario: &Scenario, stop: &Receiver<()>) -> Result<(), WireSpeedError> {
        let robot = Health::new(Role::Robot, health::hello(scenario, 0)).status();
        let status = robot.encode()?;
        let give_up = clock::now() + SILENT;
        while clock::now() < give_up {
            wait_until(clock::now(), stop)?;
            self.wire.send(status.channel(), status.as_bytes())?;
            while let Some((channel, encoding)) = self.wire.receive()? {
                let answers = channel == NodeStatus::CHANNEL.as_bytes()
                    && NodeStatus::decode(encoding)?.role == Role::Controller;
                if answers {
                    return Ok(());
                }
            }
        }
        Err(self.silent(NodeStatus::CHANNEL))
    }

    /// What robot and sensor say next.
    pub(super) fn prepare(&mut self) -> Result<Said, WireSpeedError> {
        Ok(self.plant.go_on(self.command.take().as_ref())?)
    }

    /// Say it; the time from then on to the command that answers it, unless something was lost on the way.
    pub(super) fn exchange(&mut self, said: &Said) -> Result<Option<Duration>, WireSpeedError> {
        let give_up = clock::now() + SILENT;
        let mut repeated = false;
        while clock::now() < give_up {
            self.wire.send(RobotState::CHANNEL, said.state.as_bytes())?;
            if let Some(pose) = &said.object_pose {
                self.wire.send(ObjectPose::CHANNEL, pose.as_bytes())?;
            }
            // Before it is sent, since who is woken up by it may answer before this process goes on.
            let started = clock::now();
            self.wire.send(Deflections::CHANNEL, said.deflection.as_bytes())?;
            let answered = self.hear(Command::CHANNEL, said.tick)?;
            let took = clock::now() - started;
            if let Some(command) = answered
                && self.hear(ControllerStatus::CHANNEL, said.tick)?.is_some()
            {
                if self.controls {
                    self.command = Some(Command::decode(&command)?);
                }
                return Ok((!repeated).then_some(took));
            }
            repeated = true;
        }
        Err(self.silent(Command::CHANNEL))
    }

    /// The encoding of the message of `tick` on `channel`; `None`: nothing came for a while.
    fn hear(&mut self, channel: &'static str, tick: i64) -> Result<Option<Vec<u8>>, WireSpeedError> {
        while let Some((heard, encoding)) = self.wire.receive()? {
            if heard == channel.as_bytes() && datagram::step(encoding) == Some(tick) {
                return Ok(Some(encoding.to_vec()));
            }
        }
        Ok(None)
    }

    fn silent(&self, what: &'static str) -> WireSpeedError {
        WireSpeedError::Silent {
            what,
            port: self.wire.port,
            seconds: SILENT.as_secs(),
        }
    }
}

/// What starts Python's answers.
fn echo(python: &Path, port: &RunPort) -> Result<NodeCommand, WireSpeedError> {
    let arguments = ["-c", ECHO, &port.device_url()].map(Into::into).to_vec();
    command(Role::Controller, python.to_owned(), arguments)
}
