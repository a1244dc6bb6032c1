//! `TASK`: what a person or a script asks of the controller while it runs.

use super::{Authenticity, Check, Invalid, Stamp, finite, wire_enum};

wire_enum! {
    /// What a task message asks for.
    TaskAction {
        /// Only the parameters that the mask names.
        #[default]
        None = 0,
        /// Begin the configured task.
        Start = 1,
        /// Come to rest and hold.
        Stop = 2,
        /// Take the present deflection as zero.
        Tare = 3,
        /// Clear a latched fault whose cause is gone.
        Reset = 4,
        /// Give the robot to another controller.
        Release = 5,
    }
}

wire_enum! {
    /// How the controller answered a request, or why it does not begin its task by itself.
    ParameterAnswer {
        /// Nothing asked yet.
        #[default]
        None = 0,
        /// Taken.
        Accepted = 1,
        /// Outside its limit, which is published beside.
        OutOfRange = 2,
        /// Not possible in the present phase.
        WrongPhase = 3,
        /// Not known to this controller.
        Unknown = 4,
        /// No start: the robot's state is older than its limit, s, which is published beside.
        RobotStale = 5,
        /// No start: the robot is in a fault, or farther from where it was sent than the limit, m.
        RobotNotReady = 6,
        /// No start: the sensor's newest valid sample is older than the limit, s.
        SensorStale = 7,
        /// No start: the sensor is, or was during the tare, at the end of its range.
        SensorSaturated = 8,
        /// No start: what the sensor bears at rest is turned from the tool's weight by more than the limit, rad.
        SensorFrame = 9,
        /// No start: the tool looks lighter or heavier than the limit, kg.
        ToolMass = 10,
        /// No start: the sensor's bias along x or y is beyond the limit, N.
        SensorBias = 11,
        /// No start: the object that is expected has not been seen.
        ObjectUnknown = 12,
        /// A fault is latched, or its cause is not gone.
        FaultLatched = 13,
    }
}

macro_rules! parameters {
    ($($(#[$meta:meta])* $field:ident = $bit:literal,)*) => {
        /// The parameters that can change at run time; `None`: left as it is. One mask bit each on the wire.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct TaskParameters {
            $($(#[$meta])* pub $field: Option<f64>,)*
        }

        impl TaskParameters {
            /// How many there are.
            pub const COUNT: usize = [$($bit),*].len();

            /// Names, in the order of their mask bits.
            pub const NAMES: [&'static str; Self::COUNT] = [$(stringify!($field)),*];

            /// Values in the order of their mask bits.
            pub fn values(&self) -> [Option<f64>; Self::COUNT] {
                [$(self.$field),*]
            }

            /// The parameters with `values` in the order of their mask bits.
            pub fn from_values(values: [Option<f64>; Self::COUNT]) -> Self {
                Self { $($field: values[$bit],)* }
            }
        }
    };
}

parameters! {
    /// Desired normal force, N.
    desired_force_n = 0,
    /// Desired moment about the tcp's x, Nm.
    desired_moment_x_nm = 1,
    /// Desired moment about the tcp's y, Nm.
    desired_moment_y_nm = 2,
    /// Desired moment about the tcp's z, Nm.
    desired_moment_z_nm = 3,
    /// Approach speed, m/s.
    approach_speed_m_per_s = 4,
    /// Height at which the object is expected, m.
    expected_height_m = 5,
    /// How far below the expected height to search, m.
    search_depth_m = 6,
    /// Contact detection threshold, N.
    detection_threshold_n = 7,
    /// Allowed impact force, N.
    max_impact_force_n = 8,
    /// Allowed contact force, N.
    max_contact_force_n = 9,
    /// Bound of command minus actual pose, m.
    max_lead_m = 10,
    /// Weight of a new sample in the object's pose, 1.
    object_filter_gain = 11,
    /// Bandwidth of the reference model, Hz.
    reference_bandwidth_hz = 12,
    /// Time over which the posture's tilt is spread, s.
    tilt_time_s = 13,
    /// Proportional gain K of eq. (1), m/N.
    pd_proportional_m_per_n = 14,
    /// Derivative gain D of eq. (1), m/N.
    pd_derivative_m_per_n = 15,
    /// Assumed translational compliance, m/N.
    compliance_m_per_n = 16,
    /// Assumed rotational compliance, rad/Nm.
    compliance_rad_per_nm = 17,
}

/// A request to the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Task {
    /// `step` counts the sender's requests.
    pub stamp: Stamp,
    /// What to do.
    pub action: TaskAction,
    /// What to change.
    pub parameters: TaskParameters,
    /// Sender and order.
    pub authenticity: Authenticity,
}

impl Check for Task {
    fn check(&self) -> Result<(), Invalid> {
        self.stamp.check()?;
        self.parameters
            .values()
            .iter()
            .flatten()
            .try_for_each(|value| finite("task_parameter", [value]))
    }
}
