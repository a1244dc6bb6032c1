//! The stiffness of two materials in contact as one number.

use super::quantity::{ImpactError, POISSON_RATIO, YOUNGS_MODULUS};

/// An isotropic, linearly elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    youngs_modulus: f64,
    poisson_ratio: f64,
}

impl Material {
    /// With E in Pa and nu.
    pub fn new(youngs_modulus_pa: f64, poisson_ratio: f64) -> Result<Self, ImpactError> {
        Ok(Self {
            youngs_modulus: YOUNGS_MODULUS.check(youngs_modulus_pa)?,
            poisson_ratio: POISSON_RATIO.check(poisson_ratio)?,
        })
    }

    /// `(1 - nu^2) / E`, 1/Pa.
    fn yielding(&self) -> f64 {
        (1.0 - self.poisson_ratio * self.poisson_ratio) / self.youngs_modulus
    }

    /// Paper, footnote 9: the effective Young's modulus of the contact with `partner`,
    /// `E* = ((1 - nu_1^2) / E_1 + (1 - nu_2^2) / E_2)^-1`, Pa.
    pub fn effective_modulus_pa(&self, partner: &Self) -> f64 {
        1.0 / (self.yielding() + partner.yielding())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steel on steel: E / (2 (1 - nu^2)), the paper's "100 GPa" in round numbers (Table I).
    #[test]
    fn the_same_on_the_same_is_half() {
        let steel = Material::new(210e9, 0.3).unwrap();
        assert!((steel.effective_modulus_pa(&steel) / 115.385e9 - 1.0).abs() < 1e-5);
    }

    /// The softer partner decides: steel on wood is wood on something rigid, within 1 %.
    #[test]
    fn the_softer_partner_decides() {
        let (steel, wood) = (
            Material::new(210e9, 0.3).unwrap(),
            Material::new(1e9, 0.3).unwrap(),
        );
        let together = steel.effective_modulus_pa(&wood);
        assert_eq!(together, wood.effective_modulus_pa(&steel));
        assert!((together * (1.0 - 0.09) / 1e9 - 1.0).abs() < 0.01 && together < 1e9 / 0.91);
    }

    #[test]
    fn what_is_no_material_is_refused() {
        assert!(Material::new(-1.0, 0.3).is_err() && Material::new(210e9, 0.51).is_err());
    }
}
