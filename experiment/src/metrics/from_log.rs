//! A recording out of what was said: with the truth where a simulation has told it, else by what was measured.

use super::recording::{ForceCurve, Recording, Sample};
use crate::transcript::{self, Entry};
use controller::transform::deflection_at_tcp;
use nalgebra::{UnitQuaternion, Vector3};
use node::scenario::Scenario;
use serde::Serialize;
use spatial::ports::{ControllerStatus, Deflections, RobotState};
use spatial::{Deflection, TICK_S, TICK_US, rotation};

/// Of the tool's orientation before the contact: how long it is averaged, and how long before it, s.
const BEFORE_S: f64 = 0.1;
/// A force is a contact from so many standard deviations of the standstill on, and from so much on, N.
const CONTACT_SIGMAS: f64 = 8.0;
const CONTACT_N: f64 = 0.5;

/// What forces are taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ForceFrom {
    /// `SIM_TRUTH`: the true motion of a simulated tool.
    Truth,
    /// `CONTROLLER_STATUS`: what the controller makes of the deflection, each cycle.
    Controller,
    /// `SENSOR_DEFLECTION` and the assumed compliance, along z of the sensor.
    Deflection,
}

impl Recording {
    /// The recording of the truth in `entries`, and the force that the controller measured over time after the
    /// first contact (after the start where there was none).
    pub fn from_transcript(scenario: &Scenario, entries: &[Entry]) -> (Self, ForceCurve) {
        let mut recording = Self::new(scenario);
        transcript::messages(entries).for_each(|truth| recording.push(&truth));
        recording.note_faults(entries);
        let measured = recording.by_controller(entries);
        (recording, measured)
    }

    /// The same of any log, and what its forces are taken from; `None`: it tells of no force.
    pub fn from_log(scenario: &Scenario, entries: &[Entry]) -> Option<(Self, ForceCurve, ForceFrom)> {
        let (recording, measured) = Self::from_transcript(scenario, entries);
        if recording.len() > 0 {
            return Some((recording, measured, ForceFrom::Truth));
        }
        let mut recording = Self::new(scenario);
        recording.from = if recording.take_statuses(scenario, entries) {
            ForceFrom::Controller
        } else if recording.take_deflections(scenario, entries) {
            ForceFrom::Deflection
        } else {
            return None;
        };
        recording.note_faults(entries);
        let measured = recording.by_controller(entries);
        let from = recording.from;
        Some((recording, measured, from))
    }

    fn note_faults(&mut self, entries: &[Entry]) {
        transcript::messages::<RobotState>(entries).for_each(|state| self.note_robot(&state));
        transcript::messages::<ControllerStatus>(entries).for_each(|status| self.note_controller(&status));
    }

    fn by_controller(&self, entries: &[Entry]) -> ForceCurve {
        let contact = self.first_contact_s.unwrap_or(0.0);
        let mut measured = ForceCurve::default();
        for status in transcript::messages::<ControllerStatus>(entries) {
            measured.time_s.push(status.stamp.step as f64 * TICK_S - contact);
            measured.force_n.push(status.detection.statistic_n);
        }
        measured
    }

    /// Time is that of the controller's ticks, the contact that of the sample that has shown it.
    fn take_statuses(&mut self, scenario: &Scenario, entries: &[Entry]) -> bool {
        for status in transcript::messages::<ControllerStatus>(entries) {
            let (time_s, force_n) = (status.stamp.step as f64 * TICK_S, status.detection.statistic_n);
            self.ticks
                .push(Sample::measured(time_s, force_n, status.tcp_pose.rotation));
            if status.detection.contact_step >= 0 && self.first_contact_s.is_none() {
                self.first_contact_s = Some(status.detection.contact_step as f64 * TICK_S);
            }
        }
        if self.ticks.is_empty() {
            return false;
        }
        self.step_s = scenario.timing.command_period_ticks as f64 * TICK_S;
        self.look_before();
        true
    }

    /// Time is that of the sensor's clock since its first sample; force is what the deflection beyond that of the
    /// standstill stands for.
    fn take_deflections(&mut self, scenario: &Scenario, entries: &[Entry]) -> bool {
        let mut samples = Vec::new();
        for deflections in transcript::messages::<Deflections>(entries) {
            let valid = deflections.samples.iter().filter(|sample| sample.flags.valid);
            samples.extend(valid.map(|sample| (sample.utime, sample.deflection)));
        }
        samples.sort_by_key(|(utime, _)| *utime);
        samples.dedup_by_key(|(utime, _)| *utime);
        let count = (scenario.task.standstill_s / TICK_S) as usize;
        let Some(standstill) = samples.get(..count.max(1)) else {
            return false;
        };
        let mean = standstill
            .iter()
            .fold(Deflection::default(), |sum, (_, deflection)| {
                sum + *deflection * (1.0 / standstill.len() as f64)
            });
        let lever = Vector3::from(scenario.tool.tcp_in_s_m);
        let controller = &scenario.controller;
        let compliance =
            controller.compliance_m_per_n + lever.xy().norm_squared() * controller.compliance_rad_per_nm;
        let force = |deflection: &Deflection| {
            deflection_at_tcp(&(*deflection - mean), lever).translation.z / compliance
        };
        let at_rest = standstill.iter().map(|(_, deflection)| force(deflection));
        let sigma_n = (at_rest.map(|f| f * f).sum::<f64>() / standstill.len() as f64).sqrt();
        let from_n = CONTACT_N.max(CONTACT_SIGMAS * sigma_n);
        let start = samples[0].0;
        for (utime, deflection) in &samples {
            let (time_s, force_n) = (
                (utime - start) as f64 / TICK_US as f64 * TICK_S,
                force(deflection),
            );
            let turned = rotation::exp(deflection.rotation);
            self.ticks.push(Sample::measured(time_s, force_n, turned));
            if force_n > from_n && self.first_contact_s.is_none() {
                self.first_contact_s = Some(time_s);
            }
        }
        self.look_before();
        true
    }

    /// The orientation just before the contact, and the length of what there is.
    fn look_before(&mut self) {
        self.duration_s = self.ticks.last().map_or(0.0, |sample| sample.time_s);
        let Some(contact_s) = self.first_contact_s else {
            return;
        };
        let within = contact_s - 2.0 * BEFORE_S..contact_s - BEFORE_S;
        let mut turns = self.ticks.iter().filter(|sample| within.contains(&sample.time_s));
        let Some(first) = turns.next() else { return };
        let turn = |sample: &Sample| rotation::log(&(sample.rotation * first.rotation.inverse()));
        let (sum, count) = turns.fold((Vector3::zeros(), 1.0), |(sum, count), sample| {
            (sum + turn(sample), count + 1.0)
        });
        self.before = Some(rotation::exp(sum / count) * first.rotation);
    }
}

impl Sample {
    fn measured(time_s: f64, force_n: f64, rotation: UnitQuaternion<f64>) -> Self {
        Self {
            time_s,
            deflection: Deflection::default(),
            rotation,
            contact_force_n: force_n,
            contact_force_peak_n: force_n,
            contact_work_j: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenarios::Source;
    use lcmtypes::Message;

    fn run() -> (Scenario, Vec<Entry>) {
        let scenario = Source::find("paper").unwrap().scenario(&[]).unwrap();
        let entries = transcript::in_process(&scenario).unwrap();
        (scenario, entries)
    }

    /// As a log of real devices has it.
    fn without(entries: &[Entry], more: &[&str]) -> Vec<Entry> {
        let kept = entries
            .iter()
            .filter(|entry| !entry.channel.starts_with("SIM_") && !more.contains(&entry.channel.as_str()));
        kept.cloned().collect()
    }

    #[test]
    fn what_is_measured_is_close_to_the_truth() {
        let (scenario, entries) = run();
        let (truth, ..) = Recording::from_log(&scenario, &entries).unwrap();
        let truth = truth.metrics().unwrap();
        let by_controller = without(&entries, &[]);
        let by_sensor = without(&entries, &[ControllerStatus::CHANNEL]);
        for (entries, expected) in [
            (by_controller, ForceFrom::Controller),
            (by_sensor, ForceFrom::Deflection),
        ] {
            let (recording, _, from) = Recording::from_log(&scenario, &entries).unwrap();
            assert_eq!(from, expected);
            let found = recording.metrics().unwrap();
            assert!(
                (found.peak_n - truth.peak_n).abs() < 1.5,
                "{from:?}: {} N",
                found.peak_n
            );
            assert!(
                found.steady_error_n.abs() < 0.3,
                "{from:?}: {} N",
                found.steady_error_n
            );
            // The sensor's noise of 0.6 N is in it.
            let excess = found.iae_n_s - truth.iae_n_s;
            assert!((0.0..0.3).contains(&excess), "{from:?}: {excess} N s more");
            assert!(found.impact_peak_n.is_nan() && found.energy_j.is_nan());
        }
    }

    #[test]
    fn a_log_without_forces_has_none() {
        let (scenario, entries) = run();
        let entries = without(&entries, &[ControllerStatus::CHANNEL, Deflections::CHANNEL]);
        assert!(Recording::from_log(&scenario, &entries).is_none());
    }
}
