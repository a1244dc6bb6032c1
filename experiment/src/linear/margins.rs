//! Stability and margins of a loop, from its frequency response.

use super::{Loop, Point};
use nalgebra::Complex;
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// How far a loop is from its border of stability.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Margins {
    /// Whether all its poles lie inside the unit circle.
    pub stable: bool,
    /// How many times as much the sensor may show before the loop becomes unstable; 0 for an unstable loop.
    pub gain_margin: f64,
    /// Least phase that may be lost where the open loop has magnitude 1, rad; 0 for an unstable loop.
    pub phase_margin_rad: f64,
    /// Highest frequency at which the open loop has magnitude 1, Hz; 0: it never has.
    pub crossover_hz: f64,
}

/// The largest gain that is looked for.
const LARGEST: f64 = 1e3;

impl Loop {
    /// Whether the closed loop is stable with `gain` times what the sensor shows: `F = 1 - R_e - gain R_s` has as many
    /// zeros outside the unit circle as it winds around the origin too little (argument principle; the law's own poles
    /// are stable but for its integrators, each of which begins at -pi/2).
    pub fn stable(&self, gain: f64) -> bool {
        let f = |point: &Point| Complex::from(1.0) - point.answer.by_encoder - point.answer.by_sensor * gain;
        let mut turned = 0.0;
        for pair in self.points.windows(2) {
            turned += (f(&pair[1]) / f(&pair[0])).arg();
        }
        let expected = 0.5 * PI * self.integrators as f64;
        libm::rint((expected - turned) / TAU) == 0.0
    }

    /// Margins of the loop broken at the sensor.
    pub fn margins(&self) -> Margins {
        let stable = self.stable(1.0);
        let mut phase_margin_rad = PI;
        let mut crossover_hz = 0.0;
        for pair in self.points.windows(2) {
            let (a, b) = (pair[0].open_loop(), pair[1].open_loop());
            if (a.norm() - 1.0) * (b.norm() - 1.0) <= 0.0 {
                let share = (1.0 - a.norm()) / (b.norm() - a.norm());
                let at = a + (b - a) * share;
                phase_margin_rad = f64::min(phase_margin_rad, (-at).arg().abs());
                crossover_hz = pair[1].frequency_hz;
            }
        }
        Margins {
            stable,
            gain_margin: if stable { self.gain_margin() } else { 0.0 },
            phase_margin_rad: if stable { phase_margin_rad } else { 0.0 },
            crossover_hz,
        }
    }

    /// The least gain above 1 at which the loop is unstable, to a thousandth.
    fn gain_margin(&self) -> f64 {
        let mut low = 1.0;
        let mut high = low;
        while self.stable(high) {
            low = high;
            high *= 1.1;
            if high > LARGEST {
                return LARGEST;
            }
        }
        while high / low > 1.001 {
            let middle = (low * high).sqrt();
            if self.stable(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}
