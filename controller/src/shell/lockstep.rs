//! Lockstep over LCM: the controller answers `ROBOT_STATE` of tick n, once `SENSOR_DEFLECTION` and, where it is due,
//! `OBJECT_POSE` of n are there, with `ROBOT_COMMAND` and `CONTROLLER_STATUS` of n, and a repeated state with the
//! same bytes.

mod inputs;

use controller::agenda::Agenda;
use controller::{Controller, Heard};
use inputs::Inputs;
use lcmtypes::{Encoded, Lcm, Received, Woken};
use node::clock;
use node::lockstep::{Answer, Follower};
use node::problem::Problem;
use node::shell::{Flags, Shell};
use spatial::TICK_US;
use spatial::ports::{Deflections, NodeStatus, ObjectPose, RobotState, Role, Stamp, Task};

/// Run the node until a signal ends it.
pub(super) fn run(flags: &Flags, mut shell: Shell) -> anyhow::Result<Shell> {
    let mut device = flags.device_link()?;
    let states = device.subscribe::<RobotState>(16);
    let deflections = device.subscribe::<Deflections>(16);
    let object_poses = device.subscribe::<ObjectPose>(16);
    let tasks = device.subscribe::<Task>(16);
    let peers = device.subscribe::<NodeStatus>(16);
    let device = shell.start_link(device)?;
    let timing = &shell.scenario.timing;
    let mut node = Node {
        follower: Follower::new(
            timing.command_period_ticks,
            Stamp::lockstep(0, timing.seed, Role::Robot).boot_id,
        ),
        sensor_boot_id: Stamp::lockstep(0, timing.seed, Role::Sensor).boot_id,
        controller: Controller::new(&shell.scenario),
        inputs: Inputs::new(&shell.scenario.object_sensor),
        agenda: Agenda::default(),
        answers: [const { None }; 2],
    };
    while shell.wait(None)? != Woken::Stopped {
        while let Some(Received { message, .. }) = peers.take() {
            shell.count(&[&device]);
            shell.greet(&device, &message);
        }
        while let Some(Received { message, .. }) = tasks.take() {
            node.take_task(&message);
        }
        while let Some(Received { message, .. }) = states.take() {
            node.take_state(&mut shell, &device, message);
        }
        while let Some(Received { message, .. }) = object_poses.take() {
            node.take_object_pose(&mut shell, &device, message);
        }
        while let Some(Received { message, .. }) = deflections.take() {
            node.take_deflections(&mut shell, &device, message);
        }
        shell.tell(&device);
    }
    Ok(shell)
}

struct Node {
    follower: Follower,
    sensor_boot_id: i64,
    controller: Controller,
    inputs: Inputs,
    /// What people ask for, until its cycle.
    agenda: Agenda,
    /// What was answered to the last state.
    answers: [Option<Encoded>; 2],
}

impl Node {
    fn take_state(&mut self, shell: &mut Shell, device: &Lcm, state: RobotState) {
        if !shell.works() || !state.stamp.is_lockstep() {
            return;
        }
        // A state that waits for the sensor is already counted as the last one: a repeat of it is no answer.
        let waiting = self.inputs.state.is_some();
        let expected = self.follower.expected_stamp();
        match self.follower.classify(state.stamp.step, state.stamp.boot_id) {
            Answer::Compute => {
                self.inputs.state = Some(state);
                self.cycle(shell, device);
            }
            Answer::Repeat if !waiting => {
                for encoded in self.answers.iter().flatten() {
                    shell.repeat(device, encoded);
                }
            }
            Answer::Repeat | Answer::Ignore => {}
            Answer::Broken => {
                shell.report(&Problem::Broken {
                    peer: Role::Robot,
                    expected,
                    found: state.stamp,
                });
            }
        }
    }

    fn take_deflections(&mut self, shell: &mut Shell, device: &Lcm, deflections: Deflections) {
        // A sample of the future would blind the controller to all that come before it.
        let now = deflections.stamp.step * TICK_US;
        if deflections.samples.iter().any(|sample| sample.utime > now) {
            return;
        }
        let known = self.inputs.deflections.map(|known| known.stamp);
        if self.is_news(shell, deflections.stamp, known) {
            self.inputs.deflections = Some(deflections);
            self.cycle(shell, device);
        }
    }

    fn take_object_pose(&mut self, shell: &mut Shell, device: &Lcm, pose: ObjectPose) {
        // One that is not due, or from the future, would hide those that are.
        let Stamp { step, utime, .. } = pose.stamp;
        if !shell.scenario.object_sensor.due(step) || utime > step * TICK_US {
            return;
        }
        let known = self.inputs.object_pose.map(|known| known.stamp);
        if self.is_news(shell, pose.stamp, known) {
            self.inputs.object_pose = Some(pose);
            self.cycle(shell, device);
        }
    }

    /// Requests wait for their cycle, also before the robot's greeting.
    fn take_task(&mut self, task: &Task) {
        if !self.agenda.add(task) {
            tracing::debug!(step = task.stamp.step, "a request waits already, or too many do");
        }
    }

    /// Whether a message of the sensor is newer than the `known` one; one that can't be breaks the lockstep.
    fn is_news(&self, shell: &mut Shell, found: Stamp, known: Option<Stamp>) -> bool {
        if !shell.works() {
            return false;
        }
        // The robot waits for the command of this tick, so that no sensor can be ahead of it; between two states
        // it is less than a period ahead.
        let expected = Stamp {
            boot_id: self.sensor_boot_id,
            ..self.follower.expected_stamp()
        };
        if found.boot_id != expected.boot_id || found.step > expected.step {
            shell.report(&Problem::Broken {
                peer: Role::Sensor,
                expected,
                found,
            });
            return false;
        }
        known.is_none_or(|known| found.step > known.step)
    }

    /// One cycle, once all that it needs is there.
    fn cycle(&mut self, shell: &mut Shell, device: &Lcm) {
        let Some((state, deflections, object_pose)) = self.inputs.complete() else {
            return;
        };
        let (tick, started) = (state.stamp.step, clock::now());
        let task = self.agenda.due(tick);
        if let Some(task) = &task {
            self.controller.request(task);
        }
        let outputs = self
            .controller
            .cycle(&Heard::complete(state, deflections, object_pose));
        self.answers = [
            shell.publish(device, &outputs.command),
            shell.publish(device, &outputs.status),
        ];
        if let Some(task) = &task {
            // All else that the cycle uses is told by its tick.
            shell.heard(tick, task);
        }
        shell.health.reach(tick, clock::now() - started);
        self.inputs.state = None;
        // Between two cycles: what it finds is published from the next one on.
        if let Some(concern) = self.controller.assess().and_then(|found| found.concern()) {
            tracing::warn!("{concern}");
        }
    }
}
