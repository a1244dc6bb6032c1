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
use nalgebra::{Complex, Hessenberg, RowSVector, SMatrix, SVector, Vector3};
use node::scenario::Controller;
use spatial::TICK_S;
use std::f64::consts::TAU;

type C = Complex<f64>;
/// The states without the command filters, which the law knows, and these.
const INNER: usize = POSITION;
const KNOWN: usize = STATES - INNER;
/// Those that the observer estimates: the inner ones, and the object.
const ALL: usize = INNER + 1;
type Square = SMatrix<f64, ALL, ALL>;
type Column = SVector<f64, ALL>;

/// When the Kalman filter's gain is taken, in ticks after the contact: the length of a judged run.
const SETTLED_TICKS: usize = 1500;

/// The law about its rest in contact.
#[derive(Clone, Debug)]
pub struct ElasticModel {
    observer: Observing,
    /// What the change of the acceleration is made of: of what is observed, ...
    by_state: Column,
    /// ... and of the command filters, from the newest sample's truth to the instant at which the next set-point begins to
    /// act, tick by tick.
    by_filters: Vec<Vector3<f64>>,
    period_s: f64,
    filter_rad_per_s: f64,
    filter_damping: f64,
}

/// `Observer::take`, once its gain has settled, as `X+ = N X + ...`, in coordinates in which N is an upper Hessenberg
/// matrix.
#[derive(Clone, Debug)]
struct Observing {
    transition: Square,
    /// By the deflection that is read.
    by_deflection: Column,
    /// By how far the motors are read to be from the command filters.
    by_motors: Column,
    /// By the command filters a tick before.
    by_filters_before: SMatrix<f64, ALL, KNOWN>,
    /// By their position now.
    by_position: Column,
}

impl Observing {
    /// With what an error of the deflection `corrects` of modes and object; and the coordinates, as the columns of a
    /// matrix.
    ///
    /// The plant moves, `m = A x + B (f - o)`; the motors' error corrects by L, `m += L (q - y m)`; Kalman's gain K by
    /// the deflection's, `d - c m - c_p (f - o)`.
    fn new(plant: &Plant, corrects: &SVector<f64, ESTIMATED>) -> (Self, Square) {
        let mut moved = Square::zeros();
        moved
            .fixed_view_mut::<INNER, INNER>(0, 0)
            .copy_from(&plant.tick.fixed_view::<INNER, INNER>(0, 0));
        moved
            .fixed_view_mut::<INNER, 1>(0, INNER)
            .copy_from(&-plant.tick.fixed_view::<INNER, 1>(0, POSITION));
        moved[(INNER, INNER)] = 1.0;
        let mut filters = SMatrix::<f64, ALL, KNOWN>::zeros();
        filters
            .fixed_view_mut::<INNER, KNOWN>(0, 0)
            .copy_from(&plant.tick.fixed_view::<INNER, KNOWN>(0, INNER));
        let (mut motors, mut yielded) = (Column::zeros(), RowSVector::<f64, ALL>::zeros());
        for axis in 0..6 {
            motors[DEVIATION + axis] = plant.axes_per_tcp[axis] * MOTOR_GAINS[0];
            motors[RATE + axis] = plant.axes_per_tcp[axis] * (MOTOR_GAINS[1] / TICK_S);
            yielded[DEVIATION + axis] = plant.tcp_per_axis[axis];
        }
        let kalman = Column::from_fn(|i, _| match i {
            INNER => corrects[MODAL],
            ..MODAL => corrects[i] - plant.rest[i] * corrects[MODAL],
            _ => 0.0,
        });
        let mut shown = RowSVector::<f64, ALL>::zeros();
        shown
            .fixed_view_mut::<1, INNER>(0, 0)
            .copy_from(&plant.seen.fixed_view::<1, INNER>(0, 0));
        shown[INNER] = -plant.seen[POSITION];
        let corrected = Square::identity() - kalman * shown;
        let after_motors = corrected * (Square::identity() - motors * yielded);
        let (coordinates, transition) = Hessenberg::new(after_motors * moved).unpack();
        let observing = Self {
            transition,
            by_deflection: coordinates.tr_mul(&kalman),
            by_motors: coordinates.tr_mul(&(corrected * motors)),
            by_filters_before: coordinates.tr_mul(&(after_motors * filters)),
            by_position: coordinates.tr_mul(&kalman) * -plant.seen[POSITION],
        };
        (observing, coordinates)
    }

    /// `(1 - N before)^-1` times the columns of `right`, by Gauss's elimination.
    fn solve(&self, before: C, mut right: [SVector<C, ALL>; 2]) -> [SVector<C, ALL>; 2] {
        let mut matrix = self.transition.map(|n| -before * n);
        for i in 0..ALL {
            matrix[(i, i)] += 1.0;
        }
        for j in 0..ALL - 1 {
            if matrix[(j + 1, j)].norm_sqr() > matrix[(j, j)].norm_sqr() {
                matrix.swap_rows(j, j + 1);
                right.iter_mut().for_each(|column| column.swap_rows(j, j + 1));
            }
            let factor = matrix[(j + 1, j)] / matrix[(j, j)];
            for k in j + 1..ALL {
                let above = matrix[(j, k)];
                matrix[(j + 1, k)] -= factor * above;
            }
            for column in &mut right {
                let above = column[j];
                column[j + 1] -= factor * above;
            }
        }
        for column in &mut right {
            for i in (0..ALL).rev() {
                let known = (i + 1..ALL).fold(C::from(0.0), |sum, k| sum + matrix[(i, k)] * column[k]);
                column[i] = (column[i] - known) / matrix[(i, i)];
            }
        }
        right
    }
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
        let plant = design.nearest(ratio);
        let corrects = Observer::gain_after(plant, &controller.elastic, SETTLED_TICKS);
        let (observer, coordinates) = Observing::new(plant, &corrects);
        let late_s = sensor_delay_s + 1.0 / (TAU * controller.sensor_bandwidth_hz);
        let ahead_s = controller.command_delay_periods as f64 * period_s + late_s;
        let ahead_ticks = libm::rint(ahead_s / TICK_S) as usize;
        // The plant until the next set-point begins to act, from its end on.
        let inner = plant.tick.fixed_view::<INNER, INNER>(0, 0);
        let known = plant.tick.fixed_view::<INNER, KNOWN>(0, INNER);
        let mut state: RowSVector<f64, INNER> = plant.gain.fixed_view::<1, INNER>(0, 0).into_owned();
        let mut by_filters = vec![plant.gain.fixed_view::<1, KNOWN>(0, INNER).transpose()];
        for _ in 0..ahead_ticks {
            by_filters.push((state * known).transpose());
            state *= inner;
        }
        by_filters.reverse();
        let by_object: f64 = -by_filters.iter().map(|part| part[0]).sum::<f64>();
        let by_state = Column::from_fn(|i, _| if i < INNER { state[i] } else { by_object });
        Self {
            observer,
            by_state: coordinates.tr_mul(&by_state),
            by_filters,
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
        let (z, before) = (exp(s * self.period_s), exp(-s * TICK_S));
        let acts = self.filters(z);
        let ahead_ticks = (self.by_filters.len() - 1) as f64;
        let sampled = acts * exp(-s * (ahead_ticks * TICK_S));
        let w = self.filter_rad_per_s;
        // The set-point that brings the filters there, at the end of the period.
        let setpoint = z * (acts[0] + acts[1] * (2.0 * self.filter_damping / w) + acts[2] / (w * w));
        let motors = seen.paired * setpoint - sampled[0];
        let deflection = seen.deflection * setpoint;
        let observer = &self.observer;
        // By way of the sensor, and by way of encoders and own commands.
        let by_sensor = observer.by_deflection.map(|part| deflection * part);
        let by_encoder = SVector::<C, ALL>::from_fn(|i, _| {
            let now = motors * observer.by_motors[i] + sampled[0] * observer.by_position[i];
            (0..KNOWN).fold(now, |sum, k| {
                sum + before * sampled[k] * observer.by_filters_before[(i, k)]
            })
        });
        let [by_sensor, by_encoder] = observer
            .solve(before, [by_sensor, by_encoder])
            .map(|state| (0..ALL).fold(C::from(0.0), |sum, i| sum - state[i] * self.by_state[i]));
        let ways = self.by_filters.iter().fold(Vector3::<C>::zeros(), |sum, part| {
            sum * before + part.map(C::from)
        });
        Answer {
            by_sensor,
            by_encoder: by_encoder - ways.dot(&acts),
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
}
