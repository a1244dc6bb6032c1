//! What every process does in real time, beside what it does in lockstep: its own clock, its peers, its rights.

use super::Shell;
use crate::authenticity::{Author, Gate, Refusal, Signed};
use crate::clock::{self, Clock, HostClock, SkewedClock};
use crate::flight::{self, FlightRecorder};
use crate::greeting::role_name;
use crate::key_file;
use crate::lockstep::PEER_SILENT;
use crate::peers::{News, Peers, STATUS_PERIOD};
use crate::problem::Problem;
use crate::rights::Wanted;
use lcmtypes::{Encoded, Lcm};
use rustix::rand::{GetRandomFlags, getrandom};
use signal_hook::consts::SIGUSR1;
use spatial::ports::{ClockEcho, Command, NodeStatus, RobotMode, RobotState, Role, Stamp};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// The flags of a node that matter in real time alone.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct RealTimeFlags {
    #[command(flatten)]
    wanted: Wanted,
    /// Real time: sign what this node sends, and take nothing from others that is not signed with the same key
    /// (`touchdown keygen`); of several the first signs, and all are taken
    #[arg(long, value_name = "FILE")]
    key: Vec<PathBuf>,
    /// Real time: where the last seconds are kept when a fault latches, ten files of a role at most [default: beside the
    /// record, else $STATE_DIRECTORY, $XDG_STATE_HOME/touchdown or ~/.local/state/touchdown]
    #[arg(long, value_name = "DIR")]
    flight_dir: Option<PathBuf>,
    /// Real time: keep no last seconds
    #[arg(long, conflicts_with = "flight_dir")]
    no_flight: bool,
    /// Real time, for tests: how far this node's clock is ahead, s
    #[arg(
        long,
        default_value_t = 0.0,
        value_name = "S",
        allow_negative_numbers = true,
        hide = true
    )]
    clock_offset_s: f64,
    /// Real time, for tests: how much faster this node's clock goes, 1e-6
    #[arg(
        long,
        default_value_t = 0.0,
        value_name = "PPM",
        allow_negative_numbers = true,
        hide = true
    )]
    clock_drift_ppm: f64,
    /// Real time, for tests: how far this node's clock steps at each SIGUSR1, s
    #[arg(
        long,
        default_value_t = 0.0,
        value_name = "S",
        allow_negative_numbers = true,
        hide = true
    )]
    clock_step_s: f64,
}

impl RealTimeFlags {
    /// Whether messages are to be authenticated.
    pub(super) fn has_key(&self) -> bool {
        !self.key.is_empty()
    }
}

/// A process in real time.
pub struct RealTime {
    /// What it has in lockstep, too.
    pub shell: Shell,
    clock: SkewedClock<HostClock>,
    /// Set when the clock is to step, and how far, s.
    step: (Arc<AtomicBool>, f64),
    peers: Peers,
    boot_id: i64,
    next_status: Instant,
    echo: ClockEcho,
    /// With a key.
    gate: Option<Gate>,
    /// By author: that nothing of his is taken has been said.
    refusal_told: [bool; 4],
    /// The robot's mode as it was published last.
    mode: RobotMode,
    /// When it is told that peers have not been heard of; `None`: it has been, or all have.
    missing_told: Option<Instant>,
}

impl RealTime {
    /// `shell` in real time: an identity of its own, and the rights of the calling thread.
    ///
    /// Its flight recorder writes into `beside` unless the flags say otherwise.
    pub fn start(shell: Shell, flags: &RealTimeFlags, beside: Option<&Path>) -> anyhow::Result<Self> {
        let mut shell = shell;
        if !flags.no_flight {
            let told = flags.flight_dir.as_deref().or(beside).map(Path::to_owned);
            let directory = told.unwrap_or_else(flight::default_directory);
            shell.flight = Some(FlightRecorder::start(role_name(shell.role), directory));
        }
        let gate = gate(shell.role, &flags.key)?;
        let boot_id = draw_boot_id()?;
        let started = clock::now();
        shell.health.be(boot_id, flags.wanted.ask(), gate.is_some());
        let peers = Peers::new(
            shell.role,
            boot_id,
            *shell.health.hello(),
            gate.is_some(),
            started,
        );
        let clock = SkewedClock {
            clock: HostClock::start(),
            since: started,
            offset_s: flags.clock_offset_s,
            drift_ppm: flags.clock_drift_ppm,
        };
        let step = Arc::new(AtomicBool::new(false));
        if flags.clock_step_s != 0.0 {
            signal_hook::flag::register(SIGUSR1, step.clone())?;
        }
        Ok(Self {
            shell,
            clock,
            step: (step, flags.clock_step_s),
            peers,
            boot_id,
            next_status: started,
            echo: ClockEcho::default(),
            gate,
            refusal_told: [false; 4],
            mode: RobotMode::Idle,
            missing_told: Some(started + PEER_SILENT),
        })
    }

    /// Whether messages are authenticated.
    pub fn authenticated(&self) -> bool {
        self.gate.is_some()
    }

    /// Whom the node works with.
    pub fn peers(&self) -> &Peers {
        &self.peers
    }

    /// `instant` on the node's own clock, us.
    pub fn utime(&self, instant: Instant) -> i64 {
        self.clock.utime(instant)
    }

    /// The head of a message of tick `step` that tells of `instant`.
    pub fn stamp(&self, step: i64, instant: Instant) -> Stamp {
        Stamp {
            step,
            utime: self.utime(instant),
            boot_id: self.boot_id,
        }
    }

    /// When the next status is due.
    pub fn status_due(&self) -> Instant {
        self.next_status
    }

    /// Publish the status if it is due.
    pub fn keep_status(&mut self, device: &Lcm, links: &[&Lcm]) {
        if self.step.0.swap(false, Ordering::Relaxed) {
            self.clock.offset_s += self.step.1;
        }
        let now = clock::now();
        if now < self.next_status && !self.shell.untold {
            return;
        }
        self.shell.untold = false;
        self.next_status = now + STATUS_PERIOD;
        self.tell_missing(now);
        self.shell.count(links);
        let utime = self.utime(now);
        self.shell.health.set_utime(utime);
        self.shell.publish_status(device);
    }

    /// Say once, some time after the start, who has not been heard of. That is no fault: nodes start in any order.
    fn tell_missing(&mut self, now: Instant) {
        if self.missing_told.take_if(|due| now >= *due).is_none() {
            return;
        }
        let all = [Role::Robot, Role::Sensor, Role::Controller].into_iter();
        let peers: Vec<_> = all
            .filter(|role| *role != self.shell.role && self.peers.boot_id(*role).is_none())
            .collect();
        if !peers.is_empty() {
            let (tick, seconds) = (-1, PEER_SILENT.as_secs());
            tracing::warn!("{}", Problem::Silent { peers, tick, seconds });
        }
    }

    /// A status has been heard; the role of a peer that is worked with from now on.
    pub fn hear(&mut self, status: &NodeStatus) -> Option<Role> {
        match self.peers.hear(status, clock::now()) {
            News::Known => None,
            News::Joined(role) => {
                self.shell.health.forgive_mismatch();
                self.refusal_told[role as usize] = false;
                tracing::info!("works with {} from now on", role_name(role));
                Some(role)
            }
            News::Refused(mismatch) => {
                self.shell.report(&Problem::Refused(mismatch));
                None
            }
            News::Taken(boot_id) => {
                let own = self.boot_id;
                self.shell.report(&Problem::Taken { own, other: boot_id });
                None
            }
        }
    }

    /// Whether the process `boot_id` is worked with as `role`.
    pub fn works_with(&self, role: Role, boot_id: i64) -> bool {
        self.peers.is(role, boot_id)
    }

    /// Publish a message of this node, signed if it has a key; its bytes, to be repeated on request.
    pub fn publish<M: Signed>(&mut self, link: &Lcm, message: &M) -> Option<Encoded> {
        let Some(gate) = &mut self.gate else {
            return self.shell.publish(link, message);
        };
        let mut message = *message;
        gate.sign(&mut message);
        self.shell.publish(link, &message)
    }

    /// Publish the robot's state. A robot that is armed begins another session.
    pub fn publish_state(&mut self, link: &Lcm, state: &RobotState) {
        let before = std::mem::replace(&mut self.mode, state.mode);
        if let Some(gate) = &mut self.gate
            && before == RobotMode::Idle
            && state.mode != RobotMode::Idle
        {
            gate.renew();
        }
        self.publish(link, state);
    }

    /// Whether to take a message: of the process that is worked with as its author, or of whoever asks, and with a key only
    /// what is signed and new. One that is not taken counts, and is as good as none.
    pub fn admits<M: Signed>(&mut self, message: &M) -> bool {
        let boot_id = message.stamp().boot_id;
        if let Some(role) = M::AUTHOR.role()
            && self.peers.boot_id(role) != Some(boot_id)
        {
            // Before anybody is known, who speaks is no stranger.
            self.shell.health.link().refused += i64::from(self.peers.boot_id(role).is_some());
            return false;
        }
        let Some(Err(refusal)) = self.gate.as_mut().map(|gate| gate.admit(message)) else {
            return true;
        };
        self.shell.health.link().refused += 1;
        // Repeated and overtaken messages come by themselves.
        if matches!(refusal, Refusal::Key { .. } | Refusal::Tag)
            && !std::mem::replace(&mut self.refusal_told[M::AUTHOR as usize], true)
        {
            tracing::warn!(
                "a message of {} on {} is not taken, as any like it: {refusal}",
                M::AUTHOR.role().map_or("whoever asks", role_name),
                M::CHANNEL
            );
        }
        false
    }

    /// Remember the stamps of a command that was taken, and arrived at `received_at`.
    pub fn take_echo(&mut self, command: &Command, received_at: Instant) {
        self.echo.command_send_utime = command.send_utime;
        self.echo.receive_utime = self.utime(received_at);
    }

    /// What a message that is sent now tells the controller of its own clock.
    pub fn echo(&self) -> ClockEcho {
        if self.echo.command_send_utime == 0 {
            return ClockEcho::default();
        }
        ClockEcho {
            send_utime: self.utime(clock::now()),
            ..self.echo
        }
    }
}

/// What the node in `role` takes and sends under the keys in `files`; `None`, said loudly: there is none.
fn gate(role: Role, files: &[PathBuf]) -> anyhow::Result<Option<Gate>> {
    let Some(keyring) = key_file::read_all(files)? else {
        tracing::warn!(
            "messages are NOT authenticated: whoever reaches this LCM URL can command the robot; `touchdown keygen FILE`, and \
             --key FILE for all nodes"
        );
        return Ok(None);
    };
    let ids: Vec<_> = keyring.ids().map(|id| format!("{id:08x}")).collect();
    tracing::info!("signs with key {}, takes {}", ids[0], ids.join(", "));
    Ok(Some(match role {
        Role::Robot => Gate::of_robot(keyring, &key_file::draw_secret()?),
        Role::Sensor => Gate::new(keyring, Author::Sensor),
        Role::Controller => Gate::new(keyring, Author::Controller),
    }))
}

/// A boot id: positive and at random.
pub fn draw_boot_id() -> anyhow::Result<i64> {
    let mut bytes = [0; 8];
    getrandom(&mut bytes, GetRandomFlags::empty())?;
    Ok((i64::from_le_bytes(bytes) & i64::MAX).max(1))
}
