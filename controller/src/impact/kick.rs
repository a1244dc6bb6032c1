//! The reaction force of a body that is penetrated.

use super::quantity::{COEFFICIENT, EXPONENT, ImpactError};

/// Paper (13): Kick's law `f_imp = c_in h^n`, quasi-static, in one dimension.
///
/// Validity: `0 < n <= 2`; `h >= 0`, increasing for `c_in` (the way out is [`super::rebound`]'s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KicksLaw {
    coefficient: f64,
    exponent: f64,
}

impl KicksLaw {
    /// With c_in in N/m^n and the exponent n.
    pub fn new(coefficient_n_per_m_n: f64, exponent: f64) -> Result<Self, ImpactError> {
        Ok(Self {
            coefficient: COEFFICIENT.check(coefficient_n_per_m_n)?,
            exponent: EXPONENT.check(exponent)?,
        })
    }

    /// c_in, N/m^n.
    pub fn coefficient_n_per_m_n(&self) -> f64 {
        self.coefficient
    }

    /// n.
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// The same law, stiffer by `ratio`.
    pub(super) fn stiffened(&self, ratio: f64) -> Self {
        Self {
            coefficient: self.coefficient * ratio,
            ..*self
        }
    }

    /// Paper (13): the force (N) at the indentation `h` (m); none outside the body.
    pub fn force_n(&self, h: f64) -> f64 {
        if h <= 0.0 {
            return 0.0;
        }
        self.coefficient * power(h, self.exponent)
    }

    /// The work (J) done down to the indentation `h` (m): the integral of (13), `c_in h^(n+1) / (n+1)`.
    pub fn energy_j(&self, h: f64) -> f64 {
        h * self.force_n(h) / (self.exponent + 1.0)
    }

    /// The indentation (m) down to which the work `energy` (J) is done.
    pub fn depth_of_energy_m(&self, energy: f64) -> f64 {
        let up = self.exponent + 1.0;
        power(up * energy / self.coefficient, 1.0 / up)
    }

    /// The indentation (m) at which the force is `force` (N).
    pub fn depth_of_force_m(&self, force: f64) -> f64 {
        power(force / self.coefficient, 1.0 / self.exponent)
    }
}

/// `base^exponent`; the exponents of a flat punch stay exact.
pub(super) fn power(base: f64, exponent: f64) -> f64 {
    if exponent == 1.0 {
        base
    } else if exponent == 0.5 {
        base.sqrt()
    } else {
        libm::pow(base, exponent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_force_is_the_slope_of_the_energy(c in 1e2..1e12, n in 0.05..2.0, h in 1e-7..1e-3) {
            let law = KicksLaw::new(c, n).unwrap();
            let d = 1e-4 * h;
            let slope = (law.energy_j(h + d) - law.energy_j(h - d)) / (2.0 * d);
            prop_assert!((slope / law.force_n(h) - 1.0).abs() < 1e-7);
        }

        #[test]
        fn depths_are_found_back(c in 1e2..1e12, n in 0.05..2.0, h in 1e-7..1e-3) {
            let law = KicksLaw::new(c, n).unwrap();
            prop_assert!((law.depth_of_energy_m(law.energy_j(h)) / h - 1.0).abs() < 1e-12);
            prop_assert!((law.depth_of_force_m(law.force_n(h)) / h - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn outside_the_body_there_is_no_force() {
        assert_eq!(KicksLaw::new(16e6, 1.5).unwrap().force_n(-1e-6), 0.0);
    }

    #[test]
    fn what_is_no_law_is_refused() {
        assert!(
            KicksLaw::new(16e6, 2.5)
                .unwrap_err()
                .to_string()
                .starts_with("exponent n is 2.5, outside 1e-6 to 2;")
        );
        assert!(KicksLaw::new(-1.0, 1.0).is_err() && KicksLaw::new(1.0, 0.0).is_err());
    }
}
