//! From an indenter's shape and the materials to the constants of (13).

use super::kick::{KicksLaw, power};
use super::quantity::{EFFECTIVE_MODULUS, EXPONENT, FACTOR, HALF_ANGLE, ImpactError, LENGTH};

/// A family of rigid indenters of one shape, pressed into a half space of the effective modulus E*.
///
/// Paper IV-B: (13) holds for other shapes too, "but the determination of the coefficients becomes complex"; for
/// those that are published it is one line. E* is a pressure and n fixes the rest, so that a shape is a factor and an
/// exponent: `c_in = factor E* a^(2 - n)` with a length a (radius, side), or `c_in = factor E* tan(alpha)` with
/// the half angle alpha of a self-similar shape, n = 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    factor: f64,
    exponent: f64,
}

/// What makes one indenter of a family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dimension {
    /// A length, m.
    Length(f64),
    /// The angle between axis and flank, rad.
    HalfAngle(f64),
}

impl Shape {
    /// With the numerical factor and the exponent n.
    pub fn new(factor: f64, exponent: f64) -> Result<Self, ImpactError> {
        Ok(Self {
            factor: FACTOR.check(factor)?,
            exponent: EXPONENT.check(exponent)?,
        })
    }

    /// Paper (13) for the indenter of this `dimension`, with E* in Pa.
    pub fn law(&self, dimension: Dimension, effective_modulus_pa: f64) -> Result<KicksLaw, ImpactError> {
        let modulus = EFFECTIVE_MODULUS.check(effective_modulus_pa)?;
        let size = match dimension {
            Dimension::Length(length) => power(LENGTH.check(length)?, 2.0 - self.exponent),
            Dimension::HalfAngle(angle) => libm::tan(HALF_ANGLE.check(angle)?),
        };
        KicksLaw::new(self.factor * modulus * size, self.exponent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::impact::FlatPunch;

    #[test]
    fn a_flat_punch_is_the_papers() {
        let shape = Shape::new(2.0, 1.0).unwrap();
        let law = shape.law(Dimension::Length(0.008), 1e9).unwrap();
        assert_eq!(law, FlatPunch::new(0.008, 1e9).unwrap().law().unwrap());
    }

    /// Hertz: contact radius a = sqrt(R h) and mean pressure 4 E* a / (3 pi R).
    #[test]
    fn a_sphere_is_hertzs() {
        let (radius, modulus, h) = (0.01, 1e9, 1e-5_f64);
        let law = Shape::new(4.0 / 3.0, 1.5)
            .unwrap()
            .law(Dimension::Length(radius), modulus)
            .unwrap();
        let a = (radius * h).sqrt();
        let mean_pressure = 4.0 * modulus * a / (3.0 * std::f64::consts::PI * radius);
        assert!((law.force_n(h) / (mean_pressure * std::f64::consts::PI * a * a) - 1.0).abs() < 1e-12);
    }

    /// A cone's contact radius is (2 / pi) h tan(alpha), its mean pressure E* / (2 tan(alpha)) at any depth.
    #[test]
    fn a_cone_presses_alike_at_any_depth() {
        let (angle, modulus) = (1.2, 1e9);
        let factor = std::f64::consts::FRAC_2_PI;
        let law = Shape::new(factor, 2.0)
            .unwrap()
            .law(Dimension::HalfAngle(angle), modulus)
            .unwrap();
        for h in [1e-6, 1e-4] {
            let a = factor * h * libm::tan(angle);
            let pressure = law.force_n(h) / (std::f64::consts::PI * a * a);
            assert!((pressure * 2.0 * libm::tan(angle) / modulus - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_no_indenter_is_refused() {
        let cone = Shape::new(0.6, 2.0).unwrap();
        assert!(cone.law(Dimension::HalfAngle(1.6), 1e9).is_err());
        assert!(cone.law(Dimension::HalfAngle(1.0), -1e9).is_err());
        assert!(Shape::new(2.0, 2.1).is_err() && Shape::new(0.0, 1.0).is_err());
    }
}
