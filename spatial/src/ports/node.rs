//! `NODE_STATUS`: a process as people watch it; in lockstep also the greeting between nodes.

use super::{Check, Fault, Invalid, Stamp, finite, wire_enum};

/// Version of the wire contract; nodes with different ones refuse each other.
pub const PROTOCOL: i32 = 2;

wire_enum! {
    /// State of a process.
    NodeState {
        /// Looking for its peers.
        #[default]
        Starting = 0,
        /// At work.
        Running = 1,
        /// The configured duration is over.
        Finished = 2,
        /// A fault is latched.
        Fault = 3,
    }
}

wire_enum! {
    /// What a process is.
    Role {
        /// `robot-sim` or a robot's driver.
        #[default]
        Robot = 0,
        /// `sensor-sim` or a sensor's driver.
        Sensor = 1,
        /// `controller`.
        Controller = 2,
    }
}

/// What nodes must agree on before they work together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hello {
    /// Identity of the run; nodes of different runs refuse each other.
    pub run_id: i64,
    /// Version of the wire contract.
    pub protocol: i32,
    /// Ticks per command period T.
    pub ticks_per_cycle: i32,
    /// Seed.
    pub seed: i64,
    /// Hash over the configuration.
    pub configuration_hash: i64,
}

/// Percentiles of a duration, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Latencies {
    /// Median.
    pub p50_s: f64,
    /// 99th percentile.
    pub p99_s: f64,
    /// 99.9th percentile.
    pub p999_s: f64,
    /// Maximum.
    pub max_s: f64,
}

/// Messages, counted since start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkQuality {
    /// Published, repeats included.
    pub published: i64,
    /// Received and used.
    pub received: i64,
    /// Repeated because unanswered (lockstep).
    pub repeated: i64,
    /// Gaps in the peers' sequence.
    pub lost: i64,
    /// Dropped by a full queue: the oldest.
    pub dropped: i64,
    /// Dropped by the kernel, the socket's buffer being full; -1: it does not tell.
    pub kernel_dropped: i64,
    /// Wrong fingerprint, length or values; no short message of LCM; on a channel that is none of these.
    pub undecodable: i64,
    /// Failed authentication.
    pub refused: i64,
    /// Deadlines missed.
    pub missed: i64,
}

/// A process as people watch it; in lockstep also the greeting between nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeStatus {
    /// Tick reached.
    pub stamp: Stamp,
    /// What it is.
    pub role: Role,
    /// Host name, zero-padded.
    pub host: [u8; 32],
    /// State.
    pub state: NodeState,
    /// First cause of a latched fault.
    pub fault: Fault,
    /// Tick at which it latched.
    pub fault_step: i64,
    /// Peer that the fault concerns.
    pub fault_peer: Role,
    /// What was expected (a mismatch names both values).
    pub fault_expected: i64,
    /// What was found.
    pub fault_found: i64,
    /// What must agree.
    pub hello: Hello,
    /// Message counts.
    pub link: LinkQuality,
    /// Answer times.
    pub answer: Latencies,
    /// Wake-up lateness against the pace (real time).
    pub lateness: Latencies,
    /// Round trip to the peers.
    pub round_trip: Latencies,
    /// Age at use (real time): robot, of commands, since the state that they answer was sampled; controller, in each cycle,
    /// of the newest deflection since it was sampled.
    pub age: Latencies,
    /// Clock offset to robot and sensor, s (controller, real time).
    pub clock_offset_s: [f64; 2],
    /// Bound of that offset, s.
    pub clock_bound_s: [f64; 2],
    /// Clock rate against robot and sensor, 1.
    pub clock_rate: [f64; 2],
    /// Plant time lost against the wall clock, s (robot, real time).
    pub slip_s: f64,
    /// Whether messages are authenticated.
    pub authenticated: bool,
    /// Whether real-time rights were had.
    pub realtime: bool,
}

impl Check for NodeStatus {
    fn check(&self) -> Result<(), Invalid> {
        self.stamp.check()?;
        for latencies in [&self.answer, &self.lateness, &self.round_trip, &self.age] {
            let Latencies {
                p50_s,
                p99_s,
                p999_s,
                max_s,
            } = latencies;
            finite("node_latency_s", [p50_s, p99_s, p999_s, max_s])?;
        }
        finite(
            "node_clock",
            self.clock_offset_s
                .iter()
                .chain(&self.clock_bound_s)
                .chain(&self.clock_rate),
        )?;
        finite("node_slip_s", [&self.slip_s])
    }
}
