//! Rows from messages.

use super::{
    ClockRow, ControllerRow, DetectionRow, ImpactRow, NodeRow, ObjectRow, Percentiles, RobotRow, SensorRow,
    Snapshot,
};
use crate::program::words;
use crate::up::unpadded;
use crate::watch::View;
use crate::watch::points::normal_force_n;
use crate::watch::stream::Stream;
use node::greeting::role_name;
use node::peers::SILENT;
use spatial::TICK_S;
use spatial::ports::{
    ControllerStatus, Deflections, Fault, Latencies, NodeStatus, ObjectPose, ParameterAnswer, RobotState,
    Role, Stamp, TaskParameters,
};
use std::time::Instant;

/// What the bits of `controller_limits` mean.
const LIMITS: [&str; 20] = [
    "lead",
    "velocity",
    "acceleration",
    "workspace",
    "axis",
    "deflection",
    "drift",
    "force",
    "seek",
    "collision force x",
    "collision force y",
    "collision force z",
    "collision moment x",
    "collision moment y",
    "collision moment z",
    "step failed: time",
    "step failed: search",
    "step failed: tolerance",
    "gain lowered",
    "hold",
];

fn fault(fault: Fault) -> Option<String> {
    (fault != Fault::None).then(|| words(fault.name()))
}

impl Snapshot {
    pub(in crate::watch) fn new(nodes: Vec<NodeRow>, view: &View, now: Instant) -> Self {
        Self {
            nodes,
            controller: view
                .controller
                .as_ref()
                .map(|(status, heard)| ControllerRow::new(status, *heard, now)),
            robot: view.robot.as_ref().map(|(state, _)| RobotRow::from(state)),
            sensor: view.sensor.as_ref().map(|(sensor, _)| SensorRow::from(sensor)),
            object: view.object.as_ref().map(|(object, _)| ObjectRow::from(object)),
        }
    }
}

impl NodeRow {
    /// Of a role that nobody plays.
    pub(in crate::watch) fn unheard(role: Role) -> Self {
        Self {
            node: role_name(role),
            host: String::new(),
            state: "not heard".to_owned(),
            fault: None,
            age_s: None,
            silent: true,
            rate_hz: 0.0,
            loss_ratio: 0.0,
            lost: 0,
            dropped: 0,
            kernel_dropped: None,
            refused: 0,
            missed: 0,
            answer_s: Percentiles::default(),
            lateness_s: Percentiles::default(),
            round_trip_s: Percentiles::default(),
            age_at_use_s: Percentiles::default(),
            clocks: Vec::new(),
            slip_s: 0.0,
            realtime_rights: false,
            authenticated: false,
            lockstep: false,
        }
    }

    pub(in crate::watch) fn new(
        status: &NodeStatus,
        heard: Instant,
        stream: Option<&Stream>,
        now: Instant,
    ) -> Self {
        let heard = stream.map_or(heard, |stream| stream.heard.max(heard));
        let age = now.saturating_duration_since(heard);
        let link = &status.link;
        let clocks = ["robot", "sensor"].into_iter().enumerate();
        let measured = |i: &usize| status.role == Role::Controller && status.clock_bound_s[*i] > 0.0;
        Self {
            node: role_name(status.role),
            host: unpadded(&status.host),
            state: words(status.state.name()),
            fault: fault(status.fault),
            age_s: Some(age.as_secs_f64()),
            silent: age >= SILENT,
            rate_hz: stream.map_or(0.0, |stream| stream.rate_hz(now)),
            loss_ratio: stream.map_or(0.0, |stream| stream.loss_ratio(now)),
            lost: link.lost,
            dropped: link.dropped,
            kernel_dropped: (link.kernel_dropped >= 0).then_some(link.kernel_dropped),
            refused: link.undecodable.saturating_add(link.refused),
            missed: link.missed,
            answer_s: status.answer.into(),
            lateness_s: status.lateness.into(),
            round_trip_s: status.round_trip.into(),
            age_at_use_s: status.age.into(),
            clocks: clocks
                .filter(|(i, _)| measured(i))
                .map(|(i, whose)| ClockRow {
                    whose,
                    offset_s: status.clock_offset_s[i],
                    bound_s: status.clock_bound_s[i],
                })
                .collect(),
            slip_s: status.slip_s,
            realtime_rights: status.realtime,
            authenticated: status.authenticated,
            lockstep: Stamp::lockstep(0, status.hello.seed, status.role).boot_id == status.stamp.boot_id,
        }
    }
}

impl From<Latencies> for Percentiles {
    fn from(latencies: Latencies) -> Self {
        Self {
            p50: latencies.p50_s,
            p99: latencies.p99_s,
            p999: latencies.p999_s,
            max: latencies.max_s,
        }
    }
}

impl ControllerRow {
    fn new(status: &ControllerStatus, heard: Instant, now: Instant) -> Self {
        let age = now.saturating_duration_since(heard);
        let (detection, impact) = (&status.detection, &status.impact);
        let assessed = |value: f64| (value != 0.0).then_some(value);
        let bound = |(bit, name): (usize, &'static str)| (status.limits & (1 << bit) != 0).then_some(name);
        Self {
            time_s: status.stamp.step as f64 * TICK_S,
            age_s: age.as_secs_f64(),
            silent: age >= SILENT,
            phase: words(status.phase.name()),
            law: words(status.law.name()),
            fault: fault(status.fault),
            program_step: (status.program_step >= 0).then_some(status.program_step),
            limits: LIMITS.into_iter().enumerate().filter_map(bound).collect(),
            normal_force_n: normal_force_n(status),
            force_n: status.wrench.force.into(),
            moment_nm: status.wrench.moment.into(),
            desired_force_n: status.desired_wrench.force.into(),
            desired_moment_nm: status.desired_wrench.moment.into(),
            force_error_n: status.force_error_n,
            object_position_m: status
                .object_known
                .then(|| status.object_pose.translation.vector.into()),
            object_velocity_m_per_s: status.object_velocity.into(),
            tcp_position_m: status.tcp_pose.translation.vector.into(),
            tool_axis: (status.tcp_pose.rotation * nalgebra::Vector3::z()).into(),
            tare_translation_m: status.tare.translation.into(),
            detection: DetectionRow {
                statistic_n: detection.statistic_n,
                threshold_n: detection.threshold_n,
                contact_time_s: (detection.contact_step >= 0)
                    .then_some(detection.contact_step as f64 * TICK_S),
            },
            impact: ImpactRow {
                speed_m_per_s: impact.speed_m_per_s,
                speed_limit_m_per_s: assessed(impact.speed_limit_m_per_s),
                effective_mass_kg: impact.effective_mass_kg,
                peak_force_n: impact.peak_force_n,
                maximum_depth_m: impact.maximum_depth_m,
                characteristic_time_s: impact.characteristic_time_s,
            },
            gain_margin: assessed(status.gain_margin),
            phase_margin_rad: assessed(status.phase_margin_rad),
            oscillation_n: status.oscillation_n,
            answer: answer(status),
        }
    }
}

/// What the controller has answered last.
fn answer(status: &ControllerStatus) -> Option<String> {
    if status.task_answer == ParameterAnswer::None {
        return None;
    }
    let parameter = usize::try_from(status.task_parameter).ok();
    let about = parameter.and_then(|bit| TaskParameters::NAMES.get(bit));
    let word = words(status.task_answer.name());
    Some(match about {
        Some(name) => format!("{word}: {name} {}", status.task_limit),
        None => word,
    })
}

impl From<&RobotState> for RobotRow {
    fn from(state: &RobotState) -> Self {
        let fault = fault(state.fault).map(|fault| match state.fault_axis {
            axis @ 0.. => format!("{fault}, axis {axis}"),
            _ => fault,
        });
        Self {
            mode: words(state.mode.name()),
            fault,
            missed_commands: state.missed_commands,
        }
    }
}

impl From<&Deflections> for SensorRow {
    fn from(deflections: &Deflections) -> Self {
        let newest = &deflections.samples[0];
        Self {
            valid: deflections
                .samples
                .iter()
                .filter(|sample| sample.flags.valid)
                .count(),
            saturated: newest.flags.saturated,
            translation_m: newest.deflection.translation.into(),
            rotation_rad: newest.deflection.rotation.into(),
        }
    }
}

impl From<&ObjectPose> for ObjectRow {
    fn from(object: &ObjectPose) -> Self {
        Self {
            visible: object.visible,
            position_m: object.pose.translation.vector.into(),
            sigma_m: object.position_sigma_m,
        }
    }
}
