//! `CONTROLLER_STATUS` and `NODE_STATUS`: what people watch.

use super::{
    Check, Invalid, ParameterAnswer, Stamp, TaskParameters, finite, finite_pose, finite_vectors, in_range,
    wire_enum,
};
use crate::{Compliance, Deflection, Pose, Wrench};
use nalgebra::Vector3;

/// Version of the wire contract; nodes with different ones refuse each other.
pub const PROTOCOL: i32 = 1;

wire_enum! {
    /// Phase of the controller (DESIGN.md section 6).
    ControllerPhase {
        /// Waiting for the first data.
        #[default]
        Init = 0,
        /// Data are consistent; taring.
        Sync = 1,
        /// Ready to start.
        Ready = 2,
        /// Moving towards the object.
        Approach = 3,
        /// In contact, not yet settled.
        Contact = 4,
        /// In contact, force within its band.
        Settled = 5,
        /// Moving away.
        Retract = 6,
        /// Holding after a fault.
        Fault = 7,
    }
}

wire_enum! {
    /// Control law.
    Law {
        /// Eq. (1), pd / admittance.
        #[default]
        Pd = 0,
        /// Eqs. (2), (9)-(12) as an object model.
        Proposed = 1,
        /// Eq. (2) at each sample.
        Literal = 2,
        /// Eq. (1), restarted from the actual pose at contact.
        PdReset = 3,
        /// Object model with inverted gear dynamics.
        Elastic = 4,
        /// ROS 2 `admittance_controller`.
        Ros2 = 5,
        /// FZI `cartesian_force_controller`.
        Fzi = 6,
    }
}

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

wire_enum! {
    /// Why a node does not go on. The first cause is latched.
    Fault {
        /// No fault.
        #[default]
        None = 0,
        /// A tick was skipped or a peer restarted in lockstep.
        LockstepBroken = 1,
        /// A peer did not answer in lockstep.
        PeerSilent = 2,
        /// A peer runs with another configuration, seed, T or protocol.
        HelloMismatch = 3,
        /// A command is not finite.
        CommandInvalid = 4,
        /// Commands were missing for longer than `command_gap_s`.
        CommandGap = 5,
        /// The sensor is silent or too old.
        SensorStale = 6,
        /// The robot's state is silent or too old.
        StateStale = 7,
        /// The simulated world died.
        SimLost = 8,
        /// An axis is at the end of its range.
        AxisLimit = 9,
        /// An axis exceeds its velocity limit.
        VelocityLimit = 10,
        /// A pose that kinematics can't reach.
        Unreachable = 11,
        /// The deflection is at the end of its range.
        DeflectionSaturated = 12,
        /// The contact force exceeds its limit.
        ForceLimit = 13,
        /// Contact where none is allowed.
        Collision = 14,
        /// No object within the search depth.
        NoContact = 15,
        /// A clock jumped.
        ClockJump = 16,
        /// A message of a peer can't be used.
        MessageInvalid = 17,
        /// Another node commands the robot.
        SecondOwner = 18,
        /// A log can't be written.
        RecordFailed = 19,
    }
}

/// The statistic of contact detection and its threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Detection {
    /// Normal force from the tcp deflection, N.
    pub statistic_n: f64,
    /// Threshold in force now, N.
    pub threshold_n: f64,
    /// Tick of the sample that detected contact, -1: none.
    pub contact_step: i64,
}

/// The impact that the present speed would cause, eqs. (13)-(18).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpactAssessment {
    /// Speed of the tcp, m/s.
    pub speed_m_per_s: f64,
    /// Effective mass at the tcp, kg.
    pub effective_mass_kg: f64,
    /// Peak force, N.
    pub peak_force_n: f64,
    /// Maximum indentation, m.
    pub maximum_depth_m: f64,
    /// Characteristic impact time, s.
    pub characteristic_time_s: f64,
    /// Highest approach speed allowed, m/s.
    pub speed_limit_m_per_s: f64,
}

/// The controller as people watch it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerStatus {
    /// Tick of the cycle.
    pub stamp: Stamp,
    /// Phase.
    pub phase: ControllerPhase,
    /// First cause of a latched fault.
    pub fault: Fault,
    /// Law in force.
    pub law: Law,
    /// Whether `object_pose` is known.
    pub object_known: bool,
    /// `r_from_o` as measured by the sensor, (12).
    pub object_pose: Pose,
    /// Its velocity, m/s.
    pub object_velocity: Vector3<f64>,
    /// `r_from_ta1`: deflected tcp as the controller sees it.
    pub tcp_pose: Pose,
    /// Contact wrench at the tcp, in t.
    pub wrench: Wrench,
    /// Desired wrench at the tcp, in t.
    pub desired_wrench: Wrench,
    /// Normal force minus desired normal force, N.
    pub force_error_n: f64,
    /// Contact detection.
    pub detection: Detection,
    /// Assumed or adapted compliance of the sensor (diagonals are published).
    pub compliance: Compliance,
    /// Confidence of the adaptation, 0 to 1.
    pub compliance_confidence: f64,
    /// Deflection taken as zero force.
    pub tare: Deflection,
    /// Impact assessment.
    pub impact: ImpactAssessment,
    /// Gain margin of the loop, 1; 0: not computed.
    pub gain_margin: f64,
    /// Phase margin of the loop, rad; 0: not computed.
    pub phase_margin_rad: f64,
    /// Amplitude of an observed oscillation, N.
    pub oscillation_n: f64,
    /// Limits that bind, a bit each: 1 lead, 2 velocity, 4 acceleration, 8 workspace, 16 axis, 32 deflection.
    pub limits: i32,
    /// Index of the program step, -1: no program.
    pub program_step: i32,
    /// `step` of the task message answered last.
    pub task_step: i64,
    /// The answer.
    pub task_answer: ParameterAnswer,
    /// Bit of the parameter refused, -1: none.
    pub task_parameter: i32,
    /// The limit it left.
    pub task_limit: f64,
}

/// What nodes must agree on before they work together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hello {
    /// Identity of the run, 0: any.
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
    /// Wrong fingerprint, length or values.
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

impl Check for ControllerStatus {
    fn check(&self) -> Result<(), Invalid> {
        finite_pose("object_pose", &self.object_pose)?;
        finite_pose("tcp_pose", &self.tcp_pose)?;
        finite_vectors(
            "controller_status",
            &[
                self.object_velocity,
                self.wrench.force,
                self.wrench.moment,
                self.desired_wrench.force,
                self.desired_wrench.moment,
                self.tare.translation,
                self.tare.rotation,
            ],
        )?;
        finite(
            "compliance",
            self.compliance
                .translation
                .iter()
                .chain(self.compliance.rotation.iter()),
        )?;
        let (detection, impact) = (&self.detection, &self.impact);
        finite(
            "controller_status",
            [
                &self.force_error_n,
                &self.compliance_confidence,
                &detection.statistic_n,
                &detection.threshold_n,
                &impact.speed_m_per_s,
                &impact.effective_mass_kg,
                &impact.peak_force_n,
                &impact.maximum_depth_m,
                &impact.characteristic_time_s,
                &impact.speed_limit_m_per_s,
                &self.gain_margin,
                &self.phase_margin_rad,
                &self.oscillation_n,
                &self.task_limit,
            ],
        )?;
        let last_parameter = TaskParameters::COUNT as i64 - 1;
        in_range(
            "controller_task_parameter",
            i64::from(self.task_parameter),
            -1,
            last_parameter,
        )
    }
}

impl Check for NodeStatus {
    fn check(&self) -> Result<(), Invalid> {
        for latencies in [&self.answer, &self.lateness, &self.round_trip] {
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
