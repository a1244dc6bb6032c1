//! The first impact of a simulated run against its prediction.

use super::scenario::{NoQuestion, question};
use crate::in_process::{self, Tick};
use crate::metrics::{NoFigures, Recording};
use controller::impact::{Striker, Surface};
use node::scenario::Scenario;
use serde::Serialize;
use spatial::TICK_S;
use spatial::ports::{ControllerPhase, ControllerStatus, Truth};

/// What a run says to the prediction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Simulated {
    /// The tcp's true speed towards the object at the first contact, m/s.
    pub contact_speed_m_per_s: f64,
    /// True peak force of the first impact, N.
    pub peak_force_n: f64,
    /// What the assessment predicts for that speed, N.
    pub predicted_peak_n: f64,
    /// Largest force after the impact as the tcp's deflection shows it, N: what control lets pass.
    pub controlled_peak_n: f64,
    /// What the controller has said of it; `null` if it has not noticed the contact.
    pub controller: Option<Assessed>,
}

/// What the controller has said of the impact, with what it assumes and measures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Assessed {
    /// Whether the allowed force of the impact has slowed the approach.
    pub slowed: bool,
    /// Speed in the last cycle before contact, m/s.
    pub approach_speed_m_per_s: f64,
    /// Speed that it has measured at the contact, m/s.
    pub contact_speed_m_per_s: f64,
    /// The peak for that speed, N.
    pub peak_force_n: f64,
}

/// Why there is no comparison.
#[derive(Debug, thiserror::Error)]
pub enum NoComparison {
    /// The scenario is no question.
    #[error(transparent)]
    NoQuestion(#[from] NoQuestion),
    /// The run gave no figures.
    #[error("the simulated run gave no figures: {0}")]
    NoFigures(#[from] NoFigures),
}

impl Simulated {
    /// Simulated over predicted peak, less one.
    pub fn deviation(&self) -> f64 {
        self.peak_force_n / self.predicted_peak_n - 1.0
    }

    /// Run `scenario` in this process and compare.
    pub fn of(scenario: &Scenario) -> Result<Self, NoComparison> {
        let question = question(scenario, "")?;
        let mut recording = Recording::new(scenario);
        let mut first = FirstImpact::new(question.surface, question.effective_mass_kg);
        in_process::run(scenario, |tick| {
            recording.observe(tick);
            first.observe(tick);
        });
        let metrics = recording.metrics()?;
        Ok(first.compared(metrics.peak_n))
    }
}

/// The first impact of a run, tick by tick.
#[derive(Clone, Copy, Debug)]
pub struct FirstImpact {
    surface: Surface,
    mass_kg: f64,
    contact_speed_m_per_s: f64,
    peak_force_n: f64,
    slowed: bool,
    approach_speed_m_per_s: f64,
    assessed: Option<Assessed>,
}

/// The bit of `ControllerStatus::limits` that says that the approach is slowed.
const LIMIT_VELOCITY: i32 = 2;

impl FirstImpact {
    /// Of `mass_kg` on `surface`.
    pub fn new(surface: Surface, mass_kg: f64) -> Self {
        Self {
            surface,
            mass_kg,
            contact_speed_m_per_s: 0.0,
            peak_force_n: 0.0,
            slowed: false,
            approach_speed_m_per_s: 0.0,
            assessed: None,
        }
    }

    /// Take what the next tick tells.
    pub fn observe(&mut self, tick: &Tick) {
        self.truth(&tick.sensor.truth);
        if let Some(outputs) = &tick.controller {
            self.status(&outputs.status);
        }
    }

    fn status(&mut self, status: &ControllerStatus) {
        let impact = &status.impact;
        if status.phase == ControllerPhase::Approach {
            self.slowed |= status.limits & LIMIT_VELOCITY != 0;
            self.approach_speed_m_per_s = impact.speed_m_per_s;
        } else if status.detection.contact_step >= 0 {
            self.assessed.get_or_insert(Assessed {
                slowed: self.slowed,
                approach_speed_m_per_s: self.approach_speed_m_per_s,
                contact_speed_m_per_s: impact.speed_m_per_s,
                peak_force_n: impact.peak_force_n,
            });
        }
    }

    fn truth(&mut self, truth: &Truth) {
        let speed = truth.first_contact_speed_m_per_s;
        let Ok(striker) = Striker::new(self.mass_kg, speed) else {
            return;
        };
        self.contact_speed_m_per_s = speed;
        // The tick in which the impact ends is its last one.
        let end =
            truth.first_contact_time_s + self.surface.struck_by(&striker).characteristic_time_s() + TICK_S;
        if (truth.stamp.step as f64 * TICK_S) < end {
            self.peak_force_n = self.peak_force_n.max(truth.contact_force_peak_n);
        }
    }

    fn compared(&self, controlled_peak_n: f64) -> Simulated {
        let predicted = Striker::new(self.mass_kg, self.contact_speed_m_per_s)
            .map_or(0.0, |striker| self.surface.struck_by(&striker).peak_force_n);
        Simulated {
            contact_speed_m_per_s: self.contact_speed_m_per_s,
            peak_force_n: self.peak_force_n,
            predicted_peak_n: predicted,
            controlled_peak_n,
            controller: self.assessed,
        }
    }
}
