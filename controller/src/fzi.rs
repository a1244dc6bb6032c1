//! The law of FZI's `cartesian_force_controller`, for comparison.

use crate::contact::{Aim, ContactSample, Situation};
use node::scenario;
use spatial::TICK_S;

/// How much of its velocity the virtual mass keeps in each of its steps.
const KEPT: f64 = 0.9;

/// A virtual unit mass, driven by the force error e = f - f_d, tells where to go from the *measured* pose x. Along one
/// degree of freedom, with its own step h = 0.02 s whatever the real period is:
/// `u = s (p e + d (e - e_prev) / h)`; `x_c = x + v h`; `v <- 0.9 (v + u h)`.
///
/// Source: cartesian_controllers (the facts; ANCHORS.md section 3). Shipped example: 100 Hz, p = 0.05 (rotations 1.5),
/// d = 0, s = 0.5: at rest, 90 um per N of error and step. Between its steps the set-point is held; a step falls
/// on the first cycle at or after its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fzi {
    /// p, kg/s^2 per N along an axis of the unit mass: no unit.
    proportional: f64,
    /// d, s.
    derivative: f64,
    /// s.
    error_scale: f64,
    /// Of the virtual mass, s.
    step_s: f64,
    /// Ticks between two steps.
    period_ticks: f64,
    newest: Option<ContactSample>,
    state: Option<State>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    velocity: f64,
    error: f64,
    set_point: f64,
    /// When the next step is due.
    due_tick: f64,
}

impl Fzi {
    /// No contact yet; the gains for the degree of freedom `dof`.
    pub fn new(parameters: &scenario::Fzi, dof: usize) -> Self {
        let p = parameters;
        Self {
            proportional: if dof < 3 {
                p.proportional_translation
            } else {
                p.proportional_rotation
            },
            derivative: p.derivative_s,
            error_scale: p.error_scale,
            step_s: p.virtual_step_s,
            period_ticks: 1.0 / (p.rate_hz * TICK_S),
            newest: None,
            state: None,
        }
    }

    /// Take one sample in contact.
    pub fn take(&mut self, sample: &ContactSample) {
        self.newest = Some(*sample);
    }

    /// The next set-point x_c; the one before until there is a sample.
    pub fn set_point(&mut self, aim: &Aim, situation: &Situation) -> f64 {
        let Some(sample) = self.newest else {
            return situation.commanded;
        };
        let tick = libm::rint(situation.reached_s[0] / TICK_S);
        let error = sample.wrench - aim.wrench;
        let mut state = self.state.unwrap_or(State {
            velocity: 0.0,
            error,
            set_point: situation.commanded,
            due_tick: tick,
        });
        // A tolerance, since 1 / rate need not be a whole number of ticks.
        if tick > state.due_tick - 1e-6 {
            let rate = (error - state.error) / self.step_s;
            let force = self.error_scale * (self.proportional * error + self.derivative * rate);
            state.set_point = situation.actual + state.velocity * self.step_s;
            state.velocity = KEPT * (state.velocity + force * self.step_s);
            state.error = error;
            state.due_tick += self.period_ticks;
        }
        self.state = Some(state);
        state.set_point
    }

    /// Where the newest sample met the object, at rest.
    pub fn object(&self) -> Option<(f64, f64)> {
        self.newest.map(|sample| (sample.object, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pressed(law: &mut Fzi, wrench: f64) {
        law.take(&ContactSample {
            wrench,
            ..Default::default()
        });
    }

    fn situation(tick: i64, actual: f64) -> Situation {
        let mut situation = Situation::at_rest(1.0, 4e-3);
        situation.actual = actual;
        situation.reached_s = std::array::from_fn(|i| (tick + 4 * i as i64) as f64 * TICK_S);
        situation
    }

    /// By hand: s p = 0.025, s d / h = 0.25 at d = 0.01 s; e = 4, then 6 N; h = 0.02 s.
    #[test]
    fn steps_by_hand_every_10_ms() {
        let parameters = scenario::Fzi {
            derivative_s: 0.01,
            ..Default::default()
        };
        let mut law = Fzi::new(&parameters, 2);
        assert_eq!(law.set_point(&Aim::PAPER, &situation(0, 0.9)), 1.0);
        pressed(&mut law, 14.0);
        // x_c = x; v = 0.9 * 0.025 * 4 * 0.02 = 1.8e-3.
        assert_eq!(law.set_point(&Aim::PAPER, &situation(0, 0.9)), 0.9);
        pressed(&mut law, 16.0);
        for tick in [4, 8] {
            assert_eq!(law.set_point(&Aim::PAPER, &situation(tick, 0.8)), 0.9);
        }
        // x_c = 0.7 + 1.8e-3 * 0.02; u = 0.025 * 6 + 0.25 * 2 = 0.65; v = 0.9 (1.8e-3 + 0.013) = 0.01332.
        let found = law.set_point(&Aim::PAPER, &situation(12, 0.7));
        assert!((found - 0.700_036).abs() < 1e-15, "{found}");
        // Due at 20 ms, not at 22.
        assert_eq!(law.set_point(&Aim::PAPER, &situation(16, 0.6)), found);
        let found = law.set_point(&Aim::PAPER, &situation(20, 0.6));
        assert!((found - 0.600_266_4).abs() < 1e-15, "{found}");
    }

    /// The shipped example's steady step: 9e-5 m per N of error.
    #[test]
    fn the_steady_step_of_the_shipped_example() {
        let mut law = Fzi::new(&scenario::Fzi::default(), 2);
        pressed(&mut law, 11.0);
        let steps = (0..200).map(|n| law.set_point(&Aim::PAPER, &situation(20 * n, 0.5)) - 0.5);
        assert!((steps.last().unwrap() - 9e-5).abs() < 1e-10);
    }
}
