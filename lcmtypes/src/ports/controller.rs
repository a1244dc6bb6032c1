//! `CONTROLLER_STATUS`.

use super::{Port, from_matrix, from_pose, stamp, to_bool, to_matrix, to_pose};
use crate::error::Unusable;
use spatial::ports::{
    ControllerPhase, ControllerStatus, Detection, Fault, ImpactAssessment, Law, ParameterAnswer,
};
use spatial::{Compliance, Deflection, Wrench};

impl Port for ControllerStatus {
    fn to_raw(&self) -> Self::Raw {
        let (object_position, object_quaternion) = from_pose(&self.object_pose);
        let (tcp_position, tcp_quaternion) = from_pose(&self.tcp_pose);
        Self::Raw {
            step: self.stamp.step,
            utime: self.stamp.utime,
            boot_id: self.stamp.boot_id,
            controller_phase: self.phase.code(),
            controller_fault: self.fault.code(),
            controller_law: self.law.code(),
            controller_object_known: self.object_known.into(),
            controller_r_from_o_position_m: object_position,
            controller_r_from_o_quaternion_wxyz: object_quaternion,
            controller_object_velocity_m_per_s: self.object_velocity.into(),
            controller_r_from_ta1_position_m: tcp_position,
            controller_r_from_ta1_quaternion_wxyz: tcp_quaternion,
            controller_force_n: self.wrench.force.into(),
            controller_moment_nm: self.wrench.moment.into(),
            controller_desired_force_n: self.desired_wrench.force.into(),
            controller_desired_moment_nm: self.desired_wrench.moment.into(),
            controller_force_error_n: self.force_error_n,
            controller_detection_statistic_n: self.detection.statistic_n,
            controller_detection_threshold_n: self.detection.threshold_n,
            controller_contact_step: self.detection.contact_step,
            controller_compliance_m_per_n: from_matrix(&self.compliance.translation),
            controller_compliance_rad_per_nm: from_matrix(&self.compliance.rotation),
            controller_compliance_confidence: self.compliance_confidence,
            controller_tare_translation_m: self.tare.translation.into(),
            controller_tare_rotation_rad: self.tare.rotation.into(),
            controller_impact_speed_m_per_s: self.impact.speed_m_per_s,
            controller_impact_effective_mass_kg: self.impact.effective_mass_kg,
            controller_impact_peak_force_n: self.impact.peak_force_n,
            controller_impact_maximum_depth_m: self.impact.maximum_depth_m,
            controller_impact_characteristic_time_s: self.impact.characteristic_time_s,
            controller_impact_speed_limit_m_per_s: self.impact.speed_limit_m_per_s,
            controller_gain_margin: self.gain_margin,
            controller_phase_margin_rad: self.phase_margin_rad,
            controller_oscillation_n: self.oscillation_n,
            controller_limits: self.limits,
            controller_program_step: self.program_step,
            controller_task_step: self.task_step,
            controller_task_answer: self.task_answer.code(),
            controller_task_parameter: self.task_parameter,
            controller_task_limit: self.task_limit,
        }
    }

    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable> {
        Ok(Self {
            stamp: stamp!(raw),
            phase: ControllerPhase::from_code(raw.controller_phase)?,
            fault: Fault::from_code(raw.controller_fault)?,
            law: Law::from_code(raw.controller_law)?,
            object_known: to_bool("controller_object_known", raw.controller_object_known)?,
            object_pose: to_pose(
                raw.controller_r_from_o_position_m,
                raw.controller_r_from_o_quaternion_wxyz,
            ),
            object_velocity: raw.controller_object_velocity_m_per_s.into(),
            tcp_pose: to_pose(
                raw.controller_r_from_ta1_position_m,
                raw.controller_r_from_ta1_quaternion_wxyz,
            ),
            wrench: Wrench {
                force: raw.controller_force_n.into(),
                moment: raw.controller_moment_nm.into(),
            },
            desired_wrench: Wrench {
                force: raw.controller_desired_force_n.into(),
                moment: raw.controller_desired_moment_nm.into(),
            },
            force_error_n: raw.controller_force_error_n,
            detection: Detection {
                statistic_n: raw.controller_detection_statistic_n,
                threshold_n: raw.controller_detection_threshold_n,
                contact_step: raw.controller_contact_step,
            },
            compliance: Compliance {
                translation: to_matrix(raw.controller_compliance_m_per_n),
                rotation: to_matrix(raw.controller_compliance_rad_per_nm),
            },
            compliance_confidence: raw.controller_compliance_confidence,
            tare: Deflection {
                translation: raw.controller_tare_translation_m.into(),
                rotation: raw.controller_tare_rotation_rad.into(),
            },
            impact: ImpactAssessment {
                speed_m_per_s: raw.controller_impact_speed_m_per_s,
                effective_mass_kg: raw.controller_impact_effective_mass_kg,
                peak_force_n: raw.controller_impact_peak_force_n,
                maximum_depth_m: raw.controller_impact_maximum_depth_m,
                characteristic_time_s: raw.controller_impact_characteristic_time_s,
                speed_limit_m_per_s: raw.controller_impact_speed_limit_m_per_s,
            },
            gain_margin: raw.controller_gain_margin,
            phase_margin_rad: raw.controller_phase_margin_rad,
            oscillation_n: raw.controller_oscillation_n,
            limits: raw.controller_limits,
            program_step: raw.controller_program_step,
            task_step: raw.controller_task_step,
            task_answer: ParameterAnswer::from_code(raw.controller_task_answer)?,
            task_parameter: raw.controller_task_parameter,
            task_limit: raw.controller_task_limit,
        })
    }
}
