//! What the sensor shows without contact: the tool's weight and the sensor's bias.
//!
//! Measured, not modelled: gravity computed with the assumed compliance would make an error of C look like contact.

use spatial::ports::DeflectionSample;
use spatial::{Deflection, Wrench};

/// The means over the first part of the standstill.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tare {
    deflection: Deflection,
    count: u32,
    wrench: Wrench,
    /// Samples with a measured wrench.
    weighed: u32,
    /// Mean of the normal displacements, m, and sum of their squared deviations from it.
    normal_m: f64,
    squares_m2: f64,
}

impl Tare {
    /// Take one sample at standstill, which displaces the tcp by `normal_m` (m) along the contact's normal.
    pub fn add(&mut self, sample: &DeflectionSample, normal_m: f64) {
        self.deflection = self.deflection + sample.deflection;
        self.count += 1;
        // Welford's recursion.
        let deviation = normal_m - self.normal_m;
        self.normal_m += deviation / f64::from(self.count);
        self.squares_m2 += deviation * (normal_m - self.normal_m);
        if sample.flags.wrench_measured {
            self.wrench = self.wrench + sample.wrench;
            self.weighed += 1;
        }
    }

    /// The mean deflection at s; zero before the first sample.
    pub fn deflection(&self) -> Deflection {
        self.deflection * (1.0 / f64::from(self.count.max(1)))
    }

    /// The mean of the wrench at s that is measured independently; zero before the first one.
    pub fn wrench(&self) -> Wrench {
        self.wrench * (1.0 / f64::from(self.weighed.max(1)))
    }

    /// The standard deviation of the tcp's displacement along the normal, m: the sensor's noise there.
    pub fn noise_m(&self) -> f64 {
        (self.squares_m2 / f64::from(self.count.max(2) - 1)).sqrt()
    }

    /// How many samples it rests on.
    pub fn count(&self) -> u32 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use spatial::ports::SampleFlags;

    #[test]
    fn means_and_noise_of_what_was_shown() {
        let mut tare = Tare::default();
        assert_eq!((tare.deflection(), tare.noise_m()), (Deflection::default(), 0.0));
        for (i, normal) in [1.0, 2.0, 6.0].into_iter().enumerate() {
            let sample = DeflectionSample {
                deflection: Deflection {
                    translation: Vector3::x() * normal,
                    rotation: Vector3::y(),
                },
                wrench: Wrench {
                    force: Vector3::z() * normal,
                    moment: Vector3::zeros(),
                },
                flags: SampleFlags {
                    wrench_measured: i > 0,
                    ..SampleFlags::default()
                },
                ..DeflectionSample::default()
            };
            tare.add(&sample, normal);
        }
        assert!((tare.deflection().translation.x - 3.0).abs() < 1e-15 && tare.deflection().rotation.y == 1.0);
        assert_eq!((tare.wrench().force.z, tare.count()), (4.0, 3));
        // Squares 4 + 1 + 9 over 3 - 1.
        assert!((tare.noise_m() - 7f64.sqrt()).abs() < 1e-15);
    }
}
