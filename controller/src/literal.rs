//! The paper's task description taken literally, sample by sample.

use crate::contact::{Aim, ContactSample};

/// Paper (2): `x_d(k) = x_a(k) + C (f(k) - f_d)`, commanded as it is; with (12), `x_a + C f = x_o`, and (9), (10) for
/// `C f_d` that is (11): `x_d = x_o - C f_d`.
///
/// Validity: where the actual pose is that of the link. With elastic gears the encoders see the motor, and the law
/// is unstable unless the gears are well damped (PLANT.md section 7).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Literal {
    newest: Option<ContactSample>,
}

impl Literal {
    /// Take one sample in contact.
    pub fn take(&mut self, sample: &ContactSample) {
        self.newest = Some(*sample);
    }

    /// The next set-point; `held` before the first sample.
    pub fn set_point(&self, aim: &Aim, held: f64) -> f64 {
        self.newest
            .map_or(held, |sample| sample.object - aim.displacement)
    }

    /// x_o of the newest sample, at rest.
    pub fn object(&self) -> Option<(f64, f64)> {
        self.newest.map(|sample| (sample.object, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equation_2() {
        let mut law = Literal::default();
        let aim = Aim::PAPER;
        assert_eq!(law.set_point(&aim, 0.5), 0.5);
        let (actual, wrench) = (0.099_9, 3.0);
        law.take(&ContactSample {
            time_s: 1.0,
            object: actual + aim.compliance * wrench,
            actual,
            wrench,
            ..Default::default()
        });
        let expected = actual + aim.compliance * (wrench - aim.wrench);
        assert!((law.set_point(&aim, 0.5) - expected).abs() < 1e-15);
    }
}
