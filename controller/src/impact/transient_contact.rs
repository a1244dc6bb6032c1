//! Transient contact of a robot with a person who can recoil, as used for power and force limiting.
//!
//! **Not a certification.** ISO/TS 15066:2016, annex A, has this model and the limits that go with it; which of them
//! apply, and whether they are kept, is for measurements and a risk assessment to say. No limit and no body region is
//! built in: they come from the edition that applies.

use super::quantity::{BODY_STIFFNESS, FORCE, ImpactError, MASS, SPEED};

/// Two bodies and a linear spring between them.
///
/// The energy of their relative motion, `mu v^2 / 2` with the reduced mass `mu = (1/m_H + 1/m_R)^-1`, goes into the
/// spring, `F^2 / (2 k)`: it is (17) with k for `2 R E*` and mu for M, for a partner that is free to recoil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransientContact {
    reduced_mass: f64,
    stiffness: f64,
}

impl TransientContact {
    /// With the effective masses of the robot at the contact and of the body region (kg), and the contact's stiffness
    /// k (N/m).
    pub fn new(robot_mass_kg: f64, body_mass_kg: f64, stiffness_n_per_m: f64) -> Result<Self, ImpactError> {
        let (robot, body) = (MASS.check(robot_mass_kg)?, MASS.check(body_mass_kg)?);
        Ok(Self {
            reduced_mass: 1.0 / (1.0 / robot + 1.0 / body),
            stiffness: BODY_STIFFNESS.check(stiffness_n_per_m)?,
        })
    }

    /// mu, kg.
    pub fn reduced_mass_kg(&self) -> f64 {
        self.reduced_mass
    }

    /// The relative speed `v = F / sqrt(mu k)` (m/s) at which the force reaches `force` N.
    pub fn speed_for_force_m_per_s(&self, force: f64) -> Result<f64, ImpactError> {
        Ok(FORCE.check(force)? / (self.reduced_mass * self.stiffness).sqrt())
    }

    /// The force `v sqrt(mu k)` (N) at the relative speed `speed` (m/s).
    pub fn force_n(&self, speed: f64) -> Result<f64, ImpactError> {
        Ok(SPEED.check(speed)? * (self.reduced_mass * self.stiffness).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::impact::{KicksLaw, Rebound, Striker, Surface};

    /// 10 kg against 0.6 kg with 75 N/mm: mu = 0.5660 kg, and 280 N at 1.359 m/s.
    #[test]
    fn it_is_the_impact_of_the_reduced_mass() {
        let contact = TransientContact::new(10.0, 0.6, 75e3).unwrap();
        assert!((contact.reduced_mass_kg() - 6.0 / 10.6).abs() < 1e-15);
        let speed = contact.speed_for_force_m_per_s(280.0).unwrap();
        assert!((speed - 1.359).abs() < 0.0005, "{speed}");
        assert!((contact.force_n(speed).unwrap() - 280.0).abs() < 1e-10);
        let surface = Surface {
            law: KicksLaw::new(75e3, 1.0).unwrap(),
            rebound: Rebound::ELASTIC,
        };
        let impact = surface.struck_by(&Striker::new(contact.reduced_mass_kg(), speed).unwrap());
        assert!((impact.peak_force_n - 280.0).abs() < 1e-10);
    }

    #[test]
    fn what_is_no_contact_is_refused() {
        assert!(
            TransientContact::new(10.0, -0.6, 75e3).is_err()
                && TransientContact::new(10.0, 0.6, 0.0).is_err()
        );
    }
}
