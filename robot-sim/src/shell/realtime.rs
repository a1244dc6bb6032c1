//! Real time: the robot paces the world by its own clock and never waits for a command.
//!
//! At tick n it publishes `SIM_LINK_MOTION`, and `ROBOT_STATE` when n is a multiple of T, and integrates once sensor-sim
//! has answered with `SIM_TOOL_MOTION`. Commands are heard whenever they come. Where the plant can't keep up, its time
//! slips: what was late stays late, and nothing is caught up.

use lcmtypes::{Encoded, Lcm, Received, Subscription, Woken};
use node::clock;
use node::lockstep::Retransmission;
use node::problem::Problem;
use node::robot_states::Answer;
use node::shell::{Flags, RealTime, Shell};
use robot_sim::RobotSim;
use spatial::ports::{Command, Deflections, Fault, NodeStatus, Role, Task, TaskAction, ToolMotion};
use std::time::{Duration, Instant};

/// One tick.
const TICK: Duration = Duration::from_micros(spatial::TICK_US as u64);
/// The world may stand still for so long before that is a fault.
const WORLD_SILENT: Duration = Duration::from_millis(200);

struct Robot {
    node: RealTime,
    robot: RobotSim,
    device: Lcm,
    world: Lcm,
    tools: Subscription<ToolMotion>,
    commands: Subscription<Command>,
    deflections: Subscription<Deflections>,
    tasks: Subscription<Task>,
    peers: Subscription<NodeStatus>,
    timer: Retransmission,
    /// The newest motion of the tool.
    tool: Option<ToolMotion>,
    /// The present tick, and when it was due.
    now: (i64, Instant),
}

/// Why the work ends before the scenario does.
enum Interrupted {
    Stop,
    Failed(anyhow::Error),
}

/// Run the node until a signal ends it.
pub(super) fn run(flags: &Flags, mut node: RealTime) -> anyhow::Result<Shell> {
    let (mut device, mut world) = (flags.device_link()?, flags.simulation_link()?);
    let tools = world.subscribe(16);
    let (commands, deflections) = (device.subscribe(64), device.subscribe(64));
    let (tasks, peers) = (device.subscribe(16), device.subscribe(64));
    let mut robot = Robot {
        robot: RobotSim::new(&node.shell.scenario),
        device: node.shell.start_link(device)?,
        world: node.shell.start_link(world)?,
        node,
        tools,
        commands,
        deflections,
        tasks,
        peers,
        timer: Retransmission::default(),
        tool: None,
        now: (0, clock::now()),
    };
    robot.robot.require_sensor();
    match robot.simulate() {
        Ok(()) | Err(Interrupted::Stop) => Ok(robot.node.shell),
        Err(Interrupted::Failed(error)) => Err(error),
    }
}

impl Robot {
    /// Tick by tick until a signal comes: the scenario's end is told, and does not end the robot.
    fn simulate(&mut self) -> Result<(), Interrupted> {
        self.wait_for(|robot| robot.node.peers().boot_id(Role::Sensor).is_some(), None)?;
        let (mut due, mut slip) = (clock::now(), Duration::ZERO);
        let last = self.node.shell.scenario.timing.ticks() - 1;
        for tick in 0.. {
            self.wait_for(|_| false, Some(due))?;
            let late = clock::now().saturating_duration_since(due);
            if late > TICK {
                (due, slip) = (due + late, slip + late);
            }
            self.now = (tick, due);
            self.node.shell.health.wake(late, slip.as_secs_f64());
            let mut link_motion = self.robot.link_motion();
            link_motion.stamp = self.node.stamp(tick, due);
            let unanswered = self.node.shell.publish(&self.world, &link_motion);
            if self.robot.command_due() {
                self.publish_state(tick, due);
            }
            let tool = self.tool_at(tick, unanswered.as_ref())?;
            self.robot.advance(&tool, None);
            self.tell_fault();
            let took = clock::now().saturating_duration_since(due);
            self.node.shell.health.reach(tick, took);
            self.node.shell.health.link().missed = self.robot.state().missed_commands;
            if tick == last {
                tracing::info!("the scenario is over; the robot goes on until SIGTERM or Ctrl-C");
                self.node.shell.health.finish();
            }
            due += TICK;
        }
        Ok(())
    }

    fn publish_state(&mut self, tick: i64, sampled: Instant) {
        let mut state = self.robot.state();
        state.stamp = self.node.stamp(tick, sampled);
        state.echo = self.node.echo();
        self.node.publish_state(&self.device, &state);
    }

    /// The tool's motion at `tick`, for which `message` asks; it is repeated until the sensor's side answers.
    fn tool_at(&mut self, tick: i64, message: Option<&Encoded>) -> Result<ToolMotion, Interrupted> {
        let asked = clock::now();
        let (mut repeats, mut frozen) = (0, false);
        let mut deadline = asked + self.timer.wait(repeats);
        loop {
            let answered = |robot: &Self| robot.tool.is_some_and(|tool| tool.stamp.step == tick);
            self.wait_for(answered, Some(deadline))?;
            if let Some(tool) = self.tool.filter(|tool| tool.stamp.step == tick) {
                self.timer.observe(clock::now() - asked);
                return Ok(tool);
            }
            // Before its first answer the sensor's side may not know yet whom it works with.
            if !frozen && self.tool.is_some() && clock::now() >= asked + WORLD_SILENT {
                frozen = true;
                self.robot.latch(Fault::SimLost);
                self.publish_state(tick, asked);
                self.node.shell.report(&Problem::WorldSilent {
                    tick,
                    seconds: WORLD_SILENT.as_secs_f64(),
                });
            }
            if let Some(message) = message {
                self.node.shell.repeat(&self.world, message);
            }
            repeats += 1;
            deadline = clock::now() + self.timer.wait(repeats);
        }
    }

    /// Hear what comes until `done` or `deadline`.
    fn wait_for(
        &mut self,
        done: impl Fn(&Self) -> bool,
        deadline: Option<Instant>,
    ) -> Result<(), Interrupted> {
        loop {
            self.node.keep_status(&self.device, &[&self.device, &self.world]);
            if done(self) {
                return Ok(());
            }
            // What has come is heard even if the node is late, but no flood holds it up.
            let now = clock::now();
            let past = deadline.is_some_and(|deadline| now >= deadline);
            let wake = self.node.status_due();
            let wake = deadline.map_or(wake, |deadline| deadline.min(wake));
            match self.node.shell.wait(Some(wake.saturating_duration_since(now))) {
                Ok(Woken::Stopped) => return Err(Interrupted::Stop),
                Ok(_) => self.take_all(),
                Err(error) => return Err(Interrupted::Failed(error)),
            }
            if past {
                return Ok(());
            }
        }
    }

    fn take_all(&mut self) {
        while let Some(Received { message, .. }) = self.peers.take() {
            self.node.hear(&message);
        }
        while let Some(Received { message, .. }) = self.tools.take() {
            self.take_tool(&message);
        }
        while let Some(Received { message, .. }) = self.deflections.take() {
            self.take_deflections(&message);
        }
        while let Some(Received { message, received_at }) = self.commands.take() {
            self.take_command(&message, received_at);
        }
        while let Some(Received { message, .. }) = self.tasks.take() {
            self.take_task(&message);
        }
    }

    fn take_tool(&mut self, tool: &ToolMotion) {
        if self.node.works_with(Role::Sensor, tool.stamp.boot_id) {
            self.tool = Some(*tool);
        }
    }

    fn take_deflections(&mut self, deflections: &Deflections) {
        if self.node.admits(deflections) {
            self.robot.sense(deflections);
        }
    }

    fn take_command(&mut self, command: &Command, received_at: Instant) {
        if !self.node.admits(command) {
            return;
        }
        self.node.take_echo(command, received_at);
        let tick = self.node.shell.health.step();
        self.node.shell.heard(tick, command);
        if self.robot.hear(command) == Answer::Ignored {
            self.node.shell.health.link().refused += 1;
        } else if let Some(age) = self.age(command.stamp.step, received_at) {
            self.node.shell.health.use_aged(age);
        }
    }

    /// How long before `instant` the state of tick `step` was sampled; `None`: that tick is still to come.
    fn age(&self, step: i64, instant: Instant) -> Option<Duration> {
        let (tick, due) = self.now;
        let ticks = u32::try_from(tick - step).ok()?;
        instant.checked_duration_since(due.checked_sub(ticks * TICK)?)
    }

    /// Say that the robot has latched a fault.
    fn tell_fault(&mut self) {
        let state = self.robot.state();
        if state.fault != Fault::None && !self.node.shell.health.faulty() {
            let (fault, axis) = (state.fault, state.fault_axis);
            self.node.shell.report(&Problem::RobotFault { fault, axis });
        }
    }

    fn take_task(&mut self, task: &Task) {
        if self.node.admits(task) && task.action == TaskAction::Reset && self.robot.reset() {
            tracing::info!("the fault is cleared");
            self.node.shell.health.forgive();
        }
    }
}
