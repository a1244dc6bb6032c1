//! A cell in real time behind a relay, and what is heard of it.

use crate::cell::{Bench, signal};
use crate::hosts::Hosts;
use crate::relay::{Impairment, Relay};
use crossbeam::channel::RecvError;
use crossbeam::select;
use experiment::launch::Cell;
use experiment::transcript::{self, Entry};
use lcmtypes::{Lcm, LcmBuilder, Received, Subscription};
use node::authenticity::{Author, Gate, Signed};
use node::{clock, key_file};
use rustix::process::Signal;
use spatial::TICK_S;
use spatial::ports::{
    Command, ControllerPhase, ControllerStatus, Deflections, NodeStatus, RobotMode, RobotState, Role, Stamp,
    Task, TaskAction, Truth,
};
use std::error::Error;
use std::path::Path;
use std::time::Duration;

/// Whoever asks by `TASK`.
const ASKER: i64 = 4242;
/// What an attacker leaves in what it forges, so that it is not taken for a node's: in `session`, and for a status in what was
/// expected.
pub const FORGED: i64 = 0x0bad_0bad;
/// How long something may take that has to come.
pub const LONG: Duration = Duration::from_secs(20);

/// Three programs in real time, each with ports of its own that a relay joins.
pub struct Site {
    /// Where it runs.
    pub bench: Bench,
    /// What joins the device channels; `None`: nothing does, they share a port.
    relay: Option<Relay>,
    /// The programs.
    pub cell: Cell,
    /// What is heard.
    pub heard: Heard,
    /// Ports of the device channels where each has its own: by role, then the watching one's.
    ports: Vec<u16>,
    device: Lcm,
    subscriptions: Subscriptions,
    asked: i64,
    /// What requests are signed with.
    operator: Option<Gate>,
    _others: [Lcm; 2],
    /// The simulated world's, which impairs nothing.
    _world_relay: Option<Relay>,
}

/// What is run, and where.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// Built-in scenario.
    pub scenario: &'a str,
    /// Changes of it.
    pub overrides: &'a [&'a str],
    /// What the device channels suffer.
    pub impairment: Impairment,
    /// Further flags by role.
    pub flags: [&'a [&'a str]; 3],
    /// A host for each program; `None`: all on this one.
    pub hosts: Option<&'a Hosts>,
    /// Key file of all programs, and of who asks.
    pub key: Option<&'a Path>,
    /// By role: what starts its program, such as with fewer rights; empty: nothing.
    pub through: [&'a [&'a str]; 3],
    /// All on the same ports of one host, with nothing between that could keep an attacker's packets from anybody.
    pub shared: bool,
}

impl Default for Setting<'_> {
    fn default() -> Self {
        Self {
            scenario: "paper",
            overrides: &[],
            impairment: Impairment::default(),
            flags: [&[], &[], &[]],
            hosts: None,
            key: None,
            through: [&[], &[], &[]],
            shared: false,
        }
    }
}

struct Subscriptions {
    states: Subscription<RobotState>,
    commands: Subscription<Command>,
    deflections: Subscription<Deflections>,
    controllers: Subscription<ControllerStatus>,
    nodes: Subscription<NodeStatus>,
    truths: Subscription<Truth>,
}

/// The newest of each, and what has happened since [`Heard::mark`].
#[derive(Default)]
pub struct Heard {
    /// `ROBOT_STATE`.
    pub robot: Option<RobotState>,
    /// `ROBOT_COMMAND`.
    pub command: Option<Command>,
    /// `SENSOR_DEFLECTION`.
    pub deflections: Option<Deflections>,
    /// `CONTROLLER_STATUS`.
    pub controller: Option<ControllerStatus>,
    /// `NODE_STATUS` by role.
    pub nodes: [Option<NodeStatus>; 3],
    /// `SIM_TRUTH`.
    pub truth: Option<Truth>,
    /// Largest contact force, N.
    pub peak_n: f64,
    /// Smallest and largest contact force, N.
    pub force_n: [f64; 2],
    /// Largest speed of an axis, rad/s.
    pub speed_rad_per_s: f64,
    /// Largest speed of the servos' set-point of an axis, rad/s.
    pub set_point_rad_per_s: f64,
    /// The robot's states, each as often as it was come into.
    pub modes: Vec<RobotMode>,
    /// Tick of the last command that the robot took, and tick at which it was first seen at rest with a fault.
    pub stopped: Option<[i64; 2]>,
    /// Age of the oldest command that the robot went on with: ticks since the state that it answers.
    pub command_age_ticks: i64,
}

impl Heard {
    /// Forget what has happened until now.
    pub fn mark(&mut self) {
        (self.peak_n, self.speed_rad_per_s, self.stopped) = (0.0, 0.0, None);
        (self.force_n, self.set_point_rad_per_s) = ([f64::INFINITY, f64::NEG_INFINITY], 0.0);
        self.command_age_ticks = 0;
        self.modes.clear();
    }

    /// Phase of the controller.
    pub fn phase(&self) -> Option<ControllerPhase> {
        self.controller.map(|status| status.phase)
    }

    fn take_state(&mut self, state: &RobotState) {
        self.speed_rad_per_s = self.speed_rad_per_s.max(state.axis_velocity.amax());
        if state.mode == RobotMode::Fault && self.stopped.is_none() {
            self.stopped = Some([state.command_step, state.stamp.step]);
        }
        if matches!(state.mode, RobotMode::Following | RobotMode::Bridging) {
            self.command_age_ticks = self.command_age_ticks.max(state.stamp.step - state.command_step);
        }
        if let Some(before) = self.robot {
            // States may be lost.
            let ticks = (state.stamp.step - before.stamp.step).max(1) as f64;
            let gone_rad = (state.axis_setpoint - before.axis_setpoint).amax();
            self.set_point_rad_per_s = self.set_point_rad_per_s.max(gone_rad / (ticks * TICK_S));
        }
        if self.modes.last() != Some(&state.mode) {
            self.modes.push(state.mode);
        }
        self.robot = Some(*state);
    }

    fn take_truth(&mut self, truth: &Truth) {
        self.peak_n = self.peak_n.max(truth.contact_force_peak_n);
        let [least, most] = self.force_n;
        self.force_n = [least.min(truth.contact_force.z), most.max(truth.contact_force.z)];
        self.truth = Some(*truth);
    }
}

impl Site {
    /// As `setting` says.
    pub fn start(setting: &Setting<'_>) -> Result<Self, Box<dyn Error>> {
        let always = ["timing.mode=realtime", "timing.duration_s=3600"];
        let all: Vec<_> = always.iter().chain(setting.overrides).copied().collect();
        let mut bench = Bench::of(setting.scenario, &all)?;
        let separate = match setting.shared {
            true => None,
            false => Some(bench.separate()?),
        };
        let flags = |flags: &[&str]| flags.iter().map(|&flag| flag.to_owned()).collect();
        bench.plan.flags = setting.flags.map(flags);
        bench.plan.through = setting.through.map(flags);
        let keys = setting.key.map(Path::to_path_buf);
        let keyring = key_file::read_all(keys.as_slice())?;
        for (flags, key) in bench.plan.flags.iter_mut().zip(keys.iter().cycle()) {
            flags.push(format!("--key={}", key.display()));
        }
        let ttl = u32::from(setting.hosts.is_some());
        if let Some(hosts) = setting.hosts {
            bench.plan.through = hosts.through();
            bench.plan.wiring.leave_host();
        }
        let [device, world] = separate.unwrap_or_default();
        let relay = |ports: &Vec<u16>, impairment| match ports.is_empty() {
            true => Ok(None),
            false => Relay::start(std::slice::from_ref(ports), ttl, impairment).map(Some),
        };
        let (relay, world_relay) = (
            relay(&device, setting.impairment)?,
            relay(&world, Impairment::default())?,
        );
        let mut link = LcmBuilder::open(&bench.plan.wiring.watch)?;
        // The robot's own port: what it says is heard however it is cut off.
        let mut own = LcmBuilder::open(&bench.plan.wiring.device[Role::Robot as usize])?;
        let mut sim = LcmBuilder::open(&bench.plan.wiring.world[Role::Sensor as usize])?;
        let subscriptions = Subscriptions {
            states: own.subscribe(1024),
            commands: link.subscribe(1024),
            deflections: link.subscribe(1024),
            controllers: link.subscribe(1024),
            nodes: link.subscribe(256),
            truths: sim.subscribe(8192),
        };
        Ok(Self {
            device: link.start()?,
            _others: [sim.start()?, own.start()?],
            cell: Cell::start(&bench.plan)?,
            bench,
            relay,
            _world_relay: world_relay,
            heard: Heard::default(),
            ports: device,
            subscriptions,
            asked: 0,
            operator: keyring.map(|keyring| Gate::new(keyring, Author::Operator)),
        })
    }

    /// Listen until `done`; `false`: not within `limit`.
    pub fn until(&mut self, limit: Duration, done: impl Fn(&Heard) -> bool) -> bool {
        let give_up = clock::now() + limit;
        while !done(&self.heard) {
            let left = give_up.saturating_duration_since(clock::now());
            if left.is_zero() {
                return false;
            }
            let (heard, from, gate) = (&mut self.heard, &self.subscriptions, &mut self.operator);
            select! {
                recv(from.states.receiver()) -> it => if let Some(state) = genuine(gate, it) {
                    heard.take_state(&state);
                },
                recv(from.commands.receiver()) -> it => if let Some(command) = genuine(gate, it) {
                    heard.command = Some(command);
                },
                recv(from.deflections.receiver()) -> it => if let Some(deflections) = genuine(gate, it) {
                    heard.deflections = Some(deflections);
                },
                recv(from.controllers.receiver()) -> it => heard.controller = it.ok().map(|it| it.message),
                recv(from.truths.receiver()) -> it => if let Ok(it) = it { heard.take_truth(&it.message) },
                recv(from.nodes.receiver()) -> it => if let Ok(it) = it && it.message.fault_expected != FORGED {
                    heard.nodes[it.message.role as usize] = Some(it.message);
                },
                default(left) => {}
            }
        }
        true
    }

    /// Listen for `time`.
    pub fn listen(&mut self, time: Duration) {
        self.until(time, |_| false);
    }

    /// Ask by `TASK`, again and again until `done`; `false`: not within [`LONG`].
    pub fn ask(&mut self, action: TaskAction, done: impl Fn(&Heard) -> bool) -> bool {
        (0..LONG.as_millis() / 100).any(|_| {
            self.asked += 1;
            let mut task = Task {
                stamp: Stamp {
                    step: self.asked,
                    utime: 0,
                    boot_id: ASKER,
                },
                action,
                ..Task::default()
            };
            if let Some(gate) = &mut self.operator {
                gate.sign(&mut task);
            }
            // A full buffer is one more loss.
            let _ = self.device.publish(&task);
            self.until(Duration::from_millis(100), &done)
        })
    }

    /// Stop the programs; what they have said.
    pub fn finish(self) -> Result<Vec<Entry>, Box<dyn Error>> {
        let Self { cell, bench, .. } = self;
        cell.stop()?;
        Ok(transcript::from_logs(&bench.plan.records())?)
    }

    /// The link that is listened on.
    pub fn link(&self) -> &Lcm {
        &self.device
    }

    /// Send `what` to the node in `role`: where another program has started it on its host, to the last child.
    pub fn signal(&self, role: Role, what: Signal) {
        let child = |id: &u32| {
            let children = std::fs::read_to_string(format!("/proc/{id}/task/{id}/children")).ok()?;
            children.split_whitespace().next()?.parse().ok()
        };
        if let Some(id) = std::iter::successors(self.cell.process_id(role), child).last() {
            signal(id, what);
        }
    }

    /// Cut the node in `role` off from the others' device channels, or join it again.
    pub fn cut(&self, role: Role, off: bool) {
        if let (Some(relay), Some(port)) = (&self.relay, self.ports.get(role as usize)) {
            relay.cut(*port, off);
        }
    }
}

/// A message; under a key, only if it is signed and new.
fn genuine<M: Signed>(gate: &mut Option<Gate>, it: Result<Received<M>, RecvError>) -> Option<M> {
    let message = it.ok()?.message;
    let takes = match gate {
        Some(gate) => gate.admit(&message).is_ok(),
        None => message.authenticity().session != FORGED,
    };
    takes.then_some(message)
}
