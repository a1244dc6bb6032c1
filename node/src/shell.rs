//! The shell of a process: flags, configuration, logging, signals, links and records.

mod process;
mod realtime;

pub use process::{follow, log_to_stderr, run, signals, told};
pub use realtime::{RealTime, RealTimeFlags, draw_boot_id};

use crate::flight::FlightRecorder;
use crate::greeting::{self, role_name};
use crate::health::{self, Health};
use crate::problem::Problem;
use crate::record::{Direction, Recorder, WhenFull};
use crate::scenario::{Scenario, TimingMode};
use anyhow::Context;
use lcmtypes::{Counters, Encoded, Inboxes, Lcm, LcmBuilder, Message, Woken};
use spatial::ports::{Fault, NodeStatus, Role};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The flags of every node.
#[derive(Clone, Debug, clap::Args)]
pub struct Flags {
    /// Scenario file, the same for all nodes
    #[arg(long, value_name = "FILE")]
    pub scenario: PathBuf,
    /// Change a value of the scenario, in all nodes alike, such as --set controller.law=pd
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// LCM URL of the device channels
    #[arg(long, default_value = "udpm://239.255.76.67:7667?ttl=0")]
    pub url: String,
    /// LCM URL of the simulated world (SIM_*), which nothing should impair
    #[arg(long, default_value = "udpm://239.255.76.67:7668?ttl=0")]
    pub sim_url: String,
    /// Identity of the run; nodes of different runs refuse each other
    #[arg(long, default_value_t = 0)]
    pub run_id: i64,
    /// Write what this node publishes, and what the controller hears, to an LCM event log
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// End when the process with this id, which started this one, ends
    #[arg(long, value_name = "PID")]
    pub with_parent: Option<i32>,
    /// What matters in real time alone.
    #[command(flatten)]
    pub realtime: RealTimeFlags,
}

/// What a node has at hand once its flags are read and its links are open.
pub struct Shell {
    /// The configuration.
    pub scenario: Scenario,
    /// What it publishes of itself.
    pub health: Health,
    inboxes: Inboxes,
    recorder: Option<Recorder>,
    /// A record that can't be written any more.
    lost: Option<Recorder>,
    /// In real time.
    flight: Option<FlightRecorder>,
    role: Role,
    greeted: bool,
    /// A fault that peers have not been told of yet.
    untold: bool,
}

/// What drives a node's time.
#[expect(clippy::large_enum_variant, reason = "a process has one of it")]
pub enum Pace {
    /// The ticks of the clock master, as fast as they come.
    Lockstep(Shell),
    /// The host's clock.
    RealTime(RealTime),
}

impl Flags {
    /// Start the process in `role`: logging to stderr, configuration, signals, record.
    pub fn start(&self, role: Role) -> anyhow::Result<Shell> {
        log_to_stderr();
        if let Some(parent) = self.with_parent {
            follow(parent)?;
        }
        let inboxes = Inboxes::new(process::stop_stream()?);
        let scenario = Scenario::load(&self.scenario, &self.set)?;
        let loss = scenario.network.loss_ratio;
        anyhow::ensure!(
            loss == 0.0,
            "network.loss_ratio is {loss}, but in lockstep the robot repeats what is lost, and in real time the network \
             loses what it does; set it to 0, or stay in one process (`touchdown compare`)"
        );
        let when_full = match scenario.timing.mode {
            TimingMode::Lockstep => WhenFull::Wait,
            TimingMode::Realtime => WhenFull::Drop,
        };
        let record = self.record.as_deref();
        let recorder = record.map(|path| Recorder::create(path, when_full)).transpose()?;
        let health = Health::new(role, health::hello(&scenario, self.run_id));
        tracing::info!(url = %self.url, "{} starts", role_name(role));
        Ok(Shell {
            scenario,
            health,
            inboxes,
            recorder,
            lost: None,
            flight: None,
            role,
            greeted: false,
            untold: false,
        })
    }

    /// `shell` in real time, if the scenario asks for that.
    pub fn realtime(&self, shell: Shell) -> anyhow::Result<Pace> {
        Ok(match shell.scenario.timing.mode {
            TimingMode::Lockstep => {
                anyhow::ensure!(
                    !self.realtime.has_key(),
                    "timing.mode is lockstep, in which messages are not signed: two runs send the same bits; leave --key out, or \
                     add --set timing.mode=realtime to all nodes"
                );
                Pace::Lockstep(shell)
            }
            TimingMode::Realtime => {
                let beside = self.record.as_deref().and_then(Path::parent);
                Pace::RealTime(RealTime::start(shell, &self.realtime, beside)?)
            }
        })
    }

    /// Open the link of the device channels.
    pub fn device_link(&self) -> anyhow::Result<LcmBuilder> {
        Ok(LcmBuilder::open(&self.url)?)
    }

    /// Open the link of the simulated world.
    pub fn simulation_link(&self) -> anyhow::Result<LcmBuilder> {
        Ok(LcmBuilder::open(&self.sim_url)?)
    }
}

impl Shell {
    /// Start a link whose messages [`Self::wait`] receives.
    pub fn start_link(&mut self, builder: LcmBuilder) -> anyhow::Result<Lcm> {
        Ok(self.inboxes.start(builder)?)
    }

    /// Wait for messages, for at most `limit` (`None`: for ever), in the calling thread: what has come is in the
    /// subscriptions afterwards.
    pub fn wait(&mut self, limit: Option<Duration>) -> anyhow::Result<Woken> {
        self.inboxes.wait(limit).context("can't wait for messages")
    }

    /// Check, encode, record and publish a new message; returns its bytes, to be repeated on request.
    ///
    /// A message that can't be encoded or recorded is a [`Problem`] of this node.
    pub fn publish<M: Message>(&mut self, link: &Lcm, message: &M) -> Option<Encoded> {
        let encoded = match message.encode() {
            Ok(encoded) => encoded,
            Err(invalid) => {
                self.report(&Problem::OwnMessage {
                    channel: M::CHANNEL,
                    invalid,
                });
                return None;
            }
        };
        self.keep(message.stamp().step, Direction::Said, &encoded);
        self.send(link, &encoded);
        Some(encoded)
    }

    /// Keep `message` as one that the cycle at `tick` uses, so that the cycle can be repeated.
    pub fn heard<M: Message>(&mut self, tick: i64, message: &M) {
        // It has been checked when it came.
        if (self.recorder.is_some() || self.flight.is_some())
            && let Ok(encoded) = message.encode()
        {
            self.keep(tick, Direction::Heard, &encoded);
        }
    }

    /// Keep a message of `tick` in the record, as one of that time.
    fn keep(&mut self, tick: i64, direction: Direction, encoded: &Encoded) {
        let utime = tick.max(0) * spatial::TICK_US;
        if let Some(flight) = &mut self.flight {
            flight.keep(utime, direction, encoded);
        }
        let recorded = self
            .recorder
            .as_ref()
            .map_or(Ok(()), |recorder| recorder.record(utime, direction, encoded));
        if let Err(problem) = recorded {
            self.lose_record(&problem);
        }
    }

    /// The record can't be written any more. In lockstep that is the end: the run can be made again. In real time something is
    /// controlled, which goes on.
    fn lose_record(&mut self, problem: &Problem) {
        match self.scenario.timing.mode {
            TimingMode::Lockstep => self.report(problem),
            TimingMode::Realtime => {
                tracing::error!("{problem}; control goes on without it");
                self.health.tell(Fault::RecordFailed);
                self.untold = true;
                self.lost = self.recorder.take();
            }
        }
    }

    /// Publish bytes again.
    pub fn repeat(&mut self, link: &Lcm, encoded: &Encoded) {
        self.health.link().repeated += 1;
        self.send(link, encoded);
    }

    /// Publish this node's status. It tells of wall-clock time: no two records of it are the same.
    pub fn publish_status(&mut self, link: &Lcm) {
        let status = self.health.status();
        if let Ok(encoded) = status.encode() {
            self.keep(status.stamp.step, Direction::Said, &encoded);
            self.send(link, &encoded);
        }
    }

    /// Latch a problem and say it, if it is the first.
    pub fn report(&mut self, problem: &Problem) {
        let (fault, peer, expected, found) = problem.fault(self.role);
        if self.health.latch(fault, peer, expected, found) {
            tracing::error!("{problem}");
            self.untold = true;
            self.keep_flight();
        }
    }

    /// Something has gone wrong: have the flight recorder write the last seconds, where there is one.
    pub fn keep_flight(&mut self) {
        if let Some(flight) = &mut self.flight {
            flight.write_soon();
        }
    }

    /// Publish the status if there is a fault that peers have not been told of; called after every event.
    pub fn tell(&mut self, link: &Lcm) {
        if std::mem::take(&mut self.untold) {
            self.publish_status(link);
        }
    }

    /// Answer the robot's status with the own one; refuse a robot that differs in what must agree.
    ///
    /// Only the clock master greets on its own: a node that reacts to nothing else can't multiply messages.
    pub fn greet(&mut self, link: &Lcm, status: &NodeStatus) {
        if status.role != Role::Robot {
            return;
        }
        match greeting::compare(self.health.hello(), status) {
            Ok(()) => self.greeted = true,
            Err(mismatch) => self.report(&Problem::Refused(mismatch)),
        }
        self.untold = false;
        self.publish_status(link);
    }

    /// Whether the node works: a matching robot has greeted it, and no fault is latched.
    pub fn works(&self) -> bool {
        self.greeted && !self.health.faulty()
    }

    /// Take over what the links have counted.
    pub fn count(&mut self, links: &[&Lcm]) {
        let sum = links
            .iter()
            .map(|link| link.counters())
            .fold(Counters::default(), |a, b| a + b);
        let link = self.health.link();
        link.received = sum.received as i64;
        link.dropped = sum.dropped as i64;
        link.kernel_dropped = sum.kernel_dropped.map_or(-1, |dropped| dropped as i64);
        link.undecodable = (sum.undecodable + sum.malformed + sum.foreign) as i64;
    }

    /// End: the record is written to the end.
    pub fn finish(mut self) -> anyhow::Result<()> {
        // It writes what has not been written yet.
        drop(self.flight.take());
        if let Some(recorder) = self.recorder.take().or(self.lost.take()) {
            recorder.close()?;
        }
        Ok(())
    }

    fn send(&mut self, link: &Lcm, encoded: &Encoded) {
        match link.publish_encoded(encoded) {
            Ok(()) => self.health.link().published += 1,
            // A full socket buffer is a lost datagram: lockstep repeats it.
            Err(error) => tracing::debug!("{error}"),
        }
    }
}
