//! Skeleton of a real robot's driver: the wire contract (`lcmtypes/README.md`) is served, [`Drives`] is to be filled in.
//!
//! ```sh
//! cargo run --release --example robot_driver -- --scenario cell.toml --set timing.mode=realtime
//! touchdown conform robot            # does it keep the contract?  --move: also when it is enabled
//! ```
//!
//! What it takes from `node`: flags, logging, status, peers and clock ([`RealTime`]); which commands are fresh, from whom, within
//! the limits of the scenario's `[robot]`, and what state that brings the robot into ([`Commanded`]). What is left is a tick of
//! 1 ms: read the encoders, publish every T, write the set-points. It speaks the device channels alone; there is no `SIM_*`.
//!
//! To make it a driver: implement [`Drives`] for your robot, create yours in `run`, and put kinematics, ranges, velocity limits,
//! `command_delay_periods` and `command_gap_s` of your robot into the scenario that all nodes read.

use anyhow::bail;
use clap::Parser;
use lcmtypes::{Lcm, Received, Subscription, Woken};
use node::clock;
use node::commanded::{Commanded, STANDING_RAD_PER_S};
use node::problem::Problem;
use node::robot_states::Answer;
use node::shell::{Flags, Pace, RealTime};
use spatial::TICK_S;
use spatial::kinematics::Axes;
use spatial::ports::{
    Authenticity, Command, Deflections, ENCODER_SAMPLES, Fault, NodeStatus, RobotState, Role, Task,
    TaskAction,
};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// One tick.
const TICK: Duration = Duration::from_micros(spatial::TICK_US as u64);

/// The robot's drives: what there is to be filled in. None of these may block for longer than a fraction of a tick.
trait Drives {
    /// What the encoders, on the motor side of the gears, read now: angles, rad (a linear axis: m of a rack on a pinion of 1 m).
    fn read_encoders(&mut self) -> Axes;

    /// Ask the position control of the axes for these angles (rad) until the next tick. It must keep to the axes'
    /// accelerations by itself: when commands end, the set-points stop at once, and it is what brakes.
    fn write_set_points(&mut self, axes: &Axes);

    /// A fault of the drives (an emergency stop, a following error) and its axis, -1: none, for as long as it is there.
    fn fault(&mut self) -> Option<(Fault, i32)> {
        None
    }
}

/// Drives that are none: each axis follows its set-point within some ticks.
struct InMemory {
    axes: Axes,
    set_points: Axes,
}

impl Drives for InMemory {
    fn read_encoders(&mut self) -> Axes {
        self.axes += (self.set_points - self.axes) * 0.2;
        self.axes
    }

    fn write_set_points(&mut self, axes: &Axes) {
        self.set_points = *axes;
    }
}

/// The driver between two ticks.
struct Driver<D> {
    drives: D,
    node: RealTime,
    device: Lcm,
    commands: Subscription<Command>,
    deflections: Subscription<Deflections>,
    tasks: Subscription<Task>,
    peers: Subscription<NodeStatus>,
    commanded: Commanded,
    period_ticks: i64,
    /// The tick to come.
    tick: i64,
    /// The last readings, newest first.
    encoder: [Axes; ENCODER_SAMPLES],
    set_points: Axes,
}

impl<D: Drives> Driver<D> {
    fn start(flags: &Flags, mut node: RealTime, mut drives: D) -> anyhow::Result<Self> {
        let mut device = flags.device_link()?;
        let (commands, deflections) = (device.subscribe(64), device.subscribe(64));
        let (tasks, peers) = (device.subscribe(16), device.subscribe(64));
        let axes = drives.read_encoders();
        let mut commanded = Commanded::new(&node.shell.scenario, axes);
        commanded.require_sensor();
        Ok(Self {
            drives,
            commanded,
            period_ticks: node.shell.scenario.timing.command_period_ticks,
            device: node.shell.start_link(device)?,
            node,
            commands,
            deflections,
            tasks,
            peers,
            tick: 0,
            encoder: [axes; ENCODER_SAMPLES],
            set_points: axes,
        })
    }

    /// Tick by tick, by absolute deadlines, until a signal comes. What is late by more than a tick stays late: nothing is caught
    /// up.
    fn drive(&mut self) -> anyhow::Result<()> {
        let (mut due, mut slip) = (clock::now(), Duration::ZERO);
        loop {
            if self.hear_until(due)? == Woken::Stopped {
                return Ok(());
            }
            let late = clock::now().saturating_duration_since(due);
            if late > TICK {
                (due, slip) = (due + late, slip + late);
            }
            self.node.shell.health.wake(late, slip.as_secs_f64());
            self.pass_tick();
            due += TICK;
        }
    }

    fn pass_tick(&mut self) {
        let sampled = clock::now();
        self.encoder.rotate_right(1);
        self.encoder[0] = self.drives.read_encoders();
        if let Some((fault, axis)) = self.drives.fault() {
            self.commanded.latch(fault, axis);
        }
        if self.tick % self.period_ticks == 0 {
            self.publish_state(sampled);
        }
        self.set_points = self.commanded.begin(self.tick);
        self.drives.write_set_points(&self.set_points);
        self.commanded.pass(self.velocity().amax() < STANDING_RAD_PER_S);
        let (fault, axis) = (
            self.commanded.states().fault(),
            self.commanded.states().fault_axis(),
        );
        if fault != Fault::None && !self.node.shell.health.faulty() {
            self.node.shell.report(&Problem::RobotFault { fault, axis });
        }
        let took = clock::now().saturating_duration_since(sampled);
        self.node.shell.health.reach(self.tick, took);
        self.node.shell.health.link().missed = self.commanded.missed_commands();
        self.tick += 1;
    }

    /// The axes' velocities, rad/s; better those that the drives measure, if they do.
    fn velocity(&self) -> Axes {
        (self.encoder[0] - self.encoder[1]) / TICK_S
    }

    fn publish_state(&mut self, sampled: Instant) {
        let states = self.commanded.states();
        let state = RobotState {
            stamp: self.node.stamp(self.tick, sampled),
            sample_count: (self.tick + 1).clamp(1, ENCODER_SAMPLES as i64) as i32,
            axis_position: self.encoder,
            axis_velocity: self.velocity(),
            axis_setpoint: self.set_points,
            mode: states.mode(),
            fault: states.fault(),
            fault_axis: states.fault_axis(),
            command_step: self.commanded.command_step(),
            missed_commands: self.commanded.missed_commands(),
            echo: self.node.echo(),
            authenticity: Authenticity::default(),
        };
        self.node.publish_state(&self.device, &state);
    }

    /// Hear what comes until `due`; a flood of messages does not hold up the tick.
    fn hear_until(&mut self, due: Instant) -> anyhow::Result<Woken> {
        loop {
            self.node.keep_status(&self.device, &[&self.device]);
            let wake = due.min(self.node.status_due());
            let pause = wake.saturating_duration_since(clock::now());
            let woken = self.node.shell.wait(Some(pause))?;
            while let Some(received) = self.peers.take() {
                self.node.hear(&received.message);
            }
            while let Some(received) = self.deflections.take() {
                self.take_deflections(&received.message);
            }
            while let Some(received) = self.commands.take() {
                self.take_command(&received);
            }
            while let Some(received) = self.tasks.take() {
                self.take_task(&received.message);
            }
            if woken == Woken::Stopped || clock::now() >= due {
                return Ok(woken);
            }
        }
    }

    fn take_deflections(&mut self, deflections: &Deflections) {
        if self.node.admits(deflections) {
            self.commanded.sense(self.tick, deflections);
        }
    }

    fn take_command(&mut self, received: &Received<Command>) {
        let command = &received.message;
        if !self.node.admits(command) {
            return;
        }
        self.node.take_echo(command, received.received_at);
        if self.commanded.hear(self.tick, command) == Answer::Ignored {
            self.node.shell.health.link().refused += 1;
        }
    }

    fn take_task(&mut self, task: &Task) {
        let cause_gone = self.drives.fault().is_none();
        if self.node.admits(task) && task.action == TaskAction::Reset && self.commanded.reset(cause_gone) {
            tracing::info!("the fault is cleared");
            self.node.shell.health.forgive();
        }
    }
}

/// Skeleton of a robot's driver, with drives in memory.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(flatten)]
    node: Flags,
}

fn run(flags: &Flags) -> anyhow::Result<()> {
    let Pace::RealTime(node) = flags.realtime(flags.start(Role::Robot)?)? else {
        bail!(
            "timing.mode is lockstep, but a device has a time of its own; add --set timing.mode=realtime to all nodes"
        );
    };
    let axes = node.shell.scenario.start_axes()?;
    let mut driver = Driver::start(
        flags,
        node,
        InMemory {
            axes,
            set_points: axes,
        },
    )?;
    driver.drive()?;
    driver.node.shell.finish()
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    node::shell::run(|| run(&arguments.node))
}
