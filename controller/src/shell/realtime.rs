//! Real time: a cycle every T, begun by the robot's state and the deflection of its tick, whichever comes later; T/4 after
//! the state, or after the instant at which one should have come, without what is missing.

use super::schedule::{Cycle, Schedule};
use super::timeline::Timeline;
use controller::agenda::Agenda;
use controller::margins::Assessment;
use controller::{Controller, Heard};
use crossbeam::channel::{Receiver, Sender, bounded};
use lcmtypes::{Lcm, Received, Subscription, Woken};
use node::clock;
use node::rights;
use node::scenario::Scenario;
use node::shell::{Flags, RealTime, Shell};
use spatial::TICK_US;
use spatial::ports::{Deflections, Fault, NodeStatus, ObjectPose, RobotState, Role, Task, TaskAction};
use std::time::{Duration, Instant};

/// Between two looks at the clocks' bounds.
const LOOK: Duration = Duration::from_secs(1);
/// How long the robot is told that it is released: a dozen commands, all of which no network loses.
const RELEASE: Duration = Duration::from_millis(50);

struct Node {
    process: RealTime,
    device: Lcm,
    states: Subscription<RobotState>,
    deflections: Subscription<Deflections>,
    object_poses: Subscription<ObjectPose>,
    tasks: Subscription<Task>,
    peers: Subscription<NodeStatus>,
    controller: Controller,
    agenda: Agenda,
    timeline: Timeline,
    schedule: Schedule,
    waiting: Waiting,
    /// The status by which the robot was joined.
    robot: Option<NodeStatus>,
    /// The devices' clocks have been known since the robot was joined.
    begun: bool,
    /// The controller's fault as it was published last.
    fault: Fault,
    /// Where margins are sent once they are found, and taken from.
    assessments: (Sender<Assessment>, Receiver<Assessment>),
    next_look: Instant,
    /// The bound of a clock has been warned of.
    warned: bool,
}

/// What has come for the next cycle.
#[derive(Default)]
struct Waiting {
    state: Option<RobotState>,
    deflections: Option<Deflections>,
    object: Option<ObjectPose>,
}

/// Run the node until a signal ends it.
pub(super) fn run(flags: &Flags, process: RealTime) -> anyhow::Result<Shell> {
    let mut process = process;
    anyhow::ensure!(
        !(process.authenticated() && process.shell.scenario.object_sensor.enabled),
        "object_sensor.enabled is true, but OBJECT_POSE is not signed, and whoever forges it would move the robot; set it to false, \
         or leave --key out"
    );
    let mut device = flags.device_link()?;
    let (states, deflections) = (device.subscribe(16), device.subscribe(16));
    let (object_poses, tasks) = (device.subscribe(16), device.subscribe(16));
    let peers = device.subscribe(64);
    let device = process.shell.start_link(device)?;
    let scenario = &process.shell.scenario;
    let mut node = Node {
        controller: Controller::new(scenario),
        agenda: Agenda::default(),
        timeline: Timeline::default(),
        schedule: schedule(scenario),
        waiting: Waiting::default(),
        robot: None,
        begun: false,
        fault: Fault::None,
        assessments: bounded(4),
        next_look: clock::now() + LOOK,
        warned: false,
        device,
        states,
        deflections,
        object_poses,
        tasks,
        peers,
        process,
    };
    while node.step()? {}
    node.release()?;
    Ok(node.process.shell)
}

impl Node {
    /// Take what comes next, and run the cycle if it is due; `false`: a signal asks for the end.
    fn step(&mut self) -> anyhow::Result<bool> {
        self.process.keep_status(&self.device, &[&self.device]);
        let status = self.process.status_due();
        let wake = self.schedule.due().map_or(status, |due| due.min(status));
        let pause = wake.saturating_duration_since(clock::now());
        if self.process.shell.wait(Some(pause))? == Woken::Stopped {
            return Ok(false);
        }
        // All of it: a controller that has stood still goes on with the newest state, and does not make up for cycles whose
        // time is over.
        while let Some(next) = self.peers.take() {
            self.take_status(&next.message);
        }
        while let Some(next) = self.tasks.take() {
            self.take_task(next.message);
        }
        while let Some(next) = self.object_poses.take() {
            self.take_object(&next);
        }
        while let Some(next) = self.deflections.take() {
            self.take_deflections(&next);
        }
        while let Some(next) = self.states.take() {
            self.take_state(&next);
        }
        // One that has been refused answers nothing more, also where it does not wait for a state.
        if let Some(begun) = self.schedule.begin(clock::now())
            && self.works()
        {
            self.cycle(begun);
        }
        Ok(true)
    }

    /// Give the robot up before the end: it comes to rest, holds and has no fault, so that another controller can take it over.
    fn release(&mut self) -> anyhow::Result<()> {
        let stamp = self.process.stamp(1, clock::now());
        self.take_request(Task {
            stamp,
            action: TaskAction::Release,
            ..Task::default()
        });
        let until = clock::now() + RELEASE;
        while clock::now() < until && self.step()? {}
        Ok(())
    }

    fn take_state(&mut self, received: &Received<RobotState>) {
        let Received { message, received_at } = received;
        let step = message.stamp.step;
        if !self.works() || !self.process.admits(message) {
            return;
        }
        if self.schedule.misled_by_state(step, *received_at)
            && let Some(status) = self.robot
        {
            tracing::warn!(
                "a state in robot-sim's name was of a tick far ahead of tick {step}; it is joined anew"
            );
            self.join_robot(&status);
        }
        let arrived = self.process.utime(*received_at);
        if let Some(us) = self.timeline.robot.take(&message.echo, arrived) {
            let round_trip = Duration::from_micros(us.unsigned_abs());
            self.process.shell.health.round_trip(round_trip);
        }
        if let Some(lost) = self.schedule.take_state(step, *received_at) {
            self.process.shell.health.link().lost += lost;
            self.waiting.state = Some(self.timeline.place_state(message));
        }
    }

    fn take_deflections(&mut self, received: &Received<Deflections>) {
        let Received { message, received_at } = received;
        let step = message.stamp.step;
        if !self.works() || !self.process.admits(message) {
            return;
        }
        if self.schedule.misled_by_deflections(step, *received_at) {
            tracing::warn!("deflections in sensor-sim's name were of a tick far ahead of tick {step}");
            self.schedule.forget_sensor();
        }
        let arrived = self.process.utime(*received_at);
        self.timeline.sensor.take(&message.echo, arrived);
        if let Some(lost) = self.schedule.take_deflections(step, *received_at) {
            self.process.shell.health.link().lost += lost;
            self.waiting.deflections = Some(*message);
        }
    }

    fn take_object(&mut self, received: &Received<ObjectPose>) {
        if self
            .process
            .works_with(Role::Sensor, received.message.stamp.boot_id)
        {
            self.waiting.object = Some(received.message);
        }
    }

    fn take_task(&mut self, task: Task) {
        if self.process.admits(&task) {
            self.take_request(task);
        }
    }

    /// Requests are followed by the cycle that comes next, whatever the clock of who asks says.
    fn take_request(&mut self, mut task: Task) {
        task.stamp.utime = 0;
        if !self.agenda.add(&task) {
            tracing::debug!(step = task.stamp.step, "a request waits already, or too many do");
        }
    }

    fn take_status(&mut self, status: &NodeStatus) {
        match self.process.hear(status) {
            Some(Role::Robot) => self.join_robot(status),
            Some(Role::Sensor) => {
                self.timeline.forget_sensor();
                self.schedule.forget_sensor();
                self.waiting.deflections = None;
            }
            _ => {}
        }
    }

    /// Another robot, or the same one after a restart: nothing that was known holds.
    fn join_robot(&mut self, status: &NodeStatus) {
        self.robot = Some(*status);
        self.controller = Controller::new(&self.process.shell.scenario);
        self.schedule = schedule(&self.process.shell.scenario);
        (self.waiting, self.timeline) = (Waiting::default(), Timeline::default());
        self.begun = false;
        self.process.shell.heard(status.stamp.step, status);
    }

    /// Whether the node has not been refused.
    fn works(&self) -> bool {
        !self.process.shell.health.faulty()
    }

    /// A clock that has jumped is measured anew; until then nothing can be paired.
    fn watch_clocks(&mut self) {
        let clocks = [
            (Role::Robot, &mut self.timeline.robot),
            (Role::Sensor, &mut self.timeline.sensor),
        ];
        for (role, clock) in clocks {
            if let Some(us) = clock.jump() {
                tracing::warn!(
                    "the clock of {} has jumped by {:.3} s against the own one; it is measured anew",
                    node::greeting::role_name(role),
                    1e-6 * us
                );
                self.controller.latch(Fault::ClockJump);
            }
        }
    }

    /// One cycle with what is there.
    fn cycle(&mut self, begun: Cycle) {
        let Cycle {
            tick,
            due,
            with_state,
        } = begun;
        let Waiting {
            state,
            deflections,
            object,
        } = std::mem::take(&mut self.waiting);
        // Until samples can be paired for the first time, the controller knows of nothing: its commands only carry their stamps.
        self.begun |= self.timeline.ready();
        self.watch_clocks();
        let utime = self.process.utime(clock::now());
        let deflections = deflections.and_then(|it| self.timeline.place_samples(&it, utime));
        let object = object.and_then(|it| self.timeline.place_object(&it, utime));
        if let Some(us) = self.timeline.sample_age_us(utime) {
            self.process
                .shell
                .health
                .use_aged(Duration::from_secs_f64(1e-6 * us.max(0.0)));
        }
        let task = if self.begun { self.agenda.due(tick) } else { None };
        if let Some(task) = &task {
            self.controller.request(task);
        }
        let heard = Heard {
            tick,
            state: state.as_ref().filter(|_| self.begun),
            deflections: deflections.as_ref(),
            object: object.as_ref(),
        };
        let outputs = self.controller.cycle(&heard);
        let (mut command, mut status) = (outputs.command, outputs.status);
        let now = clock::now();
        command.stamp = self.process.stamp(tick, now);
        command.send_utime = command.stamp.utime;
        status.stamp = command.stamp;
        self.process.publish(&self.device, &command);
        self.process.shell.publish(&self.device, &status);
        self.keep(&heard, task.as_ref());
        if status.fault != std::mem::replace(&mut self.fault, status.fault) && status.fault != Fault::None {
            self.process.shell.keep_flight();
        }
        self.process.shell.health.reach(tick, clock::now() - due);
        self.process.shell.health.link().missed += i64::from(!with_state);
        self.look(now, utime);
        self.assess();
    }

    /// Keep what a cycle has heard, once its answer has left: in a record it follows that.
    fn keep(&mut self, heard: &Heard<'_>, task: Option<&Task>) {
        let (shell, tick) = (&mut self.process.shell, heard.tick);
        if let Some(task) = task {
            shell.heard(tick, task);
        }
        if let Some(state) = heard.state {
            shell.heard(tick, state);
        }
        if let Some(deflections) = heard.deflections {
            shell.heard(tick, deflections);
        }
        if let Some(object) = heard.object {
            shell.heard(tick, object);
        }
    }

    /// Have the loop's margins assessed, which takes longer than a cycle, by a thread of its own.
    fn assess(&mut self) {
        if let Some(job) = self.controller.to_assess() {
            let found = self.assessments.0.clone();
            std::thread::spawn(move || {
                rights::give_up();
                // The node may have ended meanwhile.
                let _ = found.try_send(job.found());
            });
        }
        if let Ok(found) = self.assessments.1.try_recv()
            && let Some(concern) = self
                .controller
                .publish_assessment(found)
                .and_then(|it| it.concern())
        {
            tracing::warn!("{concern}");
        }
    }

    /// Publish what is known of the clocks, and warn where that is too little to pair samples.
    fn look(&mut self, now: Instant, utime: i64) {
        if now < self.next_look {
            return;
        }
        self.next_look = now + LOOK;
        let period_ticks = self.process.shell.scenario.timing.command_period_ticks;
        let most_us = 0.25 * (period_ticks * TICK_US) as f64;
        let mut worst: f64 = 0.0;
        for (role, estimate) in [Role::Robot, Role::Sensor]
            .into_iter()
            .zip(self.timeline.estimates(utime))
        {
            if let Some(estimate) = estimate {
                self.process.shell.health.clock(role, &estimate);
                worst = worst.max(estimate.bound_us);
            }
        }
        let exceeds = worst > most_us;
        if exceeds && !self.warned {
            tracing::warn!(
                "the devices' clocks are known within {:.2} ms, more than T/4 = {:.2} ms: deflection and pose may be paired \
                 wrongly; find what delays the messages (`touchdown doctor`)",
                1e-3 * worst,
                1e-3 * most_us
            );
        }
        self.warned = exceeds;
    }
}

fn schedule(scenario: &Scenario) -> Schedule {
    let longest = Duration::from_secs_f64(scenario.controller.stale_fault_s);
    Schedule::new(scenario.timing.command_period_ticks, longest)
}
