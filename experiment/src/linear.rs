//! The loop's own transfer function in contact: what linear theory predicts of a scenario, to be held against
//! simulations.
//!
//! Everything is computed from the scenario: robot, gears, servos, sensor and tool from what *is*, the law from what
//! the controller *assumes*. Small motions about the resting contact, six axes, six degrees of freedom of the tool;
//! sampled parts by their z transforms with z = e^(s h), the aliases of what is sampled neglected. Not in it: limits,
//! bounces (a contact that presses steadily moves on its rebound branch, c_re), noise, the tilt after the contact, the
//! tool's weight as a pendulum.

mod laws;
mod margins;
mod plant;

pub use laws::Answer;
pub use margins::Margins;

use laws::LawModel;
use nalgebra::Complex;
use node::scenario::Scenario;
use plant::Plant;
use std::f64::consts::PI;

/// How far down the frequency goes, Hz.
const LOWEST_HZ: f64 = 0.05;
/// Points on the imaginary axis, equally spaced in their logarithm: 0.15 Hz apart at a gear mode of 14 Hz.
const POINTS: usize = 800;

/// The open loop at one frequency, broken at the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Hz.
    pub frequency_hz: f64,
    /// What the law makes of what it sees.
    pub answer: Answer,
}

impl Point {
    /// `L`, negative feedback: the loop is on the verge of stability where this is -1.
    pub fn open_loop(&self) -> Complex<f64> {
        -self.answer.by_sensor / (Complex::from(1.0) - self.answer.by_encoder)
    }
}

/// The loop along the contact's normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    points: Vec<Point>,
    /// Poles of the law at z = 1.
    integrators: usize,
}

impl Loop {
    /// The loop of `scenario` in contact; `None` for a law that has no linear model here, or a robot that does not reach
    /// the object.
    pub fn new(scenario: &Scenario) -> Option<Self> {
        let law = LawModel::new(scenario)?;
        let plant = Plant::new(scenario)?;
        let period_s = scenario.timing.command_period_ticks as f64 * spatial::TICK_S;
        let highest_hz = 0.5 / period_s;
        let ratio = libm::log(highest_hz / LOWEST_HZ) / (POINTS - 1) as f64;
        let points = (0..POINTS)
            .map(|i| {
                let frequency_hz = LOWEST_HZ * libm::exp(ratio * i as f64);
                let s = Complex::new(0.0, 2.0 * PI * frequency_hz);
                Some(Point {
                    frequency_hz,
                    answer: law.answer(s, &plant.seen(s)?),
                })
            })
            .collect::<Option<_>>()?;
        Some(Self {
            points,
            integrators: law.integrators(),
        })
    }

    /// The open loop over frequency.
    pub fn points(&self) -> &[Point] {
        &self.points
    }
}

#[cfg(test)]
mod tests;
