//! The loop's own transfer function in contact: what linear theory predicts of a scenario, to be held against
//! simulations.
//!
//! Everything is computed from the scenario: robot, gears, servos, sensor and tool from what *is*, the law from what
//! the controller *assumes*. Small motions about the resting contact, six axes, six degrees of freedom of the tool;
//! sampled parts by their z transforms with z = e^(s h), the aliases of what is sampled neglected. Not in it: limits,
//! bounces (a contact that presses steadily moves on its rebound branch, c_re), noise, the tilt after the contact, the
//! tool's weight as a pendulum.

mod elastic;
mod laws;
mod margins;
mod plant;

pub use laws::Answer;
pub use margins::Margins;

use laws::LawModel;
use nalgebra::Complex;
use node::scenario::Scenario;
use plant::{Plant, Seen};
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

/// What any law sees of the plant, at each frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Response(Vec<(f64, Seen)>);

impl Response {
    /// The plant of `scenario` in contact; `None` for a robot that does not reach the object.
    pub fn new(scenario: &Scenario) -> Option<Self> {
        let plant = Plant::new(scenario)?;
        let highest_hz = 0.5 / period_s(scenario);
        let ratio = libm::log(highest_hz / LOWEST_HZ) / (POINTS - 1) as f64;
        let frequency_hz = |i: usize| LOWEST_HZ * libm::exp(ratio * i as f64);
        let seen = |i: usize| Some((frequency_hz(i), plant.seen(laplace(frequency_hz(i)))?));
        Some(Self((0..POINTS).map(seen).collect::<Option<_>>()?))
    }
}

fn laplace(frequency_hz: f64) -> Complex<f64> {
    Complex::new(0.0, 2.0 * PI * frequency_hz)
}

fn period_s(scenario: &Scenario) -> f64 {
    scenario.timing.command_period_ticks as f64 * spatial::TICK_S
}

/// The loop along the contact's normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    points: Vec<Point>,
    /// Poles of the law at z = 1.
    integrators: usize,
}

impl Loop {
    /// The loop of `scenario` in contact; `None` for a law that can't be regulated as it is assumed, or a robot that does
    /// not reach the object.
    pub fn new(scenario: &Scenario) -> Option<Self> {
        Self::close(&Response::new(scenario)?, scenario)
    }

    /// The loop of a plant whose `response` is known, that of `scenario` or of one that differs in its law alone.
    pub fn close(response: &Response, scenario: &Scenario) -> Option<Self> {
        let law = LawModel::new(scenario)?;
        let point = |(frequency_hz, seen): &(f64, Seen)| Point {
            frequency_hz: *frequency_hz,
            answer: law.answer(laplace(*frequency_hz), seen),
        };
        Some(Self {
            points: response.0.iter().map(point).collect(),
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
