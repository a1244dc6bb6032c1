//! A mass strikes a body: what the energy says about depth, force and time, and the inverse questions.

use super::kick::KicksLaw;
use super::quantity::{EFFECTIVE_MASS, FORCE, ImpactError, REMAINING_DEPTH, SPEED};
use super::rebound::Rebound;
use std::f64::consts::PI;

/// What is struck: how it resists and how it rebounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Paper (13).
    pub law: KicksLaw,
    /// The way out.
    pub rebound: Rebound,
}

/// What strikes: M of (14) and v_0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Striker {
    mass: f64,
    speed: f64,
}

impl Striker {
    /// With the effective mass (kg) along the normal and the speed (m/s) towards the body.
    pub fn new(mass_kg: f64, speed_m_per_s: f64) -> Result<Self, ImpactError> {
        Ok(Self {
            mass: EFFECTIVE_MASS.check(mass_kg)?,
            speed: SPEED.check(speed_m_per_s)?,
        })
    }

    /// M, kg.
    pub fn mass_kg(&self) -> f64 {
        self.mass
    }

    /// v_0, m/s.
    pub fn speed_m_per_s(&self) -> f64 {
        self.speed
    }

    /// `M v_0^2 / 2`, J.
    pub fn energy_j(&self) -> f64 {
        0.5 * self.mass * self.speed * self.speed
    }
}

/// What comes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Largest force, N.
    pub peak_force_n: f64,
    /// Largest indentation, m.
    pub maximum_depth_m: f64,
    /// Indentation that remains, m.
    pub remaining_depth_m: f64,
    /// From the first contact to the largest indentation, s.
    pub indentation_time_s: f64,
    /// From there until the force vanishes, s.
    pub rebound_time_s: f64,
    /// Speed after over speed before.
    pub restitution: f64,
    /// Integral of the force over the whole impact, N s.
    pub impulse_ns: f64,
    /// Energy that stays in the body, J.
    pub lost_energy_j: f64,
}

impl Impact {
    /// tau_cit, the characteristic impact time: indentation and rebound, s.
    pub fn characteristic_time_s(&self) -> f64 {
        self.indentation_time_s + self.rebound_time_s
    }
}

impl Surface {
    /// Paper (13), (14): the impact of `striker`.
    ///
    /// (14) has the first integral `M v^2 / 2 + c_in h^(n+1) / (n+1) = M v_0^2 / 2`. Its end v = 0 is the maximum
    /// depth, (13) there the peak force. Separating it once more gives the time of the indentation,
    /// `tau_in = h_max / v_0 * integral from 0 to 1 of dx / sqrt(1 - x^(n+1))`, see [`time_factor`].
    pub fn struck_by(&self, striker: &Striker) -> Impact {
        let n = self.law.exponent();
        let depth = self.law.depth_of_energy_m(striker.energy_j());
        let restitution = self.rebound.restitution(n);
        let indentation_time_s = depth / striker.speed * time_factor(n);
        Impact {
            peak_force_n: self.law.force_n(depth),
            maximum_depth_m: depth,
            remaining_depth_m: depth * self.rebound.remaining_share(n),
            indentation_time_s,
            rebound_time_s: restitution * indentation_time_s,
            restitution,
            impulse_ns: striker.mass * striker.speed * (1.0 + restitution),
            lost_energy_j: striker.energy_j() * (1.0 - restitution * restitution),
        }
    }

    /// The highest speed (m/s) at which the force of a mass of `mass` kg stays within `force` N.
    pub fn speed_for_force_m_per_s(&self, mass: f64, force: f64) -> Result<f64, ImpactError> {
        let depth = self.law.depth_of_force_m(FORCE.check(force)?);
        self.speed_for_depth(mass, depth)
    }

    /// The highest speed (m/s) at which a mass of `mass` kg leaves no indentation deeper than `depth` m.
    pub fn speed_for_remaining_depth_m_per_s(&self, mass: f64, depth: f64) -> Result<f64, ImpactError> {
        let depth = REMAINING_DEPTH.check(depth)?;
        let share = self.rebound.remaining_share(self.law.exponent());
        if share == 0.0 {
            return Err(ImpactError::NothingRemains);
        }
        self.speed_for_depth(mass, depth / share)
    }

    /// The speed (m/s) whose energy takes a mass down to `depth` (m).
    fn speed_for_depth(&self, mass: f64, depth: f64) -> Result<f64, ImpactError> {
        let speed = (2.0 * self.law.energy_j(depth) / EFFECTIVE_MASS.check(mass)?).sqrt();
        if speed.is_normal() {
            Ok(speed)
        } else {
            Err(ImpactError::Unrepresentable("the highest speed"))
        }
    }
}

/// `integral from 0 to 1 of dx / sqrt(1 - x^(n+1))`: with `a = 1/(n+1)` it is
/// `a B(a, 1/2) = a sqrt(pi) Gamma(a) / Gamma(a + 1/2)`. pi/2 for n = 1; 1.4716 for a sphere.
pub fn time_factor(exponent: f64) -> f64 {
    if exponent == 1.0 {
        return 0.5 * PI;
    }
    let a = 1.0 / (exponent + 1.0);
    a * PI.sqrt() * libm::tgamma(a) / libm::tgamma(a + 0.5)
}
