//! The standard law of industrial robots: pd or admittance control.

use crate::contact::{Aim, ContactSample};
use node::scenario;

/// Paper (1): `x_c(k) = x_c(k-1) + K (f(k) - f_d) + D (f(k) - f(k-1))`, on the contact's normal.
///
/// The distant-sensor extension (the posture of section III-B) acts on the other degrees of freedom; see
/// [`crate::posture`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pd {
    proportional_m_per_n: f64,
    derivative_m_per_n: f64,
    desired_force_n: f64,
    newest: Option<ContactSample>,
    /// x_c(k-1) and f(k-1).
    previous: Option<(f64, f64)>,
}

impl Pd {
    /// No contact yet.
    pub fn new(parameters: &scenario::Pd, aim: Aim) -> Self {
        Self {
            proportional_m_per_n: parameters.proportional_m_per_n,
            derivative_m_per_n: parameters.derivative_m_per_n,
            desired_force_n: aim.desired_force_n,
            newest: None,
            previous: None,
        }
    }

    /// Take one sample in contact.
    pub fn take(&mut self, sample: &ContactSample) {
        self.newest = Some(*sample);
    }

    /// The next set-point x_c (m). The law takes over from `commanded`, the last set-point of the approach; the
    /// force is positive when the environment pushes the tool back, along which direction the set-point retreats.
    pub fn set_point(&mut self, commanded: f64) -> f64 {
        let Some(ContactSample { force_n, .. }) = self.newest else {
            return commanded;
        };
        let (x_c, previous_force_n) = self.previous.unwrap_or((commanded, force_n));
        let x_c = x_c
            + (self.proportional_m_per_n * (force_n - self.desired_force_n)
                + self.derivative_m_per_n * (force_n - previous_force_n));
        self.previous = Some((x_c, force_n));
        x_c
    }

    /// Where the newest sample met the object, m.
    pub fn object_height_m(&self) -> Option<f64> {
        self.newest.map(|sample| sample.object_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_term_of_equation_1() {
        let gains = scenario::Pd {
            proportional_m_per_n: 2e-6,
            derivative_m_per_n: 30e-6,
        };
        let mut pd = Pd::new(
            &gains,
            Aim {
                desired_force_n: 10.0,
                compliance_m_per_n: 28e-6,
            },
        );
        let mut feel = |force_n: f64| {
            pd.take(&ContactSample {
                force_n,
                ..Default::default()
            });
            pd.set_point(0.5)
        };
        let first = feel(1.0);
        assert!((first - (0.5 + 2e-6 * -9.0)).abs() < 1e-15);
        let second = feel(4.0);
        assert!((second - (first + 2e-6 * -6.0 + 30e-6 * 3.0)).abs() < 1e-15);
        let third = feel(4.0);
        assert!((third - (second + 2e-6 * -6.0)).abs() < 1e-15);
    }
}
