//! What the sensor shows without contact: the tool's weight and the sensor's bias.
//!
//! Measured, not modelled: gravity computed with the assumed compliance would make an error of C look like contact.

use spatial::Deflection;

/// The mean deflection over the first part of the standstill.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tare {
    sum: Deflection,
    count: u32,
}

impl Tare {
    /// Take one sample at standstill.
    pub fn add(&mut self, deflection: &Deflection) {
        self.sum = self.sum + *deflection;
        self.count += 1;
    }

    /// The mean; zero before the first sample.
    pub fn mean(&self) -> Deflection {
        self.sum * (1.0 / f64::from(self.count.max(1)))
    }

    /// How many samples it rests on.
    pub fn count(&self) -> u32 {
        self.count
    }
}
