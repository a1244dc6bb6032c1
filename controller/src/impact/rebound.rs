//! The way out of the body: stiffer than the way in where the body was deformed plastically.

use super::kick::power;
use super::quantity::{ImpactError, REBOUND_RATIO};

/// Paper, below (13): "two different constants, one for the indentation c_in and one for the rebound phase c_re".
///
/// On the way out the force is `f = c_re (h - h_rem)^n`. It continues that of the way in at the maximum depth, which
/// fixes the remaining indentation: `h_rem = h_max (1 - (c_in / c_re)^(1/n))`.
///
/// Model choice: the paper leaves the shape of the rebound open; the same exponent is taken on both ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rebound {
    ratio: f64,
}

impl Rebound {
    /// `c_re = c_in`: nothing remains and no energy is lost. Also the estimate of (18) where c_re is unknown.
    pub const ELASTIC: Self = Self { ratio: 1.0 };

    /// With `c_re / c_in`, at least 1.
    pub fn new(ratio: f64) -> Result<Self, ImpactError> {
        let ratio = REBOUND_RATIO.check(ratio)?;
        Ok(Self { ratio })
    }

    /// `c_re / c_in`.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// The share of the maximum indentation that remains.
    pub fn remaining_share(&self, exponent: f64) -> f64 {
        1.0 - self.recovered_share(exponent)
    }

    /// The share of the maximum indentation that is recovered, `(c_in / c_re)^(1/n)`. The energy given back is the
    /// same share of the energy taken: `c_re (h_max - h_rem)^(n+1)` over `c_in h_max^(n+1)`.
    pub fn recovered_share(&self, exponent: f64) -> f64 {
        power(1.0 / self.ratio, 1.0 / exponent)
    }

    /// Speed after the impact over speed before: `e = (c_in / c_re)^(1 / 2n)`. The rebound takes e times as long as
    /// the indentation.
    pub fn restitution(&self, exponent: f64) -> f64 {
        self.recovered_share(exponent).sqrt()
    }
}
