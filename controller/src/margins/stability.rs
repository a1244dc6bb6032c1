//! Stability and margins of a loop, from its frequency response.

use super::complex::{angle, modulus};
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

/// The largest gain that is looked for; its inverse is the least.
const LARGEST: f64 = 1e3;
/// From one gain that is tried to the next.
const STRIDE: f64 = 1.1;

impl Loop {
    /// Whether the closed loop is stable with `gain` times what the sensor shows: `F = 1 - R_e - gain R_s` has as many
    /// zeros outside the unit circle as it winds around the origin too little (argument principle; the law's own poles
    /// are stable but for its integrators, each of which begins at -pi/2).
    pub fn stable(&self, gain: f64) -> bool {
        let f = |point: &Point| Complex::from(1.0) - point.answer.by_encoder - point.answer.by_sensor * gain;
        let Some(first) = self.points.first().map(f) else {
            return false;
        };
        // F turns by less than half a turn from point to point: whole turns are counted where it passes the negative axis.
        let (mut last, mut turns) = (first, 0.0);
        for point in &self.points[1..] {
            let next = f(point);
            let cross = last.re * next.im - last.im * next.re;
            match (last.im.is_sign_negative(), next.im.is_sign_negative()) {
                (false, true) if cross > 0.0 => turns += 1.0,
                (true, false) if cross < 0.0 => turns -= 1.0,
                _ if cross.is_nan() => return false,
                _ => {}
            }
            last = next;
        }
        let turned = angle(last) - angle(first) + TAU * turns;
        let expected = 0.5 * PI * self.integrators as f64;
        libm::rint((expected - turned) / TAU) == 0.0
    }

    /// Margins of the loop broken at the sensor.
    pub fn margins(&self) -> Margins {
        let stable = self.stable(1.0);
        let (phase_margin_rad, crossover_hz) = self.crossover();
        Margins {
            stable,
            gain_margin: if stable { self.gain_margin() } else { 0.0 },
            phase_margin_rad: if stable { phase_margin_rad } else { 0.0 },
            crossover_hz,
        }
    }

    /// The least angle from -1 where the open loop has magnitude 1 (rad; pi: nowhere), and the highest such frequency, Hz.
    pub(super) fn crossover(&self) -> (f64, f64) {
        let (mut least_rad, mut crossover_hz) = (PI, 0.0);
        for pair in self.points.windows(2) {
            let (a, b) = (pair[0].open_loop(), pair[1].open_loop());
            let [from, to] = [a, b].map(modulus);
            if (from - 1.0) * (to - 1.0) <= 0.0 {
                let at = a + (b - a) * ((1.0 - from) / (to - from));
                least_rad = f64::min(least_rad, libm::fabs(angle(-at)));
                crossover_hz = pair[1].frequency_hz;
            }
        }
        (least_rad, crossover_hz)
    }

    /// The least gain above 1 at which the loop is unstable, to a thousandth.
    fn gain_margin(&self) -> f64 {
        let (mut low, mut high) = (1.0, 1.0);
        while self.stable(high) {
            low = high;
            high *= STRIDE;
            if high > LARGEST {
                return LARGEST;
            }
        }
        self.border(low, high)
    }

    /// The largest gain below 1 at which an unstable loop is stable, to a thousandth; a thousandth where there is none.
    pub(super) fn stable_share(&self) -> f64 {
        let (mut low, mut high) = (1.0, 1.0);
        while !self.stable(low) {
            high = low;
            low /= STRIDE;
            if low * LARGEST < 1.0 {
                return 1.0 / LARGEST;
            }
        }
        self.border(low, high)
    }

    /// Where the loop ceases to be stable between a `low` gain with which it is and a `high` one with which it is not.
    fn border(&self, mut low: f64, mut high: f64) -> f64 {
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
