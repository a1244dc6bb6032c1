//! An impedance as the task: the way to the desired pose is that of a mass with damper and spring.

use crate::contact::{Aim, ContactSample, PREVIEW, Situation};
use crate::object_model::ObjectModel;
use node::scenario;
use spatial::TICK_S;

/// Paper, section II: a task specified as an impedance smooths the motion. The tcp moves as
/// `M x'' + D x' + K (x - x_0) = f - f_d` along one degree of freedom, x_0 where the object was met.
///
/// The force f is not the measured one but that of the object's model at x, `f = (x_o - x) / C`: no delay of the
/// sensor acts inside the loop, so that any positive M, D and K are stable, unlike admittance control.
/// With K = 0 it ends where (2) does; with K > 0 the spring takes its share: `f = f_d / (1 + K C)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impedance {
    object: ObjectModel,
    /// M, kg or kg m^2.
    inertia: f64,
    /// D, Ns/m or Nms/rad.
    damping: f64,
    /// K, N/m or Nm/rad.
    stiffness: f64,
    state: Option<State>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    position: f64,
    velocity: f64,
    /// x_0.
    rest: f64,
}

impl Impedance {
    /// No contact yet; the parameters for the degree of freedom `dof`.
    pub fn new(parameters: &scenario::Impedance, dof: usize, object: ObjectModel) -> Self {
        let p = parameters;
        let (inertia, damping, stiffness) = if dof < 3 {
            (p.mass_kg, p.damping_ns_per_m, p.stiffness_n_per_m)
        } else {
            (p.inertia_kg_m2, p.damping_nms_per_rad, p.stiffness_nm_per_rad)
        };
        Self {
            object,
            inertia,
            damping,
            stiffness,
            state: None,
        }
    }

    /// The object moves with `rate` as the contact begins.
    pub fn expect(&mut self, rate: f64) {
        self.object.expect(rate);
    }

    /// Take one sample in contact.
    pub fn take(&mut self, sample: &ContactSample) {
        self.object.take(sample);
    }

    /// The object's coordinate and its rate.
    pub fn object(&self) -> Option<(f64, f64)> {
        self.object.object()
    }

    /// The motion at the coming instants; it takes over from where the tcp is and how it moves.
    pub fn desired(&mut self, aim: &Aim, situation: &Situation) -> [f64; PREVIEW] {
        let met = State {
            position: situation.desired,
            velocity: situation.desired_rate,
            rest: self.object().map_or(situation.desired, |(object, _)| object),
        };
        let mut state = *self.state.get_or_insert(met);
        // Back-calculation: where a bound kept the tcp from the motion, the motion goes on from there.
        if state.position != situation.desired {
            (state.position, state.velocity) = (situation.desired, situation.desired_rate);
        }
        std::array::from_fn(|i| {
            if let Some(object) = self.object.at(situation.reached_s[i]) {
                state = self.moved(state, object, aim, situation.period_s);
            }
            if i == 0 {
                self.state = Some(state);
            }
            state.position
        })
    }

    /// The state a period later, by implicit Euler steps of one tick, stable for any positive parameters:
    /// `v' = v + h a(x + h v', v')`.
    fn moved(&self, mut state: State, object: f64, aim: &Aim, period_s: f64) -> State {
        let (m, d, k, c) = (self.inertia, self.damping, self.stiffness, aim.compliance);
        let ticks = libm::rint(period_s / TICK_S) as i64;
        for _ in 0..ticks {
            // The desired force and what the rest of the wrench displaces are at home at x_o - C f_d.
            let force = (object - aim.displacement - state.position) / c - k * (state.position - state.rest);
            let stiffness = 1.0 / c + k;
            let velocity =
                (m * state.velocity + TICK_S * force) / (m + TICK_S * d + TICK_S * TICK_S * stiffness);
            state.position += TICK_S * velocity;
            state.velocity = velocity;
        }
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const AIM: Aim = Aim::PAPER;

    /// Where the motion is after `periods`, from 20 mm/s at 0 towards an object at 0.
    fn end(parameters: &scenario::Impedance, periods: usize) -> f64 {
        let object = ObjectModel::new(&scenario::Proposed::default());
        let mut law = Impedance::new(parameters, 2, object);
        law.take(&ContactSample::default());
        let mut situation = Situation {
            commanded: 0.0,
            desired: 0.0,
            desired_rate: -0.02,
            actual: 0.0,
            reached_s: [0.0; PREVIEW],
            period_s: 4e-3,
        };
        for _ in 0..periods {
            let [next, after, ..] = law.desired(&AIM, &situation);
            situation.desired = next;
            situation.desired_rate = (after - next) / situation.period_s;
        }
        situation.desired
    }

    proptest! {
        /// (2) with K = 0; else the balance `(x_o - x) / C - K (x - x_0) = f_d`. Stable whatever the parameters.
        #[test]
        fn it_ends_in_balance(mass in 0.1..50.0, damping in 200.0..5000.0, stiffness in 0.0..1e5) {
            let parameters = scenario::Impedance {
                mass_kg: mass,
                damping_ns_per_m: damping,
                stiffness_n_per_m: stiffness,
                ..Default::default()
            };
            let x = end(&parameters, 5000);
            let balance = -AIM.wrench / (1.0 / AIM.compliance + stiffness);
            prop_assert!((x - balance).abs() < 1e-9, "{x} {balance}");
        }
    }

    /// M x'' + D x' + x / C = -f_d: an undamped second-order system turns around after half its natural period.
    #[test]
    fn the_motion_has_the_frequency_of_its_mass_and_the_sensor() {
        let parameters = scenario::Impedance {
            mass_kg: 20.0,
            damping_ns_per_m: 0.0,
            stiffness_n_per_m: 0.0,
            ..Default::default()
        };
        let half_period_s = std::f64::consts::PI * (20.0f64 * AIM.compliance).sqrt();
        let positions: Vec<f64> = (0..40).map(|n| end(&parameters, n)).collect();
        let crossings: Vec<usize> = (1..39)
            .filter(|&n| (positions[n] + 280e-6) * (positions[n + 1] + 280e-6) < 0.0)
            .collect();
        let found_s = (crossings[1] - crossings[0]) as f64 * 4e-3;
        assert!(
            (found_s - half_period_s).abs() <= 4e-3,
            "{found_s} s, {half_period_s} s"
        );
    }
}
