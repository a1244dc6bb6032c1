//! Free motion that leaves tool and gears at rest, and keeps the deflected tcp to its path meanwhile.
//!
//! Paper VI: a tool on a compliant sensor swings in free motion, and what is to be controlled is the deflected tcp. Three
//! things together, all of them feed-forward:
//!
//! - The robot leads the tool by what its acceleration deflects: the inversion of the assumed model ([`swing`]). Were the
//!   model right, nothing would swing, whatever the path.
//! - A change of speed is a rectangle of acceleration, as short as the allowed acceleration makes it, averaged over a
//!   window whose spectrum is small from just below the lowest mode on ([`kernel`]). What the inversion misses because a
//!   mode is not where it is assumed finds nothing to excite.
//! - The window is as short as the residual swing that is allowed permits, given the error of the modes.
//!
//! Why a low pass and not a notch (ZV, ZVD, EI) for each mode: tool on sensor and gears have up to twelve modes between
//! 10 and 75 Hz, and a notch wide enough for an error of 10 % takes 1 to 1.5 periods of each. Convolved for three modes
//! that is longer than one window for all of them, which is `acosh(1 / ripple) / pi` periods of the lowest one at
//! least (Dolph and Chebyshev), whatever lies above.

pub mod kernel;
pub mod swing;

use kernel::{Kernel, Moments};
use node::scenario;
use spatial::TICK_S;
use swing::Swing;

/// Distance and its derivatives along a path: m, m/s, m/s^2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Distance travelled, m.
    pub distance: f64,
    /// m/s.
    pub speed: f64,
    /// m/s^2.
    pub acceleration: f64,
}

/// How a change of speed is shaped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Largest acceleration, m/s^2.
    acceleration: f64,
    /// What it is averaged with; `None`: nothing, a trapezoid of speed.
    kernel: Option<Kernel>,
}

impl Shape {
    /// A trapezoid of speed, with at most `acceleration` (m/s^2).
    pub fn trapezoid(acceleration: f64) -> Self {
        Self {
            acceleration,
            kernel: None,
        }
    }

    /// A change of speed with at most `acceleration` (m/s^2) whose spectrum is at most `ripple` from `edge_hz` on, the
    /// rectangle of acceleration taken as 1.
    pub fn smooth(acceleration: f64, edge_hz: f64, ripple: f64) -> Self {
        Self {
            acceleration,
            kernel: Some(Kernel::new(edge_hz, ripple)),
        }
    }

    /// The shape that leaves the residual swing which is asked for, of what swings as `swing` says.
    ///
    /// A rectangle of acceleration a leaves the tcp swinging by at most twice what a deflects. Of that, the inversion leaves
    /// what it puts wrong by an error of the modes, its zero lying at w instead of `w (1 + error)`, and (model choice) a
    /// tenth for each spring between motors and tool, whose dampings it does not know.
    pub fn new(shaping: &scenario::Shaping, swing: &Swing) -> Self {
        let acceleration = shaping.acceleration_m_per_s2;
        match shaping.profile {
            scenario::Profile::Trapezoid => Self::trapezoid(acceleration),
            scenario::Profile::Smooth => {
                let error = shaping.mode_error;
                let missed = error * (2.0 + error) + 0.1 * swing.springs();
                let left_m = 2.0 * acceleration * swing.yields_by_s2() * missed;
                let edge_hz = (1.0 - error) * swing.lowest_hz();
                Self::smooth(acceleration, edge_hz, shaping.residual_m / left_m)
            }
        }
    }

    /// How long a window the change of speed is averaged over, s: what a change takes more than a trapezoid's.
    pub fn window(&self) -> f64 {
        self.kernel.map_or(0.0, |kernel| kernel.duration())
    }

    /// How long the speed takes to change by `change` (m/s), s; a tick for no change at all, so that none is a step.
    pub fn ramp_time(&self, change: f64) -> f64 {
        self.rise(change) + self.window()
    }

    /// The highest speed (m/s) v with `share v ramp_time(v) <= way` (m).
    pub fn speed_within(&self, share: f64, way: f64) -> f64 {
        let (a, fixed) = (self.acceleration, self.window() + TICK_S);
        0.5 * a * (libm::sqrt(fixed * fixed + 4.0 * way.max(0.0) / (share * a)) - fixed)
    }

    /// The acceleration that the ramps are made of, m/s^2.
    pub fn acceleration(&self) -> f64 {
        self.acceleration
    }

    fn rise(&self, change: f64) -> f64 {
        libm::fabs(change) / self.acceleration + TICK_S
    }

    /// Where a change of the speed from `before` by `change` (m/s) is, `time` (s) after its start.
    pub(crate) fn ramp(&self, before: f64, change: f64, time: f64) -> Point {
        let rise = self.rise(change);
        let at = |time: f64| match &self.kernel {
            _ if time <= 0.0 => Moments::default(),
            Some(kernel) => kernel.moments(time),
            None => Moments::of_step(time),
        };
        let (begun, ended) = (at(time), at(time - rise));
        let slope = change / rise;
        Point {
            distance: before * time + slope * (begun.twice - ended.twice),
            speed: before + slope * (begun.once - ended.once),
            acceleration: slope * (begun.value - ended.value),
        }
    }
}

#[cfg(test)]
mod tests;
