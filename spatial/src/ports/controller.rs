//! `CONTROLLER_STATUS`: the controller as people watch it.

use super::{
    Check, Fault, Invalid, ParameterAnswer, Stamp, TaskParameters, finite, finite_pose, finite_vectors,
    in_range, wire_enum,
};
use crate::{Compliance, Deflection, Pose, Wrench};
use nalgebra::Vector3;

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
        /// Tilting the tool to learn what sensor and tool are.
        Calibrate = 8,
        /// Moving freely, as a step of a program.
        Move = 9,
        /// Pressing and moving along a spiral.
        Search = 10,
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
        /// Object model, approached as a mass with damper and spring.
        Impedance = 7,
    }
}

/// Bit of [`ControllerStatus::limits`]: command minus actual pose is at its bound.
pub const LIMIT_LEAD: i32 = 1;
/// Bit: the velocity of a set-point, or the approach is slowed for the allowed force of the impact.
pub const LIMIT_VELOCITY: i32 = 2;
/// Bit: acceleration or jerk of a set-point.
pub const LIMIT_ACCELERATION: i32 = 4;
/// Bit: the workspace of the tcp.
pub const LIMIT_WORKSPACE: i32 = 8;
/// Bit: the end of an axis.
pub const LIMIT_AXIS: i32 = 16;
/// Bit: the sensor is at the end of its range.
pub const LIMIT_DEFLECTION: i32 = 32;
/// Bit: before contact, the sensor shows a force that it should not.
pub const LIMIT_DRIFT: i32 = 64;
/// Bit: a law would press with more than the allowed force.
pub const LIMIT_FORCE: i32 = 128;
/// Bit: a lost object is sought no faster than allowed.
pub const LIMIT_SEEK: i32 = 256;
/// Bit of the first axis whose force or moment caused a latched `Collision` or `ForceLimit`: force x; the next bits are
/// those of force y, z, moment x, y, z. [`Detection`] then has its value and its limit, N or Nm.
pub const LIMIT_COLLISION_FORCE_X: i32 = 512;
/// The program's step before failed by its time-out.
pub const LIMIT_STEP_TIME: i32 = 32768;
/// The program's step before failed at the end of its search.
pub const LIMIT_STEP_SEARCH: i32 = 65536;
/// The program's step before failed by its tolerance, or by what it touched on a free move.
pub const LIMIT_STEP_TOLERANCE: i32 = 131072;
/// The gain of the law is lowered, since the force oscillated and grew.
pub const LIMIT_GAIN: i32 = 262_144;
/// The sensor has brought nothing new for 3 T: the robot is held.
pub const LIMIT_HOLD: i32 = 524_288;

/// The statistic of contact detection and its threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Detection {
    /// Normal force from the tcp deflection, N; after a collision the force (N) or moment (Nm) that was one.
    pub statistic_n: f64,
    /// Threshold in force now, N; after a collision the limit that was exceeded, N or Nm.
    pub threshold_n: f64,
    /// Tick of the sample that detected contact, -1: none.
    pub contact_step: i64,
}

/// The impact that the present speed would cause, eqs. (13)-(18); from the contact on, that of the speed measured at
/// the contact. All zero before the tare is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpactAssessment {
    /// Speed of the tcp towards the object, m/s; negative: away from it, which causes no impact.
    pub speed_m_per_s: f64,
    /// Effective mass at the tcp, kg.
    pub effective_mass_kg: f64,
    /// Peak force, N.
    pub peak_force_n: f64,
    /// Maximum indentation, m.
    pub maximum_depth_m: f64,
    /// Characteristic impact time, s.
    pub characteristic_time_s: f64,
    /// Highest approach speed for the allowed force, m/s; 0: any force is allowed.
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
    /// Desired wrench at the tcp, in r, to which t is parallel up to the tool's sag.
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
    /// How many times as much the sensor may show before the loop is unstable, by what the controller assumes, 1; below
    /// 1: it is unstable, and stable with that share; 0: not assessed.
    pub gain_margin: f64,
    /// Phase margin of the loop, rad; negative: it is unstable; 0: not assessed.
    pub phase_margin_rad: f64,
    /// Amplitude of an observed oscillation, N.
    pub oscillation_n: f64,
    /// Limits that bind, a bit each: 1 lead, 2 velocity (the approach is slowed for the allowed force of the impact),
    /// 4 acceleration or jerk, 8 workspace, 16 axis, 32 deflection, 64 drift, 128 force, 256 seek, 512 to 16384: the axis
    /// that collided; 32768, 65536, 131072: the program's step before failed, by time, by the end of its search, by
    /// tolerance or a touch on a free move.
    pub limits: i32,
    /// Index of the program step, -1: no program. While calibrating: of the rest that is measured, -1: none.
    pub program_step: i32,
    /// `step` of the task message answered last.
    pub task_step: i64,
    /// The answer.
    pub task_answer: ParameterAnswer,
    /// Bit of the parameter refused, or of the last one accepted, -1: none.
    pub task_parameter: i32,
    /// The limit it left, or the value that it will have.
    pub task_limit: f64,
}

impl Check for ControllerStatus {
    fn check(&self) -> Result<(), Invalid> {
        self.stamp.check()?;
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
