//! `ROBOT_STATE` and `ROBOT_COMMAND`.

use super::{Port, authenticity, stamp, to_bool};
use crate::error::Unusable;
use spatial::ports::{ClockEcho, Command, Fault, RobotMode, RobotState};

impl Port for RobotState {
    fn to_raw(&self) -> Self::Raw {
        Self::Raw {
            step: self.stamp.step,
            utime: self.stamp.utime,
            boot_id: self.stamp.boot_id,
            robot_sample_count: self.sample_count,
            robot_axis_position_rad: self.axis_position.map(Into::into),
            robot_axis_velocity_rad_per_s: self.axis_velocity.into(),
            robot_axis_setpoint_rad: self.axis_setpoint.into(),
            robot_mode: self.mode.code(),
            robot_fault: self.fault.code(),
            robot_fault_axis: self.fault_axis,
            robot_command_step: self.command_step,
            robot_missed_commands: self.missed_commands,
            robot_echo_command_send_us: self.echo.command_send_utime,
            robot_echo_receive_us: self.echo.receive_utime,
            robot_echo_send_us: self.echo.send_utime,
            session: self.authenticity.session,
            seq: self.authenticity.seq,
            key_id: self.authenticity.key_id,
            tag: self.authenticity.tag,
        }
    }

    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable> {
        Ok(Self {
            stamp: stamp!(raw),
            sample_count: raw.robot_sample_count,
            axis_position: raw.robot_axis_position_rad.map(Into::into),
            axis_velocity: raw.robot_axis_velocity_rad_per_s.into(),
            axis_setpoint: raw.robot_axis_setpoint_rad.into(),
            mode: RobotMode::from_code(raw.robot_mode)?,
            fault: Fault::from_code(raw.robot_fault)?,
            fault_axis: raw.robot_fault_axis,
            command_step: raw.robot_command_step,
            missed_commands: raw.robot_missed_commands,
            echo: ClockEcho {
                command_send_utime: raw.robot_echo_command_send_us,
                receive_utime: raw.robot_echo_receive_us,
                send_utime: raw.robot_echo_send_us,
            },
            authenticity: authenticity!(raw),
        })
    }
}

impl Port for Command {
    fn to_raw(&self) -> Self::Raw {
        Self::Raw {
            step: self.stamp.step,
            utime: self.stamp.utime,
            boot_id: self.stamp.boot_id,
            command_enable: self.enable.into(),
            command_axis_position_rad: self.axis_position.map(Into::into),
            command_send_us: self.send_utime,
            session: self.authenticity.session,
            seq: self.authenticity.seq,
            key_id: self.authenticity.key_id,
            tag: self.authenticity.tag,
        }
    }

    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable> {
        Ok(Self {
            stamp: stamp!(raw),
            enable: to_bool("command_enable", raw.command_enable)?,
            axis_position: raw.command_axis_position_rad.map(Into::into),
            send_utime: raw.command_send_us,
            authenticity: authenticity!(raw),
        })
    }
}
