//! The loop's own transfer function in contact, and how far the loop is from its border of stability: linear theory.
//!
//! Small motions about the resting contact, six axes, six degrees of freedom of the tool; sampled parts by their
//! z transforms with z = e^(s h), the aliases of what is sampled neglected. Not in it: limits, bounces (a contact that
//! presses steadily moves on its rebound branch, c_re), noise, the tilt after the contact, the tool's weight as a
//! pendulum, a gain that is lowered for an oscillation, a compliance that is adapted.
//!
//! The equations know numbers alone ([`Plant`], [`LawModel`]). The controller fills them with what it *assumes*
//! (`assumed.rs`) and publishes what results (`assessment.rs`); `experiment::linear` fills the plant with what *is*.
//!
//! | Idea | File |
//! |---|---|
//! | robot, sensor, tool and contact over frequency | `plant.rs` |
//! | what the laws make of what they see | `laws.rs`, `elastic.rs` |
//! | stability and margins of what results | `stability.rs` |

mod assessment;
mod assumed;
mod complex;
mod elastic;
mod laws;
mod plant;
mod stability;

pub(crate) use assessment::Assessor;
pub use assessment::{Assessment, ToAssess};
pub use elastic::ElasticModel;
pub use laws::{Answer, LawModel};
pub use plant::{GearSprings, Plant, Seen, Servo, contact_stiffness};
pub use stability::Margins;

use nalgebra::Complex;
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
    /// Of `plant`; `None` where its equations have no solution.
    pub fn new(plant: &Plant) -> Option<Self> {
        let highest_hz = 0.5 / plant.period_s;
        let ratio = libm::log(highest_hz / LOWEST_HZ) / (POINTS - 1) as f64;
        let frequency_hz = |i: usize| LOWEST_HZ * libm::exp(ratio * i as f64);
        let seen = |i: usize| Some((frequency_hz(i), plant.seen(laplace(frequency_hz(i)))?));
        Some(Self((0..POINTS).map(seen).collect::<Option<_>>()?))
    }
}

fn laplace(frequency_hz: f64) -> Complex<f64> {
    Complex::new(0.0, 2.0 * PI * frequency_hz)
}

/// The loop along the contact's normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    points: Vec<Point>,
    /// Poles of the law at z = 1.
    integrators: usize,
}

impl Loop {
    /// The loop of `law` around a plant whose `response` is known.
    pub fn close(response: &Response, law: &LawModel) -> Self {
        let point = |(frequency_hz, seen): &(f64, Seen)| Point {
            frequency_hz: *frequency_hz,
            answer: law.answer(laplace(*frequency_hz), seen),
        };
        Self {
            points: response.0.iter().map(point).collect(),
            integrators: law.integrators(),
        }
    }

    /// Whether the open loop is known at all frequencies.
    pub fn finite(&self) -> bool {
        let known = |x: Complex<f64>| x.re.is_finite() && x.im.is_finite();
        self.points
            .iter()
            .all(|point| known(point.answer.by_sensor) && known(point.answer.by_encoder))
    }

    /// The open loop over frequency.
    pub fn points(&self) -> &[Point] {
        &self.points
    }
}
