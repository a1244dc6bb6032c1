//! What a log tells: figures, what is missing, how the clocks differ, how long messages took. Any log will do, one recorded
//! on real devices included.

mod channels;
mod clocks;
mod figures;
mod page;
mod text;
mod timing;

pub use channels::Channel;
pub use clocks::Clock;
pub use figures::Figure;
pub use page::Headline;
pub use timing::{Health, Timing};

use crate::log::Log;
use crate::metrics::{ForceCurve, ForceFrom, Metrics, NoFigures, Recording};
use crate::transcript::{self, Entry};
use node::scenario::Scenario;
use spatial::ports::{ControllerStatus, ImpactAssessment, NodeStatus, Truth};

/// All that a log tells.
#[derive(Debug)]
pub struct Analysis {
    /// What was said, each message once.
    pub said: Vec<Entry>,
    /// The recorded forces, as the controller saw them, and what they are taken from; `None`: the log tells of none.
    pub recording: Option<(Recording, ForceCurve, ForceFrom)>,
    /// The channels, and what is missing on each.
    pub channels: Vec<Channel>,
    /// How far the devices' clocks are ahead of the controller's.
    pub clocks: Vec<Clock>,
    /// How long messages took, and what nodes say of themselves.
    pub timing: Timing,
    /// The impact as it was foreseen and measured.
    pub impact: Impact,
    /// Hash of the configuration that the nodes say they run with, where it is another one than the scenario's.
    pub other_configuration: Option<i64>,
}

/// The impact as the controller saw it coming, as it measured it, and as it was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impact {
    /// Just before the contact.
    pub foreseen: Option<ImpactAssessment>,
    /// Of the speed measured at the contact.
    pub measured: Option<ImpactAssessment>,
    /// Speed (m/s) of the tcp at the first contact, peak force (N) and indentation (m), as the truth has it.
    pub truth: Option<[f64; 3]>,
}

impl Analysis {
    /// Of `log`, recorded with `scenario`.
    pub fn new(scenario: &Scenario, log: &Log) -> Self {
        let said = log.said();
        let hash = transcript::messages::<NodeStatus>(&said)
            .map(|status| status.hello.configuration_hash)
            .find(|hash| *hash != scenario.hash());
        Self {
            recording: Recording::from_log(scenario, &said),
            channels: channels::of(&log.entries),
            clocks: clocks::of(&said),
            timing: timing::of(&said),
            impact: impact(&said),
            other_configuration: hash,
            said,
        }
    }

    /// The figures, if there are any.
    pub fn metrics(&self) -> Option<Result<Metrics, NoFigures>> {
        Some(self.recording.as_ref()?.0.metrics())
    }
}

/// What forces are taken from, in words.
fn source(from: ForceFrom) -> &'static str {
    match from {
        ForceFrom::Truth => "true, quasi-static (SIM_TRUTH)",
        ForceFrom::Controller => {
            "as the controller measures it (CONTROLLER_STATUS), with the sensor's noise; what only a simulation knows is left out"
        }
        ForceFrom::Deflection => {
            "the deflection (SENSOR_DEFLECTION) by the assumed compliance, with the sensor's noise; what only a simulation knows is \
             left out"
        }
    }
}

/// How long after the first contact its peak is looked for, s.
const PEAK_S: f64 = 0.02;

fn impact(said: &[Entry]) -> Impact {
    let mut impact = Impact::default();
    for status in transcript::messages::<ControllerStatus>(said) {
        if status.impact.effective_mass_kg <= 0.0 {
            continue;
        }
        if status.detection.contact_step < 0 {
            impact.foreseen = Some(status.impact);
        } else {
            impact.measured = Some(status.impact);
            break;
        }
    }
    for truth in transcript::messages::<Truth>(said) {
        let since_s = truth.stamp.step as f64 * spatial::TICK_S - truth.first_contact_time_s;
        if truth.first_contact_time_s < 0.0 || since_s > PEAK_S {
            continue;
        }
        let [speed, peak, depth] = impact.truth.get_or_insert_default();
        *speed = truth.first_contact_speed_m_per_s;
        *peak = peak.max(truth.contact_force_peak_n);
        *depth = depth.max(truth.indentation_m);
    }
    if impact.measured.is_none() {
        // Nothing was met.
        impact.foreseen = None;
    }
    impact
}

#[cfg(test)]
mod tests;
