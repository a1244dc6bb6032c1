//! The scenario: one TOML file per experiment, read by all nodes.
//!
//! Every key is declared once, below or in the file of its section: name (its suffix is the unit), type, default,
//! limits and one line of documentation. The structs, reading with validation, [`Scenario::hash`] and
//! [`Scenario::keys`] follow from that. Every key is optional; the defaults are the experiment of the paper's
//! section V on the reference plant.
//!
//! What is (`[robot]`, `[sensor]`, `[tool]`, `[object]`, `[object_sensor]`) and what the controller assumes
//! (`[controller]`) are separate entries, so that every claim about a wrong compliance, delay, mass or gear can be
//! tested.

mod adaptation;
mod check;
mod choice;
mod controller;
mod elastic;
mod error;
mod estimate;
mod hash;
mod names;
mod network;
mod object_sensor;
mod program;
mod protection;
mod reach;
mod read;
mod robot;
mod schema;
mod shaping;
mod task;
#[cfg(test)]
mod tests;
mod value;
mod write;

pub use adaptation::Adaptation;
pub use choice::{
    ExpectedFrom, Gears, Kinematics, ObjectMotion, OnFailure, Pairing, Profile, SensorOutput, StepKind,
    TaskKind, TimingMode, ToolShape, Transform,
};
pub use controller::{AssumedServo, Controller, Expected, Fzi, Impact, Impedance, Pd, Proposed, Ros2};
pub use elastic::{AssumedGears, ElasticLaw};
pub use error::ScenarioError;
pub use network::Network;
pub use object_sensor::ObjectSensor;
pub use program::{Program, Step, Steps};
pub use protection::{Collision, Cusum, Limits, Oscillation};
pub use robot::Drives;
pub use schema::{Allowed, Key, Section};
pub use shaping::Shaping;
pub use spatial::ports::Law;
pub use task::{ForceControlled, Task};

schema::section! {
    /// One experiment: what is, what is asked for, and what the controller assumes.
    Scenario at "" with timing: Timing, network: Network, robot: Robot, sensor: Sensor, tool: Tool, object: Object,
        object_sensor: ObjectSensor, task: Task, program: Program, controller: Controller {}
}

schema::section! {
    /// Time, its pace and its length.
    Timing at "timing" {
        /// What drives the nodes' time.
        mode: TimingMode = TimingMode::Lockstep;
        /// Command period T. Of more than eight ticks, messages carry the last eight readings alone.
        command_period_ticks: i64 = 4, in 1..=12;
        /// Length of the experiment in simulated time.
        duration_s: f64 = 3.0, in 0.001..=86400.0;
        /// Seed of every random stream.
        seed: i64 = 1, in 0..=i64::MAX;
    }
}

impl Timing {
    /// How many ticks the experiment lasts, from tick 0 to the last one inclusive.
    pub fn ticks(&self) -> i64 {
        libm::rint(self.duration_s / spatial::TICK_S) as i64 + 1
    }
}

schema::section! {
    /// The robot as it is: six axes, their gears and their position controller.
    Robot at "robot" with gantry: Gantry, arm: Arm {
        /// From axis angles to the pose of s; its axes are those of `[robot.gantry]` or `[robot.arm]`.
        kinematics: Kinematics = Kinematics::Gantry;
        /// What joins motor and link.
        gears: Gears = Gears::Rigid;
        /// Damping ratio of every elastic gear with its motor locked.
        gear_damping: f64 = 0.02, in 0.0..=2.0;
        /// Periods T from a command to its effect, n_d.
        command_delay_periods: i64 = 2, in 0..=10;
        /// Good commands have to come for so long before one is executed; 0: the first one is.
        arming_s: f64 = 0.2, in 0.0..=10.0;
        /// Without a new command the robot brakes so long after the end of the newest one's horizon, and latches a fault.
        /// On a busy virtual machine more than 0.2 s.
        command_gap_s: f64 = 0.02, in 0.001..=10.0;
        /// Natural frequency of the command filter.
        filter_frequency_hz: f64 = 15.0, in 0.1..=200.0;
        /// Damping ratio of the command filter.
        filter_damping: f64 = 0.8, in 0.1..=5.0;
        /// Gain of the position loop.
        position_gain_per_s: f64 = 25.0, in 0.1..=500.0;
        /// Bandwidth of the velocity loop, with the motor's inertia alone.
        velocity_bandwidth_hz: f64 = 60.0, in 1.0..=150.0;
        /// Integral time of the velocity loop.
        velocity_integral_time_s: f64 = 0.03, in 1e-3..=100.0;
        /// Step of the axes' integration, a whole fraction of 1 ms.
        integration_step_s: f64 = 1e-3, in 1e-6..=1e-3;
    }
}

schema::section! {
    /// The axes of the gantry: three of translation (1 rad is 1 m) and three of rotation.
    Gantry at "robot.gantry" {
        /// Inertia of each axis on the motor's side.
        motor_inertia_kg_m2: [f64; 6] = [120.0, 120.0, 120.0, 4.0, 4.0, 4.0], in 1e-3..=1e4;
        /// Inertia of each axis on the link's side.
        link_inertia_kg_m2: [f64; 6] = [60.0, 60.0, 60.0, 2.0, 2.0, 2.0], in 1e-3..=1e4;
        /// Natural frequency of each link on its elastic gear, motor locked.
        gear_frequency_hz: [f64; 6] = [14.0, 14.0, 14.0, 20.0, 20.0, 20.0], in 0.5..=500.0;
        /// Lower end of each axis.
        axis_minimum_rad: [f64; 6] = [-1.0, -1.0, -1.0, -1.5, -1.5, -1.5], in -100.0..=100.0;
        /// Upper end of each axis.
        axis_maximum_rad: [f64; 6] = [1.0, 1.0, 1.0, 1.5, 1.5, 1.5], in -100.0..=100.0;
        /// Velocity that the command filter does not exceed.
        velocity_limit_rad_per_s: [f64; 6] = [1.0, 1.0, 1.0, 2.0, 2.0, 2.0], in 1e-3..=100.0;
        /// Acceleration that the command filter does not exceed.
        acceleration_limit_rad_per_s2: [f64; 6] = [5.0, 5.0, 5.0, 30.0, 30.0, 30.0], in 0.01..=1e4;
    }
}

schema::section! {
    /// The joints and links of the arm, KUKA KR 16-2 class; its lengths are fixed. A link's frame lies in its joint,
    /// parallel to the base's when all joints are at zero and the arm is stretched along x.
    Arm at "robot.arm" {
        /// Origin of the base in r; it stands parallel to r.
        base_position_m: [f64; 3] = [-1.0, 0.0, -0.72], in -10.0..=10.0;
        /// Inertia of each motor, seen from its joint.
        motor_inertia_kg_m2: [f64; 6] = [100.0, 100.0, 50.0, 2.4, 2.4, 1.0], in 0.1..=1e4;
        /// Natural frequency of each joint on its elastic gear, motor and all other joints locked, in the working
        /// posture.
        gear_frequency_hz: [f64; 6] = [14.0, 15.0, 17.0, 20.0, 22.0, 25.0], in 0.5..=500.0;
        /// Lower end of each joint.
        axis_minimum_rad: [f64; 6] = [-3.22886, -2.70526, -2.26893, -6.10865, -2.26893, -6.10865], in -100.0..=100.0;
        /// Upper end of each joint.
        axis_maximum_rad: [f64; 6] = [3.22886, 0.61087, 2.68781, 6.10865, 2.26893, 6.10865], in -100.0..=100.0;
        /// Velocity that the command filter does not exceed.
        velocity_limit_rad_per_s: [f64; 6] = [2.72271, 2.72271, 2.72271, 5.75959, 5.75959, 10.73377], in 1e-3..=100.0;
        /// Acceleration that the command filter does not exceed.
        acceleration_limit_rad_per_s2: [f64; 6] = [7.5, 7.5, 10.0, 30.0, 30.0, 45.0], in 0.01..=1e4;
        /// Mass of each link.
        link_mass_kg: [f64; 6] = [45.0, 24.0, 46.0, 25.0, 12.0, 12.0], in 1e-3..=1e4;
        /// Centres of mass in the links' frames along x.
        link_centre_x_m: [f64; 6] = [0.08, 0.27, 0.17, -0.2, 0.0, 0.06], in -5.0..=5.0;
        /// Centres of mass in the links' frames along y.
        link_centre_y_m: [f64; 6] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0], in -5.0..=5.0;
        /// Centres of mass in the links' frames along z.
        link_centre_z_m: [f64; 6] = [-0.1, 0.0, 0.03, 0.0, 0.0, 0.0], in -5.0..=5.0;
        /// Inertia of each link about the x axis through its centre of mass; the frame's axes are its principal ones.
        link_inertia_x_kg_m2: [f64; 6] = [2.5, 0.3, 0.8, 0.12, 0.1, 0.5], in 0.02..=300.0;
        /// Inertia of each link about the y axis through its centre of mass.
        link_inertia_y_kg_m2: [f64; 6] = [2.5, 1.4, 4.5, 0.9, 0.45, 0.65], in 0.02..=300.0;
        /// Inertia of each link about the z axis through its centre of mass.
        link_inertia_z_kg_m2: [f64; 6] = [2.0, 1.4, 4.5, 0.9, 0.45, 0.65], in 0.02..=300.0;
    }
}

schema::section! {
    /// The compliant sensor as it is.
    Sensor at "sensor" {
        /// Translational stiffness, equal along all axes.
        stiffness_n_per_m: f64 = 300e3, in 1e2..=3e7;
        /// Rotational stiffness, equal about all axes.
        stiffness_nm_per_rad: f64 = 401.07, in 0.1..=1e5;
        /// Translational damping.
        damping_ns_per_m: f64 = 65.7, in 0.0..=1e6;
        /// Rotational damping.
        damping_nms_per_rad: f64 = 0.2216, in 0.0..=1e4;
        /// Corner of the measurement's first-order low pass.
        bandwidth_hz: f64 = 200.0, in 1.0..=5000.0;
        /// White noise of a translation, rms.
        noise_translation_m: f64 = 2e-6, in 0.0..=1e-3;
        /// White noise of a rotation, rms.
        noise_rotation_rad: f64 = 40e-6, in 0.0..=0.01;
        /// Quantum of a translation; 0: none.
        quantum_translation_m: f64 = 1e-6, in 0.0..=1e-3;
        /// Quantum of a rotation; 0: none.
        quantum_rotation_rad: f64 = 20e-6, in 0.0..=0.01;
        /// Measuring range of a translation, either way.
        range_translation_m: f64 = 1.5e-3, in 1e-5..=0.1;
        /// Measuring range of a rotation, either way.
        range_rotation_rad: f64 = 0.02618, in 1e-5..=1.0;
        /// Ticks from sampling to publication.
        delay_ticks: i64 = 4, in 0..=100;
        /// Drift of the translation's bias.
        drift_translation_m_per_s: [f64; 3] = [0.0, 0.0, 0.0], in -1e-2..=1e-2;
        /// Drift of the rotation's bias.
        drift_rotation_rad_per_s: [f64; 3] = [0.0, 0.0, 0.0], in -0.1..=0.1;
        /// When a drop-out begins: no sample is valid until it ends.
        dropout_start_s: f64 = 0.0, in 0.0..=86400.0;
        /// How long the drop-out lasts; 0: there is none.
        dropout_duration_s: f64 = 0.0, in 0.0..=86400.0;
        /// Whether the wrench is measured too, independently of the deflection.
        wrench_measured: bool = false;
        /// White noise of a measured force, rms.
        noise_force_n: f64 = 0.2, in 0.0..=1e3;
        /// White noise of a measured moment, rms.
        noise_moment_nm: f64 = 0.005, in 0.0..=1e2;
        /// Deflection at which the translational end stop begins.
        end_stop_m: f64 = 2e-3, in 1e-5..=0.1;
        /// Stiffness that the end stop adds beyond; 0: there is none.
        end_stop_n_per_m: f64 = 0.0, in 0.0..=1e10;
        /// Deflection at which the rotational end stop begins.
        end_stop_rad: f64 = 0.035, in 1e-5..=1.0;
        /// Stiffness that the end stop adds beyond; 0: there is none.
        end_stop_nm_per_rad: f64 = 0.0, in 0.0..=1e8;
        /// Longest step of the tool's integration around kinks of the contact's law.
        integration_step_s: f64 = 20e-6, in 1e-6..=1e-3;
        /// Step while that law is smooth, free or pressing steadily; a whole fraction of 1 ms. Around kinks it is halved
        /// until it is at most integration_step_s.
        smooth_step_s: f64 = 1e-3, in 1e-6..=1e-3;
    }
}

impl Sensor {
    /// The element between the robot's last link and the tool plate, as robot and tool feel it.
    pub fn suspension(&self) -> spatial::ToolSuspension {
        spatial::ToolSuspension {
            stiffness_n_per_m: self.stiffness_n_per_m,
            stiffness_nm_per_rad: self.stiffness_nm_per_rad,
            damping_ns_per_m: self.damping_ns_per_m,
            damping_nms_per_rad: self.damping_nms_per_rad,
            end_stop_m: self.end_stop_m,
            end_stop_n_per_m: self.end_stop_n_per_m,
            end_stop_rad: self.end_stop_rad,
            end_stop_nm_per_rad: self.end_stop_nm_per_rad,
        }
    }
}

schema::section! {
    /// The rigid tool on the sensor as it is.
    Tool at "tool" {
        /// Mass.
        mass_kg: f64 = 4.0, in 1e-3..=1e4;
        /// Principal moments of inertia about the centre of mass, along the axes of s.
        inertia_kg_m2: [f64; 3] = [0.012, 0.016, 0.010], in 1e-7..=1e5;
        /// Centre of mass in s.
        centre_of_mass_in_s_m: [f64; 3] = [0.03, 0.0, -0.06], in -5.0..=5.0;
        /// Tool centre point in s.
        tcp_in_s_m: [f64; 3] = [0.10, 0.0, -0.15], in -5.0..=5.0;
        /// What of it may touch the object.
        shape: ToolShape = ToolShape::Point;
        /// Length and width of the face, along the axes of s.
        face_size_m: [f64; 2] = [0.04, 0.04], in 1e-4..=1.0;
        /// Radius of the peg.
        peg_radius_m: f64 = 0.010, in 1e-4..=0.5;
        /// Length of the peg: how far above its end the upper ring of contact points lies.
        peg_length_m: f64 = 0.020, in 1e-4..=1.0;
    }
}

schema::section! {
    /// The object and its contact with the tool, eqs. (13) to (15).
    Object at "object" {
        /// Height of its surface in r.
        height_m: f64 = 0.010, in -10.0..=10.0;
        /// Indentation coefficient while loading, c_in (for exponent n: N/m^n).
        indentation_n_per_m: f64 = 16e6, in 1e2..=1e12;
        /// Rebound coefficient over indentation coefficient, c_re / c_in.
        rebound_ratio: f64 = 4.0, in 1.0..=1e3;
        /// Exponent n of the indentation.
        exponent: f64 = 1.0, in 1.0..=3.0;
        /// Coefficient of Coulomb friction.
        friction: f64 = 0.0, in 0.0..=2.0;
        /// Sliding speed below which friction fades to zero.
        friction_speed_m_per_s: f64 = 5e-4, in 1e-5..=0.1;
        /// Where its origin lies in r, x and y: there the surface has its height, and there the hole is.
        origin_m: [f64; 2] = [0.0, 0.0], in -10.0..=10.0;
        /// Rotation vector from r to the object; the surface's normal is the object's z axis.
        rotation_rad: [f64; 3] = [0.0, 0.0, 0.0], in -0.5..=0.5;
        /// Constant velocity in r, from the start on.
        velocity_m_per_s: [f64; 3] = [0.0, 0.0, 0.0], in -1.0..=1.0;
        /// Amplitude of the sinusoid that it moves along in addition, in r.
        swing_amplitude_m: [f64; 3] = [0.0, 0.0, 0.0], in -0.1..=0.1;
        /// Frequency of the sinusoid.
        swing_frequency_hz: f64 = 1.0, in 0.0..=100.0;
        /// Phase of the sinusoid at the start.
        swing_phase_rad: f64 = 0.0, in -7.0..=7.0;
        /// Times of a recorded profile of heights, increasing.
        profile_time_s: Vec<f64> = vec![], in 0.0..=86400.0;
        /// The profile's heights at these times, above height_m.
        profile_height_m: Vec<f64> = vec![], in -1.0..=1.0;
        /// Stiffness with which the surface is held along its normal; 0: rigidly.
        support_n_per_m: f64 = 0.0, in 0.0..=1e10;
        /// Damping of that support.
        support_ns_per_m: f64 = 0.0, in 0.0..=1e6;
        /// Mass of the surface that moves on the support.
        support_mass_kg: f64 = 1.0, in 1e-3..=1e4;
        /// Radius of a round hole at the origin; 0: there is none.
        hole_radius_m: f64 = 0.0, in 0.0..=1.0;
        /// Width (and height) of the hole's chamfer.
        hole_chamfer_m: f64 = 0.0, in 0.0..=0.1;
        /// Depth of the hole.
        hole_depth_m: f64 = 0.030, in 1e-4..=1.0;
    }
}
