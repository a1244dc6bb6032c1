//! What the laws make of what they see, over frequency.

use super::complex::exp;
use super::elastic::ElasticModel;
use super::plant::Seen;
use nalgebra::Complex;
use node::scenario::{Controller, Law};
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
pub struct LawModel {
    controller: Controller,
    period_s: f64,
    /// Assumed compliance of the tcp along the normal, m/N.
    compliance: f64,
    /// The law `elastic`.
    elastic: Option<ElasticModel>,
}

impl LawModel {
    /// The law that `controller` names, with a period of `period_s` (s); `None`: it is `elastic`, and what it assumes
    /// can't be regulated, so that there is no model of it.
    pub fn new(controller: &Controller, period_s: f64, elastic: Option<ElasticModel>) -> Option<Self> {
        let [x, y, _] = controller.tcp_in_s_m;
        if controller.law == Law::Elastic && elastic.is_none() {
            return None;
        }
        Some(Self {
            compliance: controller.compliance_m_per_n + (x * x + y * y) * controller.compliance_rad_per_nm,
            period_s,
            elastic: elastic.filter(|_| controller.law == Law::Elastic),
            controller: controller.clone(),
        })
    }

    /// Poles at z = 1 of what the law makes of the force.
    pub(super) fn integrators(&self) -> usize {
        match self.controller.law {
            Law::Pd | Law::PdReset | Law::Ros2 => 1,
            Law::Elastic => ElasticModel::INTEGRATORS,
            _ => 0,
        }
    }

    /// The answer at `s` to what is `seen`.
    pub(super) fn answer(&self, s: C, seen: &Seen) -> Answer {
        if let Some(elastic) = &self.elastic {
            return elastic.answer(s, seen);
        }
        let one = C::from(1.0);
        let before = exp(-s * self.period_s);
        let force = seen.deflection / self.compliance;
        let of_object = |by: C| Answer {
            by_sensor: by * seen.deflection,
            by_encoder: by * seen.paired,
        };
        match self.controller.law {
            Law::Literal => of_object(one),
            Law::Proposed => of_object(self.memory(s) * self.stiffness() * self.followed(before)),
            Law::Impedance => of_object(self.memory(s) * self.impedance(before) * self.followed(before)),
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
                let step = exp(-s * own_s);
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
        C::from(gain) / (C::from(1.0) - exp(-s * TICK_S) * (1.0 - gain))
    }

    /// w_r^2: what a desired position that is expected to stay demands of the reference model, 1/s^2.
    fn stiffness(&self) -> f64 {
        let w = TAU * self.controller.proposed.reference_bandwidth_hz;
        w * w
    }

    /// From what is demanded of the reference model, `x_d'' + w_r^2 x_d + 2 w_r x_d'`, to the set-point: the difference
    /// equations of `CommandDynamics::towards`, whose robot is taken to move as it is simulated there.
    fn followed(&self, before: C) -> C {
        let (one, t) = (C::from(1.0), self.period_s);
        let stiffness = self.stiffness();
        let damping = 2.0 * stiffness.sqrt();
        let velocity = (one + before) / (one - before) * (0.5 * t);
        let position = (before * velocity * t + (one + before * 2.0) * (t * t / 6.0)) / (one - before);
        let acceleration = (C::from(1.0 + stiffness * t * t / 6.0 + damping * 0.5 * t)
            + before * (position + velocity * t + t * t / 3.0) * stiffness
            + before * (velocity + 0.5 * t) * damping)
            .inv();
        let f = TAU * self.controller.filter_frequency_hz;
        let zeta = self.controller.filter_damping;
        acceleration * (position + velocity * (2.0 * zeta / f) + 1.0 / (f * f))
    }

    /// From the object to what the impedance's motion demands of the reference model: implicit steps of a tick, and
    /// velocity and acceleration from three of the coming positions, as `Target::ahead` takes them.
    fn impedance(&self, before: C) -> C {
        let p = &self.controller.impedance;
        let (h, t) = (TICK_S, self.period_s);
        let stiffness = 1.0 / self.compliance + p.stiffness_n_per_m;
        let inertia = p.mass_kg + h * p.damping_ns_per_m + h * h * stiffness;
        let moved = |[mut x, mut v]: [f64; 2], object: f64| {
            for _ in 0..libm::rint(t / h) as i64 {
                v = (p.mass_kg * v + h * (object / self.compliance - stiffness * x)) / inertia;
                x += h * v;
            }
            [x, v]
        };
        let columns = [
            moved([1.0, 0.0], 0.0),
            moved([0.0, 1.0], 0.0),
            moved([0.0, 0.0], 1.0),
        ];
        let next = |[x, v]: [C; 2]| -> [C; 2] {
            std::array::from_fn(|i| x * columns[0][i] + v * columns[1][i] + columns[2][i])
        };
        // S = (1 - b Phi)^-1 Gamma.
        let [a, b, c, d] =
            [columns[0][0], columns[1][0], columns[0][1], columns[1][1]].map(|phi| before * phi);
        let one = C::from(1.0);
        let determinant = (one - a) * (one - d) - b * c;
        let [along, rate] = columns[2].map(C::from);
        let now = [
            ((one - d) * along + b * rate) / determinant,
            (c * along + (one - a) * rate) / determinant,
        ];
        let soon = next(now);
        let later = next(soon)[0];
        let (now, soon) = (now[0], soon[0]);
        let velocity = (soon * 4.0 - now * 3.0 - later) / (2.0 * t);
        let acceleration = (now - soon * 2.0 + later) / (t * t);
        acceleration + now * self.stiffness() + velocity * (2.0 * self.stiffness().sqrt())
    }
}
