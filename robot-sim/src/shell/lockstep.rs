//! Lockstep over LCM: the clock master's side.
//!
//! At tick n the robot publishes `SIM_LINK_MOTION`, and `ROBOT_STATE` when n is a multiple of T; it goes on once
//! `SIM_TOOL_MOTION` of n and, where due, `ROBOT_COMMAND` of n have come. It alone repeats what is unanswered.

use lcmtypes::{Encoded, Lcm, Message, Received, Subscription, Woken};
use node::clock;
use node::greeting;
use node::lockstep::{PEER_SILENT, Retransmission};
use node::problem::Problem;
use node::shell::{Flags, Shell};
use robot_sim::RobotSim;
use spatial::ports::{Command, Fault, NodeStatus, Role, Stamp, ToolMotion};
use std::time::{Duration, Instant};

/// Ticks between two status messages while running.
const STATUS_TICKS: i64 = 250;
/// Between two greetings, and between two status messages while waiting and after the end.
const STATUS_PERIOD: Duration = Duration::from_millis(100);

struct Robot {
    shell: Shell,
    device: Lcm,
    world: Lcm,
    tools: Subscription<ToolMotion>,
    commands: Subscription<Command>,
    peers: Subscription<NodeStatus>,
    timer: Retransmission,
}

/// Why the work ends before the scenario does.
enum Interrupted {
    Stop,
    Problem(Problem),
    Failed(anyhow::Error),
}

/// Run the node until a signal ends it.
pub(super) fn run(flags: &Flags, mut shell: Shell) -> anyhow::Result<Shell> {
    let (mut device, mut world) = (flags.device_link()?, flags.simulation_link()?);
    let tools = world.subscribe(16);
    let commands = device.subscribe(16);
    let peers = device.subscribe(16);
    let mut robot = Robot {
        device: shell.start_link(device)?,
        world: shell.start_link(world)?,
        shell,
        tools,
        commands,
        peers,
        timer: Retransmission::default(),
    };
    match robot.greet().and_then(|()| robot.simulate()) {
        Ok(()) => {
            tracing::info!("the scenario is over; SIGTERM or Ctrl-C ends this node");
            robot.shell.health.finish();
            robot.idle();
        }
        Err(Interrupted::Problem(problem)) => {
            robot.shell.report(&problem);
            robot.idle();
        }
        Err(Interrupted::Stop) => {}
        Err(Interrupted::Failed(error)) => return Err(error),
    }
    Ok(robot.shell)
}

impl Robot {
    /// Find both peers: repeat the own status until each has answered with a matching one.
    fn greet(&mut self) -> Result<(), Interrupted> {
        let mut missing = vec![Role::Sensor, Role::Controller];
        let give_up = clock::now() + PEER_SILENT;
        while !missing.is_empty() {
            if clock::now() >= give_up {
                return Err(silent(missing, -1));
            }
            self.shell.publish_status(&self.device);
            let next = clock::now() + STATUS_PERIOD;
            while !missing.is_empty() {
                let Some(status) = self.peer_until(next)? else {
                    break;
                };
                if missing.contains(&status.role) {
                    greeting::compare_at_start(self.shell.health.hello(), &status)
                        .map_err(|mismatch| Interrupted::Problem(Problem::Refused(mismatch)))?;
                    missing.retain(|role| *role != status.role);
                }
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
            if self.shell.health.faulty() {
                // The own message could not be published or recorded; it has been reported.
                self.idle();
                return Err(Interrupted::Stop);
            }
            let (tool, command) = self.answers(tick, robot.command_due(), &unanswered)?;
            robot.advance(&tool, command.as_ref());
            let took = clock::now() - started;
            self.timer.observe(took);
            self.shell.health.reach(tick, took);
            if tick % STATUS_TICKS == 0 {
                self.report();
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
    ) -> Result<(ToolMotion, Option<Command>), Interrupted> {
        let (mut tool, mut command) = (None, None);
        let start = clock::now();
        let (give_up, mut next_status) = (start + PEER_SILENT, start + STATUS_PERIOD);
        let mut repeats = 0;
        let mut deadline = start + self.timer.wait(repeats);
        loop {
            match (tool, command) {
                (Some(tool), Some(_)) => return Ok((tool, command)),
                (Some(tool), None) if !command_due => return Ok((tool, None)),
                _ => {}
            }
            // Looked at before every wait, so that no flood of messages can hold it up.
            let now = clock::now();
            if now >= give_up {
                return Err(silent(
                    vec![if tool.is_none() {
                        Role::Sensor
                    } else {
                        Role::Controller
                    }],
                    tick,
                ));
            }
            if now >= next_status {
                self.report();
                next_status = now + STATUS_PERIOD;
            }
            if now >= deadline {
                for message in messages.iter().flatten() {
                    let link = if message.channel().starts_with("SIM_") {
                        &self.world
                    } else {
                        &self.device
                    };
                    self.shell.repeat(link, message);
                }
                repeats += 1;
                deadline = now + self.timer.wait(repeats);
            }
            self.wait(deadline.saturating_duration_since(now))?;
            while let Some(received) = self.tools.take() {
                tool = self.fresh(received, tick, Role::Sensor)?.or(tool);
            }
            while let Some(received) = self.commands.take() {
                command = self.fresh(received, tick, Role::Controller)?.or(command);
            }
            while let Some(Received { message, .. }) = self.peers.take() {
                self.heed(&message)?;
            }
        }
    }

    /// The message if it answers `tick`; older ones are late duplicates, newer or foreign ones break the lockstep.
    fn fresh<M: Message>(
        &self,
        received: Received<M>,
        tick: i64,
        peer: Role,
    ) -> Result<Option<M>, Interrupted> {
        let Received { message, .. } = received;
        let found = message.stamp();
        let expected = Stamp::lockstep(tick, self.shell.health.hello().seed, peer);
        if found.boot_id != expected.boot_id || found.step > tick {
            return Err(Interrupted::Problem(Problem::Broken {
                peer,
                expected,
                found,
            }));
        }
        Ok((found.step == tick).then_some(message))
    }

    /// A status while running: a peer's fault ends the run, a peer of another run is refused.
    fn heed(&self, status: &NodeStatus) -> Result<(), Interrupted> {
        if status.role == Role::Robot {
            return Ok(());
        }
        if let Err(mismatch) = greeting::compare(self.shell.health.hello(), status) {
            return Err(Interrupted::Problem(Problem::Refused(mismatch)));
        }
        if status.fault != Fault::None {
            let (peer, fault) = (status.role, status.fault);
            return Err(Interrupted::Problem(Problem::PeerFault { peer, fault }));
        }
        Ok(())
    }

    /// After the end: tell it until a signal comes.
    fn idle(&mut self) {
        loop {
            self.report();
            // What comes meanwhile changes nothing; the own status comes back too.
            let next = clock::now() + STATUS_PERIOD;
            loop {
                match self.peer_until(next) {
                    Ok(Some(_)) => {}
                    Ok(None) => break,
                    Err(_) => return,
                }
            }
        }
    }

    fn report(&mut self) {
        self.shell.count(&[&self.device, &self.world]);
        self.shell.publish_status(&self.device);
    }

    /// The next status of a node, or none until `deadline`.
    fn peer_until(&mut self, deadline: Instant) -> Result<Option<NodeStatus>, Interrupted> {
        loop {
            let remaining = deadline.saturating_duration_since(clock::now());
            if remaining.is_zero() {
                return Ok(None);
            }
            if let Some(received) = self.peers.take() {
                return Ok(Some(received.message));
            }
            self.wait(remaining)?;
        }
    }

    /// Wait for messages, for at most `limit`.
    fn wait(&mut self, limit: Duration) -> Result<(), Interrupted> {
        match self.shell.wait(Some(limit)) {
            Ok(Woken::Stopped) => Err(Interrupted::Stop),
            Ok(_) => Ok(()),
            Err(error) => Err(Interrupted::Failed(error)),
        }
    }
}

fn silent(peers: Vec<Role>, tick: i64) -> Interrupted {
    Interrupted::Problem(Problem::Silent {
        peers,
        tick,
        seconds: PEER_SILENT.as_secs(),
    })
}
