//! The paper's task description taken literally, sample by sample.

use crate::contact::{Aim, ContactSample};

/// Paper (2): `x_d(k) = x_a(k) + C (f(k) - f_d)`, commanded as it is.
///
/// Validity: where the actual pose is that of the link. With elastic gears the encoders see the motor, and the law
/// is unstable unless the gears are well damped (PLANT.md section 7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Literal {
    aim: Aim,
    newest: Option<ContactSample>,
}

impl Literal {
    /// No contact yet.
    pub fn new(aim: Aim) -> Self {
        Self { aim, newest: None }
    }

    /// Take one sample in contact.
    pub fn take(&mut self, sample: &ContactSample) {
        self.newest = Some(*sample);
    }

    /// The next set-point (m); `held` before the first sample.
    pub fn set_point(&self, held: f64) -> f64 {
        let Aim {
            desired_force_n,
            compliance_m_per_n,
        } = self.aim;
        self.newest.map_or(
            held,
            |ContactSample {
                 actual_m, force_n, ..
             }| { actual_m + compliance_m_per_n * (force_n - desired_force_n) },
        )
    }

    /// x_o of the newest sample, m.
    pub fn object_height_m(&self) -> Option<f64> {
        self.newest.map(|sample| sample.object_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equation_2() {
        let mut law = Literal::new(Aim {
            desired_force_n: 10.0,
            compliance_m_per_n: 28e-6,
        });
        assert_eq!(law.set_point(0.5), 0.5);
        law.take(&ContactSample {
            object_m: 0.1,
            actual_m: 0.099_9,
            force_n: 3.0,
        });
        assert!((law.set_point(0.5) - (0.099_9 - 28e-6 * 7.0)).abs() < 1e-15);
    }
}
