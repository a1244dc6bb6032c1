//! The law behind elastic gears as a linear system: observer, prediction and regulator of one hypothesis.
//!
//! Once its covariance has settled, the law is linear and does not change with time, as long as it regulates
//! ([`crate::elastic`]): of its hypotheses the nearest to the real gears is taken to be believed, which is what their
//! likelihood comes to. Beyond the outermost one the real gears are what no hypothesis expects.

use super::complex::exp;
use super::laws::Answer;
use super::plant::Seen;
use crate::elastic::Design;
use crate::elastic::observer::{ESTIMATED, MOTOR_GAINS, Observer};
use crate::elastic::plant::{DEVIATION, MODAL, POSITION, Plant, RATE, STATES};
use nalgebra::{Complex, SMatrix, SVector, Vector3};
use node::scenario::Controller;
use spatial::TICK_S;
use std::f64::consts::TAU;

type C = Complex<f64>;
/// The states without the command filters, which the law knows, and these.
const INNER: usize = POSITION;
const KNOWN: usize = STATES - INNER;
/// Those and the object.
const ALL: usize = INNER + 1;
type Inner = SVector<C, INNER>;
/// By way of the sensor, and by way of encoders and own commands.
type Ways = [Inner; 2];

/// When the Kalman filter's gain is taken, in ticks after the contact: the length of a judged run.
const SETTLED_TICKS: usize = 1500;

/// The law about its rest in contact.
#[derive(Clone, Debug)]
pub struct ElasticModel {
    plant: Plant,
    /// What an error of the deflection corrects of modes and object.
    corrects: SVector<f64, ESTIMATED>,
    /// From the newest sample's truth to the instant at which the next set-point begins to act.
    ahead_ticks: i32,
    period_s: f64,
    filter_rad_per_s: f64,
    filter_damping: f64,
}

impl ElasticModel {
    /// Of the hypothesis of `design` that is nearest to gears `ratio` times as fast as they are assumed, with a period of
    /// `period_s` and samples that are `sensor_delay_s` old (s).
    pub fn new(
        design: &Design,
        controller: &Controller,
        ratio: f64,
        period_s: f64,
        sensor_delay_s: f64,
    ) -> Self {
        let plant = *design.nearest(ratio);
        let late_s = sensor_delay_s + 1.0 / (TAU * controller.sensor_bandwidth_hz);
        let ahead_s = controller.command_delay_periods as f64 * period_s + late_s;
        Self {
            corrects: Observer::gain_after(&plant, &controller.elastic, SETTLED_TICKS),
            plant,
            ahead_ticks: libm::rint(ahead_s / TICK_S) as i32,
            period_s,
            filter_rad_per_s: TAU * controller.filter_frequency_hz,
            filter_damping: controller.filter_damping,
        }
    }

    /// How the command filters answer to a change of their acceleration by 1 m/s^2: the loop of both, which is broken
    /// there, has these three integrators.
    pub(super) const INTEGRATORS: usize = 3;

    /// The change of the acceleration that a change by 1 m/s^2 is answered with, once it has gone around the loop. (Of
    /// the set-points the same holds: they follow from it.)
    pub(super) fn answer(&self, s: C, seen: &Seen) -> Answer {
        let (z, tick) = (exp(s * self.period_s), exp(s * TICK_S));
        let acts = self.filters(z);
        let sampled = acts * tick.powi(-self.ahead_ticks);
        let w = self.filter_rad_per_s;
        // The set-point that brings the filters there, at the end of the period.
        let setpoint = z * (acts[0] + acts[1] * (2.0 * self.filter_damping / w) + acts[2] / (w * w));
        let readings = [seen.deflection * setpoint, seen.paired * setpoint];
        let Some((mut states, objects)) = self.observed(tick, &sampled, readings) else {
            return Answer {
                by_sensor: C::from(f64::NAN),
                by_encoder: C::from(f64::NAN),
            };
        };
        // The plant until the next set-point begins to act.
        let mut filters = sampled;
        for _ in 0..self.ahead_ticks {
            states = std::array::from_fn(|way| {
                let mut known = filters * C::from(if way == 0 { 0.0 } else { 1.0 });
                known[0] -= objects[way];
                self.moved(&states[way], &known)
            });
            filters *= tick;
        }
        let gain = self.plant.gain;
        let answer = |way: usize| {
            let mut known = acts * C::from(if way == 0 { 0.0 } else { 1.0 });
            known[0] -= objects[way];
            let inner = (0..INNER).map(|i| states[way][i] * gain[i]);
            let outer = (0..KNOWN).map(|i| known[i] * gain[INNER + i]);
            -inner.chain(outer).fold(C::from(0.0), |sum, part| sum + part)
        };
        Answer {
            by_sensor: answer(0),
            by_encoder: answer(1),
        }
    }

    /// Position, speed and acceleration of the command filters, which changes linearly over each period.
    fn filters(&self, z: C) -> Vector3<C> {
        let (t, integral) = (self.period_s, (z - 1.0).inv());
        let acceleration = integral;
        let speed = (acceleration * t + 0.5 * t) * integral;
        let position = (speed * t + acceleration * (0.5 * t * t) + t * t / 6.0) * integral;
        Vector3::new(position, speed, acceleration)
    }

    /// One tick of what is not known for certain.
    fn moved(&self, inner: &Inner, known: &Vector3<C>) -> Inner {
        Inner::from_fn(|i, _| {
            let own = (0..INNER).fold(C::from(0.0), |sum, j| sum + inner[j] * self.plant.tick[(i, j)]);
            (0..KNOWN).fold(own, |sum, j| sum + known[j] * self.plant.tick[(i, INNER + j)])
        })
    }

    /// What `Observer::take` makes of the `readings` of deflection and motors with the command filters at `sampled`:
    /// its states and its object, by either way.
    fn observed(&self, tick: C, sampled: &Vector3<C>, readings: [C; 2]) -> Option<(Ways, [C; 2])> {
        let plant = &self.plant;
        let (before, none) = (tick.inv(), C::from(0.0));
        // Each tick, as X+ = M X + what is read: first the plant, from the states and the object before ...
        let mut moved = SMatrix::<C, INNER, ALL>::from_fn(|i, j| match j {
            INNER => -before * plant.tick[(i, POSITION)],
            _ => before * plant.tick[(i, j)],
        });
        let mut known = self.moved(&Inner::zeros(), &(sampled * before));
        // ... then the motors ...
        let yielded = |column: &dyn Fn(usize) -> C| {
            (0..6).fold(none, |sum, axis| {
                sum + column(DEVIATION + axis) * plant.tcp_per_axis[axis]
            })
        };
        let missed = |error: C, column: &mut dyn FnMut(usize, C)| {
            for axis in 0..6 {
                let part = error * plant.axes_per_tcp[axis];
                column(DEVIATION + axis, part * MOTOR_GAINS[0]);
                column(RATE + axis, part * (MOTOR_GAINS[1] / TICK_S));
            }
        };
        for j in 0..ALL {
            let error = -yielded(&|i| moved[(i, j)]);
            missed(error, &mut |i, part| moved[(i, j)] += part);
        }
        let error = readings[1] - sampled[0] - yielded(&|i| known[i]);
        missed(error, &mut |i, part| known[i] += part);
        // ... and Kalman's correction by the deflection.
        let shown =
            |column: &dyn Fn(usize) -> C| (0..INNER).fold(none, |sum, i| sum + column(i) * plant.seen[i]);
        let mut by_state = SVector::<C, ALL>::from_fn(|j, _| -shown(&|i| moved[(i, j)]));
        by_state[INNER] += before * plant.seen[POSITION];
        let by_reading = [
            readings[0],
            -shown(&|i| known[i]) - sampled[0] * plant.seen[POSITION],
        ];
        let corrects = SVector::<f64, ALL>::from_fn(|i, _| match i {
            INNER => self.corrects[MODAL],
            ..MODAL => self.corrects[i] - plant.rest[i] * self.corrects[MODAL],
            _ => 0.0,
        });
        let matrix = SMatrix::<C, ALL, ALL>::from_fn(|i, j| {
            let one = C::from(if i == j { 1.0 } else { 0.0 });
            let held = match i {
                INNER if j == INNER => before,
                INNER => none,
                _ => moved[(i, j)],
            };
            one - held - by_state[j] * corrects[i]
        });
        let right = SMatrix::<C, ALL, 2>::from_fn(|i, way| {
            let read = if way == 1 && i < INNER { known[i] } else { none };
            read + by_reading[way] * corrects[i]
        });
        let found = matrix.lu().solve(&right)?;
        let states = [0, 1].map(|way| Inner::from_fn(|i, _| found[(i, way)]));
        Some((states, [found[(INNER, 0)], found[(INNER, 1)]]))
    }
}
