//! The admittance law of ROS 2's `admittance_controller`, for comparison.

use crate::contact::{Aim, ContactSample, Situation};
use node::scenario;

/// In each period, along one degree of freedom, with the measured force f, the wrench reference -f_d *added* to it, the
/// measured position x and the reference x_r:
/// `f_h <- a (f - f_d) + (1 - a) f_h`; `acc = (f_h - D v - K (x - x_r)) / M - j v`; `v <- v + acc T`;
/// `delta <- delta + v T`; `x_c = x_r + delta`, with `D = 2 zeta sqrt(M K)`.
///
/// Source: ros2_controllers, `admittance_rule_impl.hpp` (the facts; ANCHORS.md section 3). Their `a` has no unit of time:
/// the low pass is as slow as the controller's period is long. x_r is where the approach was broken off.
/// Deviates: there the law is at work before the contact too, where f = 0 leaves it at rest; here it begins there. The
/// damping of its pseudo-inverse, 0.01, scales accelerations by 1 % and is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ros2 {
    /// M, kg or kg m^2.
    inertia: f64,
    /// K, N/m or Nm/rad.
    stiffness: f64,
    /// D, Ns/m or Nms/rad.
    damping: f64,
    /// a.
    filter_gain: f64,
    /// j, 1/s.
    joint_damping: f64,
    newest: Option<ContactSample>,
    state: Option<State>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    /// x_r.
    reference: f64,
    /// f_h.
    filtered: f64,
    velocity: f64,
    delta: f64,
}

impl Ros2 {
    /// No contact yet; the parameters for the degree of freedom `dof`.
    pub fn new(parameters: &scenario::Ros2, dof: usize) -> Self {
        let p = parameters;
        let (inertia, stiffness) = if dof < 3 {
            (p.mass_kg, p.stiffness_n_per_m)
        } else {
            (p.inertia_kg_m2, p.stiffness_nm_per_rad)
        };
        Self {
            inertia,
            stiffness,
            damping: 2.0 * p.damping_ratio * (inertia * stiffness).sqrt(),
            filter_gain: p.filter_gain,
            joint_damping: p.joint_damping_per_s,
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
        let mut state = self.state.unwrap_or(State {
            reference: situation.commanded,
            filtered: 0.0,
            velocity: 0.0,
            delta: 0.0,
        });
        let force = sample.wrench - aim.wrench;
        state.filtered = self.filter_gain * force + (1.0 - self.filter_gain) * state.filtered;
        let spring = self.stiffness * (situation.actual - state.reference);
        let acceleration = (state.filtered - self.damping * state.velocity - spring) / self.inertia
            - self.joint_damping * state.velocity;
        state.velocity += acceleration * situation.period_s;
        state.delta += state.velocity * situation.period_s;
        self.state = Some(state);
        state.reference + state.delta
    }

    /// Where the newest sample met the object, at rest.
    pub fn object(&self) -> Option<(f64, f64)> {
        self.newest.map(|sample| (sample.object, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two periods by hand: M = 2, K = 50, zeta = 0.5, hence D = 2 * 0.5 * 10 = 10; a = 0.5, j = 5, T = 0.01 s.
    #[test]
    fn two_periods_by_hand() {
        let parameters = scenario::Ros2 {
            filter_gain: 0.5,
            mass_kg: 2.0,
            stiffness_n_per_m: 50.0,
            damping_ratio: 0.5,
            joint_damping_per_s: 5.0,
            ..Default::default()
        };
        let mut law = Ros2::new(&parameters, 2);
        let situation = Situation {
            actual: 1.2,
            ..Situation::at_rest(1.0, 0.01)
        };
        assert_eq!(law.set_point(&Aim::PAPER, &situation), 1.0);
        law.take(&ContactSample {
            wrench: 50.0,
            ..Default::default()
        });
        // f_h = 20, spring 50 * 0.2 = 10: acc = 5, v = 0.05, delta = 0.0005.
        assert!((law.set_point(&Aim::PAPER, &situation) - 1.0005).abs() < 1e-15);
        // f_h = 30: acc = (30 - 0.5 - 10) / 2 - 0.25 = 9.5, v = 0.145, delta = 0.00195.
        assert!((law.set_point(&Aim::PAPER, &situation) - 1.00195).abs() < 1e-15);
    }

    #[test]
    fn rotations_have_parameters_of_their_own() {
        let law = Ros2::new(&scenario::Ros2::default(), 4);
        assert_eq!((law.inertia, law.stiffness), (9.9, 214.5));
    }
}
