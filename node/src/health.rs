//! What a process publishes of itself, and what it must agree on with the others.

use crate::clock_sync::Estimate;
use crate::scenario::Scenario;
use hdrhistogram::Histogram;
use spatial::ports::{Fault, Hello, Latencies, LinkQuality, NodeState, NodeStatus, PROTOCOL, Role, Stamp};
use std::time::Duration;

/// The hello of a node that runs `scenario` in the run `run_id`.
pub fn hello(scenario: &Scenario, run_id: i64) -> Hello {
    Hello {
        run_id,
        protocol: PROTOCOL,
        ticks_per_cycle: scenario.timing.command_period_ticks as i32,
        seed: scenario.timing.seed,
        configuration_hash: scenario.hash(),
    }
}

/// State, first fault, counts and answer times of a process.
#[derive(Clone, Debug)]
pub struct Health {
    status: NodeStatus,
    answers: Durations,
    lateness: Durations,
    round_trips: Durations,
    ages: Durations,
}

/// Durations of one kind.
#[derive(Clone, Debug)]
struct Durations(Option<Histogram<u64>>);

/// Longest duration told apart, ns.
const LONGEST_NS: u64 = 10_000_000_000;

impl Durations {
    fn new() -> Self {
        Self(Histogram::new_with_bounds(1, LONGEST_NS, 2).ok())
    }

    fn add(&mut self, duration: Duration) {
        if let Some(histogram) = &mut self.0 {
            histogram.saturating_record(u64::try_from(duration.as_nanos()).unwrap_or(LONGEST_NS));
        }
    }

    fn percentiles(&self) -> Latencies {
        self.0
            .as_ref()
            .filter(|histogram| !histogram.is_empty())
            .map_or(Latencies::default(), percentiles)
    }
}

impl Health {
    /// A process that starts.
    pub fn new(role: Role, hello: Hello) -> Self {
        let status = NodeStatus {
            stamp: Stamp {
                step: -1,
                ..Stamp::lockstep(0, hello.seed, role)
            },
            role,
            host: host(),
            state: NodeState::Starting,
            fault: Fault::None,
            fault_step: -1,
            fault_peer: role,
            fault_expected: 0,
            fault_found: 0,
            hello,
            link: LinkQuality::default(),
            answer: Latencies::default(),
            lateness: Latencies::default(),
            round_trip: Latencies::default(),
            age: Latencies::default(),
            clock_offset_s: [0.0; 2],
            clock_bound_s: [0.0; 2],
            clock_rate: [0.0; 2],
            slip_s: 0.0,
            authenticated: false,
            realtime: false,
        };
        Self {
            status,
            answers: Durations::new(),
            lateness: Durations::new(),
            round_trips: Durations::new(),
            ages: Durations::new(),
        }
    }

    /// In real time: the process `boot_id`, with or without all real-time rights, with or without a key.
    pub(crate) fn be(&mut self, boot_id: i64, realtime: bool, authenticated: bool) {
        self.status.stamp.boot_id = boot_id;
        self.status.authenticated = authenticated;
        self.status.realtime = realtime;
    }

    /// In real time: the instant of the coming status on the own clock, us.
    pub(crate) fn set_utime(&mut self, utime: i64) {
        self.status.stamp.utime = utime;
    }

    /// In real time: forget that a peer did not match, since one does now.
    pub(crate) fn forgive_mismatch(&mut self) {
        if self.status.fault == Fault::HelloMismatch {
            self.forgive();
        }
    }

    /// Clear the latched fault.
    pub fn forgive(&mut self) {
        self.status.fault = Fault::None;
        self.status.fault_step = -1;
        self.status.fault_peer = self.status.role;
        (self.status.fault_expected, self.status.fault_found) = (0, 0);
        self.status.state = match self.status.stamp.step {
            ..0 => NodeState::Starting,
            _ => NodeState::Running,
        };
    }

    /// A deadline was met `late`; a new time of plant lost, s.
    pub fn wake(&mut self, late: Duration, slip_s: f64) {
        self.lateness.add(late);
        self.status.slip_s = slip_s;
    }

    /// A message has gone to a peer and back within `round_trip`.
    pub fn round_trip(&mut self, round_trip: Duration) {
        self.round_trips.add(round_trip);
    }

    /// What is used now is `age` old.
    pub fn use_aged(&mut self, age: Duration) {
        self.ages.add(age);
    }

    /// How the clock of `peer`, robot or sensor, differs from the own one.
    pub fn clock(&mut self, peer: Role, estimate: &Estimate) {
        let (status, i) = (&mut self.status, peer as usize);
        if i < status.clock_offset_s.len() {
            status.clock_offset_s[i] = 1e-6 * estimate.ahead_us;
            status.clock_bound_s[i] = 1e-6 * estimate.bound_us;
            status.clock_rate[i] = estimate.rate;
        }
    }

    /// What must agree with every peer.
    pub fn hello(&self) -> &Hello {
        &self.status.hello
    }

    /// Tick reached, -1 before the first.
    pub fn step(&self) -> i64 {
        self.status.stamp.step
    }

    /// Message counts, to be updated by who sends and receives.
    pub fn link(&mut self) -> &mut LinkQuality {
        &mut self.status.link
    }

    /// Reach `tick`, which took `answer` to answer.
    pub fn reach(&mut self, tick: i64, answer: Duration) {
        self.status.stamp.step = tick;
        self.status.stamp.utime = tick * spatial::TICK_US;
        if self.status.state == NodeState::Starting {
            self.status.state = NodeState::Running;
        }
        self.answers.add(answer);
    }

    /// The configured duration is over.
    pub fn finish(&mut self) {
        if self.status.state != NodeState::Fault {
            self.status.state = NodeState::Finished;
        }
    }

    /// Latch `fault`, which concerns `peer`; only the first cause is kept. Says whether it was the first.
    pub fn latch(&mut self, fault: Fault, peer: Role, expected: i64, found: i64) -> bool {
        if self.status.state == NodeState::Fault {
            return false;
        }
        self.status.state = NodeState::Fault;
        self.status.fault = fault;
        self.status.fault_step = self.status.stamp.step;
        self.status.fault_peer = peer;
        self.status.fault_expected = expected;
        self.status.fault_found = found;
        true
    }

    /// Tell of `fault`, which does not keep the node from working. One that is latched, or told, stays; one that is latched
    /// later takes its place.
    pub fn tell(&mut self, fault: Fault) -> bool {
        let first = self.status.fault == Fault::None;
        if first {
            self.status.fault = fault;
            self.status.fault_step = self.status.stamp.step;
        }
        first
    }

    /// Whether a fault is latched.
    pub fn faulty(&self) -> bool {
        self.status.state == NodeState::Fault
    }

    /// The message, now.
    pub fn status(&self) -> NodeStatus {
        NodeStatus {
            answer: self.answers.percentiles(),
            lateness: self.lateness.percentiles(),
            round_trip: self.round_trips.percentiles(),
            age: self.ages.percentiles(),
            ..self.status
        }
    }
}

fn percentiles(histogram: &Histogram<u64>) -> Latencies {
    let at = |percentile: f64| histogram.value_at_percentile(percentile) as f64 * 1e-9;
    Latencies {
        p50_s: at(50.0),
        p99_s: at(99.0),
        p999_s: at(99.9),
        max_s: histogram.max() as f64 * 1e-9,
    }
}

/// The host's name, zero-padded; cut where it is longer.
pub fn host() -> [u8; 32] {
    let mut padded = [0; 32];
    let name = rustix::system::uname();
    for (slot, byte) in padded.iter_mut().zip(name.nodename().to_bytes()) {
        *slot = *byte;
    }
    padded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_fault_is_kept() {
        let mut health = Health::new(Role::Controller, Hello::default());
        assert!(health.latch(Fault::LockstepBroken, Role::Robot, 4, 12));
        assert!(!health.latch(Fault::PeerSilent, Role::Sensor, 0, 0));
        health.finish();
        let status = health.status();
        assert_eq!(
            (status.state, status.fault, status.fault_peer),
            (NodeState::Fault, Fault::LockstepBroken, Role::Robot)
        );
        assert_eq!((status.fault_expected, status.fault_found), (4, 12));
    }

    #[test]
    fn what_is_told_does_not_stop_a_node_and_gives_way_to_what_does() {
        let mut health = Health::new(Role::Controller, Hello::default());
        assert!(health.tell(Fault::RecordFailed) && !health.tell(Fault::RecordFailed));
        assert!(!health.faulty());
        assert_eq!(health.status().fault, Fault::RecordFailed);
        assert!(health.latch(Fault::HelloMismatch, Role::Robot, 1, 2));
        assert!(health.faulty() && !health.tell(Fault::RecordFailed));
        assert_eq!(health.status().fault, Fault::HelloMismatch);
    }

    #[test]
    fn answer_times_are_published_as_percentiles() {
        let mut health = Health::new(Role::Robot, Hello::default());
        for tick in 1..=1000u64 {
            health.reach(tick as i64, Duration::from_micros(tick));
        }
        let answer = health.status().answer;
        assert!((answer.p50_s / 500e-6 - 1.0).abs() < 0.02 && (answer.p99_s / 990e-6 - 1.0).abs() < 0.02);
        assert!((answer.max_s / 1e-3 - 1.0).abs() < 0.02);
        assert_eq!(health.status().state, NodeState::Running);
    }
}
