//! What is asked of an impact, and the answer.

use super::simulated::Simulated;
use controller::impact::bounce::second_impact_speed_ratio;
use controller::impact::quantity::SAMPLING_TIME;
use controller::impact::{ImpactError, Striker, Surface, TransientContact};
use serde::Serialize;

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// What to call it.
    pub name: String,
    /// What is struck, as the tool's shape makes it.
    pub surface: Surface,
    /// E* of footnote 9, Pa, where it is known.
    pub effective_modulus_pa: Option<f64>,
    /// Mass that strikes, kg.
    pub effective_mass_kg: f64,
    /// Speed towards the object, m/s.
    pub speed_m_per_s: f64,
    /// Sampling time of the force control, s.
    pub sampling_time_s: f64,
    /// Largest force that control lets pass after the impact, N, where it is known.
    pub controlled_peak_n: Option<f64>,
    /// Force that is allowed, N.
    pub allowed_force_n: Option<f64>,
    /// Indentation that may remain, m.
    pub allowed_remaining_depth_m: Option<f64>,
    /// The contact with a person.
    pub transient: Option<TransientQuestion>,
}

/// What is asked of a contact with a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransientQuestion {
    /// Effective mass of the robot at the contact, kg.
    pub robot_mass_kg: f64,
    /// Effective mass of the body region, kg.
    pub body_mass_kg: f64,
    /// Stiffness of the contact, N/m.
    pub body_stiffness_n_per_m: f64,
    /// Force that is allowed there, N.
    pub allowed_force_n: Option<f64>,
}

/// The answer; keys with units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// What to call it.
    pub name: String,
    /// n of (13).
    pub exponent: f64,
    /// c_in of (13), N/m^n.
    pub indentation_n_per_m: f64,
    /// c_re / c_in.
    pub rebound_ratio: f64,
    /// E*, Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_modulus_pa: Option<f64>,
    /// Mass that strikes, kg.
    pub effective_mass_kg: f64,
    /// Speed towards the object, m/s.
    pub speed_m_per_s: f64,
    /// (17) for any n, N.
    pub peak_force_n: f64,
    /// (16) for any n, m.
    pub maximum_depth_m: f64,
    /// m.
    pub remaining_depth_m: f64,
    /// tau_in, s.
    pub indentation_time_s: f64,
    /// tau_re, s.
    pub rebound_time_s: f64,
    /// tau_cit = tau_in + tau_re, s.
    pub characteristic_time_s: f64,
    /// Speed after over speed before.
    pub restitution: f64,
    /// Speed of the second impact over that of the first, for a tool on a compliant sensor that moves on.
    pub second_impact_speed_ratio: f64,
    /// N s.
    pub impulse_ns: f64,
    /// J.
    pub lost_energy_j: f64,
    /// Sampling time of the force control, s.
    pub sampling_time_s: f64,
    /// Whether the impact lasts longer than a sampling time, so that control may act on it at all.
    pub controllable: bool,
    /// Largest force that control lets pass, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controlled_peak_n: Option<f64>,
    /// Which of the two forces is the larger one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<Limit>,
    /// N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allowed_force_n: Option<f64>,
    /// The highest speed for it, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_for_allowed_force_m_per_s: Option<f64>,
    /// m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allowed_remaining_depth_m: Option<f64>,
    /// The highest speed for it, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_for_allowed_remaining_depth_m_per_s: Option<f64>,
    /// Another model with another purpose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transient_contact: Option<TransientReport>,
    /// What a simulated run says to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulated: Option<Simulated>,
    /// The surface, to draw it.
    #[serde(skip)]
    pub surface: Surface,
}

/// The limit that matters (the paper's conclusion).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// The force of the impact, which cannot be controlled.
    Impact,
    /// The peak of the controlled force.
    Control,
}

/// The contact with a person.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TransientReport {
    /// What it is not.
    pub notice: &'static str,
    /// kg.
    pub robot_mass_kg: f64,
    /// kg.
    pub body_mass_kg: f64,
    /// mu, kg.
    pub reduced_mass_kg: f64,
    /// k, N/m.
    pub body_stiffness_n_per_m: f64,
    /// At the speed asked for, N.
    pub force_n: f64,
    /// N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allowed_force_n: Option<f64>,
    /// v = F / sqrt(mu k), m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_for_allowed_force_m_per_s: Option<f64>,
}

/// What the second output is not.
pub const NOTICE: &str =
    "an estimate in the manner of ISO/TS 15066, no certification; limits come from the standard that applies";

impl Question {
    /// The answer.
    pub fn answer(&self) -> Result<Report, ImpactError> {
        let (surface, mass, speed) = (self.surface, self.effective_mass_kg, self.speed_m_per_s);
        let sampling_time_s = SAMPLING_TIME.check(self.sampling_time_s)?;
        let impact = surface.struck_by(&Striker::new(mass, speed)?);
        let for_force = self
            .allowed_force_n
            .map(|force| surface.speed_for_force_m_per_s(mass, force));
        let for_mark = self
            .allowed_remaining_depth_m
            .map(|depth| surface.speed_for_remaining_depth_m_per_s(mass, depth));
        Ok(Report {
            name: self.name.clone(),
            exponent: surface.law.exponent(),
            indentation_n_per_m: surface.law.coefficient_n_per_m_n(),
            rebound_ratio: surface.rebound.ratio(),
            effective_modulus_pa: self.effective_modulus_pa,
            effective_mass_kg: mass,
            speed_m_per_s: speed,
            peak_force_n: impact.peak_force_n,
            maximum_depth_m: impact.maximum_depth_m,
            remaining_depth_m: impact.remaining_depth_m,
            indentation_time_s: impact.indentation_time_s,
            rebound_time_s: impact.rebound_time_s,
            characteristic_time_s: impact.characteristic_time_s(),
            restitution: impact.restitution,
            second_impact_speed_ratio: second_impact_speed_ratio(&surface.rebound, surface.law.exponent()),
            impulse_ns: impact.impulse_ns,
            lost_energy_j: impact.lost_energy_j,
            sampling_time_s,
            controllable: impact.characteristic_time_s() > sampling_time_s,
            controlled_peak_n: self.controlled_peak_n,
            limit: self
                .controlled_peak_n
                .map(|peak| limit(impact.peak_force_n, peak)),
            allowed_force_n: self.allowed_force_n,
            speed_for_allowed_force_m_per_s: for_force.transpose()?,
            allowed_remaining_depth_m: self.allowed_remaining_depth_m,
            speed_for_allowed_remaining_depth_m_per_s: for_mark.transpose()?,
            transient_contact: self.transient.map(|asked| asked.answer(speed)).transpose()?,
            simulated: None,
            surface,
        })
    }
}

impl Report {
    /// The report with what a simulated run says to it: the run's own impact, which may be slower than what was asked
    /// for, is what its controlled force is compared with.
    pub fn with_simulation(self, simulated: Simulated) -> Self {
        let controlled_peak_n = self.controlled_peak_n.unwrap_or(simulated.controlled_peak_n);
        Self {
            controlled_peak_n: Some(controlled_peak_n),
            limit: Some(limit(simulated.peak_force_n, controlled_peak_n)),
            simulated: Some(simulated),
            ..self
        }
    }

    /// The impact that the controlled force is compared with, N.
    pub fn compared_peak_n(&self) -> f64 {
        self.simulated
            .map_or(self.peak_force_n, |simulated| simulated.peak_force_n)
    }
}

fn limit(impact_peak_n: f64, controlled_peak_n: f64) -> Limit {
    if impact_peak_n > controlled_peak_n {
        Limit::Impact
    } else {
        Limit::Control
    }
}

impl TransientQuestion {
    fn answer(&self, speed: f64) -> Result<TransientReport, ImpactError> {
        let contact =
            TransientContact::new(self.robot_mass_kg, self.body_mass_kg, self.body_stiffness_n_per_m)?;
        let limit = self
            .allowed_force_n
            .map(|force| contact.speed_for_force_m_per_s(force));
        Ok(TransientReport {
            notice: NOTICE,
            robot_mass_kg: self.robot_mass_kg,
            body_mass_kg: self.body_mass_kg,
            reduced_mass_kg: contact.reduced_mass_kg(),
            body_stiffness_n_per_m: self.body_stiffness_n_per_m,
            force_n: contact.force_n(speed)?,
            allowed_force_n: self.allowed_force_n,
            speed_for_allowed_force_m_per_s: limit.transpose()?,
        })
    }
}
