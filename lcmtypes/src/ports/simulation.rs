//! `SIM_LINK_MOTION`, `SIM_TOOL_MOTION` and `SIM_TRUTH`.

use super::{Port, from_pose, stamp, to_pose};
use crate::error::Unusable;
use spatial::ports::{LinkMotion, ToolMotion, Truth};
use spatial::{Deflection, Motion};

impl Port for LinkMotion {
    fn to_raw(&self) -> Self::Raw {
        let (position, quaternion) = from_pose(&self.motion.pose);
        Self::Raw {
            step: self.stamp.step,
            utime: self.stamp.utime,
            boot_id: self.stamp.boot_id,
            link_r_from_s_position_m: position,
            link_r_from_s_quaternion_wxyz: quaternion,
            link_velocity_m_per_s: self.motion.velocity.into(),
            link_angular_velocity_rad_per_s: self.motion.angular_velocity.into(),
            link_acceleration_m_per_s2: self.motion.acceleration.into(),
            link_angular_acceleration_rad_per_s2: self.motion.angular_acceleration.into(),
            link_kinetic_energy_j: self.kinetic_energy_j,
            link_elastic_energy_j: self.elastic_energy_j,
            link_motor_work_j: self.motor_work_j,
            link_dissipated_energy_j: self.dissipated_energy_j,
        }
    }

    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable> {
        Ok(Self {
            stamp: stamp!(raw),
            motion: Motion {
                pose: to_pose(raw.link_r_from_s_position_m, raw.link_r_from_s_quaternion_wxyz),
                velocity: raw.link_velocity_m_per_s.into(),
                angular_velocity: raw.link_angular_velocity_rad_per_s.into(),
                acceleration: raw.link_acceleration_m_per_s2.into(),
                angular_acceleration: raw.link_angular_acceleration_rad_per_s2.into(),
            },
            kinetic_energy_j: raw.link_kinetic_energy_j,
            elastic_energy_j: raw.link_elastic_energy_j,
            motor_work_j: raw.link_motor_work_j,
            dissipated_energy_j: raw.link_dissipated_energy_j,
        })
    }
}

impl Port for ToolMotion {
    fn to_raw(&self) -> Self::Raw {
        let (position, quaternion) = from_pose(&self.motion.pose);
        Self::Raw {
            step: self.stamp.step,
            utime: self.stamp.utime,
            boot_id: self.stamp.boot_id,
            tool_r_from_s1_position_m: position,
            tool_r_from_s1_quaternion_wxyz: quaternion,
            tool_velocity_m_per_s: self.motion.velocity.into(),
            tool_angular_velocity_rad_per_s: self.motion.angular_velocity.into(),
            tool_acceleration_m_per_s2: self.motion.acceleration.into(),
            tool_angular_acceleration_rad_per_s2: self.motion.angular_acceleration.into(),
        }
    }

    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable> {
        Ok(Self {
            stamp: stamp!(raw),
            motion: Motion {
                pose: to_pose(raw.tool_r_from_s1_position_m, raw.tool_r_from_s1_quaternion_wxyz),
                velocity: raw.tool_velocity_m_per_s.into(),
                angular_velocity: raw.tool_angular_velocity_rad_per_s.into(),
                acceleration: raw.tool_acceleration_m_per_s2.into(),
                angular_acceleration: raw.tool_angular_acceleration_rad_per_s2.into(),
            },
        })
    }
}

impl Port for Truth {
    fn to_raw(&self) -> Self::Raw {
        let (position, quaternion) = from_pose(&self.tcp_pose);
        Self::Raw {
            step: self.stamp.step,
            utime: self.stamp.utime,
            boot_id: self.stamp.boot_id,
            truth_r_from_ta1_position_m: position,
            truth_r_from_ta1_quaternion_wxyz: quaternion,
            truth_tcp_velocity_m_per_s: self.tcp_velocity.into(),
            truth_tcp_deflection_translation_m: self.tcp_deflection.translation.into(),
            truth_tcp_deflection_rotation_rad: self.tcp_deflection.rotation.into(),
            truth_contact_force_n: self.contact_force.into(),
            truth_contact_force_peak_n: self.contact_force_peak_n,
            truth_indentation_m: self.indentation_m,
            truth_remaining_indentation_m: self.remaining_indentation_m,
            truth_object_height_m: self.object_height_m,
            truth_first_contact_speed_m_per_s: self.first_contact_speed_m_per_s,
            truth_first_contact_time_s: self.first_contact_time_s,
            truth_kinetic_energy_j: self.kinetic_energy_j,
            truth_gravity_energy_j: self.gravity_energy_j,
            truth_elastic_energy_j: self.elastic_energy_j,
            truth_link_work_j: self.link_work_j,
            truth_dissipated_energy_j: self.dissipated_energy_j,
            truth_contact_work_j: self.contact_work_j,
        }
    }

    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable> {
        Ok(Self {
            stamp: stamp!(raw),
            tcp_pose: to_pose(
                raw.truth_r_from_ta1_position_m,
                raw.truth_r_from_ta1_quaternion_wxyz,
            ),
            tcp_velocity: raw.truth_tcp_velocity_m_per_s.into(),
            tcp_deflection: Deflection {
                translation: raw.truth_tcp_deflection_translation_m.into(),
                rotation: raw.truth_tcp_deflection_rotation_rad.into(),
            },
            contact_force: raw.truth_contact_force_n.into(),
            contact_force_peak_n: raw.truth_contact_force_peak_n,
            indentation_m: raw.truth_indentation_m,
            remaining_indentation_m: raw.truth_remaining_indentation_m,
            object_height_m: raw.truth_object_height_m,
            first_contact_speed_m_per_s: raw.truth_first_contact_speed_m_per_s,
            first_contact_time_s: raw.truth_first_contact_time_s,
            kinetic_energy_j: raw.truth_kinetic_energy_j,
            gravity_energy_j: raw.truth_gravity_energy_j,
            elastic_energy_j: raw.truth_elastic_energy_j,
            link_work_j: raw.truth_link_work_j,
            dissipated_energy_j: raw.truth_dissipated_energy_j,
            contact_work_j: raw.truth_contact_work_j,
        })
    }
}
