//! A calibration as a run: what it needs of a scenario, and what its messages tell.
//!
//! Only what a real cell gives is used: the encoders (`ROBOT_STATE`), the sensor (`SENSOR_DEFLECTION`), and which rest
//! the controller says it is in (`CONTROLLER_STATUS`). No `SIM_*` channel, nothing of `[sensor]` and `[tool]`.

mod error;
mod report;

pub use error::CalibrateError;
pub use report::{Numbers, Quantity, Report, Value};

use crate::transcript::{self, Entry};
use controller::calibration::{Calibration, KnownTool, Rest, calibrate};
use controller::tilting::{RESTS, Tilting};
use nalgebra::Vector3;
use node::scenario::{Scenario, ScenarioError};
use spatial::kinematics::Axes;
use spatial::ports::{ControllerStatus, DeflectionSample, Deflections, Fault, RobotState, Role};
use spatial::{Deflection, Wrench};

/// Time after the last rest that a run lasts on, s.
const MARGIN_S: f64 = 0.5;

/// The overrides that make a scenario a calibration, from `overrides` of the user: its task, and, unless the user has
/// set it, a duration that is long enough.
pub fn overrides(
    overrides: &[String],
    read: impl Fn(&[String]) -> Result<Scenario, ScenarioError>,
) -> Result<Vec<String>, ScenarioError> {
    let kind = "task.kind=calibrate".to_owned();
    let with = |before: Option<String>| {
        let all = before.into_iter().chain(overrides.iter().cloned());
        all.chain([kind.clone()]).collect::<Vec<_>>()
    };
    let duration = format!("timing.duration_s={:.3}", needed_s(&read(&with(None))?));
    Ok(with(Some(duration)))
}

/// How long the calibration of `scenario` takes from its start on, s.
fn needed_s(scenario: &Scenario) -> f64 {
    scenario.task.standstill_s + tilting(scenario, &Axes::zeros()).duration_s() + MARGIN_S
}

/// The way of the calibration from `start` on.
fn tilting(scenario: &Scenario, start: &Axes) -> Tilting {
    let d = scenario.controller.tcp_in_s_m.into();
    Tilting::new(&scenario.task, d, &scenario.robot.kinematics().forward(start))
}

/// Whether the robot can tilt the tool as far as it is to.
pub fn check(scenario: &Scenario) -> Result<(), CalibrateError> {
    let start = scenario
        .start_axes()
        .map_err(|reason| CalibrateError::Unreachable { rest: 0, reason })?;
    let (kinematics, drives) = (scenario.robot.kinematics(), scenario.robot.drives());
    let tilting = tilting(scenario, &start);
    for rest in 0..RESTS {
        let axes = kinematics
            .reach(&tilting.rest_pose(rest))
            .map_err(|reason| CalibrateError::Unreachable { rest, reason })?;
        let (low, high) = (drives.axis_minimum_rad, drives.axis_maximum_rad);
        if let Some(axis) = (0..6).find(|&i| !(low[i]..=high[i]).contains(&axes[i])) {
            return Err(CalibrateError::AxisRange {
                rest,
                axis,
                angle_rad: axes[axis],
                minimum_rad: low[axis],
                maximum_rad: high[axis],
            });
        }
    }
    Ok(())
}

/// What a run of `scenario` tells of sensor and tool.
pub fn from_transcript(scenario: &Scenario, entries: &[Entry]) -> Result<Calibration, CalibrateError> {
    let known = KnownTool {
        mass_kg: Some(scenario.controller.tool_mass_kg).filter(|mass| *mass > 0.0),
        centre_of_mass_in_s_m: Some(Vector3::from(scenario.controller.tool_centre_of_mass_in_s_m))
            .filter(|centre| centre.norm() > 0.0),
    };
    Ok(calibrate(&rests(scenario, entries)?, &known)?)
}

/// What was measured in each rest.
pub fn rests(scenario: &Scenario, entries: &[Entry]) -> Result<Vec<Rest>, CalibrateError> {
    no_fault(entries)?;
    let mut means = [Means::default(); RESTS];
    let mut last = None;
    for status in transcript::messages::<ControllerStatus>(entries) {
        if let Some(rest) = usize::try_from(status.program_step)
            .ok()
            .filter(|&rest| rest < RESTS)
        {
            let mean = &mut means[rest];
            let start = mean.interval_us.map_or(status.stamp.utime, |(start, _)| start);
            mean.interval_us = Some((start, status.stamp.utime));
            last = Some(status.stamp.step);
        }
    }
    // The last rest is over once the controller has said anything after it.
    let complete = means[RESTS - 1].interval_us.is_some()
        && transcript::messages::<ControllerStatus>(entries).any(|status| Some(status.stamp.step) > last);
    if !complete {
        return Err(CalibrateError::TooShort {
            duration_s: scenario.timing.duration_s,
            needed_s: needed_s(scenario),
        });
    }
    for state in transcript::messages::<RobotState>(entries) {
        if let Some(mean) = within(&mut means, state.stamp.utime) {
            mean.axes += state.axis_position[0];
            mean.states += 1;
        }
    }
    let mut newest = i64::MIN;
    for message in transcript::messages::<Deflections>(entries) {
        for sample in message.samples.iter().rev() {
            if sample.utime > newest {
                newest = sample.utime;
                if let Some(mean) = within(&mut means, sample.utime) {
                    mean.add(sample);
                }
            }
        }
    }
    let rests = means.iter().enumerate();
    rests.map(|(i, mean)| mean.rest(scenario, i)).collect()
}

/// The sums over one rest.
#[derive(Clone, Copy, Debug, Default)]
struct Means {
    /// First and last instant at which the controller says that it rests, us.
    interval_us: Option<(i64, i64)>,
    axes: Axes,
    states: u32,
    deflection: Deflection,
    wrench: Wrench,
    samples: u32,
    saturated: bool,
    /// Samples without a measured wrench.
    unweighed: u32,
}

/// The rest in whose interval `utime` is.
fn within(means: &mut [Means], utime: i64) -> Option<&mut Means> {
    means.iter_mut().find(|mean| {
        mean.interval_us
            .is_some_and(|(first, last)| (first..=last).contains(&utime))
    })
}

impl Means {
    fn add(&mut self, sample: &DeflectionSample) {
        if !sample.flags.valid {
            return;
        }
        self.deflection = self.deflection + sample.deflection;
        self.wrench.force += sample.wrench.force;
        self.wrench.moment += sample.wrench.moment;
        self.samples += 1;
        self.saturated |= sample.flags.saturated;
        self.unweighed += u32::from(!sample.flags.wrench_measured);
    }

    fn rest(&self, scenario: &Scenario, rest: usize) -> Result<Rest, CalibrateError> {
        if self.samples == 0 || self.states == 0 {
            return Err(CalibrateError::NoSamples { rest });
        }
        if self.saturated {
            return Err(CalibrateError::Saturated { rest });
        }
        let share = 1.0 / f64::from(self.samples);
        let axes = self.axes / f64::from(self.states);
        Ok(Rest {
            r_from_s: scenario.robot.kinematics().forward(&axes).rotation,
            deflection: self.deflection * share,
            wrench: (self.unweighed == 0).then(|| Wrench {
                force: self.wrench.force * share,
                moment: self.wrench.moment * share,
            }),
        })
    }
}

/// Whether robot and controller have done what they were to.
fn no_fault(entries: &[Entry]) -> Result<(), CalibrateError> {
    let states = transcript::messages::<RobotState>(entries);
    let statuses = transcript::messages::<ControllerStatus>(entries);
    let told = states
        .map(|state| (state.stamp.step, Role::Robot, state.fault))
        .chain(statuses.map(|status| (status.stamp.step, Role::Controller, status.fault)));
    match told.filter(|(.., fault)| *fault != Fault::None).min() {
        Some((tick, node, fault)) => Err(CalibrateError::Faulty { node, fault, tick }),
        None => Ok(()),
    }
}
