//! Lockstep over LCM: the clock master's side.
//!
//! At tick n the robot publishes `SIM_LINK_MOTION`, and `ROBOT_STATE` when n is a multiple of T; it goes on once
//! `SIM_TOOL_MOTION` of n and, where due, `ROBOT_COMMAND` of n have come. It alone repeats what is unanswered.

use anyhow::bail;
use crossbeam::channel::Receiver;
use crossbeam::select;
use lcmtypes::{Encoded, Lcm, Received, Subscription};
use node::clock;
use node::greeting::{self, role_name};
use node::lockstep::{PEER_SILENT, Retransmission};
use node::shell::{Flags, Shell};
use robot_sim::RobotSim;
use spatial::ports::{Command, Fault, NodeStatus, Role, Stamp, ToolMotion};
use std::time::{Duration, Instant};

/// Ticks between two status messages while running.
const STATUS_TICKS: i64 = 250;
/// Between two greetings, and between two status messages after the end.
const IDLE: Duration = Duration::from_millis(100);

struct Robot {
    shell: Shell,
    device: Lcm,
    world: Lcm,
    tools: Subscription<ToolMotion>,
    commands: Subscription<Command>,
    peers: Subscription<NodeStatus>,
    timer: Retransmission,
}

/// Why a wait ended without what was waited for.
enum Interrupted {
    Stop,
    Fault,
}

/// Run the node until a signal ends it.
pub(crate) fn run(flags: &Flags) -> anyhow::Result<()> {
    let shell = flags.start(Role::Robot)?;
    let (mut device, mut world) = (flags.device_link()?, flags.simulation_link()?);
    let tools = world.subscribe(16);
    let commands = device.subscribe(16);
    let peers = device.subscribe(16);
    let mut robot = Robot {
        shell,
        device: device.start()?,
        world: world.start()?,
        tools,
        commands,
        peers,
        timer: Retransmission::default(),
    };
    let outcome = robot.greet().and_then(|()| robot.simulate());
    match outcome {
        Err(Interrupted::Stop) => {}
        Ok(()) => {
            robot.shell.health.finish();
            robot.idle();
        }
        Err(Interrupted::Fault) => robot.idle(),
    }
    let faulty = robot.shell.health.faulty();
    robot.shell.finish()?;
    if faulty {
        bail!("ended with a latched fault, see above");
    }
    Ok(())
}

impl Robot {
    /// Find both peers: repeat the own status until each has answered with a matching one.
    fn greet(&mut self) -> Result<(), Interrupted> {
        let (mut sensor, mut controller) = (false, false);
        let give_up = clock::now() + PEER_SILENT;
        while !(sensor && controller) {
            self.shell.publish_status(&self.device);
            let next = clock::now() + IDLE;
            while let Some(status) = self.peer_until(next)? {
                let found = match status.role {
                    Role::Robot => continue,
                    Role::Sensor => &mut sensor,
                    Role::Controller => &mut controller,
                };
                match greeting::compare_at_start(self.shell.health.hello(), &status) {
                    Ok(()) => *found = true,
                    Err(mismatch) => {
                        let (expected, found) = (mismatch.expected, mismatch.found);
                        if self
                            .shell
                            .latch(Fault::HelloMismatch, mismatch.peer, expected, found)
                        {
                            tracing::error!("{mismatch}");
                        }
                        return Err(Interrupted::Fault);
                    }
                }
                if sensor && controller {
                    break;
                }
            }
            if clock::now() >= give_up {
                let silent = if sensor { Role::Controller } else { Role::Sensor };
                return Err(self.silent(silent));
            }
        }
        tracing::info!("sensor-sim and controller are there");
        Ok(())
    }

    /// All ticks of the scenario.
    fn simulate(&mut self) -> Result<(), Interrupted> {
        let mut robot = RobotSim::new(&self.shell.scenario);
        for tick in 0..self.shell.scenario.timing.ticks() {
            let started = clock::now();
            let mut unanswered = [self.shell.publish(&self.world, &robot.link_motion()), None];
            if robot.command_due() {
                unanswered[1] = self.shell.publish(&self.device, &robot.state());
            }
            let (tool, command, repeats) = self.answers(tick, robot.command_due(), &unanswered)?;
            robot.advance(&tool, command.as_ref());
            let took = clock::now() - started;
            if repeats == 0 {
                self.timer.observe(took);
            }
            self.shell.health.reach(tick, took);
            if tick % STATUS_TICKS == 0 {
                self.report();
            }
            if self.shell.health.faulty() {
                return Err(Interrupted::Fault);
            }
        }
        Ok(())
    }

    /// Wait for the answers to `tick`, repeating its messages while any is missing.
    fn answers(
        &mut self,
        tick: i64,
        command_due: bool,
        messages: &[Option<Encoded>],
    ) -> Result<(ToolMotion, Option<Command>, u32), Interrupted> {
        let (mut tool, mut command) = (None, None);
        let give_up = clock::now() + PEER_SILENT;
        let mut repeats = 0;
        let mut deadline = clock::now() + self.timer.wait(repeats);
        loop {
            match (tool, command) {
                (Some(tool), Some(_)) => return Ok((tool, command, repeats)),
                (Some(tool), None) if !command_due => return Ok((tool, None, repeats)),
                _ => {}
            }
            let remaining = deadline.saturating_duration_since(clock::now());
            select! {
                recv(self.tools.receiver()) -> received => {
                    tool = self.fresh(received.ok(), tick, Role::Sensor, |m: &ToolMotion| m.stamp)?.or(tool);
                }
                recv(self.commands.receiver()) -> received => {
                    command = self.fresh(received.ok(), tick, Role::Controller, |m: &Command| m.stamp)?.or(command);
                }
                recv(self.peers.receiver()) -> received => {
                    if let Ok(Received { message, .. }) = received {
                        self.heed(&message)?;
                    }
                }
                recv(self.shell.stop) -> _ => return Err(Interrupted::Stop),
                default(remaining) => {
                    if clock::now() >= give_up {
                        return Err(self.silent(if tool.is_none() { Role::Sensor } else { Role::Controller }));
                    }
                    for message in messages.iter().flatten() {
                        let link = if message.channel().starts_with("SIM_") { &self.world } else { &self.device };
                        self.shell.repeat(link, message);
                    }
                    repeats += 1;
                    deadline = clock::now() + self.timer.wait(repeats);
                }
            }
        }
    }

    /// `message` if it answers `tick`; older ones are late duplicates, newer or foreign ones break the lockstep.
    fn fresh<M>(
        &mut self,
        received: Option<Received<M>>,
        tick: i64,
        peer: Role,
        stamp: impl Fn(&M) -> Stamp,
    ) -> Result<Option<M>, Interrupted> {
        let Some(Received { message, .. }) = received else {
            return Ok(None);
        };
        let found = stamp(&message);
        let expected = Stamp::lockstep(tick, self.shell.health.hello().seed, peer).boot_id;
        if found.boot_id != expected || found.step > tick {
            let (expected, found, what) = if found.step > tick {
                (tick, found.step, "tick")
            } else {
                (expected, found.boot_id, "boot id")
            };
            if self.shell.latch(Fault::LockstepBroken, peer, expected, found) {
                tracing::error!(
                    "lockstep broken: {} answers {what} {found}, expected {expected}; restart all nodes",
                    role_name(peer)
                );
            }
            return Err(Interrupted::Fault);
        }
        Ok((found.step == tick).then_some(message))
    }

    /// A status while running: a peer's fault ends the run, a peer of another run is refused.
    fn heed(&mut self, status: &NodeStatus) -> Result<(), Interrupted> {
        if status.role == Role::Robot {
            return Ok(());
        }
        if let Err(mismatch) = greeting::compare(self.shell.health.hello(), status) {
            if self.shell.latch(
                Fault::HelloMismatch,
                mismatch.peer,
                mismatch.expected,
                mismatch.found,
            ) {
                tracing::error!("{mismatch}");
            }
            return Err(Interrupted::Fault);
        }
        if status.fault != Fault::None {
            if self.shell.latch(
                status.fault,
                status.role,
                status.fault_expected,
                status.fault_found,
            ) {
                tracing::error!(
                    "{} has latched the fault {:?}",
                    role_name(status.role),
                    status.fault
                );
            }
            return Err(Interrupted::Fault);
        }
        Ok(())
    }

    fn silent(&mut self, peer: Role) -> Interrupted {
        let tick = self.shell.health.step() + 1;
        if self.shell.latch(Fault::PeerSilent, peer, tick, -1) {
            let name = role_name(peer);
            let seconds = PEER_SILENT.as_secs();
            tracing::error!(
                "{name} has not answered tick {tick} for {seconds} s; is it running on the same LCM URL? \
                 `touchdown doctor` checks the network"
            );
        }
        Interrupted::Fault
    }

    /// After the end: tell it until a signal comes.
    fn idle(&mut self) {
        loop {
            self.report();
            match self.peer_until(clock::now() + IDLE) {
                Err(Interrupted::Stop) => return,
                _ => continue,
            }
        }
    }

    fn report(&mut self) {
        self.shell.count(&[&self.device, &self.world]);
        self.shell.publish_status(&self.device);
    }

    /// The next status of a peer, or none until `deadline`.
    fn peer_until(&mut self, deadline: Instant) -> Result<Option<NodeStatus>, Interrupted> {
        let remaining = deadline.saturating_duration_since(clock::now());
        let peers: &Receiver<Received<NodeStatus>> = self.peers.receiver();
        select! {
            recv(peers) -> received => Ok(received.ok().map(|received| received.message)),
            recv(self.shell.stop) -> _ => Err(Interrupted::Stop),
            default(remaining) => Ok(None),
        }
    }
}
