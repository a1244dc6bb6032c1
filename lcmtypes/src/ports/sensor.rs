//! `SENSOR_DEFLECTION` and `OBJECT_POSE`.

use super::{Port, authenticity, from_pose, in_range, stamp, to_bool, to_pose};
use crate::error::Unusable;
use spatial::ports::{ClockEcho, DEFLECTION_SAMPLES, DeflectionSample, Deflections, ObjectPose, SampleFlags};
use spatial::{Deflection, Wrench};

/// All flags of a sample.
const FLAGS: i64 = 7;

impl Port for Deflections {
    fn to_raw(&self) -> Self::Raw {
        let samples = &self.samples;
        Self::Raw {
            step: self.stamp.step,
            utime: self.stamp.utime,
            boot_id: self.stamp.boot_id,
            deflection_sample_us: samples.map(|sample| sample.utime),
            deflection_translation_m: samples.map(|sample| sample.deflection.translation.into()),
            deflection_rotation_rad: samples.map(|sample| sample.deflection.rotation.into()),
            deflection_force_n: samples.map(|sample| sample.wrench.force.into()),
            deflection_moment_nm: samples.map(|sample| sample.wrench.moment.into()),
            deflection_flags: samples.map(|sample| sample.flags.bits()),
            deflection_echo_command_send_us: self.echo.command_send_utime,
            deflection_echo_receive_us: self.echo.receive_utime,
            deflection_echo_send_us: self.echo.send_utime,
            session: self.authenticity.session,
            seq: self.authenticity.seq,
            key_id: self.authenticity.key_id,
            tag: self.authenticity.tag,
        }
    }

    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable> {
        let mut samples = [DeflectionSample::default(); DEFLECTION_SAMPLES];
        for (i, sample) in samples.iter_mut().enumerate() {
            let flags = raw.deflection_flags[i];
            in_range("deflection_flags", flags.into(), 0, FLAGS)?;
            *sample = DeflectionSample {
                utime: raw.deflection_sample_us[i],
                deflection: Deflection {
                    translation: raw.deflection_translation_m[i].into(),
                    rotation: raw.deflection_rotation_rad[i].into(),
                },
                wrench: Wrench {
                    force: raw.deflection_force_n[i].into(),
                    moment: raw.deflection_moment_nm[i].into(),
                },
                flags: SampleFlags::from_bits(flags),
            };
        }
        Ok(Self {
            stamp: stamp!(raw),
            samples,
            echo: ClockEcho {
                command_send_utime: raw.deflection_echo_command_send_us,
                receive_utime: raw.deflection_echo_receive_us,
                send_utime: raw.deflection_echo_send_us,
            },
            authenticity: authenticity!(raw),
        })
    }
}

impl Port for ObjectPose {
    fn to_raw(&self) -> Self::Raw {
        let (position, quaternion) = from_pose(&self.pose);
        Self::Raw {
            step: self.stamp.step,
            utime: self.stamp.utime,
            boot_id: self.stamp.boot_id,
            object_visible: self.visible.into(),
            object_r_from_o_position_m: position,
            object_r_from_o_quaternion_wxyz: quaternion,
            object_velocity_m_per_s: self.velocity.into(),
            object_angular_velocity_rad_per_s: self.angular_velocity.into(),
            object_position_sigma_m: self.position_sigma_m,
        }
    }

    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable> {
        Ok(Self {
            stamp: stamp!(raw),
            visible: to_bool("object_visible", raw.object_visible)?,
            pose: to_pose(
                raw.object_r_from_o_position_m,
                raw.object_r_from_o_quaternion_wxyz,
            ),
            velocity: raw.object_velocity_m_per_s.into(),
            angular_velocity: raw.object_angular_velocity_rad_per_s.into(),
            position_sigma_m: raw.object_position_sigma_m,
        })
    }
}
