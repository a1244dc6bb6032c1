//! `TASK`: parameters that are not set travel as zeros, and their mask bits too.

use super::{Port, authenticity, in_range, stamp};
use crate::error::Unusable;
use crate::raw;
use spatial::ports::{Task, TaskAction, TaskParameters};

type Raw = raw::task::Raw;

impl Port for Task {
    fn to_raw(&self) -> Self::Raw {
        let values = self.parameters.values();
        let mut raw = Raw {
            step: self.stamp.step,
            utime: self.stamp.utime,
            boot_id: self.stamp.boot_id,
            task_action: self.action.code(),
            task_parameter_mask: (0..)
                .zip(&values)
                .map(|(bit, value)| i64::from(value.is_some()) << bit)
                .sum(),
            session: self.authenticity.session,
            seq: self.authenticity.seq,
            key_id: self.authenticity.key_id,
            tag: self.authenticity.tag,
            ..Raw::default()
        };
        for (member, value) in parameters(&mut raw).into_iter().zip(values) {
            *member = value.unwrap_or(0.0);
        }
        raw
    }

    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable> {
        let mask = raw.task_parameter_mask;
        in_range("task_parameter_mask", mask, 0, (1 << TaskParameters::COUNT) - 1)?;
        let sent = parameters(&mut raw.clone()).map(|member| *member);
        let mut values = [None; TaskParameters::COUNT];
        for (bit, (value, sent)) in values.iter_mut().zip(sent).enumerate() {
            if mask >> bit & 1 == 1 {
                *value = Some(sent);
            } else if sent.to_bits() != 0 {
                let parameter = TaskParameters::NAMES[bit];
                return Err(Unusable::Unmasked {
                    parameter,
                    value: sent,
                    bit,
                });
            }
        }
        Ok(Self {
            stamp: stamp!(raw),
            action: TaskAction::from_code(raw.task_action)?,
            parameters: TaskParameters::from_values(values),
            authenticity: authenticity!(raw),
        })
    }
}

/// The parameters' members, in the order of their mask bits.
fn parameters(raw: &mut Raw) -> [&mut f64; TaskParameters::COUNT] {
    [
        &mut raw.task_desired_force_n,
        &mut raw.task_desired_moment_x_nm,
        &mut raw.task_desired_moment_y_nm,
        &mut raw.task_desired_moment_z_nm,
        &mut raw.task_approach_speed_m_per_s,
        &mut raw.task_expected_height_m,
        &mut raw.task_search_depth_m,
        &mut raw.task_detection_threshold_n,
        &mut raw.task_max_impact_force_n,
        &mut raw.task_max_contact_force_n,
        &mut raw.task_max_lead_m,
        &mut raw.task_object_filter_gain,
        &mut raw.task_reference_bandwidth_hz,
        &mut raw.task_tilt_time_s,
        &mut raw.task_pd_proportional_m_per_n,
        &mut raw.task_pd_derivative_m_per_n,
        &mut raw.task_compliance_m_per_n,
        &mut raw.task_compliance_rad_per_nm,
    ]
}
