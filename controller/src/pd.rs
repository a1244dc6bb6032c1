//! The standard law of industrial robots: pd or admittance control.

use crate::contact::{Aim, ContactSample};
use node::scenario;

/// Paper (1): `x_c(k) = x_c(k-1) + K (f(k) - f_d) + D (f(k) - f(k-1))`, along one degree of freedom.
///
/// The distant-sensor extension of section III is not the law's affair: with it, forces and coordinates are those of
/// the tcp and the other degrees of freedom take the posture ([`crate::posture`]); without it
/// (`controller.tcp_in_s_m = [0, 0, 0]` and the moments' degrees of freedom selected), those of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pd {
    /// K, m/N or rad/Nm.
    proportional: f64,
    /// D, m/N or rad/Nm.
    derivative: f64,
    /// Whether x_c starts from x_a at contact, not from x_c, which leads x_a in free motion (section II-C).
    resets: bool,
    newest: Option<ContactSample>,
    /// f(k-1).
    previous_wrench: Option<f64>,
}

impl Pd {
    /// No contact yet; the gains for the degree of freedom `dof`.
    pub fn new(parameters: &scenario::Pd, dof: usize, resets: bool) -> Self {
        let (proportional, derivative) = gains(parameters, dof);
        Self {
            proportional,
            derivative,
            resets,
            newest: None,
            previous_wrench: None,
        }
    }

    /// Go on with other gains, those of `parameters` for the degree of freedom `dof`.
    pub fn retune(&mut self, parameters: &scenario::Pd, dof: usize) {
        (self.proportional, self.derivative) = gains(parameters, dof);
    }

    /// Take one sample in contact.
    pub fn take(&mut self, sample: &ContactSample) {
        self.newest = Some(*sample);
    }

    /// The next set-point x_c. `commanded` is the one before, x_c(k-1): bounds that were put on it hold here too, so
    /// that nothing winds up. The force is positive when the environment pushes the tool back, along which direction
    /// the set-point retreats.
    pub fn set_point(&mut self, aim: &Aim, commanded: f64) -> f64 {
        let Some(ContactSample { actual, wrench, .. }) = self.newest else {
            return commanded;
        };
        let before = match self.previous_wrench {
            None if self.resets => actual,
            _ => commanded,
        };
        let change = wrench - self.previous_wrench.unwrap_or(wrench);
        self.previous_wrench = Some(wrench);
        before + (self.proportional * (wrench - aim.wrench) + self.derivative * change)
    }

    /// Where the newest sample met the object, at rest.
    pub fn object(&self) -> Option<(f64, f64)> {
        self.newest.map(|sample| (sample.object, 0.0))
    }
}

/// K and D for the degree of freedom `dof`.
fn gains(parameters: &scenario::Pd, dof: usize) -> (f64, f64) {
    if dof < 3 {
        (parameters.proportional_m_per_n, parameters.derivative_m_per_n)
    } else {
        (
            parameters.proportional_rad_per_nm,
            parameters.derivative_rad_per_nm,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AIM: Aim = Aim::PAPER;

    fn sample(wrench: f64) -> ContactSample {
        ContactSample {
            actual: 0.7,
            wrench,
            ..Default::default()
        }
    }

    #[test]
    fn each_term_of_equation_1() {
        let gains = scenario::Pd {
            proportional_m_per_n: 2e-6,
            derivative_m_per_n: 30e-6,
            proportional_rad_per_nm: 1e-3,
            derivative_rad_per_nm: 2e-3,
        };
        for (dof, p, d) in [(2, 2e-6, 30e-6), (4, 1e-3, 2e-3)] {
            let mut pd = Pd::new(&gains, dof, false);
            let mut commanded = 0.5;
            let mut expected = 0.5;
            for (wrench, change) in [(1.0, 0.0), (4.0, 3.0), (4.0, 0.0)] {
                pd.take(&sample(wrench));
                commanded = pd.set_point(&AIM, commanded);
                expected += p * (wrench - 10.0) + d * change;
                assert!(
                    (commanded - expected).abs() < 1e-15,
                    "dof {dof}: {commanded} {expected}"
                );
            }
        }
    }

    #[test]
    fn with_reset_the_first_set_point_starts_from_the_actual_pose() {
        let gains = scenario::Pd::default();
        let mut pd = Pd::new(&gains, 2, true);
        assert_eq!(pd.set_point(&AIM, 0.5), 0.5);
        pd.take(&sample(10.0));
        assert_eq!(pd.set_point(&AIM, 0.5), 0.7);
        assert_eq!(pd.set_point(&AIM, 0.6), 0.6);
    }
}
