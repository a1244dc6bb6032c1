//! What the laws make of what they see, over frequency.

use super::plant::Seen;
use nalgebra::Complex;
use node::scenario::{Controller, Law, Scenario};
use spatial::TICK_S;
use std::f64::consts::TAU;

type C = Complex<f64>;

/// The set-point that a law answers a set-point of 1 m with, once it has gone around the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// By way of the sensor's deflection.
    pub by_sensor: C,
    /// By way of the encoders.
    pub by_encoder: C,
}

/// A law about its rest in contact.
#[derive(Clone, Debug)]
pub(super) struct LawModel {
    controller: Controller,
    period_s: f64,
    /// Assumed compliance of the tcp along the normal, m/N.
    compliance: f64,
}

impl LawModel {
    /// The law of `scenario`; `None`: it has no linear model here.
    pub(super) fn new(scenario: &Scenario) -> Option<Self> {
        let controller = scenario.controller.clone();
        let [x, y, _] = controller.tcp_in_s_m;
        let known = matches!(
            controller.law,
            Law::Pd | Law::PdReset | Law::Literal | Law::Proposed | Law::Impedance | Law::Ros2 | Law::Fzi
        );
        known.then(|| Self {
            compliance: controller.compliance_m_per_n + (x * x + y * y) * controller.compliance_rad_per_nm,
            period_s: scenario.timing.command_period_ticks as f64 * TICK_S,
            controller,
        })
    }

    /// Poles at z = 1 of what the law makes of the force.
    pub(super) fn integrators(&self) -> usize {
        match self.controller.law {
            Law::Pd | Law::PdReset | Law::Ros2 => 1,
            _ => 0,
        }
    }

    /// The answer at `s` to what is `seen`.
    pub(super) fn answer(&self, s: C, seen: &Seen) -> Answer {
        let one = C::from(1.0);
        let before = (-s * self.period_s).exp();
        let force = seen.deflection / self.compliance;
        let of_object = |by: C| Answer {
            by_sensor: by * seen.deflection,
            by_encoder: by * seen.paired,
        };
        match self.controller.law {
            Law::Literal => of_object(one),
            Law::Proposed => of_object(self.memory(s) * self.followed(before)),
            Law::Impedance => of_object(self.memory(s) * self.impedance(s) * self.led(s)),
            Law::Ros2 => {
                let p = &self.controller.ros2;
                let t = self.period_s;
                let damping = 2.0 * p.damping_ratio * (p.mass_kg * p.stiffness_n_per_m).sqrt();
                let filter = C::from(p.filter_gain) / (one - before * (1.0 - p.filter_gain));
                let kept = 1.0 - t * (damping / p.mass_kg + p.joint_damping_per_s);
                let delta = C::from(t * t / p.mass_kg) / ((one - before * kept) * (one - before));
                Answer {
                    by_sensor: delta * filter * force,
                    by_encoder: -delta * p.stiffness_n_per_m * seen.actual,
                }
            }
            Law::Fzi => {
                let p = &self.controller.fzi;
                let own_s = 1.0 / p.rate_hz;
                let step = (-s * own_s).exp();
                let h = p.virtual_step_s;
                let gain = (C::from(p.proportional_translation) + (one - step) * (p.derivative_s / h))
                    * p.error_scale;
                let velocity = gain * 0.9 * h / (one - step * 0.9);
                // Held for its own period, which is sampled with T.
                let held = match own_s > self.period_s {
                    true => (one - step) / (one - before) * (self.period_s / own_s),
                    false => one,
                };
                Answer {
                    by_sensor: held * step * velocity * h * force,
                    by_encoder: held * seen.actual,
                }
            }
            _ => {
                let p = &self.controller.pd;
                let change = one - before;
                Answer {
                    by_sensor: (C::from(p.proportional_m_per_n) + change * p.derivative_m_per_n) / change
                        * force,
                    by_encoder: C::from(0.0),
                }
            }
        }
    }

    /// The object's model once its memory is full: one pole, at each sample.
    fn memory(&self, s: C) -> C {
        let p = &self.controller.proposed;
        let gain = p.settled_filter_gain.min(p.object_filter_gain);
        C::from(gain) / (C::from(1.0) - (-s * TICK_S).exp() * (1.0 - gain))
    }

    /// From a desired position that is expected to stay to the set-point: the difference equations of
    /// `CommandDynamics::towards`, whose robot is taken to move as it is simulated there.
    fn followed(&self, before: C) -> C {
        let (one, t) = (C::from(1.0), self.period_s);
        let w = TAU * self.controller.proposed.reference_bandwidth_hz;
        let (stiffness, damping) = (w * w, 2.0 * w);
        let velocity = (one + before) / (one - before) * (0.5 * t);
        let position = (before * velocity * t + (one + before * 2.0) * (t * t / 6.0)) / (one - before);
        let acceleration = C::from(stiffness)
            / (C::from(1.0 + stiffness * t * t / 6.0 + damping * 0.5 * t)
                + before * (position + velocity * t + t * t / 3.0) * stiffness
                + before * (velocity + 0.5 * t) * damping);
        let f = TAU * self.controller.filter_frequency_hz;
        let zeta = self.controller.filter_damping;
        acceleration * (position + velocity * (2.0 * zeta / f) + 1.0 / (f * f))
    }

    /// From a motion whose future is known to the set-point that leads it.
    fn led(&self, s: C) -> C {
        let f = TAU * self.controller.filter_frequency_hz;
        C::from(1.0) + s * (2.0 * self.controller.filter_damping / f) + s * s / (f * f)
    }

    /// From the object to the mass of the impedance, by implicit steps of a tick.
    fn impedance(&self, s: C) -> C {
        let p = &self.controller.impedance;
        let (one, h, before) = (C::from(1.0), TICK_S, (-s * TICK_S).exp());
        let stiffness = 1.0 / self.compliance + p.stiffness_n_per_m;
        let inertia = p.mass_kg + h * p.damping_ns_per_m + h * h * stiffness;
        // v' (inertia - m b) = h (x_o / C - stiffness b x), x (1 - b) = h v'.
        let by_velocity = C::from(h) / (one - before);
        let velocity = C::from(h / self.compliance)
            / (C::from(inertia) - before * p.mass_kg + before * by_velocity * (h * stiffness));
        velocity * by_velocity
    }
}
