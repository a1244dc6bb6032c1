//! What is shown at an instant: plain rows with units, which screen, lines and browser share.

mod from;

use serde::Serialize;

/// All that is shown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Snapshot {
    /// The processes; of a role that nobody plays, a row that says so.
    pub nodes: Vec<NodeRow>,
    /// The controller's view of the experiment.
    pub controller: Option<ControllerRow>,
    /// The robot.
    pub robot: Option<RobotRow>,
    /// The compliant sensor.
    pub sensor: Option<SensorRow>,
    /// The non-contact sensor.
    pub object: Option<ObjectRow>,
}

/// A process.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NodeRow {
    /// What it is, such as `robot-sim`, whoever plays that role.
    pub node: &'static str,
    /// Where it runs.
    pub host: String,
    /// Its state in words.
    pub state: String,
    /// Its latched fault in words.
    pub fault: Option<String>,
    /// Time since its last message, s; none: never heard.
    pub age_s: Option<f64>,
    /// Whether that is longer than any node that works is silent.
    pub silent: bool,
    /// Messages a second on its own channel, Hz.
    pub rate_hz: f64,
    /// Share of these that has not come here, 1.
    pub loss_ratio: f64,
    /// Gaps in its peers' messages, as it counts them.
    pub lost: i64,
    /// Messages that its full queues have dropped.
    pub dropped: i64,
    /// Messages that the kernel has dropped before it; none: it does not tell.
    pub kernel_dropped: Option<i64>,
    /// Messages that it could not decode, or refused.
    pub refused: i64,
    /// Deadlines that it has missed.
    pub missed: i64,
    /// Time to answer.
    pub answer_s: Percentiles,
    /// Wake-up lateness.
    pub lateness_s: Percentiles,
    /// Round trip to its peers.
    pub round_trip_s: Percentiles,
    /// Age of what it works with at use.
    pub age_at_use_s: Percentiles,
    /// Clocks that it has measured.
    pub clocks: Vec<ClockRow>,
    /// Plant time lost against the wall clock, s.
    pub slip_s: f64,
    /// Whether it has real-time rights.
    pub realtime_rights: bool,
    /// Whether its messages are signed.
    pub authenticated: bool,
    /// Whether it works in lockstep.
    pub lockstep: bool,
}

/// Percentiles of a duration, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Percentiles {
    /// Median.
    pub p50: f64,
    /// 99th percentile.
    pub p99: f64,
    /// 99.9th percentile.
    pub p999: f64,
    /// Maximum.
    pub max: f64,
}

/// A clock against the one of the node that has measured it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClockRow {
    /// Whose.
    pub whose: &'static str,
    /// How far it is ahead, s.
    pub offset_s: f64,
    /// Bound of that offset's error, s.
    pub bound_s: f64,
}

/// The controller's view of the experiment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ControllerRow {
    /// Time of the experiment: tick times 1 ms, s.
    pub time_s: f64,
    /// Time since this was said, s.
    pub age_s: f64,
    /// Whether that is longer than a controller that works is silent.
    pub silent: bool,
    /// Phase in words.
    pub phase: String,
    /// Law in words.
    pub law: String,
    /// Latched fault in words.
    pub fault: Option<String>,
    /// Step of the program.
    pub program_step: Option<i32>,
    /// Limits that bind, in words.
    pub limits: Vec<&'static str>,
    /// Normal force at the tcp that the control law works with, N.
    pub normal_force_n: f64,
    /// Contact force by the deflection of the sensor, in t, N; it shows what the tool swings, too.
    pub force_n: [f64; 3],
    /// Its moment at the tcp, Nm.
    pub moment_nm: [f64; 3],
    /// Desired force, N.
    pub desired_force_n: [f64; 3],
    /// Desired moment, Nm.
    pub desired_moment_nm: [f64; 3],
    /// Normal force minus desired normal force, N.
    pub force_error_n: f64,
    /// Position of the object in r, m, if it is known.
    pub object_position_m: Option<[f64; 3]>,
    /// Its velocity, m/s.
    pub object_velocity_m_per_s: [f64; 3],
    /// Position of the deflected tcp in r, m.
    pub tcp_position_m: [f64; 3],
    /// The tool's axis (z of t) in r, 1.
    pub tool_axis: [f64; 3],
    /// Deflection taken as zero, in s, m.
    pub tare_translation_m: [f64; 3],
    /// Contact detection.
    pub detection: DetectionRow,
    /// Impact that the present speed would cause, or that of the contact.
    pub impact: ImpactRow,
    /// Gain margin, 1; none: not assessed.
    pub gain_margin: Option<f64>,
    /// Phase margin, rad; none: not assessed.
    pub phase_margin_rad: Option<f64>,
    /// Amplitude of an observed oscillation, N.
    pub oscillation_n: f64,
    /// What it has answered last, in words.
    pub answer: Option<String>,
}

/// Contact detection.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DetectionRow {
    /// Statistic, N.
    pub statistic_n: f64,
    /// Threshold in force, N.
    pub threshold_n: f64,
    /// When contact was detected, s.
    pub contact_time_s: Option<f64>,
}

/// The impact budget.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ImpactRow {
    /// Speed of the tcp towards the object, m/s.
    pub speed_m_per_s: f64,
    /// Highest approach speed for the allowed force, m/s; none: any force is allowed.
    pub speed_limit_m_per_s: Option<f64>,
    /// Effective mass, kg.
    pub effective_mass_kg: f64,
    /// Peak force, N.
    pub peak_force_n: f64,
    /// Maximum indentation, m.
    pub maximum_depth_m: f64,
    /// Characteristic time, s.
    pub characteristic_time_s: f64,
}

/// The robot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotRow {
    /// State in words.
    pub mode: String,
    /// Latched fault in words, with its axis.
    pub fault: Option<String>,
    /// Cycles without a new command since start.
    pub missed_commands: i64,
}

/// The compliant sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SensorRow {
    /// How many of the last eight readings were taken.
    pub valid: usize,
    /// Whether the newest one is at the end of the range.
    pub saturated: bool,
    /// Newest deflection, in s, m.
    pub translation_m: [f64; 3],
    /// Its rotation, rad.
    pub rotation_rad: [f64; 3],
}

/// The non-contact sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ObjectRow {
    /// Whether it sees the object.
    pub visible: bool,
    /// Position of the object in r, m.
    pub position_m: [f64; 3],
    /// Standard deviation of the position, m.
    pub sigma_m: f64,
}
