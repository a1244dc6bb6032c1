//! The shell of the check: plays the peers that are missing, and records.

use super::record::{At, Phase, Record, Refused, Saying};
use super::session_robot;
use super::signatures::Signatures;
use super::{Expectation, Finding};
use crossbeam::channel::Receiver;
use crossbeam::select;
use lcmtypes::{Lcm, LcmBuilder, LcmError, Message, Received, Subscription};
use node::authenticity::Keyring;
use node::clock::{self, Clock, HostClock};
use node::peers::{SILENT, STATUS_PERIOD};
use spatial::kinematics::Axes;
use spatial::ports::{Command, Deflections, NodeStatus, RobotState, Role};
use std::time::{Duration, Instant};

/// What to check.
#[derive(Clone, Debug)]
pub struct Options {
    /// LCM URL of the device channels.
    pub url: String,
    /// How long to listen before anything else is done.
    pub listen: Duration,
    /// What is known of a robot.
    pub expectation: Expectation,
    /// The keys of the cell, if it has any.
    pub keys: Option<Keyring>,
}

/// Why there is nothing to judge.
#[derive(Debug, thiserror::Error)]
pub enum ConformError {
    /// No link.
    #[error(transparent)]
    Link(#[from] LcmError),
    /// Somebody commands the robot.
    #[error(
        "a controller (boot id {boot_id:x}) works on {url}; stop it first: this check plays the controller itself"
    )]
    Controller {
        /// Who.
        boot_id: i64,
        /// Where.
        url: String,
    },
    /// The host gives no random number.
    #[error("no boot id can be drawn: {0}")]
    BootId(String),
    /// The link ends by itself.
    #[error("the LCM link no longer receives; try again")]
    Ended,
    /// A signal.
    #[error("interrupted; a robot that was enabled is released")]
    Interrupted,
}

/// A link and what has come over it.
pub(super) struct Session {
    pub(super) record: Record,
    /// What is said in answer to a state.
    pub(super) saying: Saying,
    /// Where an enabled command stays.
    pub(super) reference: Option<Axes>,
    clock: HostClock,
    pub(super) boot_id: i64,
    pub(super) link: Lcm,
    /// With a key.
    pub(super) signatures: Option<Signatures>,
    states: Subscription<RobotState>,
    deflections: Subscription<Deflections>,
    commands: Subscription<Command>,
    statuses: Subscription<NodeStatus>,
    stop: Receiver<()>,
    /// Roles that are played.
    pub(super) played: Vec<Role>,
    /// Whose commands are recorded.
    pub(super) controller: Option<i64>,
    pub(super) next_status: Instant,
    /// When to command without being asked by a state, and the tick of that command.
    pub(super) next_command: Option<(Instant, i64)>,
    pub(super) requests: i64,
    began: Instant,
}

/// Check a robot.
pub fn robot(options: &Options, stop: Receiver<()>) -> Result<Vec<Finding>, ConformError> {
    let mut session = Session::open(options, Role::Robot, stop)?;
    session_robot::run(&mut session, options)?;
    let record = session.finish();
    Ok(super::robot(&record, &options.expectation))
}

/// Check a sensor.
pub fn sensor(options: &Options, stop: Receiver<()>) -> Result<Vec<Finding>, ConformError> {
    let mut session = Session::open(options, Role::Sensor, stop)?;
    session.meet()?;
    if session.controller.is_none() {
        session.play(Role::Controller);
        session.next_command = Some((clock::now(), 0));
    }
    if !session
        .record
        .peers
        .iter()
        .any(|it| it.message.role == Role::Robot)
    {
        session.play(Role::Robot);
    }
    session.say(Saying::Released, options.listen, |_| false)?;
    Ok(super::sensor(&session.finish()))
}

impl Session {
    fn open(options: &Options, role: Role, stop: Receiver<()>) -> Result<Self, ConformError> {
        let mut link = LcmBuilder::open(&options.url)?;
        let (states, deflections) = (link.subscribe(1024), link.subscribe(1024));
        let (commands, statuses) = (link.subscribe(1024), link.subscribe(256));
        let boot_id =
            node::shell::draw_boot_id().map_err(|error| ConformError::BootId(format!("{error:#}")))?;
        let signatures = options.keys.as_ref().map(|keys| Signatures::new(keys, boot_id));
        Ok(Self {
            record: Record::new(role),
            signatures,
            saying: Saying::Silence,
            reference: None,
            clock: HostClock::start(),
            boot_id,
            link: link.start()?,
            states,
            deflections,
            commands,
            statuses,
            stop,
            played: Vec::new(),
            controller: None,
            next_status: clock::now(),
            next_command: None,
            requests: 0,
            began: clock::now(),
        })
    }

    /// Listen for who is there, for as long as a node may be silent without being gone.
    pub(super) fn meet(&mut self) -> Result<(), ConformError> {
        self.listen(clock::now() + SILENT + STATUS_PERIOD, |_| false)
    }

    /// Publish the status of `role` from now on.
    pub(super) fn play(&mut self, role: Role) {
        self.played.push(role);
        if role == Role::Controller {
            self.controller = Some(self.boot_id);
        }
    }

    /// Say `what` until `done` is true of the record and what has been heard since, or for `limit`.
    pub(super) fn say(
        &mut self,
        what: Saying,
        limit: Duration,
        done: impl Fn(&RobotState) -> bool,
    ) -> Result<(), ConformError> {
        let from = clock::now();
        let phase = Phase {
            saying: what,
            from_us: self.us(from),
            until_us: i64::MAX,
        };
        self.saying = what;
        self.record.phases.push(phase);
        let before = self.record.states.len();
        let outcome = self.listen(from + limit, |record| {
            record.states.len() > before && record.states.last().is_some_and(|it| done(&it.message))
        });
        let until_us = self.us(clock::now()) + 1;
        if let Some(phase) = self.record.phases.last_mut() {
            phase.until_us = until_us;
        }
        if let Err(ConformError::Interrupted) = outcome {
            self.saying = Saying::Released;
            if let Some(state) = self.record.states.last().map(|it| it.message) {
                self.answer(&state)?;
            }
        }
        outcome
    }

    fn listen(&mut self, until: Instant, done: impl Fn(&Record) -> bool) -> Result<(), ConformError> {
        let ended = |_| ConformError::Ended;
        while !done(&self.record) {
            let now = clock::now();
            if now >= until {
                break;
            }
            self.keep_up(now)?;
            let wake = self
                .next_command
                .map_or(self.next_status, |(due, _)| due.min(self.next_status));
            let pause = wake.min(until).saturating_duration_since(now);
            select! {
                recv(self.states.receiver()) -> it => self.take_state(&it.map_err(ended)?)?,
                recv(self.deflections.receiver()) -> it => {
                    let it = it.map_err(ended)?;
                    let us = self.us(it.received_at);
                    if let Some(signatures) = &mut self.signatures {
                        signatures.hear_deflections(&it.message, self.record.role);
                    }
                    self.record.deflections.push(At { us, message: it.message });
                }
                recv(self.commands.receiver()) -> it => self.take_command(&it.map_err(ended)?),
                recv(self.statuses.receiver()) -> it => self.take_status(&it.map_err(ended)?),
                recv(self.stop) -> _ => return Err(ConformError::Interrupted),
                default(pause) => {}
            }
        }
        Ok(())
    }

    fn take_state(&mut self, received: &Received<RobotState>) -> Result<(), ConformError> {
        let (us, message) = (self.us(received.received_at), received.message);
        if let Some(signatures) = &mut self.signatures {
            signatures.hear_state(&message, self.record.role);
        }
        self.record.states.push(At { us, message });
        match self.record.role {
            Role::Robot => self.answer(&message),
            _ => Ok(()),
        }
    }

    fn take_command(&mut self, received: &Received<Command>) {
        let boot_id = received.message.stamp.boot_id;
        if !self.played.contains(&Role::Controller) && *self.controller.get_or_insert(boot_id) == boot_id {
            let us = self.us(received.received_at);
            self.record.commands.push(At {
                us,
                message: received.message,
            });
        }
    }

    fn take_status(&mut self, received: &Received<NodeStatus>) {
        let at = At {
            us: self.us(received.received_at),
            message: received.message,
        };
        if at.message.role == self.record.role {
            self.record.statuses.push(at);
        } else if at.message.stamp.boot_id != self.boot_id {
            if at.message.role == Role::Controller && self.played.is_empty() {
                self.controller = Some(at.message.stamp.boot_id);
            }
            self.record.peers.push(at);
        }
    }

    pub(super) fn us(&self, instant: Instant) -> i64 {
        self.clock.utime(instant)
    }

    fn finish(mut self) -> Record {
        fn refused<M: Message>(from: &Subscription<M>) -> Refused {
            let why = from.last_refusal().map_or(String::new(), |why| why.to_string());
            Refused {
                channel: M::CHANNEL,
                count: from.counters().undecodable,
                why,
            }
        }
        let device = match self.record.role {
            Role::Sensor => refused(&self.deflections),
            _ => refused(&self.states),
        };
        self.record.refused = vec![device, refused(&self.statuses)];
        self.record.signed = self.signatures.take().map(|signatures| signatures.heard);
        self.record.listened_us = self.us(clock::now()) - self.us(self.began);
        self.record
    }
}
