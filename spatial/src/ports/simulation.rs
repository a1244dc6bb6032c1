//! The simulated world's channels: the border between two processes that share one physics, and the truth.

use super::{Check, Invalid, Stamp, finite, finite_pose, finite_vectors};
use crate::{Motion, Pose};
use nalgebra::Vector3;

/// `SIM_LINK_MOTION`: motion of the link-side sensor frame s, the robot's half of the physics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkMotion {
    /// Tick at which the motion holds.
    pub stamp: Stamp,
    /// Motion of s in r.
    pub motion: Motion,
    /// Kinetic energy of motors and links, J.
    pub kinetic_energy_j: f64,
    /// Elastic energy of the gears, J.
    pub elastic_energy_j: f64,
    /// Work that the motors have done since start, J.
    pub motor_work_j: f64,
    /// Energy dissipated in the gears since start, J.
    pub dissipated_energy_j: f64,
}

/// `SIM_TOOL_MOTION`: motion of the deflected sensor frame s' on the tool plate, the sensor's half of the physics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolMotion {
    /// Tick at which the motion holds.
    pub stamp: Stamp,
    /// Motion of s' in r.
    pub motion: Motion,
}

/// `SIM_TRUTH`: what only the simulation knows, for analysis; no controller subscribes to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Tick at which the values hold.
    pub stamp: Stamp,
    /// `r_from_ta1`: real pose of the tcp.
    pub tcp_pose: Pose,
    /// Velocity of the tcp in r, m/s.
    pub tcp_velocity: Vector3<f64>,
    /// Deflection of the tcp in the nominal tcp frame, before any signal chain: `ta_from_ta1`.
    pub tcp_deflection: crate::Deflection,
    /// Force of the object on the tool at the tick, in r, N.
    pub contact_force: Vector3<f64>,
    /// Largest contact force inside the last tick, N.
    pub contact_force_peak_n: f64,
    /// Indentation h, m; negative: distance.
    pub indentation_m: f64,
    /// Remaining indentation, m.
    pub remaining_indentation_m: f64,
    /// Height of the object's surface in r, m.
    pub object_height_m: f64,
    /// Approach speed at the first contact, m/s; 0 before.
    pub first_contact_speed_m_per_s: f64,
    /// Time of the first contact, s; -1 before.
    pub first_contact_time_s: f64,
    /// Kinetic energy of the tool, J.
    pub kinetic_energy_j: f64,
    /// Potential energy of the tool in gravity, J.
    pub gravity_energy_j: f64,
    /// Elastic energy of the sensor, J.
    pub elastic_energy_j: f64,
    /// Work the link has done on the tool through the sensor since start, J.
    pub link_work_j: f64,
    /// Energy dissipated in the sensor since start, J.
    pub dissipated_energy_j: f64,
    /// Work that the tool has done on the object since start, J: what the contact stores and has lost.
    pub contact_work_j: f64,
}

fn finite_motion(field: &'static str, motion: &Motion) -> Result<(), Invalid> {
    finite_pose(field, &motion.pose)?;
    finite_vectors(
        field,
        &[
            motion.velocity,
            motion.angular_velocity,
            motion.acceleration,
            motion.angular_acceleration,
        ],
    )
}

impl Check for LinkMotion {
    fn check(&self) -> Result<(), Invalid> {
        self.stamp.check()?;
        finite_motion("link_motion", &self.motion)?;
        finite(
            "link_energy",
            [
                &self.kinetic_energy_j,
                &self.elastic_energy_j,
                &self.motor_work_j,
                &self.dissipated_energy_j,
            ],
        )
    }
}

impl Check for ToolMotion {
    fn check(&self) -> Result<(), Invalid> {
        self.stamp.check()?;
        finite_motion("tool_motion", &self.motion)
    }
}

impl Check for Truth {
    fn check(&self) -> Result<(), Invalid> {
        self.stamp.check()?;
        finite_pose("truth_tcp_pose", &self.tcp_pose)?;
        finite_vectors(
            "truth",
            &[
                self.tcp_velocity,
                self.tcp_deflection.translation,
                self.tcp_deflection.rotation,
                self.contact_force,
            ],
        )?;
        finite(
            "truth",
            [
                &self.contact_force_peak_n,
                &self.indentation_m,
                &self.remaining_indentation_m,
                &self.object_height_m,
                &self.first_contact_speed_m_per_s,
                &self.first_contact_time_s,
                &self.kinetic_energy_j,
                &self.gravity_energy_j,
                &self.elastic_energy_j,
                &self.link_work_j,
                &self.dissipated_energy_j,
                &self.contact_work_j,
            ],
        )
    }
}
