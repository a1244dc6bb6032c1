//! What of a run is kept for its figures.

use super::{EARLY_S, ForceFrom, Metrics, NoFigures, REBOUND_S, STEADY_S, WINDOW_S};
use crate::in_process::Tick;
use nalgebra::{UnitQuaternion, Vector3};
use node::scenario::Scenario;
use spatial::ports::{ControllerStatus, Fault, RobotState, Role, Truth};
use spatial::{Deflection, Pose, TICK_S, rotation};

/// The contact force over time as analysis sees it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForceCurve {
    /// Time after the first contact, s.
    pub time_s: Vec<f64>,
    /// Force, N.
    pub force_n: Vec<f64>,
}

/// The truth of a run, tick by tick, as far as analysis needs it.
#[derive(Clone, Debug)]
pub struct Recording {
    pub(super) duration_s: f64,
    standstill_ticks: i64,
    desired_force_n: f64,
    stiffness_n_per_m: f64,
    stiffness_nm_per_rad: f64,
    tcp_in_s: Vector3<f64>,
    /// Whether moments act at the tcp too.
    with_moments: bool,
    /// Between two samples, s.
    pub(super) step_s: f64,
    /// What the samples are taken from.
    pub(super) from: ForceFrom,
    /// The tool's orientation before the contact, if it is not that at the start.
    pub(super) before: Option<UnitQuaternion<f64>>,
    pub(super) first_contact_s: Option<f64>,
    first_fault: Option<FirstFault>,
    /// Tick of the sample that showed the contact to the controller.
    detected_tick: Option<i64>,
    pub(super) ticks: Vec<Sample>,
}

/// The fault that a robot or a controller has latched first; of one tick, the robot's, who speaks first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct FirstFault {
    tick: i64,
    node: Role,
    fault: Fault,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) time_s: f64,
    /// At the tcp.
    pub(super) deflection: Deflection,
    /// Of the real tcp, in r.
    pub(super) rotation: UnitQuaternion<f64>,
    pub(super) contact_force_n: f64,
    /// Largest within the last tick.
    pub(super) contact_force_peak_n: f64,
    /// Done on the object since start.
    pub(super) contact_work_j: f64,
}

impl Recording {
    /// Nothing recorded yet of a run of `scenario`.
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            duration_s: scenario.timing.duration_s,
            standstill_ticks: libm::floor(scenario.task.standstill_s / TICK_S) as i64,
            desired_force_n: scenario.task.pressing_force_n(),
            stiffness_n_per_m: scenario.sensor.stiffness_n_per_m,
            stiffness_nm_per_rad: scenario.sensor.stiffness_nm_per_rad,
            tcp_in_s: scenario.tool.tcp_in_s_m.into(),
            with_moments: scenario.task.force_controlled.dofs()[3..].contains(&true),
            step_s: TICK_S,
            from: ForceFrom::Truth,
            before: None,
            first_contact_s: None,
            first_fault: None,
            detected_tick: None,
            ticks: Vec::new(),
        }
    }

    /// How many samples there are.
    pub(super) fn len(&self) -> usize {
        self.ticks.len()
    }

    /// Take all that the next tick tells: the truth, and whether robot or controller have latched a fault.
    pub fn observe(&mut self, tick: &Tick) {
        self.push(&tick.sensor.truth);
        if let Some(state) = &tick.robot_state {
            self.note_robot(state);
        }
        if let Some(outputs) = &tick.controller {
            self.note_controller(&outputs.status);
        }
    }

    /// Take the truth of the next tick.
    pub fn push(&mut self, truth: &Truth) {
        if truth.first_contact_time_s >= 0.0 {
            self.first_contact_s = Some(truth.first_contact_time_s);
        }
        self.ticks.push(Sample {
            time_s: truth.stamp.step as f64 * TICK_S,
            deflection: truth.tcp_deflection,
            rotation: truth.tcp_pose.rotation,
            contact_force_n: truth.contact_force.z,
            contact_force_peak_n: truth.contact_force_peak_n,
            contact_work_j: truth.contact_work_j,
        });
    }

    /// What a spreadsheet needs, tick by tick: `time_s,force_n,contact_force_n,orientation_rad`, time after the
    /// first contact (after the start where there was none), force as [`Recording::force_curve`] has it.
    pub fn csv(&self) -> String {
        let mut text = String::from("time_s,force_n,contact_force_n,orientation_rad\n");
        let contact = self.first_contact_s.unwrap_or(0.0);
        let forces = self.forces().unwrap_or_default();
        let before = self
            .ticks
            .first()
            .map(|sample| sample.rotation)
            .unwrap_or_default();
        for (i, sample) in self.ticks.iter().enumerate() {
            let force = forces.get(i).copied().unwrap_or(0.0);
            let turned = rotation::log(&(sample.rotation * before.inverse())).norm();
            let time = sample.time_s - contact;
            text += &format!("{time:.6},{force:.6},{:.6},{turned:.9}\n", sample.contact_force_n);
        }
        text
    }

    /// Time of the first contact, s; `None`: there was none.
    pub fn first_contact_s(&self) -> Option<f64> {
        self.first_contact_s
    }

    /// The force over time after the first contact; `None` without contact.
    pub fn force_curve(&self) -> Option<ForceCurve> {
        let contact = self.first_contact_s?;
        Some(ForceCurve {
            time_s: self.ticks.iter().map(|sample| sample.time_s - contact).collect(),
            force_n: self.forces()?,
        })
    }

    /// The force (N) at each tick that the tcp's displacement by contact stands for, from the true motion before any
    /// signal chain; `None` before the standstill is recorded.
    ///
    /// The tcp is displaced along z of r by `s = z . R_ta (p_t - mean p_t at standstill)`; a force f there causes
    /// `s = f (1/K_p + (l . l_m) / K_phi)`, l the horizontal lever of the tool as it is, under which f turns it, and
    /// l_m its mean between hanging on the same link and now, about which it has turned.
    /// Where moments are controlled too, that displacement is also theirs: there the force is that of the sensor's own
    /// spring, `K_p z . R_ta (p_s - mean p_s)`, in which the tool's swing shows.
    /// Deviates from PLANT.md (`s_t,z / C_tcp,zz` with the lever d of the undeflected tool, 0.8 % off): this agrees
    /// with the true contact force at rest.
    fn forces(&self) -> Option<Vec<f64>> {
        if self.from != ForceFrom::Truth {
            return Some(self.ticks.iter().map(|sample| sample.contact_force_n).collect());
        }
        let standstill = self.standstill()?;
        let share = 1.0 / standstill.len() as f64;
        let hanging = standstill.iter().fold(Deflection::default(), |sum, sample| {
            sum + sample.deflection * share
        });
        let t_from_s = Pose::from_parts((-self.tcp_in_s).into(), UnitQuaternion::identity());
        let force = |sample: &Sample| {
            let r_from_ta = sample.rotation * rotation::exp(-sample.deflection.rotation);
            if self.with_moments {
                let at_s = |deflection: &Deflection| deflection.seen_from(&t_from_s).translation;
                let shift = r_from_ta * (at_s(&sample.deflection) - at_s(&hanging));
                return shift.z * self.stiffness_n_per_m;
            }
            let displacement = r_from_ta * (sample.deflection.translation - hanging.translation);
            let lever = sample.rotation * self.tcp_in_s;
            let before = r_from_ta * (rotation::exp(hanging.rotation) * self.tcp_in_s);
            let mean = (lever + before) * 0.5;
            let compliance =
                1.0 / self.stiffness_n_per_m + lever.xy().dot(&mean.xy()) / self.stiffness_nm_per_rad;
            displacement.z / compliance
        };
        Some(self.ticks.iter().map(force).collect())
    }

    /// The figures, if there was a contact with the whole judged window after it and nobody has latched a fault.
    pub fn metrics(&self) -> Result<Metrics, NoFigures> {
        if let Some(FirstFault { tick, node, fault }) = self.first_fault {
            return Err(NoFigures::Faulty { node, fault, tick });
        }
        let duration_s = self.duration_s;
        let contact_s = self.first_contact_s.ok_or(NoFigures::NoContact { duration_s })?;
        self.judge().ok_or(NoFigures::TooShort {
            contact_s,
            duration_s,
        })
    }

    fn judge(&self) -> Option<Metrics> {
        let curve = self.force_curve()?;
        let before = match self.before {
            Some(before) => before,
            None => self.standstill()?[0].rotation,
        };
        let start = curve.time_s.iter().position(|&t| t >= 0.0)?;
        let end = curve.time_s.iter().position(|&t| t > WINDOW_S)?;
        let desired = self.desired_force_n;
        let (time, force) = (&curve.time_s[start..end], &curve.force_n[start..end]);
        let error: Vec<f64> = force.iter().map(|f| f - desired).collect();
        let settled = |band: f64| match error.iter().rposition(|e| e.abs() > band * desired) {
            None => 0.0,
            Some(last) if last + 1 == error.len() => f64::NAN,
            Some(last) => time[last] + self.step_s,
        };
        let ticks = &self.ticks[start..end];
        let turn = |sample: &Sample| rotation::log(&(sample.rotation * before.inverse()));
        let steady = ticks
            .len()
            .checked_sub(libm::rint(STEADY_S / self.step_s) as usize)?;
        let steady = &ticks[steady..];
        let count = steady.len() as f64;
        let mean_n = mean_force(steady);
        let sigma_n = sigma(steady);
        let early = libm::rint(EARLY_S / self.step_s) as usize;
        // Of a log with gaps there may be fewer.
        let early_n = sigma(ticks.get(early..early + steady.len())?);
        let peak_n = force.iter().copied().fold(0.0, f64::max);
        let contact_s = self.first_contact_s?;
        // What only the truth tells.
        let known = |known: bool, value: f64| if known { value } else { f64::NAN };
        let true_only = |value| known(self.from == ForceFrom::Truth, value);
        // A deflection alone does not tell how the robot holds the tool.
        let turned = |value| known(self.from != ForceFrom::Deflection, value);
        let before_j = start
            .checked_sub(1)
            .map_or(0.0, |tick| self.ticks[tick].contact_work_j);
        Some(Metrics {
            peak_n,
            overshoot_ratio: (peak_n / desired - 1.0).max(0.0),
            settling_10_s: settled(0.10),
            settling_5_s: settled(0.05),
            settling_2_s: settled(0.02),
            iae_n_s: error.iter().map(|e| e.abs()).sum::<f64>() * self.step_s,
            impulse_above_n_s: error.iter().map(|e| e.max(0.0)).sum::<f64>() * self.step_s,
            steady_error_n: mean_n - desired,
            steady_sigma_n: sigma_n,
            ringing_ratio: if early_n > 0.0 { sigma_n / early_n } else { 0.0 },
            rebounds: true_only(rebounds(ticks)),
            detection_delay_s: true_only(
                self.detected_tick
                    .map_or(f64::NAN, |tick| tick as f64 * TICK_S - contact_s),
            ),
            impact_peak_n: true_only(ticks.iter().map(|s| s.contact_force_peak_n).fold(0.0, f64::max)),
            energy_j: true_only(ticks.last()?.contact_work_j - before_j),
            orientation_max_rad: turned(ticks.iter().map(|s| turn(s).norm()).fold(0.0, f64::max)),
            orientation_end_rad: turned((steady.iter().map(turn).sum::<Vector3<f64>>() / count).norm()),
        })
    }

    fn standstill(&self) -> Option<&[Sample]> {
        let end = usize::try_from(self.standstill_ticks).ok()?.min(self.ticks.len());
        (end > 0).then(|| &self.ticks[..end])
    }

    pub(super) fn note_robot(&mut self, state: &RobotState) {
        self.note(state.stamp.step, Role::Robot, state.fault);
    }

    pub(super) fn note_controller(&mut self, status: &ControllerStatus) {
        self.note(status.stamp.step, Role::Controller, status.fault);
        let tick = status.detection.contact_step;
        if tick >= 0 {
            self.detected_tick.get_or_insert(tick);
        }
    }

    fn note(&mut self, tick: i64, node: Role, fault: Fault) {
        if fault != Fault::None {
            let found = FirstFault { tick, node, fault };
            self.first_fault = Some(self.first_fault.map_or(found, |first| first.min(found)));
        }
    }
}

/// Mean of the true contact force, N.
fn mean_force(ticks: &[Sample]) -> f64 {
    ticks.iter().map(|sample| sample.contact_force_n).sum::<f64>() / ticks.len() as f64
}

/// Its standard deviation, N.
fn sigma(ticks: &[Sample]) -> f64 {
    let mean_n = mean_force(ticks);
    let deviations = ticks.iter().map(|sample| sample.contact_force_n - mean_n);
    (deviations.map(|deviation| deviation * deviation).sum::<f64>() / ticks.len() as f64).sqrt()
}

/// How often the tool has been in the air for longer than [`REBOUND_S`] before it met the object again.
fn rebounds(ticks: &[Sample]) -> f64 {
    let airborne = ticks.split(|sample| sample.contact_force_n > 0.0);
    // What follows the last contact is no rebound.
    let count = airborne
        .rev()
        .skip(1)
        .filter(|ticks| ticks.len() as f64 * TICK_S > REBOUND_S)
        .count();
    count as f64
}
