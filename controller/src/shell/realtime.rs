//! Real time: a cycle every T, begun by the robot's state and the deflection of its tick, whichever comes later; T/4 after
//! the state, or after the instant at which one should have come, without what is missing.

use super::timeline::Timeline;
use controller::agenda::Agenda;
use controller::margins::Assessment;
use controller::{Controller, Heard};
use crossbeam::channel::{Receiver, RecvError, Sender, bounded};
use crossbeam::select;
use lcmtypes::{Lcm, Received, Subscription};
use node::clock;
use node::problem::Problem;
use node::rights;
use node::shell::{Flags, RealTime, Shell};
use spatial::TICK_US;
use spatial::ports::{Deflections, NodeStatus, ObjectPose, RobotState, Role, Task};
use std::time::{Duration, Instant};

/// Between two looks at the clocks' bounds.
const LOOK: Duration = Duration::from_secs(1);

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
    period_ticks: i64,
    /// For so long cycles go on without a state.
    longest: Duration,
    waiting: Waiting,
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
    /// Tick of the newest deflections.
    sensor_step: Option<i64>,
    /// Tick of the robot's newest state.
    newest_step: Option<i64>,
    /// Tick of the last cycle.
    last: Option<i64>,
    /// Cycles without a state since the last one.
    without: i64,
    /// When the cycle begins with what is there.
    due: Option<Instant>,
}

/// Run the node until a signal ends it.
pub(super) fn run(flags: &Flags, process: RealTime) -> anyhow::Result<Shell> {
    let mut device = flags.device_link()?;
    let (states, deflections) = (device.subscribe(16), device.subscribe(16));
    let (object_poses, tasks) = (device.subscribe(16), device.subscribe(16));
    let peers = device.subscribe(64);
    let scenario = &process.shell.scenario;
    let mut node = Node {
        controller: Controller::new(scenario),
        agenda: Agenda::default(),
        timeline: Timeline::default(),
        period_ticks: scenario.timing.command_period_ticks,
        longest: Duration::from_secs_f64(scenario.controller.stale_fault_s),
        waiting: Waiting::default(),
        assessments: bounded(4),
        next_look: clock::now() + LOOK,
        warned: false,
        device: device.start()?,
        states,
        deflections,
        object_poses,
        tasks,
        peers,
        process,
    };
    while node.step().is_ok_and(|goes_on| goes_on) {}
    Ok(node.process.shell)
}

impl Node {
    /// Take what comes next, and run the cycle if it is due; `false`: a signal asks for the end.
    fn step(&mut self) -> Result<bool, RecvError> {
        self.process.keep_status(&self.device, &[&self.device]);
        let status = self.process.status_due();
        let wake = self.waiting.due.map_or(status, |due| due.min(status));
        let pause = wake.saturating_duration_since(clock::now());
        let outcome = select! {
            recv(self.states.receiver()) -> received => received.map(|it| self.take_state(&it)),
            recv(self.deflections.receiver()) -> received => received.map(|it| self.take_deflections(&it)),
            recv(self.object_poses.receiver()) -> received => received.map(|it| self.take_object(&it)),
            recv(self.tasks.receiver()) -> received => received.map(|it| self.take_task(it.message)),
            recv(self.peers.receiver()) -> received => received.map(|it| self.take_status(&it.message)),
            recv(self.process.shell.stop) -> _ => return Ok(false),
            default(pause) => Ok(()),
        };
        if outcome.is_err() {
            self.process.shell.report(&Problem::LinkEnded);
        }
        outcome?;
        if self.waiting.due.is_some_and(|due| clock::now() >= due) {
            self.cycle();
        }
        Ok(true)
    }

    fn take_state(&mut self, received: &Received<RobotState>) {
        let Received { message, received_at } = received;
        let step = message.stamp.step;
        if !self.works() || !self.process.works_with(Role::Robot, message.stamp.boot_id) {
            return;
        }
        let arrived = self.process.utime(*received_at);
        if let Some(us) = self.timeline.robot.take(&message.echo, arrived) {
            let round_trip = Duration::from_micros(us.unsigned_abs());
            self.process.shell.health.round_trip(round_trip);
        }
        if self.waiting.newest_step.is_some_and(|newest| step <= newest) {
            return;
        }
        let gap = self
            .waiting
            .newest_step
            .map_or(0, |newest| (step - newest) / self.period_ticks - 1);
        self.process.shell.health.link().lost += gap.max(0);
        self.waiting.newest_step = Some(step);
        self.waiting.state = Some(self.timeline.place_state(message));
        self.waiting.without = 0;
        self.waiting.due = Some(match self.waiting.last {
            // Its cycle has been run without it: the next one is due when the robot is there.
            Some(last) if step <= last => {
                *received_at + self.ticks(last + self.period_ticks - step) + self.patience()
            }
            _ if self.waiting.sensor_step.is_some_and(|sensor| sensor >= step) => *received_at,
            _ => *received_at + self.patience(),
        });
    }

    fn take_deflections(&mut self, received: &Received<Deflections>) {
        let Received { message, received_at } = received;
        let step = message.stamp.step;
        if !self.works() || !self.process.works_with(Role::Sensor, message.stamp.boot_id) {
            return;
        }
        let arrived = self.process.utime(*received_at);
        self.timeline.sensor.take(&message.echo, arrived);
        if self.waiting.sensor_step.is_some_and(|newest| step <= newest) {
            return;
        }
        let gap = self.waiting.sensor_step.map_or(0, |newest| step - newest - 1);
        self.process.shell.health.link().lost += gap;
        self.waiting.sensor_step = Some(step);
        // Of two messages since the last cycle the newer one has most of what the older one had, but what it marks as
        // known would be lost: samples are placed when they are used.
        self.waiting.deflections = Some(*message);
        let waits = |state: &RobotState| {
            step >= state.stamp.step && self.waiting.last.is_none_or(|last| state.stamp.step > last)
        };
        if self.waiting.state.as_ref().is_some_and(waits) {
            self.waiting.due = Some(*received_at);
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

    /// Requests are followed by the cycle that comes next, whatever the clock of who asks says.
    fn take_task(&mut self, mut task: Task) {
        task.stamp.utime = 0;
        if !self.agenda.add(&task) {
            tracing::debug!(step = task.stamp.step, "a request waits already, or too many do");
        }
    }

    fn take_status(&mut self, status: &NodeStatus) {
        match self.process.hear(status) {
            // Another robot, or the same one after a restart: nothing that was known holds.
            Some(Role::Robot) => {
                self.controller = Controller::new(&self.process.shell.scenario);
                (self.waiting, self.timeline) = (Waiting::default(), Timeline::default());
            }
            Some(Role::Sensor) => {
                self.timeline.forget_sensor();
                (self.waiting.sensor_step, self.waiting.deflections) = (None, None);
            }
            _ => {}
        }
    }

    /// Whether the node has not been refused.
    fn works(&self) -> bool {
        !self.process.shell.health.faulty()
    }

    /// How long a cycle waits for what it lacks.
    fn patience(&self) -> Duration {
        self.period() / 4
    }

    fn period(&self) -> Duration {
        self.ticks(self.period_ticks)
    }

    fn ticks(&self, ticks: i64) -> Duration {
        Duration::from_micros(ticks.saturating_mul(TICK_US).unsigned_abs())
    }

    /// One cycle with what is there.
    fn cycle(&mut self) {
        let began = self.waiting.due.take().unwrap_or_else(clock::now);
        let state = self.waiting.state.take();
        let next = self.waiting.last.map(|last| last + self.period_ticks);
        let step = state.map(|state| state.stamp.step);
        let Some(tick) = step.max(next.filter(|next| step.is_none_or(|step| step < *next))) else {
            return;
        };
        let ready = self.timeline.ready();
        let utime = self.process.utime(clock::now());
        let deflections = self.waiting.deflections.take();
        let deflections = deflections.and_then(|it| self.timeline.place_samples(&it, utime));
        let object = self.waiting.object.take();
        let object = object.and_then(|it| self.timeline.place_object(&it, utime));
        if let Some(task) = self.agenda.due(tick).filter(|_| ready) {
            self.controller.request(&task);
        }
        let outputs = self.controller.cycle(&Heard {
            tick,
            // Until samples can be paired, the controller knows of nothing: its commands only carry their stamps.
            state: state.as_ref().filter(|_| ready),
            deflections: deflections.as_ref(),
            object: object.as_ref(),
        });
        let (mut command, mut status) = (outputs.command, outputs.status);
        let now = clock::now();
        command.stamp = self.process.stamp(tick, now);
        command.send_utime = command.stamp.utime;
        status.stamp = command.stamp;
        self.process.shell.publish(&self.device, &command);
        self.process.shell.publish(&self.device, &status);
        self.process.shell.health.reach(tick, clock::now() - began);
        self.waiting.last = Some(tick);
        // When the next state should have come, and T/4 more. A cycle without a state began T/4 late already.
        let came = step == Some(tick);
        let from = if came { began + self.patience() } else { began };
        self.waiting.due = Some(from + self.period());
        if state.is_none() {
            self.process.shell.health.link().missed += 1;
            self.waiting.without += 1;
            // Its silence has been told by then. One that comes back, its time having stood still, must not find commands
            // of a future that it takes long to reach.
            if self.ticks(self.waiting.without * self.period_ticks) > self.longest {
                self.waiting.due = None;
            }
        }
        self.look(now, utime);
        self.assess();
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
        let clocks = [
            (Role::Robot, &mut self.timeline.robot),
            (Role::Sensor, &mut self.timeline.sensor),
        ];
        for (role, clock) in clocks {
            if let Some(us) = clock.jump() {
                tracing::warn!(
                    "the clock of {} has jumped by {:.3} s; it is measured anew",
                    node::greeting::role_name(role),
                    1e-6 * us
                );
            }
        }
        let most_us = 0.25 * (self.period_ticks * TICK_US) as f64;
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
